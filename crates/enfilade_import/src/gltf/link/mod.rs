//! Links separately exported files into one world, joined by portals.
//!
//! Merges documents, not imported geometry, so that elements that the importer does not read, such as animations, stay
//! in the file. The world marks rooms and portals as an author would, so there is only one way to express a portal.
//! Compressed buffer views are stored uncompressed, because their extensions refer to buffers that are merged into one.
//! Unknown extensions are left out, because they may contain indices, which cannot be shifted.
//! Source: Boreskov, Using portals to create aggregate scenes: independent scenes are joined afterwards.
//! Cost: O(bytes of the files).

mod error;
mod merge;
mod raise;
mod shape;

pub use error::LinkError;
pub use shape::Shape;

use super::affected::Affected;
use super::buffers::{Buffers, Source};
use super::compressed::Compressed;
use super::container::Container;
use super::document::{BufferView, Document, estimated_bytes, repaired};
use super::hints::{self, Hint};
use super::{extensions, nodes};
use crate::budget::Budget;
use crate::faults::Faults;
use crate::warning::Warnings;
use crate::{BrokenRule, Import, ImportError, ReadOptions, read_regular_file};
use merge::Merged;
use serde_json::{Value, json};
use shape::ShapeFrame;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Builds a world from glTF files, placed in one space, and portals that join them.
///
/// A node of a part is named `PART/NAME` in the world, so names of different parts never collide. A part without marked
/// rooms becomes one room, `PART-room`.
#[derive(Debug, Default)]
pub struct Linker {
    merged: Merged,
    parts: Vec<Part>,
    missing_images: Vec<String>,
    /// Separate files that the parts reference.
    files: Vec<PathBuf>,
    /// Approximate memory of the parts' JSON documents, in bytes.
    document_bytes: u64,
    options: ReadOptions,
}

/// Index of a part, in the order of [`Linker::part`] calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartId(usize);

/// A node of the world that serves as an opening or an exit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeId(usize);

/// Transform of a part in the world: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// In world units.
    pub translation: [f64; 3],
    /// A quaternion x, y, z, w of any length except 0.
    pub rotation: [f64; 4],
    /// Uniform scale, above 0.
    pub scale: f64,
}

impl Default for Placing {
    fn default() -> Placing {
        Placing {
            translation: [0.0; 3],
            rotation: [0.0, 0.0, 0.0, 1.0],
            scale: 1.0,
        }
    }
}

/// A finished world.
#[derive(Debug)]
pub struct Linked {
    /// The bytes of a `.glb`.
    pub glb: Vec<u8>,
    /// Extensions of the parts that are left out, because they may contain indices that differ in the world.
    pub left_out: Vec<String>,
    /// Images that could not be read, each with the reason. They are grey in the world.
    pub missing_images: Vec<String>,
    /// Separate files that the parts reference, read or not. Check output paths against this list to avoid overwriting
    /// a source.
    pub files: Vec<PathBuf>,
    /// The world, as [`read_bytes`](crate::read_bytes) reads it.
    pub import: Import,
}

#[derive(Debug)]
struct Part {
    name: String,
    /// The group node above all nodes of the part.
    group: usize,
    nodes: std::ops::Range<usize>,
    is_one_room: bool,
}

/// The contents of a file in the world.
struct AppendedPart {
    /// The roots of its scene.
    roots: Vec<usize>,
    has_rooms: bool,
    /// Whether unread extensions may change any of it.
    is_affected: bool,
}

impl Linker {
    /// Creates an empty world. `options` apply to each part and to the finished world.
    pub fn new(options: ReadOptions) -> Linker {
        Linker {
            options,
            ..Linker::default()
        }
    }

    /// Adds a file to the world.
    ///
    /// # Errors
    /// [`LinkError::File`] if the file cannot be read, [`LinkError::NameTaken`], [`LinkError::BadPlacing`].
    pub fn part(&mut self, name: &str, path: &Path, placing: &Placing) -> Result<PartId, LinkError> {
        if name.is_empty() || name.contains('/') || self.parts.iter().any(|part| part.name == name) {
            return Err(LinkError::NameTaken(name.to_owned()));
        }
        let numbers = placing.translation.iter().chain(&placing.rotation);
        let length = placing
            .rotation
            .iter()
            .map(|part| part * part)
            .sum::<f64>()
            .sqrt();
        let is_sound = numbers
            .chain([&placing.scale, &length])
            .all(|number| number.is_finite());
        if !is_sound || length == 0.0 || placing.scale <= 0.0 {
            return Err(LinkError::BadPlacing);
        }
        // Read as one room, because the targets of its portals may be in parts that are not added yet.
        let flat = ReadOptions {
            flat: true,
            textures: false,
            ..self.options.clone()
        };
        self.files.extend(crate::read_gltf(path, &flat)?.files);
        let failed = |rule| ImportError {
            file: path.display().to_string(),
            rule,
        };
        let first = self.merged.count("nodes");
        let AppendedPart {
            roots,
            has_rooms,
            is_affected,
        } = self.append_document(name, path).map_err(failed)?;
        let nodes = first..self.merged.count("nodes");
        let mut group = json!({
            "name": if has_rooms { name.to_owned() } else { format!("{name}-room") },
            "translation": placing.translation,
            "rotation": placing.rotation.map(|part| part / length),
            "scale": [placing.scale, placing.scale, placing.scale],
            "children": roots,
        });
        if !has_rooms {
            group["extras"] = json!({ "enfilade": { "kind": "room" } });
        }
        // The extensions themselves may be left out, so that the finished world does not show what they may change.
        if is_affected {
            group["extras"]["enfilade"]["occluder"] = json!(false);
        }
        let group = self.merged.push("nodes", group);
        self.parts.push(Part {
            name: name.to_owned(),
            group,
            nodes,
            is_one_room: !has_rooms,
        });
        Ok(PartId(self.parts.len() - 1))
    }

    /// Appends the contents of a file.
    fn append_document(&mut self, name: &str, path: &Path) -> Result<AppendedPart, BrokenRule> {
        let mut budget = Budget::new(self.options.limit_bytes);
        let mut unread = Warnings::default();
        // The finished world is read at the end and needs as much memory, so check now that it fits.
        budget.take(self.merged.buffer_bytes() + self.document_bytes, || {
            "the parts before it".to_owned()
        })?;
        let bytes = read_regular_file(path, None, &|| "the file".to_owned(), &mut budget)?;
        let container = Container::split(&bytes)?;
        let plain = repaired(container.json, &mut budget, &mut unread)?;
        let mut document = Document::parse(&plain, &mut budget)?;
        if let Some(scene) = &self.options.scene {
            document.choose_scene(scene)?;
        }
        let document = document;
        extensions::check(&document, self.options.lenient, &mut unread)?;
        let is_affected = Affected::by_unread(&document, &plain).is_any();
        let mut faults = Faults::new(&self.options);
        let hints = hints::read(&document, &mut faults, &mut unread);
        faults.into_result()?;
        let is_room = |node: u32| matches!(hints.get(&node), Some(Hint::Room { .. }));
        let placed = nodes::place(&document, is_room, is_room, &mut unread)?;
        let has_rooms = placed.iter().any(|placed| placed.room.is_some());
        let sources = view_sources(&document)?;
        let buffers = Buffers::load(
            &document,
            sources.iter().copied().flatten(),
            container.binary,
            path.parent(),
            &mut budget,
        )?;
        let roots = nodes::scene_roots(&document)?;
        let mut json: Value =
            serde_json::from_slice(&plain).map_err(|why| BrokenRule::Json(why.to_string()))?;
        detach(&mut json, &roots);
        let first = self.merged.count("nodes");
        let plain: BTreeSet<Source> = sources.iter().copied().flatten().collect();
        let of_buffer = |buffer| {
            let source = Source::Buffer(buffer);
            plain.contains(&source).then(|| buffers.bytes(source))
        };
        let bytes: Vec<Option<&[u8]>> = (0..document.buffers.len() as u32).map(of_buffer).collect();
        let decoded: BTreeMap<usize, &[u8]> = sources
            .iter()
            .enumerate()
            .filter_map(|(view, source)| match source {
                Some(source @ Source::View(_)) => Some((view, buffers.bytes(*source))),
                _ => None,
            })
            .collect();
        let missing = self
            .merged
            .append_document(json, &bytes, &decoded, &mut |uri, place| {
                super::address::fetch_all(uri, place, path.parent(), &mut budget)
            })?;
        self.missing_images
            .extend(missing.into_iter().map(|why| format!("{name}: {why}")));
        self.merged.rename(first, name);
        self.document_bytes += estimated_bytes(container.json);
        Ok(AppendedPart {
            roots: roots.iter().map(|&root| first + root as usize).collect(),
            has_rooms,
            is_affected,
        })
    }

    /// Returns the node of a part by its name, to use it as an opening or an exit.
    ///
    /// # Errors
    /// [`LinkError::NoSuchNode`] and [`LinkError::ManyNodes`].
    pub fn node(&self, part: PartId, name: &str) -> Result<NodeId, LinkError> {
        let part = &self.parts[part.0];
        let full = format!("{}/{name}", part.name);
        let mut called = part
            .nodes
            .clone()
            .filter(|&node| self.merged.get("nodes", node)["name"] == *full);
        match (called.next(), called.next()) {
            (Some(only), None) => Ok(NodeId(only)),
            (None, _) => Err(LinkError::NoSuchNode {
                part: part.name.clone(),
                node: name.to_owned(),
                like: self.names_like(part, name),
            }),
            _ => Err(LinkError::ManyNodes {
                part: part.name.clone(),
                node: name.to_owned(),
            }),
        }
    }

    /// Returns names of nodes that contain the name, or that are openings.
    fn names_like(&self, part: &Part, name: &str) -> String {
        const FEW: usize = 8;
        let name = name.to_lowercase();
        let own = |node: usize| {
            let full = self.merged.get("nodes", node)["name"]
                .as_str()
                .unwrap_or_default();
            full[(part.name.len() + 1).min(full.len())..].to_owned()
        };
        let is_like = |own: &String| {
            own.contains("-portal") || own.contains("-mirror") || own.to_lowercase().contains(&name)
        };
        let like: BTreeSet<String> = part.nodes.clone().map(own).filter(is_like).collect();
        like.into_iter().take(FEW).collect::<Vec<_>>().join(", ")
    }

    /// Adds a node of a shape in the space of a part: an opening if the shape has a size, otherwise an exit.
    ///
    /// # Errors
    /// [`LinkError::BadShape`].
    pub fn shape(&mut self, part: PartId, name: &str, shape: &Shape) -> Result<NodeId, LinkError> {
        let ShapeFrame {
            place,
            rotation,
            corners,
        } = shape.turned()?;
        let mut node = json!({ "name": name, "translation": place, "rotation": rotation });
        if !corners.is_empty() {
            node["mesh"] = json!(self.merged.polygon(&corners));
        }
        Ok(self.add(self.parts[part.0].group, node))
    }

    /// Adds an exit node at an opening, facing the opposite way.
    pub fn out_of(&mut self, opening: NodeId, name: &str) -> NodeId {
        // Rotation by 180° about the opening's y axis.
        self.add(
            opening.0,
            json!({ "name": name, "rotation": [0.0, 1.0, 0.0, 0.0] }),
        )
    }

    fn add(&mut self, parent: usize, node: Value) -> NodeId {
        let node = self.merged.push("nodes", node);
        if let Some(parent) = self.merged.get_mut("nodes", parent).as_object_mut() {
            let children = parent.entry("children").or_insert_with(|| json!([]));
            if let Some(children) = children.as_array_mut() {
                children.push(json!(node));
            }
        }
        NodeId(node)
    }

    /// Makes a node a portal to the room on its other side, or to a named one: a room of a part, or the whole part if
    /// that is a single room.
    ///
    /// # Errors
    /// [`LinkError::NoSuchNode`] and [`LinkError::ManyNodes`], if the room is not found.
    pub fn door(
        &mut self,
        opening: NodeId,
        to: Option<(PartId, Option<&str>)>,
        one_way: bool,
    ) -> Result<(), LinkError> {
        let mut hint = json!({ "kind": "portal", "one_way": one_way });
        if let Some((part, room)) = to
            && let Some(room) = self.room_name(part, room)?
        {
            hint["to"] = json!(room);
        }
        self.mark(opening, hint);
        Ok(())
    }

    /// Makes a node a teleport portal: enters along its −Z, leaves along the −Z of `exit`.
    ///
    /// # Errors
    /// The same as [`Linker::door`].
    pub fn teleport(
        &mut self,
        opening: NodeId,
        exit: NodeId,
        to: (PartId, Option<&str>),
    ) -> Result<(), LinkError> {
        let mut hint = json!({ "kind": "portal", "exit": self.name(exit) });
        if let Some(room) = self.room_name(to.0, to.1)? {
            hint["to"] = json!(room);
        }
        self.mark(opening, hint);
        Ok(())
    }

    /// Makes a node a mirror.
    pub fn mirror(&mut self, opening: NodeId) {
        self.mark(opening, json!({ "kind": "mirror" }));
    }

    fn room_name(&self, part: PartId, room: Option<&str>) -> Result<Option<String>, LinkError> {
        match room {
            Some(room) => Ok(Some(self.name(self.node(part, room)?).to_owned())),
            None if self.parts[part.0].is_one_room => {
                Ok(Some(self.name(NodeId(self.parts[part.0].group)).to_owned()))
            }
            None => Ok(None),
        }
    }

    fn mark(&mut self, node: NodeId, hint: Value) {
        let extras = &mut self.merged.get_mut("nodes", node.0)["extras"];
        if !extras.is_object() {
            *extras = json!({});
        }
        extras["enfilade"] = hint;
    }

    /// Returns the name of a node in the world.
    pub fn name(&self, node: NodeId) -> &str {
        self.merged.get("nodes", node.0)["name"]
            .as_str()
            .unwrap_or_default()
    }

    /// Returns the world, after reading it to validate it.
    ///
    /// # Errors
    /// [`LinkError::World`] if the world is not a valid file, [`LinkError::TooLarge`].
    pub fn finish(mut self) -> Result<Linked, LinkError> {
        let roots: Vec<usize> = self.parts.iter().map(|part| part.group).collect();
        self.merged.push("scenes", json!({ "nodes": roots }));
        let (glb, left_out) = self.merged.into_glb().ok_or(LinkError::TooLarge)?;
        // Scenes were chosen in the parts; the world has one.
        let options = ReadOptions {
            scene: None,
            ..self.options
        };
        let import =
            crate::read_bytes(&glb, None, &options).map_err(|why| LinkError::World(Box::new(why.rule)))?;
        Ok(Linked {
            glb,
            left_out,
            missing_images: self.missing_images,
            files: self.files,
            import,
        })
    }
}

/// Removes nodes from the children of their parents, which their scene leaves out: in the world they have another parent.
fn detach(json: &mut Value, roots: &[u32]) {
    let roots: BTreeSet<u64> = roots.iter().map(|&root| u64::from(root)).collect();
    let nodes = json["nodes"].as_array_mut().into_iter().flatten();
    for children in nodes.filter_map(|node| node.get_mut("children")?.as_array_mut()) {
        children.retain(|child| child.as_u64().is_none_or(|child| !roots.contains(&child)));
    }
}

/// Returns the source of each buffer view: its buffer, or its decoded bytes if it is compressed; `None` if its buffer
/// does not exist.
fn view_sources(document: &Document) -> Result<Vec<Option<Source>>, BrokenRule> {
    let source = |(number, view): (u32, &BufferView)| {
        Ok(match Compressed::of(document, number)? {
            Some(_) => Some(Source::View(number)),
            None => {
                Some(Source::Buffer(view.buffer)).filter(|_| (view.buffer as usize) < document.buffers.len())
            }
        })
    };
    (0..).zip(&document.buffer_views).map(source).collect()
}
