//! Tests authoring errors in rooms and portals: every message names the node and the remedy.

use super::file::{File, refusal, refuses, warnings};
use super::rooms::{door, house, two_rooms, ways};
use enfilade_import::{BrokenRule, Import, ReadOptions, WarningKind, read_bytes};
use serde_json::{Value, json};

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
        "the same opening",
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
    refuses(&file, &["node 4", "`Out`", "is in no room", "`to`"]);
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
    // A square parallel to z: the positions of the box's floor.
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
    refuses(&edgewise, &["node 4 \"Door-portal\"", "-Z", "rotate the node"]);
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
            &["`gate`", "room, portal, mirror, terrain and door"],
        ),
        (json!({ "kind": 3 }), &["kind = 3", "a string"]),
        (json!({ "to": ["B-room"] }), &["to = [\"B-room\"]", "a string"]),
        (json!({ "exit": 1 }), &["exit = 1", "a string"]),
        (
            json!({ "exit": "Out", "scale": 0 }),
            &["scale = 0", "a number above 0"],
        ),
        (
            json!({ "exit": "Out", "scale": "8" }),
            &["scale = \"8\"", "a number above 0"],
        ),
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
            &["method = true", "a string"],
        ),
    ] {
        let file = two_rooms(&[door("Door-portal", extras)]);
        refuses(&file, &["node 4 \"Door-portal\""]);
        refuses(&file, words);
    }
}

/// Two rooms with one good door and a portal or more for each of several mistakes.
fn full_of_mistakes() -> File {
    let portal = |name: &str, extras: Value, at: [f64; 3]| {
        let mut node = door(name, extras);
        node["translation"] = json!(at);
        node
    };
    two_rooms(&[
        door("Good-portal", Value::Null),
        portal("Lost-portal", Value::Null, [50.0, 0.0, 0.0]),
        portal("Wrong-portal", json!({ "one_way": 2 }), [0.0, 0.0, 0.0]),
        portal("Nowhere-portal", json!({ "to": "Attic-room" }), [0.0, 0.0, 0.0]),
        portal("Exitless-portal", json!({ "exit": "Out" }), [0.0, 0.0, 0.0]),
        portal("Second-portal", Value::Null, [0.0, 0.1, 0.0]),
        json!({ "name": "Empty-mirror" }),
    ])
}

const MISTAKES: [(&str, &str); 6] = [
    ("Wrong-portal", "true or false"),
    ("Nowhere-portal", "rooms are A-room, B-room"),
    ("Exitless-portal", "correct the exit"),
    ("Empty-mirror", "give it a flat convex mesh"),
    ("Lost-portal", "touches no room"),
    ("Second-portal", "remove one of them"),
];

fn reads_with(file: &File, options: ReadOptions) -> Import {
    read_bytes(&file.glb(), None, &options).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn all_mistakes_of_a_file_are_named_at_once_each_with_its_node_and_remedy() {
    let text = refusal(&full_of_mistakes().glb()).expect("it is refused");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 1 + MISTAKES.len(), "{text}");
    assert!(lines[0].contains("6 errors in its rooms"), "{text}");
    for (node, remedy) in MISTAKES {
        let named = |line: &&&str| line.contains(&format!("\"{node}\"")) && line.contains(remedy);
        assert_eq!(lines[1..].iter().filter(named).count(), 1, "{node} in {text}");
    }
}

#[test]
fn mistakes_of_rooms_portals_and_terrain_are_named_together() {
    let mut file = full_of_mistakes();
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "method": "bps" } });
    file.node(json!({ "name": "A-room", "mesh": 2, "translation": [0, 9, 0] }));
    file.node(json!({ "name": "Hill-terrain" }));
    let glb = file.glb();
    let error = read_bytes(&glb, None, &ReadOptions::default()).expect_err("it is refused");
    let BrokenRule::Authoring(errors) = &error.rule else {
        panic!("{error}")
    };
    assert_eq!(errors.count(), MISTAKES.len() + 3, "{error}");
    let text = error.to_string();
    for words in ["`bps`", "rename one of them", "terrain without triangles"] {
        assert!(text.contains(words), "{text}");
    }
    assert!(!errors.can_be_skipped() && !errors.flat_ignores_them());
    // Without the portals the rest is still wrong.
    let skipping = ReadOptions {
        skip_bad_portals: true,
        ..ReadOptions::default()
    };
    let error = read_bytes(&glb, None, &skipping).expect_err("rooms are wrong");
    assert!(matches!(error.rule, BrokenRule::Authoring(errors) if errors.count() == 3));
}

#[test]
fn a_thousand_mistakes_are_a_page_and_a_count() {
    let far = |number: usize| {
        let mut node = door(&format!("Far-portal.{number:03}"), Value::Null);
        node["translation"] = json!([50 + number, 0, 0]);
        node
    };
    let nodes: Vec<Value> = (0..1200).map(far).collect();
    let text = refusal(&two_rooms(&nodes).glb()).expect("it is refused");
    assert_eq!(text.lines().count(), 22, "{text}");
    assert!(text.contains("1200 errors in") && text.ends_with("\n  and 1180 more"));
}

#[test]
fn bad_portals_can_be_skipped_and_are_plain_holes_then() {
    let skipping = ReadOptions {
        skip_bad_portals: true,
        ..ReadOptions::default()
    };
    let import = reads_with(&full_of_mistakes(), skipping.clone());
    assert_eq!(
        ways(&import),
        ["Good-portal: A-room -> B-room", "Good-portal: B-room -> A-room"]
    );
    let items: usize = import.rooms.iter().map(|room| room.geometry.items().len()).sum();
    assert_eq!(items, 2, "no portal is drawn");
    let skipped = import.warnings.iter();
    let skipped = skipped.filter(|warning| warning.kind == WarningKind::SkippedPortal);
    assert_eq!(skipped.count(), MISTAKES.len());
    let texts = warnings(&import);
    for (node, remedy) in MISTAKES {
        let named = |text: &&String| {
            text.starts_with("a portal is skipped and becomes a plain hole")
                && text.contains(&format!("\"{node}\""))
                && text.contains(remedy)
        };
        assert_eq!(texts.iter().filter(named).count(), 1, "{node} in {texts:?}");
    }
    // A sound file is read as ever.
    let sound = two_rooms(&[door("Door-portal", Value::Null)]);
    let import = reads_with(&sound, skipping);
    assert_eq!((import.portals.len(), import.warnings.len()), (2, 0));
}

#[test]
fn skipped_portals_beyond_twenty_are_counted() {
    let far = |number: usize| {
        let mut node = door(&format!("Far-portal.{number:03}"), Value::Null);
        node["translation"] = json!([50 + number, 0, 0]);
        node
    };
    let nodes: Vec<Value> = (0..33).map(far).collect();
    let skipping = ReadOptions {
        skip_bad_portals: true,
        ..ReadOptions::default()
    };
    let texts = warnings(&reads_with(&two_rooms(&nodes), skipping));
    assert_eq!(texts.len(), 21);
    assert_eq!(texts[20], "more portals are skipped and become plain holes (13)");
}

#[test]
fn a_file_read_as_flat_ignores_what_is_wrong_with_rooms_and_portals() {
    let mut file = full_of_mistakes();
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "method": "bps" } });
    file.node(json!({ "name": "A-room", "mesh": 0 }));
    let flat = ReadOptions {
        flat: true,
        ..ReadOptions::default()
    };
    let import = reads_with(&file, flat);
    assert_eq!((import.rooms.len(), import.portals.len()), (1, 0));
    assert_eq!(import.rooms[0].geometry.items().len(), 3);
    let texts = warnings(&import);
    assert_eq!(texts.len(), 1, "{texts:?}");
    assert!(
        texts[0].contains("`bps`") && texts[0].contains("true or false"),
        "{texts:?}"
    );
}
