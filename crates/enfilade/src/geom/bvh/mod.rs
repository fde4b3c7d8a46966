//! Bounding volume hierarchy: numbered boxes in nested boxes, two nodes in each.
//!
//! Each thing stands in one leaf, however large or small it is, so the tree is as small as what it holds, and boxes may
//! overlap.
//! Source: the builder of the `obvhs` crate: Meister, Bittner, Parallel Locally-Ordered Clustering for Bounding Volume
//!     Hierarchy Construction, TVCG 2018.
//! Cost: building O(n log n).
//! A node's box holds all of what stands in it and below it, so a hidden node hides only hidden things.

mod choose;
mod movable;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use obvhs::Boundable;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
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
        let solid: Vec<u32> = (0..count as u32)
            .filter(|&thing| !boxes(thing).is_empty())
            .collect();
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
        let built = built_over(&solid, boxes, few);
        tree.nodes.reserve_exact(built.nodes.len());
        tree.parents.reserve_exact(built.nodes.len() / 2);
        tree.nodes.push(Node::EMPTY);
        // The builder's nodes and where they go; its own order is not ours.
        let mut waiting = vec![(0, 0)];
        while let Some((theirs, ours)) = waiting.pop() {
            let node = &built.nodes[theirs as usize];
            let [first, count] = [node.first_index, node.prim_count].map(|index| index as usize);
            if node.is_leaf() {
                let held = &built.primitive_indices[first..first + count];
                let place = tree.place();
                for (i, &index) in held.iter().enumerate() {
                    let thing = solid[index as usize];
                    tree.things[place as usize + i] = thing;
                    tree.leaves[thing as usize] = ours;
                }
                tree.nodes[ours as usize].first = place;
                tree.nodes[ours as usize].things = count as u32;
                continue;
            }
            let pair = tree.pair();
            tree.nodes[ours as usize].first = pair;
            tree.relink(ours);
            waiting.extend([0, 1].map(|child| (node.first_index + child, pair + child)));
        }
        // Boxes are made here, from the things' own: those of the builder were scaled, and may have lost something.
        for node in (0..tree.nodes.len() as u32).rev() {
            tree.fit(node, boxes);
        }
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
        // While it is built: boxes, the builder's nodes (two a thing), its two rows of nodes at hand, the keys that it
        // sorts by, twice; and our own nodes with their links and places of leaves.
        let theirs = 2 * size_of::<Aabb>() + 4 * 32 + 2 * 32 + 8;
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

/// A box as the builder sees it: within the unit cube, so that its areas neither overflow nor vanish.
struct Tame(obvhs::aabb::Aabb);

impl Boundable for Tame {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

/// The builder's tree over the boxes of `solid`, numbered by their place there.
fn built_over(solid: &[u32], boxes: &impl Fn(u32) -> Aabb, few: u32) -> Bvh2 {
    let whole = solid
        .iter()
        .fold(Aabb::EMPTY, |sum, &thing| sum.union(&boxes(thing)));
    let center = whole.center().map(f64::from);
    let side = (0..3).map(|axis| f64::from(whole.max[axis]) - f64::from(whole.min[axis]));
    let side = side.fold(f64::from(f32::MIN_POSITIVE), f64::max);
    let tame =
        |corner: [f32; 3]| [0, 1, 2].map(|axis| ((f64::from(corner[axis]) - center[axis]) / side) as f32);
    let boxes: Vec<Tame> = solid
        .iter()
        .map(|&thing| {
            let Aabb { min, max } = boxes(thing);
            Tame(obvhs::aabb::Aabb {
                min: tame(min).into(),
                max: tame(max).into(),
            })
        })
        .collect();
    // The steps of the crate's own `build_bvh2` without its clock, which some platforms do not have.
    let mut built = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    collapse(&mut built, few, 3.0);
    built
}
