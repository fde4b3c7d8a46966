//! Planes that everything rests on: whether all corners of what hides are on one side of a plane.
//!
//! What is a slack behind a plane counts as on it. Corners are numbers of f32: each is off by up to √3 · 2⁻²⁴ of the greatest
//! coordinate from where it was meant, a plane through three of them by up to twice that, and what placing an item rounds
//! moves both as much again: together less than 2⁻²¹. Trees of planes take corners for coplanar by the same reasoning.
//! Only an eye nearer to the plane than 2¹⁶ such steps could tell them apart by reversed depth (which counts as equal within
//! 2⁻¹⁶), and then on a border no wider than the step, or where two faces lie on one another that little apart.
//! A small face of a large wall is tilted by much more than that: its plane is turned about it until it rests on
//! corners far away, and only where that takes it off the face, too, it is found to be no wall.
//! Cost: to ask whether anything is behind a plane, the boxes and clusters that reach behind it though their corners do not,
//!     by the trees over items and clusters: few under a wall, hundreds under a smooth and finely cut dome.

use super::{Plane, clusters_that_hide};
use crate::geom::{Aabb, Step};
use crate::geometry::{Alpha, Geometry, ItemId, OpeningId, Owner};
use glam::{DAffine3, DVec3};

/// All that hides, openings included, and how far off it may be.
pub(super) struct Resting<'a> {
    geometry: &'a Geometry,
    /// No coordinate is greater.
    greatest: f64,
    slack: f64,
    /// Its middle, and half the diagonal of its box.
    middle: DVec3,
    radius: f64,
}

/// A corner of what hides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) point: DVec3,
    pub(super) of: Owner,
    /// How far behind a plane it is.
    pub(super) by: f64,
}

/// How far off a plane counts as on it, as a part of the greatest coordinate.
const SLACK: f64 = 1.0 / (1_u64 << 21) as f64;

/// A face is but a line if it is no thicker than this part of the greatest coordinate: f64 cannot tell which way it faces.
const THIN: f64 = 1.0 / (1_u64 << 45) as f64;

/// How often a plane is turned. Three corners far apart make one that is off by no more than they are.
const TURNS: usize = 8;

impl<'a> Resting<'a> {
    pub(super) fn new(geometry: &'a Geometry) -> Resting<'a> {
        let openings = geometry.openings().iter().map(|opening| opening.outline.bounds());
        let mut bounds = openings.fold(Aabb::EMPTY, |sum, hole| sum.union(&hole));
        for item in (0..geometry.items().len() as u32).map(ItemId) {
            let placed = geometry.item(item).transform();
            for cluster in clusters_that_hide(geometry, item) {
                let corners = geometry.mesh_of(item).clusters()[cluster as usize]
                    .bounds
                    .corners();
                bounds = corners
                    .into_iter()
                    .fold(bounds, |sum, corner| sum.union(&placed.point_box(corner)));
            }
        }
        let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let is_empty = bounds.is_empty();
        let greatest = if is_empty {
            0.0
        } else {
            min.abs().max(max.abs()).max_element()
        };
        Resting {
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

    /// Across a face, as long as twice its area; `None` where it is but a line.
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

    /// Are all corners in a plane?
    #[inline(always)]
    pub(super) fn lies_in(&self, corners: &[DVec3], plane: &Plane) -> bool {
        corners
            .iter()
            .all(|&corner| plane.height(corner).abs() <= self.slack)
    }

    /// Is an opening in a plane, and along it? One thinner than the slack may be in a plane that it is perpendicular to:
    /// then walls do not stay behind it.
    pub(super) fn opens_in(&self, corners: &[DVec3], area: DVec3, plane: &Plane) -> bool {
        self.lies_in(corners, plane) && area.dot(plane.normal).abs() > 0.5 * area.length()
    }

    /// The plane that a face lies in with everything on its inner side; else what is farthest behind the face. `outwards`:
    /// is its back the inner side, most likely? `fits` says whether a plane that was turned still holds the face.
    pub(super) fn under(
        &self,
        corners: &[DVec3],
        area: DVec3,
        outwards: bool,
        fits: impl Fn(&Plane) -> bool,
    ) -> Result<Plane, Corner> {
        let own = through(area.normalize(), corners[0]);
        let sides = [own, back_of(&own)];
        for side in [usize::from(outwards), usize::from(!outwards)] {
            if self.behind(&sides[side], Wanted::Any).is_none() {
                return Ok(sides[side]);
            }
        }
        self.turned_until_it_rests(corners, own, fits)
    }

    fn turned_until_it_rests(
        &self,
        corners: &[DVec3],
        mut plane: Plane,
        fits: impl Fn(&Plane) -> bool,
    ) -> Result<Plane, Corner> {
        let mut first = None;
        let mut rests: Vec<DVec3> = Vec::new();
        for _ in 0..TURNS {
            let Some(behind) = self.behind(&plane, Wanted::Farthest) else {
                return Ok(plane);
            };
            let other = back_of(&plane);
            let Some(before) = self.behind(&other, Wanted::Farthest) else {
                return Ok(other);
            };
            let first = *first.get_or_insert(behind);
            let (nearer, inside) = if behind.by <= before.by {
                (behind, before)
            } else {
                (before, behind)
            };
            rests.push(nearer.point);
            plane = self.turned(corners, &rests, inside.point, &fits).ok_or(first)?;
        }
        first.map_or(Ok(plane), Err)
    }

    /// A plane through the last of `rests` that `fits`, with the others and `inside` on its inner side.
    fn turned(
        &self,
        corners: &[DVec3],
        rests: &[DVec3],
        inside: DVec3,
        fits: impl Fn(&Plane) -> bool,
    ) -> Option<Plane> {
        let (&last, before) = rests.split_last()?;
        let points = || corners.iter().chain(before).copied();
        let mut best: Option<(f64, Plane)> = None;
        for (number, a) in points().enumerate() {
            for b in points().skip(number + 1) {
                let area = (a - last).cross(b - last);
                // The larger, the less it is off in between.
                if best.is_some_and(|(most, _)| area.length_squared() <= most) {
                    continue;
                }
                let Some(normal) = area.try_normalize() else {
                    continue;
                };
                let plane = through(normal, last);
                let plane = if plane.height(inside) < 0.0 {
                    back_of(&plane)
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

    /// A corner that is behind a plane, if any is by more than the slack.
    fn behind(&self, plane: &Plane, wanted: Wanted) -> Option<Corner> {
        let geometry = self.geometry;
        // Seen from behind, what is farthest behind is met first.
        let eye: [f64; 3] = (self.middle - plane.normal * (4.0 * self.radius)).into();
        let mut farthest = Farthest {
            by: self.slack,
            found: None,
            wanted,
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
                let item = ItemId(item);
                if farthest.may_be_in(&geometry.item(item).bounds, plane) {
                    self.farthest_of(item, plane, &mut farthest);
                }
                true
            }
        });
        farthest.found
    }

    fn farthest_of(&self, item: ItemId, plane: &Plane, farthest: &mut Farthest) {
        let mesh = self.geometry.mesh_of(item);
        let sector_from_item: DAffine3 = self.geometry.item(item).transform().0;
        // The same plane in the space of the item, where its normal is as long as lengths grow.
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

    /// `plane` is given in the space of the item.
    fn farthest_of_face(
        &self,
        item: ItemId,
        face: u32,
        sector_from_item: &DAffine3,
        plane: &Plane,
        farthest: &mut Farthest,
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
            // What has no area hides nothing, and is not hidden.
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

/// What was found to be farthest behind a plane, as yet.
struct Farthest {
    /// What is no farther behind need not be looked at.
    by: f64,
    found: Option<Corner>,
    wanted: Wanted,
}

/// Which of the corners behind a plane is asked for.
#[derive(Clone, Copy, PartialEq)]
enum Wanted {
    Any,
    Farthest,
}

impl Farthest {
    /// May anything in a box be farther behind?
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
            self.by = match self.wanted {
                Wanted::Any => f64::INFINITY,
                Wanted::Farthest => corner.by,
            };
            self.found = Some(corner);
        }
    }
}

/// The plane across a normal of length 1, through a point.
fn through(normal: DVec3, point: DVec3) -> Plane {
    Plane {
        normal,
        offset: normal.dot(point),
    }
}

/// The same plane with its sides exchanged.
fn back_of(plane: &Plane) -> Plane {
    Plane {
        normal: -plane.normal,
        offset: -plane.offset,
    }
}
