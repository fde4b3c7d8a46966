//! Clips polygons by the near plane and by cutting planes, and bounds the remainder on the screen.

use crate::faces::Cut;
use crate::view::aperture::Rect;
use glam::DVec3;

/// Corners of the clipped polygon, and a buffer for the next clip.
#[derive(Default)]
pub(crate) struct Clipper {
    corners: Vec<DVec3>,
    next: Vec<DVec3>,
}

impl Clipper {
    /// Returns a rectangle within `limits` that contains the part of a polygon with W ≥ `near` and inside all cuts.
    #[cold]
    pub(crate) fn rect(&mut self, polygon: &[DVec3], near: f64, cuts: &[Cut], limits: &Rect) -> Rect {
        self.corners.clear();
        self.corners.extend_from_slice(polygon);
        if near > 0.0 {
            self.cut(DVec3::Z, near);
        } else if polygon.iter().any(|corner| corner.z <= 0.0) {
            return *limits;
        }
        for cut in cuts {
            self.cut(cut.normal, cut.distance);
        }
        let [mut min, mut max] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for corner in &self.corners {
            for (axis, value) in [corner.x / corner.z, corner.y / corner.z].into_iter().enumerate() {
                min[axis] = smaller(value, min[axis]);
                max[axis] = greater(value, max[axis]);
            }
        }
        // Clipped corners are rounded, more so if the original ones are far behind the eye. One pixel of margin on each
        // side is safe.
        let [low, high] = [min.map(|value| value - 1.0), max.map(|value| value + 1.0)];
        Rect::around(low, high, limits)
    }

    /// Returns the part of a polygon with n · p ≥ d for all planes.
    pub(crate) fn clipped(
        &mut self,
        polygon: &[DVec3],
        planes: impl Iterator<Item = (DVec3, f64)>,
    ) -> &[DVec3] {
        self.corners.clear();
        self.corners.extend_from_slice(polygon);
        for (normal, distance) in planes {
            // Most planes clip nothing.
            if !self.corners.iter().all(|corner| normal.dot(*corner) >= distance) {
                self.cut(normal, distance);
            }
        }
        &self.corners
    }

    /// Clips the current polygon to `normal` · p ≥ `distance`.
    fn cut(&mut self, normal: DVec3, distance: f64) {
        self.next.clear();
        for (i, &here) in self.corners.iter().enumerate() {
            let there = self.corners[(i + 1) % self.corners.len()];
            let [at_here, at_there] = [normal.dot(here) - distance, normal.dot(there) - distance];
            if at_here >= 0.0 {
                self.next.push(here);
            }
            if (at_here < 0.0) != (at_there < 0.0) {
                self.next
                    .push(here + (there - here) * (at_here / (at_here - at_there)));
            }
        }
        std::mem::swap(&mut self.corners, &mut self.next);
    }
}

#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(crate) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
