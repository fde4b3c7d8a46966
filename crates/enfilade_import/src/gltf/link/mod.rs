//! Joins files that were exported separately into one world, by portals between them.
//!
//! Source: Boreskov, Using portals to create aggregate scenes: scenes that know nothing of each other are joined after.
//! Cost: O(bytes of the files).

mod error;
mod merge;
mod raise;
mod shape;

pub use error::LinkError;
pub use shape::Shape;

use super::buffers::{Buffers, Source};
use super::compressed::Compressed;
use super::container::Container;
use super::document::{BufferView, Document, estimated_bytes};
use super::hints::{self, Hint};
use super::{extensions, nodes};
use crate::budget::Budget;
use crate::faults::Faults;
use crate::warning::Warnings;
use crate::{BrokenRule, Import, ImportError, ReadOptions, read_regular_file};
use merge::Merged;
use serde_json::{Value, json};
use shape::Turned;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A world in the making: glTF files placed in one space, and portals that join them.
///
/// Nodes of a part are called `PART/NAME` in the world, so that names of different parts never meet. A part in which
/// no room is marked becomes one room, `PART-room`.
#[derive(Debug, Default)]
pub struct Linker {
    merged: Merged,
    parts: Vec<Part>,
    missing_images: Vec<String>,
    /// The other files that the parts name.
    files: Vec<PathBuf>,
    /// About the memory that the documents of the parts take.
    document_bytes: u64,
    options: ReadOptions,
}

/// A part of the world, by the order in which they were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartId(usize);

/// A node that is an opening, or one to come out at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeId(usize);

/// Where a part stands in the world: scaled, then turned, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// In units of the world.
    pub translation: [f64; 3],
    /// A quaternion x, y, z, w of any length but 0.
    pub rotation: [f64; 4],
    /// Above 0.
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

/// A world that is made.
#[derive(Debug)]
pub struct Linked {
    /// The bytes of a `.glb`.
    pub glb: Vec<u8>,
    /// Extensions of the parts that are not in it: they may name what has other numbers there.
    pub left_out: Vec<String>,
    /// Which images of the parts cannot be had, and why. They are grey in it.
    pub missing_images: Vec<String>,
    /// The other files that the parts name, read or not. Whoever writes files should write none of these.
    pub files: Vec<PathBuf>,
    /// What it holds.
    pub import: Import,
}

#[derive(Debug)]
struct Part {
    name: String,
    /// The node that all others of the part are below.
    group: usize,
    nodes: std::ops::Range<usize>,
    is_one_room: bool,
}

impl Linker {
    /// Starts with nothing. Each part is read as `options` say, and so is what they come to.
    pub fn new(options: ReadOptions) -> Linker {
        Linker {
            options,
            ..Linker::default()
        }
    }

    /// Adds a file.
    ///
    /// # Errors
    /// [`LinkError::File`] where it is no sound file, [`LinkError::NameTaken`], [`LinkError::BadPlacing`].
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
        // As one room: what portals in it lead to is not known yet.
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
        let (roots, has_rooms) = self.take_in(name, path).map_err(failed)?;
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
        let group = self.merged.push("nodes", group);
        self.parts.push(Part {
            name: name.to_owned(),
            group,
            nodes,
            is_one_room: !has_rooms,
        });
        Ok(PartId(self.parts.len() - 1))
    }

    /// Takes over everything of a file: the nodes its scene begins with, and whether any is a room.
    fn take_in(&mut self, name: &str, path: &Path) -> Result<(Vec<usize>, bool), BrokenRule> {
        let mut budget = Budget::new(self.options.limit_bytes);
        let mut unread = Warnings::default();
        // The world needs as much when it is read in the end; it is not made before that is known to fit.
        budget.take(self.merged.buffer_bytes() + self.document_bytes, || {
            "the parts before it".to_owned()
        })?;
        let bytes = read_regular_file(path, None, &|| "the file".to_owned(), &mut budget)?;
        let container = Container::split(&bytes)?;
        let document = Document::parse(container.json, &mut budget)?;
        extensions::check(&document, &mut unread)?;
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
        let json: Value =
            serde_json::from_slice(container.json).map_err(|why| BrokenRule::Json(why.to_string()))?;
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
        let missing = self.merged.take_in(json, &bytes, &decoded, &mut |uri, place| {
            super::address::fetch_all(uri, place, path.parent(), &mut budget)
        })?;
        self.missing_images
            .extend(missing.into_iter().map(|why| format!("{name}: {why}")));
        self.merged.rename(first, name);
        self.document_bytes += estimated_bytes(container.json);
        Ok((
            roots.iter().map(|&root| first + root as usize).collect(),
            has_rooms,
        ))
    }

    /// The node of a part that is called so, to go in or come out at.
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

    /// Names in a part of nodes that are openings, or that hold the name.
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

    /// Makes a node of a shape in the space of a part: an opening where it has a size, and a place to come out at.
    ///
    /// # Errors
    /// [`LinkError::BadShape`].
    pub fn shape(&mut self, part: PartId, name: &str, shape: &Shape) -> Result<NodeId, LinkError> {
        let Turned {
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

    /// Makes a node to come out at as if one came out of an opening: there, and turned round.
    pub fn out_of(&mut self, opening: NodeId, name: &str) -> NodeId {
        // Half a turn about the upright axis of the opening.
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

    /// Makes a node a door to whatever room stands at its other side, or to one that is named: a room of the part, or the
    /// whole part where it is one.
    ///
    /// # Errors
    /// [`LinkError::NoSuchNode`] and [`LinkError::ManyNodes`] for the room.
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

    /// Makes a node a teleport: in along its −Z, out along that of `exit`.
    ///
    /// # Errors
    /// As [`Linker::door`].
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

    /// What a node is called in the world.
    pub fn name(&self, node: NodeId) -> &str {
        self.merged.get("nodes", node.0)["name"]
            .as_str()
            .unwrap_or_default()
    }

    /// The world, which is read again before it is given out.
    ///
    /// # Errors
    /// [`LinkError::World`] where the parts and portals make no sound world, [`LinkError::TooLarge`].
    pub fn finish(mut self) -> Result<Linked, LinkError> {
        let roots: Vec<usize> = self.parts.iter().map(|part| part.group).collect();
        self.merged.push("scenes", json!({ "nodes": roots }));
        let (glb, left_out) = self.merged.into_glb().ok_or(LinkError::TooLarge)?;
        let import = crate::read_bytes(&glb, None, &self.options)
            .map_err(|why| LinkError::World(Box::new(why.rule)))?;
        Ok(Linked {
            glb,
            left_out,
            missing_images: self.missing_images,
            files: self.files,
            import,
        })
    }
}

/// What each view lies in, by its number: what it decodes to where it is compressed. Nothing where it names no buffer.
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
