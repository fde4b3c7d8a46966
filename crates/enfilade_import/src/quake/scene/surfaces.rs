//! The drawn faces of a map as triangles, in the axes of the scene.

use crate::BrokenRule;
use crate::budget::Budget;
use enfilade::{Attributes, Indices, MaterialId, Mesh, MeshError, Part, Vertices};
use std::ops::Range;

/// All faces of a map: of the world and of brush models.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    /// By face index of the map; `None` if engines do not draw the face.
    pub(super) faces: Vec<Option<Face>>,
    /// Vertices of all faces; no two faces share one.
    pub(super) positions: Vec<[f32; 3]>,
    /// One per position.
    pub(super) texture: Vec<[f32; 2]>,
    /// One per position, or empty.
    pub(super) normals: Vec<[f32; 3]>,
    /// One per position, or empty.
    pub(super) colors: Vec<[f32; 4]>,
    /// Counter-clockwise when seen from the front.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// A drawn face.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Face {
    pub(super) triangles: Range<usize>,
    pub(super) material: MaterialId,
    /// Whether engines draw it elsewhere than where the map has it.
    pub(super) moves: bool,
}

/// Memory of a vertex while the map is read, in bytes: here, in the mesh of its item, and while that mesh is built.
const BYTES_OF_A_CORNER: u64 = 48 + 48 + 40;
/// The same for a triangle.
const BYTES_OF_A_TRIANGLE: u64 = 12 + 16 + 120;
/// Additional memory of a face, in case it is a separate item.
const BYTES_OF_A_FACE: u64 = 600;

impl Surfaces {
    /// Reserves memory for faces, vertices and triangles.
    pub(super) fn afford(
        budget: &mut Budget,
        faces: u64,
        corners: u64,
        triangles: u64,
    ) -> Result<(), BrokenRule> {
        let bytes = [
            (corners, BYTES_OF_A_CORNER),
            (triangles, BYTES_OF_A_TRIANGLE),
            (faces, BYTES_OF_A_FACE),
        ];
        let bytes = bytes
            .iter()
            .map(|(count, of)| count.saturating_mul(*of))
            .fold(0, u64::saturating_add);
        budget.take(bytes, || "its faces".to_owned())
    }

    /// Returns the number of triangles of some faces.
    pub(super) fn triangle_count(&self, faces: &[u32]) -> usize {
        let drawn = faces
            .iter()
            .filter_map(|&face| self.faces[face as usize].as_ref());
        drawn.map(|face| face.triangles.len()).sum()
    }

    /// Returns `true` if engines draw one of some faces elsewhere than where the map has it.
    pub(super) fn any_moves(&self, faces: &[u32]) -> bool {
        let face = |&face: &u32| self.faces[face as usize].as_ref();
        faces.iter().filter_map(face).any(|face| face.moves)
    }

    /// Builds a mesh of some faces, ordered by material; without triangles if none of them is drawn.
    pub(super) fn mesh(&self, faces: &[u32]) -> Result<Mesh, MeshError> {
        let mut drawn: Vec<&Face> = faces
            .iter()
            .filter_map(|&face| self.faces[face as usize].as_ref())
            .collect();
        drawn.sort_by_key(|face| face.material);
        let mut own = MeshVertices::default();
        let mut parts = Vec::new();
        for of_one in drawn.chunk_by(|a, b| a.material == b.material) {
            let first = [own.taken.len(), own.corners.len()];
            for face in of_one {
                own.take(&self.triangles[face.triangles.clone()], first[0]);
            }
            parts.push((
                of_one[0].material,
                first[0]..own.taken.len(),
                first[1]..own.corners.len(),
            ));
        }
        let positions = own.of(&self.positions);
        let texture = own.of(&self.texture);
        let normals = own.of(&self.normals);
        let colors = own.of(&self.colors);
        let parts: Vec<Part> = parts
            .into_iter()
            .map(|(material, taken, corners)| Part {
                positions: Vertices::Packed(&positions[taken.clone()]),
                corners: Indices::U32(&own.corners[corners]),
                sides: None,
                material,
                attributes: Attributes {
                    texture: Vertices::Packed(texture.get(taken.clone()).unwrap_or_default()),
                    normals: Vertices::Packed(normals.get(taken.clone()).unwrap_or_default()),
                    colors: Vertices::Packed(colors.get(taken.clone()).unwrap_or_default()),
                },
            })
            .collect();
        Mesh::new(&parts)
    }
}

/// The vertices of one mesh; indices are relative to their part.
#[derive(Default)]
struct MeshVertices {
    /// Index of each vertex among those of all faces.
    taken: Vec<u32>,
    corners: Vec<u32>,
}

impl MeshVertices {
    /// Adds the vertices of a face to the part that begins at `first`. Faces share no vertices.
    fn take(&mut self, triangles: &[[u32; 3]], first: usize) {
        let start = self.taken.len();
        let mut all: Vec<u32> = triangles.concat();
        all.sort_unstable();
        all.dedup();
        self.taken.extend(&all);
        let place = |corner: &u32| all.binary_search(corner).unwrap_or(0) + start - first;
        self.corners
            .extend(triangles.as_flattened().iter().map(|corner| place(corner) as u32));
    }

    fn of<T: Copy>(&self, list: &[T]) -> Vec<T> {
        let taken = self.taken.iter();
        taken
            .filter_map(|&corner| list.get(corner as usize).copied())
            .collect()
    }
}
