//! kd-tree over AABBs: axis-aligned splitting planes, traversed front to back.
//!
//! A plane is at the boundary of a primitive's AABB near the middle of the node's longest side, where it cuts the
//! fewest primitives. A primitive that is cut is listed on both sides; each node's AABB is shrunk to its content.
//! Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998, section 4.
//! Cost: building O(n log² n); memory O(n), because leaves list at most four references per primitive on average.
//! The AABBs of the leaves that list a primitive together contain all of it, so culling hidden leaves culls only hidden
//! parts.

mod movable;
mod plane;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use crate::geom::runs::{Run, Runs};
use plane::{Ends, Split, best_split};

/// kd-tree over indexed AABBs, stored in two flat arrays.
///
/// A primitive ("thing") is an index into the array of AABBs that the tree was built over.
#[derive(Clone, Debug)]
pub(crate) struct KdTree {
    nodes: Vec<Node>,
    things: Runs,
    /// First nodes of free pairs.
    free_pairs: Vec<u32>,
    /// Nodes split since the last [`KdTree::tidy`]; some may have been reused since.
    new: Vec<u32>,
    few: usize,
    /// Number of primitives in the tree.
    count: usize,
    /// Total number of references to primitives in all leaves.
    held: usize,
    /// Insertions, removals and moves since the last [`KdTree::tidy`] that evaluated the whole tree.
    changes: usize,
    /// Cost when it was built; see [`KdTree::cost_now`].
    cost: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    contents: Contents,
}

#[derive(Clone, Copy, Debug)]
enum Contents {
    /// Inner node with two adjacent children: `low` below the plane where coordinate `axis` equals `at`, `low + 1`
    /// above it.
    Halves {
        axis: u8,
        at: f32,
        low: u32,
        /// Whether the node was split since the last [`KdTree::tidy`].
        new: bool,
    },
    /// Leaf with its primitives.
    Things(Run),
}

/// A leaf still to be split.
struct Cell {
    node: u32,
    space: Aabb,
    members: Vec<u32>,
    depth: u32,
    /// Number of copies of primitives that splitting may still make in it.
    spare: usize,
}

/// Maximum depth. Halves of about equal count need 30 levels for 10⁹ primitives.
const MAX_DEPTH: u32 = 48;

/// Maximum average number of leaves that list a primitive.
const COPIES: usize = 4;

impl KdTree {
    /// Builds a tree over AABBs. A leaf is split until it has at most `few` primitives or no plane separates them.
    /// Primitives are numbered by their index in `bounds`; empty AABBs are omitted. Takes O(n log² n).
    pub(crate) fn build(bounds: &[Aabb], few: usize) -> KdTree {
        KdTree::over(bounds.len(), &|thing| bounds[thing as usize], few)
    }

    /// Like [`KdTree::build`], over the primitives below `count` with a nonempty AABB.
    fn over(count: usize, boxes: &impl Fn(u32) -> Aabb, few: usize) -> KdTree {
        let members: Vec<u32> = (0..count as u32)
            .filter(|&thing| !boxes(thing).is_empty())
            .collect();
        let mut tree = KdTree {
            nodes: Vec::new(),
            things: Runs::default(),
            free_pairs: Vec::new(),
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
        tree.mark_settled();
        tree.cost = tree.cost_now();
        tree
    }

    /// Splits an empty leaf recursively and distributes the primitives; appends the new nodes to `made`, parents first.
    fn split(&mut self, cell: Cell, boxes: &impl Fn(u32) -> Aabb, made: &mut Vec<u32>) {
        // A stack instead of recursion; both children are made together, so they are adjacent.
        let mut pending = vec![cell];
        let mut ends = Ends::default();
        while let Some(cell) = pending.pop() {
            self.split_one(cell, boxes, &mut ends, &mut pending, made);
        }
    }

    fn split_one(
        &mut self,
        cell: Cell,
        boxes: &impl Fn(u32) -> Aabb,
        ends: &mut Ends,
        pending: &mut Vec<Cell>,
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
        let split = if members.len() > self.few && depth < MAX_DEPTH && !space.is_empty() {
            best_split(&space, &members, boxes, ends).filter(|split| split.cuts <= spare)
        } else {
            None
        };
        let Some(Split { axis, at, cuts }) = split else {
            self.held += members.len();
            self.nodes[node as usize].contents = Contents::Things(self.things.put(&members));
            return;
        };
        let low = self.pair();
        self.new.push(node);
        made.extend([low, low + 1]);
        self.nodes[node as usize].contents = Contents::Halves {
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
        // The remaining copies are divided in proportion to the number of primitives, so that a crowded corner cannot
        // use up all of them.
        let halves = [in_half(0), in_half(1)];
        let left = spare - cuts;
        let all = halves[0].len() + halves[1].len();
        let mut shares = [left * halves[0].len() / all; 2];
        shares[1] = left - shares[0];
        for (half, ((members, space), spare)) in
            halves.into_iter().zip([below, above]).zip(shares).enumerate()
        {
            pending.push(Cell {
                node: low + half as u32,
                space,
                members,
                depth: depth + 1,
                spare,
            });
        }
    }

    /// Returns the root node; `None` if the tree is empty.
    pub(crate) fn root(&self) -> Option<u32> {
        (self.count > 0).then_some(0)
    }

    /// Returns the AABB of a node.
    pub(crate) fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// Returns the two children of a node, the one on the side of `eye` first; `None` for a leaf.
    pub(crate) fn near_and_far(&self, node: u32, eye: [f64; 3]) -> Option<[u32; 2]> {
        match self.nodes[node as usize].contents {
            Contents::Halves { axis, at, low, .. } if eye[usize::from(axis)] > f64::from(at) => {
                Some([low + 1, low])
            }
            Contents::Halves { low, .. } => Some([low, low + 1]),
            Contents::Things(_) => None,
        }
    }

    /// Returns the primitives of a leaf; empty for an inner node.
    pub(crate) fn things(&self, node: u32) -> &[u32] {
        match self.nodes[node as usize].contents {
            Contents::Halves { .. } => &[],
            Contents::Things(run) => self.things.get(run),
        }
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes)
            + self.things.bytes()
            + size_of_val(&*self.free_pairs)
            + size_of_val(&*self.new)) as u64
    }

    /// Returns the maximum number of bytes of a tree over `things` primitives: no leaf is empty, and there are fewer
    /// inner nodes than leaves.
    pub(crate) fn max_bytes(things: usize) -> u64 {
        (things * COPIES * (2 * size_of::<Node>() + size_of::<u32>())) as u64
    }

    /// Allocates two adjacent nodes.
    fn pair(&mut self) -> u32 {
        self.free_pairs.pop().unwrap_or_else(|| {
            self.nodes.extend([Node::EMPTY; 2]);
            self.nodes.len() as u32 - 2
        })
    }

    /// Records that every primitive is now in the leaves that its current AABB reaches.
    fn mark_settled(&mut self) {
        for node in std::mem::take(&mut self.new) {
            if let Contents::Halves { new, .. } = &mut self.nodes[node as usize].contents {
                *new = false;
            }
        }
    }

    /// Returns the SAH cost: the sum of box areas weighted by the number of children and primitives, relative to the
    /// root's area.
    fn cost_now(&self) -> f64 {
        let mut pending: Vec<u32> = self.root().into_iter().collect();
        let mut cost = 0.0;
        while let Some(node) = pending.pop() {
            let asked = match self.nodes[node as usize].contents {
                Contents::Halves { low, .. } => {
                    pending.extend([low, low + 1]);
                    2
                }
                Contents::Things(run) => run.len(),
            };
            cost += self.bounds(node).half_area() * asked as f64;
        }
        cost / self.root().map_or(1.0, |root| self.bounds(root).half_area())
    }
}

impl Node {
    const EMPTY: Node = Node {
        bounds: Aabb::EMPTY,
        contents: Contents::Things(Run::EMPTY),
    };
}

/// Returns whether a primitive is listed below and above the plane. A box that only touches the plane is not cut; a box
/// in the plane goes below.
fn sides(thing: &Aabb, axis: usize, at: f32) -> [bool; 2] {
    let [below, above] = [thing.min[axis] < at, thing.max[axis] > at];
    [below || !above, above]
}

/// Splits a cell at a plane into the lower and the upper half.
fn cut(cell: &Aabb, axis: usize, at: f32) -> [Aabb; 2] {
    let [mut below, mut above] = [*cell; 2];
    below.max[axis] = at;
    above.min[axis] = at;
    [below, above]
}
