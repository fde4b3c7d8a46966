//! What is stored at each sample: how near its owner is, and which face that is, in one number.

use super::raster::{Band, Raster, Sink};
use super::report::Report;
use super::trace::Trace;
use super::triangle::{Row, Triangle};
use crate::aperture::Rect;
use crate::canvas::Canvas;
use crate::collector::Collector;
use crate::faces::{FaceSource, Faces};
use crate::geometry::{ItemId, Owners};
use crate::passage::Passage;
use crate::stats::Stats;
use std::ops::Range;

/// Reversed depth in the upper half, the complement of the face's number in the lower: the greater number is what is
/// seen, so that of equally near faces the lower one owns, whatever comes first.
pub(super) type Sample = u64;

/// Nothing is seen: infinitely far.
pub(super) const OPEN: Sample = 0;
/// Outside the aperture: nearer than anything.
pub(super) const COVERED: Sample = Sample::MAX;

/// The lower half for a face. One is added so that no face shares it with covered samples.
#[inline(always)]
pub(super) fn lower_half(owner: u32) -> u32 {
    !(owner + 1)
}

/// The face's number; `None` where the sample is open or covered.
#[inline(always)]
pub(super) fn owner_of(lower_half: u32) -> Option<u32> {
    (!lower_half).checked_sub(1).filter(|_| lower_half != OPEN as u32)
}

/// The bits of the reversed depth.
#[inline(always)]
pub(super) fn rev_depth(sample: Sample) -> u32 {
    (sample >> 32) as u32
}

/// Samples of a passage's rectangle, row after row.
#[derive(Default)]
pub(super) struct Samples {
    pub(super) width: usize,
    pub(super) rect: Rect,
    samples: Vec<Sample>,
    runs: Vec<[u16; 2]>,
    pub(super) trace: Option<Trace>,
}

impl Samples {
    /// Makes room for the aperture's rectangle; what the samples hold is not touched.
    pub(super) fn shape(&mut self, passage: &Passage, trace: bool) {
        self.rect = passage.aperture.rect();
        self.width = usize::from(self.rect.x1);
        let needed = self.width * usize::from(self.rect.y1 - self.rect.y0);
        if self.samples.len() < needed {
            self.samples.resize(needed, OPEN);
        }
        self.trace = trace.then(|| Trace::new(&self.rect));
    }

    /// Opens the samples of the aperture, covers the others of its rectangle; `row` is told the open runs of each.
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

    /// Where columns `x0..x1` of row `y` are kept: from the first row on, for a strip far down is as small as one on top.
    #[inline(always)]
    fn run(&self, y: u16, x0: u16, x1: u16) -> Range<usize> {
        let start = usize::from(y - self.rect.y0) * self.width;
        start + usize::from(x0)..start + usize::from(x1)
    }

    /// Reports and paints the owners that are left.
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

    /// Bits of the reversed depth at a sample.
    pub(super) fn depth(&self, x: u16, y: u16) -> u32 {
        rev_depth(self.row(y, x, x + 1)[0])
    }

    /// Memory in bytes for a screen of this size.
    pub(super) fn needs_bytes(size: [u32; 2]) -> u64 {
        u64::from(size[0]) * u64::from(size[1]) * size_of::<Sample>() as u64
    }

    /// A new batch of faces begins.
    pub(super) fn begin_batch(&mut self) {
        if let Some(trace) = &mut self.trace {
            trace.batch += 1;
        }
    }

    /// Lets a triangle own those samples of a run at which it is nearest.
    #[inline(always)]
    pub(super) fn keep_nearest(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        const LANES: usize = 8;
        let row = triangle.row(y);
        let owner = Sample::from(lower_half(triangle.owner));
        let samples = self.row_mut(y, x0, x1);
        let start = i32::from(x0);
        // Whole lanes first, so that the compiler widens the loop; then the last lanes again, which overlap them: to
        // be held against the same number once more changes nothing.
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

    /// Lets a triangle own a run of samples, but for those outside the aperture, whatever owned them.
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

    /// Counts a test of each sample of a run; those that `owner` owns came with the batch at hand.
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
    /// Lets `owner` own those of the samples, from column `start` on, at which it is nearest.
    #[inline(always)]
    fn own(&self, start: i32, samples: &mut [Sample], owner: Sample) {
        for (x, sample) in (start..).zip(samples) {
            let new = Sample::from(self.bits(x)) << 32 | owner;
            *sample = if new > *sample { new } else { *sample };
        }
    }
}

/// Holds see-through faces against final depths; at equal reversed depth they are in front. `depth` gives the bits of the
/// reversed depth at a sample.
pub(super) fn look_through(
    depth: impl Fn(u16, u16) -> u32,
    raster: &mut Raster,
    faces: &Faces,
    passage: &Passage,
    stats: &mut Stats,
    seen: &mut Collector,
) {
    if let FaceSource::Item(item, _) = faces.source {
        let mut glass = Glass {
            depth,
            is_seen: false,
            seen,
            item,
            item_start: faces.item_start,
        };
        raster.run(faces, passage, &mut glass, stats);
    }
}

struct Glass<'a, D> {
    depth: D,
    /// Is any of the batch seen? Who does not paint wants to know no more.
    is_seen: bool,
    seen: &'a mut Collector,
    item: ItemId,
    item_start: u32,
}

impl<D: Fn(u16, u16) -> u32> Sink for Glass<'_, D> {
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
