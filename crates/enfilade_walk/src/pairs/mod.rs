//! Broad phase: pairs of overlapping moving boxes, as candidates for collisions.
//!
//! Idea: every box stores the list of boxes that it overlaps; an update queries a tree for the changed boxes only.
//! Source: the tree is that of [`tree`].
//! Cost: O(changed · log n + pairs of the changed) per update.
//! Exact: boxes are not enlarged; boxes that only touch overlap, as in [`Aabb::meets`].

mod tree;

use enfilade::Aabb;
use std::collections::HashMap;
use thiserror::Error;
use tree::Tree;

/// Broad phase for collision detection: moving AABBs with user-defined ids, and the pairs of them that overlap.
///
/// Set the boxes that moved, then call [`Pairs::update`]:
///
/// ```
/// use enfilade::Aabb;
/// use enfilade_walk::Pairs;
///
/// let at = |x: f32| Aabb { min: [x, 0.0, 0.0], max: [x + 1.0, 1.0, 1.0] };
/// let mut pairs = Pairs::new();
/// pairs.set(7, at(0.0))?;
/// pairs.set(3, at(0.5))?;
/// assert_eq!(pairs.update().began, [[3, 7]]);
/// pairs.set(3, at(9.0))?;
/// assert_eq!(pairs.update().ended, [[3, 7]]);
/// # Ok::<(), enfilade_walk::BoxError>(())
/// ```
#[doc(alias = "broad phase")]
#[doc(alias = "overlap")]
#[doc(alias = "sweep and prune")]
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    slot_of: HashMap<u32, u32>,
    /// By slot, as the fields below; empty once removed.
    boxes: Vec<Aabb>,
    ids: Vec<u32>,
    /// The slots of the boxes that each box overlaps, sorted.
    others: Vec<Vec<u32>>,
    is_changed: Vec<bool>,
    changed: Vec<u32>,
    free: Vec<u32>,
    tree: Tree,
    found: Vec<u32>,
    began: Vec<[u32; 2]>,
    ended: Vec<[u32; 2]>,
    count: usize,
}

/// Changes found by [`Pairs::update`]: sorted pairs of ids, the lower id first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PairChanges<'a> {
    /// Pairs that overlap now, but did not at the last update.
    pub began: &'a [[u32; 2]],
    /// Pairs that overlapped at the last update and no longer do, or of which a box was removed.
    pub ended: &'a [[u32; 2]],
}

/// An error of [`Pairs::set`]; the value is the id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BoxError {
    /// A coordinate is NaN or infinite.
    #[error("box {0} is not finite")]
    NotFinite(u32),
    /// A minimum exceeds its maximum.
    #[error("box {0} is empty: a minimum exceeds its maximum")]
    Empty(u32),
}

impl Pairs {
    /// Creates an empty set of boxes.
    pub fn new() -> Pairs {
        Pairs::default()
    }

    /// Adds a box with any id, or replaces the box that has it. The next update reports the changes.
    ///
    /// # Errors
    /// Returns a [`BoxError`] if the box is not finite or is empty, and leaves the set unchanged.
    pub fn set(&mut self, id: u32, bounds: Aabb) -> Result<(), BoxError> {
        if !bounds.min.iter().chain(&bounds.max).all(|side| side.is_finite()) {
            return Err(BoxError::NotFinite(id));
        }
        if bounds.is_empty() {
            return Err(BoxError::Empty(id));
        }
        let slot = match self.slot_of.get(&id) {
            Some(&slot) => slot,
            None => self.new_slot(id),
        };
        if self.boxes[slot as usize] != bounds {
            self.boxes[slot as usize] = bounds;
            self.mark(slot);
        }
        Ok(())
    }

    /// Removes a box. Returns `true` if there was one.
    pub fn remove(&mut self, id: u32) -> bool {
        let Some(&slot) = self.slot_of.get(&id) else {
            return false;
        };
        let there = !self.boxes[slot as usize].is_empty();
        self.boxes[slot as usize] = Aabb::EMPTY;
        self.mark(slot);
        there
    }

    /// Returns the box with the given id; `None` if there is none.
    pub fn bounds(&self, id: u32) -> Option<Aabb> {
        let bounds = self.boxes[*self.slot_of.get(&id)? as usize];
        (!bounds.is_empty()).then_some(bounds)
    }

    /// Computes the pairs that changed since the last update.
    pub fn update(&mut self) -> PairChanges<'_> {
        self.began.clear();
        self.ended.clear();
        let mut changed = std::mem::take(&mut self.changed);
        let is_new = |&&slot: &&u32| !(self.tree.holds(slot) || self.boxes[slot as usize].is_empty());
        let newcomers = changed.iter().filter(is_new).count();
        if self.tree.serves(newcomers) {
            for &slot in &changed {
                self.tree.set(slot, &self.boxes[slot as usize]);
            }
        } else {
            self.tree.build(&self.boxes);
        }
        for &slot in &changed {
            self.compare(slot);
        }
        for slot in changed.drain(..) {
            self.is_changed[slot as usize] = false;
            if self.boxes[slot as usize].is_empty() {
                self.slot_of.remove(&self.ids[slot as usize]);
                self.free.push(slot);
            }
        }
        self.changed = changed;
        self.began.sort_unstable();
        self.ended.sort_unstable();
        self.count = self.count + self.began.len() - self.ended.len();
        PairChanges {
            began: &self.began,
            ended: &self.ended,
        }
    }

    /// Returns the number of overlapping pairs at the last update.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns all overlapping pairs at the last update, sorted, the lower id of each pair first.
    pub fn all(&self) -> Vec<[u32; 2]> {
        let mut all = Vec::with_capacity(self.count);
        for (slot, others) in (0..).zip(&self.others) {
            let once = others.iter().filter(|&&other| other > slot);
            all.extend(once.map(|&other| in_order(&self.ids, slot, other)));
        }
        all.sort_unstable();
        all
    }

    /// Iterates over the ids of the boxes that box `id` overlapped at the last update, in no order.
    pub fn of(&self, id: u32) -> impl Iterator<Item = u32> {
        let slot = self.slot_of.get(&id);
        let others = slot.map_or(&[][..], |&slot| &self.others[slot as usize][..]);
        others.iter().map(|&other| self.ids[other as usize])
    }

    fn new_slot(&mut self, id: u32) -> u32 {
        let slot = self.free.pop().unwrap_or(self.boxes.len() as u32);
        if slot as usize == self.boxes.len() {
            self.boxes.push(Aabb::EMPTY);
            self.ids.push(id);
            self.others.push(Vec::new());
            self.is_changed.push(false);
        }
        self.ids[slot as usize] = id;
        self.slot_of.insert(id, slot);
        slot
    }

    fn mark(&mut self, slot: u32) {
        if !std::mem::replace(&mut self.is_changed[slot as usize], true) {
            self.changed.push(slot);
        }
    }

    /// Recomputes the overlaps of a changed box, and updates the lists of the others.
    fn compare(&mut self, slot: u32) {
        let bounds = self.boxes[slot as usize];
        self.found.clear();
        if !bounds.is_empty() {
            self.tree.meeting(&bounds, &mut self.found);
        }
        self.found.retain(|&other| other != slot);
        self.found.sort_unstable();
        let before = std::mem::take(&mut self.others[slot as usize]);
        // Merges two sorted lists.
        let [mut old, mut new] = [before.iter().peekable(), self.found.iter().peekable()];
        loop {
            let (other, is_new) = match (old.peek(), new.peek()) {
                (None, None) => break,
                (Some(&&a), Some(&&b)) if a == b => {
                    old.next();
                    new.next();
                    continue;
                }
                (Some(&&a), Some(&&b)) => (a.min(b), b < a),
                (Some(&&a), None) => (a, false),
                (None, Some(&&b)) => (b, true),
            };
            let others = &mut self.others[other as usize];
            // The lists are symmetric: toggle the entry of the other box.
            match others.binary_search(&slot) {
                Ok(at) => drop(others.remove(at)),
                Err(at) => others.insert(at, slot),
            }
            let pair = in_order(&self.ids, slot, other);
            if is_new {
                new.next();
                self.began.push(pair);
            } else {
                old.next();
                self.ended.push(pair);
            }
        }
        let mut others = before;
        others.clone_from(&self.found);
        self.others[slot as usize] = others;
    }
}

/// Returns the ids of two boxes, the lower first.
fn in_order(ids: &[u32], a: u32, b: u32) -> [u32; 2] {
    let [a, b] = [a, b].map(|slot| ids[slot as usize]);
    [a.min(b), a.max(b)]
}
