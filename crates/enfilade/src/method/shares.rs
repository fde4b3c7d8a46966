//! Parallel traversal for covers that hold all occluders before it starts.
//!
//! Idea: such a cover is read-only, so each thread traverses a part of the pending queue with a copy of it; the result
//!     of one part does not depend on the others. Items in two parts are found twice and reported once.
//! Source: ours.
//! Cost: one traversal, divided; but one thread tests the first boxes, and each part copies the cover.
//! Deterministic: the parts are reported in the order in which one thread would traverse them, so the set does not
//! depend on the number of threads.

use super::culled::SampleCover;
use super::found::{FoundSet, Walk};
use crate::cover::Hides;
use crate::geometry::Geometry;
use crate::order::Order;
use crate::stats::Stats;
use crate::threads;
use crate::view::collector::Collector;
use crate::view::memory::{Marks, Memory};
use crate::view::passage::Passage;

/// Parts per thread, for load balancing. More parts would have more items in common.
const PER_THREAD: usize = 2;

/// Minimum number of pending boxes for a parallel traversal. Fewer are not worth the copies.
const MIN_PENDING: usize = 64;

/// The state of all parts; reused from look to look.
struct Shares<O: Order, C>(Vec<Share<O, C>>);

struct Share<O: Order, C> {
    cover: C,
    scratch: O::Scratch,
    marks: Marks,
    stats: Stats,
    found: FoundSet,
}

/// Traverses a geometry in parallel and reports the clusters and openings that a read-only cover does not hide.
pub(super) fn find_by_shares<O: Order, C: Hides>(
    order: &O,
    geometry: &Geometry,
    passage: &Passage,
    cover: &mut C,
    memory: &mut Memory,
    seen: &mut Collector,
) {
    let parts = PER_THREAD * passage.threads();
    let mut scratch = memory.take::<O::Scratch>();
    let mut found = memory.take::<FoundSet>();
    let mut shares = memory.take::<Shares<O, C>>();
    memory.marks.begin(geometry.items().len());
    let mut walk = Walk {
        passage,
        geometry,
        occlusion: &mut SampleCover::new(cover),
        marks: &mut memory.marks,
        stats: &mut memory.stats,
        found: &mut found,
    };
    let waiting = order.begin(geometry, passage, MIN_PENDING, &mut scratch, &mut walk);
    if waiting < MIN_PENDING {
        order.go_on(geometry, passage, &mut scratch, &mut walk);
    } else {
        let Shares(shares) = &mut *shares;
        if shares.len() < parts {
            shares.resize_with(parts, Share::default);
        }
        let shares = &mut shares[..parts];
        for (number, share) in shares.iter_mut().enumerate() {
            order.deal(&scratch, [number, parts], &mut share.scratch);
        }
        let cover = walk.occlusion.cover();
        threads::for_each(shares, |_, share| share.go_on(order, geometry, passage, cover));
        for share in shares {
            walk.stats.add(&share.stats);
            let marks = &mut *walk.marks;
            let clusters = &mut walk.found.clusters;
            clusters.take_in(&mut share.found.clusters, |item| marks.first_time(item));
        }
    }
    walk.report(seen);
    memory.put_back(scratch);
    memory.put_back(found);
    memory.put_back(shares);
}

impl<O: Order, C: Hides> Share<O, C> {
    fn go_on(&mut self, order: &O, geometry: &Geometry, passage: &Passage, cover: &C) {
        self.cover.copy(cover);
        self.marks.begin(geometry.items().len());
        self.stats = Stats::default();
        let mut walk = Walk {
            passage,
            geometry,
            occlusion: &mut SampleCover::new(&mut self.cover),
            marks: &mut self.marks,
            stats: &mut self.stats,
            found: &mut self.found,
        };
        order.go_on(geometry, passage, &mut self.scratch, &mut walk);
    }
}

impl<O: Order, C> Default for Shares<O, C> {
    fn default() -> Shares<O, C> {
        Shares(Vec::new())
    }
}

impl<O: Order, C: Default> Default for Share<O, C> {
    fn default() -> Share<O, C> {
        Share {
            cover: C::default(),
            scratch: O::Scratch::default(),
            marks: Marks::default(),
            stats: Stats::default(),
            found: FoundSet::default(),
        }
    }
}
