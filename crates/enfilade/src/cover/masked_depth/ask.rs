//! Occlusion queries: tests rectangles and boxes against the tiles.

use super::MaskedDepth;
use super::grid::Grid;
use super::outline::Outline;
use super::tile::{
    BandTiles, COLUMNS, ROWS, SUB_TILES_OF_BAND, columns_within, masks_of_rect, rows_within, tiles,
};
use crate::aperture::Rect;
use crate::geom::Aabb;
use crate::passage::Passage;
use crate::raster::{BAND, Band, greater};
use crate::region::{BOXES, EightBoxes, Region, Volume};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;

impl MaskedDepth {
    /// Tests screen rectangles against the buffer, each at one reversed depth (1 / distance along the view direction,
    /// in scene units).
    ///
    /// Sets `seen` to one entry per rectangle, in the order of `rects`: `true` if geometry with that reversed depth may
    /// be visible at any sample of the rectangle, `false` if closer occluders hide it at all of them. `true` when
    /// unsure and at equal depth. Rectangles are in pixels (`x1` and `y1` exclusive) and are clipped to the bounding
    /// rectangle of the aperture; `false` if nothing is left. Give the reversed depth of the nearest point of the
    /// occludee, rounded up.
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

    /// Tests AABBs, in the space of the passage's sector, against the buffer.
    ///
    /// Sets `seen` to one entry per box, in the order of `boxes`: `true` if any part of the box may be visible, `false`
    /// if occluders hide all of it or it is out of view. `true` when unsure. `passage` must be the one that the buffer
    /// was cleared for.
    ///
    /// Tests each box's screen rectangle at the depth of its nearest corner, eight boxes at a time.
    /// [`Cover::test`](crate::cover::Cover::test) is slower but tighter: it also uses the outline and the front faces
    /// of the box.
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

    /// Returns the reversed depth (1 / distance along the view direction, in scene units) stored at a sample:
    /// everything farther, with a smaller reversed depth, is hidden there.
    ///
    /// 0 if no occluder is known to cover the sample, infinite if it is outside the aperture. Never nearer than the
    /// true depth. `x` and `y` are the sample's column and row. They must be inside the bounding rectangle of the
    /// aperture ([`Aperture::rect`](crate::Aperture::rect)), which is not checked: elsewhere the result may be that of
    /// another sample or of an earlier view.
    ///
    /// # Panics
    /// May panic if the sample is outside that rectangle.
    pub fn rev_depth_at(&self, x: u16, y: u16) -> f32 {
        self.grid.rev_depth_at(x.into(), y.into())
    }
}

impl Grid {
    /// Returns `true` if geometry with reversed depth `nearest` may be visible at any sample of `rect`.
    #[inline(always)]
    pub(super) fn shows(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        !rect.is_empty()
            && (self.shows_middle_of(&rect, nearest) || self.first_seen(&rect, nearest).is_some())
    }

    /// Returns `true` if any sample may show the box. Tests its rectangle first, then, if it is entirely behind the
    /// near plane, its outline.
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
        // No closures here and below: the code of a closure is not compiled for the SIMD level.
        match Outline::of(&region.volume, near, &rect) {
            Some(outline) if self.shows_middle(&rect, &outline, &region.volume) => true,
            Some(outline) => self.sees_outline(simd, &rect, first, region.nearest, &outline),
            None => true,
        }
    }

    /// Returns `true` if the sample at the centre of the box would show it even at the depth of its farthest corner. A
    /// cheap early out: most visible boxes pass it.
    #[inline(always)]
    fn plainly_shows(&self, rect: &Rect, volume: &Volume) -> bool {
        /// In fewer columns or rows there may be no sample inside the box.
        const FEW: u16 = 4;
        if rect.x1 - rect.x0 < FEW || rect.y1 - rect.y0 < FEW {
            return false;
        }
        let Some([x, y]) = sample_at_middle(rect, volume) else {
            return false;
        };
        let [a, b, c] = volume.sides.map(|side| side.z);
        let farthest = volume.origin.z + greater(a, 0.0) + greater(b, 0.0) + greater(c, 0.0);
        f64::from(self.rev_depth_at(x, y)) * farthest < 1.0
    }

    /// Returns `true` if the sample at the centre of the box may show it, by outline and front faces. Most visible
    /// boxes that reach this test pass it.
    #[inline(always)]
    fn shows_middle(&self, rect: &Rect, outline: &Outline, volume: &Volume) -> bool {
        let Some([x, y]) = sample_at_middle(rect, volume) else {
            return false;
        };
        outline.rev_depth_at([x as f64 + 0.5, y as f64 + 0.5]) >= f64::from(self.rev_depth_at(x, y))
    }

    /// Returns the first row of tiles in which a sample of `rect` may show geometry with reversed depth `nearest`.
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

    /// Returns `true` if a sample of `rect` in one row of tiles may show geometry with reversed depth `nearest`.
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

    /// Returns `true` if the centre sample of `rect` may show geometry with reversed depth `nearest`. An early out:
    /// most visible rectangles pass it.
    #[inline(always)]
    pub(super) fn shows_middle_of(&self, rect: &Rect, nearest: f32) -> bool {
        let [x, y] = [
            usize::from(rect.x0.midpoint(rect.x1)),
            usize::from(rect.y0.midpoint(rect.y1)),
        ];
        let index = y / ROWS * self.columns + x / COLUMNS;
        nearest >= self.farthest[index] && nearest >= self.tiles[index].rev_depth_at(x % COLUMNS, y % ROWS)
    }

    /// Returns `true` if any sample of `rect`, from row `from` of tiles on, may show the box, by its outline and its
    /// front faces.
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
            if let Some((band, _)) = Band::inside(simd, y as u16, rect, outline.lines()) {
                let across = BandTiles::new(&band);
                for column in across.tiles() {
                    let index = y / ROWS * self.columns + column;
                    if nearest < self.farthest[index] {
                        continue;
                    }
                    let rev_depth = outline.over_tile([column * COLUMNS, y], rect, nearest);
                    let samples = across.samples(column);
                    if self.tiles[index].sees(y % ROWS / BAND, &samples, &rev_depth) {
                        return true;
                    }
                }
            }
            y += BAND;
        }
        false
    }
}

/// Returns the sample of `rect` at the projected centre of the box; `None` if the centre is outside `rect`.
#[inline(always)]
fn sample_at_middle(rect: &Rect, volume: &Volume) -> Option<[usize; 2]> {
    let [x, y, z] = volume.sides;
    let middle = volume.origin + 0.5 * (x + y + z);
    let [x, y] = [middle.x / middle.z, middle.y / middle.z];
    let within = |low: u16, value: f64, high: u16| f64::from(low) <= value && value < f64::from(high);
    (within(rect.x0, x, rect.x1) && within(rect.y0, y, rect.y1)).then_some([x as usize, y as usize])
}
