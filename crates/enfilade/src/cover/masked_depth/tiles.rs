//! The tiles of the screen: sixteen sub-tiles each, with a coverage mask and two depth layers, and the rule that merges
//! new coverage.
//!
//! Invariants of a sub-tile: at every sample, something is at least as near as `reference`; at the samples of the mask,
//! something is at least as near as `working`. New coverage would be a third layer, so one that is not the nearest is
//! discarded or merged; every choice keeps the invariants.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.2. The paper
//!     discards the working layer if it is farther from the new one than from the reference, by difference of depths.
//!     Here the ratio of reversed depths decides, whichever of the two came first, and a layer with nothing behind it
//!     is never discarded, unless it is farther than 10¹⁹.
//! Cost: O(1) for each sub-tile; [`runs`](super::runs) processes all sixteen at once.
//! Conservative: a stored reversed depth is never above the true one.

use super::LANES;
use crate::cover::show::{push, show_rows};
use crate::raster::{BAND, Band};
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverSpan, HiddenBy};
use crate::view::passage::Passage;
use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use std::ops::Range;

/// Columns and rows of a tile: two bands.
pub(super) const COLUMNS: usize = 32;
pub(super) const ROWS: usize = 2 * BAND;
/// Columns and rows of a sub-tile.
pub(super) const SUB_COLUMNS: usize = 8;
pub(super) const SUB_ROWS: usize = 4;
/// Sub-tiles per row of a tile.
pub(super) const ACROSS: usize = COLUMNS / SUB_COLUMNS;
/// Sub-tiles of a tile, in row-major order.
pub(super) const SUB_TILES: usize = 16;
/// Sub-tiles in one band of a tile.
pub(super) const SUB_TILES_OF_BAND: usize = SUB_TILES / 2;

/// Columns and rows of samples to the left of and above each sub-tile of a tile.
pub(super) const SUB_TILE_PLACES: [[f32; SUB_TILES]; 2] = {
    let mut places = [[0.0; SUB_TILES]; 2];
    let mut sub = 0;
    while sub < SUB_TILES {
        places[0][sub] = (sub % ACROSS * SUB_COLUMNS) as f32;
        places[1][sub] = (sub / ACROSS * SUB_ROWS) as f32;
        sub += 1;
    }
    places
};

/// Coverage masks of the sub-tiles in one band, and of those of a tile: bit 8·y + x for each sample.
type Masks = [u32; SUB_TILES_OF_BAND];
pub(super) type TileMasks = [u32; SUB_TILES];

/// Reversed depths of the sub-tiles in one band.
pub(super) type RevDepth = [f32; SUB_TILES_OF_BAND];

/// Depth and coverage of 32×16 samples; three cache lines.
///
/// Stores reversed depths as bits: they are not negative, so the bits sort like the numbers. Each array is a vector of
/// the wide kernels: with one line per row of sub-tiles instead, small faces were as fast, and wide triangles took 14 to
/// 20 % longer.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Tile {
    /// Coverage masks: the samples of the working layer.
    pub(super) mask: TileMasks,
    /// Reference layer: a lower bound of reversed depth at every sample; infinite if all samples are closed.
    pub(super) reference: [u32; SUB_TILES],
    /// Working layer: a lower bound of reversed depth at the samples of the mask; equal to `reference` if the mask is
    /// empty.
    pub(super) working: [u32; SUB_TILES],
}

impl Tile {
    /// A tile without open samples.
    const CLOSED: Tile = Tile {
        mask: [0; SUB_TILES],
        reference: [f32::INFINITY.to_bits(); SUB_TILES],
        working: [f32::INFINITY.to_bits(); SUB_TILES],
    };

    /// Returns a tile with nothing in its open samples.
    fn empty(closed: &TileMasks) -> Tile {
        let mut tile = Tile::CLOSED;
        for (sub, &closed) in closed.iter().enumerate() {
            if closed != u32::MAX {
                tile.reference[sub] = 0;
                tile.working[sub] = 0;
            }
        }
        tile
    }

    /// Returns the minimum of the reference layers: what has a smaller reversed depth is hidden in the whole tile.
    #[inline(always)]
    pub(super) fn farthest(&self) -> f32 {
        let mut farthest = u32::MAX;
        for reference in self.reference {
            farthest = farthest.min(reference);
        }
        f32::from_bits(farthest)
    }

    /// Merges coverage into a sub-tile: at the samples `covered`, something is at least as near as `rev_depth` (bits of
    /// a finite number). Coverage includes the samples `closed`. Returns the reference layer before if it
    /// changed.
    ///
    /// This is the specification of [`cover_tile`](super::runs::cover_tile), which merges all sixteen at once.
    #[inline(always)]
    pub(super) fn cover(&mut self, sub: usize, [covered, closed]: [u32; 2], rev_depth: u32) -> Option<u32> {
        let [mask, reference, working] = [self.mask[sub], self.reference[sub], self.working[sub]];
        // A face beside the sub-tile must not displace a layer.
        if rev_depth <= reference || covered == 0 {
            return None;
        }
        let fresh = covered | closed;
        // The nearer of the working and the new layer is kept as it is; the other keeps the remaining samples.
        let before = rev_depth >= working;
        let near = if before { rev_depth } else { working };
        let far = if before { working } else { rev_depth };
        let near_mask = if before { fresh } else { mask };
        let either = mask | fresh;
        let alone = either == near_mask;
        if either == u32::MAX {
            // Both layers together cover all samples, so the farther one becomes the reference.
            self.mask[sub] = if alone { 0 } else { near_mask };
            self.reference[sub] = if alone { near } else { far };
            self.working[sub] = near;
            return Some(reference);
        }
        // Otherwise discard the farther layer if the ratio to the reference is smaller than to the nearer layer (bits
        // of floats approximate logarithms), else merge the two.
        let discards = near + reference > 2 * far;
        self.mask[sub] = if discards { near_mask } else { either };
        self.working[sub] = if discards | alone { near } else { far };
        None
    }

    /// Returns `true` if geometry with reversed depth `rev_depth` may be visible at any of `samples` in the upper (0)
    /// or lower (1) band. Equal depths are visible.
    #[inline(always)]
    fn sees(&self, band: usize, samples: &Masks, rev_depth: &RevDepth) -> bool {
        let mut any = false;
        for (sub, (&samples, &rev_depth)) in (band * SUB_TILES_OF_BAND..).zip(samples.iter().zip(rev_depth)) {
            let beyond_reference = rev_depth < f32::from_bits(self.reference[sub]);
            let beyond_working = rev_depth < f32::from_bits(self.working[sub]);
            let outside_mask = samples & !self.mask[sub] != 0;
            any |= (samples != 0) & !beyond_reference & (outside_mask | !beyond_working);
        }
        any
    }

    /// Returns those of `samples` of a sub-tile at which geometry with reversed depth `rev_depth` may be visible.
    #[inline(always)]
    fn passing_in(&self, sub: usize, samples: u32, rev_depth: f32) -> u32 {
        let beyond_reference = rev_depth < f32::from_bits(self.reference[sub]);
        let beyond_working = rev_depth < f32::from_bits(self.working[sub]);
        let hidden = if beyond_working { self.mask[sub] } else { 0 };
        if beyond_reference { 0 } else { samples & !hidden }
    }

    /// Returns `true` if the sample belongs to the working layer.
    #[inline(always)]
    fn is_working(&self, x: usize, y: usize) -> bool {
        self.mask[sub_tile(x, y)] & bit(x, y) != 0
    }

    /// Returns the reversed depth stored at an open sample.
    #[inline(always)]
    fn rev_depth_at(&self, x: usize, y: usize) -> f32 {
        let sub = sub_tile(x, y);
        f32::from_bits(if self.is_working(x, y) {
            self.working[sub]
        } else {
            self.reference[sub]
        })
    }
}

fn sub_tile(x: usize, y: usize) -> usize {
    y / SUB_ROWS * ACROSS + x / SUB_COLUMNS
}

fn bit(x: usize, y: usize) -> u32 {
    1 << (y % SUB_ROWS * SUB_COLUMNS + x % SUB_COLUMNS)
}

/// The part of a band in each tile.
pub(super) struct BandTiles<'a> {
    band: &'a Band,
    /// Columns of the screen that any row covers, and those that all rows cover.
    any: [u16; 2],
    all: [u16; 2],
}

impl BandTiles<'_> {
    #[inline(always)]
    pub(super) fn new(band: &Band) -> BandTiles<'_> {
        let [mut any, mut all] = [[u16::MAX, 0], [0, u16::MAX]];
        for [start, end] in band.runs {
            if start < end {
                any = [any[0].min(start), any[1].max(end)];
            }
            all = [all[0].max(start), all[1].min(end)];
        }
        BandTiles { band, any, all }
    }

    /// Returns the columns of tiles that contain a sample of the band, counted from the left of the screen.
    #[inline(always)]
    pub(super) fn tiles(&self) -> Range<usize> {
        tiles(self.any[0], self.any[1], COLUMNS)
    }

    /// Returns the coverage masks of the band in one column of tiles.
    #[inline(always)]
    pub(super) fn samples(&self, column: usize) -> Masks {
        let x = COLUMNS * column;
        if usize::from(self.all[0]) <= x && x + COLUMNS <= usize::from(self.all[1]) {
            return [u32::MAX; SUB_TILES_OF_BAND];
        }
        let mut rows = [0; BAND];
        for (row, [x0, x1]) in rows.iter_mut().zip(self.band.runs) {
            *row = columns_within(x0, x1, x);
        }
        let mut masks = [0; SUB_TILES_OF_BAND];
        for (sub, mask) in masks.iter_mut().enumerate() {
            let [across, down] = [sub % ACROSS, sub / ACROSS];
            for row in 0..SUB_ROWS {
                let byte = rows[SUB_ROWS * down + row] >> (SUB_COLUMNS * across) & 0xFF;
                *mask |= byte << (SUB_COLUMNS * row);
            }
        }
        masks
    }
}

/// Returns the tiles, `side` samples long, that overlap the rows or columns `start..end`.
pub(super) fn tiles(start: u16, end: u16, side: usize) -> Range<usize> {
    usize::from(start) / side..usize::from(end).div_ceil(side)
}

/// Returns the coverage masks of a rectangle in one band of a tile, from its columns and rows.
#[inline(always)]
pub(super) fn masks_of_rect(columns: u32, rows: [u32; 2]) -> Masks {
    let mut masks = [0; SUB_TILES_OF_BAND];
    for (sub, mask) in masks.iter_mut().enumerate() {
        let [across, down] = [sub % ACROSS, sub / ACROSS];
        *mask = ((columns >> (SUB_COLUMNS * across) & 0xFF) * 0x0101_0101) & rows[down];
    }
    masks
}

/// Returns a bit mask of the columns `x0..x1` of the screen inside the tile that begins at column `x`.
#[inline(always)]
pub(super) fn columns_within(x0: u16, x1: u16, x: usize) -> u32 {
    ((1_u64 << within(x1, x)) - (1_u64 << within(x0, x))) as u32
}

/// Returns bit masks of the rows `y0..y1` of the screen inside the band that begins at row `y`: for the upper and the
/// lower sub-tiles, eight bits per row.
#[inline(always)]
pub(super) fn rows_within(y0: u16, y1: u16, y: usize) -> [u32; 2] {
    let bits = |row: u16| 8 * (i32::from(row) - y as i32).clamp(0, BAND as i32) as u128;
    let rows = (1_u128 << bits(y1)) - (1_u128 << bits(y0));
    [rows as u32, (rows >> 32) as u32]
}

/// Converts a column of the screen to one of the tile that begins at column `x`, clamped to 0..=32.
#[inline(always)]
fn within(column: u16, x: usize) -> u32 {
    (i32::from(column) - x as i32).clamp(0, COLUMNS as i32) as u32
}

/// Returns the first row of samples of a row of tiles, clamped to the largest u16.
fn first_sample(row: usize) -> u16 {
    (row * ROWS).min(u16::MAX.into()) as u16
}

/// The tiles up to the last row and column of a passage's rectangle, in row-major order from the top left corner of the
/// screen.
#[derive(Default)]
pub(super) struct Grid {
    pub(super) rect: Rect,
    pub(super) columns: usize,
    pub(super) tiles: Vec<Tile>,
    /// A lower bound of [`Tile::farthest`] of each tile; decides most queries.
    pub(super) farthest: Vec<f32>,
    /// Samples of each tile outside the aperture: queries ignore them, and any coverage includes them.
    closed: Vec<TileMasks>,
    /// Whether only some samples are closed in any sub-tile: `closed` is not needed otherwise.
    is_partly_closed: bool,
    open: [Vec<[u16; 2]>; BAND],
}

/// Rows of tiles that one thread rasterizes into.
pub(super) struct Tiles<'a> {
    /// Their samples inside the passage's rectangle.
    pub(super) rect: Rect,
    pub(super) columns: usize,
    /// Number of rows of tiles above them, from the top of the screen.
    pub(super) first_row: usize,
    pub(super) tiles: &'a mut [Tile],
    pub(super) farthest: &'a mut [f32],
    /// [`Grid::closed`]; without tiles if it is not needed.
    closed: &'a [TileMasks],
}

/// Rows of tiles for occlusion tests.
#[derive(Clone, Copy)]
pub(super) struct TilesView<'a> {
    pub(super) columns: usize,
    /// Number of rows of tiles above them.
    pub(super) first_row: usize,
    tiles: &'a [Tile],
    pub(super) farthest: &'a [f32],
    closed: &'a [TileMasks],
}

impl TilesView<'_> {
    /// Returns `true` if geometry with reversed depth `rev_depth` may be visible at any open one of `samples` in the
    /// upper (0) or lower (1) band of a tile. Equal depths are visible.
    #[inline(always)]
    pub(super) fn sees_in(&self, index: usize, band: usize, samples: &Masks, rev_depth: &RevDepth) -> bool {
        let tile = &self.tiles[index];
        let Some(closed) = self.closed.get(index) else {
            return tile.sees(band, samples, rev_depth);
        };
        let mut open = *samples;
        for (open, closed) in open.iter_mut().zip(&closed[band * SUB_TILES_OF_BAND..]) {
            *open &= !closed;
        }
        tile.sees(band, &open, rev_depth)
    }
}

impl<'a> Tiles<'a> {
    /// Splits off the tiles below the first `rows` rows of tiles, or below the last row if there are fewer.
    pub(super) fn split(self, rows: usize) -> (Tiles<'a>, Tiles<'a>) {
        let Tiles {
            rect,
            columns,
            first_row,
            tiles,
            farthest,
            closed,
        } = self;
        let border = first_sample(first_row + rows);
        let count = (rows * columns).min(tiles.len());
        let (upper, lower) = tiles.split_at_mut(count);
        let (farthest_above, farthest_below) = farthest.split_at_mut(count);
        let (closed_above, closed_below) = closed.split_at(count.min(closed.len()));
        let above = Tiles {
            rect: Rect {
                y1: rect.y1.min(border),
                ..rect
            },
            columns,
            first_row,
            tiles: upper,
            farthest: farthest_above,
            closed: closed_above,
        };
        let below = Tiles {
            rect: Rect {
                y0: rect.y0.max(border),
                ..rect
            },
            columns,
            first_row: first_row + rows,
            tiles: lower,
            farthest: farthest_below,
            closed: closed_below,
        };
        (above, below)
    }

    /// Splits the tiles into strips of `rows` rows of tiles each; the last may have fewer.
    pub(super) fn strips(self, rows: usize) -> impl Iterator<Item = Tiles<'a>> {
        let mut left = Some(self);
        std::iter::from_fn(move || {
            let (strip, below) = left.take()?.split(rows);
            left = (!below.rect.is_empty()).then_some(below);
            Some(strip)
        })
    }

    /// Returns a tile, its lower bound of [`Tile::farthest`], and its closed samples if any sub-tile has some.
    #[inline(always)]
    pub(super) fn tile(&mut self, number: u32) -> (&mut Tile, &mut f32, Option<&TileMasks>) {
        let number = number as usize;
        (
            &mut self.tiles[number],
            &mut self.farthest[number],
            self.closed.get(number),
        )
    }

    /// Returns [`Tile::farthest`] of sixteen tiles, starting at index `first`; infinite after the last tile.
    #[inline(always)]
    pub(super) fn sixteen_farthest<S: Simd>(&self, simd: S, first: usize) -> f32x16<S> {
        let farthest = &self.farthest[first..];
        if let Some(sixteen) = farthest.first_chunk::<LANES>() {
            return f32x16::from_slice(simd, sixteen);
        }
        let mut last = [f32::INFINITY; LANES];
        last[..farthest.len()].copy_from_slice(farthest);
        f32x16::from_slice(simd, &last)
    }

    /// Returns a view for occlusion tests.
    pub(super) fn view(&self) -> TilesView<'_> {
        TilesView {
            columns: self.columns,
            first_row: self.first_row,
            tiles: self.tiles,
            farthest: self.farthest,
            closed: self.closed,
        }
    }

    /// Returns `true` if everything with reversed depth up to `nearest` is hidden in these tiles, by [`Tile::farthest`]
    /// alone. Rows are counted from the first of these.
    #[inline(always)]
    pub(super) fn are_nearer(&self, columns: Range<usize>, mut rows: Range<usize>, nearest: f32) -> bool {
        rows.all(|row| {
            let first = row * self.columns;
            let mut hides = true;
            for &farthest in &self.farthest[first + columns.start..first + columns.end] {
                hides &= nearest < farthest;
            }
            hides
        })
    }

    /// Returns `true` if everything with reversed depth up to `nearest` is hidden at all samples of `rect`, by
    /// [`Tile::farthest`] alone; `false` when unsure.
    #[inline(always)]
    pub(super) fn hides(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        if rect.is_empty() {
            return true;
        }
        let rows = tiles(rect.y0, rect.y1, ROWS);
        let rows = rows.start - self.first_row..rows.end - self.first_row;
        self.are_nearer(tiles(rect.x0, rect.x1, COLUMNS), rows, nearest)
    }
}

impl Grid {
    /// Returns all tiles.
    pub(super) fn all(&mut self) -> Tiles<'_> {
        Tiles {
            rect: self.rect,
            columns: self.columns,
            first_row: 0,
            tiles: &mut self.tiles,
            farthest: &mut self.farthest,
            closed: if self.is_partly_closed { &self.closed } else { &[] },
        }
    }

    /// Returns the number of rows of tiles.
    pub(super) fn rows(&self) -> usize {
        usize::from(self.rect.y1).div_ceil(ROWS)
    }

    /// Clears the tiles of the aperture's rectangle: opens the samples of the aperture and closes all others.
    pub(super) fn clear(&mut self, passage: &Passage) {
        self.rect = passage.aperture.rect();
        let Rect { x0, y0, x1, y1 } = self.rect;
        self.columns = usize::from(x1).div_ceil(COLUMNS);
        let needed = self.columns * usize::from(y1).div_ceil(ROWS);
        if self.tiles.len() < needed {
            self.tiles.resize(needed, Tile::CLOSED);
            self.farthest.resize(needed, f32::INFINITY);
            self.closed.resize(needed, [u32::MAX; SUB_TILES]);
        }
        self.is_partly_closed = false;
        for row in tiles(y0, y1, ROWS) {
            for column in tiles(x0, x1, COLUMNS) {
                self.closed[row * self.columns + column] = [u32::MAX; SUB_TILES];
            }
            for band in 0..ROWS / BAND {
                self.open_band(passage, row, band);
            }
            for column in tiles(x0, x1, COLUMNS) {
                let index = row * self.columns + column;
                let closed = &self.closed[index];
                self.is_partly_closed |= closed.iter().any(|&closed| closed != 0 && closed != u32::MAX);
                self.tiles[index] = Tile::empty(closed);
                self.farthest[index] = self.tiles[index].farthest();
            }
        }
    }

    /// Returns the closed samples of a sub-tile, unless all are.
    #[inline(always)]
    pub(super) fn closed_in(&self, index: usize, sub: usize) -> u32 {
        if self.is_partly_closed {
            self.closed[index][sub]
        } else {
            0
        }
    }

    /// Returns those open ones of `samples` of a sub-tile at which geometry with reversed depth `rev_depth` may be
    /// visible.
    #[inline(always)]
    pub(super) fn passing_in(&self, [index, sub]: [usize; 2], samples: u32, rev_depth: f32) -> u32 {
        self.tiles[index].passing_in(sub, samples & !self.closed_in(index, sub), rev_depth)
    }

    /// Returns a view for occlusion tests.
    #[inline(always)]
    pub(super) fn view(&self) -> TilesView<'_> {
        TilesView {
            columns: self.columns,
            first_row: 0,
            tiles: &self.tiles,
            farthest: &self.farthest,
            closed: if self.is_partly_closed { &self.closed } else { &[] },
        }
    }

    /// Returns the reversed depth stored at a sample; infinite if the sample is closed.
    #[inline(always)]
    pub(super) fn rev_depth_at(&self, x: usize, y: usize) -> f32 {
        let index = y / ROWS * self.columns + x / COLUMNS;
        let [x, y] = [x % COLUMNS, y % ROWS];
        if self.closed_in(index, sub_tile(x, y)) & bit(x, y) != 0 {
            return f32::INFINITY;
        }
        self.tiles[index].rev_depth_at(x, y)
    }

    /// Opens the samples of the aperture in one band of a row of tiles.
    fn open_band(&mut self, passage: &Passage, row: usize, band: usize) {
        let y = (row * ROWS + band * BAND) as u16;
        for (y, open) in (y..).zip(&mut self.open) {
            open.clear();
            if (self.rect.y0..self.rect.y1).contains(&y) {
                passage.aperture.open_in_row(y, open);
            }
        }
        // Opens the first run of each row, then the second of each, and so on.
        let most = self.open.iter().map(Vec::len).max().unwrap_or(0);
        for number in 0..most {
            let runs = std::array::from_fn(|row| self.open[row].get(number).copied().unwrap_or([0; 2]));
            let runs = Band { y, runs };
            let across = BandTiles::new(&runs);
            for column in across.tiles() {
                let index = row * self.columns + column;
                let closed = &mut self.closed[index][band * SUB_TILES_OF_BAND..];
                for (closed, samples) in closed.iter_mut().zip(across.samples(column)) {
                    *closed &= !samples;
                }
            }
        }
    }
}

impl Grid {
    pub(super) fn show(&self, passage: &Passage, canvas: &mut dyn Canvas) {
        show_rows(passage, canvas, |y, [x0, x1], spans| {
            let [row, y] = [usize::from(y) / ROWS, usize::from(y) % ROWS];
            for x in x0..x1 {
                let [column, within] = [usize::from(x) / COLUMNS, usize::from(x) % COLUMNS];
                let index = row * self.columns + column;
                let tile = &self.tiles[index];
                let sub = y / SUB_ROWS * ACROSS + within / SUB_COLUMNS;
                let rev_depth = self.rev_depth_at(usize::from(x), row * ROWS + y);
                let by = if tile.is_working(within, y) {
                    HiddenBy::Working
                } else if rev_depth > 0.0 {
                    HiddenBy::Reference
                } else {
                    HiddenBy::Nothing
                };
                let cell = (index * SUB_TILES + sub) as u32;
                push(
                    spans,
                    CoverSpan {
                        x0: x,
                        x1: x + 1,
                        cell,
                        by,
                        rev_depth: [rev_depth; 2],
                    },
                );
            }
        });
    }
}
