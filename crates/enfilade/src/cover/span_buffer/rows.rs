//! Rows of spans, and the insertion of runs.

use super::compare::{NewFace, Relation};
use super::face::Face;
use crate::raster::{BAND, Band};
use crate::stats::SpanStats;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use std::hint::black_box;

/// Samples of one row that one face owns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) x0: u16,
    pub(super) x1: u16,
    /// Index of the face among those kept; [`COVERED`] outside the aperture.
    pub(super) face: u32,
    /// Bounds of its reversed depth, rounded outwards.
    pub(super) farthest: f32,
    pub(super) nearest: f32,
}

/// Face of the spans outside the aperture, which are nearer than anything.
pub(super) const COVERED: u32 = u32::MAX;

/// The spans of one row, left to right.
#[derive(Default)]
pub(super) struct Row {
    pub(super) spans: Vec<Span>,
    /// End column of each span; kept apart because it is searched far faster than the spans themselves.
    ends: Vec<u16>,
    /// Minimum reversed depth of the samples inside the aperture's rectangle; 0 if one is open. Never nearer than the
    /// truth.
    farthest: f32,
    /// Whether `farthest` may have grown since it was computed.
    stale: bool,
}

/// All rows of a passage's rectangle.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) rect: Rect,
    pub(super) rows: Vec<Row>,
    /// Spans that replace those a run overlaps.
    replacement: Vec<Span>,
    runs: Vec<[u16; 2]>,
}

impl Rows {
    /// Clears all rows and opens the samples of the aperture.
    pub(super) fn clear(&mut self, passage: &Passage) {
        self.rect = passage.aperture.rect();
        let Rect { x0, y0, x1, y1 } = self.rect;
        if self.rows.len() < usize::from(y1) {
            self.rows.resize_with(usize::from(y1), Row::default);
        }
        for y in y0..y1 {
            let row = &mut self.rows[usize::from(y)];
            row.spans.clear();
            row.ends.clear();
            row.farthest = 0.0;
            row.stale = false;
            passage.aperture.open_in_row(y, &mut self.runs);
            // Cover the columns before, between and after the open runs.
            self.runs.push([x1, x1]);
            let mut from = x0;
            for &[open, end] in &self.runs {
                if from < open {
                    row.spans.push(Span {
                        x0: from,
                        x1: open,
                        face: COVERED,
                        farthest: f32::INFINITY,
                        nearest: f32::INFINITY,
                    });
                    row.ends.push(open);
                }
                from = end;
            }
        }
    }

    /// Returns `true` if geometry with reversed depth `nearest` may be visible in `rect`.
    #[inline(always)]
    pub(super) fn sees(&mut self, rect: &Rect, nearest: f32) -> bool {
        // Test the middle row first: most visible rectangles are visible there.
        let middle = (rect.y0 + rect.y1) / 2;
        if self.rows[usize::from(middle)].sees(rect, nearest, &self.rect) {
            return true;
        }
        // A plain loop, because closures passed to `any` are not compiled for the SIMD level.
        for row in &mut self.rows[usize::from(rect.y0)..usize::from(rect.y1)] {
            if row.sees(rect, nearest, &self.rect) {
                return true;
            }
        }
        false
    }

    /// Returns, for each row of a band, the index of the first span that the run may overlap.
    ///
    /// Looked up for all rows before any is changed, so that their cache misses overlap.
    #[inline(always)]
    pub(super) fn insert_indices(&self, band: &Band) -> [u16; BAND] {
        let mut places = [0; BAND];
        for (y, [x0, _]) in band.rows() {
            let row = &self.rows[usize::from(y)];
            let place = row.first_beyond(x0);
            black_box(row.spans.get(place).map_or(0, |span| span.x0));
            places[usize::from(y - band.y)] = place as u16;
        }
        places
    }

    /// Inserts a run: the face becomes the owner of the samples at which it is nearest. `place` is the index of the
    /// first span that the run may overlap.
    #[inline(always)]
    pub(super) fn insert(
        &mut self,
        y: u16,
        run: [u16; 2],
        place: u16,
        new: &mut NewFace,
        stats: &mut SpanStats,
    ) {
        let [x0, x1] = run;
        let row = &mut self.rows[usize::from(y)];
        let replacement = &mut self.replacement;
        replacement.clear();
        new.begin_run(y);
        let mut next = usize::from(place);
        // Spans before `first` stay; those from `first` to `next` are replaced by `replacement`.
        let mut first = next;
        let (mut x, mut changed) = (x0, false);
        while x < x1 {
            let Some(&span) = row.spans.get(next).filter(|span| span.x0 < x1) else {
                push(replacement, new.span(x, x1));
                changed = true;
                break;
            };
            if span.x0 > x {
                push(replacement, new.span(x, span.x0));
                x = span.x0;
                changed = true;
            }
            let end = span.x1.min(x1);
            let relation = new.compare(&span, x, end, stats);
            if relation == Relation::Behind && !changed {
                x = end;
                next += 1;
                first = next;
                continue;
            }
            changed = true;
            if span.x0 < x {
                replacement.push(Span { x1: x, ..span });
            }
            let theirs = |x0, x1| Span { x0, x1, ..span };
            match relation {
                Relation::Before => push(replacement, new.span(x, end)),
                Relation::Behind => push(replacement, theirs(x, end)),
                Relation::Crosses { at, before_first } => {
                    if before_first {
                        push(replacement, new.span(x, at));
                        push(replacement, theirs(at, end));
                    } else {
                        push(replacement, theirs(x, at));
                        push(replacement, new.span(at, end));
                    }
                }
            }
            if span.x1 > x1 {
                push(replacement, theirs(x1, span.x1));
            }
            x = end;
            next += 1;
        }
        if changed {
            row.stale = true;
            row.replace(first, next, replacement);
        }
    }
}

/// Appends a span, or extends the last one if it belongs to the same face.
#[inline(always)]
fn push(replacement: &mut Vec<Span>, span: Span) {
    match replacement.last_mut() {
        Some(last) if last.face == span.face && last.x1 == span.x0 => {
            last.x1 = span.x1;
            last.farthest = last.farthest.min(span.farthest);
            last.nearest = last.nearest.max(span.nearest);
        }
        _ => replacement.push(span),
    }
}

impl Row {
    /// Returns the index of the first span that ends after column `x`.
    ///
    /// Counts linearly: a row has some hundred spans, of which SIMD counts sixteen at once. A binary search waits for
    /// memory and mispredicts a branch at each step.
    #[inline(always)]
    fn first_beyond(&self, x: u16) -> usize {
        // At most 2¹⁶ − 1 columns, so the count fits.
        usize::from(
            self.ends
                .iter()
                .fold(0_u16, |count, &end| count + u16::from(end <= x)),
        )
    }

    /// Replaces the spans `first..after`.
    #[inline(always)]
    fn replace(&mut self, first: usize, after: usize, replacement: &[Span]) {
        let (old, new, length) = (after - first, replacement.len(), self.spans.len());
        if new > old {
            self.spans.resize(length + new - old, replacement[0]);
            self.ends.resize(length + new - old, 0);
        }
        if new != old && after < length {
            self.spans.copy_within(after..length, first + new);
            self.ends.copy_within(after..length, first + new);
        }
        if new < old {
            self.spans.truncate(length + new - old);
            self.ends.truncate(length + new - old);
        }
        let places = self.spans[first..first + new].iter_mut();
        for ((place, end), replacement) in places.zip(&mut self.ends[first..first + new]).zip(replacement) {
            *place = *replacement;
            *end = replacement.x1;
        }
    }

    #[inline(always)]
    fn sees(&mut self, rect: &Rect, nearest: f32, all: &Rect) -> bool {
        if nearest < self.farthest {
            return false;
        }
        if self.stale && rect.x1 - rect.x0 > (all.x1 - all.x0) / 4 {
            self.stale = false;
            self.farthest = self.farthest_in(all.x0, all.x1);
            if nearest < self.farthest {
                return false;
            }
        }
        let mut x = rect.x0;
        let first = self.first_beyond(rect.x0);
        for span in &self.spans[first..] {
            if span.x0 > x || span.farthest <= nearest {
                return true;
            }
            x = span.x1;
            if x >= rect.x1 {
                return false;
            }
        }
        true
    }

    /// Returns `true` if something may be visible in columns `x0..x1`: if a column is open, or if `past` returns `true`
    /// for a span and its columns there.
    pub(super) fn shows(&self, x0: u16, x1: u16, past: impl Fn(&Span, u16, u16) -> bool) -> bool {
        let mut x = x0;
        let first = self.first_beyond(x0);
        for span in &self.spans[first..] {
            if span.x0 > x || (span.face != COVERED && past(span, x, span.x1.min(x1))) {
                return true;
            }
            x = span.x1;
            if x >= x1 {
                return false;
            }
        }
        true
    }

    /// Returns the minimum reversed depth in columns `x0..x1`, which contain all spans; 0 if one is open.
    fn farthest_in(&self, x0: u16, x1: u16) -> f32 {
        let mut x = x0;
        let mut farthest = f32::INFINITY;
        for span in &self.spans {
            if span.x0 > x {
                return 0.0;
            }
            farthest = farthest.min(span.farthest);
            x = span.x1;
        }
        if x < x1 { 0.0 } else { farthest }
    }

    /// Returns the span that contains column `x`.
    pub(super) fn at(&self, x: u16) -> Option<&Span> {
        self.spans.get(self.first_beyond(x)).filter(|span| span.x0 <= x)
    }
}

/// Sets `owns` for the faces that own a sample, so that the others may be dropped.
pub(super) fn mark_owners(rows: &Rows, faces: &[Face], owns: &mut Vec<bool>) {
    owns.clear();
    owns.resize(faces.len(), false);
    for y in rows.rect.y0..rows.rect.y1 {
        for span in rows.rows[usize::from(y)]
            .spans
            .iter()
            .filter(|span| span.face != COVERED)
        {
            owns[span.face as usize] = true;
        }
    }
}
