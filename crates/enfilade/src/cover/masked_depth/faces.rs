//! Faces one by one, in f64: those of which the kernels are not certain.
//!
//! Which samples a face has is told by the rasteriser of the exact covers, so that what one of those shows at a sample
//! is held here at the same sample, and of faces that share an edge each sample belongs to exactly one.
//! Source: as [`super::fill`].
//! Cost: a face O(tiles it reaches into).
//! Conservative: hides by the farthest, rounded down, that a face comes in a sub-tile.

use super::fill::Slope;
use super::grid::Tiles;
use super::rows::Waiting;
use crate::aperture::Rect;
use crate::cover::band::{BAND, Band};
use crate::cover::raster::Sink;
use crate::cover::triangle::Triangle;
use glam::DVec3;

/// Lets the runs of faces wait.
pub(super) struct OneByOne<'a> {
    tiles: &'a Tiles<'a>,
    waiting: &'a mut Waiting,
}

impl OneByOne<'_> {
    pub(super) fn new<'a>(tiles: &'a Tiles<'a>, waiting: &'a mut Waiting) -> OneByOne<'a> {
        OneByOne { tiles, waiting }
    }
}

impl Sink for OneByOne<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        self.tiles.hides(rect, nearest)
    }

    #[inline(always)]
    fn begin(&mut self, triangle: &Triangle, _corners: &[DVec3; 3]) {
        let between = [triangle.least, triangle.greatest];
        let slope = Slope::new(triangle.rev_depth, between, &self.tiles.rect);
        self.waiting.begin(&slope.slopes());
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, _triangle: &Triangle) {
        let Rect { y0, y1, .. } = self.tiles.rect;
        if y0 < band.y + BAND as u16 && band.y < y1 {
            self.waiting.push_band(band);
        }
    }
}
