//! What receives shadows: boxes around what a camera can see of each visible item.
//!
//! A box that leaves the clip region of its passage is clipped to it. What is long, such as the ground, is cut into slices by
//! distance, each with a box of its own, because the box around all that a camera sees of it would be far larger.
//! Conservative: clip regions are rounded outward by a pixel, boxes to f32.

use crate::geom::Aabb;
use crate::ids::SectorId;
use crate::scene::Scene;
use crate::view::passage::{FARTHEST_COORDINATE, Passage};
use crate::view::visible::VisibleSet;
use glam::{DVec3, DVec4};
use smallvec::SmallVec;

/// A part of what is visible: its bounds, in the space of a sector.
pub(super) struct Receiver {
    pub(super) sector: SectorId,
    pub(super) bounds: Aabb,
}

type Polygon = SmallVec<[DVec3; 16]>;

/// Ratio of the distances of a slice's far and near side.
const SLICE: f64 = 2.0;

/// Maximum number of slices of a box.
const MAX_SLICES: usize = 24;

/// Adds the receivers of a visible set between two distances along the view direction, sorted by sector.
pub(super) fn gather(scene: &Scene, set: &VisibleSet, range: [f64; 2], receivers: &mut Vec<Receiver>) {
    let mut items = set.items().iter().peekable();
    for (number, passage) in (0..).zip(set.passages()) {
        let clip = ClipRegion::of(passage, range);
        let sector = passage.sector;
        let mut add = |bounds: &Aabb| {
            clip.parts(bounds, |bounds| receivers.push(Receiver { sector, bounds }));
        };
        while let Some(seen) = items.next_if(|seen| seen.passage.0 == number) {
            let Some(geometry) = scene.geometry(sector) else {
                let own = scene.sector(sector);
                let bounds = own.item_bounds(seen.item.index);
                // Empty: unknown.
                add(&if bounds.is_empty() { own.bounds() } else { bounds });
                continue;
            };
            let item = geometry.item(seen.item.index);
            match set.clusters(seen) {
                [] => add(&item.bounds),
                clusters => {
                    let (mesh, transform) = (geometry.mesh_of(seen.item.index), item.transform());
                    for &cluster in clusters {
                        let bounds = mesh.clusters()[cluster as usize].bounds.placed(&transform.0);
                        add(&bounds.intersection(&item.bounds));
                    }
                }
            }
        }
    }
    receivers.sort_by_key(|receiver| receiver.sector);
}

/// The space that a passage shows, in its sector.
struct ClipRegion<'a> {
    passage: &'a Passage,
    /// Inside where the dot product with (x, y, z, 1) is not negative.
    planes: SmallVec<[DVec4; 8]>,
    /// Distances of the near and the far side, along the view direction.
    range: [f64; 2],
    /// The corners of the aperture's rectangle, in pixels.
    corners: [[f64; 2]; 4],
}

impl ClipRegion<'_> {
    fn of(passage: &Passage, range: [f64; 2]) -> ClipRegion<'_> {
        let rect = passage.aperture.rect();
        let [x0, y0] = [rect.x0, rect.y0].map(|at| f64::from(at) - 1.0);
        let [x1, y1] = [rect.x1, rect.y1].map(|at| f64::from(at) + 1.0);
        let near = if passage.is_parallel() {
            0.0
        } else {
            f64::from(passage.z_near)
        };
        let range = [range[0].max(near), range[1]];
        let mut planes: SmallVec<[DVec4; 8]> = [
            DVec3::new(1.0, 0.0, -x0),
            DVec3::new(-1.0, 0.0, x1),
            DVec3::new(0.0, 1.0, -y0),
            DVec3::new(0.0, -1.0, y1),
        ]
        .into_iter()
        .map(|normal| passage.screen_from_sector.half_space_here(normal, 0.0))
        .collect();
        planes.extend(passage.entry_plane().map(DVec4::from));
        planes.extend(sides(passage, range));
        ClipRegion {
            passage,
            planes,
            range,
            corners: [[x0, y0], [x0, y1], [x1, y1], [x1, y0]],
        }
    }

    /// Calls `part` with boxes that together contain what the region shows of a box.
    fn parts(&self, bounds: &Aabb, mut part: impl FnMut(Aabb)) {
        let [min, max] = [bounds.min, bounds.max].map(|corner| {
            DVec3::from(corner.map(|at| f64::from(at).clamp(-FARTHEST_COORDINATE, FARTHEST_COORDINATE)))
        });
        let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
        let mut is_inside = true;
        for plane in &self.planes {
            let at = plane.truncate().dot(middle) + plane.w;
            let reach = plane.truncate().abs().dot(half);
            if at + reach < -slack(plane, min.abs().max(max.abs())) {
                return;
            }
            is_inside &= at >= reach;
        }
        if is_inside {
            return part(*bounds);
        }
        let Some((whole, [near, far])) = self.part([min, max], self.range) else {
            return;
        };
        let near = near.max(self.range[0]).max(far * 1e-6);
        if self.passage.is_parallel() || far <= SLICE * near {
            return part(whole);
        }
        let count = ((far / near).log2().ceil() as usize).clamp(1, MAX_SLICES);
        let ratio = (far / near).powf(1.0 / count as f64);
        for number in 0..count {
            let at = |number: usize| near * ratio.powi(number as i32);
            // What is nearer than the first and farther than the last by rounding is in these too.
            let start = if number == 0 { self.range[0] } else { at(number) };
            let end = if number + 1 == count {
                self.range[1]
            } else {
                at(number + 1)
            };
            if let Some((slice, _)) = self.part([min, max], [start, end]) {
                part(slice);
            }
        }
    }

    /// Returns the bounds of what the region shows of a box between two distances, and its own range of distances; `None` if
    /// there is nothing.
    fn part(&self, [min, max]: [DVec3; 2], range: [f64; 2]) -> Option<(Aabb, [f64; 2])> {
        let mut planes = self.planes.clone();
        planes.extend(sides(self.passage, range));
        let size = min.abs().max(max.abs());
        let mut corners: SmallVec<[DVec3; 64]> = SmallVec::new();
        // A corner of the part is on a side of the box, or in the clip region's own corners.
        for axis in 0..3 {
            for at in [min, max] {
                let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                let mut side = Polygon::new();
                for [a, b] in [[min, min], [max, min], [max, max], [min, max]] {
                    let mut corner = at;
                    corner[u] = a[u];
                    corner[v] = b[v];
                    side.push(corner);
                }
                for plane in &planes {
                    clip(&mut side, plane, slack(plane, size));
                }
                corners.extend(side);
            }
        }
        let is_inside = |corner: &DVec3| {
            let above = |plane: &DVec4| {
                plane.truncate().dot(*corner) + plane.w >= -slack(plane, size.max(corner.abs()))
            };
            corner.is_finite()
                && corner.cmpge(min).all()
                && corner.cmple(max).all()
                && planes.iter().all(above)
        };
        corners.extend(self.own_corners(range).filter(is_inside));
        let first = *corners.first()?;
        let [low, high] = corners.iter().fold([first; 2], |[low, high], corner| {
            [low.min(*corner), high.max(*corner)]
        });
        let along = self.passage.distance();
        let distance = |corner: &DVec3| along.truncate().dot(*corner) + along.w;
        let near = corners.iter().map(distance).fold(f64::INFINITY, f64::min);
        let far = corners.iter().map(distance).fold(0.0, f64::max);
        let bounds = Aabb {
            min: low.as_vec3().to_array().map(f32::next_down),
            max: high.as_vec3().to_array().map(f32::next_up),
        };
        Some((bounds, [near, far]))
    }
}

impl ClipRegion<'_> {
    /// Iterates over the corners of the frustum between two distances, and the points where its edges cross the entry plane.
    fn own_corners(&self, range: [f64; 2]) -> impl Iterator<Item = DVec3> {
        let rays = self
            .corners
            .map(|corner| self.passage.ray(corner).map(DVec3::from));
        let sides = range.map(|distance| rays.map(|[origin, direction]| origin + direction * distance));
        let entry = self.passage.entry_plane().map(DVec4::from);
        let crossing = move |start: DVec3, toward: DVec3| {
            entry.map(|plane| {
                start - toward * ((plane.truncate().dot(start) + plane.w) / plane.truncate().dot(toward))
            })
        };
        let along = rays.map(|[origin, direction]| crossing(origin, direction));
        let across = sides.map(|side| [0, 1, 2, 3].map(|i| crossing(side[i], side[(i + 1) % 4] - side[i])));
        let crossings = along.into_iter().chain(across.into_iter().flatten());
        sides.into_iter().flatten().chain(crossings.flatten())
    }
}

/// Returns the planes at two distances along the view direction.
fn sides(passage: &Passage, [near, far]: [f64; 2]) -> impl Iterator<Item = DVec4> {
    let along = passage.distance();
    let [nearer, farther] = [along - DVec4::W * near, DVec4::W * far - along];
    [nearer, farther].into_iter().filter(|plane| plane.is_finite())
}

/// Returns the distance from a plane, in its own units, that rounding may amount to for points of a given size.
fn slack(plane: &DVec4, size: DVec3) -> f64 {
    1e-9 * (plane.truncate().abs().dot(size) + plane.w.abs())
}

/// Clips a polygon to a plane, moved outward by `slack`.
fn clip(polygon: &mut Polygon, plane: &DVec4, slack: f64) {
    let whole = std::mem::take(polygon);
    let height = |at: DVec3| plane.truncate().dot(at) + plane.w + slack;
    for (number, &here) in whole.iter().enumerate() {
        let there = whole[(number + 1) % whole.len()];
        let [at_here, at_there] = [height(here), height(there)];
        if at_here >= 0.0 {
            polygon.push(here);
        }
        if (at_here < 0.0) != (at_there < 0.0) {
            polygon.push(here + (there - here) * (at_here / (at_here - at_there)));
        }
    }
}
