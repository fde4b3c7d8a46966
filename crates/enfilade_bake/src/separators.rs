//! Planes that part two convex polygons: what is seen from one through the other stays on the other's side.
//!
//! A line that is below a plane at the source and above it at the pass is above it ever after.
//! Source: Teller. Visibility Computations in Densely Occluded Polyhedral Environments. PhD thesis, Berkeley 1992, 3.3.
//! Cost: each edge of either gives one plane, found in O(corners) of the other, four at a time.
//! Conservative: a plane counts only where it is checked to part all corners of both, exactly where rounding could
//! decide; each knows how far rounding can tilt it within the world. One left out shows more.

use crate::ways::Ways;
use crate::winding::{Left, cut};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use four_planes::FourPlanes;
use glam::DVec3;

mod four_planes;

/// A corner farther in line with an edge than this, as a squared sine, says nothing sure about a plane through both.
const NEEDLE: f64 = 1e-12;

/// Of its length: what rounding can do to the height of a corner over a plane. A few 2⁻⁵³, and some to spare.
const ROUNDING: f64 = 1e-14;

/// Planes between two windings, with all of the first below and all of the second above. Those two are not kept here: whoever
/// has the planes gives the same windings again.
#[derive(Debug, Default)]
pub(crate) struct Separators {
    fours: Vec<FourPlanes>,
}

impl Separators {
    pub(crate) fn clear(&mut self) {
        self.fours.clear();
    }

    /// Finds the planes between `source`, below them, and `pass`.
    ///
    /// `pass` lies on the side of `source` to which its counter-clockwise normal points, and `source` behind `pass`: lines go
    /// along both normals, or, where `against` says so, against both.
    pub(crate) fn find(&mut self, ways: &Ways, [source, pass]: [&[DVec3]; 2], against: bool) {
        self.fours.clear();
        let fours = &mut self.fours;
        dispatch!(ways.level, simd => {
            around(simd, [source, pass], false, against, ways.size, fours);
            around(simd, [pass, source], true, !against, ways.size, fours);
        });
    }

    /// Cuts off what of a winding is below one of the planes between `parted`; `kept` is scratch.
    ///
    /// What is left is never smaller than what lies above the planes: cuts are made as far below them as rounding can shift
    /// them. A winding that only touches a plane is left with nothing.
    pub(crate) fn clip(
        &self,
        ways: &Ways,
        parted: [&[DVec3]; 2],
        winding: &mut Vec<DVec3>,
        kept: &mut Vec<DVec3>,
    ) -> Left {
        dispatch!(ways.level, simd => clip(simd, &self.fours, parted, winding, kept))
    }

    /// Takes out of the words of a row, each with its number, the ways below one of the planes between `parted`; words that are
    /// zero then, too.
    pub(crate) fn keep_above(&self, ways: &Ways, parted: [&[DVec3]; 2], words: &mut Vec<(u32, u64)>) {
        dispatch!(ways.level, simd => keep_above(simd, ways, &self.fours, parted, words));
    }
}

/// Finds the planes through the edges of the first winding: with it below and the second above, or, with `edges_above`, the
/// other way. `backwards` turns the edges round.
#[inline(always)]
fn around<S: Simd>(
    simd: S,
    [edged, other]: [&[DVec3]; 2],
    edges_above: bool,
    backwards: bool,
    size: f64,
    fours: &mut Vec<FourPlanes>,
) {
    let last = edged.len() - 1;
    for first in (0..edged.len()).step_by(4) {
        let mut ends = [[0; 2]; 4];
        for (lane, ends) in ends.iter_mut().enumerate() {
            let at = (first + lane).min(last);
            let before = if at == 0 { last } else { at - 1 };
            *ends = if backwards { [at, before] } else { [before, at] };
        }
        let four = FourPlanes::rest(simd, ends, [edged, other], edges_above, size);
        fours.extend(four.first(edged.len() - first));
    }
}

#[inline(always)]
fn clip<S: Simd>(
    simd: S,
    fours: &[FourPlanes],
    parted: [&[DVec3]; 2],
    winding: &mut Vec<DVec3>,
    kept: &mut Vec<DVec3>,
) -> Left {
    let mut left = Left::All;
    for four in fours {
        let mut waiting = 0b1111;
        while waiting != 0 {
            let heights = four.heights(simd, winding);
            if heights.below & waiting != 0 {
                return Left::Nothing;
            }
            let work = (heights.touching | heights.cut) & waiting;
            if work == 0 {
                break;
            }
            let lane = work.trailing_zeros() as usize;
            waiting &= !0 << (lane + 1);
            if heights.touching >> lane & 1 != 0 && four.hides_exactly(lane, parted, winding) {
                return Left::Nothing;
            }
            if heights.cut >> lane & 1 != 0 {
                cut(winding, &four.plane(lane), kept);
                left = Left::Part;
            }
        }
    }
    left
}

#[inline(always)]
fn keep_above<S: Simd>(
    simd: S,
    ways: &Ways,
    fours: &[FourPlanes],
    parted: [&[DVec3]; 2],
    words: &mut Vec<(u32, u64)>,
) {
    // No closures here: compiled on their own, they would be without the instructions.
    let mut kept = 0;
    for at in 0..words.len() {
        let (number, mut word) = words[at];
        let mut rest = word;
        while rest != 0 {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            let way = number as usize * 64 + bit.trailing_zeros() as usize;
            for four in fours {
                if four.hides_way(simd, parted, ways.spheres[way], &ways.all[way].corners) {
                    word ^= bit;
                    break;
                }
            }
        }
        if word != 0 {
            words[kept] = (number, word);
            kept += 1;
        }
    }
    words.truncate(kept);
}
