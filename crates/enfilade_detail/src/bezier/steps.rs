//! Chooses the number of steps per patch so that its triangles stay within a tolerance.
//!
//! The error of a triangle with corners on the patch is at most a sum over pairs of corners of λᵢ λⱼ |second
//! derivative| / 2, where Σ λᵢ λⱼ ≤ 1/3. Second derivatives are bounded by the longest second difference of control
//! points.
//! Source: Filip, Magedson, Markot 1986, whose factor is 1/8 for triangles of one shape; 1/6 is valid for any triangle
//!     within a cell.
//! Cost: O(steps) to choose them.
//! A two-sided bound (Hausdorff distance): from the patch to the triangles and from the triangles to the patch.

use super::BezierPatch;
use glam::DVec3;

/// Maximum number of steps along a patch; more would be below f32 precision.
pub(super) const MAX_STEPS: u32 = 512;

/// Upper bounds of a patch's second derivatives: ∂²/∂u², ∂²/∂u∂v, ∂²/∂v².
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

    /// Returns `true` if the patch is a flat, evenly parametrized parallelogram.
    pub(super) fn is_none(&self) -> bool {
        self.uu.max(self.uv).max(self.vv) == 0.0
    }

    /// Returns the maximum error of triangles within cells of the given step counts along u and v.
    pub(super) fn error(&self, steps: [u32; 2]) -> f64 {
        let [u, v] = steps.map(|steps| 1.0 / f64::from(steps));
        (self.uu * u * u + 2.0 * self.uv * u * v + self.vv * v * v) / 6.0
    }

    /// Returns the step counts along u and v with the fewest cells within a tolerance; the maximum counts if none
    /// suffices.
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
        // The root of vv h² + 2 uv u h = left, in the form without cancellation.
        let half = self.uv * u;
        let below = half + (half * half + self.vv * left).sqrt();
        let least = if below == 0.0 { 1.0 } else { (below / left).ceil() };
        // Rounding may have made it one too small.
        let nv = least.clamp(1.0, f64::from(MAX_STEPS)) as u32;
        [nv, nv + 1]
            .into_iter()
            .find(|&nv| nv <= MAX_STEPS && self.error([nu, nv]) <= tolerance)
    }
}
