//! BVH over items, traversed front to back; hidden nodes are culled with their subtrees.
//!
//! Each item is in one leaf, whatever its size, so the tree is linear in the number of items; sibling boxes may
//! overlap. Clusters of large items come from the octrees of their meshes, which instances share.
//! Source: [`crate::geom::Bvh`], traversed with the priority queue of [`crate::traversal::Queue`].
//! Cost: building O(n log n); a traversal O(boxes tested · log(queue length)). Culling a hidden box ends its subtree.
//! Guarantees nodes front to back; single faces may come in any order.

use super::{NodesNearToFar, Order, Visit};
use crate::geom::{Aabb, Bvh};
use crate::geometry::{Geometry, MovedItem};
use crate::traversal::{Queue, Tree, walk};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use std::ops::Range;

/// Front-to-back traversal of a bounding volume hierarchy over items.
pub struct BvhOrder {
    tree: Bvh,
}

/// Maximum number of items in a leaf. A box test costs about as much as the faces of a small item.
const FEW_ITEMS: u32 = 6;

impl Order for BvhOrder {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    const NAME: &'static str = "BvhOrder";

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<BvhOrder, Unsuited> {
        let bounds: Vec<Aabb> = geometry.items().iter().map(|item| item.bounds).collect();
        Ok(BvhOrder {
            tree: Bvh::build(&bounds, FEW_ITEMS),
        })
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        Bvh::max_bytes(geometry.items().len(), FEW_ITEMS)
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }

    fn follow(&mut self, geometry: &Geometry, moved: &[MovedItem], touched: &mut Vec<u32>) -> bool {
        let boxes = |item: u32| geometry.items()[item as usize].bounds;
        let moved = moved.iter().map(|moved| (moved.item.0, moved.old_bounds));
        self.tree.shift(moved, &boxes, touched);
        self.tree.tidy(geometry.items().len(), &boxes);
        true
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        walk(&self.tree, geometry, passage, queue, visit);
    }
}

impl Tree for Bvh {
    fn root(&self) -> Option<u32> {
        Bvh::root(self)
    }

    fn bounds(&self, node: u32) -> &Aabb {
        Bvh::bounds(self, node)
    }

    fn children(&self, node: u32) -> Range<u32> {
        Bvh::children(self, node)
    }

    fn items(&self, node: u32) -> &[u32] {
        self.things(node)
    }
}
