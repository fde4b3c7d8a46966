//! Which planes the faces of a geometry lie in, so that everything else is on one side of each; and which face has none.

use super::laid::lie_on_one_another;
use super::resting::{Corner, Resting};
use super::{ConvexCell, Outside, Plane, clusters_that_hide};
use crate::geometry::{Geometry, ItemId, OpeningId, Owner};
use crate::order::{Dent, Order, Refusal};
use glam::DVec3;

/// Takes the faces of a geometry one after the other, and finds a plane for each.
pub(super) struct Walls<'a> {
    geometry: &'a Geometry,
    resting: Resting<'a>,
    limit_bytes: u64,
    /// The planes found last, the newest last: neighbours often lie in one.
    known: Vec<Known>,
    pub(super) cell: ConvexCell,
    /// Was the inner side of the plane found last the back of its face?
    outwards: bool,
    /// Of the cluster at hand.
    faces: Vec<Face>,
    corners: Vec<DVec3>,
}

/// A plane that everything is on one side of.
#[derive(Clone, Copy)]
struct Known {
    plane: Plane,
    /// Its place in [`ConvexCell::planes`], once a face in it shows its outer side.
    place: Option<u32>,
}

/// A face of the cluster at hand, and the plane that it lies in.
pub(super) struct Face {
    pub(super) corners: [usize; 2],
    pub(super) plane: Plane,
    /// Across it, as long as twice its area: against it, the corners turn left.
    pub(super) area: DVec3,
    /// From where to where it reaches along an axis, once that is asked for.
    pub(super) span: [f64; 2],
}

/// So many planes are looked through for one that a face lies in.
const MAX_KNOWN: usize = 16;

impl<'a> Walls<'a> {
    pub(super) fn new(geometry: &'a Geometry, limit_bytes: u64) -> Walls<'a> {
        Walls {
            geometry,
            resting: Resting::new(geometry),
            limit_bytes,
            known: Vec::new(),
            cell: ConvexCell {
                planes: Vec::new(),
                outside: Vec::new(),
                openings: Vec::new(),
                laid: Vec::new(),
                hiding: vec![false; geometry.items().len()],
            },
            outwards: false,
            faces: Vec::new(),
            corners: Vec::new(),
        }
    }

    /// Finds a plane for each opening.
    pub(super) fn take_openings(&mut self) -> Result<(), Refusal> {
        for (number, opening) in (0_u16..).zip(self.geometry.openings()) {
            let corners = opening.outline.corners().iter();
            let corners: Vec<DVec3> = corners.map(|corner| DVec3::from(corner.map(f64::from))).collect();
            let opening = OpeningId(number);
            let Some((known, area)) = self.plane_of(&corners, false, Owner::Opening(opening))? else {
                continue;
            };
            if area.dot(self.known[known].plane.normal) < 0.0 {
                let place = self.place_of(known);
                self.cell.openings.push((opening, place));
            }
        }
        Ok(())
    }

    /// Finds a plane for each face of an item that hides what is behind it.
    pub(super) fn take_item(&mut self, item: ItemId) -> Result<(), Refusal> {
        for cluster in clusters_that_hide(self.geometry, item) {
            self.cell.hiding[item.0 as usize] = true;
            self.take_cluster(item, cluster)?;
            if lie_on_one_another(&mut self.faces, &self.corners, self.resting.slack()) {
                self.cell.laid.push((item, cluster));
            }
            let twice = 2 * self.cell.bytes();
            if twice > self.limit_bytes {
                return Err(Refusal::TooLarge);
            }
        }
        Ok(())
    }

    fn take_cluster(&mut self, item: ItemId, number: u32) -> Result<(), Refusal> {
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
            let Some((known, turned)) = self.plane_of(&all[start..], mirrored, Owner::Face(item, face))?
            else {
                all.truncate(start);
                continue;
            };
            let area = if mirrored { -turned } else { turned };
            let plane = self.known[known].plane;
            // One that stands across its plane is thinner than the slack: which way it faces cannot be told.
            if double_sided || area.dot(plane.normal) < 0.5 * area.length() {
                self.show_outside(known, item, number, face);
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

    /// The plane that a face lies in, by its place among those that are known, and across it, as long
    /// as twice its area, where its corners turn left; `None` where it is but a line, or a point.
    fn plane_of(
        &mut self,
        corners: &[DVec3],
        mirrored: bool,
        owner: Owner,
    ) -> Result<Option<(usize, DVec3)>, Refusal> {
        let Some(area) = self.resting.area_of(corners) else {
            return Ok(None);
        };
        let fits = |plane: &Plane| match owner {
            Owner::Opening(_) => self.resting.opens_in(corners, area, plane),
            Owner::Face(..) => self.resting.lies_in(corners, plane),
        };
        if let Some(known) = self.known.iter().rposition(|known| fits(&known.plane)) {
            return Ok(Some((known, area)));
        }
        let front = if mirrored { -area } else { area };
        let plane = self
            .resting
            .under(corners, front, self.outwards, fits)
            .map_err(|behind: Corner| {
                Refusal::NotConvex(Dent {
                    wall: owner,
                    behind: behind.of,
                    point: behind.point.into(),
                    by: behind.by,
                })
            })?;
        self.outwards = plane.normal.dot(front) < 0.0;
        if self.known.len() == MAX_KNOWN {
            self.known.remove(0);
        }
        self.known.push(Known { plane, place: None });
        Ok(Some((self.known.len() - 1, area)))
    }

    fn show_outside(&mut self, known: usize, item: ItemId, cluster: u32, face: u32) {
        let plane = self.place_of(known);
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

    /// The place of a plane in which faces show their outer sides.
    fn place_of(&mut self, known: usize) -> u32 {
        let Known { plane, place } = &mut self.known[known];
        *place.get_or_insert_with(|| {
            self.cell.planes.push(*plane);
            self.cell.planes.len() as u32 - 1
        })
    }
}
