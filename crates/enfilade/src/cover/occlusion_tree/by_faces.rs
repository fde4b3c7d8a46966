//! How a box is asked after by its faces: those it shows to the eye are filtered down the tree, cut by its planes.
//!
//! All of them in shadow: the box is hidden. What comes to one lit leaf is seen, and the rest is not asked after.

use super::insert::clip;
use super::line::SLIT;
use super::pieces::{Piece, Reach};
use super::{Link, OcclusionTree, Plane};
use crate::region::Volume;
use glam::DVec3;

/// What a number computed from three products of coordinates may be wrong by, as a part of the product of the greatest:
/// some hundred units in the last place.
const ROUNDING: f64 = 1.0 / (1_u64 << 46) as f64;

/// Which faces of a box the eye sees.
struct Faces {
    /// Four corners each, around the face.
    corners: [[DVec3; 4]; 6],
    /// May the face look toward the eye? The others certainly do not.
    front: [bool; 6],
}

impl<A> OcclusionTree<A> {
    /// Is anything seen of the faces that a box shows to the eye? Yes when unsure.
    pub(super) fn sees_faces(&mut self, volume: &Volume) -> bool {
        let Some(faces) = Faces::of(volume) else {
            return true;
        };
        self.pieces.clear();
        let shown = faces.corners.iter().zip(faces.front).filter(|face| face.1);
        shown.into_iter().any(|(corners, _)| self.sees_face(*corners))
    }

    /// Does anything of a face come to a lit leaf?
    fn sees_face(&mut self, corners: [DVec3; 4]) -> bool {
        let whole = self.pieces.add(corners);
        let Some(inside) = clip(&self.tree.aperture, &mut self.pieces, whole) else {
            return false;
        };
        self.waiting.clear();
        self.waiting.push((self.tree.root, inside));
        while let Some((link, piece)) = self.waiting.pop() {
            match link {
                Link::Lit => return true,
                Link::Shadow => {}
                Link::Node(node) => self.pass_face(node, piece),
            }
        }
        false
    }

    /// Sends a piece of a face past a node.
    fn pass_face(&mut self, node: u32, piece: Piece) {
        let node = &self.tree.nodes[node as usize];
        match &node.plane {
            Plane::Line(line) => {
                let mut reach = self.pieces.measure(piece, SLIT, |corner| line.height(corner));
                let mut halves = [piece; 2];
                if reach.inside && reach.outside {
                    halves = self.pieces.split(piece);
                } else if !reach.inside && !reach.outside {
                    // Seen edge-on, or tiny: where it lies counts, be it ever so little off.
                    let Reach { inside, outside } =
                        self.pieces.measure(piece, 0.0, |corner| line.height(corner));
                    reach = Reach {
                        inside: inside || !outside,
                        outside: outside || !inside,
                    };
                }
                self.waiting
                    .extend(reach.inside.then_some((node.inside, halves[0])));
                self.waiting
                    .extend(reach.outside.then_some((node.outside, halves[1])));
            }
            Plane::Back(back) => {
                let reach = self.pieces.measure(piece, 0.0, |corner| back.height(corner));
                if reach.outside {
                    let before = if reach.inside {
                        self.pieces.half(piece, -1.0)
                    } else {
                        piece
                    };
                    self.waiting.push((node.outside, before));
                }
            }
        }
    }
}

impl Faces {
    /// `None` where the eye may be inside.
    fn of(volume: &Volume) -> Option<Faces> {
        let Volume { origin, sides } = volume;
        let mut corners = [[DVec3::ZERO; 4]; 6];
        let mut front = [false; 6];
        let mut is_outside = false;
        let size = |v: DVec3| v.x.abs() + v.y.abs() + v.z.abs();
        for axis in 0..3 {
            let [along, up, across] = [sides[(axis + 1) % 3], sides[(axis + 2) % 3], sides[axis]];
            let normal = along.cross(up);
            let off = ROUNDING * size(along) * size(up) * (size(*origin) + size(across));
            let heights = [normal.dot(*origin), normal.dot(*origin + across)];
            // The eye has height 0: outside if both faces are certainly on one side of it, and then the nearer is
            // seen. What is edge-on, as far as one can say, is asked after too. Of a box that is flat, as of a thing that
            // was flattened, both lie in one plane, side by side or one partly over the other: neither is the nearer.
            let beyond = heights.iter().all(|&h| h > off) || heights.iter().all(|&h| h < -off);
            is_outside |= beyond;
            let lead = heights[1].abs() - heights[0].abs();
            for (face, lead) in [lead, -lead].into_iter().enumerate() {
                let corner = if face == 0 { *origin } else { *origin + across };
                corners[2 * axis + face] = [corner, corner + along, corner + along + up, corner + up];
                front[2 * axis + face] = (beyond && lead >= -2.0 * off) || heights[face].abs() <= off;
            }
        }
        is_outside.then_some(Faces { corners, front })
    }
}
