//! kd-tree over items, traversed front to back by its splitting planes; hidden nodes are culled with their subtrees.
//!
//! Of two children, the one on the eye's side comes first: nothing in the other can occlude it. Clusters of an item
//! come from the octree of its mesh, which instances share.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); a traversal O(boxes tested), without a queue. Culling a hidden box ends its subtree.
//! Guarantees nodes front to back; an item that a plane cuts is emitted with the first of its leaves.

use super::{NodesNearToFar, Order, Visit};
use crate::geom::{Aabb, KdTree};
use crate::geometry::{Geometry, MovedItem};
use crate::ids::ItemIndex;
use crate::traversal::{box_visibility, emit_item, emit_openings, emit_whole};
use crate::unsuited::Unsuited;
use crate::view::passage::Passage;
use crate::view::region::Visibility;

/// Front-to-back traversal of a kd-tree over items.
pub struct KdTreeOrder {
    tree: KdTree,
}

/// A node on the traversal stack.
#[derive(Clone, Copy)]
pub struct PendingNode {
    node: u32,
    /// Whether an ancestor is fully visible; then its subtree is not tested.
    fully: bool,
}

/// Maximum number of items in a leaf. A box test costs about as much as the faces of a small item.
const FEW_ITEMS: usize = 6;

impl Order for KdTreeOrder {
    type Gives = NodesNearToFar;
    type Scratch = Vec<PendingNode>;

    const NAME: &'static str = "KdTreeOrder";

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<KdTreeOrder, Unsuited> {
        let bounds: Vec<Aabb> = geometry.items().iter().map(|item| item.bounds).collect();
        Ok(KdTreeOrder {
            tree: KdTree::build(&bounds, FEW_ITEMS),
        })
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        KdTree::max_bytes(geometry.items().len())
    }

    fn bytes(&self) -> u64 {
        self.tree.bytes()
    }

    fn follow(&mut self, geometry: &Geometry, moved: &[MovedItem], touched: &mut Vec<u32>) -> bool {
        let boxes = |item: u32| geometry.items()[item as usize].bounds;
        for MovedItem { item, old_bounds } in moved {
            self.tree.shift(item.0, old_bounds, &boxes, touched);
        }
        self.tree.tidy(geometry.items().len(), &boxes);
        true
    }

    fn visit(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        pending: &mut Vec<PendingNode>,
        visit: &mut impl Visit,
    ) {
        emit_openings(geometry, passage, visit);
        pending.clear();
        pending.extend(self.root());
        self.go_on(geometry, passage, pending, visit);
    }

    fn begin(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        least: usize,
        pending: &mut Vec<PendingNode>,
        visit: &mut impl Visit,
    ) -> usize {
        emit_openings(geometry, passage, visit);
        pending.clear();
        pending.extend(self.root());
        let eye = passage.viewpoint();
        // Level by level, so that the parts become about equally large. The node to be visited first is the last one.
        let mut splits = true;
        while splits && pending.len() < least {
            splits = false;
            let count = pending.len();
            for index in 0..count {
                let above = pending[index];
                let Some(halves) = self.tree.near_and_far(above.node, eye) else {
                    pending.push(above);
                    continue;
                };
                if let Some(fully) = self.enter(above, passage, visit) {
                    splits = true;
                    pending.extend(halves.into_iter().rev().map(|node| PendingNode { node, fully }));
                }
            }
            pending.drain(..count);
        }
        pending.len()
    }

    fn deal(&self, begun: &Vec<PendingNode>, [number, of]: [usize; 2], share: &mut Vec<PendingNode>) {
        let [end, first] = [number, number + 1].map(|number| begun.len() - begun.len() * number / of);
        share.clear();
        share.extend_from_slice(&begun[first..end]);
    }

    fn go_on(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        pending: &mut Vec<PendingNode>,
        visit: &mut impl Visit,
    ) {
        let eye = passage.viewpoint();
        while let Some(next) = pending.pop() {
            let Some(fully) = self.enter(next, passage, visit) else {
                continue;
            };
            let bounds = self.tree.bounds(next.node);
            if let Some(halves) = self.tree.near_and_far(next.node, eye) {
                pending.extend(halves.into_iter().rev().map(|node| PendingNode { node, fully }));
            }
            for &item in self.tree.things(next.node) {
                // An item that extends beyond the leaf's box may be visible only elsewhere, so the leaf's result does
                // not cover it.
                if fully && bounds.union(&geometry.item(ItemIndex(item)).bounds) == *bounds {
                    emit_whole(geometry, passage, ItemIndex(item), visit);
                } else {
                    emit_item(geometry, passage, ItemIndex(item), visit);
                }
            }
        }
    }
}

impl KdTreeOrder {
    fn root(&self) -> Option<PendingNode> {
        self.tree.root().map(|node| PendingNode { node, fully: false })
    }

    /// Tests a node: `Some(true)` if it is fully visible, `Some(false)` if partially, `None` if it is hidden.
    fn enter(&self, of: PendingNode, passage: &Passage, visit: &mut impl Visit) -> Option<bool> {
        if of.fully {
            return Some(true);
        }
        let bounds = self.tree.bounds(of.node);
        match box_visibility(passage, &passage.screen_from_sector, bounds, visit) {
            Visibility::Hidden => None,
            Visibility::Partial => Some(false),
            Visibility::Full => Some(true),
        }
    }
}
