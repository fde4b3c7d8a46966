//! BSP tree: polygons sorted by the planes of some of them, so that from any eye one knows what cannot hide what.
//!
//! A piece is a polygon as it was born and the planes that cut it, no polygon of its own: drawn from the born edges,
//! neighbours share bits, and the two sides of a cut part the samples between them.
//! Source: Fuchs, Kedem, Naylor. On Visible Surface Generation by A Priori Tree Structures. SIGGRAPH 1980; thesis
//!     "Painter's algorithm and binary space partitioning", 2.3 (how splitters are chosen).
//! Cost: building see `build.rs`; a walk O(pieces), less what `visit` leaves out.
//! Every polygon is in the tree whole; what is nearer than rounding to a plane counts as in it.

mod build;
mod choose;
mod link;
mod parts;
mod score;
mod side;
mod split;
mod sweep;
#[cfg(test)]
mod tests;
mod upright;

pub use link::BspLink;

use crate::geom::Aabb;
use glam::DVec3;
use link::Below;
use split::Cut;
use std::num::NonZeroU32;

/// How splitters are chosen: of all candidates, the lowest balance · |front − back| + splits · (polygons cut) +
/// coplanar · (polygons in the plane) wins.
///
/// Source: thesis "Painter's algorithm and binary space partitioning", 2.3.4: 1, 8, −1, with every polygon a
/// candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BspOptions {
    /// What one polygon more on one side than on the other costs; 0 or more.
    pub balance: f32,
    /// What a polygon that is cut costs; 0 or more.
    pub splits: f32,
    /// What another polygon in the plane costs; below 0 it is welcome.
    pub coplanar: f32,
    /// How much more a cut costs where the plane is no polygon's but free, across an axis or upright on an edge, for
    /// it takes no polygon away; infinite: there are no free planes.
    pub free_splits: f32,
    /// Polygons of a node whose planes are scored. `u32::MAX`: every one, on every one.
    pub candidates: u32,
    /// Memory of the tree at which nothing is split any more; see [`BspTree::is_complete`].
    pub limit_bytes: u64,
}

impl Default for BspOptions {
    fn default() -> BspOptions {
        BspOptions {
            balance: 1.0,
            splits: 8.0,
            coplanar: -1.0,
            free_splits: 2.0,
            candidates: 32,
            limit_bytes: 1_000_000_000,
        }
    }
}

/// Flat convex polygons of three or more corners, finite, in either orientation. Some may have no area.
#[derive(Clone, Debug, Default)]
pub struct Polygons {
    /// The corners of one polygon after the other, in scene units.
    pub corners: Vec<[f64; 3]>,
    /// Where each polygon's corners begin, and the end of the last.
    pub starts: Vec<u32>,
}

/// Nodes with a plane, what is in front of it and behind; leaves hold pieces of one plane.
#[derive(Clone, Debug, Default)]
pub struct BspTree {
    root: BspLink,
    nodes: Vec<Node>,
    /// Of each node: normal and offset.
    planes: Vec<[f64; 4]>,
    bounds: Vec<Aabb>,
    pieces: Vec<Piece>,
    cuts: Vec<Cut>,
    splits: u64,
    depth: u32,
    incomplete: bool,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// What is behind, in the plane, in front.
    links: [BspLink; 3],
    /// One more than the place in `bounds`.
    bounds: Option<NonZeroU32>,
}

/// Part of a polygon: all of it that its cuts leave; see [`BspTree::cuts`].
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Which polygon.
    pub polygon: u32,
    first_cut: u32,
    /// Twice the number of cuts, and one more for the last of a run.
    cuts_and_last: u32,
}

/// What a walk meets.
#[derive(Clone, Copy, Debug)]
pub enum BspStep<'a> {
    /// A box around all that is met next, up to the end of a subtree. False: nothing of that is wanted. Small subtrees
    /// have none.
    Node(&'a Aabb),
    /// Pieces in one plane, by polygon number; the answer is ignored. Among them may be some that are too thin to be
    /// seen, wherever they lie.
    Coplanar(&'a [Piece]),
}

impl BspTree {
    /// More would not fit into the links.
    const GREATEST: u64 = (1 << 30) * size_of::<Piece>() as u64;

    /// Sorts polygons, numbered by their place, into a tree. The same input gives the same tree.
    pub fn build(polygons: &Polygons, options: &BspOptions) -> BspTree {
        build::build(polygons, options)
    }

    /// Meets all pieces as seen from `eye`: near ones first, or else far ones first. Whatever is met later cannot
    /// hide, or else cannot be hidden by, what was met before; pieces met at once are in one plane.
    ///
    /// `stack` is memory only; what is in it is dropped.
    pub fn walk(
        &self,
        eye: [f64; 3],
        near_first: bool,
        stack: &mut Vec<BspLink>,
        visit: &mut impl FnMut(BspStep) -> bool,
    ) {
        let eye = DVec3::from(eye);
        stack.clear();
        stack.push(self.root);
        while let Some(link) = stack.pop() {
            match link.below() {
                Below::Nothing => {}
                Below::Pieces(first) => {
                    visit(BspStep::Coplanar(self.run(first)));
                }
                Below::Node(number) => {
                    let node = &self.nodes[number as usize];
                    if let Some(bounds) = node.bounds
                        && !visit(BspStep::Node(&self.bounds[bounds.get() as usize - 1]))
                    {
                        continue;
                    }
                    // Where rounding may turn the sign, no ray from the eye crosses the plane: any order is right.
                    let [a, b, c, offset] = self.planes[number as usize];
                    let in_front = DVec3::new(a, b, c).dot(eye) > offset;
                    let [behind, own, before] = node.links;
                    if in_front == near_first {
                        stack.extend([behind, own, before]);
                    } else {
                        stack.extend([before, own, behind]);
                    }
                }
            }
        }
    }

    /// The planes (a, b, c, d) that cut a piece out of its polygon: it is where a·x + b·y + c·z ≥ d for each of them.
    /// The other part has the same plane with all signs turned.
    pub fn cuts(&self, piece: &Piece) -> impl ExactSizeIterator<Item = [f64; 4]> {
        let first = piece.first_cut as usize;
        let cuts = &self.cuts[first..first + (piece.cuts_and_last / 2) as usize];
        cuts.iter().map(|cut| {
            let plane = self.planes[cut.node() as usize];
            if cut.back() {
                plane.map(|value| -value)
            } else {
                plane
            }
        })
    }

    /// How many pieces there are.
    pub fn pieces(&self) -> u64 {
        self.pieces.len() as u64
    }

    /// How often a piece was cut in two.
    pub fn splits(&self) -> u64 {
        self.splits
    }

    /// Nodes and leaves on the longest way down.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Was everything sorted? If not, memory ran out: some pieces that are met at once are not in one plane.
    pub fn is_complete(&self) -> bool {
        !self.incomplete
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes)
            + size_of_val(&*self.planes)
            + size_of_val(&*self.bounds)
            + size_of_val(&*self.pieces)
            + size_of_val(&*self.cuts)) as u64
    }

    /// All pieces up to the last of a run.
    fn run(&self, first: u32) -> &[Piece] {
        let rest = &self.pieces[first as usize..];
        let last = rest.iter().position(|piece| piece.cuts_and_last % 2 == 1);
        &rest[..last.map_or(rest.len(), |last| last + 1)]
    }

    fn shrink(&mut self) {
        self.nodes.shrink_to_fit();
        self.planes.shrink_to_fit();
        self.bounds.shrink_to_fit();
        self.pieces.shrink_to_fit();
        self.cuts.shrink_to_fit();
    }
}

impl Piece {
    fn new(polygon: u32, first_cut: u32, cuts: u32, last: bool) -> Piece {
        Piece {
            polygon,
            first_cut,
            cuts_and_last: 2 * cuts + u32::from(last),
        }
    }
}
