//! Shifts the indices by which elements of a document reference others, so that its lists can be appended to those of
//! another.

use serde_json::{Value, json};

/// The extension whose lights form another list.
pub(super) const LIGHTS: &str = "KHR_lights_punctual";

/// The extension whose attributes are accessor indices.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Index offsets of one document: one per list, and one for the lights.
pub(super) struct Shift(pub(super) Vec<(&'static str, usize)>, pub(super) usize);

impl Shift {
    pub(super) fn of(&self, list: &str) -> usize {
        if list == LIGHTS {
            return self.1;
        }
        let found = self.0.iter().find(|(name, _)| *name == list);
        found.map_or(0, |(_, shift)| *shift)
    }

    /// Shifts the index at `key`, if there is one.
    pub(super) fn raise(&self, thing: &mut Value, key: &str, list: &str) {
        if let Some(value) = thing.get_mut(key) {
            self.raise_number(value, list);
        }
    }

    fn raise_number(&self, value: &mut Value, list: &str) {
        if let Some(number) = value.as_u64() {
            *value = json!(number.saturating_add(self.of(list) as u64));
        }
    }

    fn raise_all(&self, thing: &mut Value, key: &str, list: &str) {
        let values = thing.get_mut(key).and_then(Value::as_array_mut);
        values
            .into_iter()
            .flatten()
            .for_each(|value| self.raise_number(value, list));
    }
}

/// Shifts every index in an element. Source: glTF 2.0 Specification, properties reference.
pub(super) fn raise(list: &str, thing: &mut Value, shift: &Shift) {
    match list {
        "accessors" => {
            shift.raise(thing, "bufferView", "bufferViews");
            for part in ["indices", "values"] {
                if let Some(part) = thing.pointer_mut(&format!("/sparse/{part}")) {
                    shift.raise(part, "bufferView", "bufferViews");
                }
            }
        }
        "textures" => {
            shift.raise(thing, "source", "images");
            shift.raise(thing, "sampler", "samplers");
            let extensions = thing.get_mut("extensions").and_then(Value::as_object_mut);
            for (_, extension) in extensions.into_iter().flatten() {
                shift.raise(extension, "source", "images");
            }
        }
        "materials" => raise_textures(thing, shift),
        "meshes" => {
            let primitives = thing.get_mut("primitives").and_then(Value::as_array_mut);
            for primitive in primitives.into_iter().flatten() {
                shift.raise(primitive, "indices", "accessors");
                shift.raise(primitive, "material", "materials");
                let targets = primitive.get_mut("targets").and_then(Value::as_array_mut);
                targets
                    .into_iter()
                    .flatten()
                    .for_each(|target| raise_each(target, shift));
                primitive
                    .get_mut("attributes")
                    .into_iter()
                    .for_each(|each| raise_each(each, shift));
            }
        }
        "skins" => {
            shift.raise(thing, "inverseBindMatrices", "accessors");
            shift.raise(thing, "skeleton", "nodes");
            shift.raise_all(thing, "joints", "nodes");
        }
        "nodes" => {
            shift.raise(thing, "mesh", "meshes");
            shift.raise(thing, "camera", "cameras");
            shift.raise(thing, "skin", "skins");
            shift.raise_all(thing, "children", "nodes");
            if let Some(light) = thing.pointer_mut(&format!("/extensions/{LIGHTS}")) {
                shift.raise(light, "light", LIGHTS);
            }
            if let Some(attributes) = thing.pointer_mut(&format!("/extensions/{INSTANCING}/attributes")) {
                raise_each(attributes, shift);
            }
        }
        "animations" => {
            let samplers = thing.get_mut("samplers").and_then(Value::as_array_mut);
            for sampler in samplers.into_iter().flatten() {
                shift.raise(sampler, "input", "accessors");
                shift.raise(sampler, "output", "accessors");
            }
            let channels = thing.get_mut("channels").and_then(Value::as_array_mut);
            for channel in channels.into_iter().flatten() {
                channel
                    .get_mut("target")
                    .into_iter()
                    .for_each(|target| shift.raise(target, "node", "nodes"));
            }
        }
        _ => {}
    }
}

/// Shifts the accessor indices of an attribute object.
fn raise_each(attributes: &mut Value, shift: &Shift) {
    let attributes = attributes.as_object_mut().into_iter().flatten();
    attributes.for_each(|(_, accessor)| shift.raise_number(accessor, "accessors"));
}

/// Shifts texture indices: `…Texture: { "index": … }` in a material and all its extensions.
fn raise_textures(value: &mut Value, shift: &Shift) {
    let entries = value.as_object_mut().into_iter().flatten();
    for (key, value) in entries.filter(|(key, _)| *key != "extras") {
        if key.ends_with("Texture") {
            shift.raise(value, "index", "textures");
        }
        raise_textures(value, shift);
    }
}
