//! Bundles of rays with nearly the same origin and direction; intersection with AABBs and triangles.

use crate::geom::Aabb;
use glam::{DAffine3, DVec3};

/// Rays with a common origin and nearly the same direction, or, in a parallel view, with nearly the same origin and a
/// common direction. A ray's parameter is the distance along the view direction and is the same in every space.
#[derive(Clone, Copy)]
pub(super) struct Bundle<const N: usize> {
    pub(super) origin: DVec3,
    pub(super) directions: [DVec3; N],
    /// From `origin` to the origin of each ray; `None` if all are zero.
    pub(super) offsets: Option<[DVec3; N]>,
}

/// Interval of 1 / direction on each axis.
pub(super) struct Slopes([Slope; 3]);

enum Slope {
    Between([f64; 2]),
    /// All directions are 0.
    None,
    /// The directions differ in sign, or some are 0.
    Unknown,
}

impl<const N: usize> Bundle<N> {
    /// Transforms the rays to another space; their parameters stay valid.
    pub(super) fn moved(&self, there_from_here: &DAffine3) -> Bundle<N> {
        Bundle {
            origin: there_from_here.transform_point3(self.origin),
            directions: self
                .directions
                .map(|direction| there_from_here.transform_vector3(direction)),
            offsets: self
                .offsets
                .map(|all| all.map(|offset| there_from_here.transform_vector3(offset))),
        }
    }

    /// Returns the origin of ray `ray`.
    pub(super) fn origin_of(&self, ray: usize) -> DVec3 {
        self.origin + self.offsets.map_or(DVec3::ZERO, |all| all[ray])
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
            if low > 0.0 || high < 0.0 {
                Slope::Between([1.0 / high, 1.0 / low])
            } else if low == 0.0 && high == 0.0 {
                Slope::None
            } else {
                Slope::Unknown
            }
        }))
    }

    /// Returns the smallest parameter at which any ray may be inside a box; `None` if none enters it before `limit`.
    #[inline]
    pub(super) fn enters(&self, slopes: &Slopes, bounds: &Aabb, limit: f64) -> Option<f64> {
        let [mut enter, mut leave] = [0.0_f64, limit];
        let reach = self.offsets.map_or(DVec3::ZERO, |all| {
            all.iter()
                .fold(DVec3::ZERO, |reach, offset| reach.max(offset.abs()))
        });
        for axis in 0..3 {
            let [low, high] =
                [bounds.min[axis], bounds.max[axis]].map(|side| f64::from(side) - self.origin[axis]);
            let [low, high] = [low - reach[axis], high + reach[axis]];
            let [a, b] = match slopes.0[axis] {
                Slope::Between(slopes) => slopes,
                Slope::Unknown => continue,
                Slope::None => {
                    let margin = 1e-12 * (self.origin[axis].abs() + low.abs() + high.abs());
                    if low > margin || high < -margin {
                        return None;
                    }
                    continue;
                }
            };
            let [first, last] = if a > 0.0 { [low, high] } else { [high, low] };
            enter = enter.max((first * a).min(first * b));
            leave = leave.min((last * a).max(last * b));
        }
        // Widened by more than the rounding error above: an unneeded box costs time, a missed one makes the answer
        // wrong.
        (enter * (1.0 - 1e-12) <= leave * (1.0 + 1e-12)).then_some(enter)
    }

    /// Returns the parameters at which ray `ray` enters and leaves a box; `None` if it passes beside it.
    pub(super) fn passes(&self, ray: usize, bounds: &Aabb) -> Option<[f64; 2]> {
        let [mut enter, mut leave] = [f64::NEG_INFINITY, f64::INFINITY];
        for axis in 0..3 {
            let sides = [bounds.min[axis], bounds.max[axis]];
            let [low, high] = sides.map(|side| f64::from(side) - self.origin_of(ray)[axis]);
            let direction = self.directions[ray][axis];
            if direction != 0.0 {
                let [a, b] = [low / direction, high / direction];
                (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
            } else if low > 0.0 || high < 0.0 {
                return None;
            }
        }
        (enter < leave).then_some([enter, leave])
    }

    /// Intersects ray `ray` with a triangle. Returns the ray parameter and whether the ray hits the back face.
    ///
    /// Edges belong to the triangle. Source: Möller, Trumbore. Fast, Minimum Storage Ray/Triangle Intersection. 1997.
    #[inline]
    pub(super) fn meets(&self, ray: usize, [a, b, c]: [DVec3; 3]) -> Option<(f64, bool)> {
        let direction = self.directions[ray];
        let [ab, ac, from_a] = [b - a, c - a, self.origin_of(ray) - a];
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
