//! The visible entities of a view, as sorted keys, and how they changed since the last look.

use crate::mirror::Mirror;
use enfilade::VisibleSet;

/// The keys that are visible in one view, sorted, each once. Keep one for each view, as its
/// [`Viewer`](enfilade::Viewer).
///
/// Allocates nothing once its buffers have grown.
#[derive(Clone, Debug, Default)]
pub struct VisibleKeys {
    now: Vec<u64>,
    before: Vec<u64>,
    entered: Vec<u64>,
    left: Vec<u64>,
}

impl VisibleKeys {
    /// Creates an empty list.
    pub fn new() -> VisibleKeys {
        VisibleKeys::default()
    }

    /// Takes over a visible set: the keys of its items, also of those that are no entities of the mirror, and the
    /// entities of the mirror that may be in view but are no items of the scene.
    ///
    /// `set` must be of the scene as it is since the last [`Mirror::sync`]. If it is not
    /// [complete](VisibleSet::complete), keys may be missing here too.
    pub fn update(&mut self, mirror: &Mirror, set: &VisibleSet) {
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.clear();
        self.now.extend(set.items().iter().map(|item| item.key));
        for (entity, bounds) in mirror.outside() {
            let mut passages = set
                .passages()
                .iter()
                .filter(|passage| passage.sector == entity.sector);
            if bounds.is_none_or(|bounds| passages.any(|passage| passage.may_show(&bounds))) {
                self.now.push(entity.key);
            }
        }
        self.now.sort_unstable();
        self.now.dedup();
        subtract(&self.now, &self.before, &mut self.entered);
        subtract(&self.before, &self.now, &mut self.left);
    }

    /// Returns the visible keys.
    pub fn now(&self) -> &[u64] {
        &self.now
    }

    /// Returns the keys that are visible and were not at the last update.
    pub fn entered(&self) -> &[u64] {
        &self.entered
    }

    /// Returns the keys that were visible at the last update and no longer are, those of despawned entities included.
    pub fn left(&self) -> &[u64] {
        &self.left
    }
}

/// Replaces the contents of `rest` with the keys of `all` that are not in `others`; all are sorted.
fn subtract(all: &[u64], others: &[u64], rest: &mut Vec<u64>) {
    rest.clear();
    let mut others = others.iter().copied().peekable();
    for &key in all {
        while others.next_if(|&other| other < key).is_some() {}
        if others.peek() != Some(&key) {
            rest.push(key);
        }
    }
}
