//! Corners on the screen: sixteen at a time, in fixed point.
//!
//! A place on the screen is kept in units of 2⁻¹⁷ pixel from the frame's middle, so that differences of places are exact
//! integers; a corner of which that cannot be told (behind the near distance, before the last portal, far off the screen,
//! no number) is odd, and whatever has it is left to f64.
//! Source: fixed point as in graphics hardware, but 512 times as fine, and never trusted beyond its unit.
//! Cost: O(corners).
//! Exact within a unit: places are computed in f64, as everywhere, and rounded once.

use super::{Frame, LANES, ONE};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, mask64x8, u32x16};

/// Column, row (in units, from the frame's middle) and the bits of the nearness, above 0; all 0 where odd.
pub(in crate::cover::masked_depth) type Corner = [u32; 4];

/// A corner farther than this from the middle is odd, in units: sums and differences of two fit 32 bits.
const FARTHEST: f64 = (1_u32 << 30) as f64;

/// A corner farther than this along the line of sight, or nearer than its inverse, is odd: what is computed in f32 from
/// others stays a number.
pub(super) const DEEPEST: f64 = 1e18;

/// What rounds an f64 to the nearest integer when added, and leaves it in the lower half of the bits.
const TO_INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;

/// Sixteen positions: x of each, y of each, z of each.
pub(in crate::cover::masked_depth) type Block = [[f32; LANES]; 3];

/// Puts positions on the screen.
#[inline(always)]
pub(super) fn place<S: Simd>(simd: S, frame: &Frame, positions: &[Block], corners: &mut Vec<Corner>) {
    let needed = positions.len() * LANES;
    if corners.len() < needed {
        corners.resize(needed, [0; 4]);
    }
    for (block, placed) in positions.iter().zip(corners.chunks_exact_mut(LANES)) {
        place_sixteen(simd, frame, block, placed);
    }
}

#[inline(always)]
fn place_sixteen<S: Simd>(simd: S, frame: &Frame, at: &Block, placed: &mut [Corner]) {
    let (xs, xs_above) = f32x16::from_slice(simd, &at[0]).widen();
    let (ys, ys_above) = f32x16::from_slice(simd, &at[1]).widen();
    let (zs, zs_above) = f32x16::from_slice(simd, &at[2]).widen();
    let below = place_eight(simd, frame, [xs, ys, zs]);
    let above = place_eight(simd, frame, [xs_above, ys_above, zs_above]);
    // The lower half of each.
    let columns = below[0]
        .bitcast::<u32x16<S>>()
        .unzip_low(above[0].bitcast::<u32x16<S>>());
    let rows = below[1]
        .bitcast::<u32x16<S>>()
        .unzip_low(above[1].bitcast::<u32x16<S>>());
    let nearness = below[2].narrow(above[2]).bitcast::<u32x16<S>>();
    let spare = u32x16::splat(simd, 0);
    let (first, second) = (columns.interleave(nearness), rows.interleave(spare));
    let all = [first.0.interleave(second.0), first.1.interleave(second.1)];
    let placed = placed.as_flattened_mut();
    all[0].0.store_slice(&mut placed[..16]);
    all[0].1.store_slice(&mut placed[16..32]);
    all[1].0.store_slice(&mut placed[32..48]);
    all[1].1.store_slice(&mut placed[48..64]);
}

/// Column and row with [`TO_INTEGER`] added, and nearness; 0 where odd.
#[inline(always)]
fn place_eight<S: Simd>(simd: S, frame: &Frame, [x, y, z]: [f64x8<S>; 3]) -> [f64x8<S>; 3] {
    let [to_x, to_y, to_w] = &frame.matrix;
    let at_x = x * to_x[0] + y * to_x[1] + z * to_x[2] + to_x[3];
    let at_y = x * to_y[0] + y * to_y[1] + z * to_y[2] + to_y[3];
    let w = x * to_w[0] + y * to_w[1] + z * to_w[2] + to_w[3];
    let zero = f64x8::splat(simd, 0.0);
    let nearness = f64x8::splat(simd, 1.0) / w;
    let column = (at_x * nearness - frame.middle[0]) * ONE as f64;
    let row = (at_y * nearness - frame.middle[1]) * ONE as f64;
    let farthest = f64x8::splat(simd, FARTHEST);
    let mut sound: mask64x8<S> = w.simd_gt(f64x8::splat(simd, frame.near))
        & column.abs().simd_lt(farthest)
        & row.abs().simd_lt(farthest)
        & w.simd_lt(f64x8::splat(simd, DEEPEST));
    if let Some(([a, b, c], distance)) = frame.entry {
        sound &= (at_x * a + at_y * b + w * c).simd_gt(f64x8::splat(simd, distance));
    }
    [
        column + TO_INTEGER,
        row + TO_INTEGER,
        sound.select(nearness, zero),
    ]
}
