//! Projects vertices to the screen in fixed point, sixteen at a time.
//!
//! Coordinates are in units of 2⁻¹⁷ pixel from the frame's origin, so differences are exact integers. A vertex is odd
//! if it has no such coordinates: it is in front of the near plane or the entry plane, too far off screen or not
//! finite. A face with an odd vertex is clipped or left to f64, unless all its vertices are outside one clip plane.
//! Source: fixed point as in graphics hardware, but 512 times as fine, and never trusted beyond its unit.
//! Cost: O(vertices).
//! Exact within a unit: coordinates are computed in f64, as in the exact covers, and rounded once.

use super::{Frame, LANES, ONE};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, mask64x8, u32x16};

/// Column and row (in units from the frame's origin), bits of the reversed depth (positive; 0 if odd), and an outcode:
/// a bit for each clip plane that an odd vertex is certainly outside.
pub(super) type Corner = [u32; 4];

/// Maximum number of vertices in a batch.
pub(super) const MAX_CORNERS: usize = 1024;

/// Projected vertices of a batch.
pub(super) struct Corners(pub(super) Box<[Corner; MAX_CORNERS]>);

impl Default for Corners {
    fn default() -> Corners {
        Corners(Box::new([[0; 4]; MAX_CORNERS]))
    }
}

/// A vertex farther from the origin is odd, in units: the limit lets sums and differences of two coordinates fit 32
/// bits.
pub(super) const FARTHEST: f64 = (1_u32 << 30) as f64;

/// A vertex with W above this, or below its inverse, is odd: the limits keep results in f32 finite.
pub(super) const DEEPEST: f64 = 1e18;

/// Rounds an f64 to the nearest integer when added, and leaves the integer in the lower half of the bits.
pub(super) const TO_INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;

/// Sixteen positions: x of each, y of each, z of each.
pub(in crate::cover::masked_depth) type Block = [[f32; LANES]; 3];

/// Projects positions, up to the capacity of `corners`.
#[inline(always)]
pub(super) fn project<S: Simd>(simd: S, frame: &Frame, positions: &[Block], corners: &mut Corners) {
    for (block, placed) in positions.iter().zip(corners.0.as_chunks_mut().0) {
        project_lanes(simd, frame, block, placed);
    }
}

#[inline(always)]
fn project_lanes<S: Simd>(simd: S, frame: &Frame, at: &Block, placed: &mut [Corner; LANES]) {
    let (xs, xs_above) = f32x16::from_slice(simd, &at[0]).widen();
    let (ys, ys_above) = f32x16::from_slice(simd, &at[1]).widen();
    let (zs, zs_above) = f32x16::from_slice(simd, &at[2]).widen();
    let eight = [
        ScreenCorners::new(frame, [xs, ys, zs]),
        ScreenCorners::new(frame, [xs_above, ys_above, zs_above]),
    ];
    let [below, above] = [
        eight[0].fixed_point(simd, frame),
        eight[1].fixed_point(simd, frame),
    ];
    // Take the lower half of each.
    let columns = below[0]
        .bitcast::<u32x16<S>>()
        .unzip_low(above[0].bitcast::<u32x16<S>>());
    let rows = below[1]
        .bitcast::<u32x16<S>>()
        .unzip_low(above[1].bitcast::<u32x16<S>>());
    let rev_depth = below[2].narrow(above[2]).bitcast::<u32x16<S>>();
    let zero = u32x16::splat(simd, 0);
    let outside = if rev_depth.simd_eq(zero).any_true() {
        let [below, above] = [eight[0].outside(simd, frame), eight[1].outside(simd, frame)];
        below.unzip_low(above)
    } else {
        zero
    };
    let (first, second) = (columns.interleave(rev_depth), rows.interleave(outside));
    let all = [first.0.interleave(second.0), first.1.interleave(second.1)];
    let placed = placed.as_flattened_mut();
    all[0].0.store_slice(&mut placed[..16]);
    all[0].1.store_slice(&mut placed[16..32]);
    all[1].0.store_slice(&mut placed[32..48]);
    all[1].1.store_slice(&mut placed[48..64]);
}

/// (X, Y, W) of eight vertices.
struct ScreenCorners<S: Simd> {
    x: f64x8<S>,
    y: f64x8<S>,
    w: f64x8<S>,
}

impl<S: Simd> ScreenCorners<S> {
    #[inline(always)]
    fn new(frame: &Frame, [x, y, z]: [f64x8<S>; 3]) -> ScreenCorners<S> {
        let [to_x, to_y, to_w] = &frame.matrix;
        ScreenCorners {
            x: x * to_x[0] + y * to_x[1] + z * to_x[2] + to_x[3],
            y: x * to_y[0] + y * to_y[1] + z * to_y[2] + to_y[3],
            w: x * to_w[0] + y * to_w[1] + z * to_w[2] + to_w[3],
        }
    }

    /// Returns column and row with [`TO_INTEGER`] added, and reversed depth; 0 if odd.
    #[inline(always)]
    fn fixed_point(&self, simd: S, frame: &Frame) -> [f64x8<S>; 3] {
        let ScreenCorners { x, y, w } = *self;
        let zero = f64x8::splat(simd, 0.0);
        let rev_depth = f64x8::splat(simd, 1.0) / w;
        let column = (x * rev_depth - frame.middle[0]) * ONE as f64;
        let row = (y * rev_depth - frame.middle[1]) * ONE as f64;
        let farthest = f64x8::splat(simd, FARTHEST);
        let mut valid: mask64x8<S> = w.simd_gt(f64x8::splat(simd, frame.near))
            & column.abs().simd_lt(farthest)
            & row.abs().simd_lt(farthest)
            & w.simd_lt(f64x8::splat(simd, DEEPEST));
        if let Some(([a, b, c], distance)) = frame.entry {
            valid &= (x * a + y * b + w * c).simd_gt(f64x8::splat(simd, distance));
        }
        [
            column + TO_INTEGER,
            row + TO_INTEGER,
            valid.select(rev_depth, zero),
        ]
    }

    /// Returns outcodes, in the lower half of the bits: a bit for each clip plane that a vertex is certainly outside. A
    /// face with all vertices outside the same plane is not visible; this also holds for vertices behind the eye.
    #[inline(always)]
    fn outside(&self, simd: S, frame: &Frame) -> u32x16<S> {
        /// Generous bound on the rounding of f64; samples are half a pixel inside the limits.
        const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;
        let ScreenCorners { x, y, w } = *self;
        let mut sides = f64x8::splat(simd, TO_INTEGER);
        for (axis, at) in [x, y].into_iter().enumerate() {
            let [low, high] = [w * frame.limits[axis][0], w * frame.limits[axis][1]];
            let slack = (at.abs() + low.abs() + high.abs()) * ROUNDING;
            sides += bit(simd, (at + slack).simd_lt(low), 1 << (2 * axis));
            sides += bit(simd, (at - slack).simd_gt(high), 2 << (2 * axis));
        }
        sides += bit(simd, w.simd_lt(f64x8::splat(simd, frame.behind)), 16);
        if let Some(([a, b, c], distance)) = frame.entry {
            let at = [x * a, y * b, w * c];
            let slack = (at[0].abs() + at[1].abs() + at[2].abs()) * ROUNDING;
            let before = (at[0] + at[1] + at[2] + slack).simd_lt(f64x8::splat(simd, distance * BEFORE));
            sides += bit(simd, before, 32);
        }
        sides.bitcast()
    }
}

/// Returns the number `bit` in lanes where `so` is true, otherwise 0.
#[inline(always)]
fn bit<S: Simd>(simd: S, so: mask64x8<S>, bit: u32) -> f64x8<S> {
    so.select(f64x8::splat(simd, f64::from(bit)), f64x8::splat(simd, 0.0))
}

/// Factor by which a vertex in front of the entry plane is certainly in front of it.
const BEFORE: f64 = 1.0 - 1.0 / (1_u64 << 20) as f64;
