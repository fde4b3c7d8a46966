//! Chooses where to insert a primitive into a BVH, and how to split an overfull leaf.
//!
//! The cost of a tree is the sum of its box areas, each weighted by the number of tests on entering the node: its two
//! children, or its primitives. The search enters the cheaper child first and prunes subtrees that cannot contain a
//! cheaper position than the best one found.
//! Source: Goldsmith, Salmon, Automatic Creation of Object Hierarchies for Ray Tracing, IEEE CG&A 1987 (the cost);
//!     Bittner, Hapala, Havran, Fast Insertion-Based Optimization of Bounding Volume Hierarchies, CGF 2013 (the
//!     search).
//! Cost: about sixty boxes tested for an insertion into ten thousand primitives, [`MAX_VISITED`] at most; O(leaf size ·
//!     log) for a split.

use super::Bvh;
use crate::geom::Aabb;
use smallvec::SmallVec;

/// Maximum number of nodes visited in a search. More are reached only where boxes overlap heavily, and then all
/// positions cost about the same.
const MAX_VISITED: u32 = 400;

/// Position at which a primitive is inserted.
pub(super) enum InsertPosition {
    /// Into this leaf.
    Into(u32),
    /// Into a new leaf that becomes the sibling of this node.
    Beside(u32),
}

impl Bvh {
    /// Returns the position in the subtree of `top` that adds the minimum cost.
    pub(super) fn best_position(&self, thing: u32, now: &Aabb, top: u32) -> InsertPosition {
        // Lower bound of the cost anywhere: the primitive is tested whenever its leaf is entered.
        let own = now.half_area();
        let mut least = f64::INFINITY;
        let mut best = InsertPosition::Beside(top);
        // Nodes, and the cost added to all their ancestors.
        let mut pending: SmallVec<[(u32, f64); 64]> = SmallVec::new();
        pending.push((top, 0.0));
        let mut visited = 0;
        while let Some((node, above)) = pending.pop() {
            if above + own >= least || visited == MAX_VISITED {
                continue;
            }
            visited += 1;
            let grown = self.bounds(node).union(now).half_area();
            // A new inner node replaces this one, with it and a leaf for the primitive as its children.
            let beside = above + 2.0 * grown + own;
            if beside < least {
                least = beside;
                best = InsertPosition::Beside(node);
            }
            let after = above + self.growth(node, grown);
            if self.nodes[node as usize].things != 0 {
                if after < least {
                    least = after;
                    best = InsertPosition::Into(node);
                }
                continue;
            }
            let children = self.children(node);
            let [left, right] = [children.start, children.start + 1].map(|child| {
                let held = self.bounds(child);
                held.union(now).half_area() - held.half_area()
            });
            // Ties are broken by a hash of the primitive's number: otherwise many coincident primitives would all take
            // the same path and the tree would degenerate into a list.
            let coin = thing.wrapping_mul(0x9E37_79B9).rotate_left(visited) & 1 == 1;
            let right_first = right < left || right == left && coin;
            let near = children.start + u32::from(right_first);
            let far = children.start + u32::from(!right_first);
            pending.extend([(far, after), (near, after)]);
        }
        best
    }

    /// Returns the cost added to a node itself, not to its subtree, when its area becomes `grown` and a primitive is
    /// added.
    fn growth(&self, node: u32, grown: f64) -> f64 {
        let area = self.bounds(node).half_area();
        match self.nodes[node as usize].things {
            0 => 2.0 * (grown - area),
            things => grown * f64::from(things + 1) - area * f64::from(things),
        }
    }
}

/// Sorts at least two primitives into two groups at minimum cost; returns the size of the first group.
pub(super) fn split_leaf(things: &mut [u32], boxes: &impl Fn(u32) -> Aabb) -> usize {
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
            // Among cuts of equal cost, the most balanced one wins.
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
