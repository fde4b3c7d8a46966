//! Depth test on the samples of one 8×8 tile, stored contiguously.
//!
//! A row of a tile is eight samples: one cache line and one register of the widest SIMD level. So a triangle is
//! depth-tested row by row without a loop over samples: columns outside its run get the value [`OPEN`], which never
//! wins the test.
//! Source: original to this library.
//! Cost: about ten operations per row of eight samples; eight loads for the farthest sample.
//! Exact: the same operations for each sample as [`Row::bits`]; the tests compare the two sample by sample, at every
//! SIMD level.

use crate::cover::samples::{COVERED, OPEN, Sample, lower_half, rev_depth};
use crate::raster::{Row, Triangle};

/// Base-2 logarithm of the number of samples along a tile's side.
pub(super) const TILE_SHIFT: usize = 3;
pub(super) const TILE: usize = 1 << TILE_SHIFT;

/// Samples of a tile in row-major order.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Block(pub(super) [[Sample; TILE]; TILE]);

impl Block {
    pub(super) const COVERED: Block = Block([[COVERED; TILE]; TILE]);
    pub(super) const OPEN: Block = Block([[OPEN; TILE]; TILE]);

    /// Depth-tests a triangle against row `y` of the tile and makes it the owner of the samples at which it is nearest.
    /// `x` is the tile's first column, `row` the reversed depth along the row, and `run` the columns of the triangle in
    /// it, in screen columns.
    #[inline(always)]
    pub(super) fn keep_nearest(&mut self, y: usize, x: u16, run: [u16; 2], row: &Row, owner: u32) {
        let owner = Sample::from(lower_half(owner));
        let bits = row.eight_bits(x);
        let [start, end] = run.map(|column| i32::from(column) - i32::from(x));
        for (lane, (sample, bits)) in (0..).zip(self.0[y].iter_mut().zip(bits)) {
            let new = Sample::from(bits) << 32 | owner;
            let new = if (start <= lane) & (lane < end) { new } else { OPEN };
            *sample = if new > *sample { new } else { *sample };
        }
    }

    /// Makes a triangle the owner of all samples. The tile's first column and row are `x` and `y`.
    #[inline(always)]
    pub(super) fn fill(&mut self, x: u16, y: u16, triangle: &Triangle) {
        let owner = Sample::from(lower_half(triangle.owner));
        for (y, samples) in (y..).zip(&mut self.0) {
            let bits = triangle.row(y).eight_bits(x);
            for (sample, bits) in samples.iter_mut().zip(bits) {
                *sample = Sample::from(bits) << 32 | owner;
            }
        }
    }

    /// Returns the bits of the farthest reversed depth in the tile.
    #[inline(always)]
    pub(super) fn farthest(&self) -> u32 {
        let mut farthest = [COVERED; TILE];
        for row in &self.0 {
            for (farthest, &sample) in farthest.iter_mut().zip(row) {
                *farthest = if sample < *farthest { sample } else { *farthest };
            }
        }
        rev_depth(farthest.into_iter().fold(COVERED, Sample::min))
    }

    /// Returns the bits of the farthest reversed depth in the given columns and rows of the tile, both start inclusive,
    /// end exclusive.
    #[inline(always)]
    pub(super) fn farthest_in(&self, columns: [usize; 2], rows: [usize; 2]) -> u32 {
        let mut farthest = [COVERED; TILE];
        for row in &self.0[rows[0]..rows[1]] {
            for (lane, (farthest, &sample)) in (0..).zip(farthest.iter_mut().zip(row)) {
                let sample = if (columns[0] <= lane) & (lane < columns[1]) {
                    sample
                } else {
                    COVERED
                };
                *farthest = if sample < *farthest { sample } else { *farthest };
            }
        }
        rev_depth(farthest.into_iter().fold(COVERED, Sample::min))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Dice, levels};
    use crate::simd::dispatch;
    use glam::DVec3;

    #[test]
    fn a_row_of_a_tile_is_its_samples_one_by_one_at_every_level() {
        let mut dice = Dice::new(5);
        for round in 0..2000_u32 {
            let triangle = Triangle {
                owner: round % 3,
                rev_depth: DVec3::new(dice.odd(0.01), dice.odd(0.01), dice.within(1.0)),
                least: 0.1,
                greatest: 0.6,
            };
            let before: Block = Block(std::array::from_fn(|_| {
                std::array::from_fn(|_| match (dice.within(1.0) * 4.0) as i32 {
                    0 => OPEN,
                    1 => COVERED,
                    _ => {
                        Sample::from((dice.within(1.0).abs() as f32).to_bits()) << 32
                            | Sample::from(lower_half(1))
                    }
                })
            }));
            let (y, x) = (round as usize % TILE, 8 * (round % 5) as u16);
            let start = x + (round / 7 % 8) as u16;
            let run = [start, start + 1 + (round / 11 % 20) as u16];
            let row = triangle.row(y as u16);
            let mut expected = before;
            for (column, sample) in (x..)
                .zip(&mut expected.0[y])
                .filter(|(column, _)| (run[0]..run[1]).contains(column))
            {
                let new = Sample::from(row.bits(i32::from(column))) << 32
                    | Sample::from(lower_half(triangle.owner));
                *sample = new.max(*sample);
            }
            let all = expected.0.iter().flatten().copied().fold(COVERED, Sample::min);
            let some = expected.0[2..5]
                .iter()
                .flat_map(|row| &row[1..7])
                .copied()
                .fold(COVERED, Sample::min);
            for level in levels() {
                let (known, [farthest, part]) = dispatch!(level, _simd => {
                    let mut block = before;
                    block.keep_nearest(y, x, run, &row, triangle.owner);
                    let farthest = [block.farthest(), block.farthest_in([1, 7], [2, 5])];
                    (block, farthest)
                });
                assert_eq!(known.0, expected.0);
                assert_eq!([farthest, part], [rev_depth(all), rev_depth(some)]);
            }
        }
    }
}
