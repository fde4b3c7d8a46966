//! Octree over items: near to far, box by box, and whole nodes dropped.
//!
//! Walks the tree of the geometry's own that other questions go through too, by a queue of boxes by reversed depth.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the tree is that of
//!     Boreskov, Hierarchical s-buffer for scenes of high complexity, its order of children made finer.
//! Cost: building O(n log n); a walk O(boxes met · log waiting), and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::queue::{Queue, Tree, walk};
use super::{NodesNearToFar, Order, Refusal, Visit};
use crate::geom::{Aabb, Octree};
use crate::geometry::{Geometry, MovedItem};
use crate::passage::Passage;
use std::ops::Range;

/// Items in nested eighths of space.
pub struct OctreeOrder;

impl Order for OctreeOrder {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<OctreeOrder, Refusal> {
        geometry.item_tree();
        Ok(OctreeOrder)
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        // An item stands in one node, and a node that holds nothing has two children at least, or a deep only one: seldom.
        geometry.items().len() as u64 * 2 * 64
    }

    fn bytes(&self) -> u64 {
        // The geometry's.
        0
    }

    fn follow(&mut self, _geometry: &Geometry, _moved: &[MovedItem], _touched: &mut Vec<u32>) -> bool {
        // The tree is the geometry's, and has followed them already.
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
