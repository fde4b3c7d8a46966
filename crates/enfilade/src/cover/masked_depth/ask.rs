//! Asks the tiles whether a box can be seen.

use super::grid::Grid;
use super::outline::Outline;
use super::tile::{Across, COLUMNS, ROWS, SUB_TILES, columns_within, masks_of_rect, rows_within, tiles};
use crate::aperture::Rect;
use crate::cover::band::{BAND, Band};
use crate::region::Region;
use fearless_simd::prelude::*;

impl Grid {
    /// May any sample show a box? By its rectangle first, then by its outline, if it is all beyond the near distance.
    #[inline(always)]
    pub(super) fn sees<S: Simd>(&self, simd: S, region: &Region, near: f64) -> bool {
        let rect = region.rect.intersection(&self.rect);
        if rect.is_empty() {
            return false;
        }
        let Some(first) = self.first_seen(&rect, region.nearest) else {
            return false;
        };
        Outline::of(&region.volume, near, &rect)
            .is_none_or(|outline| self.sees_outline(simd, &rect, first, region.nearest, &outline))
    }

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
