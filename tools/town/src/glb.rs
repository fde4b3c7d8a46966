//! Writes the items of a tile as binary glTF.

use crate::material;
use crate::mesh::{Mesh, Part, STEPS};
use serde_json::{Value, json};

/// A glTF document under construction. Positions are f32, normals i8, indices u32; each item has its own mesh.
#[derive(Default)]
pub(crate) struct Document {
    nodes: Vec<Value>,
    meshes: Vec<Value>,
    accessors: Vec<Value>,
    positions: Vec<u8>,
    normals: Vec<u8>,
    indices: Vec<u8>,
}

/// The views of the buffer.
const POSITIONS: usize = 0;
const NORMALS: usize = 1;
const INDICES: usize = 2;

/// Origins of items are multiples of 1 / 16 m.
const ORIGIN: i32 = STEPS as i32 / 16;

impl Document {
    /// Adds an item; `corner` is the position of the tile in the town in metres.
    pub(crate) fn item(&mut self, name: &str, mesh: Mesh, corner: [u32; 2]) {
        let parts = mesh.into_parts();
        let all = || parts.iter().flat_map(|(_, part)| &part.positions);
        let [low, high] = [i32::min, i32::max].map(|end| {
            let ends =
                |found: [i32; 3], at: &[i32; 3]| std::array::from_fn(|axis| end(found[axis], at[axis]));
            all()
                .copied()
                .reduce(|found, at| ends(found, &at))
                .unwrap_or_default()
        });
        // The origin is on the ground below the middle, as a modeller would choose it.
        let middle = |axis: usize| (low[axis] + high[axis]) / 2 / ORIGIN * ORIGIN;
        let origin = [middle(0), low[1].div_euclid(ORIGIN) * ORIGIN, middle(2)];
        let primitives: Value = (parts.iter())
            .map(|(material, part)| self.primitive(*material as usize, part, origin))
            .collect();
        self.meshes.push(json!({"primitives": primitives}));
        let metres = origin.map(|steps| f64::from(steps) / STEPS);
        let [x, z] = corner.map(f64::from);
        self.nodes
            .push(json!({"name": name, "mesh": self.meshes.len() - 1,
            "translation": [metres[0] + x, metres[1], metres[2] + z]}));
    }

    fn primitive(&mut self, material: usize, part: &Part, origin: [i32; 3]) -> Value {
        let starts = [&self.positions, &self.normals, &self.indices].map(Vec::len);
        let [mut low, mut high] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for position in &part.positions {
            for axis in 0..3 {
                let metres = (position[axis] - origin[axis]) as f32 / STEPS as f32;
                low[axis] = low[axis].min(metres);
                high[axis] = high[axis].max(metres);
                self.positions.extend(metres.to_le_bytes());
            }
        }
        for [x, y, z] in &part.normals {
            // Vertices start at multiples of four bytes.
            self.normals.extend([*x, *y, *z, 0].map(|part| part as u8));
        }
        for index in &part.indices {
            self.indices.extend(index.to_le_bytes());
        }
        let vertices = part.positions.len();
        let position = self.accessor(json!({"bufferView": POSITIONS, "byteOffset": starts[0],
            "componentType": 5126, "type": "VEC3", "count": vertices, "min": low, "max": high}));
        let normal = self.accessor(json!({"bufferView": NORMALS, "byteOffset": starts[1],
            "componentType": 5120, "normalized": true, "type": "VEC3", "count": vertices}));
        let index = self.accessor(json!({"bufferView": INDICES, "byteOffset": starts[2],
            "componentType": 5125, "type": "SCALAR", "count": part.indices.len()}));
        json!({"material": material, "attributes": {"POSITION": position, "NORMAL": normal}, "indices": index})
    }

    fn accessor(&mut self, accessor: Value) -> usize {
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Adds a camera that looks along +z.
    pub(crate) fn camera(&mut self, name: &str, at: [f64; 3]) {
        self.nodes
            .push(json!({"name": name, "camera": 0, "translation": at, "rotation": [0, 1, 0, 0]}));
    }

    /// Returns the bytes of the file.
    pub(crate) fn into_glb(self) -> Vec<u8> {
        let [positions, normals, indices] = [&self.positions, &self.normals, &self.indices].map(Vec::len);
        let length = positions + normals + indices;
        let nodes: Vec<usize> = (0..self.nodes.len()).collect();
        let json = json!({
            "asset": {"version": "2.0", "generator": "enfilade town"},
            "extensionsUsed": ["KHR_mesh_quantization"],
            "extensionsRequired": ["KHR_mesh_quantization"],
            "scene": 0,
            "scenes": [{"nodes": nodes}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": material::all(),
            "cameras": [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.05}}],
            "accessors": self.accessors,
            "bufferViews": [
                {"buffer": 0, "byteOffset": 0, "byteLength": positions, "byteStride": 12, "target": 34962},
                {"buffer": 0, "byteOffset": positions, "byteLength": normals, "byteStride": 4, "target": 34962},
                {"buffer": 0, "byteOffset": positions + normals, "byteLength": indices, "target": 34963},
            ],
            "buffers": [{"byteLength": length}],
        });
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = Vec::with_capacity(28 + json.len() + length);
        glb.extend(b"glTF");
        let total = 28 + json.len() + length;
        glb.extend(
            [2, total as u32, json.len() as u32]
                .map(u32::to_le_bytes)
                .as_flattened(),
        );
        glb.extend(b"JSON");
        glb.extend(json);
        glb.extend((length as u32).to_le_bytes());
        glb.extend(b"BIN\0");
        glb.extend(self.positions);
        glb.extend(self.normals);
        glb.extend(self.indices);
        glb
    }
}
