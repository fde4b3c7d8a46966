//! Rows of spans, and how a run of samples goes in.

use super::compare::{NewFace, Relation};
use super::face::Face;
use crate::aperture::Rect;
use crate::cover::raster::{BAND, Band};
use crate::passage::Passage;
use crate::stats::SpanStats;
use std::hint::black_box;

/// Samples of one row that one face owns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) x0: u16,
    pub(super) x1: u16,
    /// The face, by its place among those kept; [`COVERED`] outside the aperture.
    pub(super) face: u32,
    /// How far and how near it comes at the most.
    pub(super) farthest: f32,
    pub(super) nearest: f32,
}

/// Outside the aperture: nearer than anything.
pub(super) const COVERED: u32 = u32::MAX;

/// The spans of one row, left to right.
#[derive(Default)]
pub(super) struct Row {
    pub(super) spans: Vec<Span>,
    /// The column after the last of each span: searched far faster than the spans themselves.
    ends: Vec<u16>,
    /// The farthest reversed depth of any sample within the aperture's rectangle: 0 where one is open.
    farthest: f32,
    /// May `farthest` have grown?
    stale: bool,
}

/// All rows of a passage's rectangle.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) rect: Rect,
    pub(super) rows: Vec<Row>,
    /// What takes the place of the spans that a run meets.
    replacement: Vec<Span>,
    runs: Vec<[u16; 2]>,
}

impl Rows {
    /// Starts over: only the aperture is open.
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
            // What lies before, between and after the open runs.
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

    /// Can anything no nearer than `nearest` be seen in `rect`?
    #[inline(always)]
    pub(super) fn sees(&mut self, rect: &Rect, nearest: f32) -> bool {
        // The middle first: where something is seen at all, it mostly is there.
        let middle = (rect.y0 + rect.y1) / 2;
        if self.rows[usize::from(middle)].sees(rect, nearest, &self.rect) {
            return true;
        }
        // A loop by hand: what `any` calls knows no SIMD.
        for row in &mut self.rows[usize::from(rect.y0)..usize::from(rect.y1)] {
            if row.sees(rect, nearest, &self.rect) {
                return true;
            }
        }
        false
    }

    /// Where runs of eight rows from `y` on go in: the places of the first spans that they may meet.
    ///
    /// Asked for all rows before any is changed: each lies somewhere else in memory, and so one waits for them together.
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

    /// Lets a face own those samples of a run at which it is nearest; `place` is that of the first span that it may meet.
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
        // The spans before this one stay as they are; those from it to `next` become `made`.
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

/// Adds a span, or what it adds to the last of the same face.
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
    /// The place of the first span that reaches beyond column `x`.
    ///
    /// Counting them all takes fewer steps than halving, which waits for memory and guesses wrong at each: a row has some
    /// hundred spans, and SIMD takes sixteen at once.
    #[inline(always)]
    fn first_beyond(&self, x: u16) -> usize {
        // No more than 2¹⁶ − 1 columns: the count fits.
        usize::from(
            self.ends
                .iter()
                .fold(0_u16, |count, &end| count + u16::from(end <= x)),
        )
    }

    /// Puts spans in the place of others.
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

    /// May something be seen in columns `x0..x1`? It may where nothing is, and where `past` says that it is seen past
    /// a span in some of its columns.
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

    /// The farthest reversed depth in columns `x0..x1`, which all spans lie in.
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

    /// The span that holds column `x`.
    pub(super) fn at(&self, x: u16) -> Option<&Span> {
        self.spans.get(self.first_beyond(x)).filter(|span| span.x0 <= x)
    }
}

/// Which faces own a sample: marks them, so that the others may be dropped.
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
