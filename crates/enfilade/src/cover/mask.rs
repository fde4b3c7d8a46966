//! Coverage mask: front-to-back painting that draws every sample once.
//!
//! Correct if no face comes after a face that it hides. One bit per sample stores whether it is open, and one count per
//! tile of 64×8 samples stores how many are, so that a box behind painted samples is culled by reading a few counts.
//! Source: Boreskov, Using portals to create aggregate scenes (front-to-back BSP traversal with an s-buffer as the mask
//!     of painted samples).
//! Cost: clear and finish O(samples of the aperture); a face O(its open samples) + O(its rows); a box O(tiles).
//! Exact: no decision depends on depth.

use super::samples::{Samples, look_through};
use super::{Cover, Paints};
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::order::NearToFar;
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};

/// Coverage mask: painted samples are never overwritten.
///
/// Requires faces front to back. One bit of coverage, and one sample with owner and reversed depth, per pixel of the
/// screen.
#[derive(Default)]
pub struct Mask {
    raster: Raster,
    painted: MaskedSamples,
}

/// Samples, and a mask of the open ones.
#[derive(Default)]
struct MaskedSamples {
    samples: Samples,
    /// Number of 64-sample words in a row.
    words: usize,
    /// One bit per sample, set if it is open; row-major.
    open: Vec<u64>,
    /// Number of open samples in each tile: one word wide, [`TILE_ROWS`] high.
    tiles: Vec<u16>,
}

/// Height of a tile in rows.
const TILE_ROWS: usize = 8;

impl Cover for Mask {
    type Needs = NearToFar;

    const NAME: &'static str = "Mask";

    fn test(&mut self, region: &Region) -> Visibility {
        if self.painted.is_full(&region.rect) {
            Visibility::Hidden
        } else {
            Visibility::Partial
        }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let words = u64::from(size[0].div_ceil(64)) * u64::from(size[1]);
        Samples::needs_bytes(size) + words * size_of::<u64>() as u64
    }
}

impl Paints for Mask {
    const PRIMES: bool = false;
    const KEEPS_DEPTHS: bool = false;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        let MaskedSamples {
            samples,
            words,
            open,
            tiles,
        } = &mut self.painted;
        samples.shape(passage, trace);
        let rows = usize::from(samples.rect.y1);
        *words = samples.width.div_ceil(64);
        open.clear();
        open.resize(*words * rows, 0);
        tiles.clear();
        tiles.resize(*words * rows.div_ceil(TILE_ROWS), 0);
        samples.open(passage, |y, runs| {
            for &[x0, x1] in runs {
                for (word, bits) in words_of(x0, x1) {
                    open[usize::from(y) * *words + word] |= bits;
                    tiles[usize::from(y) / TILE_ROWS * *words + word] += bits.count_ones() as u16;
                }
            }
        });
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.painted.samples.begin_batch();
        self.raster.run(faces, passage, &mut self.painted, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let depth = |x, y| self.painted.samples.depth(x, y);
        look_through(depth, &mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.painted.samples.report(owners, seen, canvas);
    }
}

impl MaskedSamples {
    /// Returns `true` if every sample of `rect` is painted or outside the aperture.
    fn is_full(&self, rect: &Rect) -> bool {
        let [first, last] = [rect.y0, rect.y1 - 1].map(|y| usize::from(y) / TILE_ROWS);
        words_of(rect.x0, rect.x1).all(|(word, bits)| {
            (first..=last).all(|tile| {
                let rows = (tile * TILE_ROWS).max(usize::from(rect.y0))
                    ..((tile + 1) * TILE_ROWS).min(usize::from(rect.y1));
                self.tiles[tile * self.words + word] == 0
                    || rows
                        .into_iter()
                        .all(|y| self.open[y * self.words + word] & bits == 0)
            })
        })
    }

    /// Makes a triangle the owner of the open samples of a run.
    #[inline(always)]
    fn paint(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        let row = usize::from(y) * self.words;
        let tiles = usize::from(y) / TILE_ROWS * self.words;
        for (word, bits) in words_of(x0, x1) {
            let mut mine = self.open[row + word] & bits;
            self.open[row + word] &= !bits;
            self.tiles[tiles + word] -= mine.count_ones() as u16;
            while mine != 0 {
                let start = mine.trailing_zeros();
                let length = (mine >> start).trailing_ones();
                let x = word as u32 * 64 + start;
                self.samples
                    .paint_over(y, x as u16, (x + length) as u16, triangle);
                mine = mine
                    .checked_shr(start + length)
                    .map_or(0, |rest| rest << (start + length));
            }
        }
    }
}

/// Returns the words that contain the columns `x0..x1` of a row, each with a mask of those columns. `x0` must be less
/// than `x1`.
#[inline(always)]
fn words_of(x0: u16, x1: u16) -> impl Iterator<Item = (usize, u64)> + Clone {
    let [first, last] = [x0, x1 - 1].map(|x| usize::from(x) / 64);
    (first..=last).map(move |word| {
        let from = u64::MAX << (if word == first { x0 % 64 } else { 0 });
        let to = u64::MAX >> (if word == last { 63 - (x1 - 1) % 64 } else { 0 });
        (word, from & to)
    })
}

impl Sink for MaskedSamples {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, _nearest: f32) -> bool {
        self.is_full(rect)
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        for (y, [x0, x1]) in band.rows() {
            self.paint(y, x0, x1, triangle);
        }
    }
}
