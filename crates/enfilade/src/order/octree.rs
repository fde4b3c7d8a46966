//! Octree over items, traversed front to back; hidden nodes are culled with their subtrees.
//!
//! Uses the octree of the geometry, which also serves other queries, with a priority queue by reversed depth.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the tree is that of
//!     Boreskov, Hierarchical s-buffer for scenes of high complexity, with a finer order of children.
//! Cost: building O(n log n); a traversal O(boxes tested · log(queue length)). Culling a hidden box ends its subtree.
//! Guarantees nodes front to back; single faces may come in any order.

use super::{NodesNearToFar, Order, Visit};
use crate::geom::{Aabb, Octree};
use crate::geometry::{Geometry, MovedItem};
use crate::traversal::{Queue, Tree, walk};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use std::ops::Range;

/// Front-to-back traversal of the geometry's octree over items.
pub struct OctreeOrder;

impl Order for OctreeOrder {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    const NAME: &'static str = "OctreeOrder";

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<OctreeOrder, Unsuited> {
        geometry.item_tree();
        Ok(OctreeOrder)
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        // An item is in one node. A node without items usually has at least two children, or, rarely, a single deep
        // one.
        geometry.items().len() as u64 * 2 * 64
    }

    fn bytes(&self) -> u64 {
        // The geometry owns the tree.
        0
    }

    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // The geometry owns the tree and has updated it already.
        true
    }

    fn visit(&self, geometry: &Geometry, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        walk(geometry.item_tree(), geometry, passage, queue, visit);
    }
}

impl Tree for Octree {
    fn root(&self) -> Option<u32> {
        Octree::root(self)
    }

    fn bounds(&self, node: u32) -> &Aabb {
        Octree::bounds(self, node)
    }

    fn children(&self, node: u32) -> Range<u32> {
        Octree::children(self, node)
    }

    fn items(&self, node: u32) -> &[u32] {
        self.things(node)
    }
}
