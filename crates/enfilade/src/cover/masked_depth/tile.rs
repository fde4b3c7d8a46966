//! A tile: eight masks of samples with two nearnesses each, and how something new is merged into them.
//!
//! A sub-tile knows two things: everywhere in it something is at least as near as `reference`, and at the samples of
//! its mask something is at least as near as `working`. A third layer has no room, so of two that are not the nearest
//! of all, one has to give way; whatever gives way, both sentences stay true.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.2. Theirs
//!     drops the working layer where it is farther from the new one than from the reference, by difference of depths;
//!     ours by ratio of nearnesses, whichever of the two came first, and never drops where nothing is behind.
//! Cost: O(1) for each of the eight sub-tiles, without branches, so that eight lanes do all of them at once.
//! Conservative: nearness is only ever less than the truth.

use crate::cover::band::{BAND, Band};
use std::ops::Range;

/// Columns of a tile; its rows are those of a band.
pub(super) const COLUMNS: usize = 32;
pub(super) const ROWS: usize = BAND;
/// Columns and rows of a sub-tile.
pub(super) const SUB_COLUMNS: usize = 8;
pub(super) const SUB_ROWS: usize = 4;
/// Sub-tiles of a tile: four side by side, then the four below.
pub(super) const SUB_TILES: usize = 8;

/// One bit for each sample of each sub-tile: bit 8·y + x.
pub(super) type Masks = [u32; SUB_TILES];

/// Nearness for each sub-tile.
pub(super) type Nearness = [f32; SUB_TILES];

/// 32×8 samples.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Tile {
    /// The samples that belong to the aperture: the others are never asked for, and count as covered by anything.
    open: Masks,
    /// The samples of the working layer.
    masks: Masks,
    /// At every sample something is at least as near; infinite where nothing is open.
    reference: Nearness,
    /// At the samples of the mask something is at least as near; as `reference` where the mask is empty.
    working: Nearness,
}

impl Tile {
    /// Nothing is open.
    pub(super) const CLOSED: Tile = Tile {
        open: [0; SUB_TILES],
        masks: [0; SUB_TILES],
        reference: [f32::INFINITY; SUB_TILES],
        working: [f32::INFINITY; SUB_TILES],
    };

    /// Opens samples; nothing is in them.
    #[inline(always)]
    pub(super) fn open(&mut self, samples: &Masks) {
        for (sub, samples) in samples.iter().enumerate() {
            self.open[sub] |= samples;
            if self.open[sub] != 0 {
                self.reference[sub] = 0.0;
                self.working[sub] = 0.0;
            }
        }
    }

    /// The farthest that anything hidden by this tile as a whole may come.
    #[inline(always)]
    pub(super) fn farthest(&self) -> f32 {
        let mut farthest = f32::INFINITY;
        for nearness in self.reference {
            farthest = if nearness < farthest { nearness } else { farthest };
        }
        farthest
    }

    /// At the samples `covered` something is at least as near as `nearness` (finite).
    #[inline(always)]
    pub(super) fn cover(&mut self, covered: &Masks, nearness: &Nearness) {
        for sub in 0..SUB_TILES {
            let [open, mask] = [self.open[sub], self.masks[sub]];
            let [reference, working, new] = [self.reference[sub], self.working[sub], nearness[sub]];
            let fresh = covered[sub] | !open;
            let acts = (covered[sub] & open != 0) & (new > reference);

            // Of the working layer and the new one, the nearer stays as it is. The other has the samples that are left.
            let before = new >= working;
            let [near, far] = if before { [new, working] } else { [working, new] };
            let near_mask = if before { fresh } else { mask };
            let far_mask = (mask | fresh) & !near_mask;

            // The farther one becomes the reference where nothing shows past the two. Else it goes, if the reference
            // is nearer to it than the nearer layer is; or the two become one.
            let full = mask | fresh == u32::MAX;
            let alone = far_mask == 0;
            let goes = near * reference > far * far;
            let merge = !(full | alone | goes);
            let next_mask = if merge { mask | fresh } else { near_mask };
            let next_mask = if full & alone { 0 } else { next_mask };
            let next_working = if merge { far } else { near };
            let next_reference = if alone { near } else { far };
            let next_reference = if full { next_reference } else { reference };
            self.masks[sub] = if acts { next_mask } else { mask };
            self.working[sub] = if acts { next_working } else { working };
            self.reference[sub] = if acts { next_reference } else { reference };
        }
    }

    /// May anything that comes as near as `nearness` be seen at any of the samples `asked`? At equal nearness it may.
    #[inline(always)]
    pub(super) fn sees(&self, asked: &Masks, nearness: &Nearness) -> bool {
        let mut any = false;
        for sub in 0..SUB_TILES {
            let asked = asked[sub] & self.open[sub];
            let beyond_reference = nearness[sub] < self.reference[sub];
            let beyond_working = nearness[sub] < self.working[sub];
            let outside_mask = asked & !self.masks[sub] != 0;
            any |= (asked != 0) & !beyond_reference & (outside_mask | !beyond_working);
        }
        any
    }

    /// Is the sample one of the working layer?
    pub(super) fn is_working(&self, x: usize, y: usize) -> bool {
        let sub = y / SUB_ROWS * (COLUMNS / SUB_COLUMNS) + x / SUB_COLUMNS;
        self.masks[sub] >> (y % SUB_ROWS * SUB_COLUMNS + x % SUB_COLUMNS) & 1 != 0
    }

    /// At the sample, something is at least as near as this; infinite where it is not open.
    #[inline(always)]
    pub(super) fn known(&self, x: usize, y: usize) -> f32 {
        let sub = y / SUB_ROWS * (COLUMNS / SUB_COLUMNS) + x / SUB_COLUMNS;
        let bit = 1 << (y % SUB_ROWS * SUB_COLUMNS + x % SUB_COLUMNS);
        if self.open[sub] & bit == 0 {
            f32::INFINITY
        } else if self.masks[sub] & bit != 0 {
            self.working[sub]
        } else {
            self.reference[sub]
        }
    }
}

/// The tiles across a band.
pub(super) struct Across<'a> {
    band: &'a Band,
    /// The columns of the screen that any row holds, and those that all rows hold.
    any: [u16; 2],
    all: [u16; 2],
}

impl Across<'_> {
    #[inline(always)]
    pub(super) fn new(band: &Band) -> Across<'_> {
        let [mut any, mut all] = [[u16::MAX, 0], [0, u16::MAX]];
        for [start, end] in band.runs {
            if start < end {
                any = [any[0].min(start), any[1].max(end)];
            }
            all = [all[0].max(start), all[1].min(end)];
        }
        Across { band, any, all }
    }

    /// The columns of tiles in which the band holds a sample, by their place on the screen.
    #[inline(always)]
    pub(super) fn tiles(&self) -> Range<usize> {
        tiles(self.any[0], self.any[1], COLUMNS)
    }

    /// The samples of the band in a column of tiles.
    #[inline(always)]
    pub(super) fn samples(&self, column: usize) -> Masks {
        let x = COLUMNS * column;
        if usize::from(self.all[0]) <= x && x + COLUMNS <= usize::from(self.all[1]) {
            return [u32::MAX; SUB_TILES];
        }
        let mut rows = [0; ROWS];
        for (row, [x0, x1]) in rows.iter_mut().zip(self.band.runs) {
            *row = columns_within(x0, x1, x);
        }
        let mut masks = [0; SUB_TILES];
        for (sub, mask) in masks.iter_mut().enumerate() {
            let [across, down] = [sub % 4, sub / 4];
            for row in 0..SUB_ROWS {
                let byte = rows[SUB_ROWS * down + row] >> (SUB_COLUMNS * across) & 0xFF;
                *mask |= byte << (SUB_COLUMNS * row);
            }
        }
        masks
    }
}

/// The tiles that hold some of the rows or columns `start..end`, each `side` long.
pub(super) fn tiles(start: u16, end: u16, side: usize) -> Range<usize> {
    usize::from(start) / side..usize::from(end).div_ceil(side)
}

/// The samples of a rectangle in a tile, by its columns and rows.
#[inline(always)]
pub(super) fn masks_of_rect(columns: u32, rows: [u32; 2]) -> Masks {
    let mut masks = [0; SUB_TILES];
    for (sub, mask) in masks.iter_mut().enumerate() {
        let [across, down] = [sub % 4, sub / 4];
        *mask = ((columns >> (SUB_COLUMNS * across) & 0xFF) * 0x0101_0101) & rows[down];
    }
    masks
}

/// The columns `x0..x1` of the screen that are in the tile at column `x`, a bit each.
#[inline(always)]
pub(super) fn columns_within(x0: u16, x1: u16, x: usize) -> u32 {
    ((1_u64 << within(x1, x)) - (1_u64 << within(x0, x))) as u32
}

/// The rows `y0..y1` of the screen that are in the tiles at row `y`: for the upper and the lower sub-tiles, eight bits
/// a row.
#[inline(always)]
pub(super) fn rows_within(y0: u16, y1: u16, y: usize) -> [u32; 2] {
    let bits = |row: u16| 8 * (i32::from(row) - y as i32).clamp(0, ROWS as i32) as u128;
    let rows = (1_u128 << bits(y1)) - (1_u128 << bits(y0));
    [rows as u32, (rows >> 32) as u32]
}

/// A column of the screen as one of the tile that begins at column `x`, 0 to 32.
#[inline(always)]
fn within(column: u16, x: usize) -> u32 {
    (i32::from(column) - x as i32).clamp(0, COLUMNS as i32) as u32
}
