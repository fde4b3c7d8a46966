//! Builds a BVH top-down with a binned surface area heuristic (SAH), in O(n log n) for any boxes.
//!
//! Idea: sort the box centers of a node into equal bins along x, y and z, and split between the two bins where area
//!     times count, summed over both sides, is least; but set large boxes apart first where the rest then splits so much
//!     better. Split by count where all centers coincide, and where the tree would get deeper than [`MAX_LEVELS`]:
//!     coincident, nested or exponentially spaced boxes cannot make a list.
//! Source: Wald, On Fast Construction of SAH-Based Bounding Volume Hierarchies, RT 2007, section 3; setting large boxes
//!     apart is ours.
//! Cost: O(n) for each level, at most [`MAX_LEVELS`] levels, about log₂ n of them for real scenes.
//! The same boxes give the same tree for any number of threads.

use super::Node;
use crate::geom::Aabb;
use crate::threads;
use glam::{Vec3, Vec3A};

/// Levels of a tree, at most. Splits by count alone need 33 for all things that a u32 can number.
pub(super) const MAX_LEVELS: u32 = 40;

/// Bins along each axis.
const BINS: usize = 16;

/// Boxes with a side longer than this part of their node's longest side may be set apart: on either side of a plane they
/// would make the box as large as the node's.
const LARGE: f32 = 0.75;

/// What it costs to test a node's children, where testing a thing costs 1.
const VISIT_COST: f64 = 2.0;

/// Nodes of fewer things are built by one thread.
const FEWEST_TO_SHARE: usize = 4096;

/// A thing and its box.
#[derive(Clone, Copy)]
pub(super) struct Boxed {
    pub(super) bounds: Aabb,
    pub(super) thing: u32,
}

/// A tree over boxes, sorted so that the things of each leaf are adjacent.
pub(super) struct Built {
    /// A leaf's `first` is an index into the sorted boxes, another node's `first` one into `pairs`.
    pub(super) root: Node,
    /// The children of each node; unused where a leaf holds several things.
    pub(super) pairs: Vec<[Node; 2]>,
}

/// Builds a tree over boxes that are not empty, at least one, with at most `few` in a leaf, and sorts them.
pub(super) fn build(boxes: &mut [Boxed], few: u32) -> Built {
    let mut pairs = vec![[Node::EMPTY; 2]; boxes.len() - 1];
    let all = Part {
        boxes,
        pairs: &mut pairs,
        start: 0,
        level: 1,
    };
    let root = all.build(few);
    Built { root, pairs }
}

/// A node to be built. A split before box `i` of all has its children in `pairs[i - 1]`, so that the parts of a tree
/// know where their nodes go without knowing of each other.
struct Part<'a> {
    boxes: &'a mut [Boxed],
    pairs: &'a mut [[Node; 2]],
    /// Where the boxes, and the pairs, start among all.
    start: usize,
    level: u32,
}

impl Part<'_> {
    /// Recurses at most [`MAX_LEVELS`] deep.
    fn build(self, few: u32) -> Node {
        let Part {
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
            [(low, below, start), (high, above, start + at)].map(|(boxes, pairs, start)| Part {
                boxes,
                pairs,
                start,
                level: level + 1,
            });
        let children: [Node; 2] =
            threads::join(count >= FEWEST_TO_SHARE, || low.build(few), || high.build(few)).into();
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

/// Sorts boxes, at least two, into those of the first child and those of the second; returns where the latter start.
fn split(boxes: &mut [Boxed], level: u32) -> usize {
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

/// Splits where it costs least: at a plane, or large boxes from small ones. `None` where no plane separates boxes.
fn split_by_area(boxes: &mut [Boxed]) -> Option<usize> {
    let plane = best_plane(boxes)?;
    let whole = Held::of(boxes);
    let limit = LARGE * (whole.high - whole.low).max_element();
    let large = partition(boxes, |one| one.bounds.longest_side() > limit);
    let (large_ones, rest) = boxes.split_at(large);
    if large > 0
        && let Some(below) = best_plane(rest)
        && Held::of(large_ones).cost() + VISIT_COST as f32 * whole.area() + below.cost < plane.cost
    {
        return Some(large);
    }
    Some(partition(boxes, |one| {
        plane.bins.of(&one.bounds)[plane.axis] < plane.bin
    }))
}

/// Splits into two halves by number: along the axis on which centers are farthest apart, or by size where all coincide.
fn halve(boxes: &mut [Boxed]) -> usize {
    let [low, high] = centers(boxes);
    let axis = (high - low).max_position();
    let key = |one: &Boxed| {
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

/// Moves boxes to the front; returns how many.
fn partition(boxes: &mut [Boxed], is_first: impl Fn(&Boxed) -> bool) -> usize {
    let mut count = 0;
    for i in 0..boxes.len() {
        if is_first(&boxes[i]) {
            boxes.swap(i, count);
            count += 1;
        }
    }
    count
}

/// The corners of the box around all centers.
fn centers(boxes: &[Boxed]) -> [Vec3; 2] {
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
    /// The bins of a box. Where all centers have the same coordinate, or are too far apart for f32, all are in one.
    fn of(&self, bounds: &Aabb) -> [usize; 3] {
        // The cast saturates, and takes NaN to 0.
        let bins = (center(bounds) - self.low) * self.per_unit;
        bins.to_array().map(|bin| (bin as usize).min(BINS - 1))
    }
}

/// Splits boxes into those of lower bins on an axis and the others.
struct Plane {
    /// Area times count, summed over both sides.
    cost: f32,
    bins: Bins,
    axis: usize,
    bin: usize,
}

/// Several boxes, and how many they are.
#[derive(Clone, Copy)]
struct Held {
    low: Vec3A,
    high: Vec3A,
    count: u32,
}

impl Held {
    const NONE: Held = Held {
        low: Vec3A::INFINITY,
        high: Vec3A::NEG_INFINITY,
        count: 0,
    };

    fn of(boxes: &[Boxed]) -> Held {
        let mut all = Held::NONE;
        for one in boxes {
            all.add(&Held::one(&one.bounds));
        }
        all
    }

    fn one(bounds: &Aabb) -> Held {
        Held {
            low: bounds.min.into(),
            high: bounds.max.into(),
            count: 1,
        }
    }

    fn add(&mut self, other: &Held) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.count += other.count;
    }

    /// Half the area of the box around them.
    fn area(&self) -> f32 {
        let size = self.high - self.low;
        (size * Vec3A::new(size.y, size.z, size.x)).element_sum()
    }

    /// Area times count.
    fn cost(&self) -> f32 {
        self.area() * self.count as f32
    }
}

/// The plane between two bins with the least SAH cost, of equal ones the most balanced; `None` where all boxes are in one
/// bin along each axis.
fn best_plane(boxes: &[Boxed]) -> Option<Plane> {
    let [low, high] = centers(boxes);
    let bins = Bins {
        low,
        per_unit: BINS as f32 / (high - low),
    };
    let mut held = [[Held::NONE; BINS]; 3];
    for Boxed { bounds, .. } in boxes {
        let one = Held::one(bounds);
        for (held, bin) in held.iter_mut().zip(bins.of(bounds)) {
            held[bin].add(&one);
        }
    }
    let mut best: Option<(f32, u32, Plane)> = None;
    for (axis, held) in held.iter().enumerate() {
        let mut above = [Held::NONE; BINS];
        let mut sum = Held::NONE;
        for bin in (1..BINS).rev() {
            sum.add(&held[bin]);
            above[bin] = sum;
        }
        let mut below = Held::NONE;
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
