//! What small faces cover: a sub-tile, its samples and a reversed depth, one after the other.
//!
//! Written without a branch by sixteen faces at once, and merged one by one: two of the sixteen may cover the same
//! sub-tile.
//! Source: none but ours.
//! Cost: O(records).
//! Conservative: reversed depth is the least over a sub-tile, lowered, and no less than the least of the corners.

use super::Frame;
use super::lanes::Lanes;
use crate::cover::masked_depth::grid::Tiles;
use crate::cover::masked_depth::tile::{ROWS, SUB_COLUMNS, SUB_ROWS, SUB_TILES};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u32x16};

/// Room for what sixteen small faces can cover: 8 sub-tiles down, 4 across.
const MOST: usize = 16 * 8 * 4;

/// Sub-tiles of a tile, one below the other.
const DOWN: i32 = (ROWS / SUB_ROWS) as i32;

/// Samples of sub-tiles.
pub(super) struct Records {
    pub(super) count: usize,
    /// Number of the tile, times sixteen, and of the sub-tile in it.
    places: [u32; MOST + 16],
    masks: [u32; MOST + 16],
    rev_depth: [u32; MOST + 16],
    touched: u32,
}

impl Default for Records {
    fn default() -> Records {
        Records {
            count: 0,
            places: [0; MOST + 16],
            masks: [0; MOST + 16],
            rev_depth: [0; MOST + 16],
            touched: 0,
        }
    }
}

impl Records {
    /// Merges all into the tiles, and forgets them.
    #[inline(always)]
    pub(super) fn merge(&mut self, tiles: &mut Tiles) {
        let count = self.count.min(MOST);
        // All at once into the cache: one by one each would be waited for.
        for &place in &self.places[..count] {
            self.touched ^= tiles.tiles[place as usize / SUB_TILES].reference[place as usize % SUB_TILES];
        }
        let all = self.places[..count]
            .iter()
            .zip(&self.masks[..count])
            .zip(&self.rev_depth[..count]);
        for ((&place, &mask), &rev_depth) in all {
            let index = place as usize / SUB_TILES;
            let (tile, farthest) = tiles.tile(index as u32);
            if tile.cover(place as usize % SUB_TILES, mask, rev_depth) {
                *farthest = tile.farthest();
            }
        }
        self.count = 0;
    }
}

/// Where sixteen small faces cover sub-tiles, and how near they are there.
pub(super) struct Places<S: Simd> {
    /// The first sub-tile's column and row, counted from the corner of the screen.
    column: u32x16<S>,
    row: u32x16<S>,
    tile_columns: u32,
    /// Reversed depth over the first sub-tile, at least; by sub-tile; and at least anywhere.
    rev_depth: f32x16<S>,
    by_column: f32x16<S>,
    by_row: f32x16<S>,
    least: f32x16<S>,
}

impl<S: Simd> Places<S> {
    #[inline(always)]
    pub(super) fn new<const OTHERS: usize>(simd: S, frame: &Frame, lanes: &Lanes<S, OTHERS>) -> Places<S> {
        let zero = f32x16::splat(simd, 0.0);
        // The least over a sub-tile is at one of its corners.
        let [by_column, by_row] = lanes.plane.slope;
        let column = by_column
            .simd_lt(zero)
            .select(f32x16::splat(simd, 7.5), f32x16::splat(simd, 0.5));
        let row = by_row
            .simd_lt(zero)
            .select(f32x16::splat(simd, 3.5), f32x16::splat(simd, 0.5));
        Places {
            column: ((lanes.origin[0] + frame.middle_sample[0]) >> 3).bitcast(),
            row: (((lanes.origin[1] + frame.middle_sample[1]) >> 2) - frame.first_row * DOWN).bitcast(),
            tile_columns: frame.tile_columns,
            rev_depth: lanes.plane.at + by_column * column + by_row * row,
            by_column: by_column * SUB_COLUMNS as f32,
            by_row: by_row * SUB_ROWS as f32,
            least: lanes.plane.least,
        }
    }

    /// Writes the masks of the sub-tiles so many columns and rows from the first.
    #[inline(always)]
    pub(super) fn write(
        &self,
        simd: S,
        [right, down]: [usize; 2],
        mask: u32x16<S>,
        sure: mask32x16<S>,
        records: &mut Records,
    ) {
        let some = mask.simd_gt(u32x16::splat(simd, 0)) & sure;
        let found = some.to_bitmask().count_ones() as usize;
        let [column, row] = [self.column + right as u32, self.row + down as u32];
        let tile = (row >> 2) * self.tile_columns + (column >> 2);
        let place = (tile << 4) | ((row & 3) << 2) | (column & 3);
        let rev_depth = self.rev_depth + self.by_column * right as f32 + self.by_row * down as f32;
        let rev_depth: u32x16<S> = rev_depth.max(self.least).bitcast();
        let start = records.count.min(MOST);
        place
            .compress(some)
            .store_slice(&mut records.places[start..start + 16]);
        mask.compress(some)
            .store_slice(&mut records.masks[start..start + 16]);
        rev_depth
            .compress(some)
            .store_slice(&mut records.rev_depth[start..start + 16]);
        records.count = start + found;
    }
}
