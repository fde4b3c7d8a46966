//! Coverage records of small faces: sub-tile, coverage mask and reversed depth.
//!
//! Sixteen faces write records at once without branches; the records are merged one by one, because two faces may cover
//! the same sub-tile.
//! Source: original to this library.
//! Cost: O(records).
//! Conservative: reversed depth is the minimum over a sub-tile, lowered, but at least the minimum of the corners.

use super::Frame;
use super::lanes::FaceSetup;
use crate::cover::masked_depth::grid::Tiles;
use crate::cover::masked_depth::tile::{ROWS, SUB_COLUMNS, SUB_ROWS, SUB_TILES};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u32x16};

/// Maximum number of records of sixteen small faces: 8 sub-tiles down, 4 across.
const MAX_RECORDS: usize = 16 * 8 * 4;

/// Rows of sub-tiles in a tile.
const DOWN: i32 = (ROWS / SUB_ROWS) as i32;

/// Records of covered sub-tiles.
pub(super) struct Records {
    pub(super) count: usize,
    /// Index of the tile times sixteen, plus the index of the sub-tile in it.
    sub_tiles: [u32; MAX_RECORDS + 16],
    masks: [u32; MAX_RECORDS + 16],
    rev_depth: [u32; MAX_RECORDS + 16],
    touched: u32,
}

impl Default for Records {
    fn default() -> Records {
        Records {
            count: 0,
            sub_tiles: [0; MAX_RECORDS + 16],
            masks: [0; MAX_RECORDS + 16],
            rev_depth: [0; MAX_RECORDS + 16],
            touched: 0,
        }
    }
}

impl Records {
    /// Merges all records into the tiles and removes them.
    #[inline(always)]
    pub(super) fn merge(&mut self, tiles: &mut Tiles) {
        let count = self.count.min(MAX_RECORDS);
        // Prefetch all sub-tiles at once, so that the cache misses overlap.
        for &sub_tile in &self.sub_tiles[..count] {
            self.touched ^=
                tiles.tiles[sub_tile as usize / SUB_TILES].reference[sub_tile as usize % SUB_TILES];
        }
        let all = self.sub_tiles[..count]
            .iter()
            .zip(&self.masks[..count])
            .zip(&self.rev_depth[..count]);
        for ((&sub_tile, &mask), &rev_depth) in all {
            let index = sub_tile as usize / SUB_TILES;
            let (tile, farthest) = tiles.tile(index as u32);
            if tile.cover(sub_tile as usize % SUB_TILES, mask, rev_depth) {
                *farthest = tile.farthest();
            }
        }
        self.count = 0;
    }
}

/// Position and depth of the sub-tiles of sixteen small faces.
pub(super) struct RecordWriter<S: Simd> {
    /// Column and row of the first sub-tile, from the top left corner of the screen.
    column: u32x16<S>,
    row: u32x16<S>,
    tile_columns: u32,
    /// Lower bound of reversed depth in the first sub-tile, its change per sub-tile, and a lower bound anywhere.
    rev_depth: f32x16<S>,
    by_column: f32x16<S>,
    by_row: f32x16<S>,
    least: f32x16<S>,
}

impl<S: Simd> RecordWriter<S> {
    #[inline(always)]
    pub(super) fn new<const OTHERS: usize>(
        simd: S,
        frame: &Frame,
        lanes: &FaceSetup<S, OTHERS>,
    ) -> RecordWriter<S> {
        let zero = f32x16::splat(simd, 0.0);
        // The minimum over a sub-tile is at one of its corners.
        let [by_column, by_row] = lanes.plane.slope;
        let column = by_column
            .simd_lt(zero)
            .select(f32x16::splat(simd, 7.5), f32x16::splat(simd, 0.5));
        let row = by_row
            .simd_lt(zero)
            .select(f32x16::splat(simd, 3.5), f32x16::splat(simd, 0.5));
        RecordWriter {
            column: ((lanes.origin[0] + frame.middle_sample[0]) >> 3).bitcast(),
            row: (((lanes.origin[1] + frame.middle_sample[1]) >> 2) - frame.first_row * DOWN).bitcast(),
            tile_columns: frame.tile_columns,
            rev_depth: lanes.plane.at + by_column * column + by_row * row,
            by_column: by_column * SUB_COLUMNS as f32,
            by_row: by_row * SUB_ROWS as f32,
            least: lanes.plane.least,
        }
    }

    /// Writes records for the sub-tile `right` columns and `down` rows from the first.
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
        let sub_tile = (tile << 4) | ((row & 3) << 2) | (column & 3);
        let rev_depth = self.rev_depth + self.by_column * right as f32 + self.by_row * down as f32;
        let rev_depth: u32x16<S> = rev_depth.max(self.least).bitcast();
        let start = records.count.min(MAX_RECORDS);
        sub_tile
            .compress(some)
            .store_slice(&mut records.sub_tiles[start..start + 16]);
        mask.compress(some)
            .store_slice(&mut records.masks[start..start + 16]);
        rev_depth
            .compress(some)
            .store_slice(&mut records.rev_depth[start..start + 16]);
        records.count = start + found;
    }
}
