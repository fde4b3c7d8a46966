//! A tile: sixteen sub-tiles with a coverage mask and two depth layers each, and the rule that merges new coverage.
//!
//! Invariants of a sub-tile: at every sample, something is at least as near as `reference`; at the samples of the mask,
//! something is at least as near as `working`. New coverage would be a third layer, so one that is not the nearest is
//! discarded or merged; every choice keeps the invariants.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.2. The paper
//!     discards the working layer if it is farther from the new one than from the reference, by difference of depths.
//!     Here the ratio of reversed depths decides, whichever of the two came first, and a layer with nothing behind it
//!     is never discarded, unless it is farther than 10¹⁹.
//! Cost: O(1) for each sub-tile; [`rows`](super::rows) processes all sixteen at once.
//! Conservative: a stored reversed depth is never above the true one.

use crate::raster::{BAND, Band};
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

/// Coverage masks of the sub-tiles in one band: bit 8·y + x for each sample.
pub(super) type Masks = [u32; SUB_TILES_OF_BAND];

/// Reversed depths of the sub-tiles in one band.
pub(super) type RevDepth = [f32; SUB_TILES_OF_BAND];

/// Depth and coverage of 32×16 samples; four cache lines.
///
/// Stores reversed depths as bits: they are not negative, so the bits sort like the numbers.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Tile {
    /// Coverage masks: the samples of the working layer.
    pub(super) mask: [u32; SUB_TILES],
    /// Reference layer: a lower bound of reversed depth at every sample; infinite if no sample is open.
    pub(super) reference: [u32; SUB_TILES],
    /// Working layer: a lower bound of reversed depth at the samples of the mask; equal to `reference` if the mask is
    /// empty.
    pub(super) working: [u32; SUB_TILES],
    /// Samples outside the aperture: queries ignore them, and any coverage includes them.
    pub(super) closed: [u32; SUB_TILES],
}

impl Tile {
    /// A tile without open samples.
    pub(super) const CLOSED: Tile = Tile {
        mask: [0; SUB_TILES],
        reference: [f32::INFINITY.to_bits(); SUB_TILES],
        working: [f32::INFINITY.to_bits(); SUB_TILES],
        closed: [u32::MAX; SUB_TILES],
    };

    /// Opens samples of the upper (0) or lower (1) band, with nothing in them.
    #[inline(always)]
    pub(super) fn open(&mut self, band: usize, samples: &Masks) {
        for (sub, samples) in (band * SUB_TILES_OF_BAND..).zip(samples) {
            self.closed[sub] &= !samples;
            if self.closed[sub] != u32::MAX {
                self.reference[sub] = 0;
                self.working[sub] = 0;
            }
        }
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
    /// a finite number). Returns `true` if the reference layer changed.
    ///
    /// This is the specification of [`cover_tile`](super::rows::cover_tile), which merges all sixteen at once.
    #[inline(always)]
    pub(super) fn cover(&mut self, sub: usize, covered: u32, rev_depth: u32) -> bool {
        let [mask, reference, working] = [self.mask[sub], self.reference[sub], self.working[sub]];
        if rev_depth <= reference {
            return false;
        }
        let fresh = covered | self.closed[sub];
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
            return true;
        }
        // Otherwise discard the farther layer if the ratio to the reference is smaller than to the nearer layer (bits
        // of floats approximate logarithms), else merge the two.
        let discards = near + reference > 2 * far;
        self.mask[sub] = if discards { near_mask } else { either };
        self.working[sub] = if discards | alone { near } else { far };
        false
    }

    /// Returns `true` if geometry with reversed depth `rev_depth` may be visible at any of `samples` in the upper (0)
    /// or lower (1) band. Equal depths are visible.
    #[inline(always)]
    pub(super) fn sees(&self, band: usize, samples: &Masks, rev_depth: &RevDepth) -> bool {
        let mut any = false;
        for (sub, (samples, &rev_depth)) in (band * SUB_TILES_OF_BAND..).zip(samples.iter().zip(rev_depth)) {
            let samples = samples & !self.closed[sub];
            let beyond_reference = rev_depth < f32::from_bits(self.reference[sub]);
            let beyond_working = rev_depth < f32::from_bits(self.working[sub]);
            let outside_mask = samples & !self.mask[sub] != 0;
            any |= (samples != 0) & !beyond_reference & (outside_mask | !beyond_working);
        }
        any
    }

    /// Returns `true` if the sample belongs to the working layer.
    pub(super) fn is_working(&self, x: usize, y: usize) -> bool {
        self.mask[sub_tile(x, y)] & bit(x, y) != 0
    }

    /// Returns the reversed depth stored at a sample; infinite if the sample is closed.
    #[inline(always)]
    pub(super) fn rev_depth_at(&self, x: usize, y: usize) -> f32 {
        let (sub, bit) = (sub_tile(x, y), bit(x, y));
        f32::from_bits(if self.closed[sub] & bit != 0 {
            f32::INFINITY.to_bits()
        } else if self.mask[sub] & bit != 0 {
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
