//! The working memory of one camera.

use crate::aperture::Rows;
use crate::collector::{GlassSample, ReportBuffers};
use crate::geometry::ItemId;
use crate::passage::Passage;
use crate::stats::Stats;
use crate::threads;
use glam::DVec3;
use std::any::{Any, TypeId};

/// What looking needs besides the scene: buffers, reused passage after passage, and what the last look saw.
pub struct Memory {
    /// A handful: searched one by one.
    scratch: Vec<(TypeId, Box<dyn Any + Send>)>,
    pub(crate) marks: Marks,
    pub(crate) recall: Recall,
    /// Rows of samples to be filled anew.
    pub(crate) spare_rows: Vec<Rows>,
    /// Room for samples of glass.
    pub(crate) spare_glass: Vec<GlassSample>,
    pub(crate) spare_report: ReportBuffers,
    /// Counts of the look at hand.
    pub stats: Stats,
    /// May what the last look saw be seen first? It changes the cost, never the answer.
    pub coherence: bool,
    /// How many occluders methods take that choose them; `None`: as many as suits each.
    pub(crate) occluders: Option<u32>,
    /// Columns and rows of covers of lower resolution than the screen; `None`: that of the screen.
    pub(crate) cover_size: Option<[u32; 2]>,
    /// May looks use all threads of the pool that they run in?
    pub(crate) parallel: bool,
    /// Does the canvas want to know how covers came to their answer?
    pub(crate) trace: bool,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory {
            scratch: Vec::new(),
            marks: Marks::default(),
            recall: Recall::default(),
            spare_rows: Vec::new(),
            spare_glass: Vec::new(),
            spare_report: ReportBuffers::default(),
            stats: Stats::default(),
            coherence: true,
            occluders: None,
            cover_size: None,
            parallel: true,
            trace: false,
        }
    }
}

impl Memory {
    /// Takes the one buffer of a type out, to be put back by [`Memory::put_back`]: so that two may be in use.
    pub fn take<T: Default + Send + 'static>(&mut self) -> Box<T> {
        let place = self
            .scratch
            .iter()
            .position(|(kind, _)| *kind == TypeId::of::<T>());
        let kept = place.map(|place| self.scratch.swap_remove(place).1);
        kept.and_then(|any| any.downcast().ok()).unwrap_or_default()
    }

    /// How many threads may work on a passage at once.
    pub(crate) fn threads(&self) -> usize {
        if self.parallel { threads::count() } else { 1 }
    }

    /// Keeps a buffer for the next passage.
    pub fn put_back<T: Send + 'static>(&mut self, scratch: Box<T>) {
        self.scratch.push((TypeId::of::<T>(), scratch));
    }
}

/// Which items were met in the walk at hand.
#[derive(Default)]
pub(crate) struct Marks {
    walk: u32,
    last_met: Vec<u32>,
}

impl Marks {
    /// A new walk over a sector of `items` items.
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
    /// Sorted by chain.
    last: Vec<Remembered>,
    now: Vec<Remembered>,
    /// Lists to be filled anew.
    spare: Vec<Vec<(ItemId, u32)>>,
}

/// What was seen through a passage, and from where.
struct Remembered {
    chain: u64,
    eye: DVec3,
    back: DVec3,
    /// In order, each once.
    clusters: Vec<(ItemId, u32)>,
}

impl Recall {
    pub(crate) fn begin_look(&mut self) {
        std::mem::swap(&mut self.last, &mut self.now);
        let forgotten = self.now.drain(..).map(|remembered| remembered.clusters);
        // Those that were lent have left nothing behind.
        self.spare.extend(forgotten.filter(|list| list.capacity() > 0));
        self.last.sort_unstable_by_key(|remembered| remembered.chain);
    }

    /// What the last look saw through the same portals, if the eye has hardly moved since: from elsewhere most of it
    /// is hidden, and seeing it first would cost more than it hides. `size` is that of the sector. To be given back.
    pub(crate) fn seen_last(&mut self, passage: &Passage, size: f32) -> Vec<(ItemId, u32)> {
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

    /// An empty list; to be given back.
    pub(crate) fn list(&mut self) -> Vec<(ItemId, u32)> {
        let mut list = self.spare.pop().unwrap_or_default();
        list.clear();
        list
    }

    pub(crate) fn give_back(&mut self, list: Vec<(ItemId, u32)>) {
        self.spare.push(list);
    }

    /// Remembers what is seen now, and takes `used` back.
    pub(crate) fn remember(
        &mut self,
        passage: &Passage,
        clusters: impl Iterator<Item = (ItemId, u32)>,
        mut used: Vec<(ItemId, u32)>,
    ) {
        used.clear();
        used.extend(clusters);
        let (eye, back) = passage.stance();
        self.now.push(Remembered {
            chain: passage.chain,
            eye,
            back,
            clusters: used,
        });
    }

    pub(crate) fn forget(&mut self) {
        self.last.clear();
        self.now.clear();
    }
}
