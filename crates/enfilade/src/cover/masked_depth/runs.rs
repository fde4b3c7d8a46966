//! Covers tiles with parts of faces, with the sixteen sub-tiles of a tile in SIMD lanes.
//!
//! A face is cut into rows of tiles. Tiles that are nearer than the whole face are left out by [`Tiles::farthest`],
//! sixteen at a time. The others are listed: those that the face covers entirely, and those of which it covers some
//! samples. Two loops without branches then cover the tiles of both lists, so that a mispredicted branch does not delay
//! the next tile.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, sections 3.1 to 3.3.
//! Cost: O(tiles); a tile that is already nearer is rejected by one comparison.
//! Conservative: as [`Tile::cover`], the scalar specification.

use super::occluder::Slope;
use super::tiles::{
    BandTiles, COLUMNS, ROWS, SUB_COLUMNS, SUB_ROWS, SUB_TILE_PLACES, SUB_TILES, Tile, Tiles,
};
use super::{COUNT, LANES};
use crate::raster::Band;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u8x64, u32x16};
use std::ops::Range;

/// Lower bound of the reversed depth of a face in the tiles of a row: at least `least`.
pub(super) struct RowDepth<S: Simd> {
    /// In each sub-tile of the first tile.
    first: f32x16<S>,
    /// The minimum of `first`.
    lowest: f32,
    /// Change per tile to the right.
    by_tile: f32,
    least: f32,
}

/// Part of a face in a row of tiles.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct TileRow {
    /// First column and end column (exclusive) of each row of samples, from the left of the first tile; equal for a row
    /// without samples.
    starts: [i32; ROWS],
    stops: [i32; ROWS],
    /// The fields of [`RowDepth`].
    first: [f32; SUB_TILES],
    lowest: f32,
    by_tile: f32,
    least: f32,
    /// Index of the first tile.
    first_tile: u32,
}

/// Queue of rows of tiles to be covered.
pub(super) struct RunQueue {
    rows: Box<[TileRow; MAX_ROWS]>,
    row_count: usize,
    /// Tiles of which some samples are covered, and tiles that are covered entirely.
    some: TileList,
    whole: TileList,
}

/// Tiles of rows: the index of the row, and the tile, counted from the row's first one, in the lower [`TILE_BITS`].
struct TileList {
    count: usize,
    tiles: [u32; MAX_TILES + LANES],
}

const TILE_BITS: u32 = 16;

/// Maximum number of rows, and of tiles from which on they are covered.
const MAX_ROWS: usize = 64;
const MANY_TILES: usize = 64;
/// Maximum number of tiles in a list, and of those listed at once.
const MAX_TILES: usize = 512;
pub(super) const SEGMENT: i32 = 256;

/// Twice the relative rounding error of f32.
const ROUNDING: f32 = 1.0 / (1_u32 << 22) as f32;

impl Default for RunQueue {
    fn default() -> RunQueue {
        let none = || TileList {
            count: 0,
            tiles: [0; MAX_TILES + LANES],
        };
        let no_row = TileRow {
            starts: [0; ROWS],
            stops: [0; ROWS],
            first: [0.0; SUB_TILES],
            lowest: 0.0,
            by_tile: 0.0,
            least: 0.0,
            first_tile: 0,
        };
        RunQueue {
            rows: Box::new([no_row; MAX_ROWS]),
            row_count: 0,
            some: none(),
            whole: none(),
        }
    }
}

impl TileList {
    /// Adds the tiles selected by `which`, of sixteen.
    #[inline(always)]
    fn push<S: Simd>(&mut self, which: mask32x16<S>, tiles: u32x16<S>) {
        let start = self.count.min(MAX_TILES);
        tiles
            .compress(which)
            .store_slice(&mut self.tiles[start..start + LANES]);
        self.count = start + which.to_bitmask().count_ones() as usize;
    }

    /// Removes and returns all tiles, each as the index of its row and its place in it.
    #[inline(always)]
    fn take(&mut self) -> impl Iterator<Item = (usize, u32)> {
        let count = std::mem::take(&mut self.count).min(MAX_TILES);
        self.tiles[..count]
            .iter()
            .map(|tile| ((tile >> TILE_BITS) as usize, tile & ((1 << TILE_BITS) - 1)))
    }
}

/// Tiles of a row that were listed.
#[derive(Clone, Copy)]
pub(super) struct Listed {
    /// Whether any is covered, and whether any is covered in part.
    pub(super) any: bool,
    pub(super) some: bool,
    /// Lengths of the lists before.
    before: [usize; 2],
}

impl RunQueue {
    /// Returns `true` if the queue should be covered now.
    #[inline(always)]
    pub(super) fn are_many(&self) -> bool {
        self.row_count >= MAX_ROWS / 2 || self.some.count + self.whole.count >= MANY_TILES
    }

    /// Returns `true` if the queue must be covered before more tiles are listed.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.row_count == MAX_ROWS || self.some.count.max(self.whole.count) > MAX_TILES - SEGMENT as usize
    }

    /// Lists those tiles of a row that are not nearer than `greatest`: of the tiles `across`, at most [`SEGMENT`], from
    /// the tile `first_tile` on. Those in `whole` are covered entirely. If any are listed, [`RunQueue::push`] or
    /// [`RunQueue::unlist`] must follow.
    #[inline(always)]
    pub(super) fn list<S: Simd>(
        &mut self,
        simd: S,
        tiles: &Tiles,
        first_tile: usize,
        [across, whole]: [Range<i32>; 2],
        greatest: f32,
    ) -> Listed {
        let before = [self.some.count, self.whole.count];
        let greatest = f32x16::splat(simd, greatest);
        let mut tile = across.start;
        while tile < across.end {
            let here = u32x16::from_slice(simd, &COUNT).bitcast::<i32x16<S>>() + tile;
            let farthest = tiles.sixteen_farthest(simd, first_tile + tile as usize);
            let seen = farthest.simd_lt(greatest) & here.simd_lt(across.end);
            tile += LANES as i32;
            if !seen.any_true() {
                continue;
            }
            let all = here.simd_ge(whole.start) & here.simd_lt(whole.end);
            let listed = here.bitcast::<u32x16<S>>() | (self.row_count as u32) << TILE_BITS;
            self.some.push(seen & !all, listed);
            self.whole.push(seen & all, listed);
        }
        let some = self.some.count > before[0];
        Listed {
            any: some || self.whole.count > before[1],
            some,
            before,
        }
    }

    /// Removes the tiles listed last.
    #[inline(always)]
    pub(super) fn unlist(&mut self, listed: &Listed) {
        [self.some.count, self.whole.count] = listed.before;
    }

    /// Queues the row of the tiles listed last, with its runs of samples: first column and end column (exclusive) of
    /// each row of samples, from the left of the first tile.
    #[inline(always)]
    pub(super) fn push<S: Simd>(
        &mut self,
        first_tile: usize,
        [starts, stops]: [i32x16<S>; 2],
        depth: &RowDepth<S>,
    ) {
        let row = &mut self.rows[self.row_count % MAX_ROWS];
        starts.store_slice(&mut row.starts);
        stops.store_slice(&mut row.stops);
        depth.first.store_slice(&mut row.first);
        row.lowest = depth.lowest;
        row.by_tile = depth.by_tile;
        row.least = depth.least;
        row.first_tile = first_tile as u32;
        self.row_count += 1;
    }

    /// Queues the samples of a band, of a face with the given depth.
    #[inline(always)]
    pub(super) fn push_band<S: Simd>(&mut self, simd: S, tiles: &mut Tiles, band: &Band, slope: &Slope) {
        let y = usize::from(band.y);
        let across = BandTiles::new(band).tiles();
        let row = (y / ROWS - tiles.first_row) * tiles.columns;
        for first in across.clone().step_by(SEGMENT as usize) {
            if self.is_full() || self.are_many() {
                self.cover(simd, tiles);
            }
            let count = (across.end - first).min(SEGMENT as usize);
            let rev_depth = slope.over_row(simd, [first * COLUMNS, y / ROWS * ROWS], count);
            let listed = self.list(simd, tiles, row + first, [0..count as i32, 0..0], slope.nearest());
            if listed.any {
                let [mut starts, mut stops] = [[0; ROWS]; 2];
                let rows = starts.iter_mut().zip(&mut stops).skip(y % ROWS);
                for ((start, stop), run) in rows.zip(band.runs) {
                    [*start, *stop] = run.map(|column| i32::from(column) - (first * COLUMNS) as i32);
                }
                let runs = [starts, stops].map(|ends| i32x16::from_slice(simd, &ends));
                self.push(row + first, runs, &rev_depth);
            }
        }
    }

    /// Covers all queued tiles and empties the queue. Not inlined, because it is long and has several callers.
    pub(super) fn cover<S: Simd>(&mut self, simd: S, tiles: &mut Tiles) {
        simd.vectorize(
            #[inline(always)]
            || self.cover_at(simd, tiles),
        );
    }

    #[inline(always)]
    fn cover_at<S: Simd>(&mut self, simd: S, tiles: &mut Tiles) {
        for (row, across) in self.whole.take() {
            let row = &self.rows[row % MAX_ROWS];
            let (tile, farthest, _) = tiles.tile(row.first_tile + across);
            let lowest = row.lowest_in(across);
            cover_whole(simd, tile, row.over_tile(simd, across));
            if *farthest < lowest {
                *farthest = lowest;
            }
        }
        for (row, across) in self.some.take() {
            let row = &self.rows[row % MAX_ROWS];
            let column = (across * COLUMNS as u32) as i32;
            let starts = i32x16::from_slice(simd, &row.starts) - column;
            let stops = i32x16::from_slice(simd, &row.stops) - column;
            let (tile, farthest, closed) = tiles.tile(row.first_tile + across);
            let samples = masks_of_rows(simd, starts, stops);
            let closed = match closed {
                Some(closed) => u32x16::from_slice(simd, closed),
                None => u32x16::splat(simd, 0),
            };
            let rev_depth = row.over_tile(simd, across);
            cover_tile(simd, tile, farthest, [samples, closed], rev_depth);
        }
        self.row_count = 0;
    }
}

impl<S: Simd> RowDepth<S> {
    /// Creates it from the lower bound in the first sub-tile, and the changes per column and row.
    #[inline(always)]
    pub(super) fn new(simd: S, first: f32, [by_column, by_row]: [f32; 2], least: f32) -> RowDepth<S> {
        let [columns, rows] = &SUB_TILE_PLACES;
        let [columns, rows] = [f32x16::from_slice(simd, columns), f32x16::from_slice(simd, rows)];
        // That of a corner; the same operations as above, so that it is one of the numbers in `first`.
        let corner = |by: f32, places: usize| if by < 0.0 { by * places as f32 } else { 0.0 };
        let right = corner(by_column, COLUMNS - SUB_COLUMNS);
        let down = corner(by_row, ROWS - SUB_ROWS);
        RowDepth {
            first: (columns * by_column + rows * by_row) + first,
            lowest: (right + down) + first,
            by_tile: by_column * COLUMNS as f32,
            least,
        }
    }

    /// Returns it for a row in which the reversed depth is greater by `change`.
    #[inline(always)]
    pub(super) fn moved(&self, change: f32) -> RowDepth<S> {
        RowDepth {
            first: self.first + change,
            lowest: self.lowest + change,
            ..*self
        }
    }
}

impl TileRow {
    /// Returns the lower bound of reversed depth in each sub-tile of a tile, counted from the first, as bits.
    #[inline(always)]
    fn over_tile<S: Simd>(&self, simd: S, across: u32) -> u32x16<S> {
        let by_tile = self.by_tile * across as f32;
        ((f32x16::from_slice(simd, &self.first) + by_tile) * (1.0 - ROUNDING))
            .max(f32x16::splat(simd, self.least))
            .bitcast()
    }

    /// Returns the minimum of [`TileRow::over_tile`]. It is that of the sub-tile with the minimum of `first`, because
    /// rounding keeps the order of numbers.
    #[inline(always)]
    fn lowest_in(&self, across: u32) -> f32 {
        let rev_depth = (self.lowest + self.by_tile * across as f32) * (1.0 - ROUNDING);
        if rev_depth > self.least {
            rev_depth
        } else {
            self.least
        }
    }
}

/// Merges coverage as [`Tile::cover`] does, for all sub-tiles of a tile, and updates the tile's `farthest`.
#[inline(always)]
fn cover_tile<S: Simd>(
    simd: S,
    tile: &mut Tile,
    farthest: &mut f32,
    [covered, closed]: [u32x16<S>; 2],
    rev_depth: u32x16<S>,
) {
    let all = u32x16::splat(simd, u32::MAX);
    let none = u32x16::splat(simd, 0);
    let mask = u32x16::from_slice(simd, &tile.mask);
    let reference = u32x16::from_slice(simd, &tile.reference);
    let working = u32x16::from_slice(simd, &tile.working);
    let nearer = rev_depth.simd_gt(reference);
    if !nearer.any_true() {
        // The tile was listed because [`cover_whole`] only bounds `farthest`.
        *farthest = f32::from_bits(reference.reduce_min());
        return;
    }
    let acts = nearer & covered.simd_gt(none);
    let fresh = covered | closed;
    let before = rev_depth.simd_ge(working);
    let (near, far) = (rev_depth.max(working), rev_depth.min(working));
    let near_mask = before.select(fresh, mask);
    let either = mask | fresh;
    let alone = either.simd_eq(near_mask);
    let full = either.simd_eq(all);
    let discards = (near + reference).simd_gt(far + far);
    let next_mask = (discards | full).select(near_mask, either);
    let next_mask = (alone & full).select(none, next_mask);
    let next_working = (discards | alone | full).select(near, far);
    let changes = acts & full;
    acts.select(next_mask, mask).store_slice(&mut tile.mask);
    acts.select(next_working, working).store_slice(&mut tile.working);
    let next = changes.select(alone.select(near, far), reference);
    next.store_slice(&mut tile.reference);
    *farthest = f32::from_bits(next.reduce_min());
}

/// Merges coverage as [`cover_tile`] does, for a tile whose samples are all covered.
#[inline(always)]
fn cover_whole<S: Simd>(simd: S, tile: &mut Tile, rev_depth: u32x16<S>) {
    let mask = u32x16::from_slice(simd, &tile.mask);
    let reference = u32x16::from_slice(simd, &tile.reference);
    let working = u32x16::from_slice(simd, &tile.working);
    let before = rev_depth.simd_ge(working);
    let mask = before.select(u32x16::splat(simd, 0), mask);
    mask.store_slice(&mut tile.mask);
    working.max(rev_depth).store_slice(&mut tile.working);
    reference.max(rev_depth).store_slice(&mut tile.reference);
}

/// Returns the coverage masks of a tile from runs in sixteen rows, relative to the tile's first column.
#[inline(always)]
fn masks_of_rows<S: Simd>(simd: S, starts: i32x16<S>, stops: i32x16<S>) -> u32x16<S> {
    let rows = bits_from(simd, starts) & !bits_from(simd, stops);
    // Transposes bytes: rows of 4 × 8 samples become sub-tiles of 4 rows.
    rows.bitcast::<u8x64<S>>()
        .swizzle_dyn_within_blocks(u8x64::from_slice(simd, &TRANSPOSED))
        .bitcast()
}

/// Returns the bits from a column on, clamped to 0..=32.
#[inline(always)]
fn bits_from<S: Simd>(simd: S, column: i32x16<S>) -> u32x16<S> {
    let [zero, last] = [i32x16::splat(simd, 0), i32x16::splat(simd, COLUMNS as i32 - 1)];
    let bits = u32x16::splat(simd, u32::MAX) << column.max(zero).min(last).bitcast::<u32x16<S>>();
    column.simd_gt(last).select(u32x16::splat(simd, 0), bits)
}

const TRANSPOSED: [u8; 4 * ROWS] = {
    let mut order = [0; 4 * ROWS];
    let mut place = 0;
    while place < order.len() {
        order[place] = ((place % 4) * 4 + place / 4 % 4) as u8;
        place += 1;
    }
    order
};
