//! Numbers that are stored in few bytes, or only where they differ.

use super::file::{File, carried, reads, refusal, triangles};
use enfilade_import::{BrokenRule, ReadOptions, read_bytes};
use serde_json::{Value, json};

const LEAF: [&str; 1] = ["Leaf 0,0,0 1,0,0 0,1,0"];

/// The leaf with positions of another kind, each followed by bytes that are none of it.
fn quantized(component: u32, normalized: bool, bytes: Vec<u8>, stride: usize) -> File {
    let mut file = File::leaf();
    let view = file.view(bytes);
    file.json["bufferViews"][view]["byteStride"] = json!(stride);
    let positions = file.push(
        "accessors",
        json!({
            "bufferView": view, "componentType": component, "type": "VEC3", "count": 3, "normalized": normalized
        }),
    );
    file.carry("POSITION", positions);
    file.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    file
}

#[test]
fn positions_may_be_bytes_or_shorts_that_stand_for_themselves_or_for_parts_of_one() {
    let corners = |one: i32| [[0, 0, 0, 99], [one, 0, 0, 99], [0, one, 0, 99]].concat();
    let bytes = |one| corners(one).iter().map(|&part| part as u8).collect::<Vec<u8>>();
    let shorts = |one| -> Vec<u8> {
        let parts = corners(one);
        parts
            .iter()
            .flat_map(|&part| (part as u16).to_le_bytes())
            .collect()
    };
    for (component, normalized, bytes, stride) in [
        (5120, true, bytes(127), 4),
        (5121, true, bytes(255), 4),
        (5122, true, shorts(32767), 8),
        (5123, true, shorts(65535), 8),
        (5120, false, bytes(1), 4),
        (5121, false, bytes(1), 4),
        (5122, false, shorts(1), 8),
        (5123, false, shorts(1), 8),
    ] {
        let import = reads(&quantized(component, normalized, bytes, stride));
        assert_eq!(triangles(&import), LEAF, "{component} {normalized}");
        assert!(import.warnings.is_empty());
    }
    // Below zero, and scaled by the node as exporters do.
    let mut file = quantized(5122, false, shorts(-2), 8);
    file.json["nodes"][0]["scale"] = json!([0.5, 0.5, 0.5]);
    assert_eq!(triangles(&reads(&file)), ["Leaf -1,0,0 0,-1,0 0,0,0"]);
}

/// The leaf at z = 9 whose second and third corner stand elsewhere, at z = 0.
fn sparse(component: u32, indices: Vec<u8>, base: bool) -> File {
    let mut file = File::leaf();
    let indices = file.view(indices);
    let values: Vec<u8> = [1.0_f32, 0.0, 0.0, 0.0, 1.0, 0.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let values = file.view(values);
    let accessor = &mut file.json["accessors"][0];
    accessor["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": indices, "componentType": component },
        "values": { "bufferView": values }
    });
    if base {
        let far: Vec<u8> = [9.0_f32; 9].iter().flat_map(|v| v.to_le_bytes()).collect();
        let far = file.view(far);
        file.json["accessors"][0]["bufferView"] = json!(far);
    } else {
        file.json["accessors"][0]
            .as_object_mut()
            .expect("an accessor")
            .remove("bufferView");
    }
    file
}

#[test]
fn elements_that_stand_elsewhere_take_the_place_of_others_or_of_zeros() {
    for (component, indices) in [
        (5121, vec![1, 2]),
        (5123, vec![1, 0, 2, 0]),
        (5125, vec![1, 0, 0, 0, 2, 0, 0, 0]),
    ] {
        let import = reads(&sparse(component, indices.clone(), false));
        assert_eq!(triangles(&import), LEAF, "{component}");
        let import = reads(&sparse(component, indices, true));
        assert_eq!(triangles(&import), ["Leaf 0,1,0 9,9,9 1,0,0"], "{component}");
    }
}

#[test]
fn indices_and_what_corners_carry_may_stand_elsewhere_too() {
    let mut file = File::leaf();
    // 0, 1, 1 becomes 0, 1, 2.
    let wrong = file.view(vec![0, 0, 1, 0, 1, 0]);
    let place = file.view(vec![2]);
    let value = file.view(vec![2, 0]);
    let accessor = file.json["meshes"][0]["primitives"][0]["indices"]
        .as_u64()
        .expect("a number") as usize;
    file.json["accessors"][accessor]["bufferView"] = json!(wrong);
    file.json["accessors"][accessor]["sparse"] = json!({
        "count": 1,
        "indices": { "bufferView": place, "componentType": 5121 },
        "values": { "bufferView": value }
    });
    let gold = [1.0_f32, 0.5, 0.0, 1.0];
    let value = file.view(gold.iter().flat_map(|v| v.to_le_bytes()).collect());
    let colors = file.push(
        "accessors",
        json!({ "componentType": 5126, "type": "VEC4", "count": 3, "sparse": {
            "count": 1,
            "indices": { "bufferView": place, "componentType": 5121 },
            "values": { "bufferView": value }
        } }),
    );
    file.carry("COLOR_0", colors);
    let import = reads(&file);
    assert_eq!(triangles(&import), LEAF);
    assert_eq!(carried(&import, |mesh| mesh.colors()), [[0.0; 4], [0.0; 4], gold]);
}

/// Changes of a sparse leaf, with the expected messages.
type Case<'a> = (&'a str, &'a dyn Fn(&mut Value), &'a str);

#[test]
fn elements_that_stand_elsewhere_and_make_no_sense_are_refused() {
    let cases: [Case; 9] = [
        (
            "more of them than others",
            &|a| a["sparse"]["count"] = json!(4),
            "accessor 0 has 4 sparse elements, but only 3 in all",
        ),
        (
            "very many",
            &|a| {
                a["sparse"]["count"] = json!(u64::MAX);
                a["count"] = json!(u64::MAX);
            },
            "accessor 0.sparse.indices ends at byte 18446744073709551615 of bufferView 2, which has only 2",
        ),
        (
            "numbers of another type",
            &|a| a["sparse"]["indices"]["componentType"] = json!(5126),
            "accessor 0.sparse.indices holds component type 5126, but UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT",
        ),
        (
            "numbers past their view",
            &|a| a["sparse"]["indices"]["byteOffset"] = json!(1),
            "accessor 0.sparse.indices ends at byte 3 of bufferView 2",
        ),
        (
            "values past their view",
            &|a| a["sparse"]["values"]["byteOffset"] = json!(u64::MAX),
            "accessor 0.sparse.values ends at byte 18446744073709551639 of bufferView 3",
        ),
        (
            "numbers nowhere",
            &|a| a["sparse"]["indices"]["bufferView"] = json!(77),
            "accessor 0.sparse.indices names bufferView 77",
        ),
        (
            "values nowhere",
            &|a| a["sparse"]["values"]["bufferView"] = json!(77),
            "accessor 0.sparse.values names bufferView 77",
        ),
        (
            "fewer elements than they number",
            &|a| {
                a["count"] = json!(2);
            },
            "accessor 0 has the sparse index 2 at position 1, but sparse indices must increase and stay below its count of 2",
        ),
        (
            "a word",
            &|a| a["sparse"] = json!("yes"),
            "its JSON cannot be read: ",
        ),
    ];
    for (what, change, expected) in cases {
        let mut file = sparse(5121, vec![1, 2], false);
        change(&mut file.json["accessors"][0]);
        let said = refusal(&file.glb()).unwrap_or_else(|| panic!("{what} is read without complaint"));
        assert!(
            said.contains(expected),
            "{what}: it says\n  {said}\nand not\n  {expected}"
        );
    }
    for order in [vec![2, 1], vec![1, 1]] {
        let said = refusal(&sparse(5121, order, false).glb()).expect("an error");
        assert!(
            said.contains("accessor 0 has the sparse index 1 at position 1"),
            "{said}"
        );
    }
}

#[test]
fn sparse_elements_cost_no_more_where_a_thousand_primitives_share_them() {
    // Half a million numbers, checked once and searched by halves.
    const COUNT: u32 = 500_000;
    let mut file = File::empty();
    let numbers = file.view((0..COUNT).flat_map(|n| n.to_le_bytes()).collect());
    let values = file.view(vec![0; 12 * COUNT as usize]);
    let positions = file.push(
        "accessors",
        json!({ "componentType": 5126, "type": "VEC3", "count": COUNT, "sparse": {
            "count": COUNT,
            "indices": { "bufferView": numbers, "componentType": 5125 },
            "values": { "bufferView": values }
        } }),
    );
    let indices = file.indices(5123, 3, vec![0, 0, 1, 0, 2, 0]);
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    let mesh = file.mesh(json!(vec![primitive; 5000]));
    file.node(json!({ "mesh": mesh }));
    let bytes = file.glb();
    let start = std::time::Instant::now();
    assert_eq!(refusal(&bytes), None);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn what_corners_carry_must_be_one_for_each_and_of_its_kind() {
    for (attribute, each, count, expected) in [
        (
            "NORMAL",
            3,
            2,
            "meshes[0].primitives[0] has 2 normals, but 3 positions; export it again",
        ),
        (
            "COLOR_0",
            4,
            4,
            "meshes[0].primitives[0] has 4 colors, but 3 positions",
        ),
        (
            "NORMAL",
            2,
            3,
            "holds VEC2 of FLOAT, but normals as VEC3 of FLOAT, BYTE or SHORT are expected; export it again",
        ),
        (
            "COLOR_0",
            1,
            3,
            "holds SCALAR of FLOAT, but colors as VEC3 or VEC4 of FLOAT, UNSIGNED_BYTE",
        ),
    ] {
        let mut file = File::leaf();
        let accessor = file.floats(&vec![0.0; each * count], each);
        file.carry(attribute, accessor);
        let said = refusal(&file.glb()).expect("an error");
        assert!(said.contains(expected), "{said}");
    }
    let mut file = super::file::textured_leaf();
    let wide = file.floats(&[0.0; 9], 3);
    file.carry("TEXCOORD_0", wide);
    let said = refusal(&file.glb()).expect("an error");
    let expected =
        "holds VEC3 of FLOAT, but texture coordinates as VEC2 of FLOAT, or of bytes or shorts are expected";
    assert!(said.contains(expected), "{said}");
    // Where no texture wants them, they may be anything.
    file.json["materials"][0] = json!({});
    assert_eq!(refusal(&file.glb()), None);
    // They count in what memory is set aside.
    let mut file = File::leaf();
    let colors = file.push(
        "accessors",
        json!({ "componentType": 5126, "type": "VEC4", "count": 3 }),
    );
    file.carry("COLOR_0", colors);
    file.json["accessors"][1] = json!({ "componentType": 5125, "type": "SCALAR", "count": 30_000_000 });
    let options = ReadOptions {
        limit_bytes: 700_000_000,
        ..ReadOptions::default()
    };
    let error = read_bytes(&file.glb(), None, &options).expect_err("a billion bytes");
    let BrokenRule::TooLarge {
        place, needs_bytes, ..
    } = error.rule
    else {
        panic!("{error}")
    };
    assert!(
        place == "meshes[0]" && needs_bytes > 1_000_000_000,
        "{place} {needs_bytes}"
    );
}
