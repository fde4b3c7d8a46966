//! BSP tree over polygons: gives an exact front-to-back or back-to-front order for any eye position.
//!
//! A piece is an input polygon plus the planes that cut it, not a new polygon. It is rasterized from the uncut edges,
//! so that neighbours share the same edges bit for bit, and the two sides of a cut split the samples between them
//! without gap or overlap.
//! Source: Fuchs, Kedem, Naylor. On Visible Surface Generation by A Priori Tree Structures. SIGGRAPH 1980; thesis
//!     "Painter's algorithm and binary space partitioning", 2.3 (choice of splitters).
//! Cost: for building see `build.rs`; a traversal takes O(pieces), less the subtrees that `visit` skips.
//! The pieces of a polygon cover it completely. Points within the rounding error of a plane count as on it.

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
use link::LinkTarget;
use split::Cut;
use std::num::NonZeroU32;

/// Weights and limits for choosing splitting planes. The candidate with the lowest score wins: balance · |front − back|
/// + splits · (polygons cut) + coplanar · (polygons in the plane).
///
/// The source uses 1, 8 and −1, with the plane of every polygon as a candidate.
/// Source: thesis "Painter's algorithm and binary space partitioning", 2.3.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BspOptions {
    /// Weight of the difference in number between front and back; at least 0.
    pub balance: f32,
    /// Weight of each polygon that the plane cuts; at least 0.
    pub splits: f32,
    /// Weight of each further polygon in the plane; negative values favour planes with many coplanar polygons.
    pub coplanar: f32,
    /// Factor on `splits` for free planes (axis-aligned, or perpendicular to a polygon along an edge), which remove no
    /// polygon from the node. Infinite disables free planes.
    pub free_splits: f32,
    /// Number of polygons per node whose planes are scored. `u32::MAX` scores the plane of every polygon against every
    /// polygon.
    pub candidates: u32,
    /// Size of the tree in bytes from which on nothing is split any more; see [`BspTree::is_complete`].
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

/// Input polygons: planar, convex, finite, at least three corners each, in either orientation. Polygons without area
/// are allowed.
#[derive(Clone, Debug, Default)]
pub struct Polygons {
    /// Corners of all polygons one after the other, in scene units.
    pub corners: Vec<[f64; 3]>,
    /// Index of each polygon's first corner, then the total number of corners.
    pub starts: Vec<u32>,
}

/// BSP tree: inner nodes with a splitting plane and a subtree on either side; leaves with pieces in one plane.
#[derive(Clone, Debug, Default)]
pub struct BspTree {
    root: BspLink,
    nodes: Vec<Node>,
    /// Normal and offset, by node.
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
    /// Links to the subtree behind, the coplanar list, and the subtree in front.
    links: [BspLink; 3],
    /// Index in `bounds` plus one.
    bounds: Option<NonZeroU32>,
}

/// The part of a polygon that its cuts leave; see [`BspTree::cuts`].
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Index of the input polygon.
    pub polygon: u32,
    first_cut: u32,
    /// Twice the number of cuts, plus one for the last piece of a run.
    cuts_and_last: u32,
}

/// One step of [`BspTree::walk`].
#[derive(Clone, Copy, Debug)]
pub enum BspStep<'a> {
    /// AABB of a subtree that is about to be traversed; return `false` to skip the subtree. Small subtrees have no AABB
    /// and are not announced.
    Node(&'a Aabb),
    /// Coplanar pieces, sorted by polygon number; the returned value is ignored. Polygons too thin to be visible may be
    /// among them although they are not in the plane.
    Coplanar(&'a [Piece]),
}

impl BspTree {
    /// Maximum bytes of all pieces: higher piece numbers would not fit into a [`BspLink`].
    const MAX_PIECE_BYTES: u64 = (1 << 30) * size_of::<Piece>() as u64;

    /// Builds a tree over polygons, which are numbered by their index. Deterministic: equal input gives an equal tree.
    ///
    /// Takes O(n log n) for typical input, more if many polygons are cut; for memory see [`BspOptions::limit_bytes`].
    pub fn build(polygons: &Polygons, options: &BspOptions) -> BspTree {
        build::build(polygons, options)
    }

    /// Visits all pieces, front to back from `eye` if `near_first`, else back to front. Front to back, no later piece
    /// occludes an earlier one; back to front, no later piece is occluded by an earlier one. The pieces of one step are
    /// coplanar.
    ///
    /// `stack` is scratch memory; its content is discarded.
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
            match link.target() {
                LinkTarget::Nothing => {}
                LinkTarget::Pieces(first) => {
                    visit(BspStep::Coplanar(self.run(first)));
                }
                LinkTarget::Node(number) => {
                    let node = &self.nodes[number as usize];
                    if let Some(bounds) = node.bounds
                        && !visit(BspStep::Node(&self.bounds[bounds.get() as usize - 1]))
                    {
                        continue;
                    }
                    // Where rounding may turn the sign, no ray from the eye crosses the plane, and either order is
                    // right.
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

    /// Returns the planes (a, b, c, d) that bound a piece within its polygon: the piece is where a·x + b·y + c·z ≥ d
    /// for each of them. The piece on the other side of a cut has the same plane with all signs reversed.
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

    /// Returns the number of pieces.
    pub fn pieces(&self) -> u64 {
        self.pieces.len() as u64
    }

    /// Returns the number of times a polygon or piece was cut in two.
    pub fn splits(&self) -> u64 {
        self.splits
    }

    /// Returns the depth: nodes and leaves on the longest path from the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Returns `true` if every polygon was sorted. If `false`, the memory limit was reached and the pieces of some
    /// steps are not coplanar.
    pub fn is_complete(&self) -> bool {
        !self.incomplete
    }

    /// Returns the memory in use, in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.nodes)
            + size_of_val(&*self.planes)
            + size_of_val(&*self.bounds)
            + size_of_val(&*self.pieces)
            + size_of_val(&*self.cuts)) as u64
    }

    /// Returns the run of pieces that starts at `first`.
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
