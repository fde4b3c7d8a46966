//! The parts of a glTF document that are read, as they are in its JSON. Indices are not validated here.
//!
//! The crates `gltf` and `gltf-json` are not used: they panic on some hostile files, and hold node transforms in f32.

mod attributes;
mod geometry;
mod place;
mod surfaces;

pub(in crate::gltf) use attributes::*;
pub(in crate::gltf) use geometry::*;
pub(in crate::gltf) use place::{PathStep, extensions as extensions_in};
pub(in crate::gltf) use surfaces::*;

use crate::BrokenRule;
use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::collections::BTreeSet;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Document<'a> {
    #[serde(borrow)]
    pub(in crate::gltf) asset: Asset<'a>,
    #[serde(default)]
    pub(in crate::gltf) extensions_used: BTreeSet<String>,
    #[serde(default)]
    pub(in crate::gltf) extensions_required: BTreeSet<String>,
    pub(in crate::gltf) scene: Option<u32>,
    #[serde(borrow, default)]
    pub(in crate::gltf) scenes: Vec<Scene<'a>>,
    #[serde(borrow, default)]
    pub(in crate::gltf) nodes: Vec<Node<'a>>,
    #[serde(default)]
    pub(in crate::gltf) meshes: Vec<Mesh>,
    #[serde(borrow, default)]
    pub(in crate::gltf) materials: Vec<Material<'a>>,
    #[serde(borrow, default)]
    pub(in crate::gltf) cameras: Vec<Camera<'a>>,
    #[serde(borrow, default)]
    pub(in crate::gltf) accessors: Vec<Accessor<'a>>,
    #[serde(borrow, default)]
    pub(in crate::gltf) buffer_views: Vec<BufferView<'a>>,
    #[serde(borrow, default)]
    pub(in crate::gltf) buffers: Vec<Buffer<'a>>,
    // Parsed by `list` and `lights` only when needed, so that unused parts may be invalid.
    #[serde(borrow)]
    pub(in crate::gltf) textures: Option<&'a RawValue>,
    #[serde(borrow)]
    pub(in crate::gltf) images: Option<&'a RawValue>,
    #[serde(borrow)]
    pub(in crate::gltf) samplers: Option<&'a RawValue>,
    #[serde(borrow)]
    pub(in crate::gltf) extensions: Option<&'a RawValue>,
    // Parsed only if a mesh uses them.
    #[serde(borrow, default)]
    pub(in crate::gltf) skins: Vec<&'a RawValue>,
    #[serde(borrow, default)]
    pub(in crate::gltf) animations: Vec<&'a RawValue>,
}

/// A skin: the nodes that move the vertices of a mesh.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Skin<'a> {
    #[serde(borrow, default)]
    name: Cow<'a, str>,
    pub(in crate::gltf) inverse_bind_matrices: Option<u32>,
    pub(in crate::gltf) joints: Vec<u32>,
}

impl Document<'_> {
    /// Returns what animations change. A channel that cannot be read may change anything.
    pub(in crate::gltf) fn animated(&self) -> Animated {
        #[derive(Deserialize)]
        struct Animation<'a> {
            #[serde(borrow)]
            channels: Vec<&'a RawValue>,
        }
        #[derive(Deserialize)]
        struct Channel {
            target: Target,
        }
        #[derive(Deserialize)]
        struct Target {
            node: Option<u32>,
            path: String,
            #[serde(default)]
            extensions: TargetExtensions,
        }
        #[derive(Default, Deserialize)]
        struct TargetExtensions {
            #[serde(rename = "KHR_animation_pointer")]
            pointer: Option<Pointer>,
        }
        #[derive(Deserialize)]
        struct Pointer {
            pointer: String,
        }
        let mut animated = Animated::default();
        for animation in &self.animations {
            let Ok(Animation { channels }) = serde_json::from_str(animation.get()) else {
                return Animated::all(self);
            };
            for channel in channels {
                let Ok(Channel { target }) = serde_json::from_str(channel.get()) else {
                    return Animated::all(self);
                };
                if target.path != "weights" {
                    animated.nodes.extend(target.node);
                }
                if let Some(Pointer { pointer }) = target.extensions.pointer {
                    let mut steps = pointer.split('/');
                    let number = |step: Option<&str>| step.and_then(|step| step.parse().ok());
                    match [(); 2].map(|()| steps.next()) {
                        [Some(""), Some("cameras" | "extensions" | "meshes" | "textures")] => {}
                        [Some(""), Some(list @ ("nodes" | "materials"))] => match number(steps.next()) {
                            Some(number) if list == "nodes" => animated.nodes.push(number),
                            Some(number) => animated.materials.push(number),
                            None => return Animated::all(self),
                        },
                        _ => return Animated::all(self),
                    }
                }
            }
        }
        animated
    }

    /// Returns the joints of all valid skins. An invalid one is an error where a mesh uses it.
    pub(in crate::gltf) fn joints(&self) -> Vec<u32> {
        let skins = self.skins.iter();
        let read = skins.filter_map(|skin| serde_json::from_str::<Skin>(skin.get()).ok());
        read.flat_map(|skin| skin.joints).collect()
    }
}

/// What animations change, by index; an index may be out of range.
#[derive(Debug, Default)]
pub(in crate::gltf) struct Animated {
    /// Nodes that move, or appear and vanish.
    pub(in crate::gltf) nodes: Vec<u32>,
    pub(in crate::gltf) materials: Vec<u32>,
}

impl Animated {
    fn all(document: &Document) -> Animated {
        Animated {
            nodes: (0..document.nodes.len() as u32).collect(),
            materials: (0..document.materials.len() as u32).collect(),
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Asset<'a> {
    #[serde(borrow)]
    pub(in crate::gltf) version: Cow<'a, str>,
    #[serde(borrow, default)]
    pub(in crate::gltf) min_version: Cow<'a, str>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Scene<'a> {
    #[serde(borrow, default)]
    pub(in crate::gltf) name: Cow<'a, str>,
    #[serde(default)]
    pub(in crate::gltf) nodes: Vec<u32>,
    #[serde(borrow)]
    pub(in crate::gltf) extras: Option<&'a RawValue>,
}

/// Transforms are f64, as in JSON, so that positions far from the origin lose no digits before they are accumulated.
#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Node<'a> {
    #[serde(borrow, default)]
    pub(in crate::gltf) name: Cow<'a, str>,
    #[serde(default)]
    pub(in crate::gltf) children: Box<[u32]>,
    pub(in crate::gltf) mesh: Option<u32>,
    pub(in crate::gltf) camera: Option<u32>,
    pub(in crate::gltf) skin: Option<u32>,
    /// Weights of the morph targets of its mesh.
    weights: Option<Box<Weights>>,
    // Boxed, because most nodes have few of them and there may be millions of nodes.
    pub(in crate::gltf) matrix: Option<Box<[f64; 16]>>,
    pub(in crate::gltf) translation: Option<Box<[f64; 3]>>,
    pub(in crate::gltf) rotation: Option<Box<[f64; 4]>>,
    pub(in crate::gltf) scale: Option<Box<[f64; 3]>>,
    pub(in crate::gltf) extensions: Option<Box<NodeExtensions>>,
    /// Any JSON value.
    #[serde(borrow)]
    pub(in crate::gltf) extras: Option<&'a RawValue>,
}

/// Weights of morph targets, behind one pointer, because few nodes have any.
#[derive(Debug, Deserialize)]
struct Weights(Box<[f64]>);

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::gltf) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(in crate::gltf) light: Option<LightNumber>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub(in crate::gltf) instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<NodeVisibility>,
    /// Levels of detail, of which a renderer chooses one.
    #[serde(rename = "MSFT_lod")]
    levels: Option<IgnoredAny>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct NodeVisibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(in crate::gltf) struct LightNumber {
    pub(in crate::gltf) light: u32,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(in crate::gltf) struct Instancing {
    #[serde(default)]
    pub(in crate::gltf) attributes: InstanceAttributes,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub(in crate::gltf) struct InstanceAttributes {
    pub(in crate::gltf) translation: Option<u32>,
    pub(in crate::gltf) rotation: Option<u32>,
    pub(in crate::gltf) scale: Option<u32>,
}

impl Node<'_> {
    /// Returns the weights of the morph targets, if the node has weights of its own.
    pub(in crate::gltf) fn weights(&self) -> Option<&[f64]> {
        self.weights.as_ref().map(|weights| &*weights.0)
    }

    /// Returns the index of the node's light.
    pub(in crate::gltf) fn light(&self) -> Option<u32> {
        Some(self.extensions.as_ref()?.light?.light)
    }

    /// Whether the node and those below it are drawn (`KHR_node_visibility`).
    pub(in crate::gltf) fn is_visible(&self) -> bool {
        let visibility = self.extensions.as_ref().and_then(|own| own.visibility);
        visibility.is_none_or(|visibility| visibility.visible)
    }

    /// Whether a renderer may draw another node in its place.
    pub(in crate::gltf) fn has_levels(&self) -> bool {
        self.extensions.as_ref().is_some_and(|own| own.levels.is_some())
    }

    /// Returns the instance attributes of the node.
    pub(in crate::gltf) fn instancing(&self) -> Option<InstanceAttributes> {
        Some(self.extensions.as_ref()?.instancing?.attributes)
    }
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Camera<'a> {
    #[serde(rename = "type", borrow)]
    pub(in crate::gltf) kind: Cow<'a, str>,
    pub(in crate::gltf) perspective: Option<Perspective>,
    pub(in crate::gltf) orthographic: Option<Orthographic>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Perspective {
    pub(in crate::gltf) yfov: f32,
    pub(in crate::gltf) znear: f32,
    pub(in crate::gltf) zfar: Option<f32>,
    pub(in crate::gltf) aspect_ratio: Option<f32>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(in crate::gltf) struct Orthographic {
    pub(in crate::gltf) xmag: f32,
    pub(in crate::gltf) ymag: f32,
    pub(in crate::gltf) znear: f32,
    pub(in crate::gltf) zfar: f32,
}

/// The supported extensions of the document itself.
#[derive(Debug, Default, Deserialize)]
struct DocumentExtensions<'a> {
    #[serde(rename = "KHR_lights_punctual", borrow)]
    lights: Option<Lights<'a>>,
}

#[derive(Debug, Deserialize)]
struct Lights<'a> {
    #[serde(borrow, default)]
    lights: Vec<Light<'a>>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Light<'a> {
    #[serde(rename = "type", borrow)]
    pub(in crate::gltf) kind: Cow<'a, str>,
    #[serde(default = "white")]
    pub(in crate::gltf) color: [f32; 3],
    #[serde(default = "one")]
    pub(in crate::gltf) intensity: f32,
    pub(in crate::gltf) range: Option<f32>,
    #[serde(default)]
    pub(in crate::gltf) spot: Spot,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::gltf) struct Spot {
    pub(in crate::gltf) inner_cone_angle: f32,
    pub(in crate::gltf) outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Spot {
        Spot {
            inner_cone_angle: 0.0,
            outer_cone_angle: std::f32::consts::FRAC_PI_4,
        }
    }
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}

impl<'a> Document<'a> {
    /// Parses the JSON and checks that its version is 2.
    pub(in crate::gltf) fn parse(json: &'a [u8], budget: &mut Budget) -> Result<Document<'a>, BrokenRule> {
        budget.take(estimated_bytes(json), || "the JSON".to_owned())?;
        let document: Document = serde_json::from_slice(json).map_err(|why| json_error(json, &why))?;
        let Asset { version, min_version } = &document.asset;
        // A later 2.x is read as 2.0, unless `minVersion` requires more.
        for (wanted, is_read) in [
            (version, version == "2" || version.starts_with("2.")),
            (min_version, matches!(&**min_version, "" | "2.0")),
        ] {
            if !is_read && json.windows(16).any(|part| part == b"\"geometricError\"") {
                return Err(BrokenRule::OtherFormat {
                    format: "a tileset of 3D Tiles",
                    remedy: "name one of the tiles that it lists as `content`: a .b3dm, .i3dm or .glb",
                });
            }
            if !is_read {
                return Err(BrokenRule::Version(short(wanted)));
            }
        }
        Ok(document)
    }

    /// Parses the lights of the document.
    pub(in crate::gltf) fn lights(&self) -> Result<Vec<Light<'a>>, BrokenRule> {
        let Some(extensions) = self.extensions else {
            return Ok(Vec::new());
        };
        let extensions: DocumentExtensions = serde_json::from_str(extensions.get())
            .map_err(|why| within("extensions", extensions.get(), &why))?;
        Ok(extensions.lights.map_or_else(Vec::new, |lights| lights.lights))
    }

    /// Reads another scene than the default one, by name or index.
    pub(in crate::gltf) fn choose_scene(&mut self, wanted: &str) -> Result<(), BrokenRule> {
        const MOST: usize = 1000;
        const FEW: usize = 8;
        let numbered = || (0_u32..).zip(&self.scenes);
        let named: Vec<u32> = numbered()
            .filter(|(_, scene)| scene.name == wanted && !wanted.is_empty())
            .map(|(number, _)| number)
            .collect();
        let indexed = || wanted.parse().ok().filter(|&at: &usize| at < self.scenes.len());
        match &*named {
            [only] => self.scene = Some(*only),
            [] => match indexed() {
                Some(index) => self.scene = Some(index as u32),
                None => {
                    let names = self.scenes.iter().take(MOST).map(|scene| short(&scene.name));
                    return Err(BrokenRule::NoSuchScene {
                        scene: short(wanted),
                        there: names.collect(),
                    });
                }
            },
            several => {
                let indices: Vec<String> = several.iter().take(FEW).map(u32::to_string).collect();
                return Err(BrokenRule::ManyScenes {
                    scene: short(wanted),
                    indices: indices.join(", "),
                });
            }
        }
        Ok(())
    }

    /// Returns the index of the scene that is read, if there are scenes.
    pub(in crate::gltf) fn scene_number(&self) -> Option<u32> {
        self.scene.or((!self.scenes.is_empty()).then_some(0))
    }

    /// Parses an existing skin.
    pub(in crate::gltf) fn skin(&self, number: u32) -> Result<Skin<'_>, BrokenRule> {
        let raw = self.skins[number as usize];
        serde_json::from_str(raw.get()).map_err(|why| within(&format!("skins[{number}]"), raw.get(), &why))
    }

    /// Returns the name of a node in messages: `node 7 "Door"`.
    pub(in crate::gltf) fn node_name(&self, node: u32) -> String {
        let name = self.nodes.get(node as usize).map_or("", |node| &*node.name);
        spoken("node", node, name)
    }
}

impl Skin<'_> {
    /// Returns the name of the skin in messages: `skin 0 "Armature"`.
    pub(in crate::gltf) fn spoken(&self, number: u32) -> String {
        spoken("skin", number, &self.name)
    }
}

/// Returns the kind and index of an element, and its name if it has one.
fn spoken(kind: &str, number: u32, name: &str) -> String {
    match name {
        "" => format!("{kind} {number}"),
        name => format!("{kind} {number} {:?}", short(name)),
    }
}

/// Parses a list on demand; a missing list is empty.
pub(in crate::gltf) fn list<'a, T: Deserialize<'a>>(
    raw: Option<&'a RawValue>,
    name: &str,
) -> Result<Vec<T>, BrokenRule> {
    let Some(raw) = raw else {
        return Ok(Vec::new());
    };
    serde_json::from_str(raw.get()).map_err(|why| within(name, raw.get(), &why))
}

/// Estimates the memory of a parsed document and of data derived from its nodes, in bytes.
pub(in crate::gltf) fn estimated_bytes(json: &[u8]) -> u64 {
    // The largest type that a bracket can hold, and slack for lists that grow by doubling.
    const EACH_BRACKET: u64 = 256;
    // A name in a list of names.
    const EACH_COMMA: u64 = 24;
    let count = |is: fn(&u8) -> bool| json.iter().filter(|byte| is(byte)).count() as u64;
    EACH_BRACKET * count(|&byte| byte == b'{' || byte == b'[') + EACH_COMMA * count(|&byte| byte == b',')
}

/// Returns the element at an index, or an error that names the element that holds the index.
pub(in crate::gltf) fn find<'t, T>(
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

/// Returns the beginning of a text from the file, with control characters replaced: messages must stay readable and
/// must not send control sequences to a terminal.
pub(in crate::gltf) fn short(text: &str) -> String {
    const MOST: usize = 80;
    let mut letters = text.chars();
    let printable = |letter: char| if letter.is_control() { '\u{fffd}' } else { letter };
    let mut short: String = letters.by_ref().take(MOST).map(printable).collect();
    if letters.next().is_some() {
        short.push('…');
    }
    short
}

fn json_error(json: &[u8], why: &serde_json::Error) -> BrokenRule {
    let (text, position) = parted(why);
    let place = place::of_error(json, why, 2);
    let place = if place.is_empty() { place } else { place + ": " };
    BrokenRule::Json(place + &short(&text) + &position)
}

/// Returns an error about a part of the document, without line and column, which would be relative to that part.
fn within(part: &str, json: &str, why: &serde_json::Error) -> BrokenRule {
    let place = place::of_error(json.as_bytes(), why, 1);
    let dot = if place.is_empty() || place.starts_with('[') {
        ""
    } else {
        "."
    };
    BrokenRule::Json(format!("{part}{dot}{place}: {}", short(&parted(why).0)))
}

/// Returns the JSON without properties that are null, which mean the same as if they were not there, with a warning for
/// each.
pub(in crate::gltf) fn repaired<'j>(
    json: &'j [u8],
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<Cow<'j, [u8]>, BrokenRule> {
    // Most files have none.
    if !std::str::from_utf8(json).is_ok_and(|text| text.contains("null")) {
        return Ok(Cow::Borrowed(json));
    }
    budget.take(json.len() as u64, || "the JSON without nulls".to_owned())?;
    Ok(Cow::Owned(place::without_nulls(json, |place| {
        warnings.name(WarningKind::Repaired, || format!("{} is null", place()));
    })))
}

/// Splits a message of `serde_json` into its text and its position.
fn parted(why: &serde_json::Error) -> (String, String) {
    let place = format!(" at line {} column {}", why.line(), why.column());
    let text = why.to_string();
    match text.strip_suffix(&place) {
        Some(text) => (text.to_owned(), place),
        None => (text, String::new()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_brackets_hold_is_no_larger_than_estimated() {
        let sizes = [
            size_of::<Scene>(),
            size_of::<Node>(),
            size_of::<Mesh>(),
            size_of::<Primitive>(),
            size_of::<Attributes>(),
            size_of::<Material>(),
            size_of::<Camera>(),
            size_of::<Accessor>(),
            size_of::<BufferView>(),
            size_of::<Buffer>(),
            size_of::<Light>(),
            size_of::<Texture>(),
            size_of::<Image>(),
            size_of::<Sampler>(),
            size_of::<NodeExtensions>(),
            size_of::<Compression>(),
            size_of::<TextureInfo>(),
        ];
        assert!(sizes.iter().all(|&size| size <= 128), "{sizes:?}");
    }
}
