//! The tiles of the screen.

use super::batch::LANES;
use super::tile::{BandTiles, COLUMNS, ROWS, Tile, tiles};
use crate::aperture::Rect;
use crate::passage::Passage;
use crate::raster::{BAND, Band};
use fearless_simd::f32x16;
use fearless_simd::prelude::*;

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
    /// [`Tile::farthest`] of each tile; decides most queries.
    pub(super) farthest: Vec<f32>,
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
}

impl Tiles<'_> {
    /// Returns a tile and its [`Tile::farthest`].
    #[inline(always)]
    pub(super) fn tile(&mut self, number: u32) -> (&mut Tile, &mut f32) {
        let number = number as usize;
        (&mut self.tiles[number], &mut self.farthest[number])
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

    /// Returns `true` if everything with reversed depth up to `nearest` is hidden at all samples of `rect`, by
    /// [`Tile::farthest`] alone; `false` when unsure.
    #[inline(always)]
    pub(super) fn hides(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        if rect.is_empty() {
            return true;
        }
        let columns = tiles(rect.x0, rect.x1, COLUMNS);
        let mut hides = true;
        for row in tiles(rect.y0, rect.y1, ROWS) {
            let first = (row - self.first_row) * self.columns;
            for &farthest in &self.farthest[first + columns.start..first + columns.end] {
                hides &= nearest < farthest;
            }
        }
        hides
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
        }
    }

    /// Splits the tiles into strips of equal height; returns fewer than `count` if there are not enough rows of tiles.
    pub(super) fn strips(&mut self, count: usize) -> impl Iterator<Item = Tiles<'_>> {
        let Grid {
            rect,
            columns,
            ref mut tiles,
            ref mut farthest,
            ..
        } = *self;
        let last = usize::from(rect.y1).div_ceil(ROWS);
        let rows = last.div_ceil(count.max(1)).max(1);
        let tiles = tiles[..last * columns].chunks_mut(rows * columns.max(1));
        let farthest = farthest[..last * columns].chunks_mut(rows * columns.max(1));
        let strips = tiles.zip(farthest).enumerate();
        strips.map(move |(strip, (tiles, farthest))| {
            let [start, end] = [strip * rows, (strip + 1) * rows].map(first_sample);
            Tiles {
                rect: Rect {
                    y0: rect.y0.max(start),
                    y1: rect.y1.min(end),
                    ..rect
                },
                columns,
                first_row: strip * rows,
                tiles,
                farthest,
            }
        })
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
        }
        for row in tiles(y0, y1, ROWS) {
            for column in tiles(x0, x1, COLUMNS) {
                self.tiles[row * self.columns + column] = Tile::CLOSED;
            }
            for band in 0..ROWS / BAND {
                self.open_band(passage, row, band);
            }
            for column in tiles(x0, x1, COLUMNS) {
                let index = row * self.columns + column;
                self.farthest[index] = self.tiles[index].farthest();
            }
        }
    }

    /// Returns the reversed depth stored at a sample, see [`Tile::rev_depth_at`].
    #[inline(always)]
    pub(super) fn rev_depth_at(&self, x: usize, y: usize) -> f32 {
        self.tiles[y / ROWS * self.columns + x / COLUMNS].rev_depth_at(x % COLUMNS, y % ROWS)
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
                self.tiles[row * self.columns + column].open(band, &across.samples(column));
            }
        }
    }
}
