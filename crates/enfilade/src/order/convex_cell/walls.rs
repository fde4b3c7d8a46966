//! Finds for each face of a geometry the plane with all other faces on one side, and reports a face that has none.

use super::overlap::any_overlap;
use super::support::{Corner, SupportPlanes};
use super::{ConvexCell, Outside, Plane, occluder_clusters};
use crate::geometry::{Geometry, Owner};
use crate::ids::{ItemIndex, OpeningId};
use crate::order::Order;
use crate::unsuited::{NotConvex, Unsuited};
use glam::DVec3;

/// Processes the faces of a geometry one by one and finds a plane for each.
pub(super) struct Walls<'a> {
    geometry: &'a Geometry,
    support: SupportPlanes<'a>,
    limit_bytes: u64,
    /// Planes found recently, the newest last: neighbouring faces are often coplanar.
    recent: Vec<RecentPlane>,
    pub(super) cell: ConvexCell,
    /// Whether the inner side of the last plane found was the back of its face.
    outwards: bool,
    /// Faces and corners of the current cluster.
    faces: Vec<Face>,
    corners: Vec<DVec3>,
}

/// A plane that has all occluders on one side.
#[derive(Clone, Copy)]
struct RecentPlane {
    plane: Plane,
    /// Index in [`ConvexCell::planes`], once the outer side of a face in it may be visible.
    index: Option<u32>,
}

/// A face of the current cluster, and its plane.
pub(super) struct Face {
    pub(super) corners: [usize; 2],
    pub(super) plane: Plane,
    /// Normal with twice the area as length, by the order of the corners: they run counter-clockwise seen against it.
    pub(super) area: DVec3,
    /// Extent along the sort axis, once computed.
    pub(super) span: [f64; 2],
}

/// Maximum number of recent planes searched for one that contains a face.
const MAX_RECENT: usize = 16;

impl<'a> Walls<'a> {
    pub(super) fn new(geometry: &'a Geometry, limit_bytes: u64) -> Walls<'a> {
        let support = SupportPlanes::new(geometry);
        let slack = support.slack();
        Walls {
            geometry,
            support,
            limit_bytes,
            recent: Vec::new(),
            cell: ConvexCell {
                planes: Vec::new(),
                slack,
                outside: Vec::new(),
                openings: Vec::new(),
                overlapping: Vec::new(),
                occluders: vec![false; geometry.items().len()],
            },
            outwards: false,
            faces: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Finds a plane for each opening.
    pub(super) fn take_openings(&mut self) -> Result<(), Unsuited> {
        for (number, opening) in (0_u16..).zip(self.geometry.openings()) {
            let corners = opening.outline.corners().iter();
            let corners: Vec<DVec3> = corners.map(|corner| DVec3::from(corner.map(f64::from))).collect();
            let opening = OpeningId(number);
            let Some((recent, area)) = self.plane_of(&corners, false, Owner::Opening(opening))? else {
                continue;
            };
            if area.dot(self.recent[recent].plane.normal) < 0.0 {
                self.cell.openings.push(opening);
            }
        }
        Ok(())
    }

    /// Finds a plane for each occluder face of an item.
    pub(super) fn take_item(&mut self, item: ItemIndex) -> Result<(), Unsuited> {
        for cluster in occluder_clusters(self.geometry, item) {
            self.cell.occluders[item.0 as usize] = true;
            self.take_cluster(item, cluster)?;
            if any_overlap(&mut self.faces, &self.corners, self.support.slack()) {
                self.cell.overlapping.push((item, cluster));
            }
            let twice = 2 * self.cell.bytes();
            if twice > self.limit_bytes {
                return Err(Unsuited::exceeds(self.limit_bytes));
            }
        }
        Ok(())
    }

    fn take_cluster(&mut self, item: ItemIndex, number: u32) -> Result<(), Unsuited> {
        let geometry = self.geometry;
        let mesh = geometry.mesh_of(item);
        let cluster = &mesh.clusters()[number as usize];
        let sector_from_item = geometry.item(item).transform();
        let mirrored = sector_from_item.mirrors();
        let double_sided = geometry.material(cluster).double_sided;
        self.faces.clear();
        let mut all = std::mem::take(&mut self.corners);
        all.clear();
        for face in cluster.faces.clone() {
            let start = all.len();
            let corners = mesh.face(face).iter().map(|&at| mesh.positions()[at as usize]);
            all.extend(corners.map(|corner| DVec3::from(sector_from_item.point_f64(corner))));
            let Some((recent, turned)) = self.plane_of(&all[start..], mirrored, Owner::Face(item, face))?
            else {
                all.truncate(start);
                continue;
            };
            let area = if mirrored { -turned } else { turned };
            let plane = self.recent[recent].plane;
            // A face perpendicular to its plane is thinner than the slack: which way it faces cannot be determined, so
            // both sides count as visible.
            if double_sided || area.dot(plane.normal) < 0.5 * area.length() {
                self.show_outside(recent, item, number, face);
            }
            let corners = [start, all.len()];
            self.faces.push(Face {
                corners,
                plane,
                area: turned,
                span: [0.0; 2],
            });
        }
        self.corners = all;
        Ok(())
    }

    /// Returns the index in `recent` of a plane that contains the face, and the face's normal with twice its area as
    /// length; `None` if the face is a mere line or point.
    fn plane_of(
        &mut self,
        corners: &[DVec3],
        mirrored: bool,
        owner: Owner,
    ) -> Result<Option<(usize, DVec3)>, Unsuited> {
        let Some(area) = self.support.area_of(corners) else {
            return Ok(None);
        };
        let fits = |plane: &Plane| match owner {
            Owner::Opening(_) => self.support.opening_is_in(corners, area, plane),
            Owner::Face(..) => self.support.face_is_in(corners, plane),
        };
        if let Some(recent) = self.recent.iter().rposition(|recent| fits(&recent.plane)) {
            return Ok(Some((recent, area)));
        }
        let front = if mirrored { -area } else { area };
        let plane = self
            .support
            .supporting_plane(corners, front, self.outwards, fits)
            .map_err(|behind: Corner| {
                let faces = [owner, behind.of];
                Box::new(NotConvex::new(
                    self.geometry,
                    faces,
                    behind.point.into(),
                    behind.by,
                ))
            })?;
        self.outwards = plane.normal.dot(front) < 0.0;
        if self.recent.len() == MAX_RECENT {
            self.recent.remove(0);
        }
        self.recent.push(RecentPlane { plane, index: None });
        Ok(Some((self.recent.len() - 1, area)))
    }

    fn show_outside(&mut self, recent: usize, item: ItemIndex, cluster: u32, face: u32) {
        let plane = self.plane_index(recent);
        match self.cell.outside.last_mut() {
            Some(last)
                if (last.plane, last.item, last.cluster, last.faces[1]) == (plane, item, cluster, face) =>
            {
                last.faces[1] += 1;
            }
            _ => self.cell.outside.push(Outside {
                plane,
                item,
                cluster,
                faces: [face, face + 1],
            }),
        }
    }

    /// Returns the index in [`ConvexCell::planes`] of a recent plane, and adds the plane if it is missing.
    fn plane_index(&mut self, recent: usize) -> u32 {
        let RecentPlane { plane, index } = &mut self.recent[recent];
        *index.get_or_insert_with(|| {
            self.cell.planes.push(*plane);
            self.cell.planes.len() as u32 - 1
        })
    }
}
