//! Classifies the eight corners of a box against a plane, all at once.
//!
//! A box is on a side of a plane if one of its corners is. The result also has the corners that are certainly on a
//! side: a point of the box that is known to be in a leaf needs no further test.
//! Source: original to this library; `Corners::against` is specified by `sides_one_by_one` below, and gives the same
//!     bits at every SIMD level.
//! Cost: about ten vector operations per plane, without branches.
//! Conservative: a corner that is undecided within rounding, or NaN, counts as on both sides and as certain on neither.

use super::line::SLIT;
use crate::view::region::Volume;
use crate::view::screen_map::swapped;
use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::DVec3;

/// Relative error of a height, as a part of the sum that it is; larger than the error of pieces of faces.
const ROUNDING: f64 = 1.0 / (1_u64 << 44) as f64;

/// Corners as a bit mask, in the order of [`Volume::corners`].
pub(super) type Bits = u8;
pub(super) const ALL: Bits = 0xff;

/// Positions of the corners of a box relative to a plane n · p = d.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sides {
    /// Corners certainly at n · p > d.
    pub(super) inside: Bits,
    /// Corners certainly at n · p < d.
    pub(super) outside: Bits,
    /// The corners of `inside` (and of `outside`, in `well_outside`) that are more than a slit away from the plane.
    pub(super) well_inside: Bits,
    pub(super) well_outside: Bits,
}

/// Corners of a box in the space of (X, Y, W), one SIMD lane each.
#[derive(Clone, Copy)]
pub(super) struct Corners<S: Simd> {
    x: f64x8<S>,
    y: f64x8<S>,
    z: f64x8<S>,
    slit: f64x8<S>,
    /// Upper bounds of the absolute coordinates of the corners.
    sum: DVec3,
    /// Whether the corners are in the space of (column, row, reversed depth) instead.
    is_parallel: bool,
}

impl<S: Simd> Corners<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, volume: &Volume) -> Corners<S> {
        let Volume {
            origin,
            sides: [a, b, c],
            is_parallel,
        } = *volume;
        let z = spread(simd, origin.z, [a.z, b.z, c.z]);
        Corners {
            x: spread(simd, origin.x, [a.x, b.x, c.x]),
            y: spread(simd, origin.y, [a.y, b.y, c.y]),
            z,
            slit: if is_parallel {
                f64x8::splat(simd, SLIT)
            } else {
                z * SLIT
            },
            sum: greatest(volume),
            is_parallel,
        }
    }

    /// Classifies the corners against the plane `normal` · p = `distance`.
    #[inline(always)]
    pub(super) fn against(&self, simd: S, normal: DVec3, distance: f64) -> Sides {
        let (normal, distance) = self.in_space(normal, distance);
        // This order of additions has the shortest latency; the next step of the traversal waits for the result.
        let height = (self.x * normal.x + self.y * normal.y) + (self.z * normal.z - distance);
        let margin = margin(self.sum, normal, distance);
        let [above, below] = [f64x8::splat(simd, margin), f64x8::splat(simd, -margin)];
        Sides {
            inside: height.simd_gt(above).to_bitmask() as Bits,
            outside: height.simd_lt(below).to_bitmask() as Bits,
            well_inside: (height - self.slit).simd_gt(above).to_bitmask() as Bits,
            well_outside: (height + self.slit).simd_lt(below).to_bitmask() as Bits,
        }
    }

    /// Returns the corners at n · p < d, without an error margin: for planes that only bound the view, where rounding
    /// does not matter.
    #[inline(always)]
    pub(super) fn before(&self, simd: S, normal: DVec3, distance: f64) -> Bits {
        let (normal, distance) = self.in_space(normal, distance);
        let height = self.x * normal.x + self.y * normal.y + self.z * normal.z;
        height.simd_lt(f64x8::splat(simd, distance)).to_bitmask() as Bits
    }
}

impl<S: Simd> Corners<S> {
    /// Returns a plane n · (X, Y, W) = d as a plane in the space of the corners, with the same sides.
    #[inline(always)]
    fn in_space(&self, normal: DVec3, distance: f64) -> (DVec3, f64) {
        if self.is_parallel {
            swapped(normal, distance)
        } else {
            (normal, distance)
        }
    }
}

/// For each side of the box, the corners that it leads to.
const LEADS: [[f64; 8]; 3] = [
    [0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0],
    [0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0],
    [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
];

/// Computes one coordinate of all corners from that of the origin and those of the sides, summed as in
/// [`Volume::corners`]. If a side is infinite, all results are NaN.
#[inline(always)]
fn spread<S: Simd>(simd: S, origin: f64, [a, b, c]: [f64; 3]) -> f64x8<S> {
    let [to_a, to_b, to_c] = [
        f64x8::simd_from(simd, LEADS[0]),
        f64x8::simd_from(simd, LEADS[1]),
        f64x8::simd_from(simd, LEADS[2]),
    ];
    (to_c * c + origin) + (to_a * a + to_b * b)
}

/// Returns upper bounds of the absolute coordinates of the corners.
#[inline(always)]
fn greatest(volume: &Volume) -> DVec3 {
    let [a, b, c] = volume.sides;
    volume.origin.abs() + (a.abs() + b.abs() + c.abs())
}

/// Returns the error bound of a corner's height above a plane.
#[inline(always)]
fn margin(sum: DVec3, normal: DVec3, distance: f64) -> f64 {
    ROUNDING * (normal.abs().dot(sum) + distance.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::occlusion_tree::tests::{levels, odd_numbers};
    use crate::simd::dispatch;

    /// Scalar specification of [`Corners::against`].
    fn sides_one_by_one(volume: &Volume, normal: DVec3, distance: f64) -> Sides {
        let margin = margin(greatest(volume), normal, distance);
        let mut sides = Sides {
            inside: 0,
            outside: 0,
            well_inside: 0,
            well_outside: 0,
        };
        let [a, b, c] = volume.sides;
        let is_finite = volume.sides.iter().all(|side| side.is_finite());
        for (index, corner) in volume.corners().into_iter().enumerate() {
            let [to_a, to_b, to_c] = LEADS.map(|to| to[index]);
            let spread = (c * to_c + volume.origin) + (a * to_a + b * to_b);
            assert!(!is_finite || spread == corner || spread.is_nan() || corner.is_nan());
            let corner = spread;
            let height = (corner.x * normal.x + corner.y * normal.y) + (corner.z * normal.z - distance);
            let slit = corner.z * SLIT;
            sides.inside |= Bits::from(height > margin) << index;
            sides.outside |= Bits::from(height < -margin) << index;
            sides.well_inside |= Bits::from(height - slit > margin) << index;
            sides.well_outside |= Bits::from(height + slit < -margin) << index;
        }
        sides
    }

    #[test]
    fn every_simd_level_gives_the_bits_of_one_corner_after_the_other() {
        let mut number = odd_numbers(0x2545_F491_4F6C_DD1D);
        let mut point = || DVec3::new(number(), number(), number());
        let mut split = 0;
        for _ in 0..20_000 {
            let volume = Volume {
                origin: point(),
                sides: [point(), point(), point()],
                is_parallel: false,
            };
            let (normal, distance) = (point(), point().x);
            let expected = sides_one_by_one(&volume, normal, distance);
            split += usize::from(expected.inside != 0 && expected.outside != 0);
            for level in levels() {
                let sides =
                    dispatch!(level, simd => Corners::new(simd, &volume).against(simd, normal, distance));
                assert_eq!(sides, expected, "{volume:?} {normal} {distance} {level:?}");
            }
        }
        assert!(split > 2000, "{split}");
    }
}
