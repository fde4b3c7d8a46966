//! Octree over items: near to far, box by box, and whole nodes dropped.
//!
//! Small items stand in every eighth they touch, large ones where they are; walked by a queue of boxes by nearness.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the tree is that of
//!     Boreskov, Hierarchical s-buffer for scenes of high complexity, its order of children made finer.
//! Cost: building O(n log n); a walk O(boxes met · log waiting), and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::queue::{Queue, Tree, walk};
use super::{NodesNearToFar, Order, Visit};
use crate::content::Content;
use crate::geom::{Aabb, Copies, Octree};
use crate::passage::Passage;
use std::ops::Range;

/// Items in nested eighths of space.
pub struct OctreeOrder {
    tree: Octree,
}

/// Items in a leaf, at most. A test costs about as much as a small item's faces.
const FEW_ITEMS: usize = 6;

impl Order for OctreeOrder {
    type Gives = NodesNearToFar;
    type Scratch = Queue;

    fn build(content: &Content, _limit_bytes: u64) -> Option<OctreeOrder> {
        let bounds: Vec<Aabb> = content.items().iter().map(|item| item.bounds).collect();
        Some(OctreeOrder {
            tree: Octree::build(&bounds, FEW_ITEMS, Copies::OnePerCell),
        })
    }

    fn needs_bytes(content: &Content) -> u64 {
        // At the depth where it stays, an item is no smaller than half a cell: it stands in at most 3 of them along
        // each axis, in practice in one or two; eight copies with a node each are an ample guess.
        content.items().len() as u64 * 8 * 64
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }

    fn visit(&self, content: &Content, passage: &Passage, queue: &mut Queue, visit: &mut impl Visit) {
        walk(&self.tree, content, passage, queue, visit);
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
