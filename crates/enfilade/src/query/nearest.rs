//! The items nearest to a point.
//!
//! Idea: best-bounded traversal of the item tree, near to far. Once `count` items are known, nodes farther than the
//!     farthest of them are skipped.
//! Source: Roussopoulos, Kelley, Vincent, Nearest Neighbor Queries, SIGMOD 1995.
//! Cost: O(log items + count · log count) where little overlaps.
//! Exact: distances are those to the items' boxes, in f64; a node is never farther than its contents.

use super::items::nearest_squared;
use crate::geom::Step;
use crate::geometry::Geometry;
use crate::ids::{ItemId, ItemIndex};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Item with its distance from a point. Ordered by distance, then by item id.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestItem {
    /// The item.
    pub item: ItemId,
    /// The key of the item.
    pub key: u64,
    /// Distance from the point to the bounding box of the item, in scene units; 0 inside.
    pub distance: f64,
}

impl Eq for NearestItem {}

impl Ord for NearestItem {
    fn cmp(&self, other: &NearestItem) -> Ordering {
        let by_distance = self.distance.total_cmp(&other.distance);
        by_distance.then(self.item.cmp(&other.item))
    }
}

impl PartialOrd for NearestItem {
    fn partial_cmp(&self, other: &NearestItem) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Geometry {
    /// Finds the `count` items whose bounding boxes are nearest to a point, at most `radius` away, in scene units.
    /// Replaces the contents of `found`, sorted by distance, then by item id. Does not allocate if `found` has enough
    /// capacity.
    ///
    /// Pass `usize::MAX` and infinity for all items. Finds nothing if the radius is negative or NaN or the point is not
    /// finite. Ignores walls and portals; [`Scene::near`](crate::Scene::near) follows portals.
    #[doc(alias = "nearest neighbor")]
    #[doc(alias = "k-nearest")]
    #[doc(alias = "kNN")]
    pub fn nearest_items(&self, point: [f32; 3], count: usize, radius: f32, found: &mut Vec<NearestItem>) {
        found.clear();
        let point = DVec3::from(point.map(f64::from));
        let mut reach = f64::from(radius);
        if !(point.is_finite() && reach >= 0.0 && count > 0) {
            return;
        }
        // A max-heap: its top is the farthest, the next to be replaced.
        let mut best = BinaryHeap::from(std::mem::take(found));
        self.item_tree().walk(point.into(), |step| match step {
            Step::Node(bounds) => nearest_squared(bounds, point).sqrt() <= reach,
            Step::Thing(item) => {
                let item = ItemIndex(item);
                let distance = nearest_squared(&self.item(item).bounds, point).sqrt();
                if distance <= reach {
                    let full = best.len() == count;
                    let one = NearestItem {
                        item: self.id_of(item),
                        key: self.key(item),
                        distance,
                    };
                    if !full {
                        best.push(one);
                    } else if let Some(mut last) = best.peek_mut().filter(|last| one < **last) {
                        *last = one;
                    }
                    if best.len() == count {
                        reach = best.peek().map_or(reach, |last| last.distance);
                    }
                }
                true
            }
        });
        *found = best.into_sorted_vec();
    }
}
