//! Meshes as bytes: what [`Mesh::new`] computes, to be read in place.
//!
//! What is large is stored as it is used: positions, corners, neighbours, attributes. Boxes follow from the positions, which
//! are read anyway to check them.
//! Layout, in little-endian words of 32 bits: [`Header`]; for each cluster its number of faces, its number of positions and its
//! material; for each node of the octree its centre, its first child, the mask of its children, and its number of clusters; then
//! positions, normals, texture coordinates, colors, corners, starts; and at last bytes: neighbours, and occluders.
//! Cost: reading is bound by memory; a few operations per position and corner.

use super::attributes::MeshAttributes;
use super::below::Below;
use super::build::CLUSTER_FACES;
use super::face_boxes::FaceBoxes;
use super::list::List;
use super::{Cluster, Mesh, NONE};
use crate::geom::{Aabb, ConvexPolygon, Octree, StoredNode, is_in_range};
use crate::ids::MaterialId;
use bytemuck::{Pod, Zeroable};
use bytes::Bytes;
use std::sync::OnceLock;
use thiserror::Error;

/// Why bytes are no mesh; returned by [`Mesh::from_bytes`]. Tells the broken rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct MeshDataError(&'static str);

/// What the bytes of a mesh begin with.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Header {
    positions: u32,
    corners: u32,
    /// Faces and one, or 0 if all are triangles.
    starts: u32,
    clusters: u32,
    nodes: u32,
    /// Bits: 1 normals, 2 texture coordinates, 4 colors, 8 no faces but a box.
    flags: u32,
    /// Length of the occluders, in bytes.
    occluders: u32,
    /// The box of a mesh without faces.
    bounds: [[f32; 3]; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct StoredCluster {
    faces: u32,
    positions: u32,
    material: u32,
}

const NORMALS: u32 = 1;
const TEXTURE: u32 = 2;
const COLORS: u32 = 4;
const BOUNDS_ONLY: u32 = 8;

/// Takes lists off bytes, one after another.
struct Reader {
    bytes: Bytes,
}

impl Reader {
    fn list<T: Pod + Send>(&mut self, count: usize) -> Result<List<T>, MeshDataError> {
        let length = count.saturating_mul(size_of::<T>());
        Ok(List::from_bytes(self.bytes(length)?))
    }

    fn bytes(&mut self, length: usize) -> Result<Bytes, MeshDataError> {
        if length > self.bytes.len() {
            return Err(MeshDataError("there are fewer bytes than the header says"));
        }
        Ok(self.bytes.split_to(length))
    }
}

impl Mesh {
    /// Returns the mesh as bytes for [`Mesh::from_bytes`]: a multiple of 4.
    ///
    /// Their format may change with each version of this crate: keep the version with them.
    pub fn to_bytes(&self) -> Vec<u8> {
        let attributes = &self.attributes;
        let flag = |flag, is_set| if is_set { flag } else { 0 };
        let is_box = self.face_count() == 0 && !self.clusters.is_empty();
        let header = Header {
            positions: self.positions.len() as u32,
            corners: self.corners.len() as u32,
            starts: self.starts.len() as u32,
            clusters: self.clusters.len() as u32,
            nodes: self.tree.node_count() as u32,
            flags: flag(NORMALS, !attributes.normals.is_empty())
                | flag(TEXTURE, !attributes.texture.is_empty())
                | flag(COLORS, !attributes.colors.is_empty())
                | flag(BOUNDS_ONLY, is_box),
            occluders: self.occluders.len() as u32,
            bounds: if is_box {
                [self.bounds.min, self.bounds.max]
            } else {
                [[0.0; 3]; 2]
            },
        };
        let clusters: Vec<StoredCluster> = (self.clusters.iter())
            .map(|cluster| StoredCluster {
                faces: cluster.faces.len() as u32,
                positions: cluster.positions.len() as u32,
                material: cluster.material.0,
            })
            .collect();
        let nodes = self.tree.stored();
        let mut bytes = bytemuck::bytes_of(&header).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(&clusters));
        bytes.extend_from_slice(bytemuck::cast_slice(&nodes));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.positions));
        bytes.extend_from_slice(bytemuck::cast_slice(&attributes.normals));
        bytes.extend_from_slice(bytemuck::cast_slice(&attributes.texture));
        bytes.extend_from_slice(bytemuck::cast_slice(&attributes.colors));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.corners));
        bytes.extend_from_slice(bytemuck::cast_slice(&self.starts));
        bytes.extend_from_slice(&self.neighbours);
        bytes.extend_from_slice(&self.occluders);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes
    }

    /// Number of bytes that [`Mesh::bytes_beside`] reads.
    pub const HEADER_BYTES: usize = size_of::<Header>();

    /// Estimates the memory that [`Mesh::from_bytes`] takes beside the bytes that it is given, from their beginning, in bytes:
    /// for readers that limit it. Returns 0 if they are too few to be a mesh.
    pub fn bytes_beside(beginning: &[u8]) -> u64 {
        /// A cluster with its box, the boxes of its faces, and its entry in the lists below nodes.
        const CLUSTER: u64 = (size_of::<Cluster>() + size_of::<OnceLock<FaceBoxes>>() + 16) as u64;
        /// A node with the range below it.
        const NODE: u64 = 64;
        let Some(header) = beginning.get(..Mesh::HEADER_BYTES) else {
            return 0;
        };
        let header: Header = bytemuck::pod_read_unaligned(header);
        // Lists grow by doubling.
        2 * (u64::from(header.clusters) * CLUSTER + u64::from(header.nodes) * NODE)
    }

    /// Reads a mesh from bytes that [`Mesh::to_bytes`] returned; equal to the mesh then, bit by bit. Where the bytes are aligned
    /// to 4, it uses them in place, and keeps them: give it a part of a file that is mapped into memory.
    ///
    /// Damaged bytes may be another mesh, but no look at it panics or takes for ever.
    ///
    /// # Errors
    /// Returns a [`MeshDataError`] if the bytes are no mesh, or the machine is big-endian.
    pub fn from_bytes(bytes: Bytes) -> Result<Mesh, MeshDataError> {
        if cfg!(target_endian = "big") {
            return Err(MeshDataError("this machine is big-endian, and the bytes are not"));
        }
        let mut reader = Reader { bytes };
        let header = reader.list::<Header>(1)?[0];
        let has = |flag: u32| header.flags & flag != 0;
        let stored = reader.list::<StoredCluster>(header.clusters as usize)?;
        let nodes = reader.list::<StoredNode>(header.nodes as usize)?;
        let count = header.positions as usize;
        let positions = reader.list::<[f32; 3]>(count)?;
        let attributes = MeshAttributes {
            normals: reader.list(if has(NORMALS) { count } else { 0 })?,
            texture: reader.list(if has(TEXTURE) { count } else { 0 })?,
            colors: reader.list(if has(COLORS) { count } else { 0 })?,
        };
        let corners = reader.list::<u32>(header.corners as usize)?;
        let starts = reader.list::<u32>(header.starts as usize)?;
        let neighbours = reader.list::<u8>(header.corners as usize)?;
        let occluders = reader.bytes(header.occluders as usize)?;
        if reader.bytes.len() >= 4 {
            return Err(MeshDataError("there are more bytes than the header says"));
        }
        let is_finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let MeshAttributes {
            normals,
            texture,
            colors,
        } = &attributes;
        if ![
            normals.as_flattened(),
            texture.as_flattened(),
            colors.as_flattened(),
        ]
        .into_iter()
        .all(is_finite)
        {
            return Err(MeshDataError("an attribute of a vertex is not finite"));
        }
        let mut mesh = Mesh {
            positions,
            attributes,
            corners,
            starts,
            neighbours,
            occluders,
            ..Mesh::nothing()
        };
        mesh.check_starts()?;
        if has(BOUNDS_ONLY) {
            let [min, max] = header.bounds;
            let bounds_only = Mesh::bounds_only(min, max);
            return bounds_only.map_err(|_| MeshDataError("the box of a mesh without faces has no volume"));
        }
        mesh.clusters = mesh.check_clusters(&stored)?;
        mesh.check_polygons()?;
        let bounds: Vec<Aabb> = mesh.clusters.iter().map(|cluster| cluster.bounds).collect();
        mesh.tree = Octree::restored(&nodes, &bounds).ok_or(MeshDataError(
            "the nodes of the octree are no tree over the clusters",
        ))?;
        mesh.below = Below::new(&mesh.tree, |cluster| mesh.triangles_in(cluster));
        mesh.face_boxes.resize_with(mesh.clusters.len(), OnceLock::new);
        mesh.bounds = bounds.iter().fold(Aabb::EMPTY, |sum, bounds| sum.union(bounds));
        Ok(mesh)
    }

    /// Checks that the corners are divided into whole faces.
    fn check_starts(&self) -> Result<(), MeshDataError> {
        let is_sound = match &*self.starts {
            [] => self.corners.len().is_multiple_of(3),
            [first, .., last] => {
                let are_faces = self
                    .starts
                    .windows(2)
                    .all(|ends| ends[0].saturating_add(3) <= ends[1]);
                *first == 0 && *last as usize == self.corners.len() && are_faces
            }
            [_] => false,
        };
        is_sound
            .then_some(())
            .ok_or(MeshDataError("the corners are no whole faces"))
    }

    /// Returns the clusters, one after another, with their boxes. Checks that their corners and neighbours are among them.
    fn check_clusters(&self, stored: &[StoredCluster]) -> Result<Vec<Cluster>, MeshDataError> {
        let (mut face, mut position) = (0, 0);
        let mut clusters = Vec::with_capacity(stored.len());
        for stored in stored {
            if stored.faces == 0 || stored.faces as usize > CLUSTER_FACES {
                return Err(MeshDataError("a cluster must have 1 to 128 faces"));
            }
            let [end, after] = [(face, stored.faces), (position, stored.positions)]
                .map(|(from, more): (u32, u32)| from.checked_add(more));
            let (Some(end), Some(after)) = (end, after) else {
                return Err(MeshDataError("there are fewer faces than the clusters have"));
            };
            if end > self.face_count() || after as usize > self.positions.len() {
                return Err(MeshDataError("there are fewer faces than the clusters have"));
            }
            let held = &self.positions[position as usize..after as usize];
            let (corners, _) = self.runs(face..end);
            if held.len() > corners.len()
                || !corners.iter().fold(true, |all, corner| {
                    all & (corner.wrapping_sub(position) < stored.positions)
                })
            {
                return Err(MeshDataError(
                    "a cluster has a corner that is not one of its positions",
                ));
            }
            let across = self.neighbours(face..end);
            if !across.iter().fold(true, |all, &other| {
                all & (u32::from(other) < stored.faces || other == NONE)
            }) {
                return Err(MeshDataError("a neighbour of a face is not in its cluster"));
            }
            let bounds = Aabb::of(held.iter().copied());
            if !held
                .as_flattened()
                .iter()
                .fold(true, |all, &value| all & is_in_range(value))
            {
                return Err(MeshDataError("a position is not finite, or too far out"));
            }
            clusters.push(Cluster {
                faces: face..end,
                positions: position..after,
                material: MaterialId(stored.material),
                bounds,
            });
            (face, position) = (end, after);
        }
        if face != self.face_count() || position as usize != self.positions.len() {
            return Err(MeshDataError("there are more faces than the clusters have"));
        }
        Ok(clusters)
    }

    /// Checks that faces of more than three corners are flat and convex.
    fn check_polygons(&self) -> Result<(), MeshDataError> {
        if self.starts.is_empty() {
            return Ok(());
        }
        for face in 0..self.face_count() {
            let corners = self.face(face);
            if corners.len() == 3 {
                continue;
            }
            let outline: Vec<[f32; 3]> = corners
                .iter()
                .map(|&corner| self.positions[corner as usize])
                .collect();
            ConvexPolygon::new(&outline).map_err(|_| MeshDataError("a face is not flat or not convex"))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;
    use crate::mesh::{Attributes, Indices, Part, Vertices};
    use crate::{GeometryBuilder, Material, Method, Scene, Transform, View, Viewer};
    use std::sync::Arc;

    /// A grid of quads and pairs of triangles, of two materials, bent along x.
    fn sheet(n: u32) -> Mesh {
        let place = |i: u32| {
            [
                (i % (n + 1)) as f32,
                (i / (n + 1)) as f32,
                ((i % (n + 1)) as f32).sin(),
            ]
        };
        let positions: Vec<[f32; 3]> = (0..(n + 1) * (n + 1)).map(place).collect();
        let texture: Vec<[f32; 2]> = positions.iter().map(|&[x, y, _]| [x, y]).collect();
        let [mut quads, mut triangles] = [const { Vec::new() }; 2];
        for i in (0..n * (n + 1)).filter(|i| i % (n + 1) < n) {
            let [a, b, c, d] = [i, i + 1, i + n + 2, i + n + 1];
            if i % 3 == 0 {
                quads.extend([a, b, c, d]);
            } else {
                triangles.extend([a, b, c, a, c, d]);
            }
        }
        let part = |corners, sides, material| Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(corners),
            sides,
            material: MaterialId(material),
            attributes: Attributes {
                texture: Vertices::Packed(&texture),
                ..Attributes::default()
            },
        };
        let sides = vec![4; quads.len() / 4];
        let parts = [part(&quads, Some(&sides[..]), 0), part(&triangles, None, 1)];
        Mesh::new(&parts[usize::from(n.is_multiple_of(2))..]).expect("a valid mesh")
    }

    fn materials() -> [Material; 2] {
        [Material::opaque([0.5; 3]); 2]
    }

    fn walked(mesh: &Mesh, eye: [f64; 3]) -> Vec<String> {
        let mut steps = Vec::new();
        mesh.walk(eye, |step| {
            steps.push(format!("{step:?}"));
            true
        });
        steps
    }

    #[test]
    fn a_mesh_that_is_read_is_the_one_that_was_written() {
        let bounds_only = Mesh::bounds_only([-1.0; 3], [1.0, 2.0, 3.0]).expect("a box");
        let empty = Mesh::new(&[]).expect("an empty mesh");
        let occluding = sheet(31).with_occluders(&materials());
        assert!(occluding.to_bytes().len() > sheet(31).to_bytes().len() + 100);
        for mesh in [sheet(1), sheet(30), sheet(31), occluding, empty, bounds_only] {
            let bytes = Bytes::from_owner(mesh.to_bytes());
            let read = Mesh::from_bytes(bytes.clone()).expect("sound bytes");
            assert_eq!(read.to_bytes(), bytes);
            let parts = |mesh: &Mesh| {
                let lists = (
                    mesh.positions.to_vec(),
                    mesh.corners.to_vec(),
                    mesh.starts.to_vec(),
                );
                (
                    lists,
                    mesh.neighbours.to_vec(),
                    mesh.texture().to_vec(),
                    mesh.clusters.clone(),
                    mesh.bounds,
                )
            };
            assert_eq!(parts(&read), parts(&mesh));
            assert_eq!(read.bytes(), mesh.bytes());
            for eye in [[-9.0, 4.0, 1.0], [9.0, 60.0, -3.0]] {
                assert_eq!(walked(&read, eye), walked(&mesh, eye));
            }
            let within = |list: &[u32]| bytes.as_ptr_range().contains(&list.as_ptr().cast());
            assert!(read.corners.is_empty() || within(&read.corners), "read in place");
        }
    }

    /// Looks at a mesh by methods that together use all that is stored. Returns whether a geometry takes it.
    fn look_at(mesh: Mesh) -> bool {
        let mut room = GeometryBuilder::new(materials());
        let mesh = room.mesh(mesh);
        room.item("damaged", mesh, Transform::IDENTITY);
        // A damaged material, or a place out of range, is an error of the geometry.
        let Ok(room) = room.build() else { return false };
        let room = Arc::new(room);
        let view = View::new([3.0, -2.0, 9.0], [3.0, 3.0, 0.0], [64, 48]).expect("a valid view");
        for method in [
            Method::Masked,
            Method::HierarchicalZ,
            Method::HierarchicalS,
            Method::Svbsp,
        ] {
            let scene = Scene::single(Arc::clone(&room), method).expect("a scene");
            Viewer::new().look(&scene, &view);
        }
        true
    }

    #[test]
    fn damaged_bytes_are_an_error_or_a_mesh_that_can_be_looked_at() {
        let mut dice = Dice::new(34);
        let [mut refused, mut read, mut looked] = [0; 3];
        for sound in [sheet(5), sheet(12)].map(|mesh| mesh.with_occluders(&materials()).to_bytes()) {
            for length in 0..sound.len() {
                assert!(
                    Mesh::from_bytes(Bytes::from(sound[..length].to_vec())).is_err()
                        || length + 4 > sound.len()
                );
            }
            for _ in 0..20_000 {
                let mut bytes = sound.clone();
                // Mostly in the lists that lead elsewhere, at the beginning.
                let end = if dice.roll() < 0.5 { 600 } else { bytes.len() };
                for _ in 0..1 + (3.0 * dice.roll()) as usize {
                    let place = (dice.roll() * end as f64) as usize;
                    let value =
                        [0, 1, 0x7F, 0x80, 0xFF, (256.0 * dice.roll()) as u8][(6.0 * dice.roll()) as usize];
                    bytes[place] = value;
                }
                match Mesh::from_bytes(Bytes::from_owner(bytes)) {
                    Ok(mesh) => {
                        read += 1;
                        assert!(
                            walked(&mesh, [3.0, -2.0, 5.0]).len()
                                <= 2 * mesh.clusters.len() + mesh.tree.node_count()
                        );
                        assert_eq!(mesh.triangle_indices().count() as u64, 3 * mesh.triangle_count());
                        if read % 8 == 0 {
                            looked += usize::from(look_at(mesh));
                        }
                    }
                    Err(_) => refused += 1,
                }
            }
        }
        assert!(
            refused > 5000 && read > 5000 && looked > 1000,
            "{refused}, {read}, {looked}"
        );
    }
}
