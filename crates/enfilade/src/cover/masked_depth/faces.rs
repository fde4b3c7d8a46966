//! Holds faces against the tiles, and lets them hide: what a walk from near to far finds hides what it finds later.
//!
//! Which samples a face has is told by the rasteriser of the exact covers, so that what one of those shows at a sample
//! is held here at the same sample, and of faces that share an edge each sample belongs to exactly one.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 4, for occluders
//!     that are drawn while a scene is walked near to far.
//! Cost: a face O(tiles it reaches into).
//! Conservative: hidden by the nearest, rounded up, that a face comes in a sub-tile; hides by the farthest, rounded down.

use super::fill::Slope;
use super::grid::Grid;
use super::tile::{Across, COLUMNS, ROWS};
use crate::aperture::Rect;
use crate::cover::band::Band;
use crate::cover::raster::Sink;
use crate::cover::triangle::Triangle;
use glam::DVec3;

/// A batch of faces that is held against the tiles.
pub(super) struct Batch<'a> {
    grid: &'a mut Grid,
    /// Does it hide what is behind it? Else no more is asked once any of it is seen.
    hides: bool,
    /// May any of it be seen?
    pub(super) seen: bool,
    /// How near the face at hand is.
    slope: Slope,
}

impl Batch<'_> {
    pub(super) fn new(grid: &mut Grid, hides: bool) -> Batch<'_> {
        Batch {
            grid,
            hides,
            seen: false,
            slope: Slope::new(DVec3::ZERO, [0.0; 2], &Rect::default()),
        }
    }
}

impl Sink for Batch<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        (self.seen && !self.hides) || self.grid.first_seen(rect, nearest).is_none()
    }

    #[inline(always)]
    fn begin(&mut self, triangle: &Triangle, _corners: &[DVec3; 3]) {
        let Triangle {
            nearness,
            least,
            greatest,
            ..
        } = *triangle;
        self.slope = Slope::new(nearness, [least, greatest], &self.grid.rect);
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, _triangle: &Triangle) {
        let across = Across::new(band);
        let row = usize::from(band.y) / ROWS;
        for column in across.tiles() {
            let index = row * self.grid.columns + column;
            let at = [column * COLUMNS, row * ROWS];
            if !self.seen {
                let nearness = self.slope.most_over_tile(at);
                let farthest = self.grid.farthest[index];
                let mut beyond = true;
                for nearness in nearness {
                    beyond &= nearness < farthest;
                }
                self.seen = !beyond && self.grid.tiles[index].sees(&across.samples(column), &nearness);
            }
            if self.hides {
                self.grid.cover_tile(&across, [column, row], &self.slope);
            }
        }
    }
}
