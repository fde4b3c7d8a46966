//! Turns the owners of samples into what was seen, and into spans.

use super::samples::{OPEN, Sample, owner_of};
use super::trace::Trace;
use crate::aperture::Rect;
use crate::canvas::{Canvas, Span};
use crate::content::{Content, Owner};
use crate::seen::{GlassSample, ReportBuffers, Seen, report_owners};

/// Gathers runs of owners, left to right and row after row.
pub(super) struct Report<'a> {
    content: &'a Content,
    seen: &'a mut Seen,
    canvas: Option<&'a mut dyn Canvas>,
    /// The run at hand: the lower half of its samples, and its columns.
    lower_half: u32,
    x0: u16,
    x1: u16,
    last: Option<Owner>,
    buffers: ReportBuffers,
}

impl<'a> Report<'a> {
    pub(super) fn new(
        content: &'a Content,
        seen: &'a mut Seen,
        canvas: Option<&'a mut dyn Canvas>,
    ) -> Report<'a> {
        Report {
            content,
            buffers: std::mem::take(&mut seen.report),
            seen,
            canvas,
            lower_half: OPEN as u32,
            x0: 0,
            x1: 0,
            last: None,
        }
    }

    /// Samples of the row at hand, from column `x0` on.
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

    /// Samples `x0..x1` of the row at hand have this lower half.
    #[inline]
    pub(super) fn run(&mut self, x0: u16, x1: u16, lower_half: u32) {
        if lower_half == self.lower_half && x0 == self.x1 {
            self.x1 = x1;
            return;
        }
        self.end_run();
        (self.x0, self.x1, self.lower_half) = (x0, x1, lower_half);
    }

    fn end_run(&mut self) {
        if self.x0 < self.x1
            && let Some(number) = owner_of(self.lower_half)
        {
            let owner = self.content.owner(number, self.last);
            if let Owner::Face(item, face) = owner
                && self.last != Some(owner)
            {
                let cluster = self.content.mesh_of(item).cluster_of(face) as u32;
                let owners = &mut self.buffers.owners;
                if owners.last() != Some(&(item, cluster)) {
                    owners.push((item, cluster));
                }
            }
            self.last = Some(owner);
            self.buffers.row.push((self.x0, self.x1, owner));
        }
        self.x0 = self.x1;
    }

    /// The row at hand is complete: it is row `y`.
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
                trace.tell(y, rect, *canvas);
            }
        }
    }

    /// Reports what was seen, glass included.
    pub(super) fn finish(mut self) {
        let (seen, owners) = (self.seen, &mut self.buffers.owners);
        let same_face = |a: &GlassSample, b: &GlassSample| (a.item, a.face) == (b.item, b.face);
        for run in seen.glass.chunk_by(same_face) {
            let GlassSample { item, face, .. } = run[0];
            owners.push((item, self.content.mesh_of(item).cluster_of(face) as u32));
        }
        report_owners(owners, self.content, seen);
        owners.clear();
        seen.report = self.buffers;
    }
}
