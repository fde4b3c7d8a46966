//! A face as the spans know it: where it is, and on which side of it another lies.

use crate::cover::triangle::Triangle;
use glam::DVec3;

/// A triangle in the space of (X, Y, W), in which the eye is at the origin.
///
/// What is asked first stands first, in one line of a cache: most faces are told apart by their boxes and ranges.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Face {
    /// The box around the corners, rounded outwards.
    low: [f32; 3],
    high: [f32; 3],
    /// The batch it came with, and its number there; 255 where it has none.
    pub(super) batch: u32,
    pub(super) number: u8,
    /// The faces of the batch across its edges.
    pub(super) neighbours: [u8; 3],
    pub(super) triangle: Triangle,
    corners: [DVec3; 3],
    normal: DVec3,
    /// Its sign says on which side of the plane the eye is.
    determinant: f64,
}

/// Where something lies, as seen from the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlaneSide {
    /// Nowhere behind the other; `apart`: nor does it touch it.
    Before { apart: bool },
    /// Nowhere before the other.
    Behind { apart: bool },
    /// In one plane with it.
    Level,
    /// Perhaps before it here and behind it there.
    Unsure,
}

impl PlaneSide {
    /// Where the other lies.
    fn flipped(self) -> PlaneSide {
        match self {
            PlaneSide::Before { apart } => PlaneSide::Behind { apart },
            PlaneSide::Behind { apart } => PlaneSide::Before { apart },
            same => same,
        }
    }
}

/// Corners come from a product of f64: this, relative to the sums of what is added, is more than rounding can do.
const ROUNDING: f64 = 1.0 / (1_u64 << 46) as f64;
/// Farther from a plane than this many times the rounding, a face does not touch it.
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

    /// Are the boxes around both apart? Then they meet nowhere, and one of them is before the other wherever they
    /// overlap on the screen.
    #[inline]
    pub(super) fn is_apart_from(&self, other: &Face) -> bool {
        (0..3).any(|axis| self.low[axis] > other.high[axis] || other.low[axis] > self.high[axis])
    }

    /// Do both share an edge, or belong to one polygon?
    #[inline]
    pub(super) fn adjoins(&self, other: &Face) -> bool {
        self.batch == other.batch
            && (self.triangle.owner == other.triangle.owner
                || (other.number != u8::MAX && self.neighbours.contains(&other.number)))
    }

    /// Where it lies with respect to another, told from which side of each other's plane their corners are.
    ///
    /// The plane of the higher is asked first, whoever came first: of two that are nearly in one plane, one may lie in
    /// the other's plane, and the other not in its.
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

    /// Where the corners lie with respect to the other's plane.
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

    /// Does the middle of edge `edge` of another face lie on the screen within this one, and not on its outline?
    pub(super) fn contains_edge_midpoint(&self, other: &Face, edge: usize) -> bool {
        let middle = other.corners[edge] + other.corners[(edge + 1) % 3];
        if middle.z <= 0.0 {
            return false;
        }
        let [a, b, c] = self.corners;
        // Signs that are all opposite to the determinant's mean that the face is met behind the eye.
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
        // The small one lies in the plane of the large one, as far as rounding can tell, but not the other way round.
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
