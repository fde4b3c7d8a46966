//! Asks the tiles whether a box can be seen.

use super::MaskedDepth;
use super::grid::Grid;
use super::outline::Outline;
use super::tile::{
    Across, COLUMNS, ROWS, SUB_TILES_OF_BAND, columns_within, masks_of_rect, rows_within, tiles,
};
use crate::aperture::Rect;
use crate::cover::band::{BAND, Band};
use crate::cover::part::greater;
use crate::geom::Aabb;
use crate::passage::Passage;
use crate::region::{BOXES, EightBoxes, Region, Volume};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;

impl MaskedDepth {
    /// May something as near as a number (1 / distance) be seen at any sample of a rectangle? For each of `rects`, in their
    /// order, into `seen`; `true` when unsure.
    pub fn sees_rects(&self, rects: &[(Rect, f32)], seen: &mut Vec<bool>) {
        seen.resize(rects.len(), false);
        dispatch!(self.level, simd => self.see_rects(simd, rects, seen));
    }

    #[inline(always)]
    fn see_rects<S: Simd>(&self, _simd: S, rects: &[(Rect, f32)], seen: &mut [bool]) {
        for ((rect, nearest), seen) in rects.iter().zip(seen) {
            *seen = self.grid.shows(rect, *nearest);
        }
    }

    /// May anything in a box be seen, in the space of the passage's sector? For each of `boxes`, in their order, into
    /// `seen`; `true` when unsure. `passage` is the one that the cover was cleared for.
    ///
    /// By the rectangles around them, which is quick; [`Cover::sees`](crate::cover::Cover::sees) is told more by an outline.
    pub fn sees_boxes(&self, passage: &Passage, boxes: &[Aabb], seen: &mut Vec<bool>) {
        seen.resize(boxes.len(), false);
        dispatch!(self.level, simd => self.see_boxes(simd, passage, boxes, seen));
    }

    #[inline(always)]
    fn see_boxes<S: Simd>(&self, _simd: S, passage: &Passage, boxes: &[Aabb], seen: &mut [bool]) {
        for (boxes, seen) in boxes.chunks(BOXES).zip(seen.chunks_mut(BOXES)) {
            let eight = EightBoxes::of(passage, &passage.screen_from_sector, boxes);
            for (lane, seen) in seen.iter_mut().enumerate() {
                let (rect, nearest) = eight.rect(lane);
                *seen = self.grid.shows(&rect, nearest);
            }
        }
    }

    /// Something is at least as near (1 / distance) as this at a sample of the aperture's rectangle; 0 where nothing is known
    /// to be, infinite where the sample is not one of the aperture.
    pub fn rev_depth_at(&self, x: u16, y: u16) -> f32 {
        self.grid.known(x.into(), y.into())
    }
}

impl Grid {
    /// May something as near as `nearest` be seen at any sample of `rect`?
    #[inline(always)]
    pub(super) fn shows(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        !rect.is_empty()
            && (self.shows_middle_of(&rect, nearest) || self.first_seen(&rect, nearest).is_some())
    }

    /// May any sample show a box? By its rectangle first, then by its outline, if it is all beyond the near distance.
    #[inline(always)]
    pub(super) fn sees<S: Simd>(&self, simd: S, region: &Region, near: f64) -> bool {
        let rect = region.rect.intersection(&self.rect);
        if rect.is_empty() {
            return false;
        }
        if self.plainly_shows(&rect, &region.volume) {
            return true;
        }
        let Some(first) = self.first_seen(&rect, region.nearest) else {
            return false;
        };
        // No closures here and below: what runs in one does not run at the SIMD level.
        match Outline::of(&region.volume, near, &rect) {
            Some(outline) if self.shows_middle(&rect, &outline, &region.volume) => true,
            Some(outline) => self.sees_outline(simd, &rect, first, region.nearest, &outline),
            None => true,
        }
    }

    /// Would the sample at the middle of a box show it, though it were everywhere as far as its farthest corner? Most boxes
    /// that are seen are so plainly, and to ask costs little.
    #[inline(always)]
    fn plainly_shows(&self, rect: &Rect, volume: &Volume) -> bool {
        /// Fewer columns or rows may have no sample that the box is at.
        const FEW: u16 = 4;
        if rect.x1 - rect.x0 < FEW || rect.y1 - rect.y0 < FEW {
            return false;
        }
        let Some([x, y]) = sample_at_middle(rect, volume) else {
            return false;
        };
        let [a, b, c] = volume.sides.map(|side| side.z);
        let farthest = volume.origin.z + greater(a, 0.0) + greater(b, 0.0) + greater(c, 0.0);
        f64::from(self.known(x, y)) * farthest < 1.0
    }

    /// May the sample at the middle of a box show it? Of boxes that are seen most are by it, and need no more asking.
    #[inline(always)]
    fn shows_middle(&self, rect: &Rect, outline: &Outline, volume: &Volume) -> bool {
        let Some([x, y]) = sample_at_middle(rect, volume) else {
            return false;
        };
        outline.rev_depth_at([x as f64 + 0.5, y as f64 + 0.5]) >= f64::from(self.known(x, y))
    }

    /// The first row of tiles in which a sample of `rect` may show something as near as `nearest`.
    #[inline(always)]
    pub(super) fn first_seen(&self, rect: &Rect, nearest: f32) -> Option<usize> {
        let columns = tiles(rect.x0, rect.x1, COLUMNS);
        for row in tiles(rect.y0, rect.y1, ROWS) {
            let first = row * self.columns;
            let mut hidden = true;
            for &farthest in &self.farthest[first + columns.start..first + columns.end] {
                hidden &= nearest < farthest;
            }
            if !hidden && self.shows_in_row(row, rect, nearest) {
                return Some(row);
            }
        }
        None
    }

    /// May something as near as `nearest` be seen at a sample of `rect` in a row of tiles?
    fn shows_in_row(&self, row: usize, rect: &Rect, nearest: f32) -> bool {
        let rev_depth = [nearest; SUB_TILES_OF_BAND];
        for column in tiles(rect.x0, rect.x1, COLUMNS) {
            let index = row * self.columns + column;
            if nearest < self.farthest[index] {
                continue;
            }
            let columns = columns_within(rect.x0, rect.x1, column * COLUMNS);
            for band in 0..ROWS / BAND {
                let rows = rows_within(rect.y0, rect.y1, row * ROWS + band * BAND);
                if self.tiles[index].sees(band, &masks_of_rect(columns, rows), &rev_depth) {
                    return true;
                }
            }
        }
        false
    }

    /// May the sample in the middle of `rect` show something as near as `nearest`? What is seen mostly is by it.
    #[inline(always)]
    pub(super) fn shows_middle_of(&self, rect: &Rect, nearest: f32) -> bool {
        let [x, y] = [
            usize::from(rect.x0.midpoint(rect.x1)),
            usize::from(rect.y0.midpoint(rect.y1)),
        ];
        let index = y / ROWS * self.columns + x / COLUMNS;
        nearest >= self.farthest[index] && nearest >= self.tiles[index].known(x % COLUMNS, y % ROWS)
    }

    /// May any sample of `rect` from row `from` of tiles on show a box, by its outline and its front sides?
    #[inline(always)]
    fn sees_outline<S: Simd>(
        &self,
        simd: S,
        rect: &Rect,
        from: usize,
        nearest: f32,
        outline: &Outline,
    ) -> bool {
        let mut y = from * ROWS;
        while y < usize::from(rect.y1) {
            if let Some((band, _)) = Band::held(simd, y as u16, rect, outline.lines()) {
                let across = Across::new(&band);
                for column in across.tiles() {
                    let index = y / ROWS * self.columns + column;
                    if nearest < self.farthest[index] {
                        continue;
                    }
                    let rev_depth = outline.over_tile([column * COLUMNS, y], rect, nearest);
                    let asked = across.samples(column);
                    if self.tiles[index].sees(y % ROWS / BAND, &asked, &rev_depth) {
                        return true;
                    }
                }
            }
            y += BAND;
        }
        false
    }
}

/// The sample of `rect` at which the middle of a box is.
#[inline(always)]
fn sample_at_middle(rect: &Rect, volume: &Volume) -> Option<[usize; 2]> {
    let [x, y, z] = volume.sides;
    let middle = volume.origin + 0.5 * (x + y + z);
    let [x, y] = [middle.x / middle.z, middle.y / middle.z];
    let within = |low: u16, value: f64, high: u16| f64::from(low) <= value && value < f64::from(high);
    (within(rect.x0, x, rect.x1) && within(rect.y0, y, rect.y1)).then_some([x as usize, y as usize])
}
