//! Compressed meshes that are damaged or make no sense: refused, or read as whatever they are now, never worse.

use super::compressed::{compressed, leaf};
use super::file::{File, reads, refusal};
use super::hostile::numbers;
use super::meshopt;
use enfilade_import::{ReadOptions, read_bytes};
use serde_json::{Value, json};

fn extension(file: &mut File) -> &mut Value {
    &mut file.json["bufferViews"][3]["extensions"]["EXT_meshopt_compression"]
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
            "bufferView 3 is compressed, but its bytes are damaged: the stream ends too early; export it again",
        ),
        (
            "byteOffset",
            json!(u64::MAX),
            "bufferView 3 ends at byte 1844674407370955",
        ),
        (
            "byteOffset",
            json!(0),
            "its bytes are damaged: the stream begins with the byte 0x00, which is not a header of its mode",
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
        said.contains("bufferView 3 would raise the memory needed to"),
        "{said}"
    );
}

#[test]
fn damaged_streams_are_read_or_refused() {
    // A larger mesh, so that the streams have something in them: a wavy sheet.
    let side = 24_u32;
    let corners: Vec<[i32; 3]> = (0..side * side)
        .map(|i| [i % side, i / side, (i * i) % 7].map(u32::cast_signed))
        .collect();
    let mut triangles = Vec::new();
    for i in (0..side * (side - 1)).filter(|i| i % side < side - 1) {
        triangles.extend([i, i + 1, i + side, i + 1, i + side + 1, i + side]);
    }
    // Small whole numbers are floats with the exponent 0.
    let exponential: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|part| part.to_le_bytes())
        .collect();
    let octahedral: Vec<u8> = corners
        .iter()
        .flat_map(|corner| [10 * corner[2] as u8, 0, 127, 0])
        .collect();
    let mut file = File::leaf();
    let count = corners.len();
    let mut add =
        |encoded, count, stride, mode, filter| compressed(&mut file, encoded, count, stride, mode, filter);
    let views = [
        add(
            meshopt::vertices(&exponential, 12),
            count,
            12,
            "ATTRIBUTES",
            "EXPONENTIAL",
        ),
        add(
            meshopt::vertices(&octahedral, 4),
            count,
            4,
            "ATTRIBUTES",
            "OCTAHEDRAL",
        ),
        add(
            meshopt::triangles(&triangles),
            triangles.len(),
            4,
            "TRIANGLES",
            "NONE",
        ),
        add(
            meshopt::sequence(&triangles),
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
    assert_eq!(reads(&file).rooms[0].geometry.triangle_count(), 2 * 2 * 23 * 23);

    let limits = ReadOptions {
        limit_bytes: 1 << 26,
        ..ReadOptions::default()
    };
    let mut number = numbers(7);
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
