//! Supporting planes: tests whether all occluder corners are on one side of a plane.
//!
//! Corners up to the slack behind a plane count as on it. A corner has f32 coordinates: each is off by up to √3 · 2⁻²⁴
//! of the maximum coordinate from its intended position, a plane through three corners by up to twice that, and the
//! rounding of item transforms moves both by as much again. That is less than 2⁻²¹ in total. BSP trees accept corners
//! as coplanar by the same reasoning. Only an eye nearer to the plane than 2¹⁶ such steps could tell them apart by
//! reversed depth (which counts as equal within 2⁻¹⁶), and then only on a border no wider than the step, or where two
//! faces overlap at that small distance.
//! A small face of a large wall is tilted by much more than that. Its plane is rotated about the face until it is
//! supported by corners far away; only if the plane then no longer contains the face is the face rejected.
//! Cost: a test whether anything is behind a plane visits, by the trees over items and clusters, the boxes and clusters
//!     that reach behind it although their corners do not: few for a wall, hundreds for a smooth, finely tessellated
//!     dome.

use super::{Plane, occluder_clusters};
use crate::geom::{Aabb, Step};
use crate::geometry::{Alpha, Geometry, Owner};
use crate::ids::{ItemIndex, OpeningId};
use glam::{DAffine3, DVec3};

/// All occluders of a geometry, openings included, and the tolerance of plane tests.
pub(super) struct SupportPlanes<'a> {
    geometry: &'a Geometry,
    /// Maximum absolute coordinate.
    greatest: f64,
    slack: f64,
    /// Centre of the AABB, and half of its diagonal.
    middle: DVec3,
    radius: f64,
}

/// A corner of an occluder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) point: DVec3,
    pub(super) of: Owner,
    /// Distance behind a plane.
    pub(super) by: f64,
}

/// Distance from a plane that counts as on it, relative to the maximum coordinate.
const SLACK: f64 = 1.0 / (1_u64 << 21) as f64;

/// Maximum thickness of a face that counts as a mere line, relative to the maximum coordinate: f64 cannot determine its
/// normal.
const THIN: f64 = 1.0 / (1_u64 << 45) as f64;

/// Maximum number of rotations of a plane. Three corners far apart define a plane that is off by no more than they are.
const MAX_ROTATIONS: usize = 8;

impl<'a> SupportPlanes<'a> {
    pub(super) fn new(geometry: &'a Geometry) -> SupportPlanes<'a> {
        let openings = geometry.openings().iter().map(|opening| opening.outline.bounds());
        let mut bounds = openings.fold(Aabb::EMPTY, |sum, hole| sum.union(&hole));
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            let placed = geometry.item(item).transform();
            for cluster in occluder_clusters(geometry, item) {
                let corners = geometry.mesh_of(item).clusters()[cluster as usize]
                    .bounds
                    .corners();
                bounds = bounds.union(&placed.box_of(&corners));
            }
        }
        let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let is_empty = bounds.is_empty();
        let greatest = if is_empty {
            0.0
        } else {
            min.abs().max(max.abs()).max_element()
        };
        SupportPlanes {
            geometry,
            greatest,
            slack: SLACK * greatest,
            middle: if is_empty { DVec3::ZERO } else { 0.5 * (min + max) },
            radius: if is_empty { 0.0 } else { 0.5 * (max - min).length() },
        }
    }

    pub(super) fn slack(&self) -> f64 {
        self.slack
    }

    /// Returns the normal of a face with twice its area as length; `None` if the face is a mere line.
    pub(super) fn area_of(&self, corners: &[DVec3]) -> Option<DVec3> {
        let first = corners[0];
        let (mut area, mut longest) = (DVec3::ZERO, 0.0_f64);
        for pair in corners[1..].windows(2) {
            area += (pair[0] - first).cross(pair[1] - first);
            longest = longest
                .max((pair[0] - first).length())
                .max((pair[1] - first).length());
        }
        (area.length() > THIN * self.greatest * longest).then_some(area)
    }

    /// Returns `true` if all corners are on the plane.
    #[inline(always)]
    pub(super) fn face_is_in(&self, corners: &[DVec3], plane: &Plane) -> bool {
        corners
            .iter()
            .all(|&corner| plane.height(corner).abs() <= self.slack)
    }

    /// Returns `true` if an opening is in the plane and parallel to it. An opening thinner than the slack may be within
    /// the slack of a perpendicular plane; then walls do not stay behind it.
    pub(super) fn opening_is_in(&self, corners: &[DVec3], area: DVec3, plane: &Plane) -> bool {
        self.face_is_in(corners, plane) && area.dot(plane.normal).abs() > 0.5 * area.length()
    }

    /// Returns the plane of a face with all occluders on its inner side, or else the corner that is farthest behind the
    /// face. `outwards` says which side to try first: `true` if the back of the face is probably the inner side. `fits`
    /// tests whether a rotated plane still contains the face.
    pub(super) fn supporting_plane(
        &self,
        corners: &[DVec3],
        area: DVec3,
        outwards: bool,
        fits: impl Fn(&Plane) -> bool,
    ) -> Result<Plane, Corner> {
        let own = plane_through(area.normalize(), corners[0]);
        let sides = [own, flipped(&own)];
        for side in [usize::from(outwards), usize::from(!outwards)] {
            if self.behind(&sides[side], CornerChoice::Any).is_none() {
                return Ok(sides[side]);
            }
        }
        self.rotate_until_supported(corners, own, fits)
    }

    fn rotate_until_supported(
        &self,
        corners: &[DVec3],
        mut plane: Plane,
        fits: impl Fn(&Plane) -> bool,
    ) -> Result<Plane, Corner> {
        let mut first = None;
        let mut supports: Vec<DVec3> = Vec::new();
        for _ in 0..MAX_ROTATIONS {
            let Some(behind) = self.behind(&plane, CornerChoice::Farthest) else {
                return Ok(plane);
            };
            let other = flipped(&plane);
            let Some(before) = self.behind(&other, CornerChoice::Farthest) else {
                return Ok(other);
            };
            let first = *first.get_or_insert(behind);
            let (nearer, inside) = if behind.by <= before.by {
                (behind, before)
            } else {
                (before, behind)
            };
            supports.push(nearer.point);
            plane = self
                .rotated_plane(corners, &supports, inside.point, &fits)
                .ok_or(first)?;
        }
        first.map_or(Ok(plane), Err)
    }

    /// Returns a plane through the last point of `supports` that `fits`, with the other points and `inside` on its inner
    /// side.
    fn rotated_plane(
        &self,
        corners: &[DVec3],
        supports: &[DVec3],
        inside: DVec3,
        fits: impl Fn(&Plane) -> bool,
    ) -> Option<Plane> {
        let (&last, before) = supports.split_last()?;
        let points = || corners.iter().chain(before).copied();
        let mut best: Option<(f64, Plane)> = None;
        for (number, a) in points().enumerate() {
            for b in points().skip(number + 1) {
                let area = (a - last).cross(b - last);
                // The larger the triangle, the smaller the error within it.
                if best.is_some_and(|(most, _)| area.length_squared() <= most) {
                    continue;
                }
                let Some(normal) = area.try_normalize() else {
                    continue;
                };
                let plane = plane_through(normal, last);
                let plane = if plane.height(inside) < 0.0 {
                    flipped(&plane)
                } else {
                    plane
                };
                let holds = |&rest: &DVec3| plane.height(rest) >= -self.slack;
                if fits(&plane) && before.iter().all(holds) {
                    best = Some((area.length_squared(), plane));
                }
            }
        }
        best.map(|(_, plane)| plane)
    }

    /// Returns a corner that is behind a plane by more than the slack, if there is any.
    fn behind(&self, plane: &Plane, choice: CornerChoice) -> Option<Corner> {
        let geometry = self.geometry;
        // Seen from far behind the plane, the corners farthest behind it are visited first.
        let eye: [f64; 3] = (self.middle - plane.normal * (4.0 * self.radius)).into();
        let mut farthest = FarthestCorner {
            by: self.slack,
            found: None,
            choice,
        };
        geometry.opening_tree().walk(eye, |step| match step {
            Step::Node(bounds) => farthest.may_be_in(bounds, plane),
            Step::Thing(opening) => {
                let of = Owner::Opening(OpeningId(opening as u16));
                for corner in geometry.openings()[opening as usize].outline.corners() {
                    let point = DVec3::from(corner.map(f64::from));
                    farthest.take(Corner {
                        point,
                        of,
                        by: -plane.height(point),
                    });
                }
                true
            }
        });
        geometry.item_tree().walk(eye, |step| match step {
            Step::Node(bounds) => farthest.may_be_in(bounds, plane),
            Step::Thing(item) => {
                let item = ItemIndex(item);
                if farthest.may_be_in(&geometry.item(item).bounds, plane) {
                    self.farthest_of(item, plane, &mut farthest);
                }
                true
            }
        });
        farthest.found
    }

    fn farthest_of(&self, item: ItemIndex, plane: &Plane, farthest: &mut FarthestCorner) {
        let mesh = self.geometry.mesh_of(item);
        let sector_from_item: DAffine3 = self.geometry.item(item).transform().0;
        // The same plane in item space; its normal has the length by which lengths grow.
        let plane = Plane {
            normal: sector_from_item.matrix3.transpose() * plane.normal,
            offset: -plane.height(sector_from_item.translation),
        };
        let far = 4.0 * f64::from(mesh.bounds().longest_side());
        let middle = DVec3::from(mesh.bounds().center().map(f64::from));
        let eye = middle - plane.normal.normalize_or_zero() * far;
        mesh.walk(eye.into(), |step| match step {
            Step::Node(bounds) => farthest.may_be_in(bounds, &plane),
            Step::Thing(number) => {
                let cluster = &mesh.clusters()[number as usize];
                let hides = self.geometry.material_of(item, cluster).alpha == Alpha::Opaque;
                let used = cluster.positions.start as usize..cluster.positions.end as usize;
                let is_behind = |at: &[f32; 3]| -plane.height(DVec3::from(at.map(f64::from))) > farthest.by;
                if hides
                    && farthest.may_be_in(&cluster.bounds, &plane)
                    && mesh.positions()[used].iter().any(is_behind)
                {
                    for face in cluster.faces.clone() {
                        self.farthest_of_face(item, face, &sector_from_item, &plane, farthest);
                    }
                }
                true
            }
        });
    }

    /// Tests the corners of one face; `plane` is in item space.
    fn farthest_of_face(
        &self,
        item: ItemIndex,
        face: u32,
        sector_from_item: &DAffine3,
        plane: &Plane,
        farthest: &mut FarthestCorner,
    ) {
        let mesh = self.geometry.mesh_of(item);
        let local = |&at: &u32| DVec3::from(mesh.positions()[at as usize].map(f64::from));
        for corner in mesh.face(face) {
            let by = -plane.height(local(corner));
            if by <= farthest.by {
                continue;
            }
            let placed = |at| sector_from_item.transform_point3(local(at));
            let corners: Vec<DVec3> = mesh.face(face).iter().map(placed).collect();
            // A face without area neither occludes nor is occluded.
            if self.area_of(&corners).is_some() {
                farthest.take(Corner {
                    point: placed(corner),
                    of: Owner::Face(item, face),
                    by,
                });
            }
        }
    }
}

/// The corner found so far that is farthest behind a plane.
struct FarthestCorner {
    /// Distance behind the plane that a corner must exceed.
    by: f64,
    found: Option<Corner>,
    choice: CornerChoice,
}

/// Which of the corners behind a plane to find.
#[derive(Clone, Copy, PartialEq)]
enum CornerChoice {
    Any,
    Farthest,
}

impl FarthestCorner {
    /// Returns `true` if a box may contain a corner farther behind the plane.
    fn may_be_in(&self, bounds: &Aabb, plane: &Plane) -> bool {
        let lowest: [f64; 3] = std::array::from_fn(|axis| {
            let from = if plane.normal[axis] < 0.0 {
                bounds.max
            } else {
                bounds.min
            };
            f64::from(from[axis])
        });
        !bounds.is_empty() && -plane.height(DVec3::from(lowest)) > self.by
    }

    fn take(&mut self, corner: Corner) {
        if corner.by > self.by {
            self.by = match self.choice {
                CornerChoice::Any => f64::INFINITY,
                CornerChoice::Farthest => corner.by,
            };
            self.found = Some(corner);
        }
    }
}

/// Returns the plane through `point` with the unit normal `normal`.
fn plane_through(normal: DVec3, point: DVec3) -> Plane {
    Plane {
        normal,
        offset: normal.dot(point),
    }
}

/// Returns the same plane with its sides exchanged.
fn flipped(plane: &Plane) -> Plane {
    Plane {
        normal: -plane.normal,
        offset: -plane.offset,
    }
}
