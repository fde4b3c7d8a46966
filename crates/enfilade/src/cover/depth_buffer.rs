//! Depth buffer (z-buffer): the nearest face so far, at each sample.
//!
//! It culls nothing during traversal. The visible set is read from the buffer at the end: an owner is stored beside
//! each depth, so each sample is shaded once.
//! Source: Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974; the portal clip by
//!     initialising the buffer from Boreskov, Using portals to create aggregate scenes.
//! Cost: clear and finish O(samples of the aperture); a face O(samples it covers).
//! Exact: hides no box; its visible set is the owners of the final samples, plus transparent faces depth-tested against
//! them.

use super::samples::{Samples, look_through};
use super::{Cover, Paints};
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::order::Unsorted;
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};

/// Depth buffer: reversed depth and owner of the nearest face so far, at each sample.
///
/// Takes faces in any order. Occlusion queries always return `Partial`. One sample per pixel of the screen, 8 bytes
/// each.
#[derive(Default)]
#[doc(alias = "z-buffer")]
pub struct DepthBuffer {
    raster: Raster,
    samples: Samples,
}

impl Cover for DepthBuffer {
    type Needs = Unsorted;

    const NAME: &'static str = "DepthBuffer";

    fn test(&mut self, _region: &Region) -> Visibility {
        Visibility::Partial
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        Samples::needs_bytes(size)
    }
}

impl Paints for DepthBuffer {
    const PRIMES: bool = false;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        self.samples.shape(passage, trace);
        self.samples.open(passage, |_, _| {});
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.samples.begin_batch();
        self.raster.run(faces, passage, &mut self.samples, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let depth = |x, y| self.samples.depth(x, y);
        look_through(depth, &mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.samples.report(owners, seen, canvas);
    }
}

impl Sink for Samples {
    #[inline(always)]
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        for (y, [x0, x1]) in band.rows() {
            self.keep_nearest(y, x0, x1, triangle);
        }
    }
}
