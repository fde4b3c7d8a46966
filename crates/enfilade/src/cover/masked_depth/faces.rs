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
use super::rows::Waiting;
use super::tile::{Across, COLUMNS, ROWS};
use crate::aperture::Rect;
use crate::cover::band::{BAND, Band};
use crate::cover::raster::Sink;
use crate::cover::triangle::Triangle;
use glam::DVec3;

/// Faces that are held against the tiles one by one, in f64.
pub(super) struct OneByOne<'a> {
    grid: &'a Grid,
    waiting: &'a mut Waiting,
    /// Does it hide what is behind it? Else no more is asked once any of it is seen.
    hides: bool,
    /// May any of it be seen?
    pub(super) seen: bool,
    /// How near the face at hand is.
    slope: Slope,
}

impl OneByOne<'_> {
    pub(super) fn new<'a>(grid: &'a Grid, waiting: &'a mut Waiting, hides: bool) -> OneByOne<'a> {
        OneByOne {
            grid,
            waiting,
            hides,
            seen: false,
            slope: Slope::new(DVec3::ZERO, [0.0; 2], &Rect::default()),
        }
    }
}

impl Sink for OneByOne<'_> {
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
        let y = usize::from(band.y);
        for column in across.tiles() {
            let index = y / ROWS * self.grid.columns + column;
            if !self.seen {
                let nearness = self.slope.most_over_band([column * COLUMNS, y]);
                let farthest = self.grid.farthest[index];
                let mut beyond = true;
                for nearness in nearness {
                    beyond &= nearness < farthest;
                }
                let asked = across.samples(column);
                self.seen = !beyond && self.grid.tiles[index].sees(y % ROWS / BAND, &asked, &nearness);
            }
        }
        if self.hides {
            self.waiting.push_band(band, &self.slope.slopes());
        }
    }
}
