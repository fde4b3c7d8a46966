//! A face of the span buffer, and the tests that order two faces by depth.

use crate::raster::Triangle;
use glam::DVec3;

/// A triangle in the space of (X, Y, W), with the eye at the origin.
///
/// Fields that are read first come first, in one cache line: bounding boxes and depth ranges decide most comparisons.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Face {
    /// AABB of the corners, rounded outwards.
    low: [f32; 3],
    high: [f32; 3],
    /// Batch of the face, and its number there; 255 if it has none.
    pub(super) batch: u32,
    pub(super) number: u8,
    /// Numbers of the faces of the batch across its edges.
    pub(super) neighbours: [u8; 3],
    pub(super) triangle: Triangle,
    corners: [DVec3; 3],
    normal: DVec3,
    /// Its sign tells on which side of the plane the eye is.
    determinant: f64,
}

/// Position of a face relative to another, as seen from the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlaneSide {
    /// Nowhere behind the other. `apart`: does not touch it either.
    Before { apart: bool },
    /// Nowhere in front of the other. `apart`: does not touch it either.
    Behind { apart: bool },
    /// In the plane of the other.
    Level,
    /// Possibly in front of it at some points and behind it at others.
    Unsure,
}

impl PlaneSide {
    /// Returns the position of the other face relative to this one.
    fn flipped(self) -> PlaneSide {
        match self {
            PlaneSide::Before { apart } => PlaneSide::Behind { apart },
            PlaneSide::Behind { apart } => PlaneSide::Before { apart },
            same => same,
        }
    }
}

/// Generous bound on the rounding error of corners, which come from products of f64, relative to the sum of the terms.
const ROUNDING: f64 = 1.0 / (1_u64 << 46) as f64;
/// Multiple of the rounding error; a face farther from a plane than that does not touch it.
const APART: f64 = 1024.0;

impl Face {
    pub(super) fn new(triangle: Triangle, corners: [DVec3; 3], batch: u32) -> Face {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
        Face {
            triangle,
            corners,
            normal,
            determinant: normal.dot(a),
            low: low.to_array().map(|value| (value as f32).next_down()),
            high: high.to_array().map(|value| (value as f32).next_up()),
            batch,
            number: u8::MAX,
            neighbours: [u8::MAX; 3],
        }
    }

    /// Returns `true` if the AABBs are disjoint. Then the faces do not intersect, and one of them is in front wherever
    /// they overlap on the screen.
    #[inline]
    pub(super) fn is_apart_from(&self, other: &Face) -> bool {
        (0..3).any(|axis| self.low[axis] > other.high[axis] || other.low[axis] > self.high[axis])
    }

    /// Returns `true` if both faces share an edge or belong to one polygon.
    #[inline]
    pub(super) fn adjoins(&self, other: &Face) -> bool {
        self.batch == other.batch
            && (self.triangle.owner == other.triangle.owner
                || (other.number != u8::MAX && self.neighbours.contains(&other.number)))
    }

    /// Returns the position relative to another face, by testing the corners of each against the plane of the other.
    ///
    /// Tests the plane of the face with the higher owner first, whichever was inserted first: of two nearly coplanar
    /// faces, one may be in the other's plane within rounding, but not the other way round.
    pub(super) fn side_of(&self, other: &Face) -> PlaneSide {
        if self.triangle.owner <= other.triangle.owner {
            self.side_of_higher(other)
        } else {
            other.side_of_higher(self).flipped()
        }
    }

    fn side_of_higher(&self, higher: &Face) -> PlaneSide {
        match self.side_of_plane(higher) {
            PlaneSide::Unsure => higher.side_of_plane(self).flipped(),
            sure => sure,
        }
    }

    /// Tests the corners against the other face's plane.
    #[inline]
    fn side_of_plane(&self, other: &Face) -> PlaneSide {
        let origin = other.corners[0];
        let size = origin.abs();
        let toward_eye = if other.determinant < 0.0 { 1.0 } else { -1.0 };
        let [mut before, mut behind, mut apart] = [true; 3];
        for corner in self.corners {
            let side = toward_eye * other.normal.dot(corner - origin);
            let rounding = ROUNDING * other.normal.abs().dot(corner.abs() + size);
            before &= side >= -rounding;
            behind &= side <= rounding;
            apart &= side.abs() > APART * rounding;
        }
        match (before, behind) {
            (true, false) => PlaneSide::Before { apart },
            (false, true) => PlaneSide::Behind { apart },
            (true, true) => PlaneSide::Level,
            (false, false) => PlaneSide::Unsure,
        }
    }

    /// Returns `true` if the midpoint of edge `edge` of another face is, on the screen, inside this face and not on its
    /// outline.
    pub(super) fn contains_edge_midpoint(&self, other: &Face, edge: usize) -> bool {
        let middle = other.corners[edge] + other.corners[(edge + 1) % 3];
        if middle.z <= 0.0 {
            return false;
        }
        let [a, b, c] = self.corners;
        // If all signs are opposite to the determinant's, the ray meets the face behind the eye.
        let sign = self.determinant.signum();
        [(a, b), (b, c), (c, a)].iter().all(|(from, to)| {
            let plane = from.cross(*to);
            let rounding = ROUNDING * plane.abs().dot(middle.abs());
            sign * plane.dot(middle) > rounding
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(owner: u32, corners: [[f64; 3]; 3]) -> Face {
        let triangle = Triangle {
            owner,
            rev_depth: DVec3::ZERO,
            least: 0.0,
            greatest: 0.0,
        };
        Face::new(triangle, corners.map(DVec3::from), 0)
    }

    #[test]
    fn who_came_first_does_not_decide_what_is_before() {
        // The small face is in the plane of the large one within rounding, but not the other way round.
        let large = [[-1000.0, 0.0, 1.0], [1000.0, 0.0, 1.0], [0.0, 1000.0, 1.0]];
        let small = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0 + 1e-14]];
        let [a, b] = [face(0, large), face(1, small)];
        assert_ne!(a.side_of_plane(&b), b.side_of_plane(&a).flipped());
        for [lower, higher] in [[large, small], [small, large]] {
            let [lower, higher] = [face(0, lower), face(1, higher)];
            assert_eq!(lower.side_of(&higher), higher.side_of(&lower).flipped());
        }
    }
}
