//! Tests node transforms, item names and cameras.

use super::file::{File, reads, triangles, warnings};
use enfilade::ItemIndex;
use enfilade_import::Import;
use serde_json::{Value, json};

/// The leaf's mesh without its node, then these nodes.
fn forest(nodes: Value) -> File {
    let mut file = File::leaf();
    file.json["nodes"] = nodes;
    file
}

fn names(import: &Import) -> Vec<&str> {
    let geometry = &import.rooms[0].geometry;
    (0..geometry.items().len() as u32)
        .map(|item| geometry.name(ItemIndex(item)))
        .collect()
}

#[test]
fn children_stand_where_their_parents_put_them() {
    let turn = json!([0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()]);
    // Columns: twice as wide along x, then moved by (10, 0, 0).
    let matrix = json!([2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1]);
    for (what, nodes, expected) in [
        (
            "a translation",
            json!([{ "name": "A", "mesh": 0, "translation": [1, 2, 3] }]),
            "A 1,2,3 2,2,3 1,3,3",
        ),
        (
            "a scale",
            json!([{ "name": "A", "mesh": 0, "scale": [2, 3, 1] }]),
            "A 0,0,0 2,0,0 0,3,0",
        ),
        (
            "a turn about z",
            json!([{ "name": "A", "mesh": 0, "rotation": turn }]),
            "A -1,0,0 0,0,0 0,1,0",
        ),
        (
            "a turn of any length",
            json!([{ "name": "A", "mesh": 0, "rotation": [0, 0, 1e-200, 1e-200] }]),
            "A -1,0,0 0,0,0 0,1,0",
        ),
        (
            "a matrix",
            json!([{ "name": "A", "mesh": 0, "matrix": matrix }]),
            "A 10,0,0 12,0,0 10,1,0",
        ),
        (
            "scale first, then turn, then move",
            json!([{ "name": "A", "mesh": 0, "translation": [5, 0, 0], "rotation": turn, "scale": [2, 1, 1] }]),
            "A 4,0,0 5,0,0 5,2,0",
        ),
        (
            "a child of a moved and scaled parent",
            json!([
                { "children": [1], "translation": [10, 0, 0], "scale": [2, 2, 2] },
                { "name": "A", "mesh": 0, "translation": [1, 0, 0] }
            ]),
            "A 12,0,0 14,0,0 12,2,0",
        ),
    ] {
        assert_eq!(triangles(&reads(&forest(nodes))), [expected], "{what}");
    }
}

#[test]
fn far_parents_and_children_lose_no_digits_on_the_way() {
    // In f32 alone, 16777217 would become 16777216 before the child brings it back.
    let nodes = json!([
        { "children": [1], "translation": [16_777_217, 0, 0] },
        { "name": "A", "mesh": 0, "translation": [-16_777_216, 0, 0] }
    ]);
    assert_eq!(triangles(&reads(&forest(nodes))), ["A 1,0,0 2,0,0 1,1,0"]);
}

#[test]
fn a_mirrored_node_keeps_its_faces_and_says_that_it_mirrors() {
    let import = reads(&forest(json!([
        { "name": "Left", "mesh": 0 },
        { "name": "Right", "mesh": 0, "scale": [-1, 1, 1] }
    ])));
    let mirrors: Vec<bool> = import.rooms[0]
        .geometry
        .items()
        .iter()
        .map(|item| item.transform().mirrors())
        .collect();
    assert_eq!(mirrors, [false, true]);
    // Corners keep their order, which defines front and back.
    assert_eq!(
        triangles(&import),
        ["Left 0,0,0 1,0,0 0,1,0", "Right -1,0,0 0,1,0 0,0,0"]
    );
}

#[test]
fn a_node_is_named_by_its_number_where_its_name_is_missing_or_repeats() {
    let mesh = |name: &str| json!({ "name": name, "mesh": 0 });
    for (nodes, expected) in [
        (json!([mesh("A"), mesh("B")]), vec!["A", "B"]),
        (json!([mesh("A"), mesh("B"), mesh("A")]), vec!["A#0", "B", "A#2"]),
        (
            json!([{ "mesh": 0 }, mesh(""), mesh("A")]),
            vec!["node#0", "node#1", "A"],
        ),
        // Only nodes with meshes count.
        (
            json!([mesh("A"), { "name": "A" }, { "name": "A", "children": [0] }]),
            vec!["A"],
        ),
        // A node's own name goes before one that is made.
        (
            json!([mesh("A#2"), mesh("A"), mesh("A")]),
            vec!["A#2", "A#1", "A#2#2"],
        ),
        (json!([mesh("node#1"), { "mesh": 0 }]), vec!["node#1", "node#1#1"]),
        (
            json!([mesh("A#1"), mesh("A"), mesh("A"), mesh("A#1")]),
            vec!["A#1#0", "A#1", "A#2", "A#1#3"],
        ),
    ] {
        assert_eq!(names(&reads(&forest(nodes.clone()))), expected, "{nodes}");
    }
}

#[test]
fn only_the_default_scene_is_read() {
    let nodes = json!([
        { "name": "A", "mesh": 0 },
        { "name": "B", "mesh": 0, "children": [2] },
        { "name": "C", "mesh": 0 }
    ]);
    let two = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    for (scene, scenes, expected) in [
        (Value::Null, Value::Null, vec!["A", "B", "C"]),
        (Value::Null, two.clone(), vec!["A"]),
        (json!(0), two.clone(), vec!["A"]),
        (json!(1), two, vec!["B", "C"]),
        (json!(0), json!([{ "nodes": [1, 0, 1] }]), vec!["A", "B", "C"]),
    ] {
        let mut file = forest(nodes.clone());
        file.json["scene"] = scene;
        if !scenes.is_null() {
            file.json["scenes"] = scenes;
        }
        assert_eq!(names(&reads(&file)), expected);
    }
}

#[test]
fn a_name_does_not_depend_on_which_scene_is_read() {
    let mut file = forest(json!([{ "name": "A", "mesh": 0 }, { "name": "A", "mesh": 0 }]));
    file.json["scenes"] = json!([{ "nodes": [1] }]);
    assert_eq!(names(&reads(&file)), ["A#1"]);
}

#[test]
fn a_chain_of_100_000_nodes_is_as_deep_as_it_is() {
    const LENGTH: usize = 100_000;
    let mut nodes: Vec<Value> = (1..LENGTH)
        .map(|child| json!({ "children": [child], "translation": [0.25, 0, 0] }))
        .collect();
    nodes.push(json!({ "name": "End", "mesh": 0 }));
    let import = reads(&forest(Value::Array(nodes)));
    assert_eq!(triangles(&import), ["End 24999.75,0,0 25000.75,0,0 24999.75,1,0"]);
}

fn with_camera(camera: Value, node: Value) -> Import {
    let mut file = File::leaf();
    file.json["cameras"] = json!([camera]);
    file.node(node);
    reads(&file)
}

fn lens(yfov: f64, znear: f64) -> Value {
    json!({ "type": "perspective", "perspective": { "yfov": yfov, "znear": znear } })
}

#[test]
fn a_camera_stands_in_the_world_and_looks_along_its_negative_z() {
    let half = 0.5_f64.sqrt();
    for (node, eye, toward, up) in [
        (
            json!({ "camera": 0 }),
            [0.0; 3],
            [0.0, 0.0, -1.0],
            [0.0, 1.0, 0.0],
        ),
        (
            json!({ "camera": 0, "translation": [1, 2, 3] }),
            [1.0, 2.0, 3.0],
            [1.0, 2.0, 2.0],
            [0.0, 1.0, 0.0],
        ),
        // A quarter turn about x: it looks up, and up points back.
        (
            json!({ "camera": 0, "rotation": [half, 0.0, 0.0, half] }),
            [0.0; 3],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ),
        // Scale does not count.
        (
            json!({ "camera": 0, "scale": [5, 5, 5] }),
            [0.0; 3],
            [0.0, 0.0, -1.0],
            [0.0, 1.0, 0.0],
        ),
        // Far out, a step of one would drown in rounding.
        (
            json!({ "camera": 0, "translation": [1e7, 0, 0] }),
            [1e7, 0.0, 0.0],
            [1e7, 0.0, -1e4],
            [0.0, 1.0, 0.0],
        ),
    ] {
        let import = with_camera(lens(1.0, 0.1), node.clone());
        let camera = &import.cameras[0];
        for (found, expected) in [(camera.eye, eye), (camera.toward, toward), (camera.up, up)] {
            assert!(
                (0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-6),
                "{node}: {camera:?}"
            );
        }
        assert_eq!(
            (camera.fov_y, camera.z_near, &*camera.name),
            (1.0, Some(0.1), "node#1")
        );
    }
}

#[test]
fn cameras_that_make_no_picture_are_left_out_with_a_warning() {
    let orthographic = |ymag: f64, znear: f64, zfar: f64| json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": ymag, "znear": znear, "zfar": zfar } });
    let bad = "cameras with an invalid angle, near plane or transform are ignored (node 1 \"Eye\")";
    for (camera, scale) in [
        (orthographic(0.0, 0.1, 9.0), 1),
        (orthographic(-2.0, 0.1, 9.0), 1),
        (orthographic(1.0, -0.1, 9.0), 1),
        (orthographic(1.0, 9.0, 0.1), 1),
        (orthographic(1e39, 0.1, 9.0), 1),
        (orthographic(1e-38, 0.1, 1e37), 1),
        (orthographic(1.0, 0.1, 9.0), 0),
        (json!({ "type": "fisheye" }), 1),
        (json!({ "type": "perspective" }), 1),
        (json!({ "type": "orthographic" }), 1),
        (lens(0.0, 0.1), 1),
        (lens(3.5, 0.1), 1),
        (lens(1.0, 0.0), 1),
        (lens(1.0, 0.1), 0),
    ] {
        let import = with_camera(
            camera.clone(),
            json!({ "name": "Eye", "camera": 0, "scale": [scale, scale, scale] }),
        );
        assert!(import.cameras.is_empty(), "{camera}");
        assert_eq!(warnings(&import), [bad], "{camera}");
    }
}

#[test]
fn items_know_their_nodes_and_what_other_programs_call_these() {
    let mut file = forest(json!([
        { "name": "Hall-room", "children": [3, 1] },
        { "name": "wall", "mesh": 0, "extras": { "ifcClass": "IfcWall", "globalId": "2O2Fr$t4X7Zf8NOew3FNtn" } },
        { "name": "wall", "mesh": 0, "extras": { "id": 12 } },
        { "name": "tree", "mesh": 0, "extras": { "GUID": "t" },
          "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 2 } } } },
        { "name": "stone", "mesh": 0, "translation": [0, 0, 50], "extras": "no object" },
    ]));
    file.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file.floats(&[5.0, 0.0, 0.0, 0.0, 7.0, 0.0], 3);
    let import = reads(&file);
    let items: Vec<String> = import
        .rooms
        .iter()
        .flat_map(|room| {
            let items = (0..room.geometry.items().len() as u32).map(ItemIndex);
            items.map(|item| {
                let (node, id) = (room.nodes.node(item), room.nodes.id(item));
                format!("{} {node:?} {}", room.geometry.name(item), id.unwrap_or("-"))
            })
        })
        .collect();
    assert_eq!(
        items,
        [
            "wall#1 Some(1) 2O2Fr$t4X7Zf8NOew3FNtn",
            "tree[0] Some(3) t",
            "tree[1] Some(3) t",
            "wall#2 Some(2) 12",
            "stone Some(4) -",
        ]
    );
}

#[test]
fn doors_by_extras_and_what_animations_move_can_move() {
    let mut file = forest(json!([
        { "name": "wall", "mesh": 0 },
        { "name": "leaf", "children": [2], "extras": { "enfilade": { "kind": "door" } } },
        { "name": "panel", "mesh": 0 },
        { "name": "gate", "mesh": 0 },
        { "name": "face", "mesh": 0 },
    ]));
    let channel = |node: u32, path: &str| json!({ "sampler": 0, "target": { "node": node, "path": path } });
    file.json["animations"] = json!([
        { "channels": [channel(3, "rotation"), channel(4, "weights"), channel(99, "translation")], "samplers": [] },
    ]);
    let import = reads(&file);
    let can_move: Vec<bool> = (0..4)
        .map(|item| import.rooms[0].nodes.is_movable(ItemIndex(item)))
        .collect();
    assert_eq!(names(&import), ["wall", "panel", "gate", "face"]);
    assert_eq!(can_move, [false, true, true, false]);
}
