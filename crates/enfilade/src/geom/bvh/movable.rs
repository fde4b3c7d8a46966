//! Incremental insertion, removal and movement of primitives in a BVH.
//!
//! A primitive that leaves its leaf's AABB is removed and inserted again where that costs least. Leaves with few
//! primitives are merged, and on the way up tree rotations reduce the area of boxes. That keeps the tree about as good
//! as a rebuilt one; it is rebuilt only if that was not enough. The leaves that keep their primitives are refitted
//! together, at the end, so that boxes high up in the tree are computed once for many moves.
//! Source: Catto, Dynamic Bounding Volume Hierarchies, GDC 2019 (removal by the sibling); Kopta, Ize, Spjut, Brunvand,
//!     Davis, Kensler, Fast, Effective BVH Updates for Animated Scenes, I3D 2012 (rotations).
//! Cost: O(depth) at most for a primitive that stays in its leaf, plus a search for the best position
//!     ([`super::choose`]) for one that does not.
//! Boxes are refitted as tightly as after building, so traversal tests no more nodes than necessary.

use super::choose::{InsertPosition, split_leaf};
use super::{Bvh, Node, pair_of};
use crate::geom::Aabb;
use smallvec::SmallVec;

/// The tree is rebuilt when its cost exceeds this multiple of its cost after building. A scene that spreads out has a
/// higher cost, and a rebuilt tree over it has the same: trees in which every primitive was removed and inserted ten
/// times cost within 5 % of rebuilt ones. This is a safeguard against unforeseen cases.
const MAX_COST_RATIO: f64 = 2.0;

/// One in this many changes reinserts the primitive although it could stay in its leaf. All primitives of a leaf can
/// drift apart, or away from it, so slowly that none ever leaves its box.
const REINSERT_PERIOD: usize = 64;

/// A primitive stays in its leaf if the leaf's area grows by at most this factor.
const MAX_GROWTH: f64 = 1.5;

/// The search for a position starts this many levels above the lowest ancestor whose AABB contains the new box. Boxes
/// overlap, and the best position may be in a neighbouring subtree.
const LEVELS_ABOVE: u32 = 3;

impl Bvh {
    /// Inserts primitive `thing`, which must not be in the tree. `boxes` returns the current AABB of any primitive; a
    /// primitive with an empty one is not inserted. Other primitives whose AABBs have changed may still have to be
    /// shifted.
    ///
    /// All changed nodes and their ancestors are appended to `touched`. If a node occurs twice the last occurrence
    /// counts: its children come before it.
    pub(super) fn insert(&mut self, thing: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let now = boxes(thing);
        if now.is_empty() {
            return;
        }
        self.changes += 1;
        self.count += 1;
        if self.leaves.len() <= thing as usize {
            self.leaves.resize(thing as usize + 1, 0);
        }
        if self.count > 1 {
            return self.put(thing, 0, boxes, touched);
        }
        for list in [&mut self.parents, &mut self.free_pairs] {
            list.clear();
        }
        self.nodes.clear();
        self.nodes.push(Node::EMPTY);
        self.make_leaf(0, &[thing], &now);
        touched.push(0);
    }

    /// Removes a primitive from its leaf. Other arguments as for [`Bvh::insert`].
    fn remove(&mut self, thing: u32, leaf: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        self.changes += 1;
        self.count -= 1;
        if let Some(from) = self.take(thing, leaf, touched) {
            self.climb(from, from, boxes, touched);
        }
    }

    /// Moves primitives from their old AABBs, given with them, to their current ones. An empty old AABB inserts a
    /// primitive, an empty current one removes it. Other arguments as for [`Bvh::insert`].
    pub(crate) fn shift(
        &mut self,
        moved: impl Iterator<Item = (u32, Aabb)> + Clone,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        for (thing, was) in moved.clone() {
            self.shift_one(thing, &was, boxes, touched);
        }
        self.stale.resize(self.nodes.len(), false);
        for (thing, _) in moved {
            let mut next = self.leaf_of(thing);
            while let Some(node) =
                next.filter(|&node| !std::mem::replace(&mut self.stale[node as usize], true))
            {
                next = self.parent(node);
            }
        }
        self.refit(boxes, touched);
    }

    /// Moves a primitive. The AABB of a leaf that keeps it may be too large then, and those above it too small.
    fn shift_one(&mut self, thing: u32, was: &Aabb, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let now = boxes(thing);
        // For a primitive that was not in the tree, `leaves` may still name a leaf that is no longer its own.
        let leaf = self.leaf_of(thing).filter(|_| !was.is_empty());
        let Some(leaf) = leaf else {
            return self.insert(thing, boxes, touched);
        };
        if now.is_empty() {
            return self.remove(thing, leaf, boxes, touched);
        }
        let held = *self.bounds(leaf);
        self.changes += 1;
        let grown = held.union(&now).half_area();
        let stays = !self.changes.is_multiple_of(REINSERT_PERIOD) && grown <= MAX_GROWTH * held.half_area();
        if stays || self.count == 1 {
            self.nodes[leaf as usize].bounds = held.union(&now);
            return;
        }
        let Some(mut top) = self.take(thing, leaf, touched) else {
            return;
        };
        // Most primitives move a short way and belong near their old position. An ancestor's AABB may be large enough
        // only because of the primitive's old box; it is refitted on the way back up.
        let mut above = 0;
        while let Some(parent) = self.parent(top) {
            let held = self.bounds(top);
            if held.union(&now) == *held {
                above += 1;
                if above > LEVELS_ABOVE {
                    break;
                }
            }
            self.shrink(top, boxes);
            touched.push(top);
            top = parent;
        }
        self.put(thing, top, boxes, touched);
    }

    /// Rebuilds the tree if it may have degraded: after changes to half of the primitives, and only if the tree costs
    /// more than [`MAX_COST_RATIO`] times as much as after building. Returns `true` if it was rebuilt; then all nodes are new.
    ///
    /// Primitives are numbered below `count`.
    pub(crate) fn tidy(&mut self, count: usize, boxes: &impl Fn(u32) -> Aabb) -> bool {
        if self.count == 0 || 2 * self.changes < self.count {
            return false;
        }
        self.changes = 0;
        let worse = self.cost_now() > MAX_COST_RATIO * self.cost;
        if worse {
            *self = Bvh::over(count, boxes, self.few);
        }
        worse
    }

    fn leaf_of(&self, thing: u32) -> Option<u32> {
        let leaf = *self.leaves.get(thing as usize)?;
        let is_node = self.count > 0 && (leaf as usize) < self.nodes.len();
        (is_node && self.things(leaf).contains(&thing)).then_some(leaf)
    }

    fn parent(&self, node: u32) -> Option<u32> {
        (node != 0).then(|| self.parents[pair_of(node)])
    }

    /// Inserts a primitive at the position of minimum cost in the subtree of `top`, whose AABB may be too large.
    fn put(&mut self, thing: u32, top: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let now = boxes(thing);
        let from = match self.best_position(thing, &now, top) {
            InsertPosition::Into(leaf) => {
                let Node { first, things, .. } = self.nodes[leaf as usize];
                self.nodes[leaf as usize].bounds = self.bounds(leaf).union(&now);
                if things < self.few {
                    self.things[(first + things) as usize] = thing;
                    self.nodes[leaf as usize].things += 1;
                    self.leaves[thing as usize] = leaf;
                } else {
                    self.split(leaf, thing, boxes, touched);
                }
                leaf
            }
            InsertPosition::Beside(node) => {
                let pair = self.pair();
                self.nodes[pair as usize] = self.nodes[node as usize];
                self.relink(pair);
                self.shrink(pair, boxes);
                self.make_leaf(pair + 1, &[thing], &now);
                self.make_inner(node, pair);
                touched.extend([pair, pair + 1]);
                node
            }
        };
        self.climb(from, top, boxes, touched);
    }

    /// Splits a full leaf and one more primitive into two leaves.
    fn split(&mut self, leaf: u32, thing: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let Node { first, bounds, .. } = self.nodes[leaf as usize];
        let mut all: SmallVec<[u32; 8]> = self.things(leaf).into();
        all.push(thing);
        let cut = split_leaf(&mut all, boxes);
        self.free_slots.push(first);
        let pair = self.pair();
        for (child, things) in [(pair, &all[..cut]), (pair + 1, &all[cut..])] {
            self.make_leaf(child, things, &bounds);
            self.shrink(child, boxes);
            touched.push(child);
        }
        self.make_inner(leaf, pair);
    }

    pub(super) fn make_leaf(&mut self, node: u32, things: &[u32], bounds: &Aabb) {
        let first = self.leaf_slots();
        self.things[first as usize..first as usize + things.len()].copy_from_slice(things);
        self.nodes[node as usize] = Node {
            bounds: *bounds,
            first,
            things: things.len() as u32,
        };
        self.relink(node);
    }

    pub(super) fn make_inner(&mut self, node: u32, pair: u32) {
        self.nodes[node as usize].first = pair;
        self.nodes[node as usize].things = 0;
        self.relink(node);
    }

    /// Removes a primitive from its leaf. Returns the lowest node whose AABB may now be too large; `None` if the tree
    /// is empty.
    fn take(&mut self, thing: u32, leaf: u32, touched: &mut Vec<u32>) -> Option<u32> {
        let Node { first, things, .. } = self.nodes[leaf as usize];
        if things > 1 {
            let place = self.things(leaf).iter().position(|&other| other == thing)?;
            let last = self.things[(first + things - 1) as usize];
            self.things[first as usize + place] = last;
            self.nodes[leaf as usize].things -= 1;
            return Some(leaf);
        }
        self.free_slots.push(first);
        let parent = self.parent(leaf)?;
        // The sibling replaces the parent.
        let pair = self.nodes[parent as usize].first;
        let sibling = pair + u32::from(leaf == pair);
        self.nodes[parent as usize] = self.nodes[sibling as usize];
        self.relink(parent);
        self.free(pair);
        touched.push(parent);
        Some(self.parent(parent).unwrap_or(parent))
    }

    /// Refits a node and its ancestors. Above `top` refitting stops once an AABB stays the same.
    fn climb(&mut self, from: u32, top: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let mut next = Some(from);
        let mut beyond = false;
        let mut changed = true;
        while let Some(node) = next {
            if changed {
                let was = self.nodes[node as usize].bounds;
                self.merge(node);
                if !beyond {
                    self.rotate(node, touched);
                }
                self.shrink(node, boxes);
                changed = !beyond || self.nodes[node as usize].bounds != was;
                beyond |= node == top;
            }
            touched.push(node);
            next = self.parent(node);
        }
    }

    /// Refits all stale nodes, each once.
    fn refit(&mut self, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let mut next = touched.len();
        touched.extend(self.root());
        let first = next;
        while let Some(&node) = touched.get(next) {
            let stale = self.children(node).filter(|&child| self.stale[child as usize]);
            touched.extend(stale);
            next += 1;
        }
        // Children come after their parents.
        for &node in touched[first..].iter().rev() {
            self.stale[node as usize] = false;
            self.merge(node);
            self.fit(node, boxes);
        }
    }

    /// Shrinks a node's AABB to its content. Primitives of a leaf that still have to be shifted may be far away by now.
    /// They must not enlarge the leaf's AABB, or others would be inserted in the wrong subtree; they are enclosed again
    /// when they are shifted.
    fn shrink(&mut self, node: u32, boxes: &impl Fn(u32) -> Aabb) {
        let held = self.nodes[node as usize].bounds;
        self.fit(node, boxes);
        let Node { bounds, things, .. } = &mut self.nodes[node as usize];
        let shared = bounds.intersection(&held);
        if *things != 0 {
            *bounds = if shared.is_empty() { held } else { shared };
        }
    }

    /// Merges two leaf children into their parent if their primitives fit into one leaf at no higher cost.
    fn merge(&mut self, node: u32) {
        let Node {
            first: pair, things, ..
        } = self.nodes[node as usize];
        if things != 0 {
            return;
        }
        let [left, right] = [pair, pair + 1].map(|child| self.nodes[child as usize]);
        let all = left.things + right.things;
        if left.things == 0 || right.things == 0 || all > self.few {
            return;
        }
        let bounds = left.bounds.union(&right.bounds);
        let apart = left.bounds.half_area() * f64::from(left.things)
            + right.bounds.half_area() * f64::from(right.things);
        if bounds.half_area() * f64::from(all) > bounds.half_area() * 2.0 + apart {
            return;
        }
        let from = right.first as usize..(right.first + right.things) as usize;
        self.things.copy_within(from, (left.first + left.things) as usize);
        self.free_slots.push(right.first);
        self.free(pair);
        self.nodes[node as usize] = Node {
            bounds,
            first: left.first,
            things: all,
        };
        self.relink(node);
    }

    /// Performs the tree rotation (child with grandchild) that shrinks the other child's AABB most. Without rotations,
    /// primitives inserted along a row would make a list of nodes.
    fn rotate(&mut self, node: u32, touched: &mut Vec<u32>) {
        let children = self.children(node);
        let mut most = 0.0;
        let mut best = None;
        for upper in children.clone() {
            let other = children.start + u32::from(upper == children.start);
            let below = self.children(other);
            for lower in below.clone() {
                let stays = below.start + u32::from(lower == below.start);
                let held = self.bounds(stays).union(self.bounds(upper));
                let gain = self.bounds(other).half_area() - held.half_area();
                if gain > most {
                    most = gain;
                    best = Some((upper, lower, other, held));
                }
            }
        }
        if let Some((upper, lower, other, held)) = best {
            self.nodes.swap(upper as usize, lower as usize);
            self.relink(upper);
            self.relink(lower);
            self.nodes[other as usize].bounds = held;
            touched.extend([upper, lower, other]);
        }
    }
}
