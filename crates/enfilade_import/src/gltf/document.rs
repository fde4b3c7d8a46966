//! The part of a glTF document that is read, as it stands in its JSON. Numbers in it may still name nothing.

use crate::BrokenRule;
use crate::budget::Budget;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::collections::BTreeSet;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document<'a> {
    #[serde(borrow)]
    pub(super) asset: Asset<'a>,
    #[serde(default)]
    pub(super) extensions_used: BTreeSet<String>,
    #[serde(default)]
    pub(super) extensions_required: BTreeSet<String>,
    pub(super) scene: Option<u32>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(borrow, default)]
    pub(super) nodes: Vec<Node<'a>>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(borrow, default)]
    pub(super) materials: Vec<Material<'a>>,
    #[serde(borrow, default)]
    pub(super) cameras: Vec<Camera<'a>>,
    #[serde(borrow, default)]
    pub(super) accessors: Vec<Accessor<'a>>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(borrow, default)]
    pub(super) buffers: Vec<Buffer<'a>>,
    // Only counted: `IgnoredAny` takes no memory.
    #[serde(default)]
    pub(super) textures: Vec<IgnoredAny>,
    #[serde(default)]
    pub(super) skins: Vec<IgnoredAny>,
    #[serde(default)]
    pub(super) animations: Vec<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Asset<'a> {
    #[serde(borrow)]
    pub(super) version: Cow<'a, str>,
    #[serde(borrow, default)]
    pub(super) min_version: Cow<'a, str>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<u32>,
}

/// Numbers are f64 as in JSON, so that places far out do not lose digits before they are added up.
#[derive(Debug, Deserialize)]
pub(super) struct Node<'a> {
    #[serde(borrow, default)]
    pub(super) name: Cow<'a, str>,
    #[serde(default)]
    pub(super) children: Vec<u32>,
    pub(super) mesh: Option<u32>,
    pub(super) camera: Option<u32>,
    // In boxes: most nodes have few of them, and there may be millions of nodes.
    pub(super) matrix: Option<Box<[f64; 16]>>,
    pub(super) translation: Option<Box<[f64; 3]>>,
    pub(super) rotation: Option<Box<[f64; 4]>>,
    pub(super) scale: Option<Box<[f64; 3]>>,
    /// Anything at all.
    #[serde(borrow)]
    pub(super) extras: Option<&'a RawValue>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    #[serde(default)]
    pub(super) primitives: Vec<Primitive>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<u32>,
    pub(super) material: Option<u32>,
    pub(super) mode: Option<u32>,
    #[serde(default)]
    pub(super) targets: Vec<IgnoredAny>,
    #[serde(default)]
    pub(super) extensions: PrimitiveExtensions,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(super) struct Attributes {
    pub(super) position: Option<u32>,
    pub(super) normal: Option<IgnoredAny>,
    pub(super) color_0: Option<IgnoredAny>,
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(super) draco: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Material<'a> {
    #[serde(default)]
    pub(super) pbr_metallic_roughness: PbrMetallicRoughness,
    #[serde(borrow, default = "opaque")]
    pub(super) alpha_mode: Cow<'a, str>,
    #[serde(default)]
    pub(super) double_sided: bool,
    #[serde(default)]
    pub(super) extensions: MaterialExtensions,
    /// Anything at all.
    #[serde(borrow)]
    pub(super) extras: Option<&'a RawValue>,
}

fn opaque() -> Cow<'static, str> {
    Cow::Borrowed("OPAQUE")
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct PbrMetallicRoughness {
    pub(super) base_color_factor: [f32; 4],
}

impl Default for PbrMetallicRoughness {
    fn default() -> PbrMetallicRoughness {
        PbrMetallicRoughness {
            base_color_factor: [1.0; 4],
        }
    }
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_transmission", default)]
    pub(super) transmission: Transmission,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(super) struct Transmission {
    pub(super) transmission_factor: f32,
}

#[derive(Debug, Deserialize)]
pub(super) struct Camera<'a> {
    #[serde(rename = "type", borrow)]
    pub(super) kind: Cow<'a, str>,
    pub(super) perspective: Option<Perspective>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(super) struct Perspective {
    pub(super) yfov: f32,
    pub(super) znear: f32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor<'a> {
    pub(super) buffer_view: Option<u32>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    pub(super) count: u64,
    #[serde(rename = "type", borrow)]
    pub(super) shape: Cow<'a, str>,
    pub(super) sparse: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: u32,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer<'a> {
    #[serde(borrow, default)]
    pub(super) uri: Cow<'a, str>,
    pub(super) byte_length: u64,
}

impl<'a> Document<'a> {
    /// Parses the JSON and checks that it is of version 2.
    pub(super) fn parse(json: &'a [u8], budget: &mut Budget) -> Result<Document<'a>, BrokenRule> {
        budget.take(estimated_bytes(json), || "the JSON".to_owned())?;
        let document: Document = serde_json::from_slice(json).map_err(json_error)?;
        let Asset { version, min_version } = &document.asset;
        // A later 2.x is read as 2.0, unless it says that this is not enough.
        for (wanted, is_read) in [
            (version, version == "2" || version.starts_with("2.")),
            (min_version, matches!(&**min_version, "" | "2.0")),
        ] {
            if !is_read {
                return Err(BrokenRule::Version(short(wanted)));
            }
        }
        Ok(document)
    }

    /// What to call a node: `node 7 "Door"`.
    pub(super) fn node_name(&self, node: u32) -> String {
        match self.nodes.get(node as usize).map(|node| &*node.name) {
            Some(name) if !name.is_empty() => format!("node {node} {:?}", short(name)),
            _ => format!("node {node}"),
        }
    }
}

/// About the memory that a parsed document takes, with what is worked out about its nodes.
fn estimated_bytes(json: &[u8]) -> u64 {
    // The largest thing that brackets can hold, and room for lists that grow by doubling.
    const EACH_BRACKET: u64 = 256;
    const EACH_COMMA: u64 = 12;
    let count = |is: fn(&u8) -> bool| json.iter().filter(|byte| is(byte)).count() as u64;
    EACH_BRACKET * count(|&byte| byte == b'{' || byte == b'[') + EACH_COMMA * count(|&byte| byte == b',')
}

/// The thing that a number names, or an error that says that it names none.
pub(super) fn find<'t, T>(
    list: &'t [T],
    index: u32,
    kind: &'static str,
    place: impl FnOnce() -> String,
) -> Result<&'t T, BrokenRule> {
    let nothing = || BrokenRule::NoSuch {
        place: place(),
        kind,
        index,
        count: list.len(),
    };
    list.get(index as usize).ok_or_else(nothing)
}

/// The beginning of a text out of the file, without control characters: a message must stay readable, and must not
/// command a terminal, whatever the file says.
pub(super) fn short(text: &str) -> String {
    const MOST: usize = 80;
    let mut letters = text.chars();
    let printable = |letter: char| if letter.is_control() { '\u{fffd}' } else { letter };
    let mut short: String = letters.by_ref().take(MOST).map(printable).collect();
    if letters.next().is_some() {
        short.push('…');
    }
    short
}

fn json_error(why: serde_json::Error) -> BrokenRule {
    let place = format!(" at line {} column {}", why.line(), why.column());
    let text = why.to_string();
    BrokenRule::Json(match text.strip_suffix(&place) {
        Some(text) => short(text) + &place,
        None => short(&text),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_brackets_hold_is_no_larger_than_estimated() {
        let sizes = [
            size_of::<Scene>(),
            size_of::<Node>(),
            size_of::<Primitive>(),
            size_of::<Material>(),
            size_of::<Camera>(),
            size_of::<Accessor>(),
            size_of::<BufferView>(),
            size_of::<Buffer>(),
        ];
        assert!(sizes.iter().all(|&size| size <= 128), "{sizes:?}");
    }
}
