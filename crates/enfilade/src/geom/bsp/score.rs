//! Scores a splitting plane by the number of polygons in front, behind, in the plane, and cut.
//!
//! The node's sample is stored in blocks of eight polygons, one per SIMD lane, and tested against one plane after
//! another. A plane is abandoned once its score can no longer beat the best.
//! Source: thesis "Painter's algorithm and binary space partitioning", 2.3.4 (the score).
//! Cost: O(corners of the sample) for each plane.
//! Performs the same operations as `Splitter::side` in the same order, so that both classify alike.

use super::BspOptions;
use super::side::Splitter;
use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::DVec3;

/// Number of polygons on each side of a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Tally {
    pub(super) front: u32,
    pub(super) back: u32,
    pub(super) on: u32,
    pub(super) cut: u32,
}

/// A splitter and its score.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScoredSplitter {
    pub(super) score: f32,
    pub(super) cut: u32,
    pub(super) splitter: Splitter,
}

/// A free plane may cut at most one polygon in this many, so that building ends soon even if cuts cost nothing.
const MAX_CUT: u32 = 4;

impl Tally {
    /// Returns `true` if a free plane may be a splitter: both sides get fewer polygons than the node has, and it cuts
    /// few.
    pub(super) fn separates(&self) -> bool {
        self.back + self.on > 0 && self.front + self.on > 0 && self.cuts_few()
    }

    pub(super) fn cuts_few(&self) -> bool {
        MAX_CUT * self.cut <= self.front + self.back + self.on + self.cut
    }

    /// Returns the score; lower is better.
    pub(super) fn score(&self, options: &BspOptions) -> f32 {
        self.lower_bound(options, 0)
    }

    /// Returns a lower bound of the score after `more` further polygons.
    fn lower_bound(&self, options: &BspOptions, more: u32) -> f32 {
        let unbalanced = self.front.abs_diff(self.back).saturating_sub(more) as f32;
        options.balance * unbalanced
            + options.splits * self.cut as f32
            + options.coplanar * self.on as f32
            + options.coplanar.min(0.0) * more as f32
    }
}

/// Polygons that planes are scored against.
#[derive(Default)]
pub(super) struct Sample {
    /// Per block: x, y and z of the polygons' first corners, then of their second corners, and so on.
    corners: Vec<[f64; 8]>,
    blocks: Vec<Block>,
    len: usize,
}

/// Eight polygons. Those with fewer corners than the largest repeat their last corner.
struct Block {
    /// Index of the block's first row, and the corner count of its largest polygon.
    first: usize,
    corners: usize,
    /// Minimum band by polygon: points within it count as on the plane.
    bands: [f64; 8],
}

impl Sample {
    pub(super) fn clear(&mut self) {
        self.corners.clear();
        self.blocks.clear();
        self.len = 0;
    }

    pub(super) fn push(&mut self, corners: &[DVec3], band: f64) {
        let lane = self.len % 8;
        if lane == 0 {
            self.blocks.push(Block {
                first: self.corners.len(),
                corners: 0,
                bands: [0.0; 8],
            });
        }
        self.len += 1;
        let Some(block) = self.blocks.last_mut() else {
            return;
        };
        block.bands[lane] = band;
        while block.corners < corners.len() {
            let last = self.corners.len().saturating_sub(3);
            let repeated = if block.corners == 0 {
                [[0.0; 8]; 3]
            } else {
                std::array::from_fn(|axis| self.corners[last + axis])
            };
            self.corners.extend(repeated);
            block.corners += 1;
        }
        for (place, row) in self.corners[block.first..].chunks_exact_mut(3).enumerate() {
            let corner = corners[place.min(corners.len() - 1)].to_array();
            for (values, value) in row.iter_mut().zip(corner) {
                values[lane] = value;
            }
        }
    }

    /// Classifies the polygons of the sample; `None` once the score cannot be as low as `best`.
    #[inline(always)]
    pub(super) fn tally<S: Simd>(
        &self,
        simd: S,
        splitter: &Splitter,
        options: &BspOptions,
        best: f32,
    ) -> Option<Tally> {
        let splat = |value: f64| f64x8::splat(simd, value);
        let [a, b, c] = splitter.plane.normal.to_array().map(splat);
        let offset = splat(splitter.plane.offset);
        let mut tally = Tally::default();
        for (number, block) in self.blocks.iter().enumerate() {
            let [mut low, mut high] = [splat(0.0); 2];
            let rows = &self.corners[block.first..block.first + 3 * block.corners];
            for row in rows.chunks_exact(3) {
                let [x, y, z] = [0, 1, 2].map(|axis| f64x8::simd_from(simd, row[axis]));
                let height = a * x + b * y + c * z - offset;
                low = low.min(height);
                high = high.max(height);
            }
            let band = f64x8::simd_from(simd, block.bands).max(splat(splitter.band));
            let more = (self.len - 8 * number).saturating_sub(8) as u32;
            let there = 0xFF_u64 >> (8 * number + 8).saturating_sub(self.len);
            let [above, below] = [high.simd_gt(band), low.simd_lt(-band)].map(|m| m.to_bitmask() & there);
            tally.front += (above & !below).count_ones();
            tally.back += (below & !above).count_ones();
            tally.cut += (above & below).count_ones();
            tally.on += (there & !above & !below).count_ones();
            if tally.lower_bound(options, more) > best {
                return None;
            }
        }
        Some(tally)
    }
}

#[cfg(test)]
mod tests {
    use super::super::side::{Plane, Side};
    use super::*;
    use crate::chance::Dice;
    use crate::simd::dispatch;
    use fearless_simd::Level;

    #[test]
    fn eight_abreast_lie_where_one_by_one_they_do() {
        // Polygons of three to six corners on a coarse grid, so that many touch the planes.
        let mut dice = Dice::new(1);
        let mut next = move || dice.below(8) as f64 - 3.5;
        let mut polygon = |i: usize| -> Vec<DVec3> {
            let level = next();
            let corner = |_| DVec3::new(next(), next(), if i.is_multiple_of(3) { level } else { next() });
            (0..3 + i % 4).map(corner).collect()
        };
        let polygons: Vec<Vec<DVec3>> = (0..29).map(&mut polygon).collect();
        let mut sample = Sample::default();
        for (i, corners) in polygons.iter().enumerate() {
            sample.push(corners, (i % 2) as f64);
        }
        let mut seen = Tally::default();
        for round in 0..50 {
            let mut plane = Plane {
                normal: DVec3::new(next(), next(), next()).normalize(),
                offset: next(),
            };
            if round % 2 == 0 {
                plane.normal = DVec3::AXES[round / 2 % 3];
            }
            let splitter = Splitter {
                plane,
                band: 0.125,
                polygon: None,
            };
            let mut expected = Tally::default();
            for (i, corners) in polygons.iter().enumerate() {
                *match splitter.side(corners, splitter.band.max((i % 2) as f64)) {
                    Side::Front => &mut expected.front,
                    Side::Back => &mut expected.back,
                    Side::On => &mut expected.on,
                    Side::Both => &mut expected.cut,
                } += 1;
            }
            let options = BspOptions::default();
            let tally = dispatch!(Level::new(), simd => sample.tally(simd, &splitter, &options, f32::MAX));
            assert_eq!(tally, Some(expected));
            let tally = dispatch!(Level::new(), simd => {
                sample.tally(simd, &splitter, &options, expected.score(&options))
            });
            assert_eq!(
                tally,
                Some(expected),
                "a plane that equals the best score must not be abandoned"
            );
            seen.front += expected.front;
            seen.on += expected.on;
            seen.cut += expected.cut;
        }
        assert!(seen.front > 0 && seen.on > 0 && seen.cut > 0);
    }
}
