//! Meshes: flat indexed arrays of faces, shared by all items that are copies of one thing.

mod attributes;
mod below;
mod build;
mod cuboid;
mod neighbours;

pub use attributes::Attributes;
pub use build::MeshError;
pub(crate) use neighbours::NONE;

use crate::geom::{Aabb, Octree, Step};
use crate::geometry::MaterialId;
use attributes::Carried;
use below::Below;
use build::{build, check};
use std::ops::Range;

/// Faces and their corners, cut into clusters that are culled one by one.
///
/// Immutable. Building sorts faces by place, so the numbers of faces are not those of the input.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    carried: Carried,
    corners: Vec<u32>,
    /// Where each face's corners begin, and the end of the last; empty where all faces are triangles.
    starts: Vec<u32>,
    /// For each corner, the face of the cluster across the edge that begins there, or [`NONE`].
    neighbours: Vec<u8>,
    clusters: Vec<Cluster>,
    tree: Octree,
    below: Below,
    bounds: Aabb,
}

/// Faces that lie near each other and have one material: what is culled and drawn at once.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// Its faces, as numbers of the mesh's faces.
    pub faces: Range<u32>,
    /// Its corners' positions: no other cluster uses them.
    pub positions: Range<u32>,
    /// What all its faces are made of.
    pub material: MaterialId,
    /// The smallest box around it, in the space of the mesh.
    pub bounds: Aabb,
}

/// Part of a mesh as it comes in: faces of one material over their own positions.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Corner positions, in the space of the mesh.
    pub positions: &'a [[f32; 3]],
    /// Indices into `positions`, face after face, each counter-clockwise seen from its front.
    pub corners: &'a [u32],
    /// Corners of each face, in order; `None` where all are triangles.
    pub sides: Option<&'a [u32]>,
    /// What the faces are made of.
    pub material: MaterialId,
    /// What its corners carry for who draws them.
    pub attributes: Attributes<'a>,
}

impl Mesh {
    /// Checks the parts and sorts their faces into clusters.
    ///
    /// # Errors
    /// One [`MeshError`] for the first broken rule. Triangles may have zero area; larger faces must be flat and
    /// convex.
    pub fn new(parts: &[Part]) -> Result<Mesh, MeshError> {
        let mut faces = Vec::new();
        for (number, part) in parts.iter().enumerate() {
            check(number, part, &mut faces)?;
        }
        Ok(build(parts, faces))
    }

    /// The mesh of no faces.
    pub(crate) fn nothing() -> Mesh {
        build(&[], Vec::new())
    }

    /// The mesh of one part whose faces are all triangles.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub fn triangles(
        positions: &[[f32; 3]],
        corners: &[u32],
        material: MaterialId,
    ) -> Result<Mesh, MeshError> {
        Mesh::new(&[Part {
            positions,
            corners,
            sides: None,
            material,
            attributes: Attributes::default(),
        }])
    }

    /// Corner positions, cluster after cluster.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// The normals of corners, by position; zero where a corner has none, and no list where none has
    /// ([`Attributes::normals`]).
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.carried.normals
    }

    /// Where corners are in their texture, by position; no list where none says so ([`Attributes::texture`]).
    pub fn texture(&self) -> &[[f32; 2]] {
        &self.carried.texture
    }

    /// The colors of corners, by position; white where a corner has none, and no list where none has
    /// ([`Attributes::colors`]).
    pub fn colors(&self) -> &[[f32; 4]] {
        &self.carried.colors
    }

    /// The clusters, in the order of their faces.
    pub fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// The cluster that a face is in.
    pub fn cluster_of(&self, face: u32) -> usize {
        self.clusters.partition_point(|cluster| cluster.faces.end <= face)
    }

    /// How many faces there are.
    pub fn face_count(&self) -> u32 {
        if self.starts.is_empty() {
            (self.corners.len() / 3) as u32
        } else {
            self.starts.len() as u32 - 1
        }
    }

    /// How many triangles the faces have.
    pub fn triangle_count(&self) -> u64 {
        self.corners.len() as u64 - 2 * u64::from(self.face_count())
    }

    /// How many triangles the faces of a cluster have.
    pub fn triangles_in(&self, cluster: usize) -> u64 {
        let faces = &self.clusters[cluster].faces;
        self.runs(faces.clone()).0.len() as u64 - 2 * faces.len() as u64
    }

    /// The corners of a face, as indices into [`Mesh::positions`].
    pub fn face(&self, face: u32) -> &[u32] {
        let face = face as usize;
        if self.starts.is_empty() {
            &self.corners[3 * face..3 * face + 3]
        } else {
            &self.corners[self.starts[face] as usize..self.starts[face + 1] as usize]
        }
    }

    /// The smallest box around all faces; empty where there are none.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.positions)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.starts)
            + size_of_val(&*self.neighbours)
            + size_of_val(&*self.clusters)
            + self.below.bytes()
            + self.carried.bytes()) as u64
            + self.tree.bytes()
    }

    /// Meets nodes and clusters from near to far as seen from `eye` (in the space of the mesh); things are numbers
    /// of clusters. See [`Octree::walk`].
    pub fn walk(&self, eye: [f64; 3], visit: impl FnMut(Step) -> bool) {
        self.tree.walk(eye, visit);
    }

    /// The tree over the clusters.
    pub(crate) fn tree(&self) -> &Octree {
        &self.tree
    }

    /// What is in the nodes of [`Mesh::tree`] and below them.
    pub(crate) fn below(&self) -> &Below {
        &self.below
    }

    /// For each corner of a run of faces, the face across the edge that begins there, as a number within the cluster.
    pub(crate) fn neighbours(&self, faces: Range<u32>) -> &[u8] {
        let at = |face: u32| match self.starts.get(face as usize) {
            Some(&start) => start as usize,
            None => 3 * face as usize,
        };
        &self.neighbours[at(faces.start)..at(faces.end)]
    }

    /// All corners of a run of faces, and where each face begins among them (`None`: every three).
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

    /// A sheet of n × n squares, two triangles each.
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
        let mesh = Mesh::triangles(&positions, &corners, STONE).expect("a sound sheet");
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
            positions: &positions,
            corners: &corners,
            sides: None,
            material,
            attributes: Attributes::default(),
        };
        let mesh = Mesh::new(&[part(STONE), part(GLASS)]).expect("a sound pair");
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
        assert!(matches!(
            Mesh::triangles(&[[f32::NAN; 3]], &[], STONE),
            Err(MeshError::NotFinite { part: 0, position: 0 })
        ));
        let bent = Part {
            positions: &corner,
            corners: &[0, 1, 3, 2],
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
        let mesh = Mesh::new(&[]).expect("nothing is wrong with nothing");
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
            let mesh = Mesh::triangles(positions, corners, STONE).expect("sound faces");
            assert_eq!(mesh.face_count(), 100_000);
            assert_eq!(mesh.clusters().len(), 100_000_usize.div_ceil(CLUSTER_FACES));
            assert!(mesh.tree().node_count() <= 21, "{}", mesh.tree().node_count());
        }
    }
}
