//! The items nearest to a point.
//!
//! Idea: best-bounded traversal of the item tree, near to far. Once `count` items are known, nodes farther than the
//!     farthest of them are skipped.
//! Source: Roussopoulos, Kelley, Vincent, Nearest Neighbor Queries, SIGMOD 1995.
//! Cost: O(log items + count · log count) where little overlaps.
//! Exact: distances are those to the items' boxes, in f64; a node is never farther than its contents. What is excluded in
//!     f32 is farther by more than the rounding error.

use super::items::nearest_squared;
use crate::geom::{Aabb, Step};
use crate::geometry::Geometry;
use crate::ids::{ItemId, ItemIndex};
use glam::{DVec3, Vec3A};
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
        let quick = Vec3A::from(point);
        let point = DVec3::from(point.map(f64::from));
        let mut reach = f64::from(radius);
        if !(point.is_finite() && reach >= 0.0 && count > 0) {
            return;
        }
        // A max-heap: its top is the farthest, the next to be replaced.
        let mut best = BinaryHeap::from(std::mem::take(found));
        let mut limit = limit_of(reach);
        self.item_tree().walk(point.into(), |step| match step {
            Step::Node(bounds) => quick_square(bounds, quick) <= limit,
            Step::Thing(item) => {
                let item = ItemIndex(item);
                let bounds = &self.item(item).bounds;
                if quick_square(bounds, quick) > limit {
                    return true;
                }
                let distance = nearest_squared(bounds, point).sqrt();
                if distance <= reach {
                    // Generation and key follow below.
                    let one = NearestItem {
                        item: item.into(),
                        key: 0,
                        distance,
                    };
                    if best.len() < count {
                        best.push(one);
                    } else if let Some(mut last) = best.peek_mut().filter(|last| one < **last) {
                        *last = one;
                    }
                    if best.len() == count {
                        reach = best.peek().map_or(reach, |last| last.distance);
                        limit = limit_of(reach);
                    }
                }
                true
            }
        });
        *found = best.into_sorted_vec();
        for near in found {
            near.key = self.key(near.item.index);
            near.item = self.id_of(near.item.index);
        }
    }
}

/// Returns the squared distance from a point to a box in f32: off by less than a millionth, unless it is subnormal.
fn quick_square(bounds: &Aabb, point: Vec3A) -> f32 {
    let [min, max] = [bounds.min, bounds.max].map(Vec3A::from);
    (min - point).max(point - max).max(Vec3A::ZERO).length_squared()
}

/// Returns a bound of [`quick_square`] for all boxes at most this far away.
fn limit_of(reach: f64) -> f32 {
    ((reach * reach * (1.0 + 1e-5)) as f32).max(f32::MIN_POSITIVE)
}
