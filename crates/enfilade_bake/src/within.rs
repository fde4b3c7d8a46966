//! What of many ways lies above planes.
//!
//! Eight planes lie abreast, and ways come one after another: first by their spheres, which decide most, then by their corners.
//! Cost: O(ways) for eight planes, O(corners) for a way whose sphere a plane crosses.
//! The same operations in the same order at any SIMD level: the bits are those of one plane at a time.

use crate::ways::Ways;
use crate::winding::Plane;
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8};
use glam::DVec3;

/// Takes out of some words of a row the ways that lie below one of the planes, which part `parted`. `number` gives the number
/// of a word in its row.
pub(crate) fn keep_within(
    ways: &Ways,
    planes: &[Plane],
    parted: [&[DVec3]; 2],
    words: &mut [u64],
    number: impl Fn(usize) -> usize,
) {
    dispatch!(ways.level, simd => {
        for eight in planes.chunks(8) {
            keep_above(simd, ways, eight, parted, words, &number);
        }
    });
}

#[inline(always)]
fn keep_above<S: Simd>(
    simd: S,
    ways: &Ways,
    planes: &[Plane],
    parted: [&[DVec3]; 2],
    words: &mut [u64],
    number: impl Fn(usize) -> usize,
) {
    let abreast = Abreast::of(simd, planes);
    for (at, word) in words.iter_mut().enumerate() {
        let mut rest = *word;
        while rest != 0 {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            let way = number(at) * 64 + bit.trailing_zeros() as usize;
            let (centre, radius) = ways.spheres[way];
            let middle = abreast.above(simd, centre);
            let reach = abreast.slack + radius;
            let near = middle.simd_le(reach);
            if !near.any_true() {
                continue;
            }
            let is_below = middle.simd_lt(-reach).any_true()
                || abreast.hide(simd, planes, near.to_bitmask(), &ways.all[way].corners, parted);
            if is_below {
                *word ^= bit;
            }
        }
    }
}

/// Up to eight planes, lane by lane; the other lanes have everything above.
struct Abreast<S: Simd> {
    normal: [f64x8<S>; 3],
    offset: f64x8<S>,
    slack: f64x8<S>,
}

impl<S: Simd> Abreast<S> {
    #[inline(always)]
    fn of(simd: S, planes: &[Plane]) -> Abreast<S> {
        let mut normal = [[0.0; 8]; 3];
        let mut offset = [f64::NEG_INFINITY; 8];
        let mut slack = [0.0; 8];
        for (lane, plane) in planes.iter().enumerate() {
            for axis in 0..3 {
                normal[axis][lane] = plane.normal[axis];
            }
            offset[lane] = plane.offset;
            slack[lane] = plane.slack;
        }
        let lanes = |of: [f64; 8]| f64x8::simd_from(simd, of);
        Abreast {
            normal: [lanes(normal[0]), lanes(normal[1]), lanes(normal[2])],
            offset: lanes(offset),
            slack: lanes(slack),
        }
    }

    /// As [`Plane::above`].
    #[inline(always)]
    fn above(&self, simd: S, point: DVec3) -> f64x8<S> {
        let splat = |value: f64| f64x8::splat(simd, value);
        let [x, y, z] = self.normal;
        x * splat(point.x) + y * splat(point.y) + z * splat(point.z) - self.offset
    }

    /// As [`Plane::hides`], by any of the planes in `asked`.
    #[inline(always)]
    fn hide(&self, simd: S, planes: &[Plane], asked: u64, corners: &[DVec3], parted: [&[DVec3]; 2]) -> bool {
        let mut most = f64x8::splat(simd, f64::NEG_INFINITY);
        for &corner in corners {
            most = most.max(self.above(simd, corner));
        }
        let mut close = most.simd_le(self.slack).to_bitmask() & asked;
        if close == 0 {
            return false;
        }
        if most.simd_lt(-self.slack).to_bitmask() & asked != 0 {
            return true;
        }
        let most: [f64; 8] = most.into();
        while close != 0 {
            let lane = close.trailing_zeros() as usize;
            close &= close - 1;
            if planes[lane].hides(corners, most[lane], parted) {
                return true;
            }
        }
        false
    }
}
