//! kd-tree over items: near to far by the planes that part them, and whole nodes dropped.
//!
//! Of two halves the one that the eye is in comes first: nothing in the other can hide it. The clusters of an item
//! stand in the tree of its mesh, which all its copies share.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); a walk O(boxes met), without a queue, and what nothing of can be seen ends its subtree.
//! Gives nodes near to far; an item that a plane cuts comes with the first leaf of its that is met.

use super::items::{hand_out, hand_out_openings, hand_out_whole, sight};
use super::{NodesNearToFar, Order, Refusal, Visit};
use crate::geom::{Aabb, KdTree};
use crate::geometry::{Geometry, ItemId, MovedItem};
use crate::passage::Passage;
use crate::region::Visibility;

/// Items parted by planes across the axes.
pub struct KdTreeOrder {
    tree: KdTree,
}

/// A node that waits to be entered.
#[derive(Clone, Copy)]
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

    fn build(geometry: &Geometry, _limit_bytes: u64) -> Result<KdTreeOrder, Refusal> {
        let bounds: Vec<Aabb> = geometry.items().iter().map(|item| item.bounds).collect();
        Ok(KdTreeOrder {
            tree: KdTree::build(&bounds, FEW_ITEMS),
        })
    }

    fn needs_bytes(geometry: &Geometry) -> u64 {
        KdTree::most_bytes(geometry.items().len())
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
        waiting: &mut Vec<Waiting>,
        visit: &mut impl Visit,
    ) {
        hand_out_openings(geometry, passage, visit);
        waiting.clear();
        waiting.extend(self.root());
        self.go_on(geometry, passage, waiting, visit);
    }

    fn begin(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        least: usize,
        waiting: &mut Vec<Waiting>,
        visit: &mut impl Visit,
    ) -> usize {
        hand_out_openings(geometry, passage, visit);
        waiting.clear();
        waiting.extend(self.root());
        let eye = passage.eye();
        // Level by level, so that shares are about as large as each other; what comes first stands last.
        let mut splits = true;
        while splits && waiting.len() < least {
            splits = false;
            let count = waiting.len();
            for place in 0..count {
                let above = waiting[place];
                let Some(halves) = self.tree.near_and_far(above.node, eye) else {
                    waiting.push(above);
                    continue;
                };
                if let Some(fully) = self.enter(above, passage, visit) {
                    splits = true;
                    waiting.extend(halves.into_iter().rev().map(|node| Waiting { node, fully }));
                }
            }
            waiting.drain(..count);
        }
        waiting.len()
    }

    fn deal(&self, begun: &Vec<Waiting>, [number, of]: [usize; 2], share: &mut Vec<Waiting>) {
        let [end, first] = [number, number + 1].map(|number| begun.len() - begun.len() * number / of);
        share.clear();
        share.extend_from_slice(&begun[first..end]);
    }

    fn go_on(
        &self,
        geometry: &Geometry,
        passage: &Passage,
        waiting: &mut Vec<Waiting>,
        visit: &mut impl Visit,
    ) {
        let eye = passage.eye();
        while let Some(next) = waiting.pop() {
            let Some(fully) = self.enter(next, passage, visit) else {
                continue;
            };
            let bounds = self.tree.bounds(next.node);
            if let Some(halves) = self.tree.near_and_far(next.node, eye) {
                waiting.extend(halves.into_iter().rev().map(|node| Waiting { node, fully }));
            }
            for &item in self.tree.things(next.node) {
                // What reaches out of the box may be seen elsewhere only.
                if fully && bounds.union(&geometry.item(ItemId(item)).bounds) == *bounds {
                    hand_out_whole(geometry, passage, ItemId(item), visit);
                } else {
                    hand_out(geometry, passage, ItemId(item), visit);
                }
            }
        }
    }
}

impl KdTreeOrder {
    fn root(&self) -> Option<Waiting> {
        self.tree.root().map(|node| Waiting { node, fully: false })
    }

    /// Is a node seen fully? `None` where nothing of it is seen.
    fn enter(&self, of: Waiting, passage: &Passage, visit: &mut impl Visit) -> Option<bool> {
        if of.fully {
            return Some(true);
        }
        let bounds = self.tree.bounds(of.node);
        match sight(passage, &passage.screen_from_sector, bounds, visit) {
            Visibility::Hidden => None,
            Visibility::Partial => Some(false),
            Visibility::Full => Some(true),
        }
    }
}
