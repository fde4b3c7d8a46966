//! Documents whose shapes break a rule: each is refused with the place and the rule.

use super::file::{File, refusal};
use serde_json::{Value, json};

/// A change that breaks the leaf, and what is said then.
pub(crate) type Case<'a> = (&'a str, &'a dyn Fn(&mut Value), &'a str);

pub(crate) fn check(cases: &[Case]) {
    for (what, change, expected) in cases {
        let mut file = File::leaf();
        change(&mut file.json);
        let said = refusal(&file.glb()).unwrap_or_else(|| panic!("{what} is read without complaint"));
        assert!(
            said.contains(expected),
            "{what}: it says\n  {said}\nand not\n  {expected}"
        );
    }
}

#[test]
fn numbers_that_name_nothing() {
    check(&[
        (
            "a scene",
            &|j| j["scene"] = json!(3),
            "the document names scene 3, but there are only 0",
        ),
        (
            "a root",
            &|j| j["scenes"] = json!([{ "nodes": [5] }]),
            "scene 0 names node 5, but there are only 1",
        ),
        (
            "a child",
            &|j| j["nodes"][0]["children"] = json!([9]),
            "node 0 \"Leaf\" names node 9, but there are only 1",
        ),
        (
            "a mesh",
            &|j| j["nodes"][0]["mesh"] = json!(2),
            "node 0 \"Leaf\" names mesh 2, but there are only 1",
        ),
        (
            "a camera",
            &|j| j["nodes"][0]["camera"] = json!(0),
            "node 0 \"Leaf\" names camera 0, but there are only 0",
        ),
        (
            "positions",
            &|j| j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(12),
            "meshes[0].primitives[0] names accessor 12, but there are only 2",
        ),
        (
            "indices",
            &|j| j["meshes"][0]["primitives"][0]["indices"] = json!(4_294_967_295_u32),
            "meshes[0].primitives[0] names accessor 4294967295, but there are only 2",
        ),
        (
            "a material",
            &|j| j["meshes"][0]["primitives"][0]["material"] = json!(0),
            "meshes[0].primitives[0] names material 0, but there are only 0",
        ),
        (
            "a view",
            &|j| j["accessors"][0]["bufferView"] = json!(7),
            "accessor 0 names bufferView 7, but there are only 2",
        ),
        (
            "a buffer",
            &|j| j["bufferViews"][1]["buffer"] = json!(7),
            "bufferView 1 names buffer 7, but there are only 1",
        ),
    ]);
}

#[test]
fn accessors_that_reach_too_far() {
    let largest = u64::MAX;
    check(&[
        (
            "count",
            &|j| j["accessors"][0]["count"] = json!(4),
            "accessor 0 ends at byte 48 of bufferView 0, which has only 36",
        ),
        (
            "offset",
            &|j| j["accessors"][1]["byteOffset"] = json!(2),
            "accessor 1 ends at byte 8 of bufferView 1, which has only 6",
        ),
        (
            "an offset near the end of numbers",
            &|j| j["accessors"][0]["byteOffset"] = json!(largest),
            "accessor 0 ends at byte 18446744073709551651 of bufferView 0",
        ),
        (
            "a count of 2^60",
            &|j| j["accessors"][0]["count"] = json!(1_u64 << 60),
            "accessor 0 ends at byte 13835058055282163712",
        ),
        (
            "everything at once",
            &|j| {
                j["accessors"][0]["count"] = json!(largest);
                j["accessors"][0]["byteOffset"] = json!(largest);
                j["bufferViews"][0]["byteStride"] = json!(largest);
            },
            "accessor 0 ends at byte 340282366920938463426481119284349108",
        ),
        (
            "a huge stride",
            &|j| j["bufferViews"][0]["byteStride"] = json!(1_u64 << 40),
            "accessor 0 ends at byte 2199023255564",
        ),
        (
            "a stride of zero",
            &|j| j["bufferViews"][0]["byteStride"] = json!(0),
            "accessor 0 has elements of 12 bytes, but its bufferView 0 has a byteStride of 0",
        ),
        (
            "overlapping elements",
            &|j| j["bufferViews"][0]["byteStride"] = json!(8),
            "accessor 0 has elements of 12 bytes, but its bufferView 0 has a byteStride of 8",
        ),
        (
            "a view's length",
            &|j| j["bufferViews"][0]["byteLength"] = json!(1000),
            "bufferView 0 ends at byte 1000 of buffer 0, which has only 42",
        ),
        (
            "a view's offset",
            &|j| j["bufferViews"][0]["byteOffset"] = json!(largest),
            "bufferView 0 ends at byte 18446744073709551651 of buffer 0",
        ),
        (
            "a buffer's length",
            &|j| j["buffers"][0]["byteLength"] = json!(10_000_000_000_u64),
            "buffer 0 should have 10000000000 bytes, but only 44 are there; copy or export it again",
        ),
        (
            "a buffer that is nowhere",
            &|j| {
                j["buffers"]
                    .as_array_mut()
                    .expect("a list")
                    .push(json!({ "byteLength": 36 }));
                j["bufferViews"][0]["buffer"] = json!(1);
            },
            "buffer 1 has no bytes",
        ),
    ]);
}

#[test]
fn accessors_of_another_type() {
    check(&[
        (
            "positions of long whole numbers",
            &|j| j["accessors"][0]["componentType"] = json!(5125),
            "accessor 0 holds VEC3 of UNSIGNED_INT, but positions as VEC3 of FLOAT, or of bytes or shorts are expected; export",
        ),
        (
            "flat positions",
            &|j| j["accessors"][0]["type"] = json!("VEC2"),
            "accessor 0 holds VEC2 of FLOAT, but positions as VEC3 of FLOAT, or of bytes or shorts are expected",
        ),
        (
            "broken indices",
            &|j| j["accessors"][1]["componentType"] = json!(5126),
            "accessor 1 holds SCALAR of FLOAT, but indices as SCALAR of UNSIGNED_BYTE",
        ),
        (
            "a component that is not known",
            &|j| j["accessors"][1]["componentType"] = json!(5130),
            "accessor 1 holds SCALAR of component type 5130",
        ),
        (
            "a sparse accessor that says nothing",
            &|j| j["accessors"][0]["sparse"] = json!({}),
            "its JSON cannot be read: accessors[0], in sparse: missing field `count`",
        ),
        (
            "compressed positions without a plain copy",
            &|j| {
                j["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} });
                j["accessors"][0]
                    .as_object_mut()
                    .expect("an accessor")
                    .remove("bufferView");
            },
            "meshes[0].primitives[0] is compressed (KHR_draco_mesh_compression), which is not supported yet",
        ),
    ]);
}

#[test]
fn modes_that_are_not_known() {
    check(&[
        (
            "drawing",
            &|j| j["meshes"][0]["primitives"][0]["mode"] = json!(7),
            "meshes[0].primitives[0] has mode 7",
        ),
        (
            "alpha",
            &|j| j["materials"] = json!([{ "alphaMode": "GLASS" }]),
            "material 0 has alphaMode `GLASS`",
        ),
    ]);
}

#[test]
fn an_index_past_its_positions() {
    let mut file = File::empty();
    let first = file.primitive(&[[0.0; 3]; 3], &[0, 1, 2]);
    let second = file.primitive(&[[0.0; 3]; 3], &[0, 1, 2, 2, 3, 0]);
    let mesh = file.mesh(json!([first, second]));
    file.node(json!({ "mesh": mesh }));
    let said = refusal(&file.glb()).expect("an error");
    let expected = "meshes[0].primitives[1] has index 3 at corner 4, but only 3 positions";
    assert!(said.contains(expected), "{said}");
}

#[test]
fn positions_that_are_not_finite() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = File::empty();
        let primitive = file.primitive(&[[0.0; 3], [0.0; 3], [0.0, value, 0.0]], &[0, 1, 2]);
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "mesh": mesh }));
        let said = refusal(&file.glb()).expect("an error");
        assert!(
            said.contains("meshes[0].primitives[0] has a triangle at position 2, which is not finite"),
            "{said}"
        );
    }
}

#[test]
fn of_several_broken_meshes_the_first_is_named() {
    let mut file = File::empty();
    for number in 0..100 {
        let primitive = file.primitive(&[[0.0; 3]; 3], &[0, 1, if number < 40 { 2 } else { 3 }]);
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "mesh": mesh }));
    }
    let said = refusal(&file.glb()).expect("an error");
    assert!(said.contains("meshes[40].primitives[0] has index 3"), "{said}");
}
