//! Marks on nodes whose meshes are one or more nodes below, as packers and authors put them.

use super::file::{File, reads, refuses, warnings};
use super::grid::Grid;
use super::rooms::{door, two_rooms, ways};
use enfilade::{ItemIndex, Method};
use enfilade_import::{Import, ReadOptions, read_bytes};
use serde_json::{Value, json};

/// The door of two rooms without its mesh; `below` are the nodes below it, whose first is node 5.
fn door_over(enfilade: Value, children: &[usize], below: &[Value]) -> File {
    let mut node = door("AB-portal", enfilade);
    node.as_object_mut().expect("a node").remove("mesh");
    node["children"] = json!(children);
    let more: Vec<Value> = std::iter::once(node).chain(below.iter().cloned()).collect();
    two_rooms(&more)
}

/// The openings of the first room: their corners, sorted, to a millimetre.
fn corners(import: &Import) -> Vec<[f32; 3]> {
    let openings = import.rooms[0].geometry.openings().iter();
    let rounded = |corner: &[f32; 3]| corner.map(|value| (value * 1000.0).round() / 1000.0 + 0.0);
    let mut all: Vec<[f32; 3]> = openings
        .flat_map(|opening| opening.outline.corners().iter().map(rounded))
        .collect();
    all.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
    all
}

fn items(import: &Import) -> usize {
    import.rooms.iter().map(|room| room.geometry.items().len()).sum()
}

#[test]
fn a_door_is_the_same_with_its_mesh_at_its_node_or_below_it() {
    let plain = reads(&two_rooms(&[door("AB-portal", Value::Null)]));
    let (expected, outline) = (ways(&plain), corners(&plain));
    assert_eq!((expected.len(), outline.len(), items(&plain)), (2, 4, 2));
    let square = json!({ "mesh": 1 });
    let chain = [
        json!({ "children": [6] }),
        json!({ "name": "x", "children": [7], "scale": [2, 2, 2] }),
        json!({ "mesh": 1, "scale": [0.5, 0.5, 0.5] }),
    ];
    let halves = [
        json!({ "mesh": 1, "scale": [0.5, 1, 1], "translation": [-0.25, 0, 0] }),
        json!({ "mesh": 1, "scale": [0.5, 1, 1], "translation": [0.25, 0, 0], "name": "right" }),
    ];
    let kind = json!({ "kind": "portal" });
    let none = Value::Null;
    let mut quantized = door_over(
        none.clone(),
        &[5],
        &[
            json!({ "mesh": 3, "translation": [-0.5, -0.5, 0], "scale": [1.0 / 4095.0, 1.0 / 4095.0, 1.0 / 4095.0] }),
        ],
    );
    let bytes = [
        [0_u16, 0, 0, 0],
        [4095, 0, 0, 0],
        [4095, 4095, 0, 0],
        [0, 4095, 0, 0],
    ];
    let bytes: Vec<u8> = bytes
        .as_flattened()
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    let positions = quantized.accessor(5123, "VEC3", 4, bytes);
    let view = quantized.json["accessors"][positions]["bufferView"]
        .as_u64()
        .expect("a view");
    quantized.json["bufferViews"][view as usize]["byteStride"] = json!(8);
    let indices = quantized.json["meshes"][1]["primitives"][0]["indices"].clone();
    quantized.mesh(json!([{ "attributes": { "POSITION": positions }, "indices": indices }]));
    for (what, file) in [
        (
            "in a child",
            door_over(none.clone(), &[5], std::slice::from_ref(&square)),
        ),
        (
            "marked by extras",
            door_over(kind, &[5], std::slice::from_ref(&square)),
        ),
        ("three below", door_over(none.clone(), &[5], &chain)),
        ("in two halves", door_over(none.clone(), &[5, 6], &halves)),
        ("quantized", quantized),
        (
            "invisible",
            door_over(
                none.clone(),
                &[5],
                &[json!({ "mesh": 1, "extensions": { "KHR_node_visibility": { "visible": false } } })],
            ),
        ),
    ] {
        let import = reads(&file);
        assert_eq!(ways(&import), expected, "{what}");
        assert_eq!(corners(&import), outline, "{what}");
        assert_eq!(items(&import), 2, "{what}: the opening is not drawn");
        assert_eq!(warnings(&import), [""; 0], "{what}");
    }
}

#[test]
fn a_door_has_its_own_mesh_alone_if_it_has_one() {
    let mut node = door("AB-portal", Value::Null);
    node["children"] = json!([5]);
    let import = reads(&two_rooms(&[node, json!({ "name": "handle", "mesh": 2 })]));
    assert_eq!((ways(&import).len(), items(&import)), (2, 3));
}

#[test]
fn what_is_marked_below_a_marked_node_is_its_own() {
    // The mirror below the empty portal keeps its square, and what is below that; so the portal has one square.
    let mirror = json!({ "name": "B-mirror", "mesh": 1, "translation": [0, 0, 0.9], "children": [7] });
    let file = door_over(
        Value::Null,
        &[5, 6],
        &[
            json!({ "mesh": 1 }),
            mirror,
            json!({ "name": "frame", "mesh": 2 }),
        ],
    );
    let import = reads(&file);
    let mut found = ways(&import);
    found.sort();
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[2].starts_with("B-mirror"), "{found:?}");
    assert_eq!(items(&import), 3, "the frame is drawn");
}

#[test]
fn a_mirror_may_have_its_mesh_below_and_is_drawn_in_a_flat_file() {
    let turn = [0.0, -(0.5_f64.sqrt()), 0.0, 0.5_f64.sqrt()];
    let file = two_rooms(&[
        json!({ "name": "A-mirror", "rotation": turn, "translation": [-1.9, 0, 0], "children": [5] }),
        json!({ "mesh": 1 }),
    ]);
    assert_eq!(ways(&reads(&file)), ["A-mirror: A-room -> A-room"]);
    let flat = |file: &File| {
        let options = ReadOptions {
            flat: true,
            ..ReadOptions::default()
        };
        items(&read_bytes(&file.glb(), None, &options).expect("a scene"))
    };
    assert_eq!(flat(&file), 3);
    let door = door_over(Value::Null, &[5], &[json!({ "mesh": 1 })]);
    assert_eq!(flat(&door), 2);
}

#[test]
fn without_rooms_what_is_below_a_name_is_drawn() {
    let mut file = door_over(Value::Null, &[5], &[json!({ "mesh": 1 })]);
    for room in [0, 2] {
        file.json["nodes"][room]["name"] = json!("A");
    }
    let import = reads(&file);
    assert_eq!(items(&import), 3);
    assert!(
        warnings(&import)[0].contains("node 4 \"AB-portal\""),
        "{:?}",
        warnings(&import)
    );
}

#[test]
fn a_hill_may_have_its_grid_below() {
    let mut file = Grid::new([40, 40]).file();
    file.json["nodes"][0] = json!({ "mesh": 0, "scale": [2, 1, 2] });
    file.node(json!({ "name": "hill-terrain", "children": [2], "extras": { "guid": "h" } }));
    file.node(json!({ "children": [0] }));
    let import = reads(&file);
    assert_eq!(warnings(&import), [""; 0]);
    let room = &import.rooms[0];
    assert_eq!(room.geometry.items().len(), 4);
    assert_eq!(room.geometry.name(ItemIndex(0)), "hill-terrain 0 0");
    assert_eq!(room.geometry.bounds().max[0], 78.0);
    assert_eq!(
        (room.nodes.node(ItemIndex(3)), room.nodes.id(ItemIndex(3))),
        (Some(0), Some("h"))
    );
    import.scene(Method::FloatingHorizon, 1 << 30).expect("terrain");
}

#[test]
fn the_leaf_of_a_door_is_all_that_is_below_it() {
    let mut file = two_rooms(&[]);
    file.node(json!({ "name": "leaf", "children": [5], "extras": { "enfilade": { "kind": "door" } } }));
    file.node(json!({ "children": [6] }));
    file.node(json!({ "name": "panel", "mesh": 2 }));
    let import = reads(&file);
    let movable: usize = import
        .rooms
        .iter()
        .map(|room| {
            let all = (0..room.geometry.items().len() as u32).map(ItemIndex);
            all.filter(|&item| room.nodes.is_movable(item)).count()
        })
        .sum();
    assert_eq!(movable, 1);
}

#[test]
fn an_opening_that_is_wrong_says_which_meshes_were_found_below() {
    let none = Value::Null;
    for (children, below, words) in [
        (
            vec![],
            vec![],
            "has no faces for its opening: it has no mesh and no node below it; give it",
        ),
        (
            vec![5],
            vec![json!({ "children": [6] }), json!({})],
            "neither it nor any of the 2 nodes below it has a mesh",
        ),
        (
            vec![5],
            vec![json!({ "name": "B-mirror", "mesh": 1, "translation": [0, 0, 0.9] })],
            "it has no mesh, and below it only node 5 \"B-mirror\" with marks of their own",
        ),
        (
            vec![5, 6],
            vec![
                json!({ "mesh": 1 }),
                json!({ "name": "other", "mesh": 1, "translation": [2, 0, 0] }),
            ],
            "node 4 \"AB-portal\" (with the mesh of node 5 and node 6 \"other\") is an opening that is not convex",
        ),
        (
            vec![5],
            vec![json!({ "mesh": 0 })],
            "node 4 \"AB-portal\" (with the mesh of node 5) is an opening that is not flat",
        ),
    ] {
        refuses(
            &door_over(none.clone(), &children, &below),
            &["node 4 \"AB-portal\"", words],
        );
    }
    let mut lines = door_over(none.clone(), &[5], &[json!({ "mesh": 1 })]);
    lines.json["meshes"][1]["primitives"][0]["mode"] = json!(1);
    refuses(&lines, &["the meshes of node 5 have no triangles"]);
    let mut file = Grid::new([4, 4]).file();
    file.json["nodes"][0] = json!({ "name": "hill-terrain", "children": [1, 2] });
    file.node(json!({ "mesh": 0 }));
    file.node(json!({ "mesh": 0, "name": "south" }));
    refuses(
        &file,
        &["node 0 \"hill-terrain\" is terrain of several meshes, those of node 1 and node 2 \"south\""],
    );
    file.json["nodes"][0]["children"] = json!([]);
    refuses(
        &file,
        &["node 0 \"hill-terrain\" is terrain without triangles: it has no mesh and no node below it"],
    );
}

#[test]
fn a_hundred_thousand_marked_nodes_in_a_chain_are_read_at_once() {
    let many = 100_000;
    let nodes: Vec<Value> = (0..many)
        .map(|number| json!({ "name": "x-portal", "children": if number + 1 < many { vec![number + 1] } else { vec![] } }))
        .collect();
    let mut file = two_rooms(&[]);
    file.json["nodes"] = json!(nodes);
    let start = std::time::Instant::now();
    reads(&file);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}
