//! How an occluder gets into the tree.
//!
//! It is cut by the planes it meets; what comes to a lit leaf stands there from then on: a node for each edge that
//! bounds the occluder there, one for its own plane, and a shadow behind that.

use super::above::Above;
use super::line::{Back, Line, SLIT};
use super::pieces::{Piece, Pieces, Reach};
use super::{Edge, Link, Location, MAX_NODES, OcclusionTree, Plane, Side, Tree};
use crate::occluders::Occluder;
use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;

/// How much nearer than what an occluder lies behind it must be, relatively: nothing is worth a shadow before one in
/// the same wall.
const NEARER: f64 = 1.0 / (1 << 20) as f64;

/// How far inside its lines the middle of a piece must be for an edge to be left out, as a part of the piece's size.
///
/// Say the lines that are left let something out of the occluder, at q. The way there from the middle leaves the
/// occluder at some edge, still in the leaf. If that edge was not left out, its line stops q: so it was, and at that
/// place it is within `SLIT` of a line above. That line, which the middle is inside of by this part of the size, has
/// lost all but `SLIT` on the way: so q is farther by no more than `SLIT` over this part.
const THICK: f64 = 1.0 / (1 << 10) as f64;

/// What is entered before this plane, n · p ≥ d, does not hide.
pub(super) type Entry = (DVec3, f64);

impl<A> OcclusionTree<A> {
    /// Lets what of an occluder is beyond `near` and the entry plane hide what is behind it.
    ///
    /// `rounding` is how far corners may be from where they were meant.
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
        while let Some((place, piece)) = next.take().or_else(|| self.entering.pop()) {
            match self.tree.at(place) {
                Link::Shadow => {}
                Link::Lit => {
                    if self.tree.nodes.len() + self.edges.len() < MAX_NODES {
                        let corners = self.pieces.corners(piece);
                        let (tree, edges) = (&mut self.tree, &self.edges);
                        dispatch!(self.level, simd => settle(simd, tree, edges, back, place, corners));
                    }
                }
                Link::Node(node) => next = self.pass(node, piece),
            }
        }
    }

    /// The occluder's edges, and its outline, beyond `near` and the entry plane; `None` where it hides nothing.
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
            // Nothing would bound what is behind it.
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

    /// Sends a piece past a node: where what of it is to go on with comes to. What else there is waits.
    #[inline]
    fn pass(&mut self, node: u32, piece: Piece) -> Option<(Location, Piece)> {
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
                    // Too thin to hide anything.
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

/// What of a piece is within the aperture; `None` where nothing is.
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

/// Puts the occluder's planes where its piece came to a lit leaf.
// No closures here: what runs in one does not run at the SIMD level.
#[inline(always)]
fn settle<S: Simd>(simd: S, tree: &mut Tree, edges: &[Edge], back: Back, place: Location, piece: &[DVec3]) {
    if piece.len() < 3 {
        return;
    }
    tree.gather_above(place);
    let thick = is_thick(simd, &tree.above, edges, piece);
    let mut below = place;
    for edge in edges {
        let above = &tree.above;
        if above.contains(simd, &edge.line) || (thick && above.leave_nothing_of(simd, edge)) {
            continue;
        }
        let node = tree.hang(below, Plane::Line(edge.line), Link::Lit);
        below = Some((node, Side::Inside));
    }
    tree.hang(below, Plane::Back(back), Link::Shadow);
}

/// Is the middle of a piece well inside of all that bounds it?
#[inline(always)]
fn is_thick<S: Simd>(simd: S, above: &Above, edges: &[Edge], piece: &[DVec3]) -> bool {
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
    is_inside && above.hold(simd, middle, least)
}
