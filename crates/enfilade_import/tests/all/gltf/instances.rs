//! One node that shows its mesh many times.

use super::file::{File, reads, refusal, triangles, warnings};
use super::rooms::{door, two_rooms};
use enfilade_import::{BrokenRule, ReadOptions, read_bytes};
use serde_json::{Value, json};

/// The leaf, many times.
fn instanced(attributes: Value, change: impl FnOnce(&mut File)) -> File {
    let mut file = File::leaf();
    change(&mut file);
    file.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    file.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    file
}

#[test]
fn each_instance_is_an_item_with_a_place_a_turn_and_a_size_of_its_own() {
    let mut places = 0;
    let file = instanced(json!({ "TRANSLATION": 2, "ROTATION": 3, "SCALE": 4 }), |file| {
        places = file.floats(&[5.0, 0.0, 0.0, 0.0, 7.0, 0.0], 3);
        // No rotation, and a half turn about z, as normalized bytes.
        let turns = file.accessor(5120, "VEC4", 2, vec![0, 0, 0, 127, 0, 0, 127, 0]);
        file.json["accessors"][turns]["normalized"] = json!(true);
        file.floats(&[1.0, 1.0, 1.0, 2.0, 3.0, 1.0], 3);
        // All transforms are relative to their node.
        file.json["nodes"][0]["translation"] = json!([0, 0, 100]);
    });
    let import = reads(&file);
    assert_eq!((places, warnings(&import).len()), (2, 0));
    assert_eq!(
        triangles(&import),
        [
            "Leaf[0] 5,0,100 6,0,100 5,1,100",
            "Leaf[1] -2,7,100 0,4,100 0,7,100",
        ]
    );
    // They are copies of one mesh.
    assert_eq!(import.rooms[0].geometry.meshes().len(), 1);
}

#[test]
fn turns_may_be_of_any_length_and_of_floats_or_shorts() {
    let half_turn = |file: &mut File| file.floats(&[0.0, 0.0, 30.0, 0.0], 4);
    let file = instanced(json!({ "ROTATION": 2 }), |file| {
        half_turn(file);
    });
    assert_eq!(triangles(&reads(&file)), ["Leaf[0] -1,0,0 0,-1,0 0,0,0"]);
    let file = instanced(json!({ "ROTATION": 2 }), |file| {
        let turns = file.accessor(5122, "VEC4", 1, vec![0, 0, 0, 0, 0xff, 0x7f, 0, 0]);
        file.json["accessors"][turns]["normalized"] = json!(true);
    });
    assert_eq!(triangles(&reads(&file)), ["Leaf[0] -1,0,0 0,-1,0 0,0,0"]);
}

#[test]
fn names_of_instances_are_nobody_elses() {
    let mut file = instanced(json!({ "TRANSLATION": 2 }), |file| {
        file.floats(&[0.0; 6], 3);
    });
    file.node(json!({ "name": "Leaf[1]", "mesh": 0 }));
    file.node(json!({ "name": "Twin", "mesh": 0 }));
    file.node(json!({ "name": "Twin", "mesh": 0 }));
    file.json["nodes"][3]["extensions"] = file.json["nodes"][0]["extensions"].clone();
    let import = reads(&file);
    let geometry = &import.rooms[0].geometry;
    let names: Vec<&str> = (0..6)
        .map(|item| geometry.name(enfilade::ItemIndex(item)))
        .collect();
    assert_eq!(
        names,
        [
            "Leaf[0]",
            "Leaf[1]#0",
            "Leaf[1]",
            "Twin#2",
            "Twin#3[0]",
            "Twin#3[1]"
        ]
    );
}

#[test]
fn a_node_without_lists_of_instances_stands_for_itself_and_one_with_empty_ones_for_nothing() {
    let file = instanced(json!({ "_COLOR": 99 }), |_| ());
    assert_eq!(triangles(&reads(&file)), ["Leaf 0,0,0 1,0,0 0,1,0"]);
    let file = instanced(json!({ "TRANSLATION": 2 }), |file| {
        file.push(
            "accessors",
            json!({ "componentType": 5126, "type": "VEC3", "count": 0 }),
        );
    });
    let import = reads(&file);
    assert_eq!(triangles(&import), [""; 0]);
    assert_eq!(warnings(&import), ["the scene is empty: it has no triangle"]);
}

#[test]
fn openings_are_there_once() {
    let mut hall = two_rooms(&[door("Door-portal", json!({ "to": "B-room" }))]);
    let places = hall.floats(&[0.0, 0.0, 0.0, 9.0, 0.0, 0.0], 3);
    let nodes = hall.json["nodes"].as_array_mut().expect("a list");
    let gate = nodes
        .iter_mut()
        .find(|node| node["name"] == "Door-portal")
        .expect("a door");
    gate["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    let import = reads(&hall);
    assert_eq!(import.portals.len(), 2);
    let said = warnings(&import);
    assert!(
        said.iter()
            .any(|text| text.starts_with("instances of portals and mirrors are ignored")),
        "{said:?}"
    );
}

#[test]
fn instances_that_make_no_sense_are_refused() {
    let refused = |attributes: Value, change: &dyn Fn(&mut File), expected: &str| {
        let said = refusal(&instanced(attributes, change).glb()).expect("an error");
        assert!(
            said.contains(expected),
            "it says\n  {said}\nand not\n  {expected}"
        );
    };
    refused(
        json!({ "TRANSLATION": 2, "SCALE": 3 }),
        &|file| {
            file.floats(&[0.0; 9], 3);
            file.floats(&[1.0; 6], 3);
        },
        "node 0 \"Leaf\" has 3 translations (TRANSLATION), but 2 scales (SCALE); export it again with one of each per instance",
    );
    refused(
        json!({ "TRANSLATION": 7 }),
        &|_| (),
        "node 0 \"Leaf\" names accessor 7, but there are only 2",
    );
    refused(
        json!({ "ROTATION": 2 }),
        &|file| {
            file.accessor(5120, "VEC4", 1, vec![0, 0, 0, 127]);
        },
        "holds VEC4 of BYTE, but rotations of instances as VEC4 of FLOAT, or of normalized BYTE or SHORT are expected",
    );
    refused(
        json!({ "ROTATION": 2 }),
        &|file| {
            file.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 4);
        },
        "node 0 \"Leaf\", instance 1 has a rotation of length zero",
    );
    refused(
        json!({ "TRANSLATION": 2 }),
        &|file| {
            file.floats(&[0.0, f32::NAN, 0.0], 3);
        },
        "node 0 \"Leaf\", instance 0 has a transform that is not finite",
    );
    // Finite, but not where it comes to stand.
    refused(
        json!({ "TRANSLATION": 2 }),
        &|file| {
            file.floats(&[3e38, 0.0, 0.0], 3);
            file.json["nodes"][0]["scale"] = json!([100, 1, 1]);
        },
        "the transform of item `Leaf[0]` (key 0) is not finite",
    );
}

#[test]
fn four_billion_instances_in_a_few_bytes_are_refused_before_they_take_memory() {
    for count in [1_u64 << 32, 3_000_000, u64::MAX] {
        let file = instanced(json!({ "TRANSLATION": 2 }), |file| {
            let zeros = json!({ "componentType": 5126, "type": "VEC3", "count": count });
            file.push("accessors", zeros);
        });
        let error = read_bytes(&file.glb(), None, &ReadOptions::default()).expect_err("too many");
        let BrokenRule::TooLarge { place, .. } = &error.rule else {
            panic!("{error}")
        };
        assert_eq!(place, "node 0 \"Leaf\", its instances");
    }
    // A long name takes memory for each of them.
    let mut file = instanced(json!({ "TRANSLATION": 2 }), |file| {
        file.push(
            "accessors",
            json!({ "componentType": 5126, "type": "VEC3", "count": 20_000 }),
        );
    });
    file.json["nodes"][0]["name"] = json!("A".repeat(100_000));
    let error = read_bytes(&file.glb(), None, &ReadOptions::default()).expect_err("2 GB of names");
    assert!(matches!(error.rule, BrokenRule::TooLarge { .. }), "{error}");
}
