//! Rasterizes small triangles and quads: one face per lane, sixteen at a time, row by row.
//!
//! Most faces of a detailed mesh overlap two or three sub-tiles. With one face per lane and a size limit, no lane waits
//! long for a larger face. Sixteen faces write records of sub-tile, coverage mask and reversed depth at once without
//! branches; the records are merged one by one, because two faces may cover the same sub-tile.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.1, transposed:
//!     the paper has the rows of one triangle in the lanes.
//! Cost: O(rows of the highest) for sixteen faces, and O(records).
//! Exact coverage: a face with an uncertain end of a row goes to f64. Conservative depth: the minimum over a sub-tile,
//!     lowered, but at least the minimum of the corners.

use super::LANES;
use super::project::Frame;
use super::setup::{Edge, FaceSetup};
use super::sort::{FaceLanes, Queue};
use super::tiles::{SUB_COLUMNS, SUB_ROWS, SUB_TILES, Tiles};
use crate::simd::apart;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

/// Maximum number of sub-tiles that a small face overlaps, down and across.
const DOWN: usize = 8;
const ACROSS: usize = 4;

/// Rasterizes queued small faces as long as the queue has at least `least`; appends the numbers of uncertain ones to
/// `uncertain`.
#[inline(always)]
pub(super) fn draw_queued<S: Simd, const SIDES: usize, const OTHERS: usize>(
    simd: S,
    frame: &Frame,
    queue: &mut Queue<SIDES>,
    least: usize,
    records: &mut Records,
    tiles: &mut Tiles,
    uncertain: &mut Vec<u32>,
) {
    let mut from = 0;
    while queue.count >= from + least {
        let faces = queue.load(simd, from);
        draw::<S, SIDES, OTHERS>(simd, frame, &faces, records, uncertain);
        records.merge(tiles);
        from += faces.lanes;
    }
    queue.discard_before(from);
}

/// Writes records of up to sixteen small faces; appends the numbers of uncertain ones to `uncertain`.
#[inline(always)]
fn draw<S: Simd, const SIDES: usize, const OTHERS: usize>(
    simd: S,
    frame: &Frame,
    faces: &FaceLanes<S, SIDES>,
    records: &mut Records,
    uncertain: &mut Vec<u32>,
) {
    let align = [SUB_COLUMNS as i32, SUB_ROWS as i32];
    let lanes = apart!(simd, FaceSetup::<S, OTHERS>::new(simd, frame, faces, align));
    let there: mask32x16<S> = mask32x16::from_bitmask(simd, (1_u64 << faces.lanes) - 1);
    let [first, end] = [
        lanes.columns[0].to_float::<f32x16<S>>() - 0.5,
        lanes.columns[1].to_float::<f32x16<S>>() - 0.5,
    ];
    let most = f32x16::splat(simd, 30.5);
    let least = f32x16::splat(simd, -0.5);
    let none = u32x16::splat(simd, 0);
    let zero = i32x16::splat(simd, 0);
    // Mask unused lanes, which may hold anything.
    let down = there
        .select((lanes.rows[1] + (SUB_ROWS as i32 - 1)) >> 2, zero)
        .reduce_max();
    let across = there
        .select((lanes.columns[1] + (SUB_COLUMNS as i32 - 1)) >> 3, zero)
        .reduce_max();
    let (down, across) = ((down as usize).min(DOWN), (across as usize).min(ACROSS));
    let all = u32x16::splat(simd, u32::MAX);
    let last = i32x16::splat(simd, 31);
    let rows_there = (all << lanes.rows[0].max(zero).min(last).bitcast::<u32x16<S>>())
        & !(all << lanes.rows[1].max(zero).min(last).bitcast::<u32x16<S>>());

    let start = records.count;
    let writer = apart!(simd, RecordWriter::new(simd, frame, &lanes));
    let mut sure = there;
    loop {
        let mut unsure = lanes.unsure;
        for group in 0..down {
            let mut rows = [none; SUB_ROWS];
            for (row, held) in rows.iter_mut().enumerate() {
                let y = (SUB_ROWS * group + row) as f32 + 0.5;
                let [mut start, mut stop] = [lanes.edges.left.crossing(y), lanes.edges.right.crossing(y)];
                for other in &lanes.edges.others {
                    let [left, right] = [other[0].crossing(y), other[1].crossing(y)];
                    start = [start[0].max(left[0]), start[1].max(left[1])];
                    stop = [stop[0].min(right[0]), stop[1].min(right[1])];
                }
                for bound in 0..2 {
                    start[bound] = start[bound].max(first).min(most).ceil();
                    stop[bound] = stop[bound].min(end).max(least).ceil();
                }
                unsure |= !(start[0].simd_eq(start[1]) & stop[0].simd_eq(stop[1]));
                let start = start[0].to_int::<i32x16<S>>().bitcast::<u32x16<S>>();
                let stop = stop[0].to_int::<i32x16<S>>().bitcast::<u32x16<S>>();
                *held = (all << start) & !(all << stop);
            }
            let open = (rows_there >> (SUB_ROWS * group) as u32) & 0xF;
            // Expands each of four bits to a byte, a row of a sub-tile.
            let open = ((open * 0x0020_4081) & 0x0101_0101) * 0xFF;
            let masks = apart!(simd, by_sub_tile(simd, &rows));
            for (right, mask) in masks[..across].iter().enumerate() {
                apart!(
                    simd,
                    writer.write(simd, [right, group], *mask & open, sure, records)
                );
            }
        }
        let mut left = (sure & unsure).to_bitmask();
        if left == 0 {
            return;
        }
        // Repeat without the uncertain faces, and drop the records written so far.
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            uncertain.push(faces.number[lane]);
            left &= left - 1;
        }
        sure &= !unsure;
        records.count = start;
    }
}

impl<S: Simd> Edge<S> {
    /// Returns lower and upper bounds of the crossing with the row whose centre is at `y`.
    #[inline(always)]
    pub(super) fn crossing(&self, y: f32) -> [f32x16<S>; 2] {
        let way = self.slope * y;
        [self.least + way, self.greatest + way]
    }
}

/// Splits four rows of 32 samples into the masks of four sub-tiles: transposes bytes.
#[inline(always)]
fn by_sub_tile<S: Simd>(_simd: S, rows: &[u32x16<S>; SUB_ROWS]) -> [u32x16<S>; ACROSS] {
    let [a, b, c, d] = *rows;
    let even = 0x00FF_00FF;
    let odd = 0xFF00_FF00;
    let [ab_even, ab_odd] = [(a & even) | ((b & even) << 8), ((a & odd) >> 8) | (b & odd)];
    let [cd_even, cd_odd] = [(c & even) | ((d & even) << 8), ((c & odd) >> 8) | (d & odd)];
    let [low, high] = [0x0000_FFFF, 0xFFFF_0000];
    [
        (ab_even & low) | (cd_even << 16),
        (ab_odd & low) | (cd_odd << 16),
        (ab_even >> 16) | (cd_even & high),
        (ab_odd >> 16) | (cd_odd & high),
    ]
}

/// Maximum number of records of sixteen small faces.
const MAX_RECORDS: usize = LANES * DOWN * ACROSS;

/// Records of covered sub-tiles.
pub(super) struct Records {
    count: usize,
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
    fn merge(&mut self, tiles: &mut Tiles) {
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
            let sub = sub_tile as usize % SUB_TILES;
            let (tile, farthest, closed) = tiles.tile(index as u32);
            let closed = closed.map_or(0, |closed| closed[sub]);
            let before = tile.cover(sub, [mask, closed], rev_depth);
            // Only the farthest sub-tile can change it.
            if before.is_some_and(|before| f32::from_bits(before) <= *farthest) {
                *farthest = tile.farthest();
            }
        }
        self.count = 0;
    }
}

/// Position and depth of the sub-tiles of sixteen small faces.
struct RecordWriter<S: Simd> {
    /// Column and row of the first sub-tile, from the top left corner of the tiles.
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
    fn new<const OTHERS: usize>(simd: S, frame: &Frame, lanes: &FaceSetup<S, OTHERS>) -> RecordWriter<S> {
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
            row: ((lanes.origin[1] + frame.middle_sample[1]) >> 2).bitcast(),
            tile_columns: frame.tile_columns,
            rev_depth: lanes.plane.at + by_column * column + by_row * row,
            by_column: by_column * SUB_COLUMNS as f32,
            by_row: by_row * SUB_ROWS as f32,
            least: lanes.plane.least,
        }
    }

    /// Writes records for the sub-tile `right` columns and `down` rows from the first.
    #[inline(always)]
    fn write(
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
