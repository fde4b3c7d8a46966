//! The working memory of one camera.

use crate::content::ItemId;
use crate::passage::Passage;
use crate::stats::Stats;
use glam::DVec3;
use std::any::{Any, TypeId};
use std::collections::HashMap;

/// What looking needs besides the scene: buffers, reused passage after passage, and what the last look saw.
pub struct Memory {
    scratch: HashMap<TypeId, Box<dyn Any + Send>>,
    pub(crate) marks: Marks,
    pub(crate) recall: Recall,
    /// Counts of the look at hand.
    pub stats: Stats,
    /// May what the last look saw be seen first? It changes the cost, never the answer.
    pub coherence: bool,
    /// Does the canvas want to know how covers came to their answer?
    pub(crate) trace: bool,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            scratch: HashMap::new(),
            marks: Marks::default(),
            recall: Recall::default(),
            stats: Stats::default(),
            coherence: true,
            trace: false,
        }
    }
}

impl Memory {
    /// Takes the one buffer of a type out, to be put back by [`Memory::put_back`]: so that two may be in use.
    pub fn take<T: Default + Send + 'static>(&mut self) -> Box<T> {
        let kept = self.scratch.remove(&TypeId::of::<T>());
        kept.and_then(|any| any.downcast().ok()).unwrap_or_default()
    }

    /// Keeps a buffer for the next passage.
    pub fn put_back<T: Send + 'static>(&mut self, scratch: Box<T>) {
        self.scratch.insert(TypeId::of::<T>(), scratch);
    }
}

/// Which items were met in the walk at hand.
#[derive(Default)]
pub(crate) struct Marks {
    walk: u32,
    last_met: Vec<u32>,
}

impl Marks {
    /// A new walk over a fragment of `items` items.
    pub(crate) fn begin(&mut self, items: usize) {
        if self.last_met.len() < items {
            self.last_met.resize(items, 0);
        }
        self.walk = self.walk.checked_add(1).unwrap_or_else(|| {
            self.last_met.fill(0);
            1
        });
    }

    /// Was the item not met before in this walk?
    pub(crate) fn first_time(&mut self, item: ItemId) -> bool {
        std::mem::replace(&mut self.last_met[item.0 as usize], self.walk) != self.walk
    }
}

/// The clusters of items that the last look saw, by chain of portals. What a look does not visit again is forgotten, so that
/// this stays as small as what one look sees.
#[derive(Default)]
pub(crate) struct Recall {
    last: HashMap<u64, Remembered>,
    now: HashMap<u64, Remembered>,
}

/// What was seen through a passage, and from where.
struct Remembered {
    eye: DVec3,
    back: DVec3,
    /// In order, each once.
    clusters: Vec<(ItemId, u32)>,
}

impl Recall {
    pub(crate) fn begin_look(&mut self) {
        std::mem::swap(&mut self.last, &mut self.now);
        self.now.clear();
    }

    /// What the last look saw through the same portals, if the eye has hardly moved since: from elsewhere most of it
    /// is hidden, and seeing it first would cost more than it hides. `size` is that of the fragment.
    pub(crate) fn seen_last(&mut self, passage: &Passage, size: f32) -> Vec<(ItemId, u32)> {
        const STEP: f64 = 0.02;
        const TURN: f64 = 0.8;
        let (eye, back) = passage.stance();
        let near = |last: &Remembered| {
            last.eye.distance(eye) <= STEP * f64::from(size) && last.back.dot(back) >= TURN
        };
        self.last
            .remove(&passage.chain)
            .filter(near)
            .map_or_else(Vec::new, |last| last.clusters)
    }

    pub(crate) fn remember(&mut self, passage: &Passage, clusters: Vec<(ItemId, u32)>) {
        let (eye, back) = passage.stance();
        self.now.insert(passage.chain, Remembered { eye, back, clusters });
    }

    pub(crate) fn forget(&mut self) {
        self.last.clear();
        self.now.clear();
    }
}
