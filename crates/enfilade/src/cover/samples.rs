//! Depth buffer storage: reversed depth and owner of each sample, packed into one integer.

use super::report::Report;
use super::trace::Trace;
use crate::faces::{FaceSource, Faces};
use crate::geometry::Owners;
use crate::ids::ItemIndex;
use crate::raster::{Band, Raster, Row, Sink, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use std::ops::Range;

/// Bits of the reversed depth in the upper half, the complement of the face number in the lower. The maximum is the
/// visible face; of equally near faces the one with the lower number wins, in whatever order they are drawn.
pub(super) type Sample = u64;

/// An open sample: no face, at infinity.
pub(super) const OPEN: Sample = 0;
/// A sample outside the aperture: nearer than any face.
pub(super) const COVERED: Sample = Sample::MAX;

/// Returns the lower half for a face. Adding one ensures that no face shares it with covered samples.
#[inline(always)]
pub(super) fn lower_half(owner: u32) -> u32 {
    !(owner + 1)
}

/// Returns the face number; `None` if the sample is open or covered.
#[inline(always)]
pub(super) fn owner_of(lower_half: u32) -> Option<u32> {
    (!lower_half).checked_sub(1).filter(|_| lower_half != OPEN as u32)
}

/// Returns the bits of the reversed depth.
#[inline(always)]
pub(super) fn rev_depth(sample: Sample) -> u32 {
    (sample >> 32) as u32
}

/// Samples of a passage's rectangle, in row-major order.
#[derive(Default)]
pub(super) struct Samples {
    /// Samples per stored row; columns are counted from the left of the screen.
    pub(super) width: usize,
    /// Bounding rectangle of the aperture.
    pub(super) rect: Rect,
    samples: Vec<Sample>,
    runs: Vec<[u16; 2]>,
    pub(super) trace: Option<Trace>,
}

impl Samples {
    /// Resizes the storage for the aperture's rectangle, without clearing any sample.
    pub(super) fn shape(&mut self, passage: &Passage, trace: bool) {
        self.rect = passage.aperture.rect();
        self.width = usize::from(self.rect.x1);
        let needed = self.width * usize::from(self.rect.y1 - self.rect.y0);
        if self.samples.len() < needed {
            self.samples.resize(needed, OPEN);
        }
        self.trace = trace.then(|| Trace::new(&self.rect));
    }

    /// Opens the samples of the aperture and covers the others in its rectangle. Calls `row` with the open runs of each
    /// row.
    pub(super) fn open(&mut self, passage: &Passage, mut row: impl FnMut(u16, &[[u16; 2]])) {
        let Rect {
            x0: first,
            y0,
            x1: end,
            y1,
        } = self.rect;
        let mut runs = std::mem::take(&mut self.runs);
        for y in y0..y1 {
            passage.aperture.open_in_row(y, &mut runs);
            row(y, &runs);
            let mut x = first;
            for &[x0, x1] in &runs {
                self.row_mut(y, x, x0).fill(COVERED);
                self.row_mut(y, x0, x1).fill(OPEN);
                x = x1;
            }
            self.row_mut(y, x, end).fill(COVERED);
        }
        self.runs = runs;
    }

    #[inline(always)]
    pub(super) fn row(&self, y: u16, x0: u16, x1: u16) -> &[Sample] {
        &self.samples[self.run(y, x0, x1)]
    }

    #[inline(always)]
    pub(super) fn row_mut(&mut self, y: u16, x0: u16, x1: u16) -> &mut [Sample] {
        let run = self.run(y, x0, x1);
        &mut self.samples[run]
    }

    /// Returns the index range of columns `x0..x1` of row `y`. Storage starts at the first row of the rectangle, so
    /// that a strip at the bottom of the screen takes no more memory than one at the top.
    #[inline(always)]
    fn run(&self, y: u16, x0: u16, x1: u16) -> Range<usize> {
        let start = usize::from(y - self.rect.y0) * self.width;
        start + usize::from(x0)..start + usize::from(x1)
    }

    /// Reports the owners of all samples, and emits their spans to `canvas`.
    pub(super) fn report(&self, owners: &dyn Owners, seen: &mut Collector, canvas: Option<&mut dyn Canvas>) {
        let mut report = Report::new(owners, seen, canvas.map(|canvas| canvas as &mut dyn Canvas));
        let Rect { x0, y0, x1, y1 } = self.rect;
        for y in y0..y1 {
            let row = self.row(y, x0, x1);
            if report.wants_rows() {
                report.samples(x0, row);
                report.end_row(y, &self.rect, self.trace.as_ref());
            } else {
                let (eights, rest) = row.as_chunks::<8>();
                eights.iter().for_each(|eight| report.eight(eight));
                rest.iter().for_each(|&sample| report.some(sample as u32, 1));
            }
        }
        report.finish();
    }

    /// Returns the bits of the reversed depth at a sample.
    pub(super) fn depth(&self, x: u16, y: u16) -> u32 {
        rev_depth(self.row(y, x, x + 1)[0])
    }

    /// Returns the memory in bytes for a screen of `size` (width, height) pixels.
    pub(super) fn needs_bytes(size: [u32; 2]) -> u64 {
        u64::from(size[0]) * u64::from(size[1]) * size_of::<Sample>() as u64
    }

    /// Begins a new batch of faces.
    pub(super) fn begin_batch(&mut self) {
        if let Some(trace) = &mut self.trace {
            trace.batch += 1;
        }
    }

    /// Depth-tests a triangle over a run of samples and makes it the owner where it is nearest.
    #[inline(always)]
    pub(super) fn keep_nearest(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        const LANES: usize = 8;
        let row = triangle.row(y);
        let owner = Sample::from(lower_half(triangle.owner));
        let samples = self.row_mut(y, x0, x1);
        let start = i32::from(x0);
        // Whole SIMD lanes first, so that the compiler vectorizes the loop; then one more set of lanes that ends with
        // the run and overlaps the others. Testing a sample against the same value twice changes nothing.
        let whole = samples.len() / LANES * LANES;
        row.own(start, &mut samples[..whole], owner);
        let last = if whole == 0 { 0 } else { samples.len() - LANES };
        if whole < samples.len() {
            row.own(start + last as i32, &mut samples[last..], owner);
        }
        if self.trace.is_some() {
            self.count(y, x0, x1, triangle.owner);
        }
    }

    /// Makes a triangle the owner of a run of samples without a depth test, except those outside the aperture.
    #[cfg(feature = "classic")]
    #[inline(always)]
    pub(super) fn paint_over(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        let row = triangle.row(y);
        let owner = Sample::from(lower_half(triangle.owner));
        for (x, sample) in (i32::from(x0)..).zip(self.row_mut(y, x0, x1)) {
            let new = Sample::from(row.bits(x)) << 32 | owner;
            *sample = if *sample == COVERED { COVERED } else { new };
        }
        if self.trace.is_some() {
            self.count(y, x0, x1, triangle.owner);
        }
    }

    /// Counts a depth test for each sample of a run; samples that `owner` owns are attributed to the current batch.
    #[cold]
    fn count(&mut self, y: u16, x0: u16, x1: u16, owner: u32) {
        let samples = &self.samples[self.run(y, x0, x1)];
        if let Some(trace) = &mut self.trace {
            trace.test(y, x0, x1);
            for (x, &sample) in (x0..).zip(samples) {
                if sample as u32 == lower_half(owner) {
                    trace.own(y, x, x + 1, trace.batch);
                }
            }
        }
    }
}

impl Row {
    /// Makes `owner` the owner of those samples, starting at column `start`, at which it is nearest.
    #[inline(always)]
    fn own(&self, start: i32, samples: &mut [Sample], owner: Sample) {
        for (x, sample) in (start..).zip(samples) {
            let new = Sample::from(self.bits(x)) << 32 | owner;
            *sample = if new > *sample { new } else { *sample };
        }
    }
}

/// Depth-tests transparent faces against the final depths and reports the samples at which they are visible. At equal
/// reversed depth the transparent face is in front. `depth` returns the bits of the reversed depth at a sample.
pub(super) fn look_through(
    depth: impl Fn(u16, u16) -> u32,
    raster: &mut Raster,
    faces: &Faces,
    passage: &Passage,
    stats: &mut Stats,
    seen: &mut Collector,
) {
    if let FaceSource::Item(item, _) = faces.source {
        let mut glass = TransparentSink {
            depth,
            is_seen: false,
            seen,
            item,
            item_start: faces.item_start,
        };
        raster.run(faces, passage, &mut glass, stats);
    }
}

/// Depth-tests a batch of transparent faces of one item.
struct TransparentSink<'a, D> {
    depth: D,
    /// Whether any sample of the batch is visible. Without a canvas, the rest of the batch is then skipped.
    is_seen: bool,
    seen: &'a mut Collector,
    item: ItemIndex,
    item_start: u32,
}

impl<D: Fn(u16, u16) -> u32> Sink for TransparentSink<'_, D> {
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        self.is_done()
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        self.is_seen && !self.seen.paints
    }

    fn band(&mut self, band: &Band, triangle: &Triangle) {
        if self.is_done() {
            return;
        }
        for (y, [x0, x1]) in band.rows() {
            let row = triangle.row(y);
            for x in x0..x1 {
                let bits = row.bits(i32::from(x));
                if bits >= (self.depth)(x, y) {
                    self.is_seen = true;
                    self.seen.glass(
                        x,
                        y,
                        f32::from_bits(bits),
                        self.item,
                        triangle.owner - self.item_start,
                    );
                }
            }
        }
    }
}
