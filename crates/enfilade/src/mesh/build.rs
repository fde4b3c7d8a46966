//! Checks faces and groups them into clusters by position and material.

use super::attributes::MeshAttributes;
use super::below::Below;
use super::neighbours::{NONE, SmallMap, neighbours, neighbours_together};
use super::{Cluster, Mesh, Part};
use crate::geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Octree, PolygonError, is_in_range};
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
    /// A position is NaN or infinite.
    #[error("position {position} of part {part} is not finite")]
    NotFinite {
        /// Index of the part.
        part: usize,
        /// Index of the position in the part.
        position: usize,
    },
    /// A position is beyond [`MAX_COORDINATE`].
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
    #[error("corner {corner} of part {part} is position {index}, but there are only {positions}")]
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
    /// A normal, a texture coordinate or a color is NaN or infinite.
    #[error("{what} of part {part} are not all finite")]
    AttributeNotFinite {
        /// Index of the part.
        part: usize,
        /// Name of the attribute.
        what: &'static str,
    },
    /// The corners do not form whole faces.
    #[error("the faces of part {part} do not use all of its {corners} corners")]
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
pub(super) struct Source {
    part: u32,
    start: u32,
    sides: u32,
}

pub(super) fn check(number: usize, part: &Part, faces: &mut Vec<Source>) -> Result<(), MeshError> {
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
    let is_far = |p: &[f32; 3]| !p.iter().all(|&value| is_in_range(value));
    if let Some(position) = part.positions.iter().position(is_far) {
        return Err(MeshError::TooFar {
            part: number,
            position,
        });
    }
    let positions = part.positions.len();
    part.attributes.check(number, positions)?;
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

pub(super) fn build(parts: &[Part], faces: Vec<Source>) -> Mesh {
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
        attributes: MeshAttributes::default(),
        corners: Vec::new(),
        starts: Vec::new(),
        neighbours: Vec::new(),
        clusters: Vec::new(),
        tree: Octree::build(&bounds, CLUSTER_FACES),
        below: Below::default(),
        bounds: bounds.iter().fold(Aabb::EMPTY, |sum, b| sum.union(b)),
    };
    // By position of the input: (cluster + 1, new index) of the last cluster that uses it.
    let mut placed: Vec<Vec<(u32, u32)>> = parts
        .iter()
        .map(|part| vec![(0, 0); part.positions.len()])
        .collect();
    // Part and index of each position of the mesh.
    let mut sources: Vec<(u32, u32)> = Vec::new();
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
                let (order, across) = in_order(run, |face| {
                    let positions = parts[faces[face as usize].part as usize].positions;
                    corners_of(&faces[face as usize])
                        .iter()
                        .map(|&index| positions[index as usize])
                });
                mesh.neighbours.extend(across);
                for face in order {
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
                            sources.push((source.part, index));
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
    mesh.attributes = MeshAttributes::gather(parts, &sources);
    if polygons {
        mesh.starts.push(mesh.corners.len() as u32);
    }
    mesh.below = Below::new(&tree, |cluster| mesh.triangles_in(cluster));
    mesh.tree = tree;
    mesh.neighbours.shrink_to_fit();
    mesh.positions.shrink_to_fit();
    mesh.corners.shrink_to_fit();
    mesh.clusters.shrink_to_fit();
    mesh
}

/// Orders the faces of a cluster so that neighbours are adjacent; also returns, for each corner, the face across its
/// edge.
fn in_order<I: Iterator<Item = [f32; 3]>>(run: &[u32], corners: impl Fn(u32) -> I) -> (Vec<u32>, Vec<u8>) {
    // Corners at the same position share a number, even if the input has the position twice.
    let mut places: SmallMap<(u32, u32, u32), u32> = SmallMap::default();
    places.reserve(2 * run.len());
    let mut number = |corner: [f32; 3]| {
        let next = places.len() as u32;
        let [x, y, z] = corner.map(|value| (value + 0.0).to_bits());
        *places.entry((x, y, z)).or_insert(next)
    };
    let numbered = run
        .iter()
        .map(|&face| corners(face).map(&mut number).collect())
        .collect::<Vec<Vec<u32>>>();
    let across = neighbours(&numbered);
    let order = neighbours_together(&across);
    let mut place = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old] = new as u8;
    }
    let renumbered = |&old: &u8| {
        if old == NONE {
            NONE
        } else {
            place[usize::from(old)]
        }
    };
    let across = order
        .iter()
        .flat_map(|&old| across[old].iter().map(renumbered))
        .collect();
    (order.into_iter().map(|old| run[old]).collect(), across)
}
