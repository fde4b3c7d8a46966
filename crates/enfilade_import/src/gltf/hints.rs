//! Reads authoring hints: rooms, portals, mirrors and terrain, marked by node names or in `extras.enfilade`.
//!
//! The name endings are `-room`, `-portal`, `-mirror` and `-terrain`, optionally followed by Blender's numeric suffix
//! (`.001`). `extras.enfilade.kind` takes precedence over the name.

use super::document::{Document, Node, short};
use crate::AuthoringError;
use crate::faults::{Faults, Subject};
use crate::warning::{WarningKind, Warnings};
use enfilade::Method;
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The role of a marked node.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Hint {
    /// The node's descendants form a sector.
    Room { method: Option<Method> },
    /// The node's mesh is an opening.
    Opening {
        way: OpeningTarget,
        /// Marked only by its name, which authors who do not know the convention may also use.
        by_name: bool,
    },
    /// An opening with invalid extras: its mesh is not drawn, and it leads nowhere.
    Hole,
    /// The node's mesh is a grid of heights.
    Terrain,
    /// The node and its descendants are the leaf of a door; drawn as any other.
    Door,
}

/// The target of an opening, as written by the author.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum OpeningTarget {
    Portal {
        to: Option<String>,
        one_way: bool,
        exit: Option<Exit>,
    },
    Mirror,
}

/// The exit of a teleport.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Exit {
    /// Name of the node that the traveller comes out at.
    pub(super) node: String,
    /// Factor by which the portal enlarges what passes it.
    pub(super) scale: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Room,
    Portal,
    Mirror,
    Terrain,
    /// Not by a name: names of doors do not follow our convention.
    Door,
}

const KINDS: [(&str, Kind); 5] = [
    ("door", Kind::Door),
    ("room", Kind::Room),
    ("portal", Kind::Portal),
    ("mirror", Kind::Mirror),
    ("terrain", Kind::Terrain),
];

/// Returns the hints of all marked nodes, by node index. A node with invalid extras is reported and keeps the default
/// hint of its kind, so that the rest of the file can be checked too.
pub(super) fn read(document: &Document, faults: &mut Faults, warnings: &mut Warnings) -> BTreeMap<u32, Hint> {
    let mut hints = BTreeMap::new();
    for (number, node) in (0_u32..).zip(&document.nodes) {
        let hint = hint(document, number, node, warnings).unwrap_or_else(|(kind, why)| {
            let (subject, hint) = match kind {
                Some(Kind::Portal | Kind::Mirror) => (Subject::Portal, Some(Hint::Hole)),
                Some(Kind::Room) => (Subject::Room, Some(Hint::Room { method: None })),
                Some(Kind::Terrain) => (Subject::Room, Some(Hint::Terrain)),
                Some(Kind::Door) => (Subject::Room, Some(Hint::Door)),
                None => (Subject::Room, None),
            };
            faults.report(subject, why, warnings);
            hint
        });
        if let Some(hint) = hint {
            hints.insert(number, hint);
        }
    }
    hints
}

/// Returns `extras.enfilade.occluder` of all nodes that have it, or have it above them.
pub(super) fn occluders(
    document: &Document,
    faults: &mut Faults,
    warnings: &mut Warnings,
) -> BTreeMap<u32, bool> {
    let mut occluders = BTreeMap::new();
    let mut waiting = Vec::new();
    for (number, node) in (0_u32..).zip(&document.nodes) {
        // Invalid extras are reported by `read`.
        let Ok(mut notes) = Notes::of(document, number, node) else {
            continue;
        };
        match notes.choice("occluder") {
            Ok(None) => {}
            Ok(Some(hides)) => {
                occluders.insert(number, hides);
                waiting.push(number);
            }
            Err(why) => {
                // Also where faults are only warned of.
                occluders.insert(number, false);
                waiting.push(number);
                faults.report(Subject::Room, why, warnings);
            }
        }
    }
    while let Some(number) = waiting.pop() {
        let hides = occluders[&number];
        for &child in &document.nodes[number as usize].children {
            // A mark of its own is nearer.
            if (child as usize) < document.nodes.len() && !occluders.contains_key(&child) {
                occluders.insert(child, hides);
                waiting.push(child);
            }
        }
    }
    occluders
}

/// Returns `extras.enfilade.method` of the scene: the method of the room for nodes outside every room.
pub(super) fn method_of_scene(document: &Document) -> Result<Option<Method>, AuthoringError> {
    let number = document.scene.unwrap_or(0);
    match document.scenes.get(number as usize) {
        Some(scene) => Notes::written(format!("scene {number}"), scene.extras)?.method(),
        None => Ok(None),
    }
}

/// Returns the hint of a node; if its extras are invalid, the error and the kind that it still has.
fn hint(
    document: &Document,
    number: u32,
    node: &Node,
    warnings: &mut Warnings,
) -> Result<Option<Hint>, (Option<Kind>, AuthoringError)> {
    let by_name = kind_by_name(&node.name);
    let mut notes = Notes::of(document, number, node).map_err(|why| (by_name, why))?;
    // Of any node: see `occluders`.
    notes.values.remove("occluder");
    let has_notes = !notes.values.is_empty();
    let written = notes.kind().map_err(|why| (by_name, why))?;
    let Some(kind) = written.or(by_name) else {
        if has_notes {
            warnings.name(WarningKind::UnreadNotes, || notes.spoken.clone());
        }
        return Ok(None);
    };
    let hint = notes.hint(kind, !has_notes).map_err(|why| (Some(kind), why))?;
    if !notes.values.is_empty() {
        warnings.name(WarningKind::UnreadNotes, || notes.spoken.clone());
    }
    Ok(Some(hint))
}

/// Returns the kind that a name ends in, ignoring Blender's numeric suffix: `Hall-portal.001`.
fn kind_by_name(name: &str) -> Option<Kind> {
    let base = match name.rsplit_once('.') {
        Some((base, digits)) if digits.len() >= 3 && digits.bytes().all(|byte| byte.is_ascii_digit()) => base,
        _ => name,
    };
    let (_, ending) = base.rsplit_once('-')?;
    KINDS
        .iter()
        .find(|(name, kind)| *name == ending && *kind != Kind::Door)
        .map(|(_, kind)| *kind)
}

/// Returns `true` if a name marks a room, a portal or a mirror.
pub(crate) fn marks_opening_or_room(name: &str) -> bool {
    kind_by_name(name).is_some_and(|kind| kind != Kind::Terrain)
}

/// Maximum length of a hint, in bytes; a valid one is much shorter.
const MAX_BYTES: usize = 1 << 16;

#[derive(Deserialize)]
struct Extras<'a> {
    #[serde(borrow)]
    enfilade: Option<&'a RawValue>,
}

/// The unread entries of a node's `extras.enfilade`.
struct Notes {
    spoken: String,
    values: Map<String, Value>,
}

impl Notes {
    fn of(document: &Document, number: u32, node: &Node) -> Result<Notes, AuthoringError> {
        Notes::written(document.node_name(number), node.extras)
    }

    fn written(spoken: String, extras: Option<&RawValue>) -> Result<Notes, AuthoringError> {
        let extras = extras.and_then(|extras| serde_json::from_str::<Extras>(extras.get()).ok());
        let ours = extras.and_then(|extras| extras.enfilade).map(RawValue::get);
        // A longer value is not a valid hint, and parsing it might take much more memory than its text.
        let ours = match ours {
            Some(text) if text.len() > MAX_BYTES => Some(Value::String(short(text))),
            text => text.and_then(|text| serde_json::from_str(text).ok()),
        };
        match ours {
            None | Some(Value::Null) => Ok(Notes {
                spoken,
                values: Map::new(),
            }),
            Some(Value::Object(values)) => Ok(Notes { spoken, values }),
            Some(other) => Err(AuthoringError::WrongType {
                node: spoken,
                key: "enfilade",
                found: short(&other.to_string()),
                wanted: "an object such as {\"kind\": \"room\"}",
            }),
        }
    }

    fn kind(&mut self) -> Result<Option<Kind>, AuthoringError> {
        let Some(kind) = self.text("kind")? else {
            return Ok(None);
        };
        let known = KINDS.iter().find(|(name, _)| *name == kind);
        let (_, known) = known.ok_or_else(|| AuthoringError::UnknownKind {
            node: self.spoken.clone(),
            kind: short(&kind),
        })?;
        Ok(Some(*known))
    }

    fn hint(&mut self, kind: Kind, by_name: bool) -> Result<Hint, AuthoringError> {
        Ok(match kind {
            Kind::Room => Hint::Room {
                method: self.method()?,
            },
            Kind::Portal => {
                let way = OpeningTarget::Portal {
                    to: self.text("to")?,
                    one_way: self.truth("one_way")?,
                    exit: self.exit()?,
                };
                Hint::Opening { way, by_name }
            }
            Kind::Mirror => Hint::Opening {
                way: OpeningTarget::Mirror,
                by_name,
            },
            Kind::Terrain => Hint::Terrain,
            Kind::Door => Hint::Door,
        })
    }

    fn exit(&mut self) -> Result<Option<Exit>, AuthoringError> {
        let Some(node) = self.text("exit")? else {
            return Ok(None);
        };
        let scale = match self.values.remove("scale") {
            None | Some(Value::Null) => 1.0,
            Some(written) => match written.as_f64() {
                Some(scale) if scale.is_finite() && scale > 0.0 => scale,
                _ => return Err(self.wrong("scale", &written, "a number above 0")),
            },
        };
        Ok(Some(Exit { node, scale }))
    }

    fn text(&mut self, key: &'static str) -> Result<Option<String>, AuthoringError> {
        match self.values.remove(key) {
            None | Some(Value::Null) => Ok(None),
            Some(Value::String(text)) => Ok(Some(text)),
            Some(other) => Err(self.wrong(key, &other, "a string")),
        }
    }

    /// Reads a boolean; exporters also write 1 or 0.
    fn truth(&mut self, key: &'static str) -> Result<bool, AuthoringError> {
        Ok(self.choice(key)?.unwrap_or(false))
    }

    fn choice(&mut self, key: &'static str) -> Result<Option<bool>, AuthoringError> {
        match self.values.remove(key) {
            None | Some(Value::Null) => Ok(None),
            Some(Value::Bool(truth)) => Ok(Some(truth)),
            Some(Value::Number(number)) if number.as_f64() == Some(1.0) => Ok(Some(true)),
            Some(Value::Number(number)) if number.as_f64() == Some(0.0) => Ok(Some(false)),
            Some(other) => Err(self.wrong(key, &other, "true or false (or 1 or 0)")),
        }
    }

    fn method(&mut self) -> Result<Option<Method>, AuthoringError> {
        let Some(name) = self.text("method")? else {
            return Ok(None);
        };
        let known = Method::by_name(&name).ok_or_else(|| AuthoringError::UnknownMethod {
            node: self.spoken.clone(),
            method: short(&name),
            methods: Method::ALL.map(|method| method.name()).join(", "),
        })?;
        Ok(Some(known))
    }

    fn wrong(&self, key: &'static str, found: &Value, wanted: &'static str) -> AuthoringError {
        AuthoringError::WrongType {
            node: self.spoken.clone(),
            key,
            found: short(&found.to_string()),
            wanted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_of_names_are_hints_with_and_without_a_number() {
        for (name, kind) in [
            ("Hall-room", Some(Kind::Room)),
            ("Hall-room.001", Some(Kind::Room)),
            ("a-b-portal.1234", Some(Kind::Portal)),
            ("-mirror", Some(Kind::Mirror)),
            ("Hill-terrain", Some(Kind::Terrain)),
            ("Hall-room.1", None),
            ("Hall-room.glb", None),
            ("Hall-rooms", None),
            ("room", None),
            ("Hall-room-lamp", None),
            ("", None),
        ] {
            assert_eq!(kind_by_name(name), kind, "{name:?}");
        }
    }
}
