//! Meshes that meshoptimizer compressed.

use crate::file::{File, carried, reads, refusal, triangles, warnings};
use enfilade_import::{ReadOptions, read_bytes};
use meshopt::EncodeExpMode;
use serde_json::{Value, json};

const LEAF: [&str; 1] = ["Leaf 0,0,0 1,0,0 0,1,0"];

/// Adds a compressed view of `count` elements of `stride` bytes in a fallback buffer, and says its number.
fn compressed(
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
fn leaf() -> File {
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

fn extension(file: &mut File) -> &mut Value {
    &mut file.json["bufferViews"][3]["extensions"]["EXT_meshopt_compression"]
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
    let place = import.rooms[0].content.item(enfilade::ItemId(0)).transform();
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

#[test]
fn compressed_views_that_make_no_sense_are_refused_before_they_are_decoded() {
    for (key, value, expected) in [
        (
            "mode",
            json!("TETRAHEDRA"),
            "bufferView 3 is compressed, but its mode is none of ATTRIBUTES, TRIANGLES",
        ),
        (
            "filter",
            json!("COFFEE"),
            "bufferView 3 is compressed, but its filter is none of NONE, OCTAHEDRAL",
        ),
        (
            "filter",
            json!("OCTAHEDRAL"),
            "its elements of 12 bytes do not go with its mode and filter",
        ),
        (
            "filter",
            json!("QUATERNION"),
            "its elements of 12 bytes do not go with its mode and filter",
        ),
        (
            "filter",
            json!("COLOR"),
            "its elements of 12 bytes do not go with its mode and filter",
        ),
        (
            "mode",
            json!("TRIANGLES"),
            "its elements of 12 bytes do not go with its mode and filter",
        ),
        ("byteStride", json!(0), "its elements of 0 bytes"),
        ("byteStride", json!(13), "its elements of 13 bytes"),
        ("byteStride", json!(260), "its elements of 260 bytes"),
        ("count", json!(4), "it decodes to 48 bytes, but should have 36"),
        (
            "count",
            json!(u64::MAX),
            "it decodes to 221360928884514619380 bytes, but should have 36",
        ),
        ("byteLength", json!(1_000_000), "bufferView 3 ends at byte 10000"),
        (
            "byteLength",
            json!(0),
            "bufferView 3 is compressed, but its bytes are damaged; copy or export it again",
        ),
        (
            "byteOffset",
            json!(u64::MAX),
            "bufferView 3 ends at byte 184467440737095516",
        ),
        (
            "byteOffset",
            json!(0),
            "bufferView 3 is compressed, but its bytes are damaged",
        ),
        (
            "buffer",
            json!(9),
            "bufferView 3 names buffer 9, but there are only 2",
        ),
        // The one without bytes.
        ("buffer", json!(1), "bufferView 3 ends at byte"),
    ] {
        let mut file = leaf();
        extension(&mut file)[key] = value.clone();
        let said = refusal(&file.glb()).unwrap_or_else(|| panic!("{key} {value} is read without complaint"));
        assert!(
            said.contains(expected),
            "{key} {value}: it says\n  {said}\nand not\n  {expected}"
        );
    }
    let mut file = leaf();
    let triangles = &mut file.json["bufferViews"][5];
    triangles["extensions"]["EXT_meshopt_compression"]["filter"] = json!("EXPONENTIAL");
    let said = refusal(&file.glb()).expect("an error");
    assert!(
        said.contains("bufferView 5 is compressed, but indices have no filter"),
        "{said}"
    );
    let mut file = leaf();
    let triangles = &mut file.json["bufferViews"][5];
    triangles["byteLength"] = json!(8);
    triangles["extensions"]["EXT_meshopt_compression"]["count"] = json!(4);
    let said = refusal(&file.glb()).expect("an error");
    assert!(
        said.contains("bufferView 5 is compressed, but 4 indices make no triangles"),
        "{said}"
    );
}

#[test]
fn a_view_that_would_swell_beyond_all_memory_is_refused_before_it_does() {
    let mut file = leaf();
    let many = 1_u64 << 31;
    extension(&mut file)["count"] = json!(many);
    file.json["bufferViews"][3]["byteLength"] = json!(12 * many);
    let said = refusal(&file.glb()).expect("an error");
    assert!(
        said.contains("bufferView 3 would take the memory needed to"),
        "{said}"
    );
}

#[test]
fn damaged_streams_are_read_or_refused() {
    // A larger mesh, so that the streams have something in them: a wavy sheet.
    let side = 24_u32;
    let corners: Vec<[f32; 3]> = (0..side * side)
        .map(|i| [(i % side) as f32, (i / side) as f32, ((i * i) % 7) as f32])
        .collect();
    let mut triangles = Vec::new();
    for i in (0..side * (side - 1)).filter(|i| i % side < side - 1) {
        triangles.extend([i, i + 1, i + side, i + 1, i + side + 1, i + side]);
    }
    let normals: Vec<[f32; 4]> = corners.iter().map(|c| [c[2] / 10.0, 0.0, 0.9, 0.0]).collect();
    let mut file = File::leaf();
    let exponential = meshopt::encode_filter_exp(&corners, 12, EncodeExpMode::SharedVector);
    let octahedral = meshopt::encode_filter_oct::<i8>(&normals, 8);
    let count = corners.len();
    let mut add = |encoded: meshopt::Result<Vec<u8>>, count, stride, mode, filter| {
        compressed(&mut file, encoded.expect("encoded"), count, stride, mode, filter)
    };
    let views = [
        add(
            meshopt::encode_vertex_buffer(&exponential),
            count,
            12,
            "ATTRIBUTES",
            "EXPONENTIAL",
        ),
        add(
            meshopt::encode_vertex_buffer(&octahedral),
            count,
            4,
            "ATTRIBUTES",
            "OCTAHEDRAL",
        ),
        add(
            meshopt::encode_index_buffer(&triangles, count),
            triangles.len(),
            4,
            "TRIANGLES",
            "NONE",
        ),
        add(
            meshopt::encode_index_sequence(&triangles, count),
            triangles.len(),
            2,
            "INDICES",
            "NONE",
        ),
    ];
    file.json["bufferViews"][views[1]]["byteStride"] = json!(4);
    file.json["accessors"] = json!([
        { "bufferView": views[0], "componentType": 5126, "type": "VEC3", "count": count },
        { "bufferView": views[1], "componentType": 5120, "type": "VEC3", "count": count, "normalized": true },
        { "bufferView": views[2], "componentType": 5125, "type": "SCALAR", "count": triangles.len() },
        { "bufferView": views[3], "componentType": 5123, "type": "SCALAR", "count": triangles.len() },
    ]);
    let attributes = json!({ "POSITION": 0, "NORMAL": 1 });
    file.json["meshes"] = json!([{ "primitives": [
        { "attributes": attributes, "indices": 2 }, { "attributes": attributes, "indices": 3 }
    ] }]);
    assert_eq!(reads(&file).rooms[0].content.triangle_count(), 2 * 2 * 23 * 23);

    let limits = ReadOptions {
        limit_bytes: 1 << 26,
        ..ReadOptions::default()
    };
    let mut state = 7_u64;
    let mut number = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let whole = file.bytes.clone();
    let (mut read, mut refused) = (0, 0);
    for _ in 0..4000 {
        file.bytes.clone_from(&whole);
        for _ in 0..=number(4) {
            let at = number(whole.len());
            match number(3) {
                0 => file.bytes[at] = number(256) as u8,
                1 => file.bytes[at] ^= 1 << number(8),
                _ => {
                    let end = (at + number(16)).min(whole.len());
                    file.bytes[at..end].fill(0xff);
                }
            }
        }
        match read_bytes(&file.glb(), None, &limits) {
            Ok(_) => read += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(read > 200 && refused > 200, "{read} read, {refused} refused");
}
