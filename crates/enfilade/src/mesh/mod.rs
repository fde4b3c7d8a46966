//! Meshes: indexed faces grouped into clusters, shared by all items that are instances of them.

mod attributes;
mod below;
mod build;
mod cuboid;
mod face_boxes;
mod list;
mod neighbours;
mod stored;
mod triangles;
mod vertices;

pub use attributes::Attributes;
pub use build::MeshError;
#[cfg(test)]
pub(crate) use face_boxes::tests::soup;
pub(crate) use neighbours::{NONE, PositionTable, VACANT};
pub use stored::MeshDataError;
pub use vertices::{Indices, Vertices};

use crate::geom::{Aabb, Octree, Step};
use crate::ids::MaterialId;
use attributes::MeshAttributes;
use below::Below;
use build::{build, check};
use bytes::Bytes;
use face_boxes::FaceBoxes;
use list::List;
use std::ops::Range;
use std::sync::OnceLock;

/// An indexed mesh of triangles or convex polygons, grouped into clusters that are culled separately.
///
/// Immutable. Building sorts the faces by position, so face numbers differ from those of the input. A mesh can be built
/// on any thread, and so can a scene with it, while others look at the scene before:
///
/// ```
/// # use enfilade::*;
/// # let mut room = GeometryBuilder::new([Material::opaque([0.8; 3])]);
/// # let wall = room.mesh(Mesh::cuboid([-9.0, -9.0, -5.0], [9.0, 9.0, -4.0], MaterialId(0))?);
/// # room.item("wall", wall, Transform::IDENTITY);
/// # let mut scene = Scene::single(room.build()?, Method::Masked)?;
/// # let ray = Ray { origin: [0.0; 3], direction: [0.0, 0.0, -1.0] };
/// // A clone shares the geometry until it is edited.
/// let mut next = scene.clone();
/// let prepared = std::thread::spawn(move || -> Result<Scene, Box<dyn std::error::Error + Send + Sync>> {
///     let statue = Mesh::cuboid([-0.5; 3], [0.5; 3], MaterialId(0))?;
///     let mut edit = next.edit();
///     edit.add(SectorId(0), "statue", statue, Transform::translation([0.0, 0.0, -2.0]))?;
///     edit.finish()?;
///     Ok(next)
/// });
/// // Until it is ready, frames show the scene without the statue.
/// assert_eq!(scene.cast(SectorId(0), &ray).distance, 4.0);
/// scene = prepared.join().expect("no panic").expect("a sound mesh");
/// assert_eq!(scene.cast(SectorId(0), &ray).distance, 1.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "vertex buffer")]
#[doc(alias = "index buffer")]
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: List<[f32; 3]>,
    attributes: MeshAttributes,
    corners: List<u32>,
    /// Start of each face in `corners`, and the end of the last; empty if all faces are triangles.
    starts: List<u32>,
    /// For each corner, the face of the cluster across the edge that starts there, or [`NONE`].
    neighbours: List<u8>,
    clusters: Vec<Cluster>,
    tree: Octree,
    below: Below,
    bounds: Aabb,
    /// For each cluster the boxes of its faces, made by the first query that needs them.
    face_boxes: Vec<OnceLock<FaceBoxes>>,
    /// Its occluders, as `occluders` writes them; empty if they are not known.
    occluders: Bytes,
}

/// A meshlet: up to 128 nearby faces with one material, the unit of culling and drawing.
#[doc(alias = "meshlet")]
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Range of the mesh's faces.
    pub faces: Range<u32>,
    /// Range of the mesh's positions that the faces use; no other cluster uses them.
    pub positions: Range<u32>,
    /// Material of all faces; meaningless if there are none ([`Mesh::bounds_only`]).
    pub material: MaterialId,
    /// AABB in object space.
    pub bounds: Aabb,
}

/// Input for a mesh: faces of one material over a list of positions.
#[doc(alias = "submesh")]
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Positions in object space, in scene units. Those that no face uses are ignored and may be NaN.
    #[doc(alias = "vertices")]
    pub positions: Vertices<'a, 3>,
    /// Indices into `positions`, face by face, each face counter-clockwise when seen from its front.
    #[doc(alias = "indices")]
    pub corners: Indices<'a>,
    /// Number of corners of each face, in order; `None` if all faces are triangles.
    pub sides: Option<&'a [u32]>,
    /// Material of all faces.
    pub material: MaterialId,
    /// Normals, texture coordinates and colors, for renderers.
    pub attributes: Attributes<'a>,
}

impl Mesh {
    /// Checks the parts and groups their faces into clusters.
    ///
    /// Triangles may have zero area; faces of more than three corners must be planar and convex.
    ///
    /// # Errors
    /// Returns the [`MeshError`] of the first invalid element.
    pub fn new(parts: &[Part]) -> Result<Mesh, MeshError> {
        let mut faces = Vec::new();
        for (number, part) in parts.iter().enumerate() {
            check(number, part, &mut faces)?;
        }
        Ok(build(parts, faces))
    }

    /// Returns a mesh without faces.
    pub(crate) fn nothing() -> Mesh {
        Mesh {
            positions: List::default(),
            attributes: MeshAttributes::default(),
            corners: List::default(),
            starts: List::default(),
            neighbours: List::default(),
            clusters: Vec::new(),
            tree: Octree::default(),
            below: Below::default(),
            bounds: Aabb::EMPTY,
            face_boxes: Vec::new(),
            occluders: Bytes::new(),
        }
    }

    /// Returns a mesh without faces that stands for whatever is within a box: an item with it may be visible if any part
    /// of its transformed box may be, and hides nothing. For what has no mesh of triangles, such as particles, lights,
    /// or objects that the renderer makes up; for a sphere, pass the box around it.
    ///
    /// Every method tests it conservatively, by its AABB: unlike others, such an item may also be in the set of an exact
    /// method though none of its content is at any sample.
    ///
    /// # Errors
    /// [`MeshError::EmptyCuboid`] unless `min` is less than `max` on every axis; [`MeshError::NotFinite`] and
    /// [`MeshError::TooFar`] as [`Mesh::new`].
    #[doc(alias = "bounding box")]
    #[doc(alias = "bounding sphere")]
    pub fn bounds_only(min: [f32; 3], max: [f32; 3]) -> Result<Mesh, MeshError> {
        let corners = Part {
            positions: Vertices::Packed(&[min, max]),
            // Only positions that a face uses are checked.
            corners: Indices::U32(&[0, 1, 1]),
            sides: None,
            material: MaterialId(0),
            attributes: Attributes::default(),
        };
        check(0, &corners, &mut Vec::new())?;
        if (0..3).any(|axis| max[axis] <= min[axis]) {
            return Err(MeshError::EmptyCuboid(min, max));
        }
        let bounds = Aabb { min, max };
        let mut mesh = Mesh::nothing();
        mesh.clusters.push(Cluster {
            faces: 0..0,
            positions: 0..0,
            material: MaterialId(0),
            bounds,
        });
        mesh.bounds = bounds;
        mesh.tree = Octree::build(&[bounds], 1);
        mesh.below = Below::new(&mesh.tree, |_| 0);
        Ok(mesh)
    }

    /// Creates a mesh of triangles with one material.
    ///
    /// `corners` has three indices into `positions` per triangle, counter-clockwise when seen from the front.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub fn triangles(
        positions: &[[f32; 3]],
        corners: &[u32],
        material: MaterialId,
    ) -> Result<Mesh, MeshError> {
        Mesh::new(&[Part {
            positions: Vertices::Packed(positions),
            corners: Indices::U32(corners),
            sides: None,
            material,
            attributes: Attributes::default(),
        }])
    }

    /// Returns the positions in object space, cluster by cluster.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Returns the shading normals, by position: zero where a part has none; empty if no part has any
    /// ([`Attributes::normals`]).
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.attributes.normals
    }

    /// Returns the texture coordinates, by position; empty if no part has any ([`Attributes::texture`]).
    pub fn texture(&self) -> &[[f32; 2]] {
        &self.attributes.texture
    }

    /// Returns the vertex colors, by position: white where a part has none; empty if no part has any
    /// ([`Attributes::colors`]).
    pub fn colors(&self) -> &[[f32; 4]] {
        &self.attributes.colors
    }

    /// Returns the clusters, in the order of their faces.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Returns the index of the cluster that contains a face.
    pub fn cluster_of(&self, face: u32) -> usize {
        self.clusters.partition_point(|cluster| cluster.faces.end <= face)
    }

    /// Returns the number of faces.
    pub fn face_count(&self) -> u32 {
        if self.starts.is_empty() {
            (self.corners.len() / 3) as u32
        } else {
            self.starts.len() as u32 - 1
        }
    }

    /// Returns the number of triangles after triangulating all faces.
    pub fn triangle_count(&self) -> u64 {
        self.corners.len() as u64 - 2 * u64::from(self.face_count())
    }

    /// Returns the number of triangles in a cluster.
    pub fn triangles_in(&self, cluster: usize) -> u64 {
        let faces = &self.clusters[cluster].faces;
        self.runs(faces.clone()).0.len() as u64 - 2 * faces.len() as u64
    }

    /// Returns the corners of a face, as indices into [`Mesh::positions`].
    pub fn face(&self, face: u32) -> &[u32] {
        let face = face as usize;
        if self.starts.is_empty() {
            &self.corners[3 * face..3 * face + 3]
        } else {
            &self.corners[self.starts[face] as usize..self.starts[face + 1] as usize]
        }
    }

    /// Returns the mesh with other materials: where a cluster has `old`, it gets `new(old)`. They share all lists.
    #[must_use]
    pub fn with_materials(&self, new: impl Fn(MaterialId) -> MaterialId) -> Mesh {
        let mut mesh = self.clone();
        for cluster in &mut mesh.clusters {
            cluster.material = new(cluster.material);
        }
        mesh
    }

    /// Returns the AABB of all faces, in object space, or that of [`Mesh::bounds_only`]; empty for other meshes without
    /// faces.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the memory used, in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.positions)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.starts)
            + size_of_val(&*self.neighbours)
            + size_of_val(&*self.clusters)
            + self.below.bytes()
            + size_of_val(&*self.face_boxes)
            + self
                .face_boxes
                .iter()
                .filter_map(OnceLock::get)
                .map(FaceBoxes::bytes)
                .sum::<usize>()
            + self.attributes.bytes()
            + self.occluders.len()) as u64
            + self.tree.bytes()
    }

    /// Returns the occluders that are kept with the mesh; empty if there are none.
    pub(crate) fn occluder_bytes(&self) -> &Bytes {
        &self.occluders
    }

    pub(crate) fn set_occluder_bytes(&mut self, occluders: Bytes) {
        self.occluders = occluders;
    }

    /// Traverses the octree over the clusters front to back from `eye`, in object space; its things are indices of
    /// clusters. `visit` returns `true` to enter a node; its answer for a cluster is ignored.
    pub fn walk(&self, eye: [f64; 3], visit: impl FnMut(Step) -> bool) {
        self.tree.walk(eye, visit);
    }

    /// Returns the octree over the clusters.
    pub(crate) fn tree(&self) -> &Octree {
        &self.tree
    }

    /// Returns the precomputed subtrees of [`Mesh::tree`].
    pub(crate) fn below(&self) -> &Below {
        &self.below
    }

    /// Returns, for each corner of a range of faces, the face across the edge that starts there, as a number in the
    /// cluster.
    pub(crate) fn neighbours(&self, faces: Range<u32>) -> &[u8] {
        let at = |face: u32| match self.starts.get(face as usize) {
            Some(&start) => start as usize,
            None => 3 * face as usize,
        };
        &self.neighbours[at(faces.start)..at(faces.end)]
    }

    /// Returns the corners of a range of faces, and the start of each face (`None` for triangles).
    pub(crate) fn runs(&self, faces: Range<u32>) -> (&[u32], Option<&[u32]>) {
        let (start, end) = (faces.start as usize, faces.end as usize);
        if self.starts.is_empty() {
            (&self.corners[3 * start..3 * end], None)
        } else {
            let starts = &self.starts[start..=end];
            (
                &self.corners[starts[0] as usize..starts[end - start] as usize],
                Some(starts),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::build::CLUSTER_FACES;
    use super::*;

    const STONE: MaterialId = MaterialId(0);
    const GLASS: MaterialId = MaterialId(1);

    /// Returns a grid of n × n squares, two triangles each.
    fn sheet(n: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
        let positions = (0..(n + 1) * (n + 1))
            .map(|i| [(i % (n + 1)) as f32, (i / (n + 1)) as f32, 0.0])
            .collect();
        let mut corners = Vec::new();
        for y in 0..n {
            for x in 0..n {
                let [a, b] = [y * (n + 1) + x, (y + 1) * (n + 1) + x];
                corners.extend([a, a + 1, b + 1, a, b + 1, b]);
            }
        }
        (positions, corners)
    }

    #[test]
    fn every_face_of_a_large_mesh_is_in_one_cluster_with_its_corners() {
        let (positions, corners) = sheet(40);
        let mesh = Mesh::triangles(&positions, &corners, STONE).expect("a valid grid");
        assert_eq!(mesh.face_count(), 3200);
        assert!(mesh.clusters().len() >= 25);
        let mut triangles: Vec<_> = Vec::new();
        for (number, cluster) in mesh.clusters().iter().enumerate() {
            assert!(cluster.faces.len() <= CLUSTER_FACES);
            for face in cluster.faces.clone() {
                assert_eq!(mesh.cluster_of(face), number);
                let corners = mesh.face(face);
                assert!(corners.iter().all(|&index| cluster.positions.contains(&index)));
                triangles.push(
                    corners
                        .iter()
                        .map(|&i| mesh.positions()[i as usize].map(f32::to_bits))
                        .collect::<Vec<_>>(),
                );
            }
        }
        let mut input: Vec<Vec<_>> = corners
            .chunks(3)
            .map(|c| {
                c.iter()
                    .map(|&i| positions[i as usize].map(f32::to_bits))
                    .collect()
            })
            .collect();
        triangles.sort();
        input.sort();
        assert_eq!(triangles, input);
    }

    #[test]
    fn faces_of_two_materials_are_not_in_one_cluster() {
        let (positions, corners) = sheet(2);
        let part = |material| Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(&corners),
            sides: None,
            material,
            attributes: Attributes::default(),
        };
        let mesh = Mesh::new(&[part(STONE), part(GLASS)]).expect("two valid parts");
        let materials: Vec<_> = mesh.clusters().iter().map(|cluster| cluster.material).collect();
        assert_eq!(materials, [STONE, GLASS]);
    }

    #[test]
    fn each_broken_rule_has_its_own_error() {
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 2.0, 3.0]];
        assert!(matches!(
            Mesh::triangles(&corner, &[0, 1, 4], STONE),
            Err(MeshError::IndexOutOfRange {
                corner: 2,
                index: 4,
                ..
            })
        ));
        assert!(matches!(
            Mesh::triangles(&corner, &[0, 1], STONE),
            Err(MeshError::CornersLeft { .. })
        ));
        let with_nan = [corner[0], [f32::NAN; 3], corner[1], [f32::INFINITY; 3], corner[2]];
        assert!(matches!(
            Mesh::triangles(&with_nan, &[0, 2, 4, 2, 4, 3], STONE),
            Err(MeshError::NotFinite { part: 0, position: 3 })
        ));
        let unused = Mesh::triangles(&with_nan, &[0, 2, 4], STONE).expect("no face uses NaN");
        assert_eq!(unused.positions(), &corner[..3]);
        let crowded = Part {
            positions: Vertices::Strided {
                bytes: &[0; 64],
                stride: 8,
            },
            corners: Indices::U16(&[0, 1, 2]),
            sides: None,
            material: STONE,
            attributes: Attributes::default(),
        };
        assert!(matches!(
            Mesh::new(&[crowded]),
            Err(MeshError::ShortStride {
                stride: 8,
                least: 12,
                ..
            })
        ));
        let bent = Part {
            positions: Vertices::Packed(&corner),
            corners: Indices::U32(&[0, 1, 3, 2]),
            sides: Some(&[4]),
            material: STONE,
            attributes: Attributes::default(),
        };
        assert!(matches!(
            Mesh::new(&[bent]),
            Err(MeshError::BadFace { face: 0, .. })
        ));
    }

    #[test]
    fn a_mesh_of_nothing_is_empty_but_sound() {
        let mesh = Mesh::new(&[]).expect("an empty mesh is valid");
        assert_eq!((mesh.face_count(), mesh.triangle_count()), (0, 0));
        assert!(mesh.bounds().is_empty());
    }

    #[test]
    fn a_hundred_thousand_faces_at_one_position_make_full_clusters() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let apart: Vec<[f32; 3]> = corners.into_iter().cycle().take(300_000).collect();
        let shared: Vec<u32> = (0..3).cycle().take(300_000).collect();
        let numbered: Vec<u32> = (0..300_000).collect();
        let points = [[1.0; 3]; 3];
        for (positions, corners) in [
            (&apart[..], &numbered),
            (&corners[..], &shared),
            (&points[..], &shared),
        ] {
            let mesh = Mesh::triangles(positions, corners, STONE).expect("valid faces");
            assert_eq!(mesh.face_count(), 100_000);
            assert_eq!(mesh.clusters().len(), 100_000_usize.div_ceil(CLUSTER_FACES));
            assert!(mesh.tree().node_count() <= 21, "{}", mesh.tree().node_count());
        }
    }
}
