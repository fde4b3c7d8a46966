//! Meshes: flat indexed arrays of faces, shared by all items that are copies of one thing.

use crate::content::MaterialId;
use crate::geom::{Aabb, ConvexPolygon, Copies, Octree, PolygonError, Step};
use std::ops::Range;
use thiserror::Error;

/// Faces and their corners, cut into clusters that are culled one by one.
///
/// Immutable. Building sorts faces by place, so the numbers of faces are not those of the input.
#[derive(Clone, Debug)]
pub struct Mesh {
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
    /// Where each face's corners begin, and the end of the last; empty where all faces are triangles.
    starts: Vec<u32>,
    clusters: Vec<Cluster>,
    tree: Octree,
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
}

/// Why faces do not make a mesh.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A position is NaN or infinite.
    #[error("position {position} of part {part} is not finite")]
    NotFinite {
        /// Which part.
        part: usize,
        /// Which of its positions.
        position: usize,
    },
    /// A corner names a position that is not there.
    #[error("corner {corner} of part {part} is position {index}, but there are only {positions}")]
    IndexOutOfRange {
        /// Which part.
        part: usize,
        /// Which of its corners.
        corner: usize,
        /// The position it names.
        index: u32,
        /// How many there are.
        positions: usize,
    },
    /// The numbers of corners do not add up to faces.
    #[error("the faces of part {part} do not use all of its {corners} corners")]
    CornersLeft {
        /// Which part.
        part: usize,
        /// How many corners it has.
        corners: usize,
    },
    /// A face of more than three corners is not flat and convex.
    #[error("face {face} of part {part}: {why}")]
    BadFace {
        /// Which part.
        part: usize,
        /// Which of its faces.
        face: usize,
        /// The broken rule.
        why: PolygonError,
    },
}

/// Faces in a cluster, at most. Fewer are culled more finely, but each cluster costs a test and a batch.
const CLUSTER_FACES: usize = 128;

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
        }])
    }

    /// Corner positions, cluster after cluster.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
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
            + size_of_val(&*self.clusters)) as u64
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

/// A face of the input: its part, and its corners there.
struct Source {
    part: u32,
    start: u32,
    sides: u32,
}

fn check(number: usize, part: &Part, faces: &mut Vec<Source>) -> Result<(), MeshError> {
    if let Some(position) = part
        .positions
        .iter()
        .position(|p| p.iter().any(|value| !value.is_finite()))
    {
        return Err(MeshError::NotFinite {
            part: number,
            position,
        });
    }
    let positions = part.positions.len();
    if let Some(corner) = part.corners.iter().position(|&index| index as usize >= positions) {
        let index = part.corners[corner];
        return Err(MeshError::IndexOutOfRange {
            part: number,
            corner,
            index,
            positions,
        });
    }
    let left = MeshError::CornersLeft {
        part: number,
        corners: part.corners.len(),
    };
    let Some(sides) = part.sides else {
        if !part.corners.len().is_multiple_of(3) {
            return Err(left);
        }
        let count = part.corners.len() as u32 / 3;
        faces.extend((0..count).map(|face| Source {
            part: number as u32,
            start: 3 * face,
            sides: 3,
        }));
        return Ok(());
    };
    let mut start = 0;
    for (face, &sides) in sides.iter().enumerate() {
        let corners = part
            .corners
            .get(start..start + sides as usize)
            .ok_or_else(|| left.clone())?;
        if sides != 3 {
            let outline: Vec<[f32; 3]> = corners
                .iter()
                .map(|&index| part.positions[index as usize])
                .collect();
            ConvexPolygon::new(&outline).map_err(|why| MeshError::BadFace {
                part: number,
                face,
                why,
            })?;
        }
        faces.push(Source {
            part: number as u32,
            start: start as u32,
            sides,
        });
        start += sides as usize;
    }
    if start == part.corners.len() {
        Ok(())
    } else {
        Err(left)
    }
}

fn build(parts: &[Part], faces: Vec<Source>) -> Mesh {
    let corners_of = |face: &Source| {
        &parts[face.part as usize].corners[face.start as usize..(face.start + face.sides) as usize]
    };
    let bounds: Vec<Aabb> = faces
        .iter()
        .map(|face| {
            let positions = parts[face.part as usize].positions;
            Aabb::of(corners_of(face).iter().map(|&index| positions[index as usize]))
        })
        .collect();
    let polygons = faces.iter().any(|face| face.sides != 3);
    let mut mesh = Mesh {
        positions: Vec::new(),
        corners: Vec::new(),
        starts: Vec::new(),
        clusters: Vec::new(),
        tree: Octree::build(&bounds, CLUSTER_FACES, Copies::One),
        bounds: bounds.iter().fold(Aabb::EMPTY, |sum, b| sum.union(b)),
    };
    // Where a position of the input stands in the cluster being made, if it does: (cluster + 1, new index).
    let mut placed: Vec<Vec<(u32, u32)>> = parts
        .iter()
        .map(|part| vec![(0, 0); part.positions.len()])
        .collect();
    let mut tree = std::mem::take(&mut mesh.tree);
    tree.renumber(|members, things| {
        let mut members = members.to_vec();
        members.sort_by_key(|&face| (parts[faces[face as usize].part as usize].material, face));
        let material = |face: u32| parts[faces[face as usize].part as usize].material;
        for run in members.chunk_by(|&a, &b| material(a) == material(b)) {
            for run in run.chunks(CLUSTER_FACES) {
                things.push(mesh.clusters.len() as u32);
                let stamp = mesh.clusters.len() as u32 + 1;
                let first_position = mesh.positions.len() as u32;
                let first_face = mesh.clusters.last().map_or(0, |cluster| cluster.faces.end);
                let mut held = Aabb::EMPTY;
                for &face in run {
                    let source = &faces[face as usize];
                    held = held.union(&bounds[face as usize]);
                    if polygons {
                        mesh.starts.push(mesh.corners.len() as u32);
                    }
                    for &index in corners_of(source) {
                        let place = &mut placed[source.part as usize][index as usize];
                        if place.0 != stamp {
                            *place = (stamp, mesh.positions.len() as u32);
                            mesh.positions
                                .push(parts[source.part as usize].positions[index as usize]);
                        }
                        mesh.corners.push(place.1);
                    }
                }
                mesh.clusters.push(Cluster {
                    faces: first_face..first_face + run.len() as u32,
                    positions: first_position..mesh.positions.len() as u32,
                    material: material(run[0]),
                    bounds: held,
                });
            }
        }
    });
    mesh.tree = tree;
    if polygons {
        mesh.starts.push(mesh.corners.len() as u32);
    }
    mesh.positions.shrink_to_fit();
    mesh.corners.shrink_to_fit();
    mesh.clusters.shrink_to_fit();
    mesh
}

#[cfg(test)]
mod tests {
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
}
