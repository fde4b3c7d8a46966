//! Tests a box by its faces: the front faces are filtered down the tree and split by its planes.
//!
//! If all of them are in shadow, the box is hidden. As soon as a piece reaches a lit leaf, the box is visible and the
//! traversal stops.

use super::insert::clip;
use super::line::SLIT;
use super::pieces::{Piece, Reach};
use super::{Link, OcclusionTree, Plane};
use crate::view::region::Volume;
use glam::DVec3;

/// Relative error of a triple product of coordinates, as a part of the product of the largest ones: some hundred units
/// in the last place.
const ROUNDING: f64 = 1.0 / (1_u64 << 46) as f64;

/// The faces of a box, and which of them are front faces.
struct Faces {
    /// Four corners of each face, in order around it.
    corners: [[DVec3; 4]; 6],
    /// Whether the face may be a front face; `false` only for certain back faces.
    front: [bool; 6],
}

impl<A> OcclusionTree<A> {
    /// Returns `true` if any part of the box's front faces may be visible; `true` when unsure.
    pub(super) fn is_any_face_visible(&mut self, volume: &Volume) -> bool {
        let Some(faces) = Faces::of(volume) else {
            return true;
        };
        self.pieces.clear();
        let shown = faces.corners.iter().zip(faces.front).filter(|face| face.1);
        shown
            .into_iter()
            .any(|(corners, _)| self.is_face_visible(*corners))
    }

    /// Returns `true` if any part of a face reaches a lit leaf.
    fn is_face_visible(&mut self, corners: [DVec3; 4]) -> bool {
        let whole = self.pieces.add(corners);
        let Some(inside) = clip(&self.tree.aperture, &mut self.pieces, whole) else {
            return false;
        };
        self.pending.clear();
        self.pending.push((self.tree.root, inside));
        while let Some((link, piece)) = self.pending.pop() {
            match link {
                Link::Lit => return true,
                Link::Shadow => {}
                Link::Node(node) => self.pass_face(node, piece),
            }
        }
        false
    }

    /// Splits a piece of a face by a node's plane and pushes the halves.
    fn pass_face(&mut self, node: u32, piece: Piece) {
        let node = &self.tree.nodes[node as usize];
        match &node.plane {
            Plane::Line(line) => {
                let mut reach = self.pieces.measure(piece, SLIT, |corner| line.height(corner));
                let mut halves = [piece; 2];
                if reach.inside && reach.outside {
                    halves = self.pieces.split(piece);
                } else if !reach.inside && !reach.outside {
                    // Edge-on or tiny: the exact side counts, however small the distance.
                    let Reach { inside, outside } =
                        self.pieces.measure(piece, 0.0, |corner| line.height(corner));
                    reach = Reach {
                        inside: inside || !outside,
                        outside: outside || !inside,
                    };
                }
                self.pending
                    .extend(reach.inside.then_some((node.inside, halves[0])));
                self.pending
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
                    self.pending.push((node.outside, before));
                }
            }
        }
    }
}

impl Faces {
    /// As [`Faces::of`] in a parallel view: front faces are those on the side of the viewer, where reversed depth grows.
    fn parallel(volume: &Volume) -> Faces {
        let all = volume.corners();
        let mut corners = [[DVec3::ZERO; 4]; 6];
        let mut front = [false; 6];
        for axis in 0..3 {
            let [along, up] = [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
            let [a, b, across] = [(axis + 1) % 3, (axis + 2) % 3, axis].map(|side| volume.sides[side]);
            let normal = a.cross(b);
            let size = |v: DVec3| v.abs().element_sum();
            let off = ROUNDING * size(a) * size(b);
            // Of the far corner's face, relative to the near one's, along the normal.
            let lead = normal.dot(across) * normal.z;
            let unsure = normal.z.abs() <= off || normal.dot(across).abs() <= off * size(across);
            for (face, lead) in [-lead, lead].into_iter().enumerate() {
                let corner = face << axis;
                corners[2 * axis + face] =
                    [corner, corner | along, corner | along | up, corner | up].map(|at| all[at]);
                front[2 * axis + face] = unsure || lead > 0.0;
            }
        }
        Faces { corners, front }
    }

    /// Computes the faces of a box; `None` if the eye may be inside.
    fn of(volume: &Volume) -> Option<Faces> {
        if volume.is_parallel {
            // A box in the space of an item may reach farther than the item.
            return volume.is_in_depth_range().then(|| Faces::parallel(volume));
        }
        let Volume { origin, sides, .. } = volume;
        let mut corners = [[DVec3::ZERO; 4]; 6];
        let mut front = [false; 6];
        let mut is_outside = false;
        let size = |v: DVec3| v.x.abs() + v.y.abs() + v.z.abs();
        for axis in 0..3 {
            let [along, up, across] = [sides[(axis + 1) % 3], sides[(axis + 2) % 3], sides[axis]];
            let normal = along.cross(up);
            let off = ROUNDING * size(along) * size(up) * (size(*origin) + size(across));
            let heights = [normal.dot(*origin), normal.dot(*origin + across)];
            // The eye has height 0: it is outside if both faces are certainly on one side of it, and then the nearer
            // face is the front one. Faces that are edge-on within rounding are tested too. In a flat box, for example
            // of a flattened item, both faces are in one plane, side by side or partly overlapping, so neither of them
            // is nearer.
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
