//! Octree: boxes sorted into nested eighths of space, walked front to back.
//!
//! A thing goes down by its middle until it is about as large as its cell, so it stands in one node; boxes grow to hold
//! what is in them, and those of neighbours may overlap.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity (split and order of children);
//!     Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1 (things in inner nodes).
//! Cost: building O(n log n); a walk touches only what `visit` lets it enter.
//! A node's box holds all of what stands in it and below it, so a hidden node hides only hidden things.

mod movable;
#[cfg(test)]
mod tests;

use crate::geom::Aabb;
use crate::geom::runs::{Run, Runs, Spare};

/// A tree over numbered boxes, stored as two flat arrays.
#[derive(Clone, Debug)]
pub struct Octree {
    nodes: Vec<Node>,
    things: Runs,
    /// Nodes that nothing is in.
    spare: Spare,
    /// The cell of the root: what was held when the tree was built.
    space: Aabb,
    few: usize,
    /// How many things it holds.
    count: usize,
    /// Things put in, taken out and moved since the tree was built or found to be good.
    changes: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    center: [f32; 3],
    first_child: u32,
    /// Which eighths there are nodes for.
    children: u8,
    /// How many nodes there is room for where the children stand.
    room: u8,
    things: Run,
}

/// A node and its cell, which boxes may reach out of.
#[derive(Clone, Copy, Debug)]
struct Place {
    node: u32,
    space: Aabb,
    depth: u32,
}

/// One node that is still to be split.
struct Cell {
    place: Place,
    members: Vec<u32>,
}

/// What a walk meets.
#[derive(Clone, Copy, Debug)]
pub enum Step<'a> {
    /// A node; what `visit` answers decides whether anything below it is met.
    Node(&'a Aabb),
    /// A thing, by its number; it is met once. The answer is ignored.
    Thing(u32),
}

/// What a walk does about a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enter {
    /// Nothing in it is met.
    Skip,
    /// What is in it is met, and asked after.
    Ask,
    /// All things in it are wanted.
    All,
}

/// Nodes are not split further below this depth: 2⁻²⁰ of the scene is finer than f32 positions are.
const GREATEST_DEPTH: u32 = 20;

impl Octree {
    /// Sorts things with the given boxes (numbered by their place in `bounds`; empty ones are left out) until a
    /// node holds at most `few`.
    pub fn build(bounds: &[Aabb], few: usize) -> Octree {
        Octree::over(bounds.len(), &|thing| bounds[thing as usize], few)
    }

    /// As [`Octree::build`], over the things below `count` that have a box.
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
            place: tree.root_place(),
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

    /// Sorts things into a node without children and below it; `made` gets the new nodes, parents first.
    fn split(&mut self, cell: Cell, boxes: &impl Fn(u32) -> Aabb, made: &mut Vec<u32>) {
        // A stack, not recursion; the children of a node are made together, so they stand side by side.
        let mut waiting = vec![cell];
        while let Some(Cell { place, members }) = waiting.pop() {
            let few = members.len() <= self.few;
            let mut stay = Vec::new();
            let mut go: [Vec<u32>; 8] = Default::default();
            for thing in members {
                match self.belongs(&place, &boxes(thing)) {
                    Some(octant) if !few => go[octant].push(thing),
                    _ => stay.push(thing),
                }
            }
            self.nodes[place.node as usize].things = self.things.put(&stay);
            let count = go.iter().filter(|members| !members.is_empty()).count();
            if count == 0 {
                continue;
            }
            let (first, room) = self.block(count as u32);
            for (octant, members) in go.into_iter().enumerate() {
                if members.is_empty() {
                    continue;
                }
                let node = &mut self.nodes[place.node as usize];
                let child = first + node.children.count_ones();
                node.first_child = first;
                node.room = room;
                node.children |= 1 << octant;
                let place = Place {
                    node: child,
                    space: eighth(&place.space, node.center, octant),
                    depth: place.depth + 1,
                };
                self.nodes[child as usize] = Node::new(&place.space);
                made.push(child);
                waiting.push(Cell { place, members });
            }
        }
    }

    /// The eighth of a node that a box belongs into, if there were nodes for all; `None` where it belongs into the node
    /// itself: the cell is not twice as large, or the last, or the box is far outside, and would make the boxes of many
    /// nodes large.
    fn belongs(&self, place: &Place, thing: &Aabb) -> Option<usize> {
        let middle = thing.center();
        let outside = place.depth == 0 && self.is_outside(middle);
        let large = thing.longest_side() > 0.5 * place.space.longest_side();
        let below = !outside && !large && place.depth < GREATEST_DEPTH;
        below.then(|| octant_of(middle, self.nodes[place.node as usize].center))
    }

    /// Is a point so far from where things were when the tree was built that the cells at its sides are not for it?
    fn is_outside(&self, point: [f32; 3]) -> bool {
        let margin = 0.125 * self.space.longest_side();
        (0..3).any(|axis| {
            point[axis] < self.space.min[axis] - margin || point[axis] > self.space.max[axis] + margin
        })
    }

    fn root_place(&self) -> Place {
        Place {
            node: 0,
            space: self.space,
            depth: 0,
        }
    }

    /// Room for so many nodes side by side: the first, and for how many there is room.
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

    /// Things may reach out of their cell: boxes are those of what they hold.
    fn fit(&mut self, node: u32, boxes: &impl Fn(u32) -> Aabb) {
        let own = self.things(node).iter().map(|&thing| boxes(thing));
        let below = self.children(node).map(|child| *self.bounds(child));
        self.nodes[node as usize].bounds = own.chain(below).fold(Aabb::EMPTY, |sum, b| sum.union(&b));
    }

    /// Gives every node's run of things a new meaning: `renumber` gets the old numbers, writes the new ones.
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

    /// Meets nodes and things from near to far as seen from `eye`, skipping every node for which `visit` says no.
    ///
    /// With i the octant of the eye, children come in the order i, i^1, i^2, i^4, i^3, i^5, i^6, i^7.
    pub fn walk(&self, eye: [f64; 3], mut visit: impl FnMut(Step) -> bool) {
        self.walk_by(eye, |step, _| if visit(step) { Enter::Ask } else { Enter::Skip });
    }

    /// As [`Octree::walk`], but of what is in a node of which all is wanted no node is met, and `visit` is told so with
    /// each thing.
    pub fn walk_by(&self, eye: [f64; 3], mut visit: impl FnMut(Step, bool) -> Enter) {
        const FRONT_TO_BACK: [usize; 8] = [0, 1, 2, 4, 3, 5, 6, 7];
        // At most seven siblings wait on each of the levels above.
        let mut waiting = [(0_u32, false); 7 * GREATEST_DEPTH as usize + 8];
        let mut count = usize::from(self.root().is_some());
        while count > 0 {
            count -= 1;
            let (node, mut all) = waiting[count];
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
            let octant: usize = (0..3)
                .map(|axis| usize::from(eye[axis] > f64::from(node.center[axis])) << axis)
                .sum();
            for step in FRONT_TO_BACK.into_iter().rev() {
                let child = octant ^ step;
                if node.children >> child & 1 == 1 {
                    let before = (node.children & ((1_u16 << child) - 1) as u8).count_ones();
                    waiting[count] = (node.first_child + before, all);
                    count += 1;
                }
            }
        }
    }

    /// The number of the root; `None` where the tree holds nothing.
    pub fn root(&self) -> Option<u32> {
        (self.count > 0).then_some(0)
    }

    /// All nodes have lower numbers, those that nothing is in any more included. In a tree just built children have
    /// higher numbers than their parents; in one that was changed they need not.
    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The box of a node.
    pub fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// The things that stand in a node itself.
    pub fn things(&self, node: u32) -> &[u32] {
        self.things.get(self.nodes[node as usize].things)
    }

    /// The numbers of a node's children.
    pub fn children(&self, node: u32) -> std::ops::Range<u32> {
        let Node {
            first_child,
            children,
            ..
        } = self.nodes[node as usize];
        first_child..first_child + children.count_ones()
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (self.nodes.len() * size_of::<Node>() + self.things.bytes() + self.spare.bytes()) as u64
    }
}

impl Default for Octree {
    fn default() -> Octree {
        Octree {
            nodes: Vec::new(),
            things: Runs::default(),
            spare: Spare::default(),
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

/// The eighth of a cell that a point belongs into; what lies on a middle plane belongs below it.
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
