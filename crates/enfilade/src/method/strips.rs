//! Parallel looks: splits a passage into horizontal strips of rows, one task each.
//!
//! Idea: the visible surface at a sample does not depend on other samples. So each strip of the aperture is processed
//!     on its own, with its own cover, and the visible set is the union. Only single passages are split; the openings of
//!     a sector are followed one after the other. So passage ids and limits count in a fixed order, and a hundred
//!     mirrors share their buffers. The apertures that are worth a thread are large, and large ones are split here.
//! Source: ours; "sort-first" in Molnar, Cox, Ellsworth, Fuchs, A Sorting Classification of Parallel Rendering, IEEE
//!     CG&A 1994.
//! Cost: one look, divided; but each strip traverses the order from the root, tests all clusters that the last look
//!     found visible, and also projects geometry that extends into the next strip.
//! Exact: the same items, clusters and openings at every sample for any number of strips; only the work counts differ.

use crate::geometry::Owners;
use crate::ids::ItemIndex;
use crate::stats::Stats;
use crate::threads;
use crate::view::aperture::{Rect, Rows};
use crate::view::collector::{Collector, report_owners};
use crate::view::memory::Memory;
use crate::view::passage::Passage;

/// Strips per thread, so that none waits long for the most expensive one; more would repeat more work.
const PER_THREAD: usize = 2;

/// Minimum number of samples per strip. Below it, waking another thread gains little.
const MIN_SAMPLES: usize = 1 << 16;

/// Strips start at a multiple of this number of rows, as bands and tiles do.
const ALIGNED: u16 = 8;

/// The strips and their state; reused from look to look.
#[derive(Default)]
struct Strips {
    strips: Vec<Strip>,
    met: Vec<(ItemIndex, u32)>,
}

#[derive(Default)]
struct Strip {
    memory: Memory,
    seen: Collector,
    /// Storage for the strip's part of the aperture.
    rows: Rows,
}

/// Returns the number of strips to split a passage into; 1 for no split.
pub(super) fn count(passage: &Passage) -> usize {
    let threads = passage.threads();
    if threads == 1 {
        return 1;
    }
    let Rect { x0, y0, x1, y1 } = passage.aperture.rect();
    let samples = usize::from(x1 - x0) * usize::from(y1 - y0);
    (threads * PER_THREAD).min(samples / MIN_SAMPLES).max(1)
}

/// Runs `look` for each of `count` strips of a passage in parallel, and reports the union of what they find visible.
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
    // In order from top to bottom, because openings are reported in the order of their samples.
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

/// Returns the first row of strip `number`; for `number == count`, the end of the last strip.
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

    /// Reports the visible openings of the strip with their samples.
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
