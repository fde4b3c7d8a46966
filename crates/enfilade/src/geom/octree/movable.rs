//! Putting things into an octree, taking them out, and moving them, without building it anew.
//!
//! A thing's place follows from its box and the cells alone, so it is found again by its old box, and nodes that nothing
//! is in go at once: what is left is about the tree that would be built now over the same space.
//! Cost: O(depth) for a change, 64 nodes at most, and O(things of a node) where its box may shrink.
//! Boxes are as tight as after building, so nothing is met that need not be.

use super::{Cell, Node, Octree, Place, eighth};
use crate::geom::Aabb;
use smallvec::SmallVec;

/// From the root down.
type Path = SmallVec<[Place; 8]>;

impl Octree {
    /// Puts in a thing that did not stand in it. `boxes` tells the boxes as they are now, of all things; one that is
    /// empty stands nowhere. Other things whose boxes have changed may still wait to be shifted.
    ///
    /// `touched` gets the nodes of which something has changed, and all those above them; of one that is there twice
    /// the last counts: then its children come before it.
    pub(crate) fn insert(&mut self, thing: u32, boxes: &impl Fn(u32) -> Aabb, touched: &mut Vec<u32>) {
        let now = boxes(thing);
        if now.is_empty() {
            return;
        }
        self.changes += 1;
        self.count += 1;
        if self.nodes.is_empty() {
            self.space = now;
            self.nodes.push(Node::new(&now));
        }
        let mut path = Path::from_iter([self.root_place()]);
        self.put(thing, &mut path, &now, boxes, touched);
        self.refit(&path, &Aabb::EMPTY, &now, boxes, touched);
    }

    /// Takes out a thing that stands where its box `was`. The rest as for [`Octree::insert`].
    pub(crate) fn remove(
        &mut self,
        thing: u32,
        was: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let Some(mut path) = self.path_to(thing, was, &boxes(thing)) else {
            return;
        };
        self.changes += 1;
        self.count -= 1;
        let gone = was.union(&boxes(thing));
        self.take(thing, &mut path, 1, &gone, boxes, touched);
        self.merge(0);
        self.refit(&path, &gone, &Aabb::EMPTY, boxes, touched);
    }

    /// Moves a thing from where its box `was` to where it is. The rest as for [`Octree::insert`].
    pub(crate) fn shift(
        &mut self,
        thing: u32,
        was: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let now = boxes(thing);
        if now.is_empty() {
            return self.remove(thing, was, boxes, touched);
        }
        let Some(mut path) = self.path_to(thing, was, &now) else {
            return self.insert(thing, boxes, touched);
        };
        self.changes += 1;
        // As far as both ways go together.
        let shared = path.windows(2).take_while(|pair| {
            let [parent, child] = [&pair[0], &pair[1]];
            self.belongs(parent, &now)
                .is_some_and(|octant| self.child(parent.node, octant) == Some(child.node))
        });
        let shared = shared.count() + 1;
        let last = path[path.len() - 1];
        let Node { children, things, .. } = self.nodes[last.node as usize];
        let goes_below = (children != 0 || things.len() > self.few) && self.belongs(&last, &now).is_some();
        if shared < path.len() || goes_below {
            self.take(thing, &mut path, shared, &was.union(&now), boxes, touched);
            self.put(thing, &mut path, &now, boxes, touched);
        }
        self.refit(&path, was, &now, boxes, touched);
    }

    /// Builds the tree anew where so much has changed that it may have become bad: when half of the things have, and
    /// then only if they stand in another space now, or the memory has holes. Says whether; all nodes are new then.
    ///
    /// Things are numbered below `count`.
    pub(crate) fn tidy(&mut self, count: usize, boxes: &impl Fn(u32) -> Aabb) -> bool {
        if self.count == 0 || 2 * self.changes < self.count.max(self.few) {
            return false;
        }
        self.changes = 0;
        let outside = |&&thing: &&u32| self.is_outside(boxes(thing).center());
        let too_small = self.things(0).iter().filter(outside).count() > self.few;
        let too_large = 2.0 * self.bounds(0).longest_side() < self.space.longest_side();
        let holes = 2 * self.spare.len() > self.nodes.len();
        if too_small || too_large || holes {
            *self = Octree::over(count, boxes, self.few);
        }
        too_small || too_large || holes
    }

    /// The nodes from the root to the one that a thing stands in. It was put there when its box was the one or the other,
    /// or when a node above was split, by either.
    fn path_to(&self, thing: u32, was: &Aabb, now: &Aabb) -> Option<Path> {
        let mut path = Path::new();
        let found = self.root().is_some() && self.seek(thing, [was, now], self.root_place(), &mut path);
        found.then_some(path)
    }

    fn seek(&self, thing: u32, boxes: [&Aabb; 2], place: Place, path: &mut Path) -> bool {
        path.push(place);
        let node = &self.nodes[place.node as usize];
        let ways = boxes.map(|thing| self.belongs(&place, thing));
        let may_be_here = node.children == 0 || ways.contains(&None);
        if may_be_here && self.things(place.node).contains(&thing) {
            return true;
        }
        for (i, octant) in ways.into_iter().enumerate() {
            let Some(octant) = octant.filter(|_| i == 0 || ways[0] != ways[1]) else {
                continue;
            };
            if let Some(child) = self.child(place.node, octant) {
                let below = Place {
                    node: child,
                    space: eighth(&place.space, node.center, octant),
                    depth: place.depth + 1,
                };
                if self.seek(thing, boxes, below, path) {
                    return true;
                }
            }
        }
        path.pop();
        false
    }

    fn child(&self, node: u32, octant: usize) -> Option<u32> {
        let node = &self.nodes[node as usize];
        let before = (node.children & ((1_u16 << octant) - 1) as u8).count_ones();
        (node.children >> octant & 1 == 1).then_some(node.first_child + before)
    }

    /// Puts a thing into the last node of a path or below it; the path then leads to where. Its boxes are as they were.
    fn put(
        &mut self,
        thing: u32,
        path: &mut Path,
        now: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let mut place = path[path.len() - 1];
        while self.nodes[place.node as usize].children != 0 {
            let Some(octant) = self.belongs(&place, now) else {
                break;
            };
            let center = self.nodes[place.node as usize].center;
            let space = eighth(&place.space, center, octant);
            let child = self.child(place.node, octant);
            place = Place {
                node: child.unwrap_or_else(|| self.add_child(place.node, octant, &space, touched)),
                space,
                depth: place.depth + 1,
            };
            path.push(place);
        }
        let node = &mut self.nodes[place.node as usize];
        self.things.push(&mut node.things, thing);
        if node.children != 0 || node.things.len() <= self.few {
            return;
        }
        let node = place.node as usize;
        // Where there were more than few before, none of them may go.
        if self.nodes[node].things.len() > self.few + 1 && self.belongs(&place, now).is_none() {
            return;
        }
        let members = self.things(place.node).to_vec();
        self.things.clear(&mut self.nodes[node].things);
        let mut made = Vec::new();
        self.split(Cell { place, members }, boxes, &mut made);
        for node in made.into_iter().rev() {
            self.fit(node, boxes);
            touched.push(node);
        }
    }

    /// Takes a thing out of the last node of a path, which is cut down to `keep` nodes; what is empty then goes.
    fn take(
        &mut self,
        thing: u32,
        path: &mut Path,
        keep: usize,
        gone: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let last = path[path.len() - 1].node as usize;
        self.things.remove(&mut self.nodes[last].things, thing);
        while path.len() > keep {
            let below = path.len() - 1;
            let node = path[below].node;
            let Node { children, things, .. } = self.nodes[node as usize];
            if children == 0 && things.len() == 0 {
                self.drop_child(path[below - 1].node, node, touched);
            } else {
                self.merge(node);
                self.refit(&path[below..], gone, &Aabb::EMPTY, boxes, touched);
            }
            path.truncate(below);
        }
    }

    /// Takes the things of all children into a node, if they are few and nothing is below them. Fewer than make a leaf
    /// when building: a thing that goes to and fro shall not split and merge it every time.
    fn merge(&mut self, node: u32) {
        let mut all = self.nodes[node as usize].things.len();
        for child in self.children(node) {
            let child = &self.nodes[child as usize];
            if child.children != 0 {
                return;
            }
            all += child.things.len();
        }
        if all > (2 * self.few).div_ceil(3) || self.children(node).is_empty() {
            return;
        }
        for child in self.children(node) {
            let mut things = self.nodes[child as usize].things;
            for i in 0..things.len() {
                let thing = self.things.get(things)[i];
                self.things.push(&mut self.nodes[node as usize].things, thing);
            }
            self.things.clear(&mut things);
            self.nodes[child as usize] = Node::new(&Aabb::EMPTY);
        }
        let node = &mut self.nodes[node as usize];
        node.children = 0;
        self.spare
            .give(node.first_child, u32::from(std::mem::take(&mut node.room)));
    }

    /// Makes boxes as large as what is in them, bottom up, after that went out of one box and came into another.
    fn refit(
        &mut self,
        path: &[Place],
        was: &Aabb,
        now: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        for &Place { node, .. } in path.iter().rev() {
            let held = self.nodes[node as usize].bounds;
            let may_shrink = (0..3).any(|axis| {
                was.min[axis] <= held.min[axis] && held.min[axis] < now.min[axis]
                    || was.max[axis] >= held.max[axis] && held.max[axis] > now.max[axis]
            });
            if may_shrink {
                self.fit(node, boxes);
            } else {
                self.nodes[node as usize].bounds = held.union(now);
            }
            touched.push(node);
        }
    }

    /// Makes a node for an eighth that has none. Its siblings move up, or elsewhere if there is no room.
    fn add_child(&mut self, parent: u32, octant: usize, space: &Aabb, touched: &mut Vec<u32>) -> u32 {
        let Node {
            first_child: old,
            children,
            room: old_room,
            ..
        } = self.nodes[parent as usize];
        let count = children.count_ones();
        let before = (children & ((1_u16 << octant) - 1) as u8).count_ones();
        let (first, room) = if count < u32::from(old_room) {
            (old, old_room)
        } else {
            self.block((count + 1).next_power_of_two())
        };
        // From the end, so that none is overwritten that has yet to move.
        for i in (0..count).rev() {
            let to = first + i + u32::from(i >= before);
            if to != old + i {
                let empty = Node::new(&Aabb::EMPTY);
                self.nodes[to as usize] = std::mem::replace(&mut self.nodes[(old + i) as usize], empty);
                touched.push(to);
            }
        }
        if first != old {
            self.spare.give(old, u32::from(old_room));
        }
        let node = &mut self.nodes[parent as usize];
        node.first_child = first;
        node.room = room;
        node.children |= 1 << octant;
        self.nodes[(first + before) as usize] = Node::new(space);
        first + before
    }

    /// Forgets an empty child. Its siblings close up.
    fn drop_child(&mut self, parent: u32, child: u32, touched: &mut Vec<u32>) {
        let Node {
            first_child: first,
            children,
            room,
            ..
        } = self.nodes[parent as usize];
        let last = first + children.count_ones() - 1;
        for at in child..last {
            self.nodes[at as usize] = self.nodes[at as usize + 1];
            touched.push(at);
        }
        self.nodes[last as usize] = Node::new(&Aabb::EMPTY);
        // The child's bit is the lowest of those that are left when the bits of the siblings before it are gone.
        let mut rest = children;
        for _ in first..child {
            rest &= rest - 1;
        }
        let node = &mut self.nodes[parent as usize];
        node.children &= !(rest & rest.wrapping_neg());
        if node.children == 0 {
            node.room = 0;
            self.spare.give(first, u32::from(room));
        }
    }
}
