//! A small glTF writer, and helpers for what was read.

use enfilade::ItemIndex;
use enfilade_import::{Import, ReadOptions, read_bytes};
use serde_json::{Value, json};

/// A glTF file in the making: its JSON, and the bytes of its one buffer.
#[derive(Clone)]
pub(crate) struct File {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl File {
    /// A file with nothing in it.
    pub(crate) fn empty() -> File {
        let json = json!({
            "asset": { "version": "2.0" },
            "nodes": [], "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{ "byteLength": 0 }]
        });
        File {
            json,
            bytes: Vec::new(),
        }
    }

    /// One node, `Leaf`, with one triangle from (0, 0, 0) to (1, 0, 0) to (0, 1, 0).
    pub(crate) fn leaf() -> File {
        let mut file = File::empty();
        let primitive = file.primitive(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[0, 1, 2]);
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "name": "Leaf", "mesh": mesh }));
        file
    }

    /// Adds a primitive over its own positions, with 16-bit indices.
    pub(crate) fn primitive(&mut self, positions: &[[f32; 3]], indices: &[u16]) -> Value {
        let positions = self.positions(positions);
        let indices = self.indices(
            5123,
            indices.len(),
            indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
        );
        json!({ "attributes": { "POSITION": positions }, "indices": indices })
    }

    /// Adds an accessor of positions and says its number.
    pub(crate) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let bytes = positions
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": 5126, "type": "VEC3", "count": positions.len()
            }),
        )
    }

    /// Adds an accessor of indices of a component type and says its number.
    pub(crate) fn indices(&mut self, component: u32, count: usize, bytes: Vec<u8>) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "type": "SCALAR", "count": count
            }),
        )
    }

    /// Adds an accessor of floats and returns its index.
    pub(crate) fn floats(&mut self, values: &[f32], each: usize) -> usize {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let shape = ["SCALAR", "VEC2", "VEC3", "VEC4"][each - 1];
        self.accessor(5126, shape, values.len() / each, bytes)
    }

    /// Adds an accessor of anything and says its number.
    pub(crate) fn accessor(&mut self, component: u32, shape: &str, count: usize, bytes: Vec<u8>) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": shape, "count": count }),
        )
    }

    /// Adds a material that all of the first primitive is made of, and says its number.
    pub(crate) fn material(&mut self, material: Value) -> usize {
        let number = self.push("materials", material);
        self.json["meshes"][0]["primitives"][0]["material"] = json!(number);
        number
    }

    /// Gives the corners of the first primitive something to carry.
    pub(crate) fn carry(&mut self, attribute: &str, accessor: usize) {
        self.json["meshes"][0]["primitives"][0]["attributes"][attribute] = json!(accessor);
    }

    /// Adds an image in the buffer and a texture of it, and says the texture's number.
    pub(crate) fn texture(&mut self, bytes: Vec<u8>) -> usize {
        let view = self.view(bytes);
        let image = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.push("textures", json!({ "source": image }))
    }

    /// Adds bytes to the buffer and says the number of their view.
    pub(crate) fn view(&mut self, bytes: Vec<u8>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bytes.len());
        self.push("bufferViews", view)
    }

    /// Adds a mesh of some primitives and says its number.
    pub(crate) fn mesh(&mut self, primitives: Value) -> usize {
        self.push("meshes", json!({ "primitives": primitives }))
    }

    /// Adds a node and says its number.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        self.push("nodes", node)
    }

    /// Adds anything to a list of the document and says its number.
    pub(crate) fn push(&mut self, list: &str, thing: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(thing);
        list.len() - 1
    }

    /// The file as `.gltf`, with the buffer at `uri`.
    pub(crate) fn gltf(&self, uri: &str) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["uri"] = json!(uri);
        json.to_string().into_bytes()
    }

    /// The file as `.glb`.
    pub(crate) fn glb(&self) -> Vec<u8> {
        glb(&self.json.to_string(), &self.bytes)
    }
}

/// A PNG of some texels in rows.
pub(crate) fn png(size: [u32; 2], texel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    image::RgbaImage::from_fn(size[0], size[1], |x, y| image::Rgba(texel(x, y)))
        .write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png)
        .expect("into memory");
    bytes
}

/// A leaf with a texture of four texels, red, green, blue and white, and places in it: (0, 0), (1, 0) and (0, 1).
pub(crate) fn textured_leaf() -> File {
    let mut file = File::leaf();
    let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]];
    let texture = file.texture(png([2, 2], |x, y| texels[(2 * y + x) as usize]));
    file.material(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    let places = file.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0], 2);
    file.carry("TEXCOORD_0", places);
    file
}

/// Returns the attributes of the vertices of the first mesh at (0, 0, 0), (1, 0, 0) and (0, 1, 0), in that order.
pub(crate) fn carried<const N: usize>(
    import: &Import,
    list: impl Fn(&enfilade::Mesh) -> &[[f32; N]],
) -> Vec<[f32; N]> {
    let mesh = &import.rooms[0].geometry.meshes()[0];
    if list(mesh).is_empty() {
        return Vec::new();
    }
    let at = |place: [f32; 3]| {
        let corner = mesh.positions().iter().position(|&position| position == place);
        list(mesh)[corner.expect("a corner of the leaf")]
    };
    [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(at).to_vec()
}

/// The first material that is drawn.
pub(crate) fn material(import: &Import) -> enfilade::Material {
    let geometry = &import.rooms[0].geometry;
    *geometry.material(&geometry.meshes()[0].clusters()[0])
}

/// A `.glb` of any JSON text.
pub(crate) fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, bytes, padding) in [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", binary, 0)] {
        let size = bytes.len().next_multiple_of(4);
        file.extend((size as u32).to_le_bytes());
        file.extend(kind);
        file.extend(bytes);
        file.extend(std::iter::repeat_n(padding, size - bytes.len()));
    }
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    file
}

/// The text of the error that reading gives, or nothing where there is none.
pub(crate) fn refusal(bytes: &[u8]) -> Option<String> {
    read_bytes(bytes, None, &ReadOptions::default())
        .err()
        .map(|error| error.to_string())
}

/// Asserts that reading fails with an error that contains all `words`.
#[track_caller]
pub(crate) fn refuses(file: &File, words: &[&str]) {
    let text = refusal(&file.glb()).expect("it is refused");
    for word in words {
        assert!(text.contains(word), "`{text}` does not say `{word}`");
    }
}

/// Reads a valid file.
#[track_caller]
pub(crate) fn reads(file: &File) -> Import {
    read_bytes(&file.glb(), None, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Every triangle, item by item, as `Leaf 0,0,0 1,0,0 0,1,0`: corners in world space, the least first, then round.
pub(crate) fn triangles(import: &Import) -> Vec<String> {
    let geometry = &import.rooms[0].geometry;
    let mut lines = Vec::new();
    for number in 0..geometry.items().len() as u32 {
        let item = ItemIndex(number);
        let mesh = geometry.mesh_of(item);
        let place = geometry.item(item).transform();
        for face in 0..mesh.face_count() {
            let corner = |&index: &u32| place.point(mesh.positions()[index as usize]).map(rounded);
            let mut corners: Vec<[f32; 3]> = mesh.face(face).iter().map(corner).collect();
            let least =
                (0..corners.len()).min_by(|&a, &b| corners[a].partial_cmp(&corners[b]).expect("finite"));
            corners.rotate_left(least.expect("three corners"));
            let corners: Vec<String> = corners.iter().map(|[x, y, z]| format!("{x},{y},{z}")).collect();
            lines.push(format!("{} {}", geometry.name(item), corners.join(" ")));
        }
    }
    lines.sort();
    lines
}

/// To a millionth, since a turn by numbers out of JSON is not quite a quarter turn; never −0.
fn rounded(value: f32) -> f32 {
    ((f64::from(value) * 1e6).round() / 1e6 + 0.0) as f32
}

/// The texts of all warnings.
pub(crate) fn warnings(import: &Import) -> Vec<String> {
    import.warnings.iter().map(ToString::to_string).collect()
}
