//! Scanline crossings of a triangle that is too large for f32, in f64.
//!
//! Source: as [`super::lanes`].
//! Cost: O(1) for sixteen rows.
//! Exact up to a unit of fixed point; returns bounds of the error.

use super::{LANES, ONE};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8};

/// Edges of a triangle: at most two bound its rows on each side.
pub(super) struct HugeEdges {
    left: [HugeEdge; 2],
    right: [HugeEdge; 2],
}

/// One edge, like a lane of [`Edge`](super::lanes::Edge).
#[derive(Clone, Copy)]
struct HugeEdge {
    slope: f64,
    least: f64,
    greatest: f64,
}

impl HugeEdges {
    /// Creates the edges from vertices in units; crossings are relative to `origin`, in samples.
    pub(super) fn new(corners: [[i32; 2]; 3], origin: [i32; 2]) -> HugeEdges {
        let at = |[x, y]: [i32; 2]| {
            let pixels = |place: i32, from: i32| f64::from(place) / f64::from(ONE) - f64::from(from);
            [pixels(x, origin[0]), pixels(y, origin[1])]
        };
        let [a, b, c] = corners.map(at);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let [b, c] = if area < 0.0 { [c, b] } else { [b, c] };
        let bounds_nothing = |column: f64| HugeEdge {
            slope: 0.0,
            least: column,
            greatest: column,
        };
        let mut sides = HugeEdges {
            left: [bounds_nothing(-FAR); 2],
            right: [bounds_nothing(FAR); 2],
        };
        let [mut lefts, mut rights] = [0, 0];
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            let slope = dx / dy;
            let at = from[0] - 0.5 - from[1] * slope;
            let error = (1.0 + slope.abs()) * UNITS;
            let side = HugeEdge {
                slope,
                least: at - error,
                greatest: at + error,
            };
            // As in `lanes`: y points down.
            if dy < 0.0 {
                sides.left[lefts % 2] = side;
                lefts += 1;
            } else if dy > 0.0 {
                sides.right[rights % 2] = side;
                rights += 1;
            }
        }
        sides
    }

    /// Returns the first column and the end column (exclusive) of each of sixteen rows from `row` on, clamped to
    /// `between`; each as a lower and an upper bound.
    #[inline(always)]
    pub(super) fn ends<S: Simd>(&self, simd: S, row: i32, between: [f64; 2]) -> [[f32x16<S>; 2]; 2] {
        let below = self.eight(simd, row, between);
        let above = self.eight(simd, row + LANES as i32 / 2, between);
        [
            [below[0].narrow(above[0]), below[1].narrow(above[1])],
            [below[2].narrow(above[2]), below[3].narrow(above[3])],
        ]
    }

    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, row: i32, [first, end]: [f64; 2]) -> [f64x8<S>; 4] {
        let y = f64x8::from_slice(simd, &CENTRES) + f64::from(row);
        let [first, end] = [f64x8::splat(simd, first), f64x8::splat(simd, end)];
        let [mut start, mut start_at_most] = [first, first];
        let [mut stop, mut stop_at_most] = [end, end];
        for side in &self.left {
            let way = y * side.slope;
            start = start.max(way + side.least);
            start_at_most = start_at_most.max(way + side.greatest);
        }
        for side in &self.right {
            let way = y * side.slope;
            stop = stop.min(way + side.least);
            stop_at_most = stop_at_most.min(way + side.greatest);
        }
        [
            start.min(end).ceil(),
            start_at_most.min(end).ceil(),
            stop.max(first).ceil(),
            stop_at_most.max(first).ceil(),
        ]
    }
}

/// Outside all columns.
const FAR: f64 = 1e9;

/// Generous bound on the error of a coordinate, in pixels; rounding to units accounts for half a unit.
const UNITS: f64 = 2.0 / ONE as f64;

const CENTRES: [f64; LANES / 2] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
