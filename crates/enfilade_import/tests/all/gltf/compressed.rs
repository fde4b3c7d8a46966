//! Meshes that meshoptimizer compressed.

use super::file::{File, carried, reads, refusal, triangles, warnings};
use super::meshopt;
use serde_json::json;

const LEAF: [&str; 1] = ["Leaf 0,0,0 1,0,0 0,1,0"];
const CORNERS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Adds a compressed view of `count` elements of `stride` bytes in a fallback buffer, and returns its number.
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
        // It has no bytes: only a reader without a decoder would need them.
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
    let encoded = meshopt::vertices(CORNERS.map(f32::to_le_bytes).as_flattened(), 12);
    let positions = compressed(&mut file, encoded, 3, 12, "ATTRIBUTES", "NONE");
    let encoded = meshopt::triangles(&[0, 1, 2]);
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
    let bytes = super::file::glb(&text, &file.bytes);
    assert_eq!(refusal(&bytes), None);
}

#[test]
fn indices_may_be_a_sequence_and_of_four_bytes() {
    for (mode, stride) in [("INDICES", 2), ("INDICES", 4), ("TRIANGLES", 4)] {
        let mut file = leaf();
        let encoded = match mode {
            "INDICES" => meshopt::sequence(&[0, 1, 2]),
            _ => meshopt::triangles(&[0, 1, 2]),
        };
        let view = compressed(&mut file, encoded, 3, stride, mode, "NONE");
        file.json["accessors"][1]["bufferView"] = json!(view);
        file.json["accessors"][1]["componentType"] = json!(if stride == 2 { 5123 } else { 5125 });
        assert_eq!(triangles(&reads(&file)), LEAF, "{mode} {stride}");
    }
}

#[test]
fn elements_of_all_sizes_are_decoded() {
    for words in 3..=64 {
        // Three positions, each followed by other bytes.
        let mut elements = vec![7; 3 * 4 * words];
        for (element, corner) in elements.chunks_exact_mut(4 * words).zip(CORNERS.chunks(3)) {
            let position = corner.iter().flat_map(|part| part.to_le_bytes());
            element.iter_mut().zip(position).for_each(|(to, from)| *to = from);
        }
        let encoded = meshopt::vertices(&elements, 4 * words);
        let mut file = leaf();
        let view = compressed(&mut file, encoded, 3, 4 * words, "ATTRIBUTES", "NONE");
        file.json["bufferViews"][view]["byteStride"] = json!(4 * words);
        file.json["accessors"][0]["bufferView"] = json!(view);
        assert_eq!(triangles(&reads(&file)), LEAF, "{words} words");
    }
}

/// Encodes elements of four numbers; an element has `stride` bytes.
fn shorts_or_bytes<const N: usize>(elements: [[i32; 4]; N], stride: usize) -> Vec<u8> {
    let numbers = elements.into_iter().flatten();
    let bytes: Vec<u8> = numbers
        .flat_map(|number| number.to_le_bytes().into_iter().take(stride / 4))
        .collect();
    meshopt::vertices(&bytes, stride)
}

#[test]
fn octahedral_normals_are_unit_vectors() {
    let normals = [[0.0_f32, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, -1.0, 0.0]];
    for (one, stride, component, tolerance) in [
        (127, 4, 5120, 0.02),
        (31, 4, 5120, 0.05),
        (32767, 8, 5122, 0.0001),
        (511, 8, 5122, 0.004),
    ] {
        let elements = normals.map(|[x, y, z]| {
            let sum = x.abs() + y.abs() + z.abs();
            let [x, y] = [x, y].map(|part| (part / sum * one as f32).round() as i32);
            [x, y, one, 0]
        });
        let mut file = leaf();
        let encoded = shorts_or_bytes(elements, stride);
        let view = compressed(&mut file, encoded, 3, stride, "ATTRIBUTES", "OCTAHEDRAL");
        file.json["bufferViews"][view]["byteStride"] = json!(stride);
        let accessor = file.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "type": "VEC3", "count": 3, "normalized": true
            }),
        );
        file.carry("NORMAL", accessor);
        let found = carried(&reads(&file), |mesh| mesh.normals());
        assert_eq!(found.len(), 3);
        for (found, expected) in found.iter().zip(normals) {
            assert!(
                (0..3).all(|axis| (found[axis] - expected[axis]).abs() < tolerance),
                "{one}: {found:?}, not {expected:?}"
            );
        }
    }
}

#[test]
fn exponential_positions_are_floats() {
    // 1 as 1·2⁰, as 1024·2⁻¹⁰ and as 2²²·2⁻²².
    for one in [1_i32, (-10 << 24) | 1024, (-22 << 24) | (1 << 22)] {
        let numbers = CORNERS.map(|part| if part == 0.0 { 0 } else { one }.to_le_bytes());
        let mut file = leaf();
        let encoded = meshopt::vertices(numbers.as_flattened(), 12);
        let view = compressed(&mut file, encoded, 3, 12, "ATTRIBUTES", "EXPONENTIAL");
        file.json["accessors"][0]["bufferView"] = json!(view);
        assert_eq!(triangles(&reads(&file)), LEAF, "{one:#x}");
    }
}

#[test]
fn quaternions_turn_instances() {
    // Half a turn about z: the third component is the largest, the others are 0.
    let encoded = shorts_or_bytes([[0, 0, 0, 32764 | 2]], 8);
    let mut file = leaf();
    let view = compressed(&mut file, encoded, 1, 8, "ATTRIBUTES", "QUATERNION");
    let turns = file.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5122, "type": "VEC4", "count": 1, "normalized": true }),
    );
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "ROTATION": turns } } });
    let import = reads(&file);
    let place = import.rooms[0].geometry.item(enfilade::ItemIndex(0)).transform();
    let tip = place.point([1.0, 0.0, 0.0]);
    assert!(
        (0..3).all(|axis| (tip[axis] - [-1.0, 0.0, 0.0][axis]).abs() < 1e-3),
        "{tip:?}"
    );
}

#[test]
fn colors_are_red_green_and_blue() {
    let gold = [1.0_f32, 0.5, 0.0, 1.0];
    for (max, stride, component) in [(255, 4, 5121), (65535, 8, 5123)] {
        // Luma and the difference from blue to red are halves; alpha is opaque, below the bit that says how many there are.
        let mut file = leaf();
        let encoded = shorts_or_bytes([[max / 2, max / 2, 0, max]; 3], stride);
        let view = compressed(&mut file, encoded, 3, stride, "ATTRIBUTES", "COLOR");
        let colors = file.push(
            "accessors",
            json!({ "bufferView": view, "componentType": component, "type": "VEC4", "count": 3, "normalized": true }),
        );
        file.carry("COLOR_0", colors);
        let found = carried(&reads(&file), |mesh| mesh.colors());
        assert_eq!(found.len(), 3);
        for found in found {
            assert!(
                (0..4).all(|part| (found[part] - gold[part]).abs() < 0.005),
                "{found:?}"
            );
        }
    }
}
