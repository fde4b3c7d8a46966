//! How many steps a patch takes, for its triangles to be no farther from it than a tolerance.
//!
//! A triangle whose corners lie on the patch is off by a sum over pairs of corners of λᵢ λⱼ |second derivative| / 2 at most,
//! in which Σ λᵢ λⱼ ≤ 1/3. The second derivatives are no longer than the longest second difference of control points.
//! Source: Filip, Magedson, Markot 1986, whose factor is 1/8 for triangles of one shape; 1/6 is right for any within a cell.
//! Cost: O(steps) to choose them.
//! A true bound in both directions: each point of the patch has one of a triangle as near, and the other way round.

use super::BezierPatch;
use glam::DVec3;

/// Steps along a patch, at most: what rounding leaves of finer ones is no smoother.
pub(super) const MAX_STEPS: u32 = 512;

/// How long the second derivatives of a patch are, at most: twice along u, along both, twice along v.
pub(super) struct Bend {
    uu: f64,
    uv: f64,
    vv: f64,
}

impl Bend {
    pub(super) fn of(patch: &BezierPatch) -> Bend {
        let at = |u: usize, v: usize| DVec3::from(patch[4 * v + u].map(f64::from));
        let longest = |us: usize, vs: usize, difference: &dyn Fn(usize, usize) -> DVec3| {
            let all = (0..vs).flat_map(|v| (0..us).map(move |u| (u, v)));
            all.map(|(u, v)| difference(u, v).length()).fold(0.0, f64::max)
        };
        Bend {
            uu: 6.0 * longest(2, 4, &|u, v| at(u + 2, v) - 2.0 * at(u + 1, v) + at(u, v)),
            uv: 9.0
                * longest(3, 3, &|u, v| {
                    (at(u + 1, v + 1) - at(u, v + 1)) - (at(u + 1, v) - at(u, v))
                }),
            vv: 6.0 * longest(4, 2, &|u, v| at(u, v + 2) - 2.0 * at(u, v + 1) + at(u, v)),
        }
    }

    /// Is the patch a flat parallelogram that is run through evenly?
    pub(super) fn is_none(&self) -> bool {
        self.uu.max(self.uv).max(self.vv) == 0.0
    }

    /// How far triangles within cells of so many steps may be off.
    pub(super) fn error(&self, steps: [u32; 2]) -> f64 {
        let [u, v] = steps.map(|steps| 1.0 / f64::from(steps));
        (self.uu * u * u + 2.0 * self.uv * u * v + self.vv * v * v) / 6.0
    }

    /// The fewest cells that are within a tolerance: steps along u and v. Those at the limit where none are.
    pub(super) fn steps(&self, tolerance: f64) -> [u32; 2] {
        let mut best = [MAX_STEPS; 2];
        for nu in 1..=MAX_STEPS {
            let cells = best[0] * best[1];
            if nu >= cells {
                break;
            }
            let fewest = self.steps_along_v(nu, tolerance).filter(|nv| nu * nv < cells);
            best = fewest.map_or(best, |nv| [nu, nv]);
        }
        best
    }

    fn steps_along_v(&self, nu: u32, tolerance: f64) -> Option<u32> {
        let u = 1.0 / f64::from(nu);
        let left = 6.0 * tolerance - self.uu * u * u;
        if left < 0.0 {
            return None;
        }
        // The root of vv h² + 2 uv u h = left, in the form that does not cancel.
        let half = self.uv * u;
        let below = half + (half * half + self.vv * left).sqrt();
        let least = if below == 0.0 { 1.0 } else { (below / left).ceil() };
        // Rounding may have lost the last bit of it.
        let nv = least.clamp(1.0, f64::from(MAX_STEPS)) as u32;
        [nv, nv + 1]
            .into_iter()
            .find(|&nv| nv <= MAX_STEPS && self.error([nu, nv]) <= tolerance)
    }
}
