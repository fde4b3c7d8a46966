//! Putting things into nested boxes, taking them out, and moving them, without building the tree anew.
//!
//! A thing that leaves the box of its leaf is taken out and put in again where it costs least; leaves that hold few
//! become one, and on the way up neighbours change places where that makes boxes smaller. That keeps the tree about as
//! good as a new one, so it is built anew only where that was not enough.
//! Source: Catto, Dynamic Bounding Volume Hierarchies, GDC 2019 (what takes whose place); Kopta, Ize, Spjut, Brunvand,
//!     Davis, Kensler, Fast, Effective BVH Updates for Animated Scenes, I3D 2012 (nodes that change places).
//! Cost: O(depth) for a thing that stays in its leaf, and a search for a place ([`super::choose`]) for one that does not.
//! Boxes are as tight as after building, so nothing is met that need not be.

use super::choose::{Goes, part};
use super::{Bvh, Node, pair_of};
use crate::geom::Aabb;
use smallvec::SmallVec;

/// A tree is built anew when its cost is so many times that which it had when it was built. A world that spreads out costs
/// more, and a new tree over it does not cost less: trees in which everything has come and gone ten times were found to
/// cost within a twentieth of new ones. So this is for what nobody thought of.
const WORSE: f64 = 2.0;

/// Every so many changes a thing is put in anew though it could stay in its leaf. All things of a leaf can drift apart
/// or away from it so slowly that none ever leaves its box.
const PATIENCE: usize = 16;

/// A thing stays in its leaf if the box need not grow to more than so many times its area.
const MAY_GROW: f64 = 1.5;

/// A place is looked for below the node that stands so many levels above the first whose box is large enough. Boxes
/// overlap, and the best place may be in a neighbour of that node.
const LEVELS_ABOVE: u32 = 3;

impl Bvh {
    /// Puts in a thing that did not stand in it. `boxes` tells the boxes as they are now, of all things; one that is
    /// empty stands nowhere. Other things whose boxes have changed may still wait to be shifted.
    ///
    /// `touched` gets the nodes of which something has changed, and all those above them; of one that is there twice
    /// the last counts: then its children come before it.
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
        for list in [&mut self.parents, &mut self.spare_pairs] {
            list.clear();
        }
        self.nodes.clear();
        self.nodes.push(Node::EMPTY);
        self.make_leaf(0, &[thing], &now);
        touched.push(0);
    }

    /// Takes out a thing that stands in a leaf. The rest as for [`Bvh::insert`].
    fn remove(&mut self, thing: u32, leaf: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        self.changes += 1;
        self.count -= 1;
        if let Some(from) = self.take(thing, leaf, touched) {
            self.climb(from, from, boxes, touched);
        }
    }

    /// Moves a thing from where its box `was` to where it is now: from nowhere, or to nowhere, where that is empty. The rest
    /// as for [`Bvh::insert`].
    pub(crate) fn shift(
        &mut self,
        thing: u32,
        was: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let now = boxes(thing);
        // What stood nowhere may be remembered in a leaf that is none of its own any more.
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
        let stays = !self.changes.is_multiple_of(PATIENCE) && grown <= MAY_GROW * held.half_area();
        if stays || self.count == 1 {
            self.nodes[leaf as usize].bounds = held.union(&now);
            return self.climb(leaf, leaf, boxes, touched);
        }
        let Some(mut top) = self.take(thing, leaf, touched) else {
            return;
        };
        // Most go a short way, and belong near to where they were. The box that is large enough may be so for the sake
        // of the thing as it was; it is put right on the way back.
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

    /// Builds the tree anew where so much has changed that it may have become bad: when half of the things have, and
    /// then only if it costs more than when it was built. Says whether; all nodes are new then.
    ///
    /// Things are numbered below `count`.
    pub(crate) fn tidy(&mut self, count: usize, boxes: &impl Fn(u32) -> Aabb) -> bool {
        if self.count == 0 || 2 * self.changes < self.count {
            return false;
        }
        self.changes = 0;
        let worse = self.cost_now() > WORSE * self.cost;
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

    /// Puts a thing where it costs least at or below a node, whose box may be too large.
    fn put(&mut self, thing: u32, top: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let now = boxes(thing);
        let from = match self.best_place(thing, &now, top) {
            Goes::Into(leaf) => {
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
            Goes::Beside(node) => {
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

    /// Parts the things of a leaf, and one more.
    fn split(&mut self, leaf: u32, thing: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let Node { first, bounds, .. } = self.nodes[leaf as usize];
        let mut all: SmallVec<[u32; 8]> = self.things(leaf).into();
        all.push(thing);
        let cut = part(&mut all, boxes);
        self.spare_places.push(first);
        let pair = self.pair();
        for (child, things) in [(pair, &all[..cut]), (pair + 1, &all[cut..])] {
            self.make_leaf(child, things, &bounds);
            self.shrink(child, boxes);
            touched.push(child);
        }
        self.make_inner(leaf, pair);
    }

    pub(super) fn make_leaf(&mut self, node: u32, things: &[u32], bounds: &Aabb) {
        let first = self.place();
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

    /// Takes a thing out of its leaf; gives the lowest node whose box may be too large now, if any is left.
    fn take(&mut self, thing: u32, leaf: u32, touched: &mut Vec<u32>) -> Option<u32> {
        let Node { first, things, .. } = self.nodes[leaf as usize];
        if things > 1 {
            let place = self.things(leaf).iter().position(|&other| other == thing)?;
            let last = self.things[(first + things - 1) as usize];
            self.things[first as usize + place] = last;
            self.nodes[leaf as usize].things -= 1;
            return Some(leaf);
        }
        self.spare_places.push(first);
        let parent = self.parent(leaf)?;
        // The sibling takes the parent's place.
        let pair = self.nodes[parent as usize].first;
        let sibling = pair + u32::from(leaf == pair);
        self.nodes[parent as usize] = self.nodes[sibling as usize];
        self.relink(parent);
        self.spare_pairs.push(pair);
        touched.push(parent);
        Some(self.parent(parent).unwrap_or(parent))
    }

    /// Makes the boxes of a node and all above it as large as what is in them. Above `top` that ends where nothing
    /// changes.
    fn climb(&mut self, from: u32, top: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let mut next = Some(from);
        let mut beyond = false;
        let mut changed = true;
        while let Some(node) = next {
            if changed {
                let was = self.nodes[node as usize].bounds;
                self.merge(node);
                if !beyond {
                    self.swap_places(node, touched);
                }
                self.shrink(node, boxes);
                changed = !beyond || self.nodes[node as usize].bounds != was;
                beyond |= node == top;
            }
            touched.push(node);
            next = self.parent(node);
        }
    }

    /// Makes a box as small as what it holds. What is in a leaf and still waits to be shifted may be far away by now: it
    /// does not make the box larger, or others would go where they should not, and is held when it has been shifted.
    fn shrink(&mut self, node: u32, boxes: &impl Fn(u32) -> Aabb) {
        let held = self.nodes[node as usize].bounds;
        self.fit(node, boxes);
        let Node { bounds, things, .. } = &mut self.nodes[node as usize];
        let shared = bounds.intersection(&held);
        if *things != 0 {
            *bounds = if shared.is_empty() { held } else { shared };
        }
    }

    /// Makes a node whose children are leaves one of their things, where these are few and it costs no more.
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
        self.spare_places.push(right.first);
        self.spare_pairs.push(pair);
        self.nodes[node as usize] = Node {
            bounds,
            first: left.first,
            things: all,
        };
        self.relink(node);
    }

    /// Lets a child and a grandchild change places where that makes the other child's box smaller. Without this, things
    /// that come one after the other along a row would make a list of nodes.
    fn swap_places(&mut self, node: u32, touched: &mut Vec<u32>) {
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
