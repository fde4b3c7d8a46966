//! kd-tree: boxes parted by planes across the axes, one after the other, met from near to far.
//!
//! A plane stands at the boundary of some thing's box, near the middle of the node's longest side, where it cuts the
//! fewest things. What it cuts stands on both sides; each node's box is shrunk to what is in it.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); memory O(n), as at most four numbers are kept for each thing.
//! Every thing stands in leaves whose boxes together hold it whole, so hidden leaves hide only hidden parts.

mod movable;
mod plane;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use crate::geom::runs::{Run, Runs};
use plane::{Ends, Split, best_split};

/// A tree over numbered boxes, stored as two flat arrays.
#[derive(Clone, Debug)]
pub struct KdTree {
    nodes: Vec<Node>,
    things: Runs,
    /// First ones of pairs of nodes that nothing is in.
    spare_pairs: Vec<u32>,
    /// Nodes that were split since the tree was last tidied; some may be others by now.
    new: Vec<u32>,
    few: usize,
    /// How many things it holds.
    count: usize,
    /// How often things stand in leaves, all together.
    held: usize,
    /// Things put in, taken out and moved since the tree was last looked at as a whole.
    changes: usize,
    /// What it cost when it was built, by [`KdTree::cost_now`].
    cost: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    holds: Holds,
}

#[derive(Clone, Copy, Debug)]
enum Holds {
    /// Two nodes that stand side by side: `low` below the plane where `axis` is `at`, `low + 1` above it.
    Halves {
        axis: u8,
        at: f32,
        low: u32,
        /// Was it split since the tree was last tidied?
        new: bool,
    },
    /// A leaf.
    Things(Run),
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

/// Nodes are not split further below this depth. Halves of about the same number need 30 for 10⁹ things.
const GREATEST_DEPTH: u32 = 48;

/// How often a thing may stand in leaves, in the mean.
const COPIES: usize = 4;

impl KdTree {
    /// Sorts things with the given boxes (numbered by their place in `bounds`; empty ones are left out) until a leaf
    /// holds at most `few`, or no plane parts what it holds.
    pub fn build(bounds: &[Aabb], few: usize) -> KdTree {
        KdTree::over(bounds.len(), &|thing| bounds[thing as usize], few)
    }

    /// As [`KdTree::build`], over the things below `count` that have a box.
    fn over(count: usize, boxes: &impl Fn(u32) -> Aabb, few: usize) -> KdTree {
        let members: Vec<u32> = (0..count as u32)
            .filter(|&thing| !boxes(thing).is_empty())
            .collect();
        let mut tree = KdTree {
            nodes: Vec::new(),
            things: Runs::default(),
            spare_pairs: Vec::new(),
            new: Vec::new(),
            few,
            count: members.len(),
            held: 0,
            changes: 0,
            cost: 0.0,
        };
        if members.is_empty() {
            return tree;
        }
        tree.nodes.push(Node::EMPTY);
        let root = Cell {
            node: 0,
            space: members
                .iter()
                .fold(Aabb::EMPTY, |sum, &thing| sum.union(&boxes(thing))),
            spare: (COPIES - 1) * members.len(),
            members,
            depth: 0,
        };
        tree.split(root, boxes, &mut Vec::new());
        tree.nodes.shrink_to_fit();
        tree.settled();
        tree.cost = tree.cost_now();
        tree
    }

    /// Sorts things into a leaf without things, and below it; `made` gets the new nodes, parents first.
    fn split(&mut self, cell: Cell, boxes: &impl Fn(u32) -> Aabb, made: &mut Vec<u32>) {
        // A stack, not recursion; both halves of a node are made together, so they stand side by side.
        let mut waiting = vec![cell];
        let mut ends = Ends::default();
        while let Some(cell) = waiting.pop() {
            self.settle(cell, boxes, &mut ends, &mut waiting, made);
        }
    }

    fn settle(
        &mut self,
        cell: Cell,
        boxes: &impl Fn(u32) -> Aabb,
        ends: &mut Ends,
        waiting: &mut Vec<Cell>,
        made: &mut Vec<u32>,
    ) {
        let Cell {
            node,
            space,
            members,
            depth,
            spare,
        } = cell;
        let held = members
            .iter()
            .fold(Aabb::EMPTY, |sum, &thing| sum.union(&boxes(thing)));
        let space = held.intersection(&space);
        self.nodes[node as usize].bounds = space;
        let split = if members.len() > self.few && depth < GREATEST_DEPTH && !space.is_empty() {
            best_split(&space, &members, boxes, ends).filter(|split| split.cuts <= spare)
        } else {
            None
        };
        let Some(Split { axis, at, cuts }) = split else {
            self.held += members.len();
            self.nodes[node as usize].holds = Holds::Things(self.things.put(&members));
            return;
        };
        let low = self.pair();
        self.new.push(node);
        made.extend([low, low + 1]);
        self.nodes[node as usize].holds = Holds::Halves {
            axis: axis as u8,
            at,
            low,
            new: true,
        };
        let [below, above] = cut(&space, axis, at);
        let in_half = |half: usize| -> Vec<u32> {
            let side = |&thing: &u32| sides(&boxes(thing), axis, at)[half];
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
        (self.count > 0).then_some(0)
    }

    /// The box of a node.
    pub fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// The two halves of a node, the one on the side of `eye` first; `None` for a leaf.
    pub fn near_and_far(&self, node: u32, eye: [f64; 3]) -> Option<[u32; 2]> {
        match self.nodes[node as usize].holds {
            Holds::Halves { axis, at, low, .. } if eye[usize::from(axis)] > f64::from(at) => {
                Some([low + 1, low])
            }
            Holds::Halves { low, .. } => Some([low, low + 1]),
            Holds::Things(_) => None,
        }
    }

    /// The things that stand in a leaf; none in a node that has halves.
    pub fn things(&self, node: u32) -> &[u32] {
        match self.nodes[node as usize].holds {
            Holds::Halves { .. } => &[],
            Holds::Things(run) => self.things.get(run),
        }
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes)
            + self.things.bytes()
            + size_of_val(&*self.spare_pairs)
            + size_of_val(&*self.new)) as u64
    }

    /// At most how many bytes a tree over so many things takes: a leaf holds something, and there are fewer other nodes
    /// than leaves.
    pub fn most_bytes(things: usize) -> u64 {
        (things * COPIES * (2 * size_of::<Node>() + size_of::<u32>())) as u64
    }

    /// Room for two nodes side by side.
    fn pair(&mut self) -> u32 {
        self.spare_pairs.pop().unwrap_or_else(|| {
            self.nodes.extend([Node::EMPTY; 2]);
            self.nodes.len() as u32 - 2
        })
    }

    /// From now on all things stand where their boxes are.
    fn settled(&mut self) {
        for node in std::mem::take(&mut self.new) {
            if let Holds::Halves { new, .. } = &mut self.nodes[node as usize].holds {
                *new = false;
            }
        }
    }

    /// The areas of all boxes, each as often as something is asked when it is entered, in parts of the whole's.
    fn cost_now(&self) -> f64 {
        let mut waiting: Vec<u32> = self.root().into_iter().collect();
        let mut cost = 0.0;
        while let Some(node) = waiting.pop() {
            let asked = match self.nodes[node as usize].holds {
                Holds::Halves { low, .. } => {
                    waiting.extend([low, low + 1]);
                    2
                }
                Holds::Things(run) => run.len(),
            };
            cost += self.bounds(node).half_area() * asked as f64;
        }
        cost / self.root().map_or(1.0, |root| self.bounds(root).half_area())
    }
}

impl Node {
    const EMPTY: Node = Node {
        bounds: Aabb::EMPTY,
        holds: Holds::Things(Run::EMPTY),
    };
}

/// Does a thing reach below the plane, and above it? What only touches the plane is not cut; what lies in it belongs
/// below.
fn sides(thing: &Aabb, axis: usize, at: f32) -> [bool; 2] {
    let [below, above] = [thing.min[axis] < at, thing.max[axis] > at];
    [below || !above, above]
}

/// The two halves of a cell.
fn cut(cell: &Aabb, axis: usize, at: f32) -> [Aabb; 2] {
    let [mut below, mut above] = [*cell; 2];
    below.max[axis] = at;
    above.min[axis] = at;
    [below, above]
}
