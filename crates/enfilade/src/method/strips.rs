//! A passage looked through in strips of rows, side by side.
//!
//! Who owns a sample is told at that sample, whatever is seen beside it: so strips of an aperture can be looked through apart
//! from each other, each by a cover of its own, and what is seen through any of them is what is seen.
//! Source: ours; "sort-first" in Molnar, Cox, Ellsworth, Fuchs, A Sorting Classification of Parallel Rendering, IEEE CG&A 1994.
//! Cost: a look, divided; but each strip walks down to what it sees by itself, asks about all that the last look saw, and
//!     works out the corners of what reaches into the next strip as well.
//! Exact: the same items, clusters and openings, sample by sample, however many strips there are; other counts of work.

use crate::aperture::{Rect, Rows};
use crate::collector::{Collector, report_owners};
use crate::geometry::{ItemId, Owners};
use crate::memory::Memory;
use crate::passage::Passage;
use crate::stats::Stats;
use crate::threads;

/// Strips for each thread, so that none waits long for the dearest; more would repeat more.
const PER_THREAD: usize = 2;

/// Samples of a strip, at least: where there are fewer, little is gained by waking another thread.
const LEAST: usize = 1 << 16;

/// Strips begin at a multiple of so many rows, as bands and tiles do.
const ALIGNED: u16 = 8;

/// What strips are looked through with; kept from look to look.
#[derive(Default)]
struct Strips {
    strips: Vec<Strip>,
    met: Vec<(ItemId, u32)>,
}

#[derive(Default)]
struct Strip {
    memory: Memory,
    seen: Collector,
    /// The samples of the aperture in it.
    rows: Rows,
}

/// In how many strips a passage is looked through.
pub(super) fn count(passage: &Passage, memory: &Memory) -> usize {
    let threads = memory.threads();
    if threads == 1 {
        return 1;
    }
    let Rect { x0, y0, x1, y1 } = passage.aperture.rect();
    let samples = usize::from(x1 - x0) * usize::from(y1 - y0);
    (threads * PER_THREAD).min(samples / LEAST).max(1)
}

/// Looks through `count` strips of a passage, and reports what all of them together see.
pub(super) fn look_in_strips(
    count: usize,
    owners: &dyn Owners,
    passage: &Passage,
    memory: &mut Memory,
    seen: &mut Collector,
    look: impl Fn(&Passage, &mut Memory, &mut Collector) + Send + Sync,
) {
    let mut all = memory.take::<Strips>();
    let Strips { strips, met } = &mut *all;
    if strips.len() < count {
        strips.resize_with(count, Strip::default);
    }
    let strips = &mut strips[..count];
    let rect = passage.aperture.rect();
    threads::for_each(strips, |number, strip| {
        let rows = [number, number + 1].map(|number| first_row(&rect, number, count));
        strip.look(passage, rows, &look);
    });
    // From the first to the last: openings are reported as their samples come, top to bottom.
    for strip in strips {
        met.extend(strip.seen.clusters_of_items(owners));
        memory.stats.add(&strip.memory.stats);
        strip.report_openings(seen);
        seen.samples_owned += strip.seen.samples_owned;
    }
    report_owners(met, owners, seen);
    met.clear();
    memory.put_back(all);
}

/// The first row of a strip, by its number; of the one after the last, the row after the last.
fn first_row(rect: &Rect, number: usize, count: usize) -> u16 {
    let rows = usize::from(rect.y1 - rect.y0);
    let row = rect.y0 + (rows * number / count) as u16;
    if number == 0 || number == count {
        row
    } else {
        (row - row % ALIGNED).max(rect.y0)
    }
}

impl Strip {
    fn look(
        &mut self,
        passage: &Passage,
        rows: [u16; 2],
        look: &impl Fn(&Passage, &mut Memory, &mut Collector),
    ) {
        let Strip {
            memory,
            seen,
            rows: spare,
        } = self;
        memory.stats = Stats::default();
        seen.clear(false);
        if rows[0] == rows[1] {
            return;
        }
        let mut strip = passage.with_aperture(passage.aperture.strip(rows, spare));
        look(&strip, memory, seen);
        if let Some(rows) = strip.aperture.take_rows() {
            *spare = rows;
        }
    }

    /// Reports the openings that it saw, and the samples of them.
    fn report_openings(&mut self, seen: &mut Collector) {
        for opening in self.seen.openings.drain(..) {
            let Some(mut rows) = opening.rows else { continue };
            for y in rows.range() {
                for &[x0, x1] in rows.row(y) {
                    seen.add_to_opening(opening.opening, y, x0, x1);
                }
            }
            rows.clear();
            self.seen.spare_rows.push(rows);
        }
    }
}
