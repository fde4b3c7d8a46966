//! Rays from one point, and where they meet boxes and triangles.

use crate::geom::Aabb;
use glam::{DAffine3, DVec3};

/// Rays from one point that go nearly the same way. A ray's parameter is the distance along the line of sight, in whatever space.
#[derive(Clone, Copy)]
pub(super) struct Bundle<const N: usize> {
    pub(super) origin: DVec3,
    pub(super) directions: [DVec3; N],
}

/// Bounds of 1 / direction on each axis; `None` where the directions do not agree on a sign.
pub(super) struct Slopes([Option<[f64; 2]>; 3]);

impl<const N: usize> Bundle<N> {
    /// The same rays in another space; their parameters stay.
    pub(super) fn moved(&self, there_from_here: &DAffine3) -> Bundle<N> {
        Bundle {
            origin: there_from_here.transform_point3(self.origin),
            directions: self
                .directions
                .map(|direction| there_from_here.transform_vector3(direction)),
        }
    }

    pub(super) fn slopes(&self) -> Slopes {
        Slopes(std::array::from_fn(|axis| {
            let low = self
                .directions
                .iter()
                .map(|d| d[axis])
                .fold(f64::INFINITY, f64::min);
            let high = self
                .directions
                .iter()
                .map(|d| d[axis])
                .fold(f64::NEG_INFINITY, f64::max);
            (low > 0.0 || high < 0.0).then(|| [1.0 / high, 1.0 / low])
        }))
    }

    /// The least parameter at which any ray may be inside a box; `None` where none can be before `limit`.
    #[inline]
    pub(super) fn enters(&self, slopes: &Slopes, bounds: &Aabb, limit: f64) -> Option<f64> {
        let [mut enter, mut leave] = [0.0_f64, limit];
        for axis in 0..3 {
            let Some([a, b]) = slopes.0[axis] else { continue };
            let [low, high] =
                [bounds.min[axis], bounds.max[axis]].map(|side| f64::from(side) - self.origin[axis]);
            let [first, last] = if a > 0.0 { [low, high] } else { [high, low] };
            enter = enter.max((first * a).min(first * b));
            leave = leave.min((last * a).max(last * b));
        }
        // Wider by more than the rounding above: a box too many costs time, one too few the truth.
        (enter * (1.0 - 1e-12) <= leave * (1.0 + 1e-12)).then_some(enter)
    }

    /// Where ray `ray` meets a triangle: its parameter, and whether it comes from behind.
    ///
    /// Möller, Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997; sides are counted in.
    #[inline]
    pub(super) fn meets(&self, ray: usize, [a, b, c]: [DVec3; 3]) -> Option<(f64, bool)> {
        let direction = self.directions[ray];
        let [ab, ac, from_a] = [b - a, c - a, self.origin - a];
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let u = from_a.dot(p) * inverse;
        if !(0.0..=1.0).contains(&u) {
            return None;
        }
        let q = from_a.cross(ab);
        let v = direction.dot(q) * inverse;
        let w = ac.dot(q) * inverse;
        (v >= 0.0 && u + v <= 1.0 && w > 0.0).then_some((w, determinant < 0.0))
    }
}
