//! Faces one by one, in f64: those of which the kernels are not certain.
//!
//! Which samples a face has is told by the rasteriser of the exact covers, so that what one of those shows at a sample
//! is held here at the same sample, and of faces that share an edge each sample belongs to exactly one.
//! Source: as [`super::fill`].
//! Cost: a face O(tiles it reaches into).
//! Conservative: hides by the farthest, rounded down, that a face comes in a sub-tile.

use super::fill::Slope;
use super::grid::Grid;
use super::rows::{Slopes, Waiting};
use crate::aperture::Rect;
use crate::cover::band::Band;
use crate::cover::raster::Sink;
use crate::cover::triangle::Triangle;
use glam::DVec3;

/// Lets the runs of faces wait.
pub(super) struct OneByOne<'a> {
    grid: &'a Grid,
    waiting: &'a mut Waiting,
    /// How near the face at hand is.
    slopes: Slopes,
}

impl OneByOne<'_> {
    pub(super) fn new<'a>(grid: &'a Grid, waiting: &'a mut Waiting) -> OneByOne<'a> {
        OneByOne {
            grid,
            waiting,
            slopes: Slope::new(DVec3::ZERO, [0.0; 2], &Rect::default()).slopes(),
        }
    }
}

impl Sink for OneByOne<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        self.grid.first_seen(rect, nearest).is_none()
    }

    #[inline(always)]
    fn begin(&mut self, triangle: &Triangle, _corners: &[DVec3; 3]) {
        let between = [triangle.least, triangle.greatest];
        self.slopes = Slope::new(triangle.nearness, between, &self.grid.rect).slopes();
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, _triangle: &Triangle) {
        self.waiting.push_band(band, &self.slopes);
    }
}
