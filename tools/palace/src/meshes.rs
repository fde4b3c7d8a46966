//! Meshes as streams of numbers that meshoptimizer compresses, shared by all primitives.
//!
//! Walls, floors and everything else that bounds rooms keep their f32 positions. The positions of ornament are rounded
//! to a grid: multiples of a power of two, which the exponential filter stores exactly. So objects need no transform
//! that scales them back, and vertices of one position stay at one position.

use crate::document::{Document, numbers};
use anyhow::Result;
use enfilade::{Material, Mesh, Texture, Wrap};
use glam::Vec3;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::collections::HashMap;
use std::sync::Arc;

/// Grid of ornament: at most 2⁻¹¹ (half a millimetre), and at most 2⁻¹² of the size of the mesh.
const COARSEST: i32 = -11;
const STEPS: i32 = 12;
/// Grid of texture coordinates, in repetitions of the texture.
const TEXTURE_GRID: i32 = -11;
const NORMAL_BITS: i32 = 8;

/// The streams, and the accessors that refer to them.
#[derive(Default)]
pub(crate) struct Streams {
    exact: Vec<[f32; 3]>,
    rounded: Vec<[i32; 3]>,
    normals: Vec<[u8; 4]>,
    exact_normals: Vec<[f32; 3]>,
    texture: Vec<[i32; 2]>,
    indices: Vec<u32>,
    /// For each accessor, its stream.
    accessors: Vec<(Stream, Value)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stream {
    Exact,
    Rounded,
    Normals,
    ExactNormals,
    Texture,
    Indices,
}

/// A vertex, comparable bit by bit.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
struct Vertex {
    position: [u32; 3],
    normal: [u32; 3],
    texture: [u32; 2],
}

/// How exactly a mesh is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Grid {
    /// All bits of positions and normals.
    Exact,
    /// All bits of positions.
    Shell,
    Rounded,
}

impl Streams {
    /// Adds the meshes of one glTF mesh, as one primitive for each material. Returns the glTF mesh.
    pub(crate) fn mesh(
        &mut self,
        meshes: &[Arc<Mesh>],
        grid: Grid,
        materials: &[Material],
        textures: &[Arc<Texture>],
    ) -> Value {
        let mut by_material: BTreeMap<u32, Vec<(usize, u32)>> = BTreeMap::new();
        for (number, mesh) in meshes.iter().enumerate() {
            for cluster in mesh.clusters() {
                let faces = cluster.faces.clone().map(|face| (number, face));
                by_material.entry(cluster.material.0).or_default().extend(faces);
            }
        }
        let positions = || {
            meshes
                .iter()
                .flat_map(|mesh| mesh.positions())
                .map(|&p| Vec3::from(p))
        };
        let (min, max) = positions().fold((Vec3::MAX, Vec3::MIN), |(min, max), p| (min.min(p), max.max(p)));
        let power = |size: f32| size.max(1e-9).log2().ceil() as i32;
        // 23 bits hold the integers, so a small mesh far from its origin gets a coarser grid.
        let exponent = (power((max - min).max_element()) - STEPS)
            .min(COARSEST)
            .max(power(min.abs().max(max.abs()).max_element()) - 22);
        let ends: [[i32; 2]; 3] = std::array::from_fn(|axis| {
            let [low, high] = [min, max].map(|end| f64::from(end[axis]) * 2.0_f64.powi(-exponent));
            [low.ceil() as i32, high.floor() as i32]
        });
        // What is flat between two lines of the grid stays where it is.
        let is_between = ends.iter().any(|[low, high]| low > high);
        let grid = match grid {
            Grid::Rounded if is_between => Grid::Shell,
            grid => grid,
        };
        let mut primitives = Vec::new();
        for (material, faces) in by_material {
            let wrap = materials[material as usize]
                .texture
                .map(|t| textures[t.0 as usize].wrap);
            let has_texture = wrap.is_some() && meshes.iter().all(|mesh| !mesh.texture().is_empty());
            let mut corners: Vec<Vertex> = Vec::new();
            let mut smooth = false;
            for &(mesh, face) in &faces {
                let mesh = &meshes[mesh];
                let face = mesh.face(face);
                let at = |corner: u32| Vec3::from(mesh.positions()[corner as usize]);
                let flat: Vec3 = (1..face.len() - 1)
                    .map(|i| (at(face[i]) - at(face[0])).cross(at(face[i + 1]) - at(face[0])))
                    .sum();
                let flat = flat.normalize_or(Vec3::Y);
                let vertex = |corner: u32| {
                    let own = mesh
                        .normals()
                        .get(corner as usize)
                        .copied()
                        .map_or(Vec3::ZERO, Vec3::from);
                    let normal = if own == Vec3::ZERO { flat } else { own };
                    let texture = mesh.texture().get(corner as usize).copied().unwrap_or_default();
                    let position = Vec3::from(mesh.positions()[corner as usize]);
                    let position = std::array::from_fn(|axis| match grid {
                        // Inwards at the ends, so that nothing reaches out of its room.
                        Grid::Rounded => {
                            let [low, high] = ends[axis];
                            rounded(position[axis], exponent).max(low).min(high) as u32
                        }
                        _ => sound(position[axis]).to_bits(),
                    });
                    let vertex = Vertex {
                        position,
                        normal: (normal + Vec3::ZERO).to_array().map(f32::to_bits),
                        texture: if has_texture {
                            texture.map(f32::to_bits)
                        } else {
                            [0; 2]
                        },
                    };
                    (vertex, own != Vec3::ZERO)
                };
                for i in 1..face.len() - 1 {
                    for corner in [0, i, i + 1] {
                        let (vertex, is_smooth) = vertex(face[corner]);
                        smooth |= is_smooth;
                        corners.push(vertex);
                    }
                }
            }
            // Without normals, faces are flat.
            if !smooth {
                corners.iter_mut().for_each(|corner| corner.normal = [0; 3]);
            }
            if has_texture && wrap == Some([Wrap::Repeat; 2]) {
                near_zero(&mut corners);
            }
            // Rounded before equal vertices are merged: faces of one plane get the same normal.
            for corner in &mut corners {
                corner.texture =
                    (corner.texture).map(|bits| rounded(f32::from_bits(bits), TEXTURE_GRID) as u32);
            }
            if smooth && grid != Grid::Exact {
                let normals = corners.iter().map(|corner| corner.normal.map(f32::from_bits));
                let normals: Vec<[f32; 4]> = normals.map(|[x, y, z]| [x, y, z, 0.0]).collect();
                let encoded = meshopt::encode_filter_oct::<i8>(&normals, NORMAL_BITS);
                for (corner, normal) in corners.iter_mut().zip(encoded) {
                    corner.normal = [i32::from_le_bytes(normal.map(|part| part as u8)) as u32, 0, 0];
                }
            }
            let mut numbers = HashMap::new();
            let mut vertices: Vec<Vertex> = Vec::new();
            let mut indices: Vec<u32> = Vec::with_capacity(corners.len());
            for corner in corners {
                indices.push(*numbers.entry(corner).or_insert_with(|| {
                    vertices.push(corner);
                    vertices.len() as u32 - 1
                }));
            }
            if grid != Grid::Exact {
                meshopt::optimize_vertex_cache_strip_in_place(&mut indices, vertices.len());
            }
            let vertices = meshopt::optimize_vertex_fetch(&mut indices, &vertices);
            primitives.push(self.primitive(
                material,
                grid,
                exponent,
                &vertices,
                &indices,
                smooth,
                has_texture,
            ));
        }
        json!({"primitives": primitives})
    }

    #[expect(clippy::too_many_arguments, reason = "a primitive has as many properties")]
    fn primitive(
        &mut self,
        material: u32,
        grid: Grid,
        exponent: i32,
        vertices: &[Vertex],
        indices: &[u32],
        smooth: bool,
        textured: bool,
    ) -> Value {
        let count = vertices.len();
        let mut primitive = json!({"material": material, "attributes": {}});
        let (stream, position): (_, fn(u32, i32) -> f32) = match grid {
            Grid::Rounded => (Stream::Rounded, |bits, exponent| {
                bits as i32 as f32 * 2.0_f32.powi(exponent)
            }),
            _ => (Stream::Exact, |bits, _| f32::from_bits(bits)),
        };
        let placed = vertices
            .iter()
            .map(|v| Vec3::from(v.position.map(|bits| position(bits, exponent))));
        let (min, max) = placed.fold((Vec3::MAX, Vec3::MIN), |(min, max), p| (min.min(p), max.max(p)));
        let before = match stream {
            Stream::Rounded => self.rounded.len(),
            _ => self.exact.len(),
        };
        let start = 12 * before;
        for vertex in vertices {
            match stream {
                Stream::Rounded => {
                    let packed = |bits: u32| (exponent << 24) | (bits as i32 & 0xFF_FFFF);
                    self.rounded.push(vertex.position.map(packed));
                }
                _ => self.exact.push(vertex.position.map(f32::from_bits)),
            }
        }
        primitive["attributes"]["POSITION"] = self.accessor(
            stream,
            json!({"byteOffset": start, "componentType": 5126, "type": "VEC3", "count": count,
                "min": numbers(&min.to_array()), "max": numbers(&max.to_array())}),
        );
        if smooth {
            primitive["attributes"]["NORMAL"] = if grid == Grid::Exact {
                let start = 12 * self.exact_normals.len();
                self.exact_normals
                    .extend(vertices.iter().map(|v| v.normal.map(f32::from_bits)));
                self.accessor(
                    Stream::ExactNormals,
                    json!({"byteOffset": start, "componentType": 5126, "type": "VEC3", "count": count}),
                )
            } else {
                let start = 4 * self.normals.len();
                self.normals
                    .extend(vertices.iter().map(|v| v.normal[0].to_le_bytes()));
                self.accessor(
                    Stream::Normals,
                    json!({"byteOffset": start, "componentType": 5120, "normalized": true, "type": "VEC3", "count": count}),
                )
            };
        }
        if textured {
            let start = 8 * self.texture.len();
            let packed = |bits: u32| (TEXTURE_GRID << 24) | (bits as i32 & 0xFF_FFFF);
            self.texture
                .extend(vertices.iter().map(|v| v.texture.map(packed)));
            primitive["attributes"]["TEXCOORD_0"] = self.accessor(
                Stream::Texture,
                json!({"byteOffset": start, "componentType": 5126, "type": "VEC2", "count": count}),
            );
        }
        let start = 2 * self.indices.len();
        assert!(count < 1 << 16, "a primitive has 16-bit indices");
        self.indices.extend(indices);
        primitive["indices"] = self.accessor(
            Stream::Indices,
            json!({"byteOffset": start, "componentType": 5123, "type": "SCALAR", "count": indices.len()}),
        );
        primitive
    }

    fn accessor(&mut self, stream: Stream, accessor: Value) -> Value {
        self.accessors.push((stream, accessor));
        json!(self.accessors.len() - 1)
    }

    /// Adds an opening: a flat convex polygon. Returns the glTF mesh.
    pub(crate) fn polygon(&mut self, outline: &[[f32; 3]]) -> Value {
        let vertices: Vec<Vertex> = (outline.iter())
            .map(|corner| Vertex {
                position: corner.map(|value| sound(value).to_bits()),
                ..Vertex::default()
            })
            .collect();
        let fan = |i: u32| [0, i, i + 1];
        let indices: Vec<u32> = (1..outline.len() as u32 - 1).flat_map(fan).collect();
        let mut primitive = self.primitive(0, Grid::Shell, 0, &vertices, &indices, false, false);
        primitive
            .as_object_mut()
            .map(|primitive| primitive.remove("material"));
        json!({"primitives": [primitive]})
    }

    /// Compresses the streams and writes them.
    pub(crate) fn write(self, document: &mut Document) -> Result<()> {
        let streams = [
            (
                Stream::Exact,
                vertices(&self.exact)?,
                [self.exact.len(), 12],
                "NONE",
            ),
            (
                Stream::Rounded,
                vertices(&self.rounded)?,
                [self.rounded.len(), 12],
                "EXPONENTIAL",
            ),
            (
                Stream::Normals,
                vertices(&self.normals)?,
                [self.normals.len(), 4],
                "OCTAHEDRAL",
            ),
            (
                Stream::ExactNormals,
                vertices(&self.exact_normals)?,
                [self.exact_normals.len(), 12],
                "NONE",
            ),
            (
                Stream::Texture,
                vertices(&self.texture)?,
                [self.texture.len(), 8],
                "EXPONENTIAL",
            ),
            (
                Stream::Indices,
                meshopt::encode_index_buffer(&self.indices, 1 << 16)?,
                [self.indices.len(), 2],
                "NONE",
            ),
        ];
        let mut views = BTreeMap::new();
        for (stream, bytes, shape, filter) in streams {
            println!("{stream:?}: {} elements, {} bytes", shape[0], bytes.len());
            let mode = if stream == Stream::Indices {
                "TRIANGLES"
            } else {
                "ATTRIBUTES"
            };
            views.insert(stream, document.compressed(&bytes, shape, mode, filter));
        }
        refer(self.accessors, &views, document);
        Ok(())
    }

    /// Writes the streams as readers without extensions need them: decoded, and all numbers of vertices as f32.
    pub(crate) fn write_plain(mut self, document: &mut Document) {
        let power_of_two = |packed: i32| {
            let mantissa = (packed << 8) >> 8;
            mantissa as f32 * 2.0_f32.powi(packed >> 24)
        };
        let rounded: Vec<f32> = self.rounded.iter().flatten().copied().map(power_of_two).collect();
        let texture: Vec<f32> = self.texture.iter().flatten().copied().map(power_of_two).collect();
        let mut normals: Vec<[i8; 4]> = self
            .normals
            .iter()
            .map(|normal| normal.map(|part| part as i8))
            .collect();
        meshopt::decode_filter_oct(&mut normals);
        let normals = normals.iter().flat_map(|&[x, y, z, _]| {
            let normal = Vec3::new(x.into(), y.into(), z.into());
            normal.normalize().to_array()
        });
        let floats: [(Stream, Vec<f32>); 5] = [
            (Stream::Exact, self.exact.into_flattened()),
            (Stream::Rounded, rounded),
            (Stream::Normals, normals.collect()),
            (Stream::ExactNormals, self.exact_normals.into_flattened()),
            (Stream::Texture, texture),
        ];
        let bytes =
            floats.map(|(stream, values)| (stream, values.into_iter().flat_map(f32::to_le_bytes).collect()));
        let indices = self
            .indices
            .iter()
            .flat_map(|&index| (index as u16).to_le_bytes());
        let views = bytes
            .into_iter()
            .chain([(Stream::Indices, indices.collect())])
            .map(|(stream, bytes): (Stream, Vec<u8>)| (stream, document.view(&bytes)))
            .collect();
        for (stream, accessor) in &mut self.accessors {
            if *stream == Stream::Normals {
                let start = accessor["byteOffset"].as_u64().expect("set above");
                accessor["byteOffset"] = json!(start * 3);
                accessor["componentType"] = json!(5126);
                accessor["normalized"] = json!(false);
            }
        }
        refer(self.accessors, &views, document);
    }
}

/// Writes the accessors, which refer to the views of their streams.
fn refer(accessors: Vec<(Stream, Value)>, views: &BTreeMap<Stream, usize>, document: &mut Document) {
    for (stream, mut accessor) in accessors {
        accessor["bufferView"] = json!(views[&stream]);
        if accessor["byteOffset"] == json!(0) {
            accessor
                .as_object_mut()
                .map(|accessor| accessor.remove("byteOffset"));
        }
        document.push("accessors", accessor);
    }
}

/// Returns a coordinate with 0 for what rounding left of it.
fn sound(value: f32) -> f32 {
    if value.abs() < 1e-9 { 0.0 } else { value }
}

/// Returns the multiple of a power of two that is nearest to a value.
fn rounded(value: f32, exponent: i32) -> i32 {
    (f64::from(value) * 2.0_f64.powi(-exponent)).round() as i32
}

/// Compresses vertices in the version of the codec that EXT_meshopt_compression allows.
fn vertices<T>(elements: &[T]) -> Result<Vec<u8>> {
    Ok(meshopt::encode_vertex_buffer_level(elements, 2, Some(0))?)
}

/// Moves repeating texture coordinates by whole repetitions, so that the smallest is between 0 and 1.
fn near_zero(corners: &mut [Vertex]) {
    for axis in 0..2 {
        let values = corners.iter().map(|corner| f32::from_bits(corner.texture[axis]));
        let low = values.fold(f32::INFINITY, f32::min).floor();
        for corner in corners.iter_mut() {
            corner.texture[axis] = (f32::from_bits(corner.texture[axis]) - low).to_bits();
        }
    }
}
