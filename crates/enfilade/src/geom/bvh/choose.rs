//! Where in a tree of boxes a thing goes, and how the things of a leaf are parted.
//!
//! What counts is the areas of boxes, each as often as something is asked when it is entered: its two children, or its
//! things. The cheaper child is looked into first, and a node not at all where no place below can cost less than one
//! that was found.
//! Source: Goldsmith, Salmon, Automatic Creation of Object Hierarchies for Ray Tracing, IEEE CG&A 1987 (the areas);
//!     Bittner, Hapala, Havran, Fast Insertion-Based Optimization of Bounding Volume Hierarchies, CGF 2013 (the search).
//! Cost: some sixty boxes for a place in ten thousand things, [`MAX_SEEN`] at most; O(things of a leaf · log) for parting
//! them.

use super::Bvh;
use crate::geom::Aabb;
use smallvec::SmallVec;

/// Nodes that are looked at for a place. So many are only where boxes lie all over each other, and then one place is about
/// as good as another.
const MAX_SEEN: u32 = 400;

/// Where a thing goes.
pub(super) enum Goes {
    /// Into a leaf, with its things.
    Into(u32),
    /// Into a leaf of its own, which stands beside this node.
    Beside(u32),
}

impl Bvh {
    /// Where at or below a node a thing goes with the least cost.
    pub(super) fn best_place(&self, thing: u32, now: &Aabb, top: u32) -> Goes {
        // At least so much it costs everywhere: it is asked when its leaf is entered.
        let own = now.half_area();
        let mut least = f64::INFINITY;
        let mut best = Goes::Beside(top);
        // Nodes, and by how much the cost of all above them grows.
        let mut waiting: SmallVec<[(u32, f64); 32]> = SmallVec::new();
        waiting.push((top, 0.0));
        let mut seen = 0;
        while let Some((node, above)) = waiting.pop() {
            if above + own >= least || seen == MAX_SEEN {
                continue;
            }
            seen += 1;
            let grown = self.bounds(node).union(now).half_area();
            // A new node takes its place, and has it and a leaf for the thing as children.
            let beside = above + 2.0 * grown + own;
            if beside < least {
                least = beside;
                best = Goes::Beside(node);
            }
            let after = above + self.growth(node, grown);
            if self.nodes[node as usize].things != 0 {
                if after < least {
                    least = after;
                    best = Goes::Into(node);
                }
                continue;
            }
            let children = self.children(node);
            let [left, right] = [children.start, children.start + 1].map(|child| {
                let held = self.bounds(child);
                held.union(now).half_area() - held.half_area()
            });
            // Of two children that cost the same the thing's number chooses: in a crowd of things in one place each would
            // else go the same way, and the tree would be a list.
            let coin = thing.wrapping_mul(0x9E37_79B9).rotate_left(seen) & 1 == 1;
            let right_first = right < left || right == left && coin;
            let near = children.start + u32::from(right_first);
            let far = children.start + u32::from(!right_first);
            waiting.extend([(far, after), (near, after)]);
        }
        best
    }

    /// How much the cost of a node grows, without what is below it, when its area does and a thing goes into it.
    fn growth(&self, node: u32, grown: f64) -> f64 {
        let area = self.bounds(node).half_area();
        match self.nodes[node as usize].things {
            0 => 2.0 * (grown - area),
            things => grown * f64::from(things + 1) - area * f64::from(things),
        }
    }
}

/// Parts things, at least two, where both sides together cost least; gives how many come before the cut.
pub(super) fn part(things: &mut [u32], boxes: &impl Fn(u32) -> Aabb) -> usize {
    type Few<T> = SmallVec<[T; 8]>;
    let mut best: Option<(f64, usize, Few<u32>)> = None;
    for axis in 0..3 {
        let middle = |thing: &u32| boxes(*thing).center()[axis];
        things.sort_unstable_by(|a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
        let side = |up_to: &mut Aabb, thing: u32| {
            *up_to = up_to.union(&boxes(thing));
            Some(up_to.half_area())
        };
        let below: Few<f64> = things.iter().copied().scan(Aabb::EMPTY, side).collect();
        let above: Few<f64> = things.iter().rev().copied().scan(Aabb::EMPTY, side).collect();
        for cut in 1..things.len() {
            let rest = things.len() - cut;
            let cost = below[cut - 1] * cut as f64 + above[rest - 1] * rest as f64;
            // Of cuts that cost the same the one nearest to the middle.
            let better = best.as_ref().is_none_or(|(least, at, _)| {
                cost < *least || cost == *least && cut.abs_diff(rest) < at.abs_diff(things.len() - at)
            });
            if better {
                best = Some((cost, cut, Few::from_slice(things)));
            }
        }
    }
    let Some((_, cut, order)) = best else {
        return things.len();
    };
    things.copy_from_slice(&order);
    cut
}
