//! Bounding volume hierarchy over items: near to far, box by box, and whole nodes dropped.
//!
//! Each item stands in one leaf, however large or small it is, so the tree is as small as the scene and boxes may
//! overlap; clusters of large items are met by the trees of their meshes, which copies share.
//! Source: the builder of the `obvhs` crate: Meister, Bittner, Parallel Locally-Ordered Clustering for Bounding Volume
//!     Hierarchy Construction, TVCG 2018. Walked by the queue of [`super::queue`].
//! Cost: building O(n log n); a walk O(boxes met · log waiting), and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::queue::{Queue, Tree, walk};
use super::{NodesNearToFar, Order, Visit};
use crate::content::Content;
use crate::geom::Aabb;
use crate::passage::Passage;
use obvhs::Boundable;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use std::ops::Range;

/// Items in nested boxes, two nodes in each.
pub struct BvhOrder {
    /// The root comes first; the two children of a node stand side by side, after it.
    nodes: Vec<Node>,
    items: Vec<u32>,
}

struct Node {
    bounds: Aabb,
    /// The first child, or the place of the first item in [`BvhOrder::items`].
    first: u32,
    /// Items of a leaf; 0 where the node has children.
    items: u32,
}

/// Items in a leaf, at most. A test costs about as much as a small item's faces.
const FEW_ITEMS: u32 = 6;

impl Order for BvhOrder {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    fn build(content: &Content, _limit_bytes: u64) -> Option<BvhOrder> {
        let bounds: Vec<Aabb> = content.items().iter().map(|item| item.bounds).collect();
        Some(BvhOrder::over(&bounds))
    }

    fn needs_bytes(content: &Content) -> u64 {
        // While it is built: boxes, the builder's nodes (two an item), its two rows of nodes at hand, the keys that it
        // sorts by, twice, and our own nodes.
        const EACH: usize = 2 * size_of::<Aabb>() + 4 * 32 + 2 * 32 + 2 * size_of::<Node>() + 8;
        (content.items().len() * EACH) as u64
    }

    fn bytes(&self) -> u64 {
        (self.nodes.len() * size_of::<Node>() + self.items.len() * size_of::<u32>()) as u64
    }

    fn visit(&self, content: &Content, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        walk(self, content, passage, queue, visit);
    }
}

impl Tree for BvhOrder {
    fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }

    fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    fn children(&self, node: u32) -> Range<u32> {
        let Node { first, items, .. } = self.nodes[node as usize];
        if items == 0 { first..first + 2 } else { 0..0 }
    }

    fn items(&self, node: u32) -> &[u32] {
        let Node { first, items, .. } = self.nodes[node as usize];
        if items == 0 {
            return &[];
        }
        &self.items[first as usize..(first + items) as usize]
    }
}

/// A box as the builder sees it: within the unit cube, so that its areas neither overflow nor vanish.
struct Tame(obvhs::aabb::Aabb);

impl Boundable for Tame {
    fn aabb(&self) -> obvhs::aabb::Aabb {
        self.0
    }
}

impl BvhOrder {
    /// A tree over things with the given boxes, numbered by their place; empty ones are left out.
    fn over(bounds: &[Aabb]) -> BvhOrder {
        let solid: Vec<u32> = (0..bounds.len() as u32)
            .filter(|&item| !bounds[item as usize].is_empty())
            .collect();
        let mut order = BvhOrder {
            nodes: Vec::new(),
            items: Vec::with_capacity(solid.len()),
        };
        if solid.is_empty() {
            return order;
        }
        let built = built_over(&solid, bounds);
        order.nodes.reserve(built.nodes.len());
        order.nodes.push(Node::EMPTY);
        // The builder's nodes and where they go; its own order is not ours.
        let mut waiting = vec![(0, 0)];
        while let Some((theirs, ours)) = waiting.pop() {
            let node = &built.nodes[theirs as usize];
            let [first, count] = [node.first_index, node.prim_count].map(|index| index as usize);
            let next = order.nodes.len() as u32;
            let ours = &mut order.nodes[ours as usize];
            if node.is_leaf() {
                [ours.first, ours.items] = [order.items.len(), count].map(|index| index as u32);
                let held = &built.primitive_indices[first..first + count];
                order
                    .items
                    .extend(held.iter().map(|&index| solid[index as usize]));
                continue;
            }
            ours.first = next;
            for child in 0..2 {
                waiting.push((node.first_index + child, next + child));
                order.nodes.push(Node::EMPTY);
            }
        }
        order.fit(bounds);
        order
    }

    /// Boxes are made here, from the items' own: those of the builder were scaled, and may have lost something.
    fn fit(&mut self, bounds: &[Aabb]) {
        for node in (0..self.nodes.len() as u32).rev() {
            let own = self.items(node).iter().map(|&item| bounds[item as usize]);
            let below = self.children(node).map(|child| *self.bounds(child));
            let held = own.chain(below).fold(Aabb::EMPTY, |sum, held| sum.union(&held));
            self.nodes[node as usize].bounds = held;
        }
    }
}

impl Node {
    const EMPTY: Node = Node {
        bounds: Aabb::EMPTY,
        first: 0,
        items: 0,
    };
}

/// The builder's tree over the boxes of `solid`, numbered by their place there.
fn built_over(solid: &[u32], bounds: &[Aabb]) -> Bvh2 {
    let whole = solid
        .iter()
        .fold(Aabb::EMPTY, |sum, &item| sum.union(&bounds[item as usize]));
    let center = whole.center().map(f64::from);
    let side = (0..3).map(|axis| f64::from(whole.max[axis]) - f64::from(whole.min[axis]));
    let side = side.fold(f64::from(f32::MIN_POSITIVE), f64::max);
    let tame =
        |corner: [f32; 3]| [0, 1, 2].map(|axis| ((f64::from(corner[axis]) - center[axis]) / side) as f32);
    let boxes: Vec<Tame> = solid
        .iter()
        .map(|&item| {
            let Aabb { min, max } = bounds[item as usize];
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
    collapse(&mut built, FEW_ITEMS, 3.0);
    built
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubes(places: impl Iterator<Item = [f32; 3]>, side: f32) -> Vec<Aabb> {
        let cube = |at: [f32; 3]| Aabb {
            min: at,
            max: at.map(|value| value + side),
        };
        places.map(cube).collect()
    }

    /// Every thing stands in one leaf, and the boxes on the way to it hold it. Gives the depth.
    fn check(bounds: &[Aabb]) -> usize {
        let order = BvhOrder::over(bounds);
        let mut met = vec![0; bounds.len()];
        let mut deepest = 0;
        let mut waiting: Vec<(u32, usize)> = order.root().map(|root| (root, 1)).into_iter().collect();
        while let Some((node, depth)) = waiting.pop() {
            deepest = deepest.max(depth);
            let held = order.bounds(node);
            for child in order.children(node) {
                assert!(child > node);
                assert_eq!(held.union(order.bounds(child)), *held);
                waiting.push((child, depth + 1));
            }
            for &item in order.items(node) {
                assert_eq!(held.union(&bounds[item as usize]), *held);
                met[item as usize] += 1;
            }
        }
        for (item, times) in met.into_iter().enumerate() {
            assert_eq!(times, usize::from(!bounds[item].is_empty()), "thing {item}");
        }
        deepest
    }

    #[test]
    fn every_thing_stands_in_one_leaf_whose_boxes_hold_it() {
        let grid = (0..1000_u16).map(|i| [i % 10, i / 10 % 10, i / 100].map(f32::from));
        let mut bounds = cubes(grid, 0.3);
        bounds[17] = Aabb::EMPTY;
        let depth = check(&bounds);
        assert!((8..20).contains(&depth), "{depth}");
    }

    #[test]
    fn few_things_or_none_make_a_tree() {
        for count in 0..10 {
            check(&cubes((0..count).map(|i| [f32::from(i as u8); 3]), 1.0));
        }
        check(&[Aabb::EMPTY; 3]);
    }

    #[test]
    fn things_that_coincide_or_are_huge_or_tiny_make_a_tree() {
        check(&cubes((0..5000).map(|_| [1.0; 3]), 0.0));
        check(&cubes((0..300).map(|i| [1.2_f32.powi(i); 3]), 1.0));
        check(&cubes((0..300).map(|i| [1e-38 * i as f32; 3]), 1e-39));
        let [low, high] = [[-3e38; 3], [3e38; 3]];
        check(&cubes([low, high, [0.0; 3], low, [1e-20; 3]].into_iter(), 1e37));
    }
}
