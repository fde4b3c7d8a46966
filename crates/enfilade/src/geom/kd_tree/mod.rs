//! kd-tree: boxes parted by planes across the axes, one after the other, met from near to far.
//!
//! A plane stands at the boundary of some thing's box, near the middle of the node's longest side, where it cuts the
//! fewest things. What it cuts stands on both sides; each node's box is shrunk to what is in it.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); memory O(n), as at most four numbers are kept for each thing.
//! Every thing stands in leaves whose boxes together hold it whole, so hidden leaves hide only hidden parts.

#[cfg(test)]
mod tests;

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
