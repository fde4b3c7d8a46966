//! Painter's algorithm: back-to-front painting without a depth test, later faces overwriting earlier ones.
//!
//! Correct only as far as its traversal order is: no face may come before a face that it hides. It paints owners
//! instead of colours, so each sample is shaded once and the remaining owners are the visible set.
//! Source: the painter's algorithm; Newell, Newell, Sancha, A Solution to the Hidden Surface Problem, 1972.
//! Cost: clear and finish O(samples of the aperture); a face O(samples it covers), hidden or not.
//! Contract: that of the traversal order.

use super::samples::{Samples, look_through};
use super::{Cover, Paints};
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::order::FarToNear;
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};

/// Buffer of owners for the painter's algorithm: each face overwrites the samples it covers.
///
/// Requires faces back to front. Occlusion queries always return `Partial`. One sample per pixel of the screen.
#[derive(Default)]
pub struct PaintersBuffer {
    raster: Raster,
    painted: PaintedSamples,
}

/// Samples without a depth test.
#[derive(Default)]
struct PaintedSamples(Samples);

impl Cover for PaintersBuffer {
    type Needs = FarToNear;

    const NAME: &'static str = "PaintersBuffer";

    fn test(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        Samples::needs_bytes(size)
    }
}

impl Paints for PaintersBuffer {
    const PRIMES: bool = false;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        self.painted.0.shape(passage, trace);
        self.painted.0.open(passage, |_, _| {});
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.painted.0.begin_batch();
        self.raster.run(faces, passage, &mut self.painted, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let depth = |x, y| self.painted.0.depth(x, y);
        look_through(depth, &mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.painted.0.report(owners, seen, canvas);
    }
}

impl Sink for PaintedSamples {
    #[inline(always)]
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        for (y, [x0, x1]) in band.rows() {
            self.0.paint_over(y, x0, x1, triangle);
        }
    }
}
