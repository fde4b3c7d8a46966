//! Covers runs of samples in a row of tiles, with the sixteen sub-tiles of a tile in SIMD lanes.
//!
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, sections 3.1 to 3.3.
//! Cost: O(tiles); a tile that is already nearer is rejected by one comparison.
//! Conservative: as [`Tile::cover`], the scalar specification.

use super::tiles::{ACROSS, COLUMNS, ROWS, SUB_COLUMNS, SUB_ROWS, SUB_TILES, Tile, Tiles};
use super::{COUNT, LANES};
use crate::raster::{Band, smaller};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u8x64, u32x16};

/// Runs of samples in the sixteen rows of a row of tiles.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Runs {
    /// First column and end column (exclusive) of each row; 0 and 0 for a row without samples.
    starts: [i32; ROWS],
    stops: [i32; ROWS],
    /// Columns that are covered in all rows; empty if unknown.
    whole: [i32; 2],
    row: u32,
    /// Index of their [`Slopes`] in the queue.
    slopes: u32,
}

/// Queue of runs to be covered.
///
/// Works in three passes, each without branches in its inner loop: collect runs, find the tiles they overlap, cover
/// these tiles. So a mispredicted branch does not delay the next step.
#[derive(Default)]
pub(super) struct RunQueue {
    /// Depth planes, one per face.
    slopes: Vec<Slopes>,
    runs: Vec<Runs>,
    /// Tiles of which some samples are covered, and tiles that are covered entirely.
    some: TileRuns,
    whole: TileRuns,
}

/// Pairs of a tile and the runs that overlap it, by index.
struct TileRuns {
    count: usize,
    tiles: [u32; MAX_TILE_RUNS],
    runs: [u32; MAX_TILE_RUNS],
}

/// Number of queued runs from which on they are covered (a large face may exceed it), and the maximum number of pairs.
const MANY_RUNS: usize = 64;
const MAX_TILE_RUNS: usize = 256;

impl Default for TileRuns {
    fn default() -> TileRuns {
        TileRuns {
            count: 0,
            tiles: [0; MAX_TILE_RUNS],
            runs: [0; MAX_TILE_RUNS],
        }
    }
}

impl TileRuns {
    /// Adds the tiles selected by `which`, of sixteen.
    #[inline(always)]
    fn push<S: Simd>(&mut self, which: mask32x16<S>, tiles: u32x16<S>, runs: u32x16<S>) {
        let start = self.count.min(MAX_TILE_RUNS - LANES);
        tiles
            .compress(which)
            .store_slice(&mut self.tiles[start..start + LANES]);
        runs.store_slice(&mut self.runs[start..start + LANES]);
        self.count = start + which.to_bitmask().count_ones() as usize;
    }

    fn is_full(&self) -> bool {
        self.count > MAX_TILE_RUNS - LANES
    }

    /// Removes and returns all pairs of tile and runs.
    #[inline(always)]
    fn take(&mut self) -> impl Iterator<Item = (u32, u32)> {
        let count = std::mem::take(&mut self.count).min(MAX_TILE_RUNS);
        let runs = self.runs[..count].iter().copied();
        self.tiles[..count].iter().copied().zip(runs)
    }
}

impl RunQueue {
    /// Returns `true` if the queue should be covered now.
    #[inline(always)]
    pub(super) fn are_many(&self) -> bool {
        self.runs.len() >= MANY_RUNS
    }

    /// Begins a face; the runs pushed next belong to it.
    #[inline(always)]
    pub(super) fn begin(&mut self, slopes: &Slopes) {
        self.slopes.push(*slopes);
    }

    /// Queues the runs of a row of tiles. The columns `whole` are covered in all rows.
    #[inline(always)]
    pub(super) fn push(&mut self, row: usize, [starts, stops]: [[i32; ROWS]; 2], whole: [i32; 2]) {
        self.runs.push(Runs {
            starts,
            stops,
            whole,
            row: row as u32,
            slopes: self.slopes.len() as u32 - 1,
        });
    }

    /// Queues the runs of a band.
    pub(super) fn push_band(&mut self, band: &Band) {
        let y = usize::from(band.y);
        let [mut starts, mut stops] = [[0; ROWS]; 2];
        let rows = starts.iter_mut().zip(&mut stops).skip(y % ROWS);
        for ((start, stop), run) in rows.zip(band.runs) {
            if run[0] < run[1] {
                [*start, *stop] = run.map(i32::from);
            }
        }
        self.push(y / ROWS, [starts, stops], [0; 2]);
    }

    /// Covers all queued runs and empties the queue. Not inlined, because it is long and has several callers.
    pub(super) fn cover<S: Simd>(&mut self, simd: S, tiles: &mut Tiles) {
        simd.vectorize(
            #[inline(always)]
            || self.cover_at(simd, tiles),
        );
    }

    #[inline(always)]
    fn cover_at<S: Simd>(&mut self, simd: S, tiles: &mut Tiles) {
        const STEP: i32 = (LANES * COLUMNS) as i32;
        let far = i32x16::splat(simd, i32::MAX);
        let lanes = u32x16::from_slice(simd, &COUNT);
        let columns = lanes.bitcast::<i32x16<S>>() * COLUMNS as i32;
        for number in 0..self.runs.len() {
            let runs = &self.runs[number];
            let starts = i32x16::from_slice(simd, &runs.starts);
            let stops = i32x16::from_slice(simd, &runs.stops);
            let first = starts.simd_lt(stops).select(starts, far).reduce_min();
            let (end, whole) = (stops.reduce_max(), runs.whole);
            let greatest = f32x16::splat(simd, self.slopes[runs.slopes as usize].greatest);
            let row = (runs.row as usize - tiles.first_row) * tiles.columns;
            let mut column = first & -(COLUMNS as i32);
            while column < end {
                let tile = row + column as usize / COLUMNS;
                let columns = columns + column;
                // Skip tiles that are already nearer.
                let farthest = tiles.sixteen_farthest(simd, tile);
                let seen = farthest.simd_lt(greatest) & columns.simd_lt(end);
                let all = columns.simd_ge(whole[0]) & (columns + COLUMNS as i32).simd_le(whole[1]);
                let (at, number) = (lanes + tile as u32, u32x16::splat(simd, number as u32));
                self.some.push(seen & !all, at, number);
                self.whole.push(seen & all, at, number);
                if self.some.is_full() || self.whole.is_full() {
                    self.cover_tile_runs(simd, tiles);
                }
                column += STEP;
            }
        }
        self.cover_tile_runs(simd, tiles);
        self.slopes.clear();
        self.runs.clear();
    }

    #[inline(always)]
    fn cover_tile_runs<S: Simd>(&mut self, simd: S, tiles: &mut Tiles) {
        let (slopes, runs) = (&self.slopes, &self.runs);
        for (number, of) in self.whole.take() {
            let runs = &runs[of as usize];
            let column = runs.column_of(number, tiles);
            let row = (runs.row * ROWS as u32) as i32;
            let rev_depth = slopes[runs.slopes as usize].over_tile(simd, [column, row]);
            let (tile, farthest) = tiles.tile(number);
            cover_whole(simd, tile, farthest, rev_depth);
        }
        for (number, of) in self.some.take() {
            let runs = &runs[of as usize];
            let column = runs.column_of(number, tiles);
            let row = (runs.row * ROWS as u32) as i32;
            let starts = i32x16::from_slice(simd, &runs.starts) - column;
            let stops = i32x16::from_slice(simd, &runs.stops) - column;
            let rev_depth = slopes[runs.slopes as usize].over_tile(simd, [column, row]);
            let (tile, farthest) = tiles.tile(number);
            cover_tile(
                simd,
                tile,
                farthest,
                masks_of_rows(simd, starts, stops),
                rev_depth,
            );
        }
    }
}

impl Runs {
    /// Returns the first column of samples of a tile in this row, by the tile's index.
    #[inline(always)]
    fn column_of(&self, tile: u32, tiles: &Tiles) -> i32 {
        let first = (self.row as usize - tiles.first_row) * tiles.columns;
        ((tile as usize - first) * COLUMNS) as i32
    }
}

/// Merges coverage as [`Tile::cover`] does, for all sub-tiles of a tile, and updates the tile's `farthest`.
#[inline(always)]
fn cover_tile<S: Simd>(
    simd: S,
    tile: &mut Tile,
    farthest: &mut f32,
    covered: u32x16<S>,
    rev_depth: u32x16<S>,
) {
    let all = u32x16::splat(simd, u32::MAX);
    let none = u32x16::splat(simd, 0);
    let mask = u32x16::from_slice(simd, &tile.mask);
    let reference = u32x16::from_slice(simd, &tile.reference);
    let working = u32x16::from_slice(simd, &tile.working);
    let closed = u32x16::from_slice(simd, &tile.closed);
    let acts = rev_depth.simd_gt(reference) & covered.simd_gt(none);
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
fn cover_whole<S: Simd>(simd: S, tile: &mut Tile, farthest: &mut f32, rev_depth: u32x16<S>) {
    let mask = u32x16::from_slice(simd, &tile.mask);
    let reference = u32x16::from_slice(simd, &tile.reference);
    let working = u32x16::from_slice(simd, &tile.working);
    let before = rev_depth.simd_ge(working);
    let mask = before.select(u32x16::splat(simd, 0), mask);
    mask.store_slice(&mut tile.mask);
    working.max(rev_depth).store_slice(&mut tile.working);
    let next = reference.max(rev_depth);
    next.store_slice(&mut tile.reference);
    *farthest = f32::from_bits(next.reduce_min());
}

/// Lower bound of a face's reversed depth in each sub-tile.
#[derive(Clone, Copy)]
pub(super) struct Slopes {
    /// Offsets of the sub-tiles from the first one of their tile.
    by_sub_tile: [f32; SUB_TILES],
    /// Value in the first sub-tile of the tile at column and row 0; change per column and per row.
    at: f64,
    by_column: f64,
    by_row: f64,
    least: f32,
    greatest: f32,
}

/// Values below this, times the columns of any screen, fit f32.
const LARGE: f64 = 1e30;

/// Twice the relative rounding error of f32.
const ROUNDING: f32 = 1.0 / (1_u32 << 22) as f32;

impl Slopes {
    /// Creates it from a plane with reversed depth `at + by_column · column + by_row · row` at samples. The result is
    /// lowered by the rounding error of f32, at least `least` and nowhere above `greatest`.
    #[inline(always)]
    pub(super) fn new(at: f64, slopes: [f64; 2], [least, greatest]: [f32; 2]) -> Slopes {
        // If f32 could overflow or a value is NaN, only the minimum is known.
        let is_small = (at.abs() < LARGE) & (slopes[0].abs() < LARGE) & (slopes[1].abs() < LARGE);
        let (at, [by_column, by_row]) = if is_small { (at, slopes) } else { (0.0, [0.0; 2]) };
        // The minimum over a sub-tile is at a corner: at its first or last column and row.
        let across = smaller(by_column * (SUB_COLUMNS as f64 - 1.0), 0.0);
        let down = smaller(by_row * (SUB_ROWS as f64 - 1.0), 0.0);
        let rounding = (by_column.abs() * COLUMNS as f64 + by_row.abs() * ROWS as f64) * f64::from(ROUNDING);
        let mut by_sub_tile = [0.0; SUB_TILES];
        for (sub, rev_depth) in by_sub_tile.iter_mut().enumerate() {
            let [right, down] = [sub % ACROSS * SUB_COLUMNS, sub / ACROSS * SUB_ROWS];
            *rev_depth = right as f32 * by_column as f32 + down as f32 * by_row as f32;
        }
        Slopes {
            by_sub_tile,
            at: at + (0.5 * by_column + across) + (0.5 * by_row + down) - rounding,
            by_column,
            by_row,
            least,
            greatest,
        }
    }

    /// Returns the values in the tile that begins at a column and a row, as bits.
    #[inline(always)]
    fn over_tile<S: Simd>(&self, simd: S, [column, row]: [i32; 2]) -> u32x16<S> {
        let at = self.at + self.by_column * f64::from(column) + self.by_row * f64::from(row);
        ((f32x16::from_slice(simd, &self.by_sub_tile) + at as f32) * (1.0 - ROUNDING))
            .max(f32x16::splat(simd, self.least))
            .bitcast()
    }
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
