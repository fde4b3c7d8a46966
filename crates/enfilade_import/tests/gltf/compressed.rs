//! Meshes that meshoptimizer compressed.

use crate::file::{File, carried, reads, refusal, triangles, warnings};
use meshopt::EncodeExpMode;
use serde_json::json;

const LEAF: [&str; 1] = ["Leaf 0,0,0 1,0,0 0,1,0"];

/// Adds a compressed view of `count` elements of `stride` bytes in a fallback buffer, and says its number.
pub(crate) fn compressed(
    file: &mut File,
    encoded: Vec<u8>,
    count: usize,
    stride: usize,
    mode: &str,
    filter: &str,
) -> usize {
    let source = file.view(encoded);
    let source = file.json["bufferViews"][source].clone();
    let length = count * stride;
    if file.json["buffers"][1].is_null() {
        // Nothing is in it: it is there for who cannot decode.
        let fallback =
            json!({ "byteLength": 0, "extensions": { "EXT_meshopt_compression": { "fallback": true } } });
        file.push("buffers", fallback);
        file.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    }
    let start = file.json["buffers"][1]["byteLength"].as_u64().expect("a number");
    file.json["buffers"][1]["byteLength"] = json!(start + length as u64);
    file.push(
        "bufferViews",
        json!({ "buffer": 1, "byteOffset": start, "byteLength": length, "extensions": { "EXT_meshopt_compression": {
            "buffer": 0, "byteOffset": source["byteOffset"], "byteLength": source["byteLength"],
            "byteStride": stride, "count": count, "mode": mode, "filter": filter
        } } }),
    )
}

/// The leaf with both of its views compressed, the first in the first view.
pub(crate) fn leaf() -> File {
    let mut file = File::leaf();
    let corners: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let encoded = meshopt::encode_vertex_buffer(&corners).expect("encoded");
    let positions = compressed(&mut file, encoded, 3, 12, "ATTRIBUTES", "NONE");
    let encoded = meshopt::encode_index_buffer(&[0, 1, 2], 3).expect("encoded");
    let indices = compressed(&mut file, encoded, 3, 2, "TRIANGLES", "NONE");
    file.json["accessors"][0]["bufferView"] = json!(positions);
    file.json["accessors"][1]["bufferView"] = json!(indices);
    file
}

#[test]
fn positions_and_triangles_come_out_as_they_went_in() {
    let file = leaf();
    let import = reads(&file);
    assert_eq!(triangles(&import), LEAF);
    assert_eq!(warnings(&import), [""; 0]);
    // The same under its later name.
    let text = file.json.to_string().replace("EXT_meshopt", "KHR_meshopt");
    let bytes = crate::file::glb(&text, &file.bytes);
    assert_eq!(refusal(&bytes), None);
}

#[test]
fn indices_may_be_a_sequence_and_of_four_bytes() {
    for (mode, stride) in [("INDICES", 2), ("INDICES", 4), ("TRIANGLES", 4)] {
        let mut file = leaf();
        let encoded = match mode {
            "INDICES" => meshopt::encode_index_sequence(&[0, 1, 2], 3),
            _ => meshopt::encode_index_buffer(&[0, 1, 2], 3),
        };
        let view = compressed(&mut file, encoded.expect("encoded"), 3, stride, mode, "NONE");
        file.json["accessors"][1]["bufferView"] = json!(view);
        file.json["accessors"][1]["componentType"] = json!(if stride == 2 { 5123 } else { 5125 });
        assert_eq!(triangles(&reads(&file)), LEAF, "{mode} {stride}");
    }
}

#[test]
fn elements_of_all_sizes_are_decoded() {
    /// Three positions, each with other words behind it.
    fn encoded<const WORDS: usize>() -> Vec<u8> {
        let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let elements = corners.map(|corner| {
            let mut words = [7_u32; WORDS];
            words[..3].copy_from_slice(&corner.map(f32::to_bits));
            words
        });
        meshopt::encode_vertex_buffer(&elements).expect("encoded")
    }
    for (words, encoded) in [
        (3, encoded::<3>()),
        (4, encoded::<4>()),
        (31, encoded::<31>()),
        (37, encoded::<37>()),
        (64, encoded::<64>()),
    ] {
        let mut file = leaf();
        let view = compressed(&mut file, encoded, 3, 4 * words, "ATTRIBUTES", "NONE");
        file.json["bufferViews"][view]["byteStride"] = json!(4 * words);
        file.json["accessors"][0]["bufferView"] = json!(view);
        assert_eq!(triangles(&reads(&file)), LEAF, "{words} words");
    }
}

#[test]
fn filters_are_undone() {
    let normals = [
        [0.0_f32, 0.0, 1.0, 0.0],
        [0.6, 0.0, 0.8, 0.0],
        [0.0, -1.0, 0.0, 0.0],
    ];
    let small = meshopt::encode_filter_oct::<i8>(&normals, 8);
    let large = meshopt::encode_filter_oct::<i16>(&normals, 14);
    for (encoded, stride, component, tolerance) in [
        (meshopt::encode_vertex_buffer(&small), 4, 5120, 0.02),
        (meshopt::encode_vertex_buffer(&large), 8, 5122, 0.001),
    ] {
        let mut file = leaf();
        let view = compressed(
            &mut file,
            encoded.expect("encoded"),
            3,
            stride,
            "ATTRIBUTES",
            "OCTAHEDRAL",
        );
        file.json["bufferViews"][view]["byteStride"] = json!(stride);
        let accessor = file.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "type": "VEC3", "count": 3, "normalized": true
            }),
        );
        file.carry("NORMAL", accessor);
        let found = carried(&reads(&file), |mesh| mesh.normals());
        for (found, expected) in found.iter().zip(normals) {
            assert!(
                (0..3).all(|axis| (found[axis] - expected[axis]).abs() < tolerance),
                "{found:?}, not {expected:?}"
            );
        }
    }

    let corners = [[0.0_f32; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let encoded = meshopt::encode_filter_exp(&corners, 15, EncodeExpMode::Separate);
    let encoded = meshopt::encode_vertex_buffer(&encoded).expect("encoded");
    let mut file = leaf();
    let view = compressed(&mut file, encoded, 3, 12, "ATTRIBUTES", "EXPONENTIAL");
    file.json["accessors"][0]["bufferView"] = json!(view);
    assert_eq!(triangles(&reads(&file)), LEAF);

    // Half a turn about z, for one instance.
    let turns = meshopt::encode_filter_quat(&[[0.0, 0.0, 1.0, 0.0]], 16);
    let encoded = meshopt::encode_vertex_buffer(&turns).expect("encoded");
    let mut file = leaf();
    let view = compressed(&mut file, encoded, 1, 8, "ATTRIBUTES", "QUATERNION");
    let turns = file.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5122, "type": "VEC4", "count": 1, "normalized": true }),
    );
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "ROTATION": turns } } });
    let import = reads(&file);
    let place = import.rooms[0].geometry.item(enfilade::ItemId(0)).transform();
    let tip = place.point([1.0, 0.0, 0.0]);
    assert!(
        (0..3).all(|axis| (tip[axis] - [-1.0, 0.0, 0.0][axis]).abs() < 1e-3),
        "{tip:?}"
    );

    let gold = [[1.0_f32, 0.5, 0.0, 1.0]; 3];
    let small = meshopt::encode_filter_color::<u8>(&gold, 8);
    let large = meshopt::encode_filter_color::<u16>(&gold, 16);
    for (encoded, stride, component) in [
        (meshopt::encode_vertex_buffer(&small), 4, 5121),
        (meshopt::encode_vertex_buffer(&large), 8, 5123),
    ] {
        let mut file = leaf();
        let view = compressed(
            &mut file,
            encoded.expect("encoded"),
            3,
            stride,
            "ATTRIBUTES",
            "COLOR",
        );
        let colors = file.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": "VEC4", "count": 3, "normalized": true }),
        );
        file.carry("COLOR_0", colors);
        for found in carried(&reads(&file), |mesh| mesh.colors()) {
            assert!(
                (0..4).all(|part| (found[part] - gold[0][part]).abs() < 0.02),
                "{found:?}"
            );
        }
    }
}
