//! Occluder meshes: faces as compact arrays for the rasterizer.
//!
//! Faces are split at the median of their centres into parts of up to 256 triangles, each with its box: parts are drawn
//! front to back, and only those that are not hidden yet. So few vertices are transformed in vain, and those of a part
//! stay in the L1 cache. Positions are stored as arrays of sixteen x, y and z. Two successive triangles that form a
//! planar convex quad are merged. Faces index the vertices of their part: with the corners of sixteen faces in the order of
//! the kernels instead, separate quads took 16 % less time, but Sponza 20 % more, because it shares vertices.
//! Source: order as in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 4.
//! Cost: O(faces log faces).
//! Conservative: as [`batch`](super::batch). A merged quad is no nearer than its four corners, and covers what its two
//!     triangles cover.

use super::LANES;
use super::project::Block;
use crate::geom::Aabb;
use crate::occluders::{LargeFace, large_faces};
use crate::raster::{greater, smaller};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};
use glam::DVec3;
use std::collections::HashMap;
use thiserror::Error;

/// Triangles that an [`OcclusionBuffer`](crate::OcclusionBuffer) rasterizes as occluders.
///
/// Build it once per mesh, and draw any number of instances of it, each with its own transform. Everything that an
/// instance covers in the buffer must be opaque on the screen: leave out glass, foliage with alpha test, and whatever
/// the renderer moves or hides on its own, such as skinned meshes and distant LODs with another outline.
#[derive(Clone, Debug)]
#[doc(alias = "occluder")]
#[doc(alias = "occlusion proxy")]
pub struct OccluderMesh {
    /// Whether faces occlude from both sides. Default `false`: back-faces are culled, so a face hides what is behind it
    /// only if the eye is in front of it. Set it for meshes that the renderer draws without back-face culling.
    pub double_sided: bool,
    pub(super) parts: Vec<Part>,
}

/// Why an occluder mesh is invalid; returned by [`OccluderMesh::triangles`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum OccluderMeshError {
    /// The number of indices is not a multiple of three.
    #[error("{0} indices are not whole triangles; each triangle has three")]
    IndicesLeft(usize),
    /// An index refers to a position that does not exist.
    #[error("triangle {triangle} has position {index}, but there are only {positions}")]
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The index of the position.
        index: u32,
        /// Number of positions.
        positions: usize,
    },
    /// A corner is NaN or infinite.
    #[error("position {index}, a corner of triangle {triangle}, is not finite")]
    NotFinite {
        /// Index of the triangle.
        triangle: usize,
        /// Index of the position.
        index: u32,
    },
}

/// Faces that share no vertices with other parts.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// AABB of all finite vertices.
    pub(super) bounds: Aabb,
    /// Estimate of the share of the AABB's outline that the faces fill: 1 for a wall, almost 0 for scattered faces.
    pub(super) fill: f32,
    pub(super) blocks: Vec<Block>,
    pub(super) quads: FaceList<4, 2>,
    pub(super) triangles: FaceList<3, 1>,
}

/// Faces with `SIDES` corners, each of which is `HALVES` triangles.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceList<const SIDES: usize, const HALVES: usize> {
    /// Corners, as indices into the part's positions.
    faces: Vec<[u32; SIDES]>,
    /// For each sixteen faces: n and d of the planes of their triangles. n · p + d is positive in front of the face.
    planes: Vec<[[[f32; LANES]; 4]; HALVES]>,
}

impl Part {
    /// A part without faces.
    pub(super) const EMPTY: Part = Part {
        bounds: Aabb::EMPTY,
        fill: 0.0,
        blocks: Vec::new(),
        quads: FaceList::EMPTY,
        triangles: FaceList::EMPTY,
    };

    /// Returns the number of quads and triangles.
    pub(super) fn face_count(&self) -> usize {
        self.quads.faces.len() + self.triangles.faces.len()
    }
}

/// Maximum number of triangles in a part.
const MAX_TRIANGLES: usize = 256;

impl OccluderMesh {
    /// Builds a mesh of triangles: three indices into `positions` each, counter-clockwise as seen from the front.
    ///
    /// Triangles that are close together, up to 256, keep their order, so give the largest first: what they hide is then
    /// rejected early. Two successive triangles that form a planar convex quad, such as (a, b, c) and (a, c, d), are
    /// merged into one face. Positions that no triangle uses are ignored, and triangles without area hide nothing.
    ///
    /// # Errors
    /// Returns the [`OccluderMeshError`] of the first triangle with an index out of range or a corner that is not
    /// finite, or [`OccluderMeshError::IndicesLeft`].
    pub fn triangles(positions: &[[f32; 3]], indices: &[u32]) -> Result<OccluderMesh, OccluderMeshError> {
        let (triangles, left) = indices.as_chunks::<3>();
        if !left.is_empty() {
            return Err(OccluderMeshError::IndicesLeft(indices.len()));
        }
        for (triangle, &index) in triangles
            .iter()
            .enumerate()
            .flat_map(|(triangle, corners)| corners.iter().map(move |index| (triangle, index)))
        {
            let Some(position) = positions.get(index as usize) else {
                return Err(OccluderMeshError::IndexOutOfRange {
                    triangle,
                    index,
                    positions: positions.len(),
                });
            };
            if !position.iter().all(|value| value.is_finite()) {
                return Err(OccluderMeshError::NotFinite { triangle, index });
            }
        }
        Ok(OccluderMesh::unchecked(positions, indices))
    }

    /// As [`OccluderMesh::triangles`], but invalid triangles hide nothing.
    pub(super) fn unchecked(positions: &[[f32; 3]], indices: &[u32]) -> OccluderMesh {
        let mut faces = Vec::new();
        let triangles = indices.as_chunks().0;
        let mut next = 0;
        while let Some(&one) = triangles.get(next) {
            let merged = triangles
                .get(next + 1)
                .and_then(|&other| merged(positions, one, other));
            faces.push(MeshFace::new(
                positions,
                merged.map_or(Corners::Triangle(one), Corners::Quad),
                faces.len(),
            ));
            next += if merged.is_some() { 2 } else { 1 };
        }
        OccluderMesh::of(positions, &mut faces)
    }

    /// Builds a mesh from quads: four indices each. A quad (a, b, c, d), bent or not, hides at most what the triangles
    /// (a, b, c) and (a, c, d) hide.
    #[cfg(test)]
    pub(super) fn quads(positions: &[[f32; 3]], corners: &[u32]) -> OccluderMesh {
        let quads = corners.as_chunks::<4>().0.iter().enumerate();
        let face = |(number, &quad)| MeshFace::new(positions, Corners::Quad(quad), number);
        OccluderMesh::of(positions, &mut quads.map(face).collect::<Vec<_>>())
    }

    fn of(positions: &[[f32; 3]], faces: &mut [MeshFace]) -> OccluderMesh {
        let mut builder = MeshBuilder {
            positions,
            parts: Vec::new(),
            local_index: HashMap::new(),
            used: Vec::new(),
        };
        builder.add_parts(faces);
        OccluderMesh {
            double_sided: false,
            parts: builder.parts,
        }
    }

    /// Returns a mesh of at most `max_triangles` triangles that hides nothing that this one does not hide, from any eye
    /// position.
    ///
    /// It consists of the largest parts of the surface: faces that are connected and exactly coplanar are merged to
    /// convex polygons, so a wall of a thousand triangles becomes two, and one with a window four rectangles. The
    /// largest polygons are kept. So it suits buildings, rooms and furniture, with axis-aligned faces in their own
    /// space. Of a curved surface, or of faces that are coplanar up to rounding only, it keeps single triangles, which
    /// hide little; give a proxy of your own for those, inside of the surface.
    ///
    /// O(n log n) in the number of triangles; meant for import, not for every frame.
    #[doc(alias = "occluder proxy")]
    pub fn simplified(&self, max_triangles: usize) -> OccluderMesh {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        self.for_each_triangle(|corners| {
            let first = positions.len() as u32;
            positions.extend(corners);
            triangles.push([first, first + 1, first + 2]);
        });
        let (mut kept, mut indices) = (Vec::new(), Vec::new());
        for LargeFace { corners, .. } in large_faces(&positions, &triangles, self.double_sided) {
            if indices.len() / 3 + corners.len() - 2 <= max_triangles {
                let first = kept.len() as u32;
                indices.extend(
                    (2..corners.len() as u32).flat_map(|last| [first, first + last - 1, first + last]),
                );
                kept.extend(corners);
            }
        }
        OccluderMesh {
            double_sided: self.double_sided,
            ..OccluderMesh::unchecked(&kept, &indices)
        }
    }

    /// Calls `each` with the corners of each triangle.
    pub(super) fn for_each_triangle(&self, mut each: impl FnMut([[f32; 3]; 3])) {
        for part in &self.parts {
            let quads = part.quads.faces.iter();
            let halves = quads.flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            for corners in halves.chain(part.triangles.faces.iter().copied()) {
                let at = |corner: u32| {
                    part.blocks[corner as usize / LANES].map(|axis| axis[corner as usize % LANES])
                };
                each(corners.map(at));
            }
        }
    }

    /// Returns the number of triangles.
    pub fn triangle_count(&self) -> usize {
        let parts = self.parts.iter();
        parts
            .map(|part| 2 * part.quads.faces.len() + part.triangles.faces.len())
            .sum()
    }

    /// Returns the memory in bytes.
    pub fn bytes(&self) -> u64 {
        let parts = self.parts.iter().map(|part| {
            size_of_val(part)
                + size_of_val(&*part.blocks)
                + size_of_val(&*part.quads.faces)
                + size_of_val(&*part.quads.planes)
                + size_of_val(&*part.triangles.faces)
                + size_of_val(&*part.triangles.planes)
        });
        parts.sum::<usize>() as u64
    }
}

/// Returns the quad of which two triangles are the halves; `None` if they share no edge or the quad is not planar and
/// convex.
pub(super) fn merged(positions: &[[f32; 3]], one: [u32; 3], other: [u32; 3]) -> Option<[u32; 4]> {
    /// Tolerance of planarity, relative to the length of the diagonal. Geometry nearer behind the quad than this is not
    /// hidden.
    const FLAT: f64 = 1e-4;
    let turns = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let (one, other) = turns(one)
        .into_iter()
        .flat_map(|one| turns(other).map(|other| (one, other)))
        .find(|(one, other)| one[0] == other[0] && one[2] == other[1])?;
    let quad = [one[0], one[1], one[2], other[2]];
    let mut at = [DVec3::ZERO; 4];
    for (at, corner) in at.iter_mut().zip(quad) {
        *at = DVec3::from(positions.get(corner as usize)?.map(f64::from));
    }
    let [a, b, c, d] = at;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let is_flat = normal.dot(d - a).abs() <= FLAT * (c - a).length();
    let is_convex = [[d, a, b], [a, b, c], [b, c, d], [c, d, a]]
        .iter()
        .all(|[before, here, after]| (here - before).cross(after - here).dot(normal) > 0.0);
    (is_flat && is_convex).then_some(quad)
}

/// A face of a mesh under construction.
struct MeshFace {
    corners: Corners,
    /// Three times its centre; corners with an index out of range count as the origin.
    at: [f32; 3],
    /// Place in the input.
    number: usize,
}

enum Corners {
    Triangle([u32; 3]),
    Quad([u32; 4]),
}

impl MeshFace {
    fn new(positions: &[[f32; 3]], corners: Corners, number: usize) -> MeshFace {
        let (Corners::Triangle([a, b, c]) | Corners::Quad([a, b, c, _])) = corners;
        let [a, b, c] = [a, b, c].map(|corner| positions.get(corner as usize).copied().unwrap_or_default());
        let at = [0, 1, 2].map(|axis| a[axis] + b[axis] + c[axis]);
        MeshFace { corners, at, number }
    }

    fn triangles(&self) -> usize {
        match self.corners {
            Corners::Triangle(_) => 1,
            Corners::Quad(_) => 2,
        }
    }
}

/// A mesh under construction.
struct MeshBuilder<'a> {
    positions: &'a [[f32; 3]],
    parts: Vec<Part>,
    /// Of the current part: the local index of each vertex, and the vertex positions by that index.
    local_index: HashMap<u32, u32>,
    used: Vec<[f32; 3]>,
}

impl MeshBuilder<'_> {
    /// Adds the parts of faces, and sorts the faces by part.
    fn add_parts(&mut self, faces: &mut [MeshFace]) {
        if faces.iter().map(MeshFace::triangles).sum::<usize>() <= MAX_TRIANGLES {
            faces.sort_unstable_by_key(|face| face.number);
            self.add_part(faces);
            return;
        }
        let bounds = Aabb::of(faces.iter().map(|face| face.at));
        let side = |axis: &usize| bounds.max[*axis] - bounds.min[*axis];
        let axis = (0..3).max_by(|a, b| side(a).total_cmp(&side(b))).unwrap_or(0);
        let key = |face: &MeshFace| (face.at[axis], face.number);
        let order = |a: &MeshFace, b: &MeshFace| {
            let [a, b] = [key(a), key(b)];
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        };
        let middle = faces.len() / 2;
        faces.select_nth_unstable_by(middle, order);
        let (one, other) = faces.split_at_mut(middle);
        self.add_parts(one);
        self.add_parts(other);
    }

    fn add_part(&mut self, faces: &[MeshFace]) {
        let (mut quads, mut triangles) = (FaceList::default(), FaceList::default());
        for face in faces {
            match face.corners {
                Corners::Triangle(corners) => triangles.faces.push(self.local_indices(corners)),
                Corners::Quad(corners) => quads.faces.push(self.local_indices(corners)),
            }
        }
        let is_number = |at: &&[f32; 3]| at.iter().all(|value| value.is_finite());
        let area = quads.find_planes(&self.used) + triangles.find_planes(&self.used);
        let bounds = Aabb::of(self.used.iter().filter(is_number).copied());
        self.parts.push(Part {
            // 0 for NaN, of faces and a box without area.
            fill: smaller(greater(area / bounds.half_area(), 0.0), 1.0) as f32,
            bounds,
            blocks: self.used.chunks(LANES).map(block).collect(),
            quads,
            triangles,
        });
        self.used.clear();
        self.local_index.clear();
    }

    /// Returns the corners as indices into the current part.
    fn local_indices<const SIDES: usize>(&mut self, corners: [u32; SIDES]) -> [u32; SIDES] {
        corners.map(|corner| {
            *self.local_index.entry(corner).or_insert_with(|| {
                let position = self.positions.get(corner as usize).copied();
                self.used.push(position.unwrap_or([f32::NAN; 3]));
                self.used.len() as u32 - 1
            })
        })
    }
}

impl<const SIDES: usize, const HALVES: usize> FaceList<SIDES, HALVES> {
    const EMPTY: Self = FaceList {
        faces: Vec::new(),
        planes: Vec::new(),
    };

    /// Fills `planes`, and returns the area of the faces.
    fn find_planes(&mut self, positions: &[[f32; 3]]) -> f64 {
        let mut area = 0.0;
        for faces in self.faces.chunks(LANES) {
            let mut planes = [[[0.0; LANES]; 4]; HALVES];
            for (lane, face) in faces.iter().enumerate() {
                let at = face.map(|corner| DVec3::from(positions[corner as usize].map(f64::from)));
                for (half, planes) in planes.iter_mut().enumerate() {
                    let normal = (at[half + 1] - at[0]).cross(at[half + 2] - at[0]);
                    area += greater(0.5 * normal.length(), 0.0);
                    let normal = normal.normalize_or_zero();
                    let plane = [normal.x, normal.y, normal.z, -normal.dot(at[0])];
                    for (axis, value) in plane.into_iter().enumerate() {
                        planes[axis][lane] = value as f32;
                    }
                }
            }
            self.planes.push(planes);
        }
        area
    }

    /// Appends all faces to `facing`.
    #[inline(always)]
    pub(super) fn keep_all(&self, facing: &mut Vec<[u32; SIDES]>) {
        facing.extend_from_slice(&self.faces);
    }

    /// Appends to `facing` all faces except those that certainly face away from the eye.
    #[inline(always)]
    pub(super) fn keep_facing<S: Simd>(&self, simd: S, eye: [f32; 3], facing: &mut Vec<[u32; SIDES]>) {
        for (planes, faces) in self.planes.iter().zip(self.faces.chunks(LANES)) {
            let mut left = !behind(simd, planes, eye) & ((1 << faces.len()) - 1);
            if left == (1 << LANES) - 1 {
                facing.extend_from_slice(faces);
                continue;
            }
            while left != 0 {
                facing.push(faces[left.trailing_zeros() as usize]);
                left &= left - 1;
            }
        }
    }
}

/// Returns a bit mask of sixteen faces; a bit is set if the face certainly faces away from the eye.
#[inline(always)]
fn behind<S: Simd, const HALVES: usize>(simd: S, planes: &[[[f32; LANES]; 4]; HALVES], eye: [f32; 3]) -> u64 {
    /// Generous bound on the relative rounding error.
    const ROUNDING: f32 = 1.0 / (1_u32 << 20) as f32;
    let mut behind = mask32x16::splat(simd, true);
    for [a, b, c, d] in planes {
        let a = f32x16::from_slice(simd, a) * eye[0];
        let b = f32x16::from_slice(simd, b) * eye[1];
        let c = f32x16::from_slice(simd, c) * eye[2];
        let d = f32x16::from_slice(simd, d);
        let slack = (a.abs() + b.abs() + c.abs() + d.abs()) * ROUNDING;
        // `false` for NaN, so faces with NaN planes are kept.
        behind &= (a + b + c + d).simd_lt(-slack);
    }
    behind.to_bitmask()
}

/// Transposes up to sixteen positions into the layout of the kernels; missing ones become NaN.
pub(super) fn block(positions: &[[f32; 3]]) -> Block {
    if let Ok(whole) = <&[[f32; 3]; LANES]>::try_from(positions) {
        return [0, 1, 2].map(|axis| whole.map(|position| position[axis]));
    }
    let mut block = [[f32::NAN; LANES]; 3];
    for (lane, position) in positions.iter().enumerate() {
        for (axis, &value) in position.iter().enumerate() {
            block[axis][lane] = value;
        }
    }
    block
}
