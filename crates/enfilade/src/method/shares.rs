//! A walk shared among threads, where all that hides is in the cover before it.
//!
//! Such a cover is only asked, so each thread has a copy of it, and walks down to other things: what is found does not
//! depend on what else is. What stands in two shares is found by both, and reported once.
//! Source: ours.
//! Cost: a walk, divided; but the first boxes are asked about by one thread, and each share copies the cover.
//! The same set however many threads there are: shares are told in the order in which one thread would walk them.

use super::culled::InSamples;
use super::found::{Found, Walk};
use crate::collector::Collector;
use crate::cover::Hides;
use crate::geometry::Geometry;
use crate::memory::{Marks, Memory};
use crate::order::Order;
use crate::passage::Passage;
use crate::stats::Stats;
use crate::threads;

/// Shares for each thread: some are walked sooner than others. With more, more things stand in two.
const PER_THREAD: usize = 2;

/// A walk is shared where so many boxes wait that may be seen; below as many there is too little to be worth it.
const LEAST: usize = 64;

/// What the shares of a walk need; kept from look to look.
struct Shares<O: Order, C>(Vec<Share<O, C>>);

struct Share<O: Order, C> {
    cover: C,
    scratch: O::Scratch,
    marks: Marks,
    stats: Stats,
    found: Found,
}

/// Reports what an order's walk finds past a cover that it only asks.
pub(super) fn find_by_shares<O: Order, C: Hides>(
    order: &O,
    geometry: &Geometry,
    passage: &Passage,
    cover: &mut C,
    memory: &mut Memory,
    seen: &mut Collector,
) {
    let most = PER_THREAD * memory.threads();
    let mut scratch = memory.take::<O::Scratch>();
    let mut found = memory.take::<Found>();
    let mut shares = memory.take::<Shares<O, C>>();
    memory.marks.begin(geometry.items().len());
    let mut walk = Walk {
        passage,
        geometry,
        against: &mut InSamples(cover),
        marks: &mut memory.marks,
        stats: &mut memory.stats,
        found: &mut found,
    };
    let waiting = order.begin(geometry, passage, LEAST, &mut scratch, &mut walk);
    if waiting < LEAST {
        order.go_on(geometry, passage, &mut scratch, &mut walk);
    } else {
        let Shares(shares) = &mut *shares;
        if shares.len() < most {
            shares.resize_with(most, Share::default);
        }
        let shares = &mut shares[..most];
        for (number, share) in shares.iter_mut().enumerate() {
            order.deal(&scratch, [number, most], &mut share.scratch);
        }
        let cover = &*walk.against.0;
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
            against: &mut InSamples(&mut self.cover),
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
            found: Found::default(),
        }
    }
}
