//! Writes the visibility method of each room into a copy of a file.
//!
//! The methods are stored as an author would write them, not in a separate file. The JSON is serialized anew, so its
//! keys may change order.

use super::affected::Affected;
use super::container::{Container, is_binary, joined};
use super::document::{Document, repaired};
use super::plan::Plan;
use crate::budget::Budget;
use crate::faults::Faults;
use crate::warning::Warnings;
use crate::{BrokenRule, ReadOptions};
use enfilade::Method;
use serde_json::{Map, Value, json};

/// Returns a copy of a file in which room n has method n; the method of the room for nodes outside every room is stored
/// in the scene. `None` if a `.glb` would exceed its size limit.
pub(crate) fn with_methods(
    bytes: &[u8],
    methods: &[Method],
    mut budget: Budget,
) -> Result<Option<Vec<u8>>, BrokenRule> {
    let container = Container::split(bytes)?;
    let plain = repaired(container.json, &mut budget, &mut Warnings::default())?;
    let document = Document::parse(&plain, &mut budget)?;
    // Only rooms matter here. Invalid portals were accepted or rejected when the file was read.
    let mut faults = Faults::new(&ReadOptions {
        skip_bad_portals: true,
        ..ReadOptions::default()
    });
    let plan = Plan::new(
        &document,
        false,
        Affected::default(),
        &mut faults,
        &mut Warnings::default(),
    )?;
    faults.into_result()?;
    let rooms = plan.room_nodes();
    // Upper estimate of the parsed JSON, with a separate value for every number.
    budget.take(container.json.len() as u64 * BYTES_OF_VALUES, || {
        "its JSON, to be written again".to_owned()
    })?;
    let mut json: Value =
        serde_json::from_slice(container.json).map_err(|why| BrokenRule::Json(why.to_string()))?;
    for (&node, method) in rooms.iter().zip(methods) {
        pin(&mut json["nodes"][node as usize], *method);
    }
    if let Some(method) = methods.get(rooms.len()) {
        if document.scenes.is_empty() {
            json["scenes"] = json!([{ "nodes": super::nodes::scene_roots(&document)? }]);
            json["scene"] = json!(0);
        }
        pin(&mut json["scenes"][document.scene.unwrap_or(0) as usize], *method);
    }
    Ok(if is_binary(bytes) {
        joined(json.to_string().as_bytes(), container.binary.unwrap_or_default())
    } else {
        Some(format!("{json:#}\n").into_bytes())
    })
}

/// Approximate maximum of parsed JSON bytes per byte of text.
const BYTES_OF_VALUES: u64 = 16;

fn pin(thing: &mut Value, method: Method) {
    let mut extras = thing.get_mut("extras").map_or(Value::Null, Value::take);
    if !extras.is_object() {
        // Keeps `extras` that are not an object as `was` of a new object.
        let was = std::mem::replace(&mut extras, Value::Object(Map::new()));
        if !was.is_null() {
            extras["was"] = was;
        }
    }
    if !extras["enfilade"].is_object() {
        extras["enfilade"] = json!({});
    }
    extras["enfilade"]["method"] = json!(method.name());
    thing["extras"] = extras;
}
