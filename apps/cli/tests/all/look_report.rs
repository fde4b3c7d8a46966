//! The report of `look --json`: its schema, and what it says of each visible item.

use crate::support::schema::broken;
use crate::support::{Folder, document, glb};
use enfilade::Method;
use serde_json::{Value, json};

fn schema() -> Value {
    let text = include_str!("../../../../book/src/look.schema.json");
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn reports_are_as_the_schema_says() {
    let folder = Folder::new();
    let schema = schema();
    for arguments in [
        "look scene.glb",
        "look scene.glb --path views.jsonl --check",
        "look scene.glb --method all --check",
        "look scene.glb --survey 3 --method auto",
        "look @enfilade --check",
        "look @enfilade --memory 1 --method all",
    ] {
        let report = folder.json(&format!("{arguments} --size 64x36"));
        assert_eq!(broken(&schema, &report), [""; 0], "{arguments}");
    }
}

#[test]
fn a_report_that_breaks_the_schema_is_found_out() {
    let schema = schema();
    let report = Folder::new().json("look scene.glb --size 64x36 --check");
    let broken_by = |pointer: &str, value: Value| {
        let mut report = report.clone();
        *report.pointer_mut(pointer).expect("it is there") = value;
        broken(&schema, &report).join("\n")
    };
    for (pointer, value, why) in [
        (
            "/views/0/visible_items/0",
            json!({ "name": "a" }),
            "has no size_px",
        ),
        ("/views/0/visible_items/0/node", json!(-1), "below 0"),
        ("/views/0/check/missed", json!([3]), "is no \\\"string\\\""),
        ("/views/0/eye", json!([1, 2]), "shorter than 3"),
        ("/contract", json!("sure"), "is none of"),
        ("/summary", json!({ "speed": 1 }), "speed: is not in the schema"),
    ] {
        let found = broken_by(pointer, value);
        assert!(found.contains(why), "{pointer}: {found}");
    }
}

#[test]
fn the_schema_knows_every_method() {
    let mut names: Vec<&str> = Method::ALL.map(Method::name).into();
    names.extend(["own", "auto"]);
    assert_eq!(schema()["$defs"]["method"]["enum"], json!(names));
}

#[test]
fn visible_items_have_the_nodes_ids_and_sizes_of_what_is_visible() {
    let folder = Folder::new();
    let nodes = [
        json!({ "name": "near", "mesh": 0, "extras": { "globalId": "2O2Fr$t4X7Zf8NOew3FNtn" } }),
        json!({ "name": "twin", "mesh": 0, "translation": [2, 0, 0], "extras": { "id": 7 } }),
        json!({ "name": "twin", "mesh": 0, "translation": [-2, 0, 0] }),
    ];
    folder.add("blocks.glb", glb(&document(&nodes, json!([]))));
    let report = folder.json("look blocks.glb --eye 0,0,5 --toward 0,0,0 --size 64x64 --fov 90");
    let view = &report["views"][0];
    assert_eq!(view["visible"], json!(["near", "twin#1", "twin#2"]));
    // A side of 1 at a distance of 4.5 is 7.1 of 64 pixels at 90 degrees, and meets 8 of their centres at most.
    let size = view["visible_items"][0]["size_px"].as_u64();
    assert!((Some(7)..=Some(9)).contains(&size), "{size:?}");
    let without_sizes = |items: &Value| {
        let mut items = items.as_array().cloned().expect("a list");
        items.iter_mut().for_each(|item| {
            item.as_object_mut().expect("an item").remove("size_px");
        });
        Value::Array(items)
    };
    assert_eq!(
        without_sizes(&view["visible_items"]),
        json!([
            { "name": "near", "node": 0, "id": "2O2Fr$t4X7Zf8NOew3FNtn" },
            { "name": "twin#1", "node": 1, "id": "7" },
            { "name": "twin#2", "node": 2 },
        ])
    );
}

#[test]
fn items_of_maps_and_built_in_scenes_have_neither_nodes_nor_ids() {
    let folder = Folder::empty();
    folder.add("room.bsp", crate::support::map::map(true));
    for scene in ["@enfilade", "room.bsp"] {
        let report = folder.json(&format!("look {scene} --size 64x36"));
        let items = report["views"][0]["visible_items"].as_array().expect("a list");
        assert!(!items.is_empty());
        for item in items {
            assert_eq!(
                (&item["node"], &item["id"]),
                (&Value::Null, &Value::Null),
                "{item}"
            );
        }
    }
}
