//! Rasterizes single faces in f64: the fallback for faces that the kernels are not certain of.
//!
//! The rasterizer of the exact covers decides which samples a face covers. So this buffer covers the same samples as
//! they do, and faces that share an edge are watertight: each sample belongs to exactly one of them.
//! Source: as [`super::fill`].
//! Cost: a face O(tiles it overlaps).
//! Conservative: stores the farthest depth of a face in each sub-tile, rounded down.

use super::fill::Slope;
use super::grid::Tiles;
use super::rows::RunQueue;
use crate::aperture::Rect;
use crate::raster::{BAND, Band, Sink, Triangle};
use glam::DVec3;

/// Rasterizer output that queues the runs of the faces.
pub(super) struct RunSink<'a> {
    tiles: &'a Tiles<'a>,
    run_queue: &'a mut RunQueue,
}

impl RunSink<'_> {
    pub(super) fn new<'a>(tiles: &'a Tiles<'a>, run_queue: &'a mut RunQueue) -> RunSink<'a> {
        RunSink { tiles, run_queue }
    }
}

impl Sink for RunSink<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        self.tiles.hides(rect, nearest)
    }

    #[inline(always)]
    fn begin(&mut self, triangle: &Triangle, _corners: &[DVec3; 3]) {
        let between = [triangle.least, triangle.greatest];
        let slope = Slope::new(triangle.rev_depth, between, &self.tiles.rect);
        self.run_queue.begin(&slope.slopes());
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, _triangle: &Triangle) {
        let Rect { y0, y1, .. } = self.tiles.rect;
        if y0 < band.y + BAND as u16 && band.y < y1 {
            self.run_queue.push_band(band);
        }
    }
}
