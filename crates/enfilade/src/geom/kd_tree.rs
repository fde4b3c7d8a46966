//! kd-tree: boxes parted by planes across the axes, one after the other, met from near to far.
//!
//! A plane stands at the boundary of some thing's box, near the middle of the node's longest side, where it cuts the
//! fewest things. What it cuts stands on both sides; each node's box is shrunk to what is in it.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); memory O(n), as at most four numbers are kept for each thing.
//! Every thing stands in leaves whose boxes together hold it whole, so hidden leaves hide only hidden parts.

use crate::geom::Aabb;

/// A tree over numbered boxes, stored as two flat arrays.
#[derive(Clone, Debug, Default)]
pub struct KdTree {
    nodes: Vec<Node>,
    things: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb,
    holds: Holds,
}

#[derive(Clone, Debug)]
enum Holds {
    /// Two nodes that stand side by side: `low` below the plane where `axis` is `at`, `low + 1` above it.
    Halves { axis: u8, at: f32, low: u32 },
    /// A run of things.
    Things { start: u32, end: u32 },
}

/// One node that is still to be split.
struct Cell {
    node: u32,
    space: Aabb,
    members: Vec<u32>,
    depth: u32,
    /// How many copies of things may still be made in it.
    spare: usize,
}

/// Where a cell is split.
struct Split {
    axis: usize,
    at: f32,
    cuts: usize,
}

/// Nodes are not split further below this depth. Halves of about the same number need 30 for 10⁹ things.
const GREATEST_DEPTH: u32 = 48;

/// How often a thing may stand in leaves, in the mean.
const COPIES: usize = 4;

/// How far from the middle a plane is looked for, as a part of the side: a quarter leaves each half at least a quarter.
const NEAR_THE_MIDDLE: f32 = 0.25;

impl KdTree {
    /// Sorts things with the given boxes (numbered by their place in `bounds`; empty ones are left out) until a leaf
    /// holds at most `few`, or no plane parts what it holds.
    pub fn build(bounds: &[Aabb], few: usize) -> KdTree {
        let members: Vec<u32> = (0..bounds.len() as u32)
            .filter(|&i| !bounds[i as usize].is_empty())
            .collect();
        let mut tree = KdTree::default();
        if members.is_empty() {
            return tree;
        }
        let space = members
            .iter()
            .fold(Aabb::EMPTY, |sum, &i| sum.union(&bounds[i as usize]));
        let spare = (COPIES - 1) * members.len();
        tree.nodes.push(Node::new());
        // A stack, not recursion; both halves of a node are made together, so they stand side by side.
        let mut waiting = vec![Cell {
            node: 0,
            space,
            members,
            depth: 0,
            spare,
        }];
        let mut ends = Ends::default();
        while let Some(cell) = waiting.pop() {
            tree.settle(cell, few, bounds, &mut ends, &mut waiting);
        }
        tree.nodes.shrink_to_fit();
        tree.things.shrink_to_fit();
        tree
    }

    fn settle(&mut self, cell: Cell, few: usize, bounds: &[Aabb], ends: &mut Ends, waiting: &mut Vec<Cell>) {
        let Cell {
            node,
            space,
            members,
            depth,
            spare,
        } = cell;
        let held = members
            .iter()
            .fold(Aabb::EMPTY, |sum, &i| sum.union(&bounds[i as usize]));
        let space = held.intersection(&space);
        self.nodes[node as usize].bounds = space;
        let split = if members.len() > few && depth < GREATEST_DEPTH {
            best_split(&space, &members, bounds, ends).filter(|split| split.cuts <= spare)
        } else {
            None
        };
        let Some(Split { axis, at, cuts }) = split else {
            let start = self.things.len() as u32;
            self.things.extend(&members);
            let end = self.things.len() as u32;
            self.nodes[node as usize].holds = Holds::Things { start, end };
            return;
        };
        let low = self.nodes.len() as u32;
        self.nodes[node as usize].holds = Holds::Halves {
            axis: axis as u8,
            at,
            low,
        };
        self.nodes.extend([Node::new(), Node::new()]);
        let [mut below, mut above] = [space; 2];
        below.max[axis] = at;
        above.min[axis] = at;
        let in_half = |half: usize| -> Vec<u32> {
            let side = |&i: &u32| sides(&bounds[i as usize], axis, at)[half];
            members.iter().copied().filter(side).collect()
        };
        // What may still be copied is shared by how much there is to copy: a crowded corner cannot use it all up.
        let halves = [in_half(0), in_half(1)];
        let left = spare - cuts;
        let all = halves[0].len() + halves[1].len();
        let mut shares = [left * halves[0].len() / all; 2];
        shares[1] = left - shares[0];
        for (half, ((members, space), spare)) in
            halves.into_iter().zip([below, above]).zip(shares).enumerate()
        {
            waiting.push(Cell {
                node: low + half as u32,
                space,
                members,
                depth: depth + 1,
                spare,
            });
        }
    }

    /// The number of the root; `None` where the tree holds nothing.
    pub fn root(&self) -> Option<u32> {
        (!self.nodes.is_empty()).then_some(0)
    }

    /// The box of a node.
    pub fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// The two halves of a node, the one on the side of `eye` first; `None` for a leaf.
    pub fn near_and_far(&self, node: u32, eye: [f64; 3]) -> Option<[u32; 2]> {
        match self.nodes[node as usize].holds {
            Holds::Halves { axis, at, low } if eye[usize::from(axis)] > f64::from(at) => Some([low + 1, low]),
            Holds::Halves { low, .. } => Some([low, low + 1]),
            Holds::Things { .. } => None,
        }
    }

    /// The things that stand in a leaf; none in a node that has halves.
    pub fn things(&self, node: u32) -> &[u32] {
        match self.nodes[node as usize].holds {
            Holds::Halves { .. } => &[],
            Holds::Things { start, end } => &self.things[start as usize..end as usize],
        }
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes) + size_of_val(&*self.things)) as u64
    }

    /// At most how many bytes a tree over so many things takes: a leaf holds something, and there are fewer other nodes
    /// than leaves.
    pub fn most_bytes(things: usize) -> u64 {
        (things * COPIES * (2 * size_of::<Node>() + size_of::<u32>())) as u64
    }
}

impl Node {
    fn new() -> Node {
        Node {
            bounds: Aabb::EMPTY,
            holds: Holds::Things { start: 0, end: 0 },
        }
    }
}

/// Does a thing reach below the plane, and above it? What only touches the plane is not cut; what lies in it belongs
/// below.
fn sides(thing: &Aabb, axis: usize, at: f32) -> [bool; 2] {
    let [below, above] = [thing.min[axis] < at, thing.max[axis] > at];
    [below || !above, above]
}

/// Where the boxes of a cell's things begin and end along an axis, each list sorted.
#[derive(Default)]
struct Ends {
    lows: Vec<f32>,
    highs: Vec<f32>,
    /// Where things lie that begin and end in one place.
    flats: Vec<f32>,
}

impl Ends {
    fn gather(&mut self, axis: usize, members: &[u32], bounds: &[Aabb]) {
        let Ends { lows, highs, flats } = self;
        for list in [&mut *lows, &mut *highs, &mut *flats] {
            list.clear();
        }
        for &i in members {
            let [low, high] = [bounds[i as usize].min[axis], bounds[i as usize].max[axis]];
            lows.push(low);
            highs.push(high);
            if low == high {
                flats.push(low);
            }
        }
        for list in [lows, highs, flats] {
            list.sort_unstable_by(f32::total_cmp);
        }
    }

    /// How many things lie wholly below a plane, and wholly above it.
    fn beside(&self, at: f32) -> [usize; 2] {
        let before = |list: &[f32]| list.partition_point(|&end| end < at);
        let up_to = |list: &[f32]| list.partition_point(|&end| end <= at);
        let in_it = up_to(&self.flats) - before(&self.flats);
        [up_to(&self.highs), self.lows.len() - before(&self.lows) - in_it]
    }
}

/// The plane across the longest side along which things can be parted at all.
fn best_split(space: &Aabb, members: &[u32], bounds: &[Aabb], ends: &mut Ends) -> Option<Split> {
    let size = space.size();
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| size[b].total_cmp(&size[a]));
    axes.into_iter().find_map(|axis| {
        ends.gather(axis, members, bounds);
        split_along(axis, space, ends)
    })
}

/// The plane that cuts the fewest things, of those the one nearest to the middle; `None` where none near the middle
/// has something wholly on either side and cuts no more than half of all.
fn split_along(axis: usize, space: &Aabb, ends: &Ends) -> Option<Split> {
    let middle = space.center()[axis];
    let reach = NEAR_THE_MIDDLE * (space.max[axis] - space.min[axis]);
    let all = ends.lows.len();
    let boundaries = [&ends.lows, &ends.highs].into_iter().flat_map(|list| {
        let first = list.partition_point(|&end| end < middle - reach);
        let last = list.partition_point(|&end| end <= middle + reach);
        list[first..last].chunk_by(|a, b| a == b).map(|run| run[0])
    });
    let mut best: Option<(Split, f32)> = None;
    for at in boundaries.chain([middle]) {
        let [below, above] = ends.beside(at);
        let cuts = all - below - above;
        if below == 0 || above == 0 || 2 * cuts > all {
            continue;
        }
        let off = (at - middle).abs();
        let better = |(split, least_off): &(Split, f32)| {
            let order = cuts.cmp(&split.cuts).then(off.total_cmp(least_off));
            order.then(at.total_cmp(&split.at)).is_lt()
        };
        if best.as_ref().is_none_or(better) {
            best = Some((Split { axis, at, cuts }, off));
        }
    }
    best.map(|(split, _)| split)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn cube(at: [f32; 3], side: f32) -> Aabb {
        Aabb {
            min: at,
            max: at.map(|value| value + side),
        }
    }

    /// Pseudo-random numbers from 0 to 1, the same every time.
    fn chance(seed: u32) -> impl FnMut() -> f32 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        }
    }

    fn pebbles(count: usize, side: f32) -> Vec<Aabb> {
        let mut chance = chance(7);
        (0..count)
            .map(|_| cube([0; 3].map(|_| 100.0 * chance()), side * chance()))
            .collect()
    }

    /// Calls `each` with every node, near to far, and whether it is a leaf.
    fn walk(tree: &KdTree, eye: [f64; 3], mut each: impl FnMut(u32, bool)) {
        let mut waiting: Vec<u32> = tree.root().into_iter().collect();
        while let Some(node) = waiting.pop() {
            let halves = tree.near_and_far(node, eye);
            each(node, halves.is_none());
            if let Some([near, far]) = halves {
                waiting.extend([far, near]);
            }
        }
    }

    /// What holds of every tree; gives how many numbers its leaves hold.
    fn check(bounds: &[Aabb], few: usize) -> usize {
        let tree = KdTree::build(bounds, few);
        assert!(tree.bytes() <= KdTree::most_bytes(bounds.len()));
        let mut volume = vec![0.0; bounds.len()];
        let mut met = BTreeSet::new();
        let mut held = 0;
        walk(&tree, [0.0; 3], |node, is_leaf| {
            let outer = *tree.bounds(node);
            if let Some(halves) = tree.near_and_far(node, [0.0; 3]) {
                for half in halves {
                    assert_eq!(outer.union(tree.bounds(half)), outer, "a half reaches out");
                }
            }
            held += tree.things(node).len();
            assert!(is_leaf || tree.things(node).is_empty());
            for &thing in tree.things(node) {
                met.insert(thing);
                let shared = outer.intersection(&bounds[thing as usize]);
                assert!(!shared.is_empty(), "{thing} is not in its leaf");
                volume[thing as usize] += shared.volume();
            }
        });
        for (thing, whole) in bounds.iter().enumerate() {
            assert_eq!(met.contains(&(thing as u32)), !whole.is_empty());
            let lost = whole.volume() - volume[thing];
            assert!(
                lost <= 1e-3 * whole.volume(),
                "{thing} is not held whole by its leaves"
            );
        }
        assert!(held <= COPIES * bounds.len());
        held
    }

    #[test]
    fn every_thing_is_held_whole_and_few_are_copied() {
        let held = check(&pebbles(3000, 3.0), 6);
        assert!((3000..6000).contains(&held), "{held}");
        let large = check(&pebbles(3000, 60.0), 6);
        assert!(large <= COPIES * 3000, "{large}");
    }

    #[test]
    fn no_leaf_comes_after_one_that_it_hides() {
        let tree = KdTree::build(&pebbles(1000, 0.1), 2);
        let mut chance = chance(3);
        let mut crossed = 0;
        for eye in [[-10.0; 3], [100.0, -5.0, 50.0], [50.0; 3]] {
            let mut leaves = Vec::new();
            walk(&tree, eye, |node, is_leaf| {
                if is_leaf {
                    leaves.push(*tree.bounds(node));
                }
            });
            for (place, leaf) in leaves.iter().enumerate() {
                let inside = |axis: usize, t: f32| leaf.min[axis] + t * (leaf.max[axis] - leaf.min[axis]);
                let target = [0, 1, 2].map(|axis| f64::from(inside(axis, chance())));
                for step in 1..10 {
                    let t = 0.1 * f64::from(step);
                    let at = [0, 1, 2].map(|axis| eye[axis] + t * (target[axis] - eye[axis]));
                    let holds = |other: &Aabb| {
                        (0..3).all(|a| f64::from(other.min[a]) < at[a] && at[a] < f64::from(other.max[a]))
                    };
                    if let Some(before) = leaves.iter().position(holds) {
                        assert!(before <= place, "from {eye:?}");
                        crossed += usize::from(before < place);
                    }
                }
            }
        }
        assert!(crossed > 100, "{crossed}");
    }

    #[test]
    fn a_plane_runs_along_the_aisle_and_cuts_nothing() {
        let shelves: Vec<Aabb> = (0..64)
            .map(|i| cube([if i < 32 { 0.0 } else { 4.5 }, i as f32 % 32.0, 0.0], 4.0))
            .map(|b| Aabb {
                max: [b.max[0], b.min[1] + 0.5, b.max[2]],
                ..b
            })
            .collect();
        assert_eq!(check(&shelves, 4), 64);
    }

    #[test]
    fn walls_in_one_plane_are_not_copied() {
        let mut walls = pebbles(500, 2.0);
        for wall in &mut walls {
            wall.min[1] = 7.0;
            wall.max[1] = 7.0;
        }
        assert!(check(&walls, 4) < 1000);
    }

    #[test]
    fn what_cannot_be_parted_is_one_leaf() {
        assert_eq!(KdTree::build(&[], 4).root(), None);
        assert_eq!(KdTree::build(&[Aabb::EMPTY; 9], 4).root(), None);
        assert_eq!(check(&vec![cube([1.0; 3], 0.0); 1000], 4), 1000);
        assert_eq!(check(&vec![cube([1.0; 3], 2.0); 1000], 4), 1000);
        // Russian dolls: every plane cuts all but a few.
        let dolls: Vec<Aabb> = (0..100).map(|i| cube([-(i as f32); 3], 2.0 * i as f32)).collect();
        check(&dolls, 4);
        let huge = [
            cube([-3e38; 3], 1.0),
            cube([3e38; 3], 1.0),
            Aabb::EMPTY,
            cube([0.0; 3], 1.0),
        ];
        check(&huge, 1);
    }

    #[test]
    fn a_hundred_thousand_things_are_parted_in_no_time() {
        let bounds = pebbles(100_000, 0.5);
        let tree = KdTree::build(&bounds, 6);
        let mut largest = 0;
        walk(&tree, [0.0; 3], |node, _| {
            largest = largest.max(tree.things(node).len())
        });
        assert!(largest <= 6);
    }
}
