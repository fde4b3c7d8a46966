//! Face lists, from which meshes are built.

mod fill;
mod loft;
mod solid;

pub(crate) use fill::fill;
pub(crate) use loft::{around, ball, knot, lathe};
pub(crate) use solid::{block, cuboid, prism, taper};

use enfilade::{Attributes, ConvexPolygon, Indices, MaterialId, Mesh, Part, Vertices};
use glam::Vec3;
use std::collections::HashMap;
use std::sync::Arc;

/// Faces grouped by material. Polygons that are not flat and convex are split into triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    sheets: Vec<Sheet>,
}

/// The faces of one material; corners are merged when the mesh is built.
#[derive(Clone, Debug)]
struct Sheet {
    material: MaterialId,
    corners: Vec<Vec3>,
    sides: Vec<u32>,
}

impl Shape {
    pub(crate) fn new() -> Shape {
        Shape::default()
    }

    /// Adds a face, counter-clockwise as seen from its front. Faces beyond the flatness tolerance are split into
    /// triangles.
    pub(crate) fn face(&mut self, material: MaterialId, corners: &[Vec3]) {
        let count = corners.len();
        let corners: Vec<Vec3> = (0..count)
            .filter(|&i| corners[i] != corners[(i + 1) % count])
            .map(|i| corners[i])
            .collect();
        if corners.len() < 3 {
            return;
        }
        let outline: Vec<[f32; 3]> = corners.iter().map(Vec3::to_array).collect();
        if corners.len() == 3 || ConvexPolygon::new(&outline).is_ok() {
            self.push(material, &corners);
        } else {
            for i in 1..corners.len() - 1 {
                self.triangle(material, [corners[0], corners[i], corners[i + 1]]);
            }
        }
    }

    /// Adds a triangle, unless two of its corners are equal.
    pub(crate) fn triangle(&mut self, material: MaterialId, [a, b, c]: [Vec3; 3]) {
        if a != b && b != c && c != a {
            self.push(material, &[a, b, c]);
        }
    }

    /// Adds all faces of `other`.
    pub(crate) fn join(&mut self, other: Shape) -> &mut Shape {
        for (material, face) in other.faces() {
            self.push(material, face);
        }
        self
    }

    /// Returns the faces with each corner moved by `bend`; those that are no longer flat become triangles.
    pub(crate) fn bent(self, bend: impl Fn(Vec3) -> Vec3) -> Shape {
        let mut shape = Shape::new();
        for (material, face) in self.faces() {
            let moved: Vec<Vec3> = face.iter().map(|&corner| bend(corner)).collect();
            shape.face(material, &moved);
        }
        shape
    }

    /// Returns the faces with reversed winding.
    pub(crate) fn flipped(self) -> Shape {
        let mut shape = Shape::new();
        for (material, face) in self.faces() {
            let reversed: Vec<Vec3> = face.iter().rev().copied().collect();
            shape.push(material, &reversed);
        }
        shape
    }

    /// Builds the mesh of all faces; corners at the same position are merged.
    pub(crate) fn mesh(&self) -> Arc<Mesh> {
        let welded: Vec<(Vec<[f32; 3]>, Vec<u32>)> =
            self.sheets.iter().map(|sheet| weld(&sheet.corners)).collect();
        let parts: Vec<Part> = (self.sheets.iter().zip(&welded))
            .map(|(sheet, (positions, corners))| Part {
                positions: Vertices::Packed(positions),
                corners: Indices::U32(corners),
                sides: (sheet.sides.iter().any(|&sides| sides != 3)).then_some(&*sheet.sides),
                material: sheet.material,
                attributes: Attributes::default(),
            })
            .collect();
        Arc::new(Mesh::new(&parts).expect("faces are validated when they are added"))
    }

    fn faces(&self) -> impl Iterator<Item = (MaterialId, &[Vec3])> {
        self.sheets.iter().flat_map(|sheet| {
            let mut rest = &*sheet.corners;
            sheet.sides.iter().map(move |&sides| {
                let (face, after) = rest.split_at(sides as usize);
                rest = after;
                (sheet.material, face)
            })
        })
    }

    fn push(&mut self, material: MaterialId, face: &[Vec3]) {
        let found = self.sheets.iter().position(|sheet| sheet.material == material);
        let index = found.unwrap_or_else(|| {
            self.sheets.push(Sheet {
                material,
                corners: Vec::new(),
                sides: Vec::new(),
            });
            self.sheets.len() - 1
        });
        let sheet = &mut self.sheets[index];
        // Adding zero turns −0 into 0, so that corners at the same position have the same bits.
        sheet
            .corners
            .extend(face.iter().map(|&corner| corner + Vec3::ZERO));
        sheet.sides.push(face.len() as u32);
    }
}

/// Returns the distinct positions, and for each corner the index of its position.
fn weld(corners: &[Vec3]) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions = Vec::new();
    let mut numbers = HashMap::new();
    let indices = corners
        .iter()
        .map(|corner| {
            *numbers
                .entry(corner.to_array().map(f32::to_bits))
                .or_insert_with(|| {
                    positions.push(corner.to_array());
                    positions.len() as u32 - 1
                })
        })
        .collect();
    (positions, indices)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    const STONE: MaterialId = MaterialId(0);

    /// Returns the enclosed volume; negative if the faces look inwards.
    fn volume(shape: &Shape) -> f32 {
        let mut sum = 0.0;
        for (_, face) in shape.faces() {
            for i in 1..face.len() - 1 {
                sum += face[0].dot(face[i].cross(face[i + 1]));
            }
        }
        sum / 6.0
    }

    /// Returns `true` if every edge has an opposite edge.
    fn is_closed(shape: &Shape) -> bool {
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        for (_, face) in shape.faces() {
            for i in 0..face.len() {
                let [a, b] = [face[i], face[(i + 1) % face.len()]].map(|c| c.to_array().map(f32::to_bits));
                *edges.entry([a, b]).or_default() += 1;
                *edges.entry([b, a]).or_default() -= 1;
            }
        }
        edges.values().all(|&excess| excess == 0)
    }

    #[test]
    fn solids_are_closed_and_look_outwards() {
        for (name, solid) in [
            ("block", block(STONE, [-1.0; 3], [1.0, 2.0, 3.0])),
            ("taper", taper(STONE, [1.0, 2.0], 3.0, [0.5, 0.25])),
            ("prism", prism(STONE, &[Vec3::ZERO, Vec3::Z, Vec3::X], Vec3::Y)),
            (
                "lathe",
                lathe(STONE, &[[0.0, 0.0], [1.0, 0.0], [0.5, 2.0], [0.0, 3.0]], 12),
            ),
            ("ball", ball(STONE, 1.0, 6, 9)),
            ("knot", knot(STONE, 2, 3, 1.0, 0.4, 0.1, 40, 6)),
        ] {
            assert!(is_closed(&solid), "{name} is not closed");
            assert!(volume(&solid) > 0.0, "{name} is inside out");
        }
    }

    #[test]
    fn corners_at_one_place_become_one() {
        assert_eq!(block(STONE, [0.0; 3], [1.0; 3]).mesh().positions().len(), 8);
    }
}
