//! Inserts an occluder into the tree.
//!
//! The occluder is split by the planes it crosses. Wherever a piece reaches a lit leaf, the leaf is replaced: by a node
//! for each edge that bounds the occluder there, then one for its own plane, with a shadow leaf behind it.

use super::above::LinesAbove;
use super::line::{Back, Line, SLIT};
use super::pieces::{Piece, Pieces, Reach};
use super::{Edge, Link, MAX_NODES, OcclusionTree, Plane, Side, Slot, Tree};
use crate::occluders::Occluder;
use crate::simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;

/// Relative distance by which a piece must be in front of an occluder already in the tree to be inserted there: a
/// shadow just in front of another one in the same wall is not worth its nodes.
const NEARER: f64 = 1.0 / (1 << 20) as f64;

/// Minimum distance of the centre of a piece inside its lines for an edge to be left out, as a part of the piece's size.
///
/// Assume that the remaining lines include a point q outside the occluder. The segment from the centre to q leaves the
/// occluder at some edge, still in the leaf. If that edge had a node, its line would exclude q; so it was left out, and
/// at that point it is within `SLIT` of an ancestor line. The centre is inside that line by this part of the size, and
/// all but `SLIT` of it is used up on the way: so q is farther by at most `SLIT` over this part.
const THICK: f64 = 1.0 / (1 << 10) as f64;

/// Entry plane behind the last portal: geometry at n · p < d does not occlude.
pub(super) type Entry = (DVec3, f64);

impl<A> OcclusionTree<A> {
    /// Inserts the part of an occluder beyond `near` and the entry plane.
    ///
    /// `rounding` is the maximum distance of the corners from their exact positions.
    pub(super) fn insert(&mut self, occluder: &Occluder, near: f64, entry: Option<Entry>, rounding: f64) {
        self.pieces.clear();
        self.edges.clear();
        self.tree.firsts.push(self.tree.nodes.len() as u32);
        let Some(back) = Back::new(occluder.plane, self.tree.far, rounding) else {
            return;
        };
        let Some(piece) = self.outline(occluder, near, entry) else {
            return;
        };
        let Some(piece) = clip(&self.tree.aperture, &mut self.pieces, piece) else {
            return;
        };
        let mut next = Some((None, piece));
        while let Some((slot, piece)) = next.take().or_else(|| self.entering.pop()) {
            match self.tree.link_at(slot) {
                Link::Shadow => {}
                Link::Lit => {
                    if self.tree.nodes.len() + self.edges.len() < MAX_NODES {
                        let corners = self.pieces.corners(piece);
                        let (tree, edges) = (&mut self.tree, &self.edges);
                        dispatch!(self.level, simd => insert_planes(simd, tree, edges, back, slot, corners));
                    }
                }
                Link::Node(node) => next = self.pass(node, piece),
            }
        }
    }

    /// Collects the occluder's edges and returns its outline, clipped by `near` and the entry plane; `None` if it hides
    /// nothing.
    fn outline(&mut self, occluder: &Occluder, near: f64, entry: Option<Entry>) -> Option<Piece> {
        let corners = occluder.corners;
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            if from != to {
                let line = Line::through(from, to)?;
                self.edges.push(Edge { from, to, line });
            }
        }
        if self.edges.len() < 3 {
            // Its shadow volume would be unbounded.
            return None;
        }
        let mut piece = self.pieces.add(corners.iter().copied());
        let before: [Option<Entry>; 2] = [Some((DVec3::Z, near)), entry];
        for (normal, distance) in before.into_iter().flatten() {
            let reach = self
                .pieces
                .measure(piece, 0.0, |corner| normal.dot(corner) - distance);
            if reach.outside {
                piece = self.pieces.half(piece, 1.0);
                let [from, to] = self.pieces.cut_edge(piece)?;
                let line = Line::through(from, to)?;
                self.edges.push(Edge { from, to, line });
            } else if !reach.inside {
                return None;
            }
        }
        Some(piece)
    }

    /// Splits a piece by a node's plane. Returns the slot and the piece to continue with, and pushes the other half if
    /// there is one.
    #[inline]
    fn pass(&mut self, node: u32, piece: Piece) -> Option<(Slot, Piece)> {
        let [inside, outside] = [Side::Inside, Side::Outside].map(|side| Some((node, side)));
        match &self.tree.nodes[node as usize].plane {
            Plane::Line(line) => {
                let reach = self.pieces.measure(piece, SLIT, |corner| line.height(corner));
                match reach {
                    Reach {
                        inside: true,
                        outside: true,
                    } => {
                        let halves = self.pieces.split(piece);
                        self.entering.push((inside, halves[0]));
                        Some((outside, halves[1]))
                    }
                    Reach { inside: true, .. } => Some((inside, piece)),
                    Reach { outside: true, .. } => Some((outside, piece)),
                    // Too thin to occlude.
                    _ => None,
                }
            }
            Plane::Back(back) => {
                let before = |corner| -back.height(corner) - NEARER * back.distance;
                let reach = self.pieces.measure(piece, 0.0, before);
                match reach {
                    Reach { inside: false, .. } => None,
                    Reach { outside: true, .. } => Some((outside, self.pieces.half(piece, 1.0))),
                    _ => Some((outside, piece)),
                }
            }
        }
    }
}

/// Clips a piece by the aperture; `None` if nothing is left.
pub(super) fn clip(aperture: &[Line], pieces: &mut Pieces, mut piece: Piece) -> Option<Piece> {
    for line in aperture {
        let reach = pieces.measure(piece, SLIT, |corner| line.height(corner));
        if reach.outside {
            if !reach.inside {
                return None;
            }
            piece = pieces.half(piece, 1.0);
        }
    }
    Some(piece)
}

/// Replaces a lit leaf that a piece of the occluder reached by nodes for the occluder's planes.
// No closures here: code in a closure is not compiled for the SIMD level.
#[inline(always)]
fn insert_planes<S: Simd>(simd: S, tree: &mut Tree, edges: &[Edge], back: Back, slot: Slot, piece: &[DVec3]) {
    if piece.len() < 3 {
        return;
    }
    tree.gather_bounds(slot);
    let thick = is_thick(simd, &tree.above, edges, piece);
    let mut below = slot;
    for edge in edges {
        let above = &tree.above;
        if above.contains(simd, &edge.line) || (thick && above.clip_away(simd, edge)) {
            continue;
        }
        let node = tree.attach(below, Plane::Line(edge.line), Link::Lit);
        below = Some((node, Side::Inside));
    }
    tree.attach(below, Plane::Back(back), Link::Shadow);
}

/// Returns `true` if the centre of a piece is well inside all lines that bound it.
#[inline(always)]
fn is_thick<S: Simd>(simd: S, above: &LinesAbove, edges: &[Edge], piece: &[DVec3]) -> bool {
    let [mut min, mut max] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    let mut middle = DVec3::ZERO;
    for corner in piece {
        let on_screen = *corner / corner.z;
        min = min.min(on_screen);
        max = max.max(on_screen);
        middle += on_screen;
    }
    middle /= piece.len() as f64;
    let size = max - min;
    let least = THICK * (size.x + size.y) + SLIT;
    let mut is_inside = size.x + size.y > 0.0;
    for edge in edges {
        is_inside &= edge.line.height(middle) >= least;
    }
    is_inside && above.contain_point(simd, middle, least)
}
