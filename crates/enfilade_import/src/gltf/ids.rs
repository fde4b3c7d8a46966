//! Reads the ids of nodes from their `extras`.
//!
//! [`SourceNodes::id`](crate::SourceNodes::id) defines which values are ids.

use super::document::Document;
use super::nodes::SceneNode;
use crate::BrokenRule;
use crate::budget::Budget;
use serde::Deserializer;
use serde::de::{IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::collections::BTreeMap;
use std::fmt;

/// Keys of ids in lower case and without underscores, in order of preference: a `globalId` is the same in every file of
/// a building, while an `id` may be anything.
const KEYS: [&str; 5] = ["globalid", "ifcguid", "guid", "uuid", "id"];

/// Maximum length of an id, in bytes; a longer string is probably a description.
const MAX_BYTES: usize = 256;

/// Memory of an id in addition to its text, in bytes.
const BYTES_PER_ID: u64 = 64;

/// Reads the ids of nodes that have one, by node index.
pub(super) fn read(
    document: &Document,
    placed: &[SceneNode],
    budget: &mut Budget,
) -> Result<BTreeMap<u32, String>, BrokenRule> {
    let mut ids = BTreeMap::new();
    for placed in placed {
        let extras = document.nodes[placed.node as usize].extras;
        if let Some(id) = extras.and_then(id_in) {
            // Stored twice: here and in the node's room.
            let bytes = 2 * (BYTES_PER_ID + id.len() as u64);
            budget.take(bytes, || format!("{}, its id", document.node_name(placed.node)))?;
            ids.insert(placed.node, id);
        }
    }
    Ok(ids)
}

fn id_in(extras: &RawValue) -> Option<String> {
    let mut text = serde_json::Deserializer::from_str(extras.get());
    // `extras` may be any JSON value; only objects have ids.
    text.deserialize_any(BestId).ok().flatten()
}

/// Finds the preferred id in an object without storing the rest of it.
struct BestId;

impl<'de> Visitor<'de> for BestId {
    type Value = Option<String>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Option<String>, A::Error> {
        let mut best: Option<(usize, String)> = None;
        while let Some(key) = map.next_key::<String>()? {
            let Some(rank) = rank(&key) else {
                map.next_value::<IgnoredAny>()?;
                continue;
            };
            let id = id(map.next_value::<&RawValue>()?);
            if let Some(id) = id.filter(|_| best.as_ref().is_none_or(|(best, _)| rank < *best)) {
                best = Some((rank, id));
            }
        }
        Ok(best.map(|(_, id)| id))
    }
}

fn rank(key: &str) -> Option<usize> {
    let letters = key.bytes().filter(|&letter| letter != b'_');
    let letters = letters.map(|letter| letter.to_ascii_lowercase());
    KEYS.iter().position(|known| letters.clone().eq(known.bytes()))
}

fn id(value: &RawValue) -> Option<String> {
    let value = value.get();
    let is_whole = |text: &str| {
        let digits = text.strip_prefix('-').unwrap_or(text);
        digits.bytes().all(|digit| digit.is_ascii_digit())
    };
    let id = match value.starts_with('"') {
        true => serde_json::from_str(value).ok()?,
        false if is_whole(value) => value.to_owned(),
        false => return None,
    };
    (!id.is_empty() && id.len() <= MAX_BYTES).then_some(id)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id_of(extras: &str) -> Option<String> {
        let extras: &RawValue = serde_json::from_str(extras).expect("JSON");
        id_in(extras)
    }

    #[test]
    fn the_best_key_gives_the_id_however_it_is_written() {
        for (extras, id) in [
            (
                r#"{ "globalId": "2O2Fr$t4X7Zf8NOew3FNtn" }"#,
                "2O2Fr$t4X7Zf8NOew3FNtn",
            ),
            (r#"{ "id": 3, "GlobalId": "g", "guid": "u" }"#, "g"),
            (r#"{ "ifc_guid": "a\u00e9b", "Id": "x" }"#, "aéb"),
            (r#"{ "UUID": "u", "name": { "id": "not this one" } }"#, "u"),
            (r#"{ "globalId": null, "id": -12 }"#, "-12"),
            (r#"{ "id": 18446744073709551616 }"#, "18446744073709551616"),
        ] {
            assert_eq!(id_of(extras).as_deref(), Some(id), "{extras}");
        }
    }

    #[test]
    fn what_is_no_text_and_no_whole_number_is_no_id() {
        for extras in [
            "{}",
            "[1]",
            "12",
            "\"id\"",
            r#"{ "name": "wall", "identity": "x" }"#,
            r#"{ "id": "" }"#,
            r#"{ "id": 1.5 }"#,
            r#"{ "id": { "id": "x" } }"#,
            r#"{ "id": true }"#,
            &format!(r#"{{ "id": "{}" }}"#, "x".repeat(257)),
        ] {
            assert_eq!(id_of(extras), None, "{extras}");
        }
    }
}
