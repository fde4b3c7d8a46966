//! Coverage of cells larger than samples.

use super::MaskedDepth;
use super::fill::Slope;
use super::tile::{BandTiles, COLUMNS, ROWS};
use crate::aperture::Rect;
use crate::cover::Coarse;
use crate::passage::Passage;
use crate::raster::{BAND, Band, Triangle};

impl Coarse for MaskedDepth {
    fn clear_cells(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.near);
    }

    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.grid.rect);
        !rect.is_empty() && self.grid.first_seen(&rect, nearest).is_some()
    }

    fn sees_plane(&mut self, cells: &Band, rev_depth: &Triangle) -> bool {
        let slope = self.slope(rev_depth);
        let across = BandTiles::new(cells);
        let y = usize::from(cells.y);
        across.tiles().any(|column| {
            let most = slope.most_over_band([column * COLUMNS, y]);
            let tile = &self.grid.tiles[y / ROWS * self.grid.columns + column];
            tile.sees(y % ROWS / BAND, &across.samples(column), &most)
        })
    }

    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle) {
        let slope = self.slope(rev_depth);
        self.grid.cover(cells, &slope);
    }
}

impl MaskedDepth {
    fn slope(&self, triangle: &Triangle) -> Slope {
        let between = [triangle.least, triangle.greatest];
        Slope::new(triangle.rev_depth, between, &self.grid.rect)
    }
}
