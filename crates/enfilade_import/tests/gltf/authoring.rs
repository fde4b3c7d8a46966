//! What authors do wrong with rooms and portals: every message names the node and the remedy.

use crate::file::{File, refusal};
use crate::rooms::{door, house, two_rooms};
use serde_json::{Value, json};

#[track_caller]
fn refuses(file: &File, words: &[&str]) {
    let text = refusal(&file.glb()).expect("it is refused");
    for word in words {
        assert!(text.contains(word), "`{text}` does not say `{word}`");
    }
}

#[test]
fn a_portal_that_does_not_stand_between_two_rooms() {
    let at = |x: f64| {
        let mut node = door("Door-portal", Value::Null);
        node["translation"] = json!([x, 0, 0]);
        two_rooms(&[node])
    };
    refuses(&at(50.0), &["node 4 \"Door-portal\"", "touches no room", "-room"]);
    for x in [-1.0, 1.0, 2.0] {
        refuses(
            &at(x),
            &["node 4 \"Door-portal\"", "touches only one room", "`to`"],
        );
    }
    refuses(&at(-2.0), &["node 0 \"A-room\""]);
}

#[test]
fn two_portals_for_one_opening() {
    let other = |x: f64, y: f64| {
        let mut node = door("Gate-portal", json!({ "one_way": true, "to": "B-room" }));
        node["translation"] = json!([x, y, 0]);
        two_rooms(&[door("Door-portal", Value::Null), node])
    };
    let words = [
        "node 4 \"Door-portal\"",
        "node 5 \"Gate-portal\"",
        "one opening",
        "remove one",
    ];
    refuses(&other(0.0, 0.0), &words);
    refuses(&other(0.01, 0.2), &words);
    assert_eq!(refusal(&other(0.0, 0.9).glb()), None);
}

#[test]
fn names_of_rooms_and_exits_that_are_not_there_or_not_clear() {
    let with = |extras: Value| two_rooms(&[door("Door-portal", extras)]);
    refuses(
        &with(json!({ "to": "C-room" })),
        &["node 4 \"Door-portal\"", "`C-room`", "rooms are A-room, B-room"],
    );
    refuses(
        &with(json!({ "exit": "Out" })),
        &["node 4", "`Out`", "correct the exit"],
    );
    let mut file = with(json!({ "exit": "Out" }));
    file.node(json!({ "name": "Out", "translation": [1, 0, 0] }));
    file.node(json!({ "name": "Out" }));
    refuses(&file, &["node 5 \"Out\"", "node 6 \"Out\"", "rename one"]);
    let mut file = with(json!({ "exit": "Out" }));
    file.node(json!({ "name": "Out", "translation": [500, 0, 0] }));
    refuses(&file, &["node 4", "`Out`", "stands in no room", "`to`"]);
}

#[test]
fn a_teleport_that_has_no_direction() {
    let teleport = |key: &str, value: Value| {
        let mut node = json!({
            "name": "Door-portal", "mesh": 1, "extras": { "enfilade": { "exit": "Out" } }, "translation": [-1, 0, 0]
        });
        node[key] = value;
        two_rooms(&[
            node,
            json!({ "name": "Out", "translation": [1, 0, 0], "scale": [1, 1, 1] }),
        ])
    };
    let mut flat = teleport("name", json!("Door-portal"));
    flat.json["nodes"][5]["scale"] = json!([0, 0, 0]);
    refuses(&flat, &["node 5 \"Out\"", "scale of 0"]);
    // A square that lies along z: the positions of the box's floor.
    let mut edgewise = teleport("name", json!("Door-portal"));
    let floor = edgewise.primitive(
        &[
            [-0.5, 0.0, -0.5],
            [0.5, 0.0, -0.5],
            [0.5, 0.0, 0.5],
            [-0.5, 0.0, 0.5],
        ],
        &[0, 1, 2, 0, 2, 3],
    );
    let mesh = edgewise.mesh(json!([floor]));
    edgewise.json["nodes"][4]["mesh"] = json!(mesh);
    refuses(&edgewise, &["node 4 \"Door-portal\"", "-Z", "turn the node"]);
}

#[test]
fn a_portal_that_is_no_flat_convex_polygon() {
    let with = |positions: &[[f32; 3]], indices: &[u16]| {
        let mut file = two_rooms(&[door("Door-portal", Value::Null)]);
        let primitive = file.primitive(positions, indices);
        let mesh = file.mesh(json!([primitive]));
        file.json["nodes"][4]["mesh"] = json!(mesh);
        file
    };
    let bent = [
        [-0.5, -0.5, 0.0],
        [0.5, -0.5, 0.2],
        [0.5, 0.5, 0.0],
        [-0.5, 0.5, 0.2],
    ];
    refuses(
        &with(&bent, &[0, 1, 2, 0, 2, 3]),
        &["node 4 \"Door-portal\"", "not flat", "flatten"],
    );
    let notched = [
        [-0.5, -0.5, 0.0],
        [0.5, -0.5, 0.0],
        [-0.3, -0.3, 0.0],
        [-0.5, 0.5, 0.0],
    ];
    refuses(
        &with(&notched, &[0, 1, 2, 0, 2, 3]),
        &["node 4", "not convex", "bounding rectangle"],
    );
    refuses(
        &with(&[[0.0; 3]; 3], &[0, 1, 2]),
        &["node 4", "without area", "scale"],
    );
    let many: Vec<u16> = [0, 1, 2].repeat(50_001);
    refuses(&with(&bent, &many), &["node 4", "50001 triangles", "simplify"]);
    let mut file = two_rooms(&[door("Door-portal", Value::Null)]);
    file.json["nodes"][4]
        .as_object_mut()
        .expect("a node")
        .remove("mesh");
    refuses(
        &file,
        &["node 4 \"Door-portal\"", "no faces", "give it a flat convex mesh"],
    );
}

#[test]
fn rooms_that_cannot_be_told_apart() {
    refuses(
        &house(json!([
            { "name": "Hall-room", "mesh": 0 },
            { "name": "Hall-room", "mesh": 0, "translation": [9, 0, 0] },
        ])),
        &["node 0 \"Hall-room\"", "node 1 \"Hall-room\"", "rename one"],
    );
    let overlapping = |x: f64, scale: f64| {
        house(json!([
            { "name": "A-room", "mesh": 0 },
            { "name": "B-room", "mesh": 0, "translation": [x, 0, 0], "scale": [scale, scale, scale] },
        ]))
    };
    let words = [
        "node 0 \"A-room\"",
        "node 1 \"B-room\"",
        "overlap",
        "move one of them",
    ];
    refuses(&overlapping(1.0, 1.0), &words);
    refuses(&overlapping(0.0, 1.0), &words);
    // One within the other, or side by side.
    for (x, scale) in [(0.0, 3.0), (0.2, 0.5), (2.0, 1.0)] {
        assert_eq!(refusal(&overlapping(x, scale).glb()), None, "{x} {scale}");
    }
}

#[test]
fn openings_without_rooms() {
    let mirror = |extras: Value| json!({ "name": "Glass", "mesh": 1, "extras": { "enfilade": extras } });
    refuses(
        &house(json!([{ "name": "Hall", "mesh": 0 }, mirror(json!({ "kind": "mirror" }))])),
        &["node 1 \"Glass\"", "no rooms", "NAME-room"],
    );
    let mut far = mirror(json!({ "kind": "mirror" }));
    far["translation"] = json!([0, 90, 0]);
    refuses(&two_rooms(&[far]), &["node 4 \"Glass\"", "touches no room"]);
}

#[test]
fn a_one_way_portal_that_does_not_say_which_way() {
    refuses(
        &two_rooms(&[door("Door-portal", json!({ "one_way": true }))]),
        &[
            "node 4 \"Door-portal\"",
            "A-room",
            "B-room",
            "belongs to neither",
            "`to`",
        ],
    );
}

#[test]
fn extras_of_the_wrong_type_or_with_unknown_words() {
    for (extras, words) in [
        (json!(5), &["enfilade = 5", "an object such as"][..]),
        (
            json!({ "kind": "gate" }),
            &["`gate`", "room, portal, mirror and terrain"],
        ),
        (json!({ "kind": 3 }), &["kind = 3", "a text"]),
        (json!({ "to": ["B-room"] }), &["to = [\"B-room\"]", "a text"]),
        (json!({ "exit": 1 }), &["exit = 1", "a text"]),
        (json!({ "one_way": 2 }), &["one_way = 2", "true or false"]),
        (
            json!({ "one_way": "yes" }),
            &["one_way = \"yes\"", "true or false"],
        ),
        (
            json!({ "kind": "room", "method": "bps" }),
            &["`bps`", "hierarchical-z"],
        ),
        (
            json!({ "kind": "room", "method": true }),
            &["method = true", "a text"],
        ),
    ] {
        let file = two_rooms(&[door("Door-portal", extras)]);
        refuses(&file, &["node 4 \"Door-portal\""]);
        refuses(&file, words);
    }
}
