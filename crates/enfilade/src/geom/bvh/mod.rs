//! Bounding volume hierarchy: numbered boxes in nested boxes, two nodes in each.
//!
//! Each thing stands in one leaf, however large or small it is, so the tree is as small as what it holds, and boxes may
//! overlap.
//! Source: see `build.rs` for building, `movable.rs` for changes.
//! Cost: building O(n log n) for any boxes.
//! A node's box holds all of what stands in it and below it, so a hidden node hides only hidden things.

mod build;
mod choose;
mod movable;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use build::{Boxed, Built, build};
use smallvec::SmallVec;
use std::ops::Range;

/// A tree over numbered boxes, stored as flat arrays.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// The root comes first; the two children of a node stand side by side.
    nodes: Vec<Node>,
    /// Each leaf has a place for `few` things.
    things: Vec<u32>,
    /// The parents of nodes 1 and 2, of nodes 3 and 4, and so on.
    parents: Vec<u32>,
    /// The leaf of each thing; of a thing that stands nowhere, any number.
    leaves: Vec<u32>,
    /// First ones of pairs of nodes that nothing is in, and places of leaves that are no more.
    spare_pairs: Vec<u32>,
    spare_places: Vec<u32>,
    few: u32,
    /// How many things it holds.
    count: usize,
    /// Things put in, taken out and moved since the tree was last looked at as a whole.
    changes: usize,
    /// What it cost when it was built, by [`Bvh::cost_now`].
    cost: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// The first child, or where the first thing is in [`Bvh::things`].
    first: u32,
    /// Things of a leaf; 0 where the node has children.
    things: u32,
}

impl Bvh {
    /// Sorts things with the given boxes, numbered by their place, into leaves of at most `few`; empty boxes are left
    /// out.
    pub fn build(bounds: &[Aabb], few: u32) -> Bvh {
        Bvh::over(bounds.len(), &|thing| bounds[thing as usize], few.max(1))
    }

    /// As [`Bvh::build`], over the things below `count` that have a box.
    fn over(count: usize, boxes: &impl Fn(u32) -> Aabb, few: u32) -> Bvh {
        let boxed = |thing| Boxed {
            bounds: boxes(thing),
            thing,
        };
        let all = (0..count as u32).map(boxed);
        let mut solid: Vec<Boxed> = all.filter(|one| !one.bounds.is_empty()).collect();
        let mut tree = Bvh {
            nodes: Vec::new(),
            things: Vec::new(),
            parents: Vec::new(),
            leaves: vec![0; count],
            spare_pairs: Vec::new(),
            spare_places: Vec::new(),
            few,
            count: solid.len(),
            changes: 0,
            cost: 0.0,
        };
        if solid.is_empty() {
            return tree;
        }
        let Built { root, pairs } = build(&mut solid, few);
        tree.nodes.reserve_exact(2 * pairs.len() + 1);
        tree.nodes.push(Node::EMPTY);
        // Nodes of the builder, and where they go: it leaves gaps.
        let mut waiting = vec![(root, 0)];
        while let Some((built, node)) = waiting.pop() {
            let Node {
                bounds,
                first,
                things,
            } = built;
            let first = first as usize;
            tree.nodes[node as usize].bounds = bounds;
            if things == 0 {
                let pair = tree.pair();
                tree.make_inner(node, pair);
                waiting.extend([1, 0].map(|child| (pairs[first][child], pair + child as u32)));
            } else {
                let held = solid[first..first + things as usize].iter();
                let held: SmallVec<[u32; 8]> = held.map(|one| one.thing).collect();
                tree.make_leaf(node, &held, &bounds);
            }
        }
        tree.nodes.shrink_to_fit();
        tree.parents.shrink_to_fit();
        tree.cost = tree.cost_now();
        tree
    }

    /// The number of the root; `None` where the tree holds nothing.
    pub fn root(&self) -> Option<u32> {
        (self.count > 0).then_some(0)
    }

    /// The box of a node.
    pub fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// The numbers of a node's children.
    pub fn children(&self, node: u32) -> Range<u32> {
        let Node { first, things, .. } = self.nodes[node as usize];
        if things == 0 { first..first + 2 } else { 0..0 }
    }

    /// The things that stand in a leaf; none in a node that has children.
    pub fn things(&self, node: u32) -> &[u32] {
        let Node { first, things, .. } = self.nodes[node as usize];
        if things == 0 {
            return &[];
        }
        &self.things[first as usize..(first + things) as usize]
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        let numbers = [
            &self.things,
            &self.parents,
            &self.leaves,
            &self.spare_pairs,
            &self.spare_places,
        ];
        let numbers: usize = numbers.into_iter().map(|list| size_of_val(&**list)).sum();
        (size_of_val(&*self.nodes) + numbers) as u64
    }

    /// At most how many bytes building a tree over so many things takes, with leaves of at most `few`.
    pub fn most_bytes(things: usize, few: u32) -> u64 {
        // While it is built: boxes and the builder's nodes; and our own nodes with their links and places of leaves.
        let theirs = size_of::<Boxed>() + size_of::<[Node; 2]>();
        let ours = 2 * size_of::<Node>() + (3 + few as usize) * size_of::<u32>();
        (things * (theirs + ours)) as u64
    }

    /// Makes a box as large as what it holds.
    fn fit(&mut self, node: u32, boxes: &impl Fn(u32) -> Aabb) {
        let own = self.things(node).iter().map(|&thing| boxes(thing));
        let below = self.children(node).map(|child| *self.bounds(child));
        self.nodes[node as usize].bounds = own.chain(below).fold(Aabb::EMPTY, |sum, held| sum.union(&held));
    }

    /// Room for two nodes side by side.
    fn pair(&mut self) -> u32 {
        self.spare_pairs.pop().unwrap_or_else(|| {
            self.nodes.extend([Node::EMPTY; 2]);
            self.parents.push(0);
            self.nodes.len() as u32 - 2
        })
    }

    /// Room for the things of a leaf.
    fn place(&mut self) -> u32 {
        self.spare_places.pop().unwrap_or_else(|| {
            self.things.resize(self.things.len() + self.few as usize, 0);
            self.things.len() as u32 - self.few
        })
    }

    /// Tells what hangs below a node where it hangs.
    fn relink(&mut self, node: u32) {
        let Node { first, things, .. } = self.nodes[node as usize];
        if things == 0 {
            self.parents[pair_of(first)] = node;
        }
        for i in 0..things {
            let thing = self.things[(first + i) as usize];
            self.leaves[thing as usize] = node;
        }
    }

    /// The areas of all boxes, each as often as something is asked when it is entered, in parts of the whole's.
    fn cost_now(&self) -> f64 {
        let mut waiting: Vec<u32> = self.root().into_iter().collect();
        let mut cost = 0.0;
        while let Some(node) = waiting.pop() {
            cost +=
                self.bounds(node).half_area() * (self.children(node).len() + self.things(node).len()) as f64;
            waiting.extend(self.children(node));
        }
        cost / self.root().map_or(1.0, |root| self.bounds(root).half_area())
    }
}

impl Node {
    const EMPTY: Node = Node {
        bounds: Aabb::EMPTY,
        first: 0,
        things: 0,
    };
}

/// The place in [`Bvh::parents`] of a node that is not the root.
fn pair_of(node: u32) -> usize {
    (node as usize - 1) / 2
}
