//! Merges several documents into one: appends every list, and shifts every index into it.

use super::raise::{INSTANCING, LIGHTS, Shift, raise};
use crate::BrokenRule;
use crate::gltf::compressed::COMPRESSION;
use crate::gltf::container;
use crate::images;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// The lists that are merged.
const LISTS: [&str; 11] = [
    "bufferViews",
    "accessors",
    "images",
    "samplers",
    "textures",
    "materials",
    "meshes",
    "cameras",
    "skins",
    "nodes",
    "animations",
];

/// Extensions that are kept, besides those of materials: they contain no indices, or only indices that `raise` shifts.
const TAKEN: [&str; 8] = [
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    INSTANCING,
    "KHR_texture_transform",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "EXT_texture_avif",
    "MSFT_texture_dds",
];

/// The merged document, and the bytes of its only buffer.
#[derive(Debug, Default)]
pub(super) struct Merged {
    lists: Map<String, Value>,
    lights: Vec<Value>,
    binary: Vec<u8>,
    used: BTreeSet<String>,
    required: BTreeSet<String>,
    left_out: BTreeSet<String>,
}

/// Reads the bytes of a URI; the second argument names the element for messages.
type Fetch<'f> = dyn FnMut(&str, &str) -> Result<Vec<u8>, BrokenRule> + 'f;

impl Merged {
    pub(super) fn count(&self, list: &str) -> usize {
        self.lists.get(list).and_then(Value::as_array).map_or(0, Vec::len)
    }

    pub(super) fn get(&self, list: &str, index: usize) -> &Value {
        &self.lists[list][index]
    }

    pub(super) fn get_mut(&mut self, list: &str, index: usize) -> &mut Value {
        &mut self.lists[list][index]
    }

    /// Returns the length of the buffer, in bytes.
    pub(super) fn buffer_bytes(&self) -> u64 {
        self.binary.len() as u64
    }

    /// Appends an element to a list and returns its index.
    pub(super) fn push(&mut self, list: &str, thing: Value) -> usize {
        let entry = self.lists.entry(list).or_insert_with(|| json!([]));
        let Some(things) = entry.as_array_mut() else {
            return 0;
        };
        things.push(thing);
        things.len() - 1
    }

    /// Appends bytes to the buffer and returns the index of their buffer view.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let start = self.append(bytes);
        self.push(
            "bufferViews",
            json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() }),
        )
    }

    /// Appends bytes to the buffer, aligned to 4, and returns their offset.
    fn append(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let start = self.binary.len();
        self.binary.extend_from_slice(bytes);
        start
    }

    /// Adds a mesh of one polygon and returns its index. Its corners are counter-clockwise when seen from the front.
    pub(super) fn polygon(&mut self, corners: &[[f32; 3]]) -> usize {
        let bytes: Vec<u8> = corners
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let view = self.view(&bytes);
        let end = |better: fn(f32, f32) -> f32, start: f32| {
            [0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).fold(start, better))
        };
        let positions = self.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": 5126, "type": "VEC3", "count": corners.len(),
                "min": end(f32::min, f32::INFINITY), "max": end(f32::max, f32::NEG_INFINITY),
            }),
        );
        // A triangle fan from the first corner; valid because the polygon is convex.
        let primitive = json!({ "attributes": { "POSITION": positions }, "mode": 6 });
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// Appends a validated document; returns why images could not be read, which become grey. `buffers` holds the bytes
    /// of used buffers; `decoded` those of compressed buffer views, which are stored uncompressed; `fetch` reads image
    /// files.
    pub(super) fn append_document(
        &mut self,
        mut json: Value,
        buffers: &[Option<&[u8]>],
        decoded: &BTreeMap<usize, &[u8]>,
        fetch: &mut Fetch,
    ) -> Result<Vec<String>, BrokenRule> {
        let starts: Vec<usize> = buffers
            .iter()
            .map(|bytes| bytes.map_or(0, |bytes| self.append(bytes)))
            .collect();
        let decoded: BTreeMap<usize, usize> = decoded
            .iter()
            .map(|(&view, bytes)| (view, self.append(bytes)))
            .collect();
        let mut missing = Vec::new();
        // Images in separate files become buffer views first, because the index shifts below depend on the number of
        // views.
        let mut images = Vec::new();
        for (number, image) in list(&json, "images").iter().enumerate() {
            let bytes = match image["uri"].as_str() {
                Some(uri) => match fetch(uri, &format!("image {number}")) {
                    Ok(bytes) => Some(bytes),
                    Err(why @ BrokenRule::TooLarge { .. }) => return Err(why),
                    Err(why) => {
                        missing.push(why.to_string());
                        Some(images::grey_png())
                    }
                },
                None => None,
            };
            images.push(bytes.map(|bytes| (self.view(&bytes), mime_type(&bytes))));
        }
        let shift = Shift(
            LISTS.iter().map(|list| (*list, self.count(list))).collect(),
            self.lights.len(),
        );
        self.take_extensions(&mut json);
        for name in LISTS {
            let mut things = match json.get_mut(name).map(Value::take) {
                Some(Value::Array(things)) => things,
                _ => continue,
            };
            for (number, thing) in things.iter_mut().enumerate() {
                match name {
                    "bufferViews" => {
                        let buffer = thing["buffer"].as_u64().unwrap_or(0) as usize;
                        let offset = thing["byteOffset"].as_u64().unwrap_or(0);
                        let start = starts.get(buffer).copied().unwrap_or(0) as u64;
                        let start = decoded
                            .get(&number)
                            .map_or(start.saturating_add(offset), |&start| start as u64);
                        thing["buffer"] = json!(0);
                        thing["byteOffset"] = json!(start);
                    }
                    "images" => match images.get(number) {
                        Some(Some((view, mime_type))) => {
                            let name = thing["name"].as_str().unwrap_or_default();
                            *thing = json!({ "name": name, "bufferView": view, "mimeType": mime_type });
                        }
                        _ => shift.raise(thing, "bufferView", "bufferViews"),
                    },
                    _ => raise(name, thing, &shift),
                }
            }
            for thing in things {
                self.push(name, thing);
            }
        }
        Ok(missing)
    }

    /// Keeps known extensions and removes the others, which may contain indices.
    fn take_extensions(&mut self, json: &mut Value) {
        let lights = json.pointer_mut(&format!("/extensions/{LIGHTS}/lights"));
        let lights = lights.and_then(Value::as_array_mut);
        self.lights.extend(lights.into_iter().flat_map(std::mem::take));
        for (key, into) in [
            ("extensionsUsed", &mut self.used),
            ("extensionsRequired", &mut self.required),
        ] {
            let names = list(json, key).iter().filter_map(Value::as_str);
            into.extend(names.filter(|name| is_taken(name)).map(str::to_owned));
        }
        if let Some(json) = json.as_object_mut() {
            json.remove("extensions");
        }
        // The buffer views are already uncompressed, so dropping the compression extensions loses nothing: they are not
        // reported.
        for name in ["buffers", "bufferViews"] {
            let things = json.get_mut(name).and_then(Value::as_array_mut);
            let extensions = things
                .into_iter()
                .flatten()
                .filter_map(|thing| thing.get_mut("extensions"));
            let extensions = extensions.filter_map(Value::as_object_mut);
            extensions.for_each(|each| each.retain(|name, _| !COMPRESSION.contains(&&**name)));
        }
        strip(json, &mut self.left_out);
    }

    /// Renames the nodes from index `first` on to `PART/NAME`, and the references to them in portals.
    pub(super) fn rename(&mut self, first: usize, part: &str) {
        let prefixed = |value: &mut Value| {
            if let Some(name) = value.as_str().filter(|name| !name.is_empty()) {
                *value = json!(format!("{part}/{name}"));
            }
        };
        for node in first..self.count("nodes") {
            let node = self.get_mut("nodes", node);
            if let Some(name) = node.get_mut("name") {
                prefixed(name);
            }
            for key in ["to", "exit"] {
                let named = node.pointer_mut(&format!("/extras/enfilade/{key}"));
                named.into_iter().for_each(prefixed);
            }
        }
    }

    /// Returns the document as a `.glb`, and the extensions that were left out; `None` if it exceeds the size limit of
    /// a `.glb`.
    pub(super) fn into_glb(mut self) -> Option<(Vec<u8>, Vec<String>)> {
        let mut document = std::mem::take(&mut self.lists);
        document.insert(
            "asset".to_owned(),
            json!({ "version": "2.0", "generator": "enfilade link" }),
        );
        document.insert("scene".to_owned(), json!(0));
        if !self.binary.is_empty() {
            document.insert("buffers".to_owned(), json!([{ "byteLength": self.binary.len() }]));
        }
        if !self.lights.is_empty() {
            document.insert(
                "extensions".to_owned(),
                json!({ LIGHTS: { "lights": self.lights } }),
            );
        }
        for (key, names) in [
            ("extensionsUsed", &self.used),
            ("extensionsRequired", &self.required),
        ] {
            if !names.is_empty() {
                document.insert(key.to_owned(), json!(names));
            }
        }
        let json = Value::Object(document).to_string();
        let glb = container::joined(json.as_bytes(), &self.binary)?;
        Some((glb, self.left_out.into_iter().collect()))
    }
}

fn list<'v>(json: &'v Value, key: &str) -> &'v [Value] {
    json.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn is_taken(extension: &str) -> bool {
    TAKEN.contains(&extension)
        || extension.starts_with("KHR_materials_") && extension != "KHR_materials_variants"
}

/// Removes all extensions that are not kept, recursively.
fn strip(value: &mut Value, left_out: &mut BTreeSet<String>) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| strip(value, left_out)),
        Value::Object(object) => {
            if let Some(Value::Object(extensions)) = object.get_mut("extensions") {
                extensions.retain(|name, _| {
                    let taken = is_taken(name);
                    if !taken {
                        left_out.insert(name.clone());
                    }
                    taken
                });
                if extensions.is_empty() {
                    object.remove("extensions");
                }
            }
            // `extras` are application data and stay unchanged.
            let others = object.iter_mut().filter(|(key, _)| *key != "extras");
            others.for_each(|(_, value)| strip(value, left_out));
        }
        _ => {}
    }
}

/// Returns the MIME type of an image by its first bytes.
fn mime_type(bytes: &[u8]) -> &'static str {
    if bytes.starts_with(b"\x89PNG") {
        "image/png"
    } else if bytes.get(8..12) == Some(b"WEBP") {
        "image/webp"
    } else if bytes.starts_with(b"\xABKTX 20") {
        "image/ktx2"
    } else {
        "image/jpeg"
    }
}
