//! Buffers and temporal coherence of one viewer.

use crate::ids::ItemIndex;
use crate::stats::Stats;
use crate::view::aperture::Rows;
use crate::view::collector::{GlassSample, ReportBuffers};
use crate::view::passage::Passage;
#[cfg(feature = "steps")]
use crate::view::step_log::StepLog;
use glam::DVec3;
use std::any::{Any, TypeId};
use std::sync::{Mutex, PoisonError};

/// The working memory of a [`Viewer`](crate::Viewer): buffers reused from passage to passage, and what the last look
/// saw.
///
/// A custom sector can keep its buffers here too: see [`Memory::take`].
#[derive(Default)]
pub struct Memory {
    /// One buffer per type. There are only a handful, so search is linear. The mutex is never locked: it makes the memory
    /// `Sync`, because buffers, which need not be, are only reachable through `&mut`.
    scratch: Mutex<Vec<(TypeId, Box<dyn Any + Send>)>>,
    pub(crate) marks: Marks,
    pub(crate) recall: Recall,
    /// Empty rows for reuse.
    pub(crate) spare_rows: Vec<Rows>,
    /// Empty buffer for transparent samples.
    pub(crate) spare_glass: Vec<GlassSample>,
    pub(crate) spare_report: ReportBuffers,
    /// Counters of the current look.
    pub stats: Stats,
    /// Whether the canvas wants the test counts of covers ([`Canvas::wants_work`](crate::Canvas::wants_work)).
    pub(crate) trace: bool,
    /// The steps of the current look, if they are recorded.
    #[cfg(feature = "steps")]
    pub(crate) steps: Option<Box<StepLog>>,
}

impl Memory {
    /// Takes the buffer of type `T` out of the memory, or creates one. Return it by [`Memory::put_back`].
    ///
    /// Taking it out allows a sector to use several buffers at a time.
    pub fn take<T: Default + Send + 'static>(&mut self) -> Box<T> {
        let scratch = self.scratch();
        let place = scratch.iter().position(|(kind, _)| *kind == TypeId::of::<T>());
        let kept = place.map(|place| scratch.swap_remove(place).1);
        kept.and_then(|any| any.downcast().ok()).unwrap_or_default()
    }

    /// Stores a buffer for the next [`Memory::take`] of its type.
    pub fn put_back<T: Send + 'static>(&mut self, scratch: Box<T>) {
        self.scratch().push((TypeId::of::<T>(), scratch));
    }

    fn scratch(&mut self) -> &mut Vec<(TypeId, Box<dyn Any + Send>)> {
        self.scratch.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Marks the items found in the current traversal.
#[derive(Default)]
pub(crate) struct Marks {
    walk: u32,
    last_met: Vec<u32>,
}

impl Marks {
    /// Begins a traversal of a sector with `items` items.
    pub(crate) fn begin(&mut self, items: usize) {
        if self.last_met.len() < items {
            self.last_met.resize(items, 0);
        }
        self.walk = self.walk.checked_add(1).unwrap_or_else(|| {
            self.last_met.fill(0);
            1
        });
    }

    /// Marks an item; returns `true` if it was not marked in this traversal.
    pub(crate) fn first_time(&mut self, item: ItemIndex) -> bool {
        std::mem::replace(&mut self.last_met[item.0 as usize], self.walk) != self.walk
    }
}

/// Temporal coherence: the clusters that were visible in the last look, by chain of portals. Chains that a look does
/// not visit again are forgotten, so the size stays that of one look.
#[derive(Default)]
pub(crate) struct Recall {
    /// Sorted by chain.
    last: Vec<PassageRecord>,
    now: Vec<PassageRecord>,
    /// Empty lists for reuse.
    spare: Vec<Vec<(ItemIndex, u32)>>,
}

/// The clusters that were visible through a passage, with the eye position and direction.
struct PassageRecord {
    chain: u64,
    eye: DVec3,
    back: DVec3,
    /// Sorted, without repeats.
    clusters: Vec<(ItemIndex, u32)>,
}

impl Recall {
    pub(crate) fn begin_look(&mut self) {
        std::mem::swap(&mut self.last, &mut self.now);
        let forgotten = self.now.drain(..).map(|remembered| remembered.clusters);
        // Lists that are lent have been replaced by empty ones.
        self.spare.extend(forgotten.filter(|list| list.capacity() > 0));
        self.last.sort_unstable_by_key(|remembered| remembered.chain);
    }

    /// Returns the clusters that were visible through the same chain of portals in the last look; empty if the eye
    /// moved or turned too far since. From elsewhere most of them are hidden, so testing them first would cost more
    /// than it saves.
    ///
    /// `size` is the longest side of the sector. Return the list by [`Recall::give_back`] or [`Recall::remember`].
    pub(crate) fn seen_last(&mut self, passage: &Passage, size: f32) -> Vec<(ItemIndex, u32)> {
        const STEP: f64 = 0.02;
        const TURN: f64 = 0.8;
        let (eye, back) = passage.stance();
        let found = self.last.binary_search_by_key(&passage.chain, |last| last.chain);
        let Some(last) = found.ok().map(|place| &mut self.last[place]) else {
            return self.list();
        };
        let mut clusters = std::mem::take(&mut last.clusters);
        if last.eye.distance(eye) > STEP * f64::from(size) || last.back.dot(back) < TURN {
            clusters.clear();
        }
        clusters
    }

    /// Returns an empty list. Return it by [`Recall::give_back`] or [`Recall::remember`].
    pub(crate) fn list(&mut self) -> Vec<(ItemIndex, u32)> {
        let mut list = self.spare.pop().unwrap_or_default();
        list.clear();
        list
    }

    pub(crate) fn give_back(&mut self, list: Vec<(ItemIndex, u32)>) {
        self.spare.push(list);
    }

    /// Stores the clusters that are visible now, in the list `used`.
    pub(crate) fn remember(
        &mut self,
        passage: &Passage,
        clusters: impl Iterator<Item = (ItemIndex, u32)>,
        mut used: Vec<(ItemIndex, u32)>,
    ) {
        used.clear();
        used.extend(clusters);
        let (eye, back) = passage.stance();
        self.now.push(PassageRecord {
            chain: passage.chain,
            eye,
            back,
            clusters: used,
        });
    }
}
