//! Depth buffer: the nearest face so far, at each sample.
//!
//! Its whole answer comes at the end: an owner is kept beside each depth, so nothing is shaded twice.
//! Source: Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974; the portal clip by
//!     initialising the buffer from Boreskov, Using portals to create aggregate scenes.
//! Cost: clear and finish O(samples of the aperture); a face O(samples it covers).
//! Exact: hides no box; its set is the owners that are left, and glass held against the final depth.

use super::raster::{Raster, Sink, Triangle};
use super::samples::{Sample, Samples, owned_by};
use super::{Cover, Sight};
use crate::aperture::Rect;
use crate::canvas::Canvas;
use crate::content::Content;
use crate::faces::Faces;
use crate::order::Unsorted;
use crate::passage::Passage;
use crate::region::Region;
use crate::seen::Seen;
use crate::stats::Stats;

/// The nearest face so far, at each sample.
#[derive(Default)]
pub struct DepthBuffer {
    raster: Raster,
    samples: Samples,
}

impl Cover for DepthBuffer {
    type CullNeeds = Unsorted;
    type DrawNeeds = Unsorted;
    const PRIMES: bool = false;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        self.samples.clear(passage, trace);
    }

    fn sees(&mut self, _region: &Region) -> Sight {
        Sight::Partly
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.samples.begin_batch();
        self.raster.run(faces, passage, &mut self.samples, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Seen) {
        self.samples
            .look_through(&mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        content: &Content,
        _passage: &Passage,
        seen: &mut Seen,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.samples.finish(content, seen, canvas);
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        u64::from(size[0]) * u64::from(size[1]) * size_of::<Sample>() as u64
    }
}

impl Sink for Samples {
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    #[inline(always)]
    fn run(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        keep_nearest(self.row(y, x0, x1), x0, y, triangle);
        self.count(y, x0, x1, triangle.owner);
    }
}

/// Lets a triangle own those samples of a run at which it is nearest.
#[inline(always)]
pub(super) fn keep_nearest(samples: &mut [Sample], x0: u16, y: u16, triangle: &Triangle) {
    let row = triangle.row(y);
    let owner = owned_by(triangle.owner);
    for (x, sample) in (i32::from(x0)..).zip(samples) {
        let new = Sample::from(row.bits(x)) << 32 | owner;
        *sample = if new > *sample { new } else { *sample };
    }
}
