//! Triangles, however they are stored, and what they are made of.

use super::file::{File, reads, triangles, warnings};
use enfilade::{Alpha, Material, MaterialId};
use serde_json::{Value, json};
use std::sync::Arc;

/// Corners of two squares beside each other, in the order of a strip.
const LADDER: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

/// The leaf, after a change to its JSON.
fn leaf_with(change: impl FnOnce(&mut File)) -> File {
    let mut file = File::leaf();
    change(&mut file);
    file
}

#[test]
fn indices_may_have_8_16_or_32_bits_or_be_left_out() {
    for (component, bytes) in [
        (5121, vec![0, 1, 2]),
        (5123, vec![0, 0, 1, 0, 2, 0]),
        (5125, vec![0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]),
    ] {
        let file = leaf_with(|file| {
            let indices = file.indices(component, 3, bytes);
            file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
        });
        assert_eq!(
            triangles(&reads(&file)),
            ["Leaf 0,0,0 1,0,0 0,1,0"],
            "component type {component}"
        );
    }
    let file = leaf_with(|file| file.json["meshes"][0]["primitives"][0]["indices"] = Value::Null);
    assert_eq!(triangles(&reads(&file)), ["Leaf 0,0,0 1,0,0 0,1,0"]);
}

#[test]
fn strips_and_fans_face_the_same_way_all_along() {
    let rim = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    for (mode, positions, expected) in [
        (5, LADDER, ["Rug 0,0,0 1,0,0 0,1,0", "Rug 0,1,0 1,0,0 1,1,0"]),
        (6, rim, ["Rug 0,0,0 1,0,0 1,1,0", "Rug 0,0,0 1,1,0 0,1,0"]),
    ] {
        let mut file = File::empty();
        let positions = file.positions(&positions);
        let mesh = file.mesh(json!([{ "attributes": { "POSITION": positions }, "mode": mode }]));
        file.node(json!({ "name": "Rug", "mesh": mesh }));
        assert_eq!(triangles(&reads(&file)), expected, "mode {mode}");
    }
}

#[test]
fn an_indexed_strip_takes_its_corners_through_the_indices() {
    let mut file = File::empty();
    let mut primitive = file.primitive(&LADDER, &[3, 2, 1, 0]);
    primitive["mode"] = json!(5);
    let mesh = file.mesh(json!([primitive]));
    file.node(json!({ "name": "Rug", "mesh": mesh }));
    assert_eq!(
        triangles(&reads(&file)),
        ["Rug 0,0,0 1,0,0 0,1,0", "Rug 0,1,0 1,0,0 1,1,0"]
    );
}

#[test]
fn positions_may_stand_apart_and_begin_late() {
    // Each position is followed by four bytes of something else; the first eight bytes are something else too.
    let mut file = File::leaf();
    let mut bytes = vec![0xff; 8];
    for position in [[0.0_f32, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]] {
        bytes.extend(position.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0xff; 4]);
    }
    // The last element needs no gap behind it.
    bytes.truncate(bytes.len() - 4);
    let view = file.view(bytes);
    file.json["bufferViews"][view]["byteStride"] = json!(16);
    file.json["accessors"][0]["bufferView"] = json!(view);
    file.json["accessors"][0]["byteOffset"] = json!(8);
    assert_eq!(triangles(&reads(&file)), ["Leaf 0,0,5 1,0,5 0,1,5"]);
}

#[test]
fn an_accessor_that_stands_nowhere_is_all_zeros() {
    let file = leaf_with(|file| {
        file.json["accessors"][0]
            .as_object_mut()
            .expect("an accessor")
            .remove("bufferView");
    });
    assert_eq!(triangles(&reads(&file)), ["Leaf 0,0,0 0,0,0 0,0,0"]);
}

#[test]
fn a_part_takes_only_the_positions_that_its_triangles_use() {
    // 1000 positions, all but a few of them NaN: near each other and scattered.
    for used in [[10_u16, 11, 12], [0, 500, 999]] {
        let mut file = File::empty();
        let mut positions = vec![[f32::NAN; 3]; 1000];
        for (corner, &index) in used.iter().enumerate() {
            positions[usize::from(index)] = LADDER[corner];
        }
        let primitive = file.primitive(&positions, &used);
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "name": "Leaf", "mesh": mesh }));
        assert_eq!(triangles(&reads(&file)), ["Leaf 0,0,0 1,0,0 0,1,0"], "{used:?}");
    }
}

#[test]
fn primitives_of_a_mesh_are_parts_of_one_item() {
    let mut file = File::empty();
    let lower = file.primitive(&LADDER, &[0, 1, 2]);
    let mut upper = file.primitive(&LADDER, &[1, 3, 2]);
    upper["material"] = json!(0);
    file.push(
        "materials",
        json!({ "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.0, 1.0] } }),
    );
    let mesh = file.mesh(json!([lower, upper]));
    file.node(json!({ "name": "Rug", "mesh": mesh }));
    let import = reads(&file);
    assert_eq!(
        triangles(&import),
        ["Rug 0,0,0 1,0,0 0,1,0", "Rug 0,1,0 1,0,0 1,1,0"]
    );
    let geometry = &import.rooms[0].geometry;
    assert_eq!(geometry.items().len(), 1);
    let colors: Vec<_> = geometry.meshes()[0]
        .clusters()
        .iter()
        .map(|cluster| geometry.material(cluster).base_color)
        .collect();
    assert_eq!(colors, [[0.5, 0.25, 0.0, 1.0], [1.0; 4]]);
}

#[test]
fn nodes_that_share_a_mesh_share_it_in_memory() {
    let mut file = File::leaf();
    for x in 1..100 {
        file.node(json!({ "name": format!("Leaf{x}"), "mesh": 0, "translation": [x, 0, 0] }));
    }
    let import = reads(&file);
    let geometry = &import.rooms[0].geometry;
    assert_eq!((geometry.items().len(), geometry.meshes().len()), (100, 1));
    assert_eq!(
        (
            geometry.triangle_count(),
            Arc::strong_count(&geometry.meshes()[0])
        ),
        (100, 1)
    );
}

#[test]
fn meshes_that_no_item_uses_are_not_looked_at() {
    let mut file = File::leaf();
    file.mesh(json!([{ "attributes": { "POSITION": 1234 } }]));
    assert_eq!(reads(&file).rooms[0].geometry.meshes().len(), 1);
}

#[test]
fn materials_say_what_hides_and_from_which_side() {
    let glass = json!({ "KHR_materials_transmission": { "transmissionFactor": 0.9 } });
    let solid = json!({ "KHR_materials_transmission": {} });
    let color = |color: Value| json!({ "pbrMetallicRoughness": { "baseColorFactor": color } });
    let material = |base_color, alpha, double_sided| Material {
        base_color,
        alpha,
        double_sided,
        ..Material::opaque([1.0; 3])
    };
    for (source, expected) in [
        (json!({}), Material::opaque([1.0; 3])),
        (
            json!({ "doubleSided": true }),
            material([1.0; 4], Alpha::Opaque, true),
        ),
        (
            json!({ "alphaMode": "MASK" }),
            material([1.0; 4], Alpha::Mask, false),
        ),
        (
            json!({ "alphaMode": "BLEND" }),
            material([1.0; 4], Alpha::Blend, false),
        ),
        // An opaque material has full coverage, whatever its alpha says.
        (
            color(json!([0.5, 0.5, 0.5, 0.25])),
            material([0.5, 0.5, 0.5, 1.0], Alpha::Opaque, false),
        ),
        (
            color(json!([2.0, -1.0, 0.5, 1.0])),
            material([1.0, 0.0, 0.5, 1.0], Alpha::Opaque, false),
        ),
        // A transmissive material must not occlude, even if its alpha mode is OPAQUE.
        (
            json!({ "extensions": glass }),
            material([1.0, 1.0, 1.0, 1.0 - 0.9 * 0.9], Alpha::Blend, false),
        ),
        (json!({ "extensions": solid }), Material::opaque([1.0; 3])),
    ] {
        let mut file = File::leaf();
        file.push("materials", source.clone());
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let import = reads(&file);
        let geometry = &import.rooms[0].geometry;
        assert_eq!(
            *geometry.material(&geometry.meshes()[0].clusters()[0]),
            expected,
            "{source}"
        );
    }
}

#[test]
fn materials_may_be_marked_as_detail() {
    for (extras, expected) in [
        (json!({ "enfilade": { "detail": true } }), true),
        (json!({ "enfilade": { "detail": 1 }, "of others": [1, 2] }), true),
        (json!({ "enfilade": { "detail": 0 } }), false),
        (json!({ "enfilade": { "detail": "very" } }), false),
        (json!({ "enfilade": 7 }), false),
        (json!(["enfilade"]), false),
        (json!(null), false),
    ] {
        let mut file = File::leaf();
        file.push("materials", json!({ "extras": extras }));
        file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let import = reads(&file);
        let geometry = &import.rooms[0].geometry;
        assert_eq!(geometry.materials()[0].detail, expected, "{extras}");
    }
}

#[test]
fn a_primitive_without_a_material_is_white_and_one_sided() {
    let import = reads(&File::leaf());
    let geometry = &import.rooms[0].geometry;
    let cluster = &geometry.meshes()[0].clusters()[0];
    assert_eq!(
        (cluster.material, geometry.material(cluster)),
        (MaterialId(0), &Material::opaque([1.0; 3]))
    );
}

#[test]
fn triangles_beside_points_and_lines_are_drawn() {
    let mut file = File::leaf();
    for mode in 0..4 {
        let mut primitive = file.json["meshes"][0]["primitives"][0].clone();
        primitive["mode"] = json!(mode);
        file.json["meshes"][0]["primitives"]
            .as_array_mut()
            .expect("a list")
            .push(primitive);
    }
    let import = reads(&file);
    assert_eq!(triangles(&import), ["Leaf 0,0,0 1,0,0 0,1,0"]);
    assert_eq!(
        warnings(&import),
        [
            "points are not drawn (meshes[0].primitives[1])",
            "lines are not drawn (meshes[0].primitives[2], meshes[0].primitives[3], meshes[0].primitives[4])",
        ]
    );
}

#[test]
fn any_number_of_threads_reads_the_same() {
    let mut file = File::empty();
    for number in 0..200_u8 {
        let corner = f32::from(number);
        let primitive = file.primitive(
            &[[corner, 0.0, 0.0], [0.0, corner, 0.0], [0.0, 0.0, corner]],
            &[0, 1, 2],
        );
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "mesh": mesh }));
    }
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| format!("{:?}", reads(&file)))
    };
    assert_eq!(with(1), with(4));
}
