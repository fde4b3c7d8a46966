//! Turns the owners of samples into what was seen, and into spans.

use super::samples::{OPEN, Sample, owner_of};
use super::trace::Trace;
use crate::aperture::Rect;
use crate::canvas::{Canvas, Span};
use crate::content::{Content, ItemId, Owner};
use crate::seen::{GlassSample, Seen, SeenOpening, report_owners};

/// Gathers runs of owners, left to right and row after row.
pub(super) struct Report<'a> {
    content: &'a Content,
    canvas: Option<&'a mut dyn Canvas>,
    /// The run at hand: the lower half of its samples, and its columns.
    lower_half: u32,
    x0: u16,
    x1: u16,
    last: Option<Owner>,
    owners: Vec<(ItemId, u32)>,
    openings: Vec<SeenOpening>,
    row: Vec<(u16, u16, Owner)>,
    spans: Vec<Span>,
    samples_owned: u64,
}

impl<'a> Report<'a> {
    pub(super) fn new(content: &'a Content, canvas: Option<&'a mut dyn Canvas>) -> Report<'a> {
        Report {
            content,
            canvas,
            lower_half: OPEN as u32,
            x0: 0,
            x1: 0,
            last: None,
            owners: Vec::new(),
            openings: Vec::new(),
            row: Vec::new(),
            spans: Vec::new(),
            samples_owned: 0,
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
                if self.owners.last() != Some(&(item, cluster)) {
                    self.owners.push((item, cluster));
                }
            }
            self.last = Some(owner);
            self.row.push((self.x0, self.x1, owner));
        }
        self.x0 = self.x1;
    }

    /// The row at hand is complete: it is row `y`.
    pub(super) fn end_row(&mut self, y: u16, rect: &Rect, trace: Option<&Trace>) {
        self.end_run();
        [self.x0, self.x1] = [0, 0];
        self.spans.clear();
        for (x0, x1, owner) in self.row.drain(..) {
            let Owner::Opening(opening) = owner else {
                self.samples_owned += u64::from(x1 - x0);
                self.spans.push(Span {
                    x0,
                    x1,
                    owner,
                    see_through: false,
                });
                continue;
            };
            let known = self.openings.iter().position(|seen| seen.opening == opening);
            let place = known.unwrap_or_else(|| {
                self.openings.push(SeenOpening {
                    opening,
                    rows: Some(Default::default()),
                });
                self.openings.len() - 1
            });
            if let Some(rows) = &mut self.openings[place].rows {
                rows.push(y, x0, x1);
            }
        }
        if let Some(canvas) = &mut self.canvas {
            canvas.row(y, &self.spans);
            if let Some(trace) = trace {
                trace.tell(y, rect, *canvas);
            }
        }
    }

    /// Reports what was seen, glass included.
    pub(super) fn finish(mut self, seen: &mut Seen) {
        let same_face = |a: &GlassSample, b: &GlassSample| (a.item, a.face) == (b.item, b.face);
        for run in seen.glass.chunk_by(same_face) {
            let GlassSample { item, face, .. } = run[0];
            self.owners
                .push((item, self.content.mesh_of(item).cluster_of(face) as u32));
        }
        seen.samples_owned += self.samples_owned;
        report_owners(&mut self.owners, self.content, seen);
        seen.openings.append(&mut self.openings);
    }
}
