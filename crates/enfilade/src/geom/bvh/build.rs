//! Builds a BVH top-down with the binned surface area heuristic (SAH), in O(n log n) for any input.
//!
//! Idea: distribute the AABB centres of a node over equal bins along x, y and z, and split between the two bins where
//!     area times count, summed over both sides, is minimal. Large boxes are first separated from the rest if the rest
//!     then splits at much lower cost. Split by count where all centres coincide, and where the tree would exceed
//!     [`MAX_LEVELS`]: coincident, nested or exponentially spaced boxes cannot degenerate into a list.
//!     A PLOC builder (crate `obvhs`) takes O(n²) time on such boxes and makes trees as deep as their number.
//! Source: Wald, On Fast Construction of SAH-Based Bounding Volume Hierarchies, RT 2007, section 3; separating large
//!     boxes is ours.
//! Cost: O(n) for each level, at most [`MAX_LEVELS`] levels, about log₂ n of them for real scenes.
//! Deterministic: the same boxes give the same tree for any number of threads.

use super::Node;
use crate::geom::Aabb;
use crate::threads;
use glam::{Vec3, Vec3A};

/// Maximum number of levels. Splits by count alone need 33 for as many primitives as a u32 can number.
pub(super) const MAX_LEVELS: u32 = 40;

/// Number of bins along each axis.
const BINS: usize = 16;

/// Boxes with a side longer than this fraction of the node's longest side may be separated from the rest: on either
/// side of a plane they would make that side's AABB as large as the node's.
const LARGE: f32 = 0.75;

/// Cost of testing a node's children, relative to testing one primitive.
const VISIT_COST: f64 = 2.0;

/// Minimum number of primitives for building the two subtrees of a node in parallel.
const MIN_TO_SHARE: usize = 4096;

/// A primitive and its AABB.
#[derive(Clone, Copy)]
pub(super) struct Primitive {
    pub(super) bounds: Aabb,
    pub(super) thing: u32,
}

/// The finished tree; the input boxes are sorted so that the primitives of each leaf are adjacent.
pub(super) struct BuiltTree {
    /// In a leaf, `first` is an index into the sorted boxes; in an inner node, an index into `pairs`.
    pub(super) root: Node,
    /// Child pairs; unused entries belong to leaves with several primitives.
    pub(super) pairs: Vec<[Node; 2]>,
}

/// Builds a tree over at least one box, none of them empty, with at most `few` in a leaf; sorts the boxes.
pub(super) fn build(boxes: &mut [Primitive], few: u32) -> BuiltTree {
    let mut pairs = vec![[Node::EMPTY; 2]; boxes.len() - 1];
    let all = Subtree {
        boxes,
        pairs: &mut pairs,
        start: 0,
        level: 1,
    };
    let root = all.build(few);
    BuiltTree { root, pairs }
}

/// A subtree to be built. A split before box `i` of all boxes stores the children in `pairs[i - 1]`, so that subtrees
/// know where their nodes go without knowing of each other.
struct Subtree<'a> {
    boxes: &'a mut [Primitive],
    pairs: &'a mut [[Node; 2]],
    /// Index of the first box, and of the first pair, among all.
    start: usize,
    level: u32,
}

impl Subtree<'_> {
    /// Builds the subtree. Recurses at most [`MAX_LEVELS`] deep.
    fn build(self, few: u32) -> Node {
        let Subtree {
            boxes,
            pairs,
            start,
            level,
        } = self;
        let count = boxes.len();
        let leaf = |bounds| Node {
            bounds,
            first: start as u32,
            things: count as u32,
        };
        if let [one] = boxes {
            return leaf(one.bounds);
        }
        let at = split(boxes, level);
        let (low, high) = boxes.split_at_mut(at);
        let (below, rest) = pairs.split_at_mut(at - 1);
        let (own, above) = rest.split_at_mut(1);
        let [low, high] =
            [(low, below, start), (high, above, start + at)].map(|(boxes, pairs, start)| Subtree {
                boxes,
                pairs,
                start,
                level: level + 1,
            });
        let children: [Node; 2] =
            threads::join(count >= MIN_TO_SHARE, || low.build(few), || high.build(few)).into();
        let bounds = children[0].bounds.union(&children[1].bounds);
        let are_leaves = children.iter().all(|child| child.things > 0);
        if are_leaves && count <= few as usize {
            let apart: f64 = children
                .iter()
                .map(|child| child.bounds.half_area() * f64::from(child.things))
                .sum();
            if bounds.half_area() * (count as f64 - VISIT_COST) <= apart {
                return leaf(bounds);
            }
        }
        own[0] = children;
        Node {
            bounds,
            first: (start + at - 1) as u32,
            things: 0,
        }
    }
}

/// Partitions at least two boxes into those of the first and those of the second child; returns the index of the second
/// child's first box.
fn split(boxes: &mut [Primitive], level: u32) -> usize {
    if boxes.len() == 2 {
        return 1;
    }
    let halvings = usize::BITS - (boxes.len() - 1).leading_zeros();
    let by_area = if level + halvings < MAX_LEVELS {
        split_by_area(boxes)
    } else {
        None
    };
    by_area.unwrap_or_else(|| halve(boxes))
}

/// Partitions at minimum SAH cost: by a plane, or large boxes from the rest. `None` if no plane separates boxes.
fn split_by_area(boxes: &mut [Primitive]) -> Option<usize> {
    let plane = best_plane(boxes)?;
    let whole = BoxSum::of(boxes);
    let limit = LARGE * (whole.high - whole.low).max_element();
    let large = partition(boxes, |one| one.bounds.longest_side() > limit);
    let (large_ones, rest) = boxes.split_at(large);
    if large > 0
        && let Some(below) = best_plane(rest)
        && BoxSum::of(large_ones).cost() + VISIT_COST as f32 * whole.area() + below.cost < plane.cost
    {
        return Some(large);
    }
    Some(partition(boxes, |one| {
        plane.bins.of(&one.bounds)[plane.axis] < plane.bin
    }))
}

/// Partitions into halves of equal count: along the axis with the largest spread of centres, or by size if all centres
/// coincide.
fn halve(boxes: &mut [Primitive]) -> usize {
    let [low, high] = centers(boxes);
    let axis = (high - low).max_position();
    let key = |one: &Primitive| {
        if low == high {
            one.bounds.half_area()
        } else {
            f64::from(center(&one.bounds)[axis])
        }
    };
    let half = boxes.len() / 2;
    boxes.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)).then(a.thing.cmp(&b.thing)));
    half
}

/// Moves the boxes that satisfy `is_first` to the front; returns their number.
fn partition(boxes: &mut [Primitive], is_first: impl Fn(&Primitive) -> bool) -> usize {
    let mut count = 0;
    for i in 0..boxes.len() {
        if is_first(&boxes[i]) {
            boxes.swap(i, count);
            count += 1;
        }
    }
    count
}

/// Returns the minimum and maximum corner of the AABB of all centres.
fn centers(boxes: &[Primitive]) -> [Vec3; 2] {
    boxes
        .iter()
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], one| {
            let center = center(&one.bounds);
            [low.min(center), high.max(center)]
        })
}

fn center(bounds: &Aabb) -> Vec3 {
    bounds.center().into()
}

/// Equal intervals along x, y and z.
#[derive(Clone, Copy)]
struct Bins {
    low: Vec3,
    per_unit: Vec3,
}

impl Bins {
    /// Returns the bin of a box along each axis. If all centres share a coordinate, or are too far apart for f32, all
    /// boxes are in one bin.
    fn of(&self, bounds: &Aabb) -> [usize; 3] {
        // The cast saturates and converts NaN to 0.
        let bins = (center(bounds) - self.low) * self.per_unit;
        bins.to_array().map(|bin| (bin as usize).min(BINS - 1))
    }
}

/// A split between the boxes of lower bins on an axis and the others.
struct Plane {
    /// Area times count, summed over both sides.
    cost: f32,
    bins: Bins,
    axis: usize,
    bin: usize,
}

/// AABB and number of several boxes.
#[derive(Clone, Copy)]
struct BoxSum {
    low: Vec3A,
    high: Vec3A,
    count: u32,
}

impl BoxSum {
    const NONE: BoxSum = BoxSum {
        low: Vec3A::INFINITY,
        high: Vec3A::NEG_INFINITY,
        count: 0,
    };

    fn of(boxes: &[Primitive]) -> BoxSum {
        let mut all = BoxSum::NONE;
        for one in boxes {
            all.add(&BoxSum::one(&one.bounds));
        }
        all
    }

    fn one(bounds: &Aabb) -> BoxSum {
        BoxSum {
            low: bounds.min.into(),
            high: bounds.max.into(),
            count: 1,
        }
    }

    fn add(&mut self, other: &BoxSum) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.count += other.count;
    }

    /// Returns half the surface area of the AABB.
    fn area(&self) -> f32 {
        let size = self.high - self.low;
        (size * Vec3A::new(size.y, size.z, size.x)).element_sum()
    }

    /// Returns area times count.
    fn cost(&self) -> f32 {
        self.area() * self.count as f32
    }
}

/// Returns the split between two bins with the minimum SAH cost, the most balanced one among equals; `None` if all
/// boxes are in one bin along each axis.
fn best_plane(boxes: &[Primitive]) -> Option<Plane> {
    let [low, high] = centers(boxes);
    let bins = Bins {
        low,
        per_unit: BINS as f32 / (high - low),
    };
    let mut held = [[BoxSum::NONE; BINS]; 3];
    for Primitive { bounds, .. } in boxes {
        let one = BoxSum::one(bounds);
        for (held, bin) in held.iter_mut().zip(bins.of(bounds)) {
            held[bin].add(&one);
        }
    }
    let mut best: Option<(f32, u32, Plane)> = None;
    for (axis, held) in held.iter().enumerate() {
        let mut above = [BoxSum::NONE; BINS];
        let mut sum = BoxSum::NONE;
        for bin in (1..BINS).rev() {
            sum.add(&held[bin]);
            above[bin] = sum;
        }
        let mut below = BoxSum::NONE;
        for bin in 1..BINS {
            below.add(&held[bin - 1]);
            let above = &above[bin];
            if below.count == 0 || above.count == 0 {
                continue;
            }
            let cost = below.cost() + above.cost();
            let uneven = below.count.abs_diff(above.count);
            let better = |(least, least_uneven, _): &(f32, u32, Plane)| {
                cost < *least || cost == *least && uneven < *least_uneven
            };
            if best.as_ref().is_none_or(better) {
                best = Some((
                    cost,
                    uneven,
                    Plane {
                        cost,
                        bins,
                        axis,
                        bin,
                    },
                ));
            }
        }
    }
    best.map(|(_, _, plane)| plane)
}
