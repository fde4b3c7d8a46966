//! A tile: sixteen masks of samples with two reversed depths each, and how something new is merged into them.
//!
//! A sub-tile knows two things: everywhere in it something is at least as near as `reference`, and at the samples of
//! its mask something is at least as near as `working`. A third layer has no room, so of two that are not the nearest
//! of all, one has to give way; whatever gives way, both sentences stay true.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.2. Theirs
//!     drops the working layer where it is farther from the new one than from the reference, by difference of depths;
//!     ours by ratio of reversed depths, whichever of the two came first, and never drops where nothing is behind, unless that
//!     layer is farther than 10¹⁹.
//! Cost: O(1) for each sub-tile; [`rows`](super::rows) does all sixteen at once.
//! Conservative: reversed depth is only ever less than the truth.

use crate::cover::band::{BAND, Band};
use std::ops::Range;

/// Columns and rows of a tile: two bands.
pub(super) const COLUMNS: usize = 32;
pub(super) const ROWS: usize = 2 * BAND;
/// Columns and rows of a sub-tile.
pub(super) const SUB_COLUMNS: usize = 8;
pub(super) const SUB_ROWS: usize = 4;
/// Sub-tiles side by side.
pub(super) const ACROSS: usize = COLUMNS / SUB_COLUMNS;
/// Sub-tiles of a tile: four side by side, then the four below, and so on.
pub(super) const SUB_TILES: usize = 16;
/// Those in the rows of a band.
pub(super) const SUB_TILES_OF_BAND: usize = SUB_TILES / 2;

/// One bit for each sample of each sub-tile in the rows of a band: bit 8·y + x.
pub(super) type Masks = [u32; SUB_TILES_OF_BAND];

/// Reversed depth for each sub-tile in the rows of a band.
pub(super) type RevDepth = [f32; SUB_TILES_OF_BAND];

/// 32×16 samples: four lines of the cache.
///
/// Reversed depth is kept as bits: not being below zero, they sort as it does.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Tile {
    /// The samples of the working layer.
    pub(super) mask: [u32; SUB_TILES],
    /// At every sample something is at least as near; infinite where nothing is open.
    pub(super) reference: [u32; SUB_TILES],
    /// At the samples of the mask something is at least as near; as `reference` where the mask is empty.
    pub(super) working: [u32; SUB_TILES],
    /// The samples that do not belong to the aperture: they are never asked for, and are covered by anything.
    pub(super) closed: [u32; SUB_TILES],
}

impl Tile {
    /// Nothing is open.
    pub(super) const CLOSED: Tile = Tile {
        mask: [0; SUB_TILES],
        reference: [f32::INFINITY.to_bits(); SUB_TILES],
        working: [f32::INFINITY.to_bits(); SUB_TILES],
        closed: [u32::MAX; SUB_TILES],
    };

    /// Opens samples of a band, the upper or the lower; nothing is in them.
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

    /// The farthest that anything hidden by this tile as a whole may come.
    #[inline(always)]
    pub(super) fn farthest(&self) -> f32 {
        let mut farthest = u32::MAX;
        for reference in self.reference {
            farthest = farthest.min(reference);
        }
        f32::from_bits(farthest)
    }

    /// At the samples `covered` of a sub-tile something is at least as near as `rev_depth` (bits of what is finite). Is the
    /// reference another than before?
    ///
    /// The specification of [`cover_tile`](super::rows::cover_tile), which does all sixteen.
    #[inline(always)]
    pub(super) fn cover(&mut self, sub: usize, covered: u32, rev_depth: u32) -> bool {
        let [mask, reference, working] = [self.mask[sub], self.reference[sub], self.working[sub]];
        if rev_depth <= reference {
            return false;
        }
        let fresh = covered | self.closed[sub];
        // Of the working layer and the new one, the nearer stays as it is. The other has the samples that are left.
        let before = rev_depth >= working;
        let near = if before { rev_depth } else { working };
        let far = if before { working } else { rev_depth };
        let near_mask = if before { fresh } else { mask };
        let either = mask | fresh;
        let alone = either == near_mask;
        if either == u32::MAX {
            // The farther one becomes the reference, for nothing shows past the two.
            self.mask[sub] = if alone { 0 } else { near_mask };
            self.reference[sub] = if alone { near } else { far };
            self.working[sub] = near;
            return true;
        }
        // Else it goes, if the reference is nearer to it than the nearer layer is, by ratio: bits of floats are about
        // their logarithms. Or the two become one.
        let goes = near + reference > 2 * far;
        self.mask[sub] = if goes { near_mask } else { either };
        self.working[sub] = if goes | alone { near } else { far };
        false
    }

    /// May anything that comes as near as `rev_depth` be seen at any of the samples `asked` of a band, the upper or the
    /// lower? At equal reversed depth it may.
    #[inline(always)]
    pub(super) fn sees(&self, band: usize, asked: &Masks, rev_depth: &RevDepth) -> bool {
        let mut any = false;
        for (sub, (asked, &rev_depth)) in (band * SUB_TILES_OF_BAND..).zip(asked.iter().zip(rev_depth)) {
            let asked = asked & !self.closed[sub];
            let beyond_reference = rev_depth < f32::from_bits(self.reference[sub]);
            let beyond_working = rev_depth < f32::from_bits(self.working[sub]);
            let outside_mask = asked & !self.mask[sub] != 0;
            any |= (asked != 0) & !beyond_reference & (outside_mask | !beyond_working);
        }
        any
    }

    /// Is the sample one of the working layer?
    pub(super) fn is_working(&self, x: usize, y: usize) -> bool {
        self.mask[sub_tile(x, y)] & bit(x, y) != 0
    }

    /// At the sample, something is at least as near as this; infinite where it is not open.
    #[inline(always)]
    pub(super) fn known(&self, x: usize, y: usize) -> f32 {
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

/// The tiles that hold some of the rows or columns `start..end`, each `side` long.
pub(super) fn tiles(start: u16, end: u16, side: usize) -> Range<usize> {
    usize::from(start) / side..usize::from(end).div_ceil(side)
}

/// The samples of a rectangle in the rows of a band of a tile, by its columns and rows.
#[inline(always)]
pub(super) fn masks_of_rect(columns: u32, rows: [u32; 2]) -> Masks {
    let mut masks = [0; SUB_TILES_OF_BAND];
    for (sub, mask) in masks.iter_mut().enumerate() {
        let [across, down] = [sub % ACROSS, sub / ACROSS];
        *mask = ((columns >> (SUB_COLUMNS * across) & 0xFF) * 0x0101_0101) & rows[down];
    }
    masks
}

/// The columns `x0..x1` of the screen that are in the tile at column `x`, a bit each.
#[inline(always)]
pub(super) fn columns_within(x0: u16, x1: u16, x: usize) -> u32 {
    ((1_u64 << within(x1, x)) - (1_u64 << within(x0, x))) as u32
}

/// The rows `y0..y1` of the screen that are in the band at row `y`: for the upper and the lower sub-tiles, eight bits
/// a row.
#[inline(always)]
pub(super) fn rows_within(y0: u16, y1: u16, y: usize) -> [u32; 2] {
    let bits = |row: u16| 8 * (i32::from(row) - y as i32).clamp(0, BAND as i32) as u128;
    let rows = (1_u128 << bits(y1)) - (1_u128 << bits(y0));
    [rows as u32, (rows >> 32) as u32]
}

/// A column of the screen as one of the tile that begins at column `x`, 0 to 32.
#[inline(always)]
fn within(column: u16, x: usize) -> u32 {
    (i32::from(column) - x as i32).clamp(0, COLUMNS as i32) as u32
}
