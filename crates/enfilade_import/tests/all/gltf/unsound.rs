//! Documents whose nodes, extensions or version break a rule: each is refused with the place and the rule.

use super::broken::check;
use super::file::{File, refusal};
use serde_json::{Value, json};

#[test]
fn forests_that_are_none() {
    check(&[
        (
            "two parents",
            &|j| {
                j["nodes"] =
                    json!([{ "name": "Door" }, { "children": [0] }, { "name": "Hall", "children": [0] }])
            },
            "node 0 \"Door\" is a child of both node 1 and node 2 \"Hall\"",
        ),
        (
            "a node that is its own child",
            &|j| j["nodes"] = json!([{ "name": "Ouroboros", "children": [0] }]),
            "form a cycle: node 0 \"Ouroboros\", node 0 \"Ouroboros\"",
        ),
        (
            "a ring of three, with a tail",
            &|j| j["nodes"] = json!([{}, { "children": [3] }, { "children": [1, 0] }, { "children": [2] }]),
            "form a cycle: node 2, node 1, node 3, node 2",
        ),
        (
            "a ring that no scene shows",
            &|j| {
                j["nodes"] = json!([{ "mesh": 0 }, { "children": [2] }, { "children": [1] }]);
                j["scenes"] = json!([{ "nodes": [0] }]);
            },
            "form a cycle",
        ),
    ]);
}

#[test]
fn a_long_ring_is_not_told_in_full() {
    let mut nodes: Vec<Value> = (1..100_000).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "children": [0] }));
    check(&[(
        "a ring of 100,000",
        &|j| j["nodes"] = Value::Array(nodes.clone()),
        "and 99994 more",
    )]);
}

#[test]
fn places_that_are_none() {
    let huge = 1e39;
    check(&[
        (
            "a matrix with perspective",
            &|j| j["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0 \"Leaf\" has a matrix with perspective",
        ),
        (
            "a place too far out",
            &|j| j["nodes"][0]["translation"] = json!([huge, 0, 0]),
            "node 0 \"Leaf\" has a transform that is not finite",
        ),
        (
            "a size too large",
            &|j| j["nodes"][0]["matrix"] = json!([huge, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0 \"Leaf\" has a transform that is not finite",
        ),
        (
            "a short matrix",
            &|j| j["nodes"][0]["matrix"] = json!([1, 0, 0]),
            "its JSON cannot be read: nodes[0] \"Leaf\", in matrix: invalid length 3",
        ),
        (
            "a place in words",
            &|j| j["nodes"][0]["translation"] = json!(["far", 0, 0]),
            "its JSON cannot be read: nodes[0] \"Leaf\", in translation[0]: invalid type",
        ),
    ]);
}

#[test]
fn a_mesh_or_its_node_that_leads_too_far_out_is_named() {
    let said = |far: f32, scale: f32| {
        let mut file = File::empty();
        let primitive = file.primitive(&[[0.0; 3], [far, 0.0, 0.0], [0.0, far, 0.0]], &[0, 1, 2]);
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "name": "Sky", "mesh": mesh, "scale": [scale, scale, scale] }));
        refusal(&file.glb()).expect("an error")
    };
    for (far, scale, named) in [
        (
            3e38,
            10.0,
            "meshes[0]: position 1 of part 0 is farther out than 1e12 units",
        ),
        (5e11, 10.0, "node 0 \"Sky\" extends beyond 1e12 units"),
        (1.0, 5e12, "node 0 \"Sky\" extends beyond 1e12 units"),
    ] {
        let said = said(far, scale);
        assert!(said.contains(named), "{said}");
    }
}

#[test]
fn extensions_that_are_required_and_not_read() {
    let draco = "KHR_draco_mesh_compression";
    for (names, remedy) in [
        (vec![draco], "export it again without compression"),
        (vec!["ACME_time_travel"], "export it again without"),
        (
            vec!["KHR_gaussian_splatting"],
            "its splats are lost; export it again as triangles",
        ),
        (vec!["A", "B", "C", "D", "E", "F"], "export it again without"),
    ] {
        let spoken = match names.len() {
            6 => "A, B, C, D, 2 more".to_owned(),
            _ => names.join(", "),
        };
        let expected = format!("requires an unsupported extension: {spoken}; {remedy}");
        let mut required = names.clone();
        required.push("KHR_materials_unlit");
        check(&[(&spoken, &|j| j["extensionsRequired"] = json!(required), &expected)]);
    }
}

#[test]
fn other_versions_of_gltf() {
    check(&[
        (
            "1.0",
            &|j| j["asset"]["version"] = json!("1.0"),
            "is glTF version 1.0; export it again as glTF 2.0",
        ),
        (
            "20.0",
            &|j| j["asset"]["version"] = json!("20.0"),
            "is glTF version 20.0",
        ),
        (
            "2.1 at least",
            &|j| j["asset"] = json!({ "version": "2.1", "minVersion": "2.1" }),
            "is glTF version 2.1; export it again as glTF 2.0",
        ),
        (
            "none",
            &|j| j["asset"] = json!({}),
            "its JSON cannot be read: asset: missing field `version`",
        ),
    ]);
    let mut later = File::leaf();
    later.json["asset"] = json!({ "version": "2.1", "minVersion": "2.0" });
    assert_eq!(refusal(&later.glb()), None);
}
