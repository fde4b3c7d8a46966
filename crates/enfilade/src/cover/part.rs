//! Where on the screen the part of a polygon can be that a near distance and cutting planes leave.

use crate::aperture::Rect;
use crate::faces::Cut;
use glam::DVec3;

/// Corners of the part at hand, and room for those of the next.
#[derive(Default)]
pub(super) struct Part {
    corners: Vec<DVec3>,
    next: Vec<DVec3>,
}

impl Part {
    /// A rectangle within `limits` around what is left of a polygon at W ≥ `near` and inside of all cuts.
    #[cold]
    pub(super) fn rect(&mut self, polygon: &[DVec3], near: f64, cuts: &[Cut], limits: &Rect) -> Rect {
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
        // Cuts are rounded, more so where corners are far behind the eye: a pixel more does no harm.
        let [low, high] = [min.map(|value| value - 1.0), max.map(|value| value + 1.0)];
        Rect::around(low, high, limits)
    }

    /// What is left of a polygon at n · p ≥ d for all planes.
    pub(super) fn clipped(
        &mut self,
        polygon: &[DVec3],
        planes: impl Iterator<Item = (DVec3, f64)>,
    ) -> &[DVec3] {
        self.corners.clear();
        self.corners.extend_from_slice(polygon);
        for (normal, distance) in planes {
            // Most planes cut nothing off.
            if !self.corners.iter().all(|corner| normal.dot(*corner) >= distance) {
                self.cut(normal, distance);
            }
        }
        &self.corners
    }

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
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
