//! Tiles of cells larger than samples.

use super::MaskedDepth;
use super::fill::Slope;
use super::tile::{Across, COLUMNS, Nearness, ROWS, SUB_COLUMNS, SUB_ROWS};
use crate::aperture::Rect;
use crate::cover::Coarse;
use crate::cover::band::Band;
use crate::cover::part::smaller;
use crate::cover::triangle::Triangle;
use crate::passage::Passage;
use glam::DVec3;
use std::array;

impl Coarse for MaskedDepth {
    fn clear_cells(&mut self, passage: &Passage) {
        self.grid.clear(passage);
        self.near = f64::from(passage.near);
    }

    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.grid.rect);
        !rect.is_empty() && self.grid.first_seen(&rect, nearest).is_some()
    }

    fn sees_plane(&mut self, cells: &Band, nearness: &Triangle) -> bool {
        let across = Across::new(cells);
        let row = usize::from(cells.y) / ROWS;
        across.tiles().any(|column| {
            let most = nearest_over([column * COLUMNS, row * ROWS], nearness);
            self.grid.tiles[row * self.grid.columns + column].sees(&across.samples(column), &most)
        })
    }

    fn cover_cells(&mut self, cells: &Band, nearness: &Triangle) {
        let slope = Slope {
            at: nearness.nearness,
            least: nearness.least,
        };
        self.grid.cover(cells, &slope);
    }
}

/// The most that a plane is near at the cells of each sub-tile of the tile at column and row `at`.
fn nearest_over(at: [usize; 2], plane: &Triangle) -> Nearness {
    let DVec3 { x, y, z } = plane.nearness;
    // Linear, so greatest at a corner.
    let column = at[0] as f64 + if x > 0.0 { SUB_COLUMNS as f64 - 0.5 } else { 0.5 };
    let row = at[1] as f64 + if y > 0.0 { SUB_ROWS as f64 - 0.5 } else { 0.5 };
    array::from_fn(|sub| {
        let [across, down] = [sub % 4 * SUB_COLUMNS, sub / 4 * SUB_ROWS];
        let nearness = (column + across as f64) * x + ((row + down as f64) * y + z);
        smaller(nearness, plane.greatest) as f32
    })
}
