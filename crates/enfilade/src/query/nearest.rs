//! The nearest items.
//!
//! The tree over the items is walked from near to far; once as many are known as are wanted, what is farther than the
//! last of them is skipped.
//! Source: Roussopoulos, Kelley, Vincent, Nearest Neighbor Queries, SIGMOD 1995.
//! Cost: O(log items + count · log count) where little overlaps.
//! Exact: distances are those to the items' boxes, in f64; a node is never farther than what is in it.

use super::items::nearest_squared;
use crate::geom::Step;
use crate::geometry::{Geometry, ItemId};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// An item and how far it is. The nearer comes first, at one distance the lower.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestItem {
    /// Which.
    pub item: ItemId,
    /// From the point to its box, in scene units; 0 within.
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
    /// The `count` items whose boxes are nearest to a point, and no farther than `radius`, in scene units: the nearest first,
    /// then by number. They replace what `found` held; nothing is allocated where it has room.
    ///
    /// `usize::MAX` and infinity ask for all. None are within a radius that is negative or NaN, or of a point that is not
    /// finite. Walls are not in the way, and openings lead nowhere: [`Scene::near`](crate::Scene::near) goes through those.
    pub fn nearest_items(&self, point: [f32; 3], count: usize, radius: f32, found: &mut Vec<NearestItem>) {
        found.clear();
        let point = DVec3::from(point.map(f64::from));
        let mut reach = f64::from(radius);
        if !(point.is_finite() && reach >= 0.0 && count > 0) {
            return;
        }
        // Its top is the farthest: the next to go.
        let mut best = BinaryHeap::from(std::mem::take(found));
        self.item_tree().walk(point.into(), |step| match step {
            Step::Node(bounds) => nearest_squared(bounds, point).sqrt() <= reach,
            Step::Thing(item) => {
                let item = ItemId(item);
                let distance = nearest_squared(&self.item(item).bounds, point).sqrt();
                if distance <= reach {
                    let full = best.len() == count;
                    let one = NearestItem { item, distance };
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
