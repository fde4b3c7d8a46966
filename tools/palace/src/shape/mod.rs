//! Face lists, from which meshes are built.

mod clip;
mod dress;
#[path = "../../../../crates/enfilade_scenes/src/shape/fill.rs"]
mod fill;
mod loft;
#[path = "../../../../crates/enfilade_scenes/src/shape/solid.rs"]
mod solid;
mod superquadric;
mod sweep;

pub(crate) use clip::clip;
pub(crate) use dress::Dress;
pub(crate) use fill::fill;
pub(crate) use loft::{around, ball, band, cloth, fluted, knot, lathe, loft, round_tube, tube};
pub(crate) use solid::{block, cuboid, prism, taper};
pub(crate) use superquadric::superquadric;
pub(crate) use sweep::{frame, moulding, surround};

use enfilade::{ConvexPolygon, MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// Faces grouped by material. Polygons that are not flat and convex are split into triangles.
///
/// Every corner has texture coordinates in metres. Faces get them from their own shape and keep them when they are
/// moved later: see [`boxed`](dress::boxed).
#[derive(Clone, Debug, Default)]
pub(crate) struct Shape {
    sheets: Vec<Sheet>,
}

/// The faces of one material; corners are merged when the mesh is built.
#[derive(Clone, Debug)]
struct Sheet {
    material: MaterialId,
    corners: Vec<Vec3>,
    /// Texture coordinates of each corner, in metres.
    places: Vec<Vec2>,
    sides: Vec<u32>,
}

impl Shape {
    pub(crate) fn new() -> Shape {
        Shape::default()
    }

    /// Adds a face, counter-clockwise as seen from its front. Faces beyond the flatness tolerance are split into
    /// triangles.
    pub(crate) fn face(&mut self, material: MaterialId, corners: &[Vec3]) {
        self.placed(material, corners, &dress::boxed(corners));
    }

    /// As [`Shape::face`], with explicit texture coordinates for each corner.
    pub(crate) fn placed(&mut self, material: MaterialId, corners: &[Vec3], places: &[Vec2]) {
        let count = corners.len();
        let corners: Vec<(Vec3, Vec2)> = (0..count)
            .filter(|&i| corners[i] != corners[(i + 1) % count])
            .map(|i| (corners[i], places[i]))
            .collect();
        if corners.len() < 3 {
            return;
        }
        let flat = corners.len() == 3 || {
            let outline: Vec<[f32; 3]> = corners.iter().map(|(corner, _)| corner.to_array()).collect();
            ConvexPolygon::new(&outline).is_ok()
        };
        if flat {
            self.push(material, corners.iter().copied(), corners.len());
        } else {
            for i in 1..corners.len() - 1 {
                self.sharp(material, [corners[0], corners[i], corners[i + 1]]);
            }
        }
    }

    /// Adds a triangle, unless two of its corners are equal.
    pub(crate) fn triangle(&mut self, material: MaterialId, corners: [Vec3; 3]) {
        let places = dress::boxed(&corners);
        self.sharp(material, [0, 1, 2].map(|i| (corners[i], places[i])));
    }

    fn sharp(&mut self, material: MaterialId, corners: [(Vec3, Vec2); 3]) {
        let [a, b, c] = corners.map(|(corner, _)| corner);
        if a != b && b != c && c != a {
            self.push(material, corners.into_iter(), 3);
        }
    }

    /// Adds a copy of all faces of `other`, transformed by `placed`.
    pub(crate) fn add(&mut self, other: &Shape, placed: Transform) -> &mut Shape {
        let mirrors = placed.mirrors();
        for sheet in &other.sheets {
            let mut start = 0;
            for &sides in &sheet.sides {
                let face = sheet.face(start, sides);
                let moved = face
                    .clone()
                    .map(|(corner, place)| (Vec3::from(placed.point(corner.to_array())), place));
                if mirrors {
                    self.push(sheet.material, moved.rev(), face.len());
                } else {
                    self.push(sheet.material, moved, face.len());
                }
                start += sides as usize;
            }
        }
        self
    }

    /// Adds all faces of `other` untransformed.
    pub(crate) fn join(&mut self, other: Shape) -> &mut Shape {
        for sheet in other.sheets {
            let own = self.sheet(sheet.material);
            own.corners.extend(sheet.corners);
            own.places.extend(sheet.places);
            own.sides.extend(sheet.sides);
        }
        self
    }

    /// Returns the faces with each corner moved by `bend`; those that are no longer flat become triangles.
    pub(crate) fn bent(self, bend: impl Fn(Vec3) -> Vec3) -> Shape {
        let mut shape = Shape::new();
        for sheet in self.sheets {
            let mut start = 0;
            for sides in sheet.sides {
                let end = start + sides as usize;
                let moved: Vec<Vec3> = sheet.corners[start..end]
                    .iter()
                    .map(|&corner| bend(corner))
                    .collect();
                shape.placed(sheet.material, &moved, &sheet.places[start..end]);
                start = end;
            }
        }
        shape
    }

    /// Returns the faces with reversed winding.
    pub(crate) fn flipped(mut self) -> Shape {
        for sheet in &mut self.sheets {
            let mut start = 0;
            for &sides in &sheet.sides {
                let end = start + sides as usize;
                sheet.corners[start..end].reverse();
                sheet.places[start..end].reverse();
                start = end;
            }
        }
        self
    }

    /// Builds the mesh of all faces with the attributes that `dress` chooses for each material.
    pub(crate) fn dressed(&self, dress: impl Fn(MaterialId) -> Dress) -> Arc<Mesh> {
        dress::mesh(&self.sheets, dress)
    }

    fn sheet(&mut self, material: MaterialId) -> &mut Sheet {
        let index = self
            .sheets
            .iter()
            .position(|sheet| sheet.material == material)
            .unwrap_or_else(|| {
                self.sheets.push(Sheet {
                    material,
                    corners: Vec::new(),
                    places: Vec::new(),
                    sides: Vec::new(),
                });
                self.sheets.len() - 1
            });
        &mut self.sheets[index]
    }

    fn push(&mut self, material: MaterialId, corners: impl Iterator<Item = (Vec3, Vec2)>, sides: usize) {
        let sheet = self.sheet(material);
        for (corner, place) in corners {
            // Adding zero turns −0 into 0, so that corners at the same position have the same bits.
            sheet.corners.push(corner + Vec3::ZERO);
            sheet.places.push(place + Vec2::ZERO);
        }
        sheet.sides.push(sides as u32);
    }
}

impl Sheet {
    /// Returns the corners of the face that begins at `start`, with their texture coordinates.
    fn face(
        &self,
        start: usize,
        sides: u32,
    ) -> impl DoubleEndedIterator<Item = (Vec3, Vec2)> + ExactSizeIterator + Clone + '_ {
        (start..start + sides as usize).map(|i| (self.corners[i], self.places[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    const STONE: MaterialId = MaterialId(0);

    /// Returns the enclosed volume; negative if the faces look inwards.
    fn volume(shape: &Shape) -> f32 {
        let mut sum = 0.0;
        for sheet in &shape.sheets {
            let mut start = 0;
            for &sides in &sheet.sides {
                let face = &sheet.corners[start..start + sides as usize];
                for i in 1..face.len() - 1 {
                    sum += face[0].dot(face[i].cross(face[i + 1]));
                }
                start += sides as usize;
            }
        }
        sum / 6.0
    }

    /// Returns `true` if every edge has an opposite edge.
    fn is_closed(shape: &Shape) -> bool {
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        for sheet in &shape.sheets {
            let mut start = 0;
            for &sides in &sheet.sides {
                let face = &sheet.corners[start..start + sides as usize];
                for i in 0..face.len() {
                    let [a, b] =
                        [face[i], face[(i + 1) % face.len()]].map(|c| c.to_array().map(f32::to_bits));
                    *edges.entry([a, b]).or_default() += 1;
                    *edges.entry([b, a]).or_default() -= 1;
                }
                start += sides as usize;
            }
        }
        edges.values().all(|&excess| excess == 0)
    }

    #[test]
    fn solids_are_closed_and_look_outwards() {
        let path = [Vec3::ZERO, Vec3::new(0.3, 1.0, 0.0), Vec3::new(0.0, 2.0, 0.5)];
        for (name, solid) in [
            ("block", block(STONE, [-1.0; 3], [1.0, 2.0, 3.0])),
            ("taper", taper(STONE, [1.0, 2.0], 3.0, [0.5, 0.25])),
            ("prism", prism(STONE, &[Vec3::ZERO, Vec3::Z, Vec3::X], Vec3::Y)),
            (
                "lathe",
                lathe(STONE, &[[0.0, 0.0], [1.0, 0.0], [0.5, 2.0], [0.0, 3.0]], 12),
            ),
            (
                "fluted",
                fluted(
                    STONE,
                    &[[0.0, 0.0], [1.0, 0.0], [0.8, 2.0], [0.0, 2.0]],
                    12,
                    4,
                    0.1,
                ),
            ),
            ("ball", ball(STONE, 1.0, 6, 9)),
            ("tube", tube(STONE, &path, |_| 0.1, 7)),
            ("knot", knot(STONE, 2, 3, 1.0, 0.4, 0.1, 40, 6)),
            (
                "superquadric",
                superquadric(STONE, [1.0, 2.0, 1.0], 0.4, 1.6, 8, 12),
            ),
        ] {
            assert!(is_closed(&solid), "{name} is not closed");
            assert!(volume(&solid) > 0.0, "{name} is inside out");
        }
    }

    #[test]
    fn a_mirrored_copy_still_looks_outwards() {
        let mut shape = Shape::new();
        shape.add(
            &block(STONE, [0.0; 3], [1.0; 3]),
            Transform::scaling([-1.0, 1.0, 1.0]),
        );
        assert!(volume(&shape) > 0.0);
    }

    #[test]
    fn corners_at_one_place_become_one() {
        assert_eq!(
            block(STONE, [0.0; 3], [1.0; 3])
                .dressed(|_| Dress::Smooth)
                .positions()
                .len(),
            8
        );
    }
}
