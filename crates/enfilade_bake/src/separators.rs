//! Separating planes of two windings: bound what a ray through both can reach.
//!
//! A line that is below a separating plane at the source and above it at the pass stays above it from there on.
//! Source: Teller. Visibility Computations in Densely Occluded Polyhedral Environments. PhD thesis, Berkeley 1992, 3.3.
//! Cost: each edge of either winding gives one plane, found in O(corners) of the other, four edges at a time (SIMD).
//! Conservative: a plane is used only if all corners of both windings are verified to be on their sides, with exact
//! arithmetic where rounding could decide. Each plane has a bound of its rounding error. A missing plane only enlarges
//! the result.

use crate::ways::Ways;
use crate::winding::{ClipResult, cut};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use four_planes::FourPlanes;
use glam::DVec3;

mod four_planes;

/// Squared sine of the angle between an edge and a corner below which the plane through both is numerically unreliable.
const NEEDLE: f64 = 1e-12;

/// Relative rounding error of a corner's height above a plane: a few 2⁻⁵³, with a margin.
const ROUNDING: f64 = 1e-14;

/// Separating planes of two windings, the first below and the second above all of them. The windings are not stored;
/// callers pass the same two again.
#[derive(Debug, Default)]
pub(crate) struct Separators {
    fours: Vec<FourPlanes>,
}

impl Separators {
    pub(crate) fn clear(&mut self) {
        self.fours.clear();
    }

    /// Computes the separating planes of `source` (below) and `pass` (above).
    ///
    /// `pass` is on the side to which the counter-clockwise normal of `source` points, and `source` is behind `pass`:
    /// rays run along both normals, or with `against` opposite to both.
    pub(crate) fn find(&mut self, ways: &Ways, [source, pass]: [&[DVec3]; 2], against: bool) {
        self.fours.clear();
        let fours = &mut self.fours;
        dispatch!(ways.level, simd => {
            around(simd, [source, pass], false, against, ways.size, fours);
            around(simd, [pass, source], true, !against, ways.size, fours);
        });
    }

    /// Clips `winding` to the upper side of all planes between `windings`; `kept` is scratch memory.
    ///
    /// Conservative: each cut is made as far below its plane as rounding can shift it. A winding that only touches a
    /// plane from below is removed.
    pub(crate) fn clip(
        &self,
        ways: &Ways,
        windings: [&[DVec3]; 2],
        winding: &mut Vec<DVec3>,
        kept: &mut Vec<DVec3>,
    ) -> ClipResult {
        dispatch!(ways.level, simd => clip(simd, &self.fours, windings, winding, kept))
    }

    /// Clears the bits of all ways that are below one of the planes between `windings`, and removes words that become
    /// zero. `words` holds words of a bit row with their indices.
    pub(crate) fn keep_above(&self, ways: &Ways, windings: [&[DVec3]; 2], words: &mut Vec<(u32, u64)>) {
        dispatch!(ways.level, simd => keep_above(simd, ways, &self.fours, windings, words));
    }
}

/// Computes the planes through the edges of the first winding, with that winding below and the second above, or swapped
/// if `edges_above`. `backwards` reverses the edges.
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
        let four = FourPlanes::find(simd, ends, [edged, other], edges_above, size);
        fours.extend(four.first(edged.len() - first));
    }
}

#[inline(always)]
fn clip<S: Simd>(
    simd: S,
    fours: &[FourPlanes],
    windings: [&[DVec3]; 2],
    winding: &mut Vec<DVec3>,
    kept: &mut Vec<DVec3>,
) -> ClipResult {
    let mut left = ClipResult::All;
    for four in fours {
        let mut pending = 0b1111;
        while pending != 0 {
            let heights = four.heights(simd, winding);
            if heights.below & pending != 0 {
                return ClipResult::Nothing;
            }
            let work = (heights.touching | heights.cut) & pending;
            if work == 0 {
                break;
            }
            let lane = work.trailing_zeros() as usize;
            pending &= !0 << (lane + 1);
            if heights.touching >> lane & 1 != 0 && four.culls_exactly(lane, windings, winding) {
                return ClipResult::Nothing;
            }
            if heights.cut >> lane & 1 != 0 {
                cut(winding, &four.plane(lane), kept);
                left = ClipResult::Part;
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
    windings: [&[DVec3]; 2],
    words: &mut Vec<(u32, u64)>,
) {
    // No closures here: they are compiled as separate functions, without the SIMD target features.
    let mut kept = 0;
    for at in 0..words.len() {
        let (number, mut word) = words[at];
        let mut rest = word;
        while rest != 0 {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            let way = number as usize * 64 + bit.trailing_zeros() as usize;
            for four in fours {
                if four.culls_way(simd, windings, ways.spheres[way], &ways.all[way].corners) {
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
