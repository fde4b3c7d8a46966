//! kd-tree over items: near to far by the planes that part them, and whole nodes dropped.
//!
//! Of two halves the one that the eye is in comes first: nothing in the other can hide it. The clusters of an item
//! stand in the tree of its mesh, which all its copies share.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); a walk O(boxes met), without a queue, and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; an item that a plane cuts comes with the first leaf of its that is met.

use super::items::{hand_out, hand_out_openings, hand_out_whole, sight};
use super::{NodesNearToFar, Order, Visit};
use crate::content::{Content, ItemId, Moved};
use crate::geom::{Aabb, KdTree};
use crate::passage::Passage;
use crate::region::Sight;

/// Items parted by planes across the axes.
pub struct KdTreeOrder {
    tree: KdTree,
}

/// A node that waits to be entered.
pub struct Waiting {
    node: u32,
    /// Is it in one that is seen fully? Then nothing in it is asked after.
    fully: bool,
}

/// Items in a leaf, at most. A test costs about as much as a small item's faces.
const FEW_ITEMS: usize = 6;

impl Order for KdTreeOrder {
    type Gives = NodesNearToFar;
    type Scratch = Vec<Waiting>;

    fn build(content: &Content, _limit_bytes: u64) -> Option<KdTreeOrder> {
        let bounds: Vec<Aabb> = content.items().iter().map(|item| item.bounds).collect();
        Some(KdTreeOrder {
            tree: KdTree::build(&bounds, FEW_ITEMS),
        })
    }

    fn needs_bytes(content: &Content) -> u64 {
        KdTree::most_bytes(content.items().len())
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }

    fn follow(&mut self, content: &Content, moved: &[Moved], touched: &mut Vec<u32>) -> bool {
        let boxes = |item: u32| content.items()[item as usize].bounds;
        for Moved { item, was } in moved {
            self.tree.shift(item.0, was, &boxes, touched);
        }
        self.tree.tidy(content.items().len(), &boxes);
        true
    }

    fn visit(
        &self,
        content: &Content,
        passage: &Passage,
        waiting: &mut Vec<Waiting>,
        visit: &mut impl Visit,
    ) {
        hand_out_openings(content, passage, visit);
        waiting.clear();
        waiting.extend(self.tree.root().map(|node| Waiting { node, fully: false }));
        let eye = passage.eye();
        while let Some(Waiting { node, mut fully }) = waiting.pop() {
            let bounds = self.tree.bounds(node);
            if !fully {
                match sight(passage, &passage.screen_from_fragment, bounds, visit) {
                    Sight::Hidden => continue,
                    Sight::Partly => {}
                    Sight::Fully => fully = true,
                }
            }
            if let Some(halves) = self.tree.near_and_far(node, eye) {
                waiting.extend(halves.into_iter().rev().map(|node| Waiting { node, fully }));
            }
            for &item in self.tree.things(node) {
                // What reaches out of the box may be seen elsewhere only.
                if fully && bounds.union(&content.item(ItemId(item)).bounds) == *bounds {
                    hand_out_whole(content, passage, ItemId(item), visit);
                } else {
                    hand_out(content, passage, ItemId(item), visit);
                }
            }
        }
    }
}
