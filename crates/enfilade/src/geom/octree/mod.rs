//! Octree: boxes sorted into nested eighths of space, walked front to back.
//!
//! A thing goes down by its middle until it is about as large as its cell, so it stands in one node; boxes grow to hold
//! what is in them, and those of neighbours may overlap.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity (split and order of children);
//!     Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, section 3.1 (things in inner nodes).
//! Cost: building O(n log n); a walk touches only what `visit` lets it enter.
//! A node's box holds all of what stands in it and below it, so a hidden node hides only hidden things.

#[cfg(test)]
mod tests;

use crate::geom::Aabb;

/// A tree over numbered boxes, stored as two flat arrays.
#[derive(Clone, Debug, Default)]
pub struct Octree {
    nodes: Vec<Node>,
    things: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb,
    center: [f32; 3],
    first_child: u32,
    children: u8,
    things: [u32; 2],
}

/// One node that is still to be split.
struct Cell {
    node: u32,
    space: Aabb,
    members: Vec<u32>,
    depth: u32,
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
        let whole = bounds
            .iter()
            .filter(|b| !b.is_empty())
            .fold(Aabb::EMPTY, |sum, b| sum.union(b));
        let all: Vec<u32> = (0..bounds.len() as u32)
            .filter(|&i| !bounds[i as usize].is_empty())
            .collect();
        let mut tree = Octree::default();
        if all.is_empty() {
            return tree;
        }
        tree.nodes.push(Node::new(whole));
        // A stack, not recursion; the children of a node are made together, so they stand side by side.
        let mut waiting = vec![Cell {
            node: 0,
            space: whole,
            members: all,
            depth: 0,
        }];
        while let Some(cell) = waiting.pop() {
            tree.split(cell, few, bounds, &mut waiting);
        }
        tree.fit(bounds);
        tree
    }

    fn split(&mut self, cell: Cell, few: usize, bounds: &[Aabb], waiting: &mut Vec<Cell>) {
        let Cell {
            node,
            space,
            members,
            depth,
        } = cell;
        let center = space.center();
        self.nodes[node as usize].center = center;
        let leaf = members.len() <= few || depth == GREATEST_DEPTH;
        let half = 0.5 * space.longest_side();
        let (stay, go): (Vec<u32>, Vec<u32>) = members
            .into_iter()
            .partition(|&i| leaf || bounds[i as usize].longest_side() > half);
        self.nodes[node as usize].things =
            [self.things.len() as u32, (self.things.len() + stay.len()) as u32];
        self.things.extend(stay);
        if go.is_empty() {
            return;
        }
        let mut children: [Vec<u32>; 8] = Default::default();
        for i in go {
            children[octant_of(bounds[i as usize].center(), center)].push(i);
        }
        self.nodes[node as usize].first_child = self.nodes.len() as u32;
        for (octant, members) in children.into_iter().enumerate() {
            if members.is_empty() {
                continue;
            }
            self.nodes[node as usize].children |= 1 << octant;
            let space = eighth(&space, center, octant);
            waiting.push(Cell {
                node: self.nodes.len() as u32,
                space,
                members,
                depth: depth + 1,
            });
            self.nodes.push(Node::new(space));
        }
    }

    /// Things may reach out of their cell: boxes are those of what they hold.
    fn fit(&mut self, bounds: &[Aabb]) {
        for node in (0..self.nodes.len()).rev() {
            let Node {
                first_child,
                children,
                things,
                ..
            } = self.nodes[node];
            let own = self.things[things[0] as usize..things[1] as usize]
                .iter()
                .map(|&i| bounds[i as usize]);
            let below =
                (first_child..first_child + children.count_ones()).map(|c| self.nodes[c as usize].bounds);
            self.nodes[node].bounds = own.chain(below).fold(Aabb::EMPTY, |sum, b| sum.union(&b));
        }
    }

    /// Gives every node's run of things a new meaning: `renumber` gets the old numbers, writes the new ones.
    pub(crate) fn renumber(&mut self, mut renumber: impl FnMut(&[u32], &mut Vec<u32>)) {
        let mut things = Vec::new();
        for node in &mut self.nodes {
            let start = things.len() as u32;
            renumber(
                &self.things[node.things[0] as usize..node.things[1] as usize],
                &mut things,
            );
            node.things = [start, things.len() as u32];
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
        let mut count = usize::from(!self.nodes.is_empty());
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
            for &thing in &self.things[node.things[0] as usize..node.things[1] as usize] {
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
        (!self.nodes.is_empty()).then_some(0)
    }

    /// How many nodes there are; children have higher numbers than their parents.
    pub(crate) fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The box of a node.
    pub fn bounds(&self, node: u32) -> &Aabb {
        &self.nodes[node as usize].bounds
    }

    /// The things that stand in a node itself.
    pub fn things(&self, node: u32) -> &[u32] {
        let [start, end] = self.nodes[node as usize].things;
        &self.things[start as usize..end as usize]
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
        (self.nodes.len() * size_of::<Node>() + self.things.len() * size_of::<u32>()) as u64
    }
}

impl Node {
    fn new(bounds: Aabb) -> Node {
        Node {
            bounds,
            center: bounds.center(),
            first_child: 0,
            children: 0,
            things: [0, 0],
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
