//! What is stored at each sample: how near its owner is, and which face that is, in one number.

use crate::aperture::Rect;
use crate::canvas::{Canvas, Span};
use crate::content::{Content, ItemId, Owner};
use crate::cover::raster::{Raster, Sink, Triangle};
use crate::faces::{Faces, Of};
use crate::passage::Passage;
use crate::seen::{GlassSample, Seen, SeenOpening, report_owners};
use crate::stats::Stats;

/// Nearness in the upper half, the complement of the face's number in the lower: the greater number is what is
/// seen, so that of equally near faces the lower one owns, whatever comes first.
pub(super) type Sample = u64;

/// Nothing is seen: infinitely far.
pub(super) const OPEN: Sample = 0;
/// Outside the aperture: nearer than anything.
pub(super) const COVERED: Sample = u64::MAX;

/// The lower half for a face. One is added so that no face shares it with covered samples.
#[inline(always)]
pub(super) fn owned_by(owner: u32) -> Sample {
    Sample::from(!(owner + 1))
}

/// The bits of the nearness.
#[inline(always)]
pub(super) fn nearness(sample: Sample) -> u32 {
    (sample >> 32) as u32
}

/// The face's number; `None` where the sample is open or covered.
fn owner(sample: Sample) -> Option<u32> {
    (!(sample as u32)).checked_sub(1).filter(|_| sample != OPEN)
}

/// A screen of samples.
#[derive(Default)]
pub(super) struct Samples {
    pub(super) width: usize,
    pub(super) rect: Rect,
    pub(super) samples: Vec<Sample>,
    trace: Option<Trace>,
    owners: Vec<(ItemId, u32)>,
    spans: Vec<Span>,
    runs: Vec<[u16; 2]>,
}

/// How often each sample was tested, and with which batch its owner came.
#[derive(Default)]
struct Trace {
    batch: u32,
    tested: Vec<u16>,
    batches: Vec<u32>,
}

impl Samples {
    /// Opens the samples of the aperture, covers the others of its rectangle.
    pub(super) fn clear(&mut self, passage: &Passage, trace: bool) {
        self.rect = passage.aperture.rect();
        self.width = usize::from(self.rect.x1);
        let needed = self.width * usize::from(self.rect.y1);
        if self.samples.len() < needed {
            self.samples.resize(needed, OPEN);
        }
        let mut runs = std::mem::take(&mut self.runs);
        for y in self.rect.y0..self.rect.y1 {
            passage.aperture.open_in_row(y, &mut runs);
            let rect = self.rect;
            let row = self.row(y, rect.x0, rect.x1);
            let mut x = rect.x0;
            for &[x0, x1] in &runs {
                row[usize::from(x - rect.x0)..usize::from(x0 - rect.x0)].fill(COVERED);
                row[usize::from(x0 - rect.x0)..usize::from(x1 - rect.x0)].fill(OPEN);
                x = x1;
            }
            row[usize::from(x - rect.x0)..].fill(COVERED);
        }
        self.runs = runs;
        self.trace = trace.then(|| Trace {
            batch: 0,
            tested: vec![0; needed],
            batches: vec![0; needed],
        });
    }

    #[inline(always)]
    pub(super) fn row(&mut self, y: u16, x0: u16, x1: u16) -> &mut [Sample] {
        let start = usize::from(y) * self.width;
        &mut self.samples[start + usize::from(x0)..start + usize::from(x1)]
    }

    /// A new batch of faces begins.
    pub(super) fn begin_batch(&mut self) {
        if let Some(trace) = &mut self.trace {
            trace.batch += 1;
        }
    }

    /// Counts the test of a run against a face that owns those samples which `owned` says.
    #[inline(always)]
    pub(super) fn count(&mut self, y: u16, x0: u16, x1: u16, owner: u32) {
        if self.trace.is_some() {
            self.count_traced(y, x0, x1, owner);
        }
    }

    #[cold]
    fn count_traced(&mut self, y: u16, x0: u16, x1: u16, owner: u32) {
        let start = usize::from(y) * self.width;
        let run = start + usize::from(x0)..start + usize::from(x1);
        if let Some(trace) = &mut self.trace {
            for i in run {
                trace.tested[i] = trace.tested[i].saturating_add(1);
                if self.samples[i] as u32 == owned_by(owner) as u32 {
                    trace.batches[i] = trace.batch;
                }
            }
        }
    }

    /// Holds see-through faces against the final depths; at equal nearness they are in front.
    pub(super) fn look_through(
        &self,
        raster: &mut Raster,
        faces: &Faces,
        passage: &Passage,
        stats: &mut Stats,
        seen: &mut Seen,
    ) {
        if let Of::Item(item, _) = faces.of {
            raster.run(
                faces,
                passage,
                &mut Glass {
                    samples: self,
                    seen,
                    item,
                    item_start: faces.item_start,
                },
                stats,
            );
        }
    }

    /// Reports every owner, and paints them row by row.
    pub(super) fn finish(&mut self, content: &Content, seen: &mut Seen, mut canvas: Option<&mut dyn Canvas>) {
        let rect = self.rect;
        self.owners.clear();
        let same_face = |a: &GlassSample, b: &GlassSample| (a.item, a.face) == (b.item, b.face);
        for run in seen.glass.chunk_by(same_face) {
            let GlassSample { item, face, .. } = run[0];
            self.owners
                .push((item, content.mesh_of(item).cluster_of(face) as u32));
        }
        let mut openings: Vec<SeenOpening> = Vec::new();
        let mut last = None;
        for y in rect.y0..rect.y1 {
            let start = usize::from(y) * self.width;
            let row = &self.samples[start + usize::from(rect.x0)..start + usize::from(rect.x1)];
            self.spans.clear();
            let mut x = rect.x0;
            for run in row.chunk_by(|a, b| *a as u32 == *b as u32) {
                let x0 = x;
                x += run.len() as u16;
                let Some(number) = owner(run[0]) else { continue };
                let owner = content.owner(number, last);
                last = Some(owner);
                match owner {
                    Owner::Face(item, face) => {
                        let cluster = content.mesh_of(item).cluster_of(face) as u32;
                        if self.owners.last() != Some(&(item, cluster)) {
                            self.owners.push((item, cluster));
                        }
                        self.spans.push(Span {
                            x0,
                            x1: x,
                            owner,
                            see_through: false,
                        });
                    }
                    Owner::Opening(opening) => {
                        let place = openings.iter().position(|o| o.opening == opening);
                        let place = place.unwrap_or_else(|| {
                            openings.push(SeenOpening {
                                opening,
                                rows: Some(Default::default()),
                            });
                            openings.len() - 1
                        });
                        if let Some(rows) = &mut openings[place].rows {
                            rows.push(y, x0, x);
                        }
                    }
                }
            }
            if let Some(canvas) = canvas.as_deref_mut() {
                canvas.row(y, &self.spans);
                if let Some(trace) = &self.trace {
                    let run = start + usize::from(rect.x0)..start + usize::from(rect.x1);
                    canvas.work(y, rect.x0, &trace.tested[run.clone()], &trace.batches[run]);
                }
            }
        }
        report_owners(&mut self.owners, content, seen);
        seen.openings.append(&mut openings);
    }
}

struct Glass<'a> {
    samples: &'a Samples,
    seen: &'a mut Seen,
    item: ItemId,
    item_start: u32,
}

impl Sink for Glass<'_> {
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    fn run(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        let row = triangle.row(y);
        let start = usize::from(y) * self.samples.width;
        for x in x0..x1 {
            let bits = row.bits(i32::from(x));
            if bits >= nearness(self.samples.samples[start + usize::from(x)]) {
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
