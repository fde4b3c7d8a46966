//! Bounding volume hierarchy (BVH): a binary tree of AABBs over primitives.
//!
//! Each primitive is in one leaf, whatever its size, so the tree is linear in the number of primitives; sibling boxes
//! may overlap.
//! Source: for building see `build.rs`, for incremental changes `movable.rs`.
//! Cost: building O(n log n) for any input.
//! A node's AABB contains every primitive of its subtree, so culling a hidden node culls only hidden primitives.

mod build;
mod choose;
mod movable;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use build::{BuiltTree, Primitive, build};
use smallvec::SmallVec;
use std::ops::Range;

/// Bounding volume hierarchy over indexed AABBs, stored in flat arrays.
///
/// A primitive ("thing") is an index into the array of AABBs that the tree was built over.
#[doc(alias = "bounding volume hierarchy")]
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    /// The root is node 0; the two children of a node are adjacent.
    nodes: Vec<Node>,
    /// Primitives of all leaves; each leaf has `few` slots.
    things: Vec<u32>,
    /// Parents of nodes 1 and 2, of nodes 3 and 4, and so on.
    parents: Vec<u32>,
    /// Leaf of each primitive; arbitrary for a primitive that is not in the tree.
    leaves: Vec<u32>,
    /// First nodes of free pairs, and first slots of removed leaves.
    free_pairs: Vec<u32>,
    free_slots: Vec<u32>,
    /// Whether a node has to be refitted, while primitives are moved.
    stale: Vec<bool>,
    few: u32,
    /// Number of primitives in the tree.
    count: usize,
    /// Insertions, removals and moves since the last [`Bvh::tidy`] that evaluated the whole tree.
    changes: usize,
    /// Cost when it was built; see [`Bvh::cost_now`].
    cost: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// First child, or index of the first primitive in [`Bvh::things`].
    first: u32,
    /// Number of primitives in a leaf; 0 in an inner node.
    things: u32,
}

impl Bvh {
    /// Builds a tree over AABBs with at most `few` primitives per leaf (at least 1). Primitives are numbered by their
    /// index in `bounds`; empty AABBs are omitted. Takes O(n log n).
    pub(crate) fn build(bounds: &[Aabb], few: u32) -> Bvh {
        Bvh::over(bounds.len(), &|thing| bounds[thing as usize], few.max(1))
    }

    /// Like [`Bvh::build`], over the primitives below `count` with a nonempty AABB.
    fn over(count: usize, boxes: &impl Fn(u32) -> Aabb, few: u32) -> Bvh {
        let boxed = |thing| Primitive {
            bounds: boxes(thing),
            thing,
        };
        let all = (0..count as u32).map(boxed);
        let mut solid: Vec<Primitive> = all.filter(|one| !one.bounds.is_empty()).collect();
        let mut tree = Bvh {
            nodes: Vec::new(),
            things: Vec::new(),
            parents: Vec::new(),
            leaves: vec![0; count],
            free_pairs: Vec::new(),
            free_slots: Vec::new(),
            stale: Vec::new(),
            few,
            count: solid.len(),
            changes: 0,
            cost: 0.0,
        };
        if solid.is_empty() {
            return tree;
        }
        let BuiltTree { root, pairs } = build(&mut solid, few);
        tree.nodes.reserve_exact(2 * pairs.len() + 1);
        tree.nodes.push(Node::EMPTY);
        // Builder nodes and their final indices: the builder's array has gaps.
        let mut pending = vec![(root, 0)];
        while let Some((built, node)) = pending.pop() {
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
                pending.extend([1, 0].map(|child| (pairs[first][child], pair + child as u32)));
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

    /// Returns the root node; `None` if the tree is empty.
    pub(crate) fn root(&self) -> Option<u32> {
        (self.count > 0).then_some(0)
    }

    /// Returns the AABB of a node.
    pub(crate) fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// Returns the children of a node: two node numbers, or none for a leaf.
    pub(crate) fn children(&self, node: u32) -> Range<u32> {
        let Node { first, things, .. } = self.nodes[node as usize];
        if things == 0 { first..first + 2 } else { 0..0 }
    }

    /// Returns the primitives of a leaf; empty for an inner node.
    pub(crate) fn things(&self, node: u32) -> &[u32] {
        let Node { first, things, .. } = self.nodes[node as usize];
        if things == 0 {
            return &[];
        }
        &self.things[first as usize..(first + things) as usize]
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let numbers = [
            &self.things,
            &self.parents,
            &self.leaves,
            &self.free_pairs,
            &self.free_slots,
        ];
        let numbers: usize = numbers.into_iter().map(|list| size_of_val(&**list)).sum();
        (size_of_val(&*self.nodes) + numbers) as u64
    }

    /// Returns the maximum number of bytes, temporary memory included, for building a tree over `things` primitives
    /// with leaves of at most `few`.
    pub(crate) fn max_bytes(things: usize, few: u32) -> u64 {
        // During building: boxes and the builder's nodes, and the final nodes with their parents and leaf slots.
        let builder_bytes = size_of::<Primitive>() + size_of::<[Node; 2]>();
        let tree_bytes = 2 * size_of::<Node>() + (3 + few as usize) * size_of::<u32>();
        (things * (builder_bytes + tree_bytes)) as u64
    }

    /// Refits a node's AABB to its primitives and children.
    fn fit(&mut self, node: u32, boxes: &impl Fn(u32) -> Aabb) {
        let children = self.children(node);
        self.nodes[node as usize].bounds = if children.is_empty() {
            let own = self.things(node).iter();
            own.fold(Aabb::EMPTY, |sum, &thing| sum.union(&boxes(thing)))
        } else {
            self.bounds(children.start).union(self.bounds(children.start + 1))
        };
    }

    /// Allocates two adjacent nodes.
    fn pair(&mut self) -> u32 {
        self.free_pairs.pop().unwrap_or_else(|| {
            self.nodes.extend([Node::EMPTY; 2]);
            self.parents.push(0);
            self.nodes.len() as u32 - 2
        })
    }

    /// Frees two adjacent nodes.
    fn free(&mut self, pair: u32) {
        // Their area is 0 then, for `cost_now`.
        self.nodes[pair as usize..pair as usize + 2].fill(Node::EMPTY);
        self.free_pairs.push(pair);
    }

    /// Allocates the slots of a leaf.
    fn leaf_slots(&mut self) -> u32 {
        self.free_slots.pop().unwrap_or_else(|| {
            self.things.resize(self.things.len() + self.few as usize, 0);
            self.things.len() as u32 - self.few
        })
    }

    /// Updates the parent of a node's children, and the leaf of its primitives, after the node has moved.
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

    /// Returns the SAH cost: the sum of box areas weighted by the number of children and primitives, relative to the
    /// root's area.
    fn cost_now(&self) -> f64 {
        let tests = |node: &Node| if node.things == 0 { 2 } else { node.things };
        let costs = self
            .nodes
            .iter()
            .map(|node| node.bounds.half_area() * f64::from(tests(node)));
        costs.sum::<f64>() / self.root().map_or(1.0, |root| self.bounds(root).half_area())
    }
}

impl Node {
    const EMPTY: Node = Node {
        bounds: Aabb::EMPTY,
        first: 0,
        things: 0,
    };
}

/// Returns the index in [`Bvh::parents`] for a node other than the root.
fn pair_of(node: u32) -> usize {
    (node as usize - 1) / 2
}
