//! Asks the tiles whether a box can be seen.

use super::grid::Grid;
use super::outline::Outline;
use super::shapes::Volume;
use super::tile::{Across, COLUMNS, ROWS, SUB_TILES, columns_within, masks_of_rect, rows_within, tiles};
use crate::aperture::Rect;
use crate::cover::band::{BAND, Band};
use fearless_simd::prelude::*;

impl Grid {
    /// The first row of tiles in which a sample of `rect` may show something as near as `nearest`.
    #[inline(always)]
    pub(super) fn first_seen(&self, rect: &Rect, nearest: f32) -> Option<usize> {
        let nearness = [nearest; SUB_TILES];
        tiles(rect.y0, rect.y1, ROWS).find(|row| {
            let rows = rows_within(rect.y0, rect.y1, row * ROWS);
            tiles(rect.x0, rect.x1, COLUMNS).any(|column| {
                let index = row * self.columns + column;
                if nearest < self.farthest[index] {
                    return false;
                }
                let columns = columns_within(rect.x0, rect.x1, column * COLUMNS);
                self.tiles[index].sees(&masks_of_rect(columns, rows), &nearness)
            })
        })
    }

    /// May any sample of `rect` from row `from` of tiles on show a box, by its outline and its front sides?
    #[inline(always)]
    pub(super) fn sees_outline<S: Simd>(
        &self,
        simd: S,
        rect: &Rect,
        from: usize,
        nearest: f32,
        outline: &Outline,
    ) -> bool {
        tiles(rect.y0, rect.y1, ROWS)
            .skip_while(|&row| row < from)
            .any(|row| {
                let Some((band, _)) = Band::held(simd, (row * BAND) as u16, rect, outline.lines()) else {
                    return false;
                };
                let across = Across::new(&band);
                across.tiles().any(|column| {
                    let index = row * self.columns + column;
                    if nearest < self.farthest[index] {
                        return false;
                    }
                    let nearness = outline.over_tile([column * COLUMNS, row * ROWS], rect, nearest);
                    self.tiles[index].sees(&across.samples(column), &nearness)
                })
            })
    }
}

/// The near distance is where a volume ceases to be of use.
#[inline(always)]
pub(super) fn sees<S: Simd>(
    simd: S,
    grid: &Grid,
    rect: &Rect,
    nearest: f32,
    volume: &Volume,
    near: f64,
) -> bool {
    let rect = rect.intersection(&grid.rect);
    if rect.is_empty() {
        return false;
    }
    let Some(first) = grid.first_seen(&rect, nearest) else {
        return false;
    };
    match Outline::of(volume, near, &rect) {
        Some(outline) => grid.sees_outline(simd, &rect, first, nearest, &outline),
        None => true,
    }
}
