//! Tests the warnings.

use super::file::{File, reads, warnings};
use super::rooms::{door, two_rooms};
use serde_json::json;

/// A leaf with a change to it gives exactly these warnings.
#[track_caller]
fn warns(change: impl FnOnce(&mut File), expected: &[&str]) {
    let mut file = File::leaf();
    change(&mut file);
    assert_eq!(warnings(&reads(&file)), expected);
}

#[test]
fn a_plain_file_gives_no_warning() {
    warns(|_| (), &[]);
}

#[test]
fn a_scene_without_triangles_is_called_empty() {
    let empty = "the scene is empty: it has no triangle";
    warns(|file| file.json["nodes"] = json!([]), &[empty]);
    warns(
        |file| file.json["nodes"] = json!([{ "name": "Nothing" }]),
        &[empty],
    );
    warns(|file| file.json["meshes"][0]["primitives"] = json!([]), &[empty]);
    warns(|file| file.json["scenes"] = json!([{}]), &[empty]);
}

#[test]
fn scenes_beside_the_default_one_are_counted() {
    let other = "only one scene is read, others are not (2)";
    warns(
        |file| file.json["scenes"] = json!([{ "nodes": [0] }, {}, {}]),
        &[other],
    );
}

#[test]
fn a_door_that_an_animation_opens_is_told_since_its_opening_does_not() {
    let mut file = two_rooms(&[door("Door-portal", json!({}))]);
    let node = file.json["nodes"].as_array().expect("nodes").len() - 1;
    let target = json!({ "node": node, "path": "translation" });
    file.json["animations"] = json!([{ "channels": [{ "sampler": 0, "target": target }], "samplers": [] }]);
    let told = reads(&file).warnings.iter().any(|warning| {
        let text = warning.to_string();
        text.starts_with("portals and mirrors that animations move") && text.contains("Door-portal")
    });
    assert!(told);
}

#[test]
fn extensions_that_are_read_are_not_named_and_others_are() {
    warns(
        |file| {
            file.json["extensionsUsed"] = json!([
                "KHR_materials_clearcoat",
                "EXT_mesh_gpu_instancing",
                "KHR_texture_transform",
                "KHR_materials_ior"
            ]);
            file.json["extensionsRequired"] = json!(["KHR_texture_transform", "KHR_lights_punctual"]);
        },
        &["extensions are not read (KHR_materials_clearcoat, KHR_materials_ior)"],
    );
}

#[test]
fn compression_with_a_plain_copy_beside_it_is_passed_over() {
    warns(
        |file| {
            file.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
            file.json["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": { "bufferView": 99, "attributes": { "POSITION": 0 } } });
        },
        &["extensions are not read (KHR_draco_mesh_compression)"],
    );
}

#[test]
fn what_changes_only_the_look_is_counted() {
    warns(
        |file| {
            file.json["materials"] = json!([
                { "normalTexture": { "index": 9 }, "occlusionTexture": { "index": 8 } },
                { "normalTexture": { "index": 9 } },
            ]);
            file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
            file.json["skins"] = json!([{ "joints": [0] }]);
            file.json["animations"] = json!([{}, {}, {}]);
            file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
        },
        &[
            "animations are not read yet: everything stands still (3)",
            "metallic-roughness, normal, occlusion and transmission textures are not drawn (2)",
        ],
    );
}

#[test]
fn corners_that_make_no_triangle_are_left_out() {
    warns(
        |file| {
            let indices = file.indices(5121, 5, vec![0, 1, 2, 0, 1]);
            file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        },
        &[
            "triangle lists with a corner count that is not a multiple of 3: the last corners are ignored (meshes[0].primitives[0])",
        ],
    );
}

#[test]
fn a_primitive_without_positions_is_not_drawn() {
    warns(
        |file| {
            file.json["meshes"][0]["primitives"]
                .as_array_mut()
                .expect("a list")
                .push(json!({ "attributes": {} }));
        },
        &["primitives without positions are not drawn (meshes[0].primitives[1])"],
    );
}

#[test]
fn nodes_that_flatten_or_shear_are_named() {
    let flat = "node transforms flatten their mesh, which may be invisible (node 0 \"Leaf\")";
    warns(|file| file.json["nodes"][0]["scale"] = json!([1, 1, 0]), &[flat]);
    warns(|file| file.json["nodes"][0]["scale"] = json!([0, 0, 0]), &[flat]);
    let sheared = "node matrices shear, which glTF forbids; they are taken as they are (node 0 \"Leaf\")";
    let matrix = json!([1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    warns(|file| file.json["nodes"][0]["matrix"] = matrix, &[sheared]);
    warns(
        |file| file.json["nodes"][0]["scale"] = json!([1e-12, 1e-12, 1e-12]),
        &[],
    );
}

#[test]
fn a_hundred_odd_things_of_a_kind_are_one_warning() {
    warns(
        |file| {
            for _ in 0..100 {
                file.node(json!({ "mesh": 0, "scale": [0, 1, 1] }));
            }
        },
        &["node transforms flatten their mesh, which may be invisible \
           (node 1, node 2, node 3, node 4, node 5, node 6 and 94 more)"],
    );
}
