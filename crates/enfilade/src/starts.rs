//! The sectors that the rays of a parallel view start in.
//!
//! All rays start in the near plane: in the sector of the eye where they are inside its box, elsewhere in the one that
//! [`Scene::locate`] finds, and in that of the eye if there is none. On the screen, the box of a sector bounds a convex
//! polygon.
//! Cost: O(sectors + rows · sectors that the near rectangle touches); nothing if it does not leave the eye's sector.
//! Allocates, unlike other looks.

use crate::geom::Aabb;
use crate::ids::SectorId;
use crate::scene::Scene;
use crate::view::View;
use crate::view::aperture::{Aperture, Rows};
use glam::{DAffine3, DVec3};
use smallvec::SmallVec;

/// A convex polygon on the screen, in pixels.
type Polygon = SmallVec<[[f64; 2]; 16]>;

/// The sectors that a near rectangle touches, the eye's first, then in the order in which they claim rays.
pub(crate) struct Starts {
    size: [u32; 2],
    /// From (column, row, 0) to the near plane.
    sector_from_screen: DAffine3,
    sectors: Vec<SectorId>,
    boxes: Vec<[DVec3; 2]>,
}

impl Starts {
    /// Returns `None` if all rays start in the sector of the eye.
    pub(crate) fn of(scene: &Scene, view: &View, of_eye: SectorId) -> Option<Starts> {
        let screen_from_sector = view.screen_from_eye() * view.eye_from_sector().0;
        let mut starts = Starts {
            size: view.size(),
            sector_from_screen: screen_from_sector.inverse(),
            sectors: vec![of_eye],
            boxes: vec![box_of(scene, of_eye)],
        };
        let corners = starts.whole().map(|[x, y]| starts.point(x, y));
        let [min, max] = starts.boxes[0];
        if corners
            .iter()
            .all(|at| at.cmpge(min).all() && at.cmple(max).all())
        {
            return None;
        }
        let ahead = DVec3::from(view.toward()) - DVec3::from(view.eye());
        let low = corners.into_iter().fold(DVec3::INFINITY, DVec3::min);
        let high = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
        let mut others: Vec<_> = scene
            .sectors()
            .filter(|&id| id != of_eye)
            .map(|id| (id, box_of(scene, id)))
            .filter(|(_, [min, max])| min.cmple(high).all() && max.cmpge(low).all())
            .map(|(id, bounds)| {
                let [min, max] = bounds;
                // A rectangle in the plane of a side of the box is not inside it.
                let touches = (low.cmpeq(high) & (low.cmple(min) | high.cmpge(max))).any();
                let size = max - min;
                let order = if touches {
                    let middle = 0.5 * (min + max);
                    let eye = DVec3::from(view.eye());
                    [
                        -DVec3::select(middle.is_finite_mask(), middle - eye, DVec3::ZERO).dot(ahead),
                        0.0,
                    ]
                } else {
                    [size.element_product(), size.x * size.z]
                };
                (touches, order, id, bounds)
            })
            .collect();
        others.sort_by(|a, b| {
            let sizes = a.1[0].total_cmp(&b.1[0]).then(a.1[1].total_cmp(&b.1[1]));
            let ids = if a.0 { b.2.cmp(&a.2) } else { a.2.cmp(&b.2) };
            a.0.cmp(&b.0).then(sizes).then(ids)
        });
        for (_, _, id, bounds) in others {
            if starts.outline(&bounds).len() >= 3 {
                starts.sectors.push(id);
                starts.boxes.push(bounds);
            }
        }
        Some(starts)
    }

    pub(crate) fn sectors(&self) -> &[SectorId] {
        &self.sectors
    }

    /// Returns the part of the screen whose rays start in a sector, by its place in [`Starts::sectors`]; exactly, if `by_samples`,
    /// otherwise conservatively for positions up to `spread` pixels from the samples. `None` if there is none.
    pub(crate) fn aperture(&self, number: usize, by_samples: bool, spread: f64) -> Option<Aperture> {
        if !by_samples {
            let outline = match number {
                // Also what is in no box.
                0 => Polygon::from_slice(&self.whole()),
                _ => self.outline(&self.boxes[number]),
            };
            return Aperture::part(self.size, &outline, None, spread);
        }
        let mut rows = Rows::default();
        let mut claimed: Vec<[u16; 2]> = Vec::new();
        for y in 0..self.size[1] as u16 {
            claimed.clear();
            // Rays in no box start in the sector of the eye: that has what no other claims.
            let before = if number == 0 {
                1..self.sectors.len()
            } else {
                0..number
            };
            let own = match number {
                0 => [0, self.size[0] as u16],
                _ => self.columns(number, y),
            };
            let first = self.columns(0, y);
            for other in before {
                let mut taken = self.columns(other, y);
                if number == 0 {
                    // Only outside the box of the eye's sector.
                    let right = [taken[0].max(first[1]), taken[1]];
                    if first[0] < first[1] {
                        taken[1] = taken[1].min(first[0]);
                        claimed.push(right);
                    }
                }
                claimed.push(taken);
            }
            claimed.retain(|run| run[0] < run[1]);
            claimed.sort_unstable();
            let mut x = own[0];
            for &[start, end] in &claimed {
                if start.min(own[1]) > x {
                    rows.push(y, x, start.min(own[1]));
                }
                x = x.max(end);
            }
            if x < own[1] {
                rows.push(y, x, own[1]);
            }
        }
        Aperture::part(self.size, &self.whole(), Some(rows), spread)
    }

    /// Returns the corners of the screen, counter-clockwise.
    fn whole(&self) -> [[f64; 2]; 4] {
        let [width, height] = self.size.map(f64::from);
        [[0.0, 0.0], [0.0, height], [width, height], [width, 0.0]]
    }

    /// Returns the point of the near plane at a position on the screen.
    fn point(&self, x: f64, y: f64) -> DVec3 {
        self.sector_from_screen.transform_point3(DVec3::new(x, y, 0.0))
    }

    /// Returns the part of the screen whose rays start inside a box.
    fn outline(&self, &[min, max]: &[DVec3; 2]) -> Polygon {
        let mut outline = Polygon::from_slice(&self.whole());
        for axis in 0..3 {
            for (limit, sign) in [(min[axis], 1.0), (max[axis], -1.0)] {
                let inside = |[x, y]: [f64; 2]| sign * (self.point(x, y)[axis] - limit);
                let whole = std::mem::take(&mut outline);
                for (i, &here) in whole.iter().enumerate() {
                    let there = whole[(i + 1) % whole.len()];
                    let [at_here, at_there] = [inside(here), inside(there)];
                    if at_here >= 0.0 {
                        outline.push(here);
                    }
                    if (at_here < 0.0) != (at_there < 0.0) {
                        let part = at_here / (at_here - at_there);
                        outline.push([0, 1].map(|axis| here[axis] + (there[axis] - here[axis]) * part));
                    }
                }
            }
        }
        outline
    }

    /// Returns the columns of a row whose rays start inside a box, as the first and the last + 1.
    fn columns(&self, number: usize, y: u16) -> [u16; 2] {
        let [min, max] = self.boxes[number];
        if min.cmpgt(max).any() {
            return [0; 2];
        }
        let origin = self.point(0.0, f64::from(y) + 0.5);
        let step = self.sector_from_screen.matrix3.x_axis;
        let [mut low, mut high] = [0.0, f64::from(self.size[0])];
        for axis in 0..3 {
            let ends = [min[axis], max[axis]].map(|limit| (limit - origin[axis]) / step[axis]);
            if step[axis] == 0.0 {
                if origin[axis] < min[axis] || origin[axis] > max[axis] {
                    return [0; 2];
                }
                continue;
            }
            low = f64::max(low, ends[0].min(ends[1]));
            high = f64::min(high, ends[0].max(ends[1]));
        }
        if low > high {
            return [0; 2];
        }
        [low, high].map(|at| (at - 0.5).ceil().max(0.0) as u16)
    }
}

/// Returns the box of a sector, without a top if it is open above.
fn box_of(scene: &Scene, id: SectorId) -> [DVec3; 2] {
    let Aabb { min, max } = scene.bounds(id);
    let [min, mut max] = [min, max].map(|corner| DVec3::from(corner.map(f64::from)));
    if scene.is_open_above(id) && min.y <= max.y {
        max.y = f64::INFINITY;
    }
    [min, max]
}
