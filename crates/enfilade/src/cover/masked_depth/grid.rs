//! The tiles of a screen.

use super::tile::{Across, COLUMNS, ROWS, Tile, tiles};
use crate::aperture::Rect;
use crate::cover::band::{BAND, Band};
use crate::passage::Passage;

/// The tiles of the rows and columns of a passage's rectangle, counted from the corner of the screen.
#[derive(Default)]
pub(super) struct Grid {
    pub(super) rect: Rect,
    pub(super) columns: usize,
    pub(super) tiles: Vec<Tile>,
    /// [`Tile::farthest`] of each: most questions are answered by it.
    pub(super) farthest: Vec<f32>,
    open: [Vec<[u16; 2]>; BAND],
}

impl Grid {
    /// Opens the samples of the aperture, and closes the others of its rectangle.
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

    /// What is known at a sample, as [`Tile::known`].
    #[inline(always)]
    pub(super) fn known(&self, x: usize, y: usize) -> f32 {
        self.tiles[y / ROWS * self.columns + x / COLUMNS].known(x % COLUMNS, y % ROWS)
    }

    /// Opens the samples of the aperture in a band of a row of tiles.
    fn open_band(&mut self, passage: &Passage, row: usize, band: usize) {
        let y = (row * ROWS + band * BAND) as u16;
        for (y, open) in (y..).zip(&mut self.open) {
            open.clear();
            if (self.rect.y0..self.rect.y1).contains(&y) {
                passage.aperture.open_in_row(y, open);
            }
        }
        // The first run of each row, then the second of each.
        let most = self.open.iter().map(Vec::len).max().unwrap_or(0);
        for number in 0..most {
            let runs = std::array::from_fn(|row| self.open[row].get(number).copied().unwrap_or([0; 2]));
            let runs = Band { y, runs };
            let across = Across::new(&runs);
            for column in across.tiles() {
                self.tiles[row * self.columns + column].open(band, &across.samples(column));
            }
        }
    }
}
