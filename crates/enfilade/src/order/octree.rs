//! Octree over items: near to far, node by node, and whole nodes dropped.
//!
//! An item that reaches into several cells stands in each, and is met once; what is large stays in inner nodes.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1; the order of children
//!     from Boreskov, Hierarchical s-buffer for scenes of high complexity.
//! Cost: building O(n log n); a walk follows what is seen: a node that nothing of can be seen ends its subtree.
//! Gives nodes near to far; single faces may come in any order.

use super::items::{hand_out, hand_out_openings};
use super::{NodesNearToFar, Order, Visit};
use crate::content::{Content, ItemId};
use crate::geom::{Aabb, Copies, Octree, Step};
use crate::passage::Passage;
use crate::region::Region;

/// Items in nested eighths of space.
pub struct OctreeOrder {
    tree: Octree,
}

/// Items in a leaf, at most. A test costs about as much as a small item's faces.
const FEW_ITEMS: usize = 6;

impl Order for OctreeOrder {
    type Gives = NodesNearToFar;

    fn build(content: &Content) -> OctreeOrder {
        let bounds: Vec<Aabb> = content.items().iter().map(|item| item.bounds).collect();
        OctreeOrder {
            tree: Octree::build(&bounds, FEW_ITEMS, Copies::OnePerCell),
        }
    }

    fn needs_bytes(content: &Content) -> u64 {
        // An item has at most eight copies at its depth; a node for each copy is more than were ever seen.
        content.items().len() as u64 * 8 * 64
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }

    fn visit(&self, content: &Content, passage: &Passage, visit: &mut impl Visit) {
        hand_out_openings(content, passage, visit);
        self.tree.walk(passage.eye(), |step| match step {
            Step::Node(bounds) => Region::of(passage, &passage.screen_from_fragment, bounds)
                .is_some_and(|region| visit.enter(&region)),
            Step::Thing(item) => {
                hand_out(content, passage, ItemId(item), visit);
                true
            }
        });
    }
}
