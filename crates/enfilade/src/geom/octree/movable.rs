//! Incremental insertion, removal and movement of primitives in an octree.
//!
//! A primitive's node follows from its AABB and the cells alone, so the old AABB finds it again. Nodes that become
//! empty are removed at once: the tree stays about equal to one rebuilt over the same root cell.
//! Cost: O(depth) for a change, 64 nodes at most, and O(primitives of a node) where its AABB may shrink.
//! Boxes are refitted as tightly as after building, so traversal tests no more nodes than necessary.

use super::{Cell, Node, NodeCell, Octree, eighth};
use crate::geom::Aabb;
use smallvec::SmallVec;

/// Nodes and cells from the root down.
type Path = SmallVec<[NodeCell; 8]>;

impl Octree {
    /// Inserts primitive `thing`, which must not be in the tree. `boxes` returns the current AABB of any primitive; a
    /// primitive with an empty one is not inserted. Other primitives whose AABBs have changed may still have to be
    /// shifted.
    ///
    /// All changed nodes and their ancestors are appended to `touched`. If a node occurs twice the last occurrence
    /// counts: its children come before it.
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
        let mut path = Path::from_iter([self.root_cell()]);
        self.put(thing, &mut path, &now, boxes, touched);
        self.refit(&path, &Aabb::EMPTY, &now, boxes, touched);
    }

    /// Removes a primitive whose old AABB is `was`. Other arguments as for [`Octree::insert`].
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

    /// Moves a primitive from its old AABB `was` to its current one. Other arguments as for [`Octree::insert`].
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
        // Length of the path that the old and the new position share.
        let shared = path.windows(2).take_while(|pair| {
            let [parent, child] = [&pair[0], &pair[1]];
            self.belongs(parent, &now)
                .is_some_and(|octant| self.child(parent.node, octant) == Some(child.node))
        });
        let shared = shared.count() + 1;
        let last = path[path.len() - 1];
        let Node { children, things, .. } = self.nodes[last.node as usize];
        let descends = (children != 0 || things.len() > self.few) && self.belongs(&last, &now).is_some();
        if shared < path.len() || descends {
            self.take(thing, &mut path, shared, &was.union(&now), boxes, touched);
            self.put(thing, &mut path, &now, boxes, touched);
        }
        self.refit(&path, was, &now, boxes, touched);
    }

    /// Rebuilds the tree if it may have degraded: after changes to half of the primitives, and only if the root cell
    /// has become too small or too large or the node array has many holes. Returns `true` if it was rebuilt; then all
    /// nodes are new.
    ///
    /// Primitives are numbered below `count`.
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

    /// Returns the path from the root to the node that lists a primitive. The primitive was placed by its old or its
    /// current AABB: when it was inserted, or when a node above was split.
    fn path_to(&self, thing: u32, was: &Aabb, now: &Aabb) -> Option<Path> {
        let mut path = Path::new();
        let found = self.root().is_some() && self.seek(thing, [was, now], self.root_cell(), &mut path);
        found.then_some(path)
    }

    fn seek(&self, thing: u32, boxes: [&Aabb; 2], node_cell: NodeCell, path: &mut Path) -> bool {
        path.push(node_cell);
        let node = &self.nodes[node_cell.node as usize];
        let ways = boxes.map(|thing| self.belongs(&node_cell, thing));
        let may_be_here = node.children == 0 || ways.contains(&None);
        if may_be_here && self.things(node_cell.node).contains(&thing) {
            return true;
        }
        for (i, octant) in ways.into_iter().enumerate() {
            let Some(octant) = octant.filter(|_| i == 0 || ways[0] != ways[1]) else {
                continue;
            };
            if let Some(child) = self.child(node_cell.node, octant) {
                let below = NodeCell {
                    node: child,
                    space: eighth(&node_cell.space, node.center, octant),
                    depth: node_cell.depth + 1,
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

    /// Inserts a primitive into the subtree of the last node of `path`, and extends `path` to its node. Does not refit
    /// AABBs of existing nodes.
    fn put(
        &mut self,
        thing: u32,
        path: &mut Path,
        now: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        let mut node_cell = path[path.len() - 1];
        while self.nodes[node_cell.node as usize].children != 0 {
            let Some(octant) = self.belongs(&node_cell, now) else {
                break;
            };
            let center = self.nodes[node_cell.node as usize].center;
            let space = eighth(&node_cell.space, center, octant);
            let child = self.child(node_cell.node, octant);
            node_cell = NodeCell {
                node: child.unwrap_or_else(|| self.add_child(node_cell.node, octant, &space, touched)),
                space,
                depth: node_cell.depth + 1,
            };
            path.push(node_cell);
        }
        let node = &mut self.nodes[node_cell.node as usize];
        self.things.push(&mut node.things, thing);
        if node.children != 0 || node.things.len() <= self.few {
            return;
        }
        let node = node_cell.node as usize;
        // If the node was overfull before, none of its other primitives can descend.
        if self.nodes[node].things.len() > self.few + 1 && self.belongs(&node_cell, now).is_none() {
            return;
        }
        let members = self.things(node_cell.node).to_vec();
        self.things.clear(&mut self.nodes[node].things);
        let mut made = Vec::new();
        self.split(Cell { node_cell, members }, boxes, &mut made);
        for node in made.into_iter().rev() {
            self.fit(node, boxes);
            touched.push(node);
        }
    }

    /// Removes a primitive from the last node of `path`, then shortens `path` to `keep` nodes and removes nodes that
    /// have become empty.
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

    /// Merges all children into their parent if they are leaves with few primitives. The limit is lower than for a
    /// split in building, so that a primitive moving back and forth does not split and merge a node every time.
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

    /// Refits the AABBs of a path bottom-up, after its content has lost the box `was` and gained the box `now`.
    fn refit(
        &mut self,
        path: &[NodeCell],
        was: &Aabb,
        now: &Aabb,
        boxes: &impl Fn(u32) -> Aabb,
        touched: &mut Vec<u32>,
    ) {
        for &NodeCell { node, .. } in path.iter().rev() {
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

    /// Adds a child for an octant that has none. Siblings move up, or to a new block if there is no room.
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
        // From the end, so that no sibling is overwritten before it has moved.
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

    /// Removes an empty child; its siblings close the gap.
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
        // The child's bit is the lowest one once the bits of the siblings before it are cleared.
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
