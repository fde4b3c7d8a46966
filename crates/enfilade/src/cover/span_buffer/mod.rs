//! s-buffer: a scanline cover that stores the visible spans of each row, and nothing of what is hidden.
//!
//! A face is inserted row by row and replaces the spans that it hides; shading comes last, once per sample. Most depth
//! comparisons are avoided by coherence: with the row above, with the span to the left, with the adjacent face.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, sections 1 and 2.
//! Cost: a face O(rows · (log spans of a row + spans it overlaps)); finish O(spans). Memory grows with the visible
//!     edges, not with the resolution.
//! Exact: intersecting faces are split where they cross; nothing is rounded to cells.

mod compare;
mod face;
mod rows;
mod show;

use super::report::Report;
use super::samples::{look_through, lower_half};
use super::trace::Trace;
use super::{Coarse, Cover, Paints};
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::mesh::NONE;
use crate::order::Unsorted;
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::stats::{SpanStats, Stats};
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use compare::{CachedOrder, NewFace};
use face::Face;
use glam::DVec3;
use rows::{COVERED, Rows, mark_owners};

/// Rows of non-overlapping spans; each sample is painted once. Faces may be added in any order.
///
/// Memory grows with the visible edges, not with the resolution.
#[doc(alias = "s-buffer")]
#[doc(alias = "scanline")]
#[derive(Default)]
pub struct SpanBuffer {
    raster: Raster,
    rows: Rows,
    /// Faces that owned a sample when they were inserted; those that own none any more are dropped from time to time.
    kept: Vec<Face>,
    cached_orders: Vec<CachedOrder>,
    /// Number of faces after the last drop; all of them owned a sample.
    owners: usize,
    /// Serial numbers of the last face and the last batch.
    turn: u32,
    batch: u32,
    /// Serial numbers of the faces of the current batch, by their number in the batch.
    turns: Vec<u32>,
    trace: Option<Trace>,
    compaction: Compaction,
}

/// Buffers for dropping hidden faces.
#[derive(Default)]
struct Compaction {
    owns: Vec<bool>,
    /// New index of each face that owns a sample.
    places: Vec<u32>,
}

/// Number of faces kept in excess of twice those that own a sample, before the others are dropped.
const ROOM: usize = 1 << 16;

impl Cover for SpanBuffer {
    type Needs = Unsorted;

    const NAME: &'static str = "SpanBuffer";

    fn test(&mut self, region: &Region) -> Visibility {
        if self.rows.sees(&region.rect, region.nearest) {
            Visibility::Partial
        } else {
            Visibility::Hidden
        }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        // Assumes that many faces cover about one pixel; in practice there are far fewer.
        const BYTES_PER_SAMPLE: u64 = 48;
        u64::from(size[0]) * u64::from(size[1]) * BYTES_PER_SAMPLE
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Spans);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.show_spans(passage, canvas);
    }
}

impl Paints for SpanBuffer {
    const PRIMES: bool = true;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        self.rows.clear(passage);
        self.kept.clear();
        self.cached_orders.clear();
        [self.turn, self.batch] = [0, 0];
        self.owners = 0;
        self.trace = trace.then(|| Trace::new(&self.rows.rect));
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        if self.kept.len() > 2 * self.owners + ROOM {
            self.drop_hidden();
        }
        self.batch += 1;
        self.turns.clear();
        self.turns.resize(faces.count(), 0);
        let mut raster = std::mem::take(&mut self.raster);
        let mut insertion = Insertion {
            buffer: self,
            faces,
            now: None,
            counts: stats.spans,
        };
        raster.run(faces, passage, &mut insertion, stats);
        stats.spans = insertion.counts;
        self.raster = raster;
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let (rows, kept) = (&self.rows, &self.kept);
        let depth = |x: u16, y: u16| match rows.rows[usize::from(y)].at(x).map(|span| span.face) {
            None => 0,
            Some(COVERED) => u32::MAX,
            Some(face) => kept[face as usize].triangle.row(y).bits(i32::from(x)),
        };
        look_through(depth, &mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        let mut report = Report::new(owners, seen, canvas.map(|canvas| canvas as &mut dyn Canvas));
        let rect = self.rows.rect;
        for y in rect.y0..rect.y1 {
            let spans = self.rows.rows[usize::from(y)].spans.iter();
            for span in spans.filter(|span| span.face != COVERED) {
                let face = &self.kept[span.face as usize];
                report.run(span.x0, span.x1, lower_half(face.triangle.owner));
                if let Some(trace) = &mut self.trace {
                    trace.own(y, span.x0, span.x1, face.batch);
                }
            }
            report.end_row(y, &rect, self.trace.as_ref());
        }
        report.finish();
    }
}

impl Coarse for SpanBuffer {
    fn clear_cells(&mut self, passage: &Passage) {
        self.clear(passage, false);
    }

    /// Uses the depth of each span inside `rect`, not its farthest depth: no exact test of faces follows.
    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool {
        let (rows, kept) = (&self.rows.rows, &self.kept);
        (rect.y0..rect.y1).any(|y| {
            rows[usize::from(y)].shows(rect.x0, rect.x1, |span, x0, x1| {
                let theirs = kept[span.face as usize].triangle.row(y);
                let [left, right] = [x0, x1 - 1].map(|x| (theirs.at(x) as f32).next_down());
                span.farthest <= nearest && left.min(right) <= nearest
            })
        })
    }

    fn sees_plane(&mut self, cells: &Band, rev_depth: &Triangle) -> bool {
        let (rows, kept) = (&self.rows.rows, &self.kept);
        cells.rows().any(|(y, [x0, x1])| {
            let mine = rev_depth.row(y);
            rows[usize::from(y)].shows(x0, x1, |span, x0, x1| {
                let theirs = kept[span.face as usize].triangle.row(y);
                // Both planes are linear, and so is their difference.
                [x0, x1 - 1]
                    .into_iter()
                    .any(|x| mine.beyond(x) >= theirs.beyond(x))
            })
        })
    }

    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle) {
        if self.kept.len() > 2 * self.owners + ROOM {
            self.drop_hidden();
        }
        self.turn += 1;
        // No corners, so reversed depth alone decides which face is nearer.
        let face = Face::new(*rev_depth, [DVec3::NAN; 3], 0);
        let (kept, cached_orders) = (&mut self.kept, &mut self.cached_orders);
        let mut new = NewFace::new(&face, self.turn, [0; 3], kept, cached_orders, None);
        let places = self.rows.insert_indices(cells);
        for (y, run) in cells.rows() {
            let place = places[usize::from(y - cells.y)];
            self.rows
                .insert(y, run, place, &mut new, &mut SpanStats::default());
        }
    }
}

impl SpanBuffer {
    /// Drops the faces that own no sample any more.
    fn drop_hidden(&mut self) {
        let Compaction { owns, places } = &mut self.compaction;
        mark_owners(&self.rows, &self.kept, owns);
        let mut left = 0;
        places.clear();
        places.extend(owns.iter().map(|&owns| {
            left += u32::from(owns);
            left - u32::from(owns)
        }));
        let mut owner = owns.iter();
        self.kept.retain(|_| owner.next().is_some_and(|&owns| owns));
        let mut owner = owns.iter();
        self.cached_orders
            .retain(|_| owner.next().is_some_and(|&owns| owns));
        for row in &mut self.rows.rows[usize::from(self.rows.rect.y0)..usize::from(self.rows.rect.y1)] {
            for span in row.spans.iter_mut().filter(|span| span.face != COVERED) {
                span.face = places[span.face as usize];
            }
        }
        self.owners = self.kept.len();
    }
}

/// A batch that is being inserted.
struct Insertion<'a> {
    buffer: &'a mut SpanBuffer,
    faces: &'a Faces<'a>,
    /// The current face, the serial numbers of its neighbours, and its index among the kept faces once it owns a
    /// sample.
    now: Option<(Face, [u32; 3], Option<u32>)>,
    counts: SpanStats,
}

impl Sink for Insertion<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        !self.buffer.rows.sees(rect, nearest)
    }

    fn begin(&mut self, triangle: &Triangle, corners: &[DVec3; 3]) {
        let SpanBuffer {
            turn, turns, batch, ..
        } = self.buffer;
        *turn += 1;
        let mut face = Face::new(*triangle, *corners, *batch);
        let number = (triangle.owner - self.faces.first_owner) as usize;
        turns[number] = *turn;
        let mut neighbours = [0; 3];
        // Only if all faces are triangles are the corners of a face those of its one triangle.
        if self.faces.starts.is_none() && !self.faces.neighbours.is_empty() {
            face.number = number as u8;
            face.neighbours = std::array::from_fn(|edge| self.faces.neighbours[3 * number + edge]);
            neighbours = face.neighbours.map(|other| {
                if other == NONE {
                    0
                } else {
                    turns[usize::from(other)]
                }
            });
        }
        self.now = Some((face, neighbours, None));
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, _triangle: &Triangle) {
        let Some((face, neighbours, place)) = &mut self.now else {
            return;
        };
        let SpanBuffer {
            rows,
            kept,
            cached_orders,
            turn,
            trace,
            ..
        } = self.buffer;
        let mut new = NewFace::new(face, *turn, *neighbours, kept, cached_orders, *place);
        let places = rows.insert_indices(band);
        for (y, run) in band.rows() {
            let place = places[usize::from(y - band.y)];
            rows.insert(y, run, place, &mut new, &mut self.counts);
            if let Some(trace) = trace {
                trace.test(y, run[0], run[1]);
            }
        }
        *place = new.index();
    }
}
