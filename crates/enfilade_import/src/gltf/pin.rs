//! Writes into a copy of a file by which method each of its rooms is to be seen.

use super::container::{Container, is_binary, joined};
use super::document::Document;
use super::plan::Plan;
use crate::budget::Budget;
use crate::faults::Faults;
use crate::warning::Warnings;
use crate::{BrokenRule, ReadOptions};
use enfilade::Method;
use serde_json::{Map, Value, json};

/// A copy of a file of which room n is seen by method n; of what stands in no room its scene says it. `None` where a `.glb`
/// would be larger than one can be.
pub(crate) fn with_methods(
    bytes: &[u8],
    methods: &[Method],
    mut budget: Budget,
) -> Result<Option<Vec<u8>>, BrokenRule> {
    let container = Container::split(bytes)?;
    let document = Document::parse(container.json, &mut budget)?;
    // Only rooms matter here. Whether bad portals are tolerated was decided when the file was read.
    let mut faults = Faults::new(&ReadOptions {
        skip_bad_portals: true,
        ..ReadOptions::default()
    });
    let plan = Plan::new(&document, false, &mut faults, &mut Warnings::default())?;
    faults.into_result()?;
    let rooms = plan.room_nodes();
    // As large as it can be once read, with every number a value of its own.
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

/// Bytes of values for each byte of text, at most about.
const BYTES_OF_VALUES: u64 = 16;

fn pin(thing: &mut Value, method: Method) {
    let mut extras = thing.get_mut("extras").map_or(Value::Null, Value::take);
    if !extras.is_object() {
        // Something else can stand there, which goes by a name now.
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
