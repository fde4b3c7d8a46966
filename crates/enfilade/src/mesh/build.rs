//! Checks faces and groups them into clusters by position and material.

use super::attributes::MeshAttributes;
use super::below::Below;
use super::neighbours::Adjacency;
use super::{Cluster, Mesh, Part, Vertices};
use crate::geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Octree, PolygonError, is_in_range};
use std::sync::OnceLock;
use thiserror::Error;

/// Why a mesh is invalid; returned by [`Mesh::new`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A cuboid has no volume; holds its two corners.
    #[error(
        "the cuboid from {0:?} to {1:?} has no volume; each coordinate must be larger in the second point"
    )]
    EmptyCuboid([f32; 3], [f32; 3]),
    /// A position that a face uses is NaN or infinite.
    #[error("position {position} of part {part} is not finite")]
    NotFinite {
        /// Index of the part.
        part: usize,
        /// Index of the position in the part.
        position: usize,
    },
    /// A position that a face uses is beyond [`MAX_COORDINATE`].
    #[error(
        "position {position} of part {part} is farther out than {MAX_COORDINATE:e} units; scale the mesh down or move it to its origin"
    )]
    TooFar {
        /// Index of the part.
        part: usize,
        /// Index of the position in the part.
        position: usize,
    },
    /// An index refers to a position that does not exist.
    #[error("index {corner} of part {part} is {index}, but there are only {positions} positions")]
    IndexOutOfRange {
        /// Index of the part.
        part: usize,
        /// Index of the corner in the part.
        corner: usize,
        /// The index of the position.
        index: u32,
        /// Number of positions.
        positions: usize,
    },
    /// The stride of strided vertex data is shorter than a vertex.
    #[error("the {what} of part {part} have a stride of {stride} bytes, but take {least}")]
    ShortStride {
        /// Index of the part.
        part: usize,
        /// Name of the vertex data.
        what: &'static str,
        /// The stride, in bytes.
        stride: usize,
        /// Size of a vertex, in bytes.
        least: usize,
    },
    /// The number of normals, texture coordinates or colors differs from the number of positions.
    #[error("part {part} has {count} {what}, but {positions} positions; give one for each, or none")]
    AttributeCount {
        /// Index of the part.
        part: usize,
        /// Name of the attribute.
        what: &'static str,
        /// Number of its elements.
        count: usize,
        /// Number of positions.
        positions: usize,
    },
    /// A normal, a texture coordinate or a color of a position that a face uses is NaN or infinite.
    #[error("the {what} of part {part} are not finite at position {position}")]
    AttributeNotFinite {
        /// Index of the part.
        part: usize,
        /// Name of the attribute.
        what: &'static str,
        /// Index of the position in the part.
        position: usize,
    },
    /// The corners do not form whole faces.
    #[error(
        "the {corners} indices of part {part} are no whole faces: three per triangle, or as many as `sides` says"
    )]
    CornersLeft {
        /// Index of the part.
        part: usize,
        /// Number of corners.
        corners: usize,
    },
    /// A face of more than three corners is not planar and convex.
    #[error("face {face} of part {part}: {why}")]
    BadFace {
        /// Index of the part.
        part: usize,
        /// Index of the face in the part.
        face: usize,
        /// Why the face is invalid.
        why: PolygonError,
    },
}

/// Maximum number of faces in a cluster. Smaller clusters are culled more precisely, but each costs a test and a batch.
pub(super) const CLUSTER_FACES: usize = 128;

/// A face of the input: its part, and its range of corners there.
#[derive(Clone, Copy)]
pub(super) struct Source {
    part: u32,
    start: u32,
    sides: u32,
}

impl Source {
    /// Returns the indices of the corners' positions.
    fn corners<'a>(self, parts: &'a [Part]) -> impl Iterator<Item = u32> + 'a {
        let corners = parts[self.part as usize].corners;
        (self.start..self.start + self.sides).map(move |corner| corners.at(corner as usize))
    }
}

/// Checks a part and appends its faces.
pub(super) fn check(number: usize, part: &Part, faces: &mut Vec<Source>) -> Result<(), MeshError> {
    let positions = part.positions.len();
    check_stride(number, &part.positions, "positions")?;
    let out_of_range = |&corner: &usize| part.corners.at(corner) as usize >= positions;
    if let Some(corner) = (0..part.corners.len()).find(out_of_range) {
        return Err(MeshError::IndexOutOfRange {
            part: number,
            corner,
            index: part.corners.at(corner),
            positions,
        });
    }
    let is_bad = |position: usize| !part.positions.at(position).into_iter().all(is_in_range);
    if let Some(position) = first_used(part, (0..positions).filter(|&position| is_bad(position))) {
        let is_finite = part.positions.at(position).iter().all(|value| value.is_finite());
        return Err(if is_finite {
            MeshError::TooFar {
                part: number,
                position,
            }
        } else {
            MeshError::NotFinite {
                part: number,
                position,
            }
        });
    }
    part.attributes.check(number, part)?;
    let left = || MeshError::CornersLeft {
        part: number,
        corners: part.corners.len(),
    };
    let Some(sides) = part.sides else {
        if !part.corners.len().is_multiple_of(3) {
            return Err(left());
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
        let end = start + sides as usize;
        if end > part.corners.len() {
            return Err(left());
        }
        if sides != 3 {
            let corners = (start..end).map(|corner| part.corners.at(corner));
            let outline: Vec<[f32; 3]> = corners.map(|index| part.positions.at(index as usize)).collect();
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
        start = end;
    }
    if start == part.corners.len() {
        Ok(())
    } else {
        Err(left())
    }
}

pub(super) fn check_stride<const N: usize>(
    part: usize,
    list: &Vertices<N>,
    what: &'static str,
) -> Result<(), MeshError> {
    match list.short_stride() {
        Some(stride) => Err(MeshError::ShortStride {
            part,
            what,
            stride,
            least: 4 * N,
        }),
        None => Ok(()),
    }
}

/// Returns the first of the given positions, in ascending order, that a face uses.
///
/// Only invalid positions are given: sound buffers, most of them, cost nothing here.
pub(super) fn first_used(part: &Part, positions: impl Iterator<Item = usize>) -> Option<usize> {
    let mut positions = positions.peekable();
    positions.peek()?;
    let mut used = vec![false; part.positions.len()];
    for corner in 0..part.corners.len() {
        used[part.corners.at(corner) as usize] = true;
    }
    positions.find(|&position| used[position])
}

/// Builds the mesh of valid faces.
pub(super) fn build(parts: &[Part], faces: Vec<Source>) -> Mesh {
    let bounds: Vec<Aabb> = (faces.iter())
        .map(|face| {
            let positions = parts[face.part as usize].positions;
            Aabb::of(face.corners(parts).map(|index| positions.at(index as usize)))
        })
        .collect();
    let mut tree = Octree::build(&bounds, CLUSTER_FACES);
    let mut clusters = Clusters::new(parts, &faces, &bounds);
    let material = |face: u32| parts[faces[face as usize].part as usize].material;
    let mut members: Vec<u32> = Vec::new();
    tree.renumber(|in_node, numbers| {
        members.clear();
        members.extend_from_slice(in_node);
        // A new octree lists faces in order.
        if parts.len() > 1 {
            members.sort_by_key(|&face| material(face));
        }
        for run in members.chunk_by(|&a, &b| material(a) == material(b)) {
            for run in run.chunks(CLUSTER_FACES) {
                numbers.push(clusters.lists.clusters.len() as u32);
                clusters.add(run);
            }
        }
    });
    let Clusters {
        mut lists, sources, ..
    } = clusters;
    if faces.iter().any(|face| face.sides != 3) {
        lists.starts.push(lists.corners.len() as u32);
    } else {
        lists.starts = Vec::new();
    }
    lists.clusters.shrink_to_fit();
    let mut mesh = Mesh {
        positions: lists.positions.into(),
        attributes: MeshAttributes::gather(parts, &sources),
        corners: lists.corners.into(),
        starts: lists.starts.into(),
        neighbours: lists.neighbours.into(),
        clusters: lists.clusters,
        ..Mesh::nothing()
    };
    mesh.below = Below::new(&tree, |cluster| mesh.triangles_in(cluster));
    mesh.tree = tree;
    mesh.face_boxes.resize_with(mesh.clusters.len(), OnceLock::new);
    mesh.bounds = bounds.iter().fold(Aabb::EMPTY, |sum, b| sum.union(b));
    mesh
}

/// The lists of a mesh that is being built.
#[derive(Default)]
struct Lists {
    positions: Vec<[f32; 3]>,
    corners: Vec<u32>,
    starts: Vec<u32>,
    neighbours: Vec<u8>,
    clusters: Vec<Cluster>,
}

/// Builds the clusters of a mesh one by one.
struct Clusters<'a> {
    parts: &'a [Part<'a>],
    faces: &'a [Source],
    bounds: &'a [Aabb],
    lists: Lists,
    /// Part and index of each position of the mesh.
    sources: Vec<(u32, u32)>,
    /// By position of the input: 1 + the last cluster that uses it, and its number there.
    seen: Vec<Vec<(u32, u32)>>,
    /// The cluster being built: its vertices in the order in which its faces come, their positions, and their indices in
    /// the mesh; the corners of its faces, as numbers of vertices; the start of each face there.
    vertices: Vec<(u32, u32)>,
    positions: Vec<[f32; 3]>,
    placed: Vec<u32>,
    corners: Vec<u32>,
    starts: Vec<u32>,
    adjacency: Adjacency,
}

impl<'a> Clusters<'a> {
    fn new(parts: &'a [Part], faces: &'a [Source], bounds: &'a [Aabb]) -> Clusters<'a> {
        let mut lists = Lists::default();
        let corners: usize = parts.iter().map(|part| part.corners.len()).sum();
        lists.corners.reserve_exact(corners);
        lists.neighbours.reserve_exact(corners);
        let vertices = parts.iter().map(|part| vec![(0, 0); part.positions.len()]);
        Clusters {
            parts,
            faces,
            bounds,
            lists,
            sources: Vec::new(),
            seen: vertices.collect(),
            vertices: Vec::new(),
            positions: Vec::new(),
            placed: Vec::new(),
            corners: Vec::new(),
            starts: Vec::new(),
            adjacency: Adjacency::default(),
        }
    }

    /// Adds a cluster of the given faces, neighbours together.
    fn add(&mut self, members: &[u32]) {
        self.collect(members);
        self.adjacency.find(&self.positions, &self.corners, &self.starts);
        const UNPLACED: u32 = u32::MAX;
        self.placed.clear();
        self.placed.resize(self.vertices.len(), UNPLACED);
        let lists = &mut self.lists;
        let first_position = lists.positions.len() as u32;
        let mut bounds = Aabb::EMPTY;
        for &face in self.adjacency.order() {
            let face = usize::from(face);
            bounds = bounds.union(&self.bounds[members[face] as usize]);
            lists.starts.push(lists.corners.len() as u32);
            for corner in self.starts[face]..self.starts[face + 1] {
                let vertex = self.corners[corner as usize] as usize;
                if self.placed[vertex] == UNPLACED {
                    self.placed[vertex] = lists.positions.len() as u32;
                    lists.positions.push(self.positions[vertex]);
                    self.sources.push(self.vertices[vertex]);
                }
                lists.corners.push(self.placed[vertex]);
                lists.neighbours.push(self.adjacency.across(corner));
            }
        }
        let first_face = lists.clusters.last().map_or(0, |cluster| cluster.faces.end);
        lists.clusters.push(Cluster {
            faces: first_face..first_face + members.len() as u32,
            positions: first_position..lists.positions.len() as u32,
            material: self.parts[self.faces[members[0] as usize].part as usize].material,
            bounds,
        });
    }

    /// Collects the corners of a cluster's faces, and numbers its vertices.
    fn collect(&mut self, members: &[u32]) {
        let stamp = self.lists.clusters.len() as u32 + 1;
        self.vertices.clear();
        self.positions.clear();
        self.corners.clear();
        self.starts.clear();
        self.starts.push(0);
        for &member in members {
            let face = self.faces[member as usize];
            let seen = &mut self.seen[face.part as usize];
            for index in face.corners(self.parts) {
                let seen = &mut seen[index as usize];
                if seen.0 != stamp {
                    *seen = (stamp, self.vertices.len() as u32);
                    self.vertices.push((face.part, index));
                    let positions = &self.parts[face.part as usize].positions;
                    self.positions.push(positions.at(index as usize));
                }
                self.corners.push(seen.1);
            }
            self.starts.push(self.corners.len() as u32);
        }
    }
}
