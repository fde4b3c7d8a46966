//! Octree over AABBs, traversed front to back.
//!
//! A primitive descends by its centre until its size is comparable to the cell's, so it is in one node only (a loose
//! octree). A node's AABB grows to its content and may overlap its neighbours'. Compared with listing a primitive in
//! every leaf it touches, looks test about half as many boxes, building takes half the time, and a move changes few
//! nodes.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity (splitting and order of children); Greene,
//!     Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1 (primitives in inner nodes).
//! Cost: building O(n log n); a traversal visits only the subtrees that `visit` enters.
//! A node's AABB contains every primitive of its subtree, so culling a hidden node culls only hidden primitives.

mod movable;
mod stored;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use crate::geom::runs::{FreeList, Run, Runs};
use smallvec::SmallVec;
pub(crate) use stored::StoredNode;

/// Octree over indexed AABBs, stored in two flat arrays.
///
/// A primitive ("thing") is an index into the array of AABBs that the tree was built over.
#[derive(Clone, Debug)]
pub(crate) struct Octree {
    nodes: Vec<Node>,
    things: Runs,
    /// Free nodes.
    spare: FreeList,
    /// Cell of the root: the AABB of all primitives when the tree was built.
    space: Aabb,
    few: usize,
    /// Number of primitives in the tree.
    count: usize,
    /// Insertions, removals and moves since the tree was built or last evaluated by [`Octree::tidy`].
    changes: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    center: [f32; 3],
    first_child: u32,
    /// Bit mask of the octants that have a child.
    children: u8,
    /// Number of nodes allocated for the children.
    room: u8,
    things: Run,
}

/// A node and its cell. The node's AABB may extend beyond the cell.
#[derive(Clone, Copy, Debug)]
struct NodeCell {
    node: u32,
    space: Aabb,
    depth: u32,
}

/// A node still to be split.
struct Cell {
    node_cell: NodeCell,
    members: Vec<u32>,
}

/// One step of a traversal.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// AABB of a node about to be entered; the return value decides whether its subtree is visited.
    Node(&'a Aabb),
    /// Number of a primitive, visited once. The returned value is ignored.
    Thing(u32),
}

/// Decision of `visit` about a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Enter {
    /// Skips the subtree.
    Skip,
    /// Enters the node and visits its children and primitives one by one.
    Ask,
    /// Accepts all primitives of the subtree without visiting its nodes.
    All,
}

/// Nodes that a traversal has still to visit, and whether all of their subtrees was accepted: at most seven siblings on
/// each level, so that it never allocates. Not an array, because to fill it takes longer than many a traversal.
type Pending = SmallVec<[(u32, bool); 256]>;

/// Maximum depth: 2⁻²⁰ of the scene's size is finer than f32 positions.
const MAX_DEPTH: u32 = 20;

impl Octree {
    /// Builds a tree over AABBs; a node is split while it has more than `few` primitives. Primitives are numbered by
    /// their index in `bounds`; empty AABBs are omitted. Takes O(n log n).
    pub(crate) fn build(bounds: &[Aabb], few: usize) -> Octree {
        Octree::over(bounds.len(), &|thing| bounds[thing as usize], few)
    }

    /// Like [`Octree::build`], over the primitives below `count` with a nonempty AABB.
    fn over(count: usize, boxes: &impl Fn(u32) -> Aabb, few: usize) -> Octree {
        let members: Vec<u32> = (0..count as u32)
            .filter(|&thing| !boxes(thing).is_empty())
            .collect();
        let mut tree = Octree {
            few,
            count: members.len(),
            ..Octree::default()
        };
        if members.is_empty() {
            return tree;
        }
        tree.space = members
            .iter()
            .fold(Aabb::EMPTY, |sum, &thing| sum.union(&boxes(thing)));
        tree.nodes.push(Node::new(&tree.space));
        let root = Cell {
            node_cell: tree.root_cell(),
            members,
        };
        let mut made = vec![0];
        tree.split(root, boxes, &mut made);
        // Children are made after their parents.
        for node in made.into_iter().rev() {
            tree.fit(node, boxes);
        }
        tree
    }

    /// Splits a childless node recursively and distributes the primitives; appends the new nodes to `made`, parents
    /// first.
    fn split(&mut self, cell: Cell, boxes: &impl Fn(u32) -> Aabb, made: &mut Vec<u32>) {
        const STAY: usize = 0;
        let Cell { node_cell, members } = cell;
        // Sorted together with what decides where they go: looking up boxes in another order costs more.
        let placed = |&thing: &u32| {
            let bounds = boxes(thing);
            (thing, bounds.center(), bounds.longest_side())
        };
        let mut all: Vec<(u32, [f32; 3], f32)> = members.iter().map(placed).collect();
        let (mut sorted, mut things) = (Vec::new(), Vec::new());
        // Octant of each primitive of a cell, or `STAY`.
        let mut octants: Vec<u8> = Vec::new();
        // A stack instead of recursion; the children of a node are made together, so they are adjacent.
        let mut pending = vec![(node_cell, 0..all.len())];
        while let Some((node_cell, range)) = pending.pop() {
            let members = &mut all[range.clone()];
            let few = members.len() <= self.few;
            let mut counts = [0; 9];
            octants.clear();
            octants.extend(members.iter().map(|&(_, middle, side)| {
                let octant = if few {
                    None
                } else {
                    self.octant(&node_cell, middle, side)
                };
                let octant = octant.map_or(STAY, |octant| octant + 1);
                counts[octant] += 1;
                octant as u8
            }));
            // A stable counting sort: first those that stay, then octant by octant.
            let mut next = [0; 9];
            for octant in 1..9 {
                next[octant] = next[octant - 1] + counts[octant - 1];
            }
            if counts[STAY] < members.len() {
                sorted.clear();
                sorted.extend_from_slice(members);
                for (&octant, &placed) in octants.iter().zip(&sorted) {
                    members[next[usize::from(octant)]] = placed;
                    next[usize::from(octant)] += 1;
                }
            }
            things.clear();
            things.extend(members[..counts[STAY]].iter().map(|placed| placed.0));
            self.nodes[node_cell.node as usize].things = self.things.put(&things);
            let count = counts[1..].iter().filter(|&&count| count > 0).count();
            if count == 0 {
                continue;
            }
            let (first, room) = self.block(count as u32);
            let mut start = range.start + counts[STAY];
            for (octant, &count) in counts[1..].iter().enumerate().filter(|&(_, &count)| count > 0) {
                let node = &mut self.nodes[node_cell.node as usize];
                let child = first + node.children.count_ones();
                node.first_child = first;
                node.room = room;
                node.children |= 1 << octant;
                let node_cell = NodeCell {
                    node: child,
                    space: eighth(&node_cell.space, node.center, octant),
                    depth: node_cell.depth + 1,
                };
                self.nodes[child as usize] = Node::new(&node_cell.space);
                made.push(child);
                pending.push((node_cell, start..start + count));
                start += count;
            }
        }
    }

    /// Returns the octant of a node that a box belongs to, whether or not that child exists. `None` if the box belongs
    /// to the node itself: if the cell is not twice as large as the box, if the node is at the maximum depth, or if the
    /// box is far outside the root cell, where it would enlarge the AABBs of many nodes.
    fn belongs(&self, node_cell: &NodeCell, thing: &Aabb) -> Option<usize> {
        self.octant(node_cell, thing.center(), thing.longest_side())
    }

    /// Like [`Octree::belongs`], for a box with this centre and longest side.
    #[inline]
    fn octant(&self, node_cell: &NodeCell, middle: [f32; 3], side: f32) -> Option<usize> {
        let outside = node_cell.depth == 0 && self.is_outside(middle);
        let large = side > 0.5 * node_cell.space.longest_side();
        let below = !outside && !large && node_cell.depth < MAX_DEPTH;
        below.then(|| octant_of(middle, self.nodes[node_cell.node as usize].center))
    }

    /// Returns `true` if a point is too far from the root cell to be assigned to the cells at its sides.
    fn is_outside(&self, point: [f32; 3]) -> bool {
        let margin = 0.125 * self.space.longest_side();
        (0..3).any(|axis| {
            point[axis] < self.space.min[axis] - margin || point[axis] > self.space.max[axis] + margin
        })
    }

    fn root_cell(&self) -> NodeCell {
        NodeCell {
            node: 0,
            space: self.space,
            depth: 0,
        }
    }

    /// Allocates `count` adjacent nodes; returns the first one and the capacity of the block.
    fn block(&mut self, count: u32) -> (u32, u8) {
        let room = count.next_power_of_two();
        if let Some(first) = self.spare.take(room) {
            return (first, room as u8);
        }
        let first = self.nodes.len() as u32;
        self.nodes
            .resize((first + count) as usize, Node::new(&Aabb::EMPTY));
        (first, count as u8)
    }

    /// Refits a node's AABB to its primitives and children, which may extend beyond its cell.
    fn fit(&mut self, node: u32, boxes: &impl Fn(u32) -> Aabb) {
        let own = self.things(node).iter().map(|&thing| boxes(thing));
        let below = self.children(node).map(|child| *self.bounds(child));
        self.nodes[node as usize].bounds = own.chain(below).fold(Aabb::EMPTY, |sum, b| sum.union(&b));
    }

    /// Replaces the primitive list of every node: `renumber` gets the old numbers and writes the new ones.
    pub(crate) fn renumber(&mut self, mut renumber: impl FnMut(&[u32], &mut Vec<u32>)) {
        let mut things = Runs::default();
        let mut numbers = Vec::new();
        for node in &mut self.nodes {
            numbers.clear();
            renumber(self.things.get(node.things), &mut numbers);
            node.things = things.put(&numbers);
        }
        self.things = things;
    }

    /// Visits nodes and primitives front to back from `eye`, skipping the subtree of every node for which `visit`
    /// returns `false`.
    ///
    /// With i the octant of the eye, children come in the order i, i^1, i^2, i^4, i^3, i^5, i^6, i^7.
    pub(crate) fn walk(&self, eye: [f64; 3], mut visit: impl FnMut(Step) -> bool) {
        self.walk_by(eye, |step, _| if visit(step) { Enter::Ask } else { Enter::Skip });
    }

    /// Like [`Octree::walk`], but `visit` may also accept a subtree as a whole ([`Enter::All`]): none of its nodes is
    /// visited, and `visit` gets `true` with each of its primitives.
    pub(crate) fn walk_by(&self, eye: [f64; 3], mut visit: impl FnMut(Step, bool) -> Enter) {
        let mut pending = Pending::new();
        pending.extend(self.root().map(|root| (root, false)));
        while let Some((node, mut all)) = pending.pop() {
            let node = &self.nodes[node as usize];
            if !all {
                match visit(Step::Node(&node.bounds), false) {
                    Enter::Skip => continue,
                    Enter::Ask => {}
                    Enter::All => all = true,
                }
            }
            for &thing in self.things.get(node.things) {
                visit(Step::Thing(thing), all);
            }
            if node.children != 0 {
                push_children(node, eye, all, &mut pending);
            }
        }
    }

    /// Visits primitives in no order, and says of each whether it is in a node that `enter` accepted as a whole
    /// ([`Enter::All`]); none of the nodes in such a node is asked for.
    pub(crate) fn search(&self, enter: impl Fn(&Aabb) -> Enter, mut visit: impl FnMut(u32, bool)) {
        let enter = |node: u32, all: bool| match all {
            true => Some((node, true)),
            false => match enter(&self.nodes[node as usize].bounds) {
                Enter::Skip => None,
                decision => Some((node, decision == Enter::All)),
            },
        };
        let mut pending = Pending::new();
        pending.extend(self.root().and_then(|root| enter(root, false)));
        while let Some((node, all)) = pending.pop() {
            for &thing in self.things(node) {
                visit(thing, all);
            }
            pending.extend(self.children(node).filter_map(|child| enter(child, all)));
        }
    }

    /// Returns the root node; `None` if the tree is empty.
    pub(crate) fn root(&self) -> Option<u32> {
        (self.count > 0).then_some(0)
    }

    /// Returns the size of the node array, free nodes included; all node numbers are lower. In a newly built tree
    /// children have higher numbers than their parents; after changes they need not.
    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the AABB of a node.
    pub(crate) fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// Returns the primitives of a node itself, without those of its children.
    pub(crate) fn things(&self, node: u32) -> &[u32] {
        self.things.get(self.nodes[node as usize].things)
    }

    /// Returns the children of a node.
    pub(crate) fn children(&self, node: u32) -> std::ops::Range<u32> {
        let Node {
            first_child,
            children,
            ..
        } = self.nodes[node as usize];
        first_child..first_child + children.count_ones()
    }

    /// Returns the memory in use, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        (self.nodes.len() * size_of::<Node>() + self.things.bytes() + self.spare.bytes()) as u64
    }
}

/// Pushes the children of a node, the nearest last. Apart from [`Octree::walk_by`], which is compiled for each visitor.
fn push_children(node: &Node, eye: [f64; 3], all: bool, pending: &mut Pending) {
    const FRONT_TO_BACK: [usize; 8] = [0, 1, 2, 4, 3, 5, 6, 7];
    let octant: usize = (0..3)
        .map(|axis| usize::from(eye[axis] > f64::from(node.center[axis])) << axis)
        .sum();
    // Without branches, which would be hard to predict: an octant without a child is overwritten by the next.
    let mut next = node.first_child;
    let by_octant: [u32; 8] = std::array::from_fn(|child| {
        let this = next;
        next += u32::from(node.children >> child & 1);
        this
    });
    let mut children = [(0, all); 8];
    let mut count = 0;
    for step in FRONT_TO_BACK.into_iter().rev() {
        let child = octant ^ step;
        children[count].0 = by_octant[child];
        count += usize::from(node.children >> child & 1);
    }
    pending.extend_from_slice(&children[..count]);
}

impl Default for Octree {
    fn default() -> Octree {
        Octree {
            nodes: Vec::new(),
            things: Runs::default(),
            spare: FreeList::default(),
            space: Aabb::EMPTY,
            few: 0,
            count: 0,
            changes: 0,
        }
    }
}

impl Node {
    fn new(space: &Aabb) -> Node {
        Node {
            bounds: Aabb::EMPTY,
            center: space.center(),
            first_child: 0,
            children: 0,
            room: 0,
            things: Run::EMPTY,
        }
    }
}

/// Returns the octant of a cell that contains a point; a point on a middle plane belongs below it.
fn octant_of(point: [f32; 3], center: [f32; 3]) -> usize {
    (0..3)
        .map(|axis| usize::from(point[axis] > center[axis]) << axis)
        .sum()
}

fn eighth(cell: &Aabb, center: [f32; 3], octant: usize) -> Aabb {
    let upper = |axis: usize| octant >> axis & 1 == 1;
    Aabb {
        min: std::array::from_fn(|axis| if upper(axis) { center[axis] } else { cell.min[axis] }),
        max: std::array::from_fn(|axis| if upper(axis) { cell.max[axis] } else { center[axis] }),
    }
}
