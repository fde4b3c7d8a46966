//! Converts the owners of samples to visible items, clusters and spans.

use super::samples::{OPEN, Sample, owner_of};
use super::trace::Trace;
use crate::geometry::{Owner, Owners};
use crate::ids::ItemIndex;
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, Span};
use crate::view::collector::{Collector, GlassSample, ReportBuffers, report_owners};

/// Collects runs of equal owners, left to right and row after row.
pub(super) struct Report<'a> {
    owners: &'a dyn Owners,
    seen: &'a mut Collector,
    canvas: Option<&'a mut dyn Canvas>,
    /// The current run: the lower half of its samples, and its columns.
    lower_half: u32,
    x0: u16,
    x1: u16,
    /// The owner resolved last.
    last: Option<Owner>,
    buffers: ReportBuffers,
}

/// Size of the direct-mapped caches of faces and clusters already reported; later entries replace earlier ones.
const REMEMBERED: usize = 4096;

impl<'a> Report<'a> {
    pub(super) fn new(
        owners: &'a dyn Owners,
        seen: &'a mut Collector,
        canvas: Option<&'a mut dyn Canvas>,
    ) -> Report<'a> {
        let mut buffers = std::mem::take(&mut seen.report);
        buffers.faces.clear();
        buffers.faces.resize(REMEMBERED, OPEN as u32);
        buffers.clusters.clear();
        buffers.clusters.resize(REMEMBERED, (ItemIndex(u32::MAX), 0));
        Report {
            owners,
            buffers,
            seen,
            canvas,
            lower_half: OPEN as u32,
            x0: 0,
            x1: 0,
            last: None,
        }
    }

    /// Adds samples of the current row, starting at column `x0`.
    #[inline]
    pub(super) fn samples(&mut self, x0: u16, samples: &[Sample]) {
        let mut x = x0;
        let mut rest = samples;
        while let Some(&first) = rest.first() {
            let lower_half = first as u32;
            let length = rest
                .iter()
                .position(|&sample| sample as u32 != lower_half)
                .unwrap_or(rest.len());
            self.run(x, x + length as u16, lower_half);
            x += length as u16;
            rest = &rest[length..];
        }
    }

    /// Adds a run `x0..x1` of the current row whose samples have this lower half.
    #[inline]
    pub(super) fn run(&mut self, x0: u16, x1: u16, lower_half: u32) {
        if lower_half == self.lower_half && x0 == self.x1 {
            self.x1 = x1;
            return;
        }
        self.end_run();
        (self.x0, self.x1, self.lower_half) = (x0, x1, lower_half);
    }

    #[inline]
    fn end_run(&mut self) {
        if self.x0 < self.x1 && owner_of(self.lower_half).is_some() {
            let samples = u64::from(self.x1 - self.x0);
            if (self.canvas.is_some() || !self.is_known(self.lower_half, samples))
                && let Some(owner) = self.resolve(self.lower_half)
            {
                self.buffers.row.push((self.x0, self.x1, owner));
            }
        }
        self.x0 = self.x1;
    }

    /// Whether samples must be added row by row. If not, they may come in any order through [`Report::some`] and
    /// [`Report::eight`].
    pub(super) fn wants_rows(&self) -> bool {
        self.canvas.is_some() || self.owners.has_openings()
    }

    /// Adds `samples` samples with this lower half. Allowed only if [`Report::wants_rows`] is `false`.
    #[inline(always)]
    pub(super) fn some(&mut self, lower_half: u32, samples: u64) {
        if owner_of(lower_half).is_some() && !self.is_known(lower_half, samples) {
            self.resolve(lower_half);
            self.seen.samples_owned += samples;
        }
    }

    /// Adds eight samples. Allowed only if [`Report::wants_rows`] is `false`.
    #[inline(always)]
    pub(super) fn eight(&mut self, samples: &[Sample; 8]) {
        let first = samples[0] as u32;
        if samples
            .iter()
            .fold(true, |same, &sample| same & (sample as u32 == first))
        {
            self.some(first, 8);
            return;
        }
        for &sample in samples {
            self.some(sample as u32, 1);
        }
    }

    /// Returns `true`, and counts the samples, if this face is in the cache of reported faces.
    #[inline(always)]
    fn is_known(&mut self, lower_half: u32, samples: u64) -> bool {
        let known = self.buffers.faces[lower_half as usize % REMEMBERED] == lower_half;
        self.seen.samples_owned += if known { samples } else { 0 };
        known
    }

    /// Resolves the owner of a sample and adds its cluster to the visible ones; `None` if the sample is open or
    /// covered.
    #[inline(never)]
    fn resolve(&mut self, lower_half: u32) -> Option<Owner> {
        let owner = self.owners.owner(owner_of(lower_half)?, self.last);
        if let Owner::Face(item, face) = owner
            && self.last != Some(owner)
        {
            let cluster = self.owners.cluster_of(item, face);
            let ReportBuffers {
                owners,
                faces,
                clusters,
                ..
            } = &mut self.buffers;
            faces[lower_half as usize % REMEMBERED] = lower_half;
            let place = item.0.wrapping_mul(0x9E37_79B1).wrapping_add(cluster) as usize % REMEMBERED;
            if clusters[place] != (item, cluster) {
                clusters[place] = (item, cluster);
                owners.push((item, cluster));
            }
        }
        self.last = Some(owner);
        Some(owner)
    }

    /// Ends the current row, which is row `y`, and emits its spans.
    pub(super) fn end_row(&mut self, y: u16, rect: &Rect, trace: Option<&Trace>) {
        self.end_run();
        [self.x0, self.x1] = [0, 0];
        let ReportBuffers { row, spans, .. } = &mut self.buffers;
        spans.clear();
        for (x0, x1, owner) in row.drain(..) {
            if let Owner::Opening(opening) = owner {
                self.seen.add_to_opening(opening, y, x0, x1);
                continue;
            }
            self.seen.samples_owned += u64::from(x1 - x0);
            if !owner.item().is_none_or(|item| self.owners.is_drawn(item)) {
                continue;
            }
            spans.push(Span {
                x0,
                x1,
                owner,
                see_through: false,
            });
        }
        if let Some(canvas) = &mut self.canvas {
            canvas.row(y, spans);
            if let Some(trace) = trace {
                trace.emit_row(y, rect, *canvas);
            }
        }
    }

    /// Reports the visible clusters, including transparent ones.
    pub(super) fn finish(mut self) {
        let (seen, owners) = (self.seen, &mut self.buffers.owners);
        let same_face = |a: &GlassSample, b: &GlassSample| (a.item, a.face) == (b.item, b.face);
        for run in seen.glass.chunk_by(same_face) {
            let GlassSample { item, face, .. } = run[0];
            owners.push((item, self.owners.cluster_of(item, face)));
        }
        report_owners(owners, self.owners, seen);
        owners.clear();
        seen.report = self.buffers;
    }
}
