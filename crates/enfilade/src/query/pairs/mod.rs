//! Which of many moving boxes overlap: candidates for collisions.
//!
//! Every box knows which others it overlaps; an update asks a tree for those that have changed, and for no other.
//! Source: the tree is that of [`tree`].
//! Cost: O(changed · log n + pairs of the changed) an update.
//! Exact: boxes as they are, none grown; those that only touch overlap, as [`Aabb::meets`] says.

mod tree;

use crate::geom::Aabb;
use std::collections::HashMap;
use thiserror::Error;
use tree::Tree;

/// Boxes that move, by numbers of the user's own, and the pairs of them that overlap.
///
/// Say what has moved, then ask for an update:
///
/// ```
/// use enfilade::{Aabb, Pairs};
///
/// let at = |x: f32| Aabb { min: [x, 0.0, 0.0], max: [x + 1.0, 1.0, 1.0] };
/// let mut pairs = Pairs::new();
/// pairs.set(7, at(0.0))?;
/// pairs.set(3, at(0.5))?;
/// assert_eq!(pairs.update().began, [[3, 7]]);
/// pairs.set(3, at(9.0))?;
/// assert_eq!(pairs.update().ended, [[3, 7]]);
/// # Ok::<(), enfilade::BoxError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    place_of: HashMap<u32, u32>,
    /// By place, as all that follow; empty once removed.
    boxes: Vec<Aabb>,
    ids: Vec<u32>,
    /// The places of those that each overlaps, in order.
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

/// What an update has changed: pairs of numbers, the lower first, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PairChanges<'a> {
    /// They overlap, and did not when the last update was made.
    pub began: &'a [[u32; 2]],
    /// They did, and do no longer, or one of them was removed.
    pub ended: &'a [[u32; 2]],
}

/// Why something cannot be one of the boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BoxError {
    /// A side is NaN or infinite.
    #[error("box {0} is not finite")]
    NotFinite(u32),
    /// It holds no point.
    #[error("box {0} is empty: a least side exceeds the greatest")]
    Empty(u32),
}

impl Pairs {
    /// No boxes.
    pub fn new() -> Pairs {
        Pairs::default()
    }

    /// Adds a box by the name of any number, or moves the one that has it. The next update tells what that changes.
    ///
    /// # Errors
    /// One [`BoxError`] for each broken rule, and then the box stays as it was.
    pub fn set(&mut self, id: u32, bounds: Aabb) -> Result<(), BoxError> {
        if !bounds.min.iter().chain(&bounds.max).all(|side| side.is_finite()) {
            return Err(BoxError::NotFinite(id));
        }
        if bounds.is_empty() {
            return Err(BoxError::Empty(id));
        }
        let place = match self.place_of.get(&id) {
            Some(&place) => place,
            None => self.new_place(id),
        };
        if self.boxes[place as usize] != bounds {
            self.boxes[place as usize] = bounds;
            self.mark(place);
        }
        Ok(())
    }

    /// Takes a box away; says whether there was one.
    pub fn remove(&mut self, id: u32) -> bool {
        let Some(&place) = self.place_of.get(&id) else {
            return false;
        };
        let there = !self.boxes[place as usize].is_empty();
        self.boxes[place as usize] = Aabb::EMPTY;
        self.mark(place);
        there
    }

    /// A box; `None` where none has that number.
    pub fn bounds(&self, id: u32) -> Option<Aabb> {
        let bounds = self.boxes[*self.place_of.get(&id)? as usize];
        (!bounds.is_empty()).then_some(bounds)
    }

    /// Finds what has changed since the last update.
    pub fn update(&mut self) -> PairChanges<'_> {
        self.began.clear();
        self.ended.clear();
        let mut changed = std::mem::take(&mut self.changed);
        let is_new = |&&place: &&u32| !(self.tree.holds(place) || self.boxes[place as usize].is_empty());
        let newcomers = changed.iter().filter(is_new).count();
        if self.tree.serves(newcomers) {
            for &place in &changed {
                self.tree.set(place, &self.boxes[place as usize]);
            }
        } else {
            self.tree.build(&self.boxes);
        }
        for &place in &changed {
            self.compare(place);
        }
        for place in changed.drain(..) {
            self.is_changed[place as usize] = false;
            if self.boxes[place as usize].is_empty() {
                self.place_of.remove(&self.ids[place as usize]);
                self.free.push(place);
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

    /// How many pairs overlapped when the last update was made.
    pub fn count(&self) -> usize {
        self.count
    }

    /// All pairs that overlapped when the last update was made: the lower number first, in order.
    pub fn all(&self) -> Vec<[u32; 2]> {
        let mut all = Vec::with_capacity(self.count);
        for (place, others) in (0..).zip(&self.others) {
            let once = others.iter().filter(|&&other| other > place);
            all.extend(once.map(|&other| in_order(&self.ids, place, other)));
        }
        all.sort_unstable();
        all
    }

    /// The numbers of the boxes that one overlapped when the last update was made, in no order.
    pub fn of(&self, id: u32) -> impl Iterator<Item = u32> {
        let place = self.place_of.get(&id);
        let others = place.map_or(&[][..], |&place| &self.others[place as usize][..]);
        others.iter().map(|&other| self.ids[other as usize])
    }

    fn new_place(&mut self, id: u32) -> u32 {
        let place = self.free.pop().unwrap_or(self.boxes.len() as u32);
        if place as usize == self.boxes.len() {
            self.boxes.push(Aabb::EMPTY);
            self.ids.push(id);
            self.others.push(Vec::new());
            self.is_changed.push(false);
        }
        self.ids[place as usize] = id;
        self.place_of.insert(id, place);
        place
    }

    fn mark(&mut self, place: u32) {
        if !std::mem::replace(&mut self.is_changed[place as usize], true) {
            self.changed.push(place);
        }
    }

    /// Finds what a changed box overlaps now, and tells the others.
    fn compare(&mut self, place: u32) {
        let bounds = self.boxes[place as usize];
        self.found.clear();
        if !bounds.is_empty() {
            self.tree.meeting(&bounds, &mut self.found);
        }
        self.found.retain(|&other| other != place);
        self.found.sort_unstable();
        let before = std::mem::take(&mut self.others[place as usize]);
        // Those of both lists in order, as one goes through two that are sorted.
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
            // Of two boxes each knows of the other, or none does.
            match others.binary_search(&place) {
                Ok(at) => drop(others.remove(at)),
                Err(at) => others.insert(at, place),
            }
            let pair = in_order(&self.ids, place, other);
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
        self.others[place as usize] = others;
    }
}

/// The numbers of two boxes, the lower first.
fn in_order(ids: &[u32], a: u32, b: u32) -> [u32; 2] {
    let [a, b] = [a, b].map(|place| ids[place as usize]);
    [a.min(b), a.max(b)]
}
