//! Files made to do harm: they may be refused, but never take the program down, or its memory, or its time.

use super::file::{File, glb, refusal};
use super::rooms::{door, two_rooms};
use enfilade_import::{BrokenRule, ReadOptions, read, read_bytes};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

/// A file like those of exporters: two meshes, a tree of nodes, materials, a camera.
fn orchard() -> File {
    let mut file = File::leaf();
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut strip = file.primitive(&square, &[0, 1, 2, 3]);
    strip["mode"] = json!(5);
    strip["material"] = json!(0);
    let mesh = file.mesh(json!([strip]));
    file.push(
        "materials",
        json!({ "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 0.5] } }),
    );
    file.push(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }),
    );
    let crown = file.node(json!({ "name": "Crown", "mesh": mesh, "scale": [2, 2, 2] }));
    file.node(
        json!({ "children": [crown], "camera": 0, "rotation": [0, 0, 0, 1], "translation": [0, 3, 0] }),
    );
    file.json["scenes"] = json!([{ "nodes": [0, 2] }]);
    file
}

/// Returns random numbers below those asked for, reproducible by seed.
pub(crate) fn numbers(seed: u64) -> impl FnMut(usize) -> usize {
    let mut random = fastrand::Rng::with_seed(seed);
    move |below| random.usize(..below)
}

#[test]
fn rooms_and_portals_with_a_number_or_a_word_wrong_are_read_or_refused() {
    let mut mirror = door("Glass-mirror", Value::Null);
    mirror["translation"] = json!([-1.9, 0, 0]);
    let mut gate = door(
        "Gate-portal",
        json!({ "kind": "portal", "exit": "Out", "one_way": 1 }),
    );
    gate["translation"] = json!([-0.5, 0.2, 0]);
    let house = two_rooms(&[
        door("Door-portal", json!({ "to": "B-room" })),
        gate,
        json!({ "name": "Out", "translation": [1, 0, 0] }),
        mirror,
    ]);
    let text = house.json.to_string();
    let mut number = numbers(7);
    let bad = [
        "0", "-1", "1e38", "1e-38", "7", "null", "\"\"", "[]", "{}", "true",
    ];
    let (mut read, mut refused) = (0, 0);
    for _ in 0..3000 {
        // One word of letters, or one number, becomes something else.
        let start = number(text.len());
        let is_word = |byte: u8| byte.is_ascii_alphanumeric() || b".-\"".contains(&byte);
        let tail = &text[start..];
        let from = start + tail.bytes().position(is_word).unwrap_or(0);
        let word = text[from..].bytes().take_while(|&byte| is_word(byte)).count();
        let broken = format!(
            "{}{}{}",
            &text[..from],
            bad[number(bad.len())],
            &text[from + word..]
        );
        match refusal(&glb(&broken, &house.bytes)) {
            None => read += 1,
            Some(_) => refused += 1,
        }
    }
    assert!(read > 100 && refused > 100, "{read} read, {refused} refused");
}

/// Reads files that have something wrong in them: none may do harm, and of all neither next to none may be read, nor refused.
pub(crate) fn each_is_read_or_refused(files: impl ExactSizeIterator<Item = Vec<u8>>) {
    let limits = ReadOptions {
        limit_bytes: 1 << 26,
        ..ReadOptions::default()
    };
    let few = files.len() / 20;
    let (mut read, mut refused) = (0, 0);
    for file in files {
        match read_bytes(&file, None, &limits) {
            Ok(_) => read += 1,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                refused += 1;
            }
        }
    }
    assert!(
        read > few && refused > few,
        "{read} read, {refused} refused: the mutations are too mild or too wild"
    );
}

#[test]
fn a_file_with_a_few_bytes_wrong_is_read_or_refused() {
    const SEED: u64 = 20_261_121;
    let whole = orchard().glb();
    let json_end = 20 + u32::from_le_bytes(whole[12..16].try_into().expect("four bytes")) as usize;
    let mut number = numbers(SEED);
    each_is_read_or_refused((0..20_000).map(|_| {
        let mut file = whole.clone();
        for _ in 0..=number(3) {
            match number(8) {
                0 => file[number(20)] = number(256) as u8,
                1 => file.truncate(20 + number(file.len() - 20)),
                // Digits for digits, so that much of it is still JSON and only the numbers are wrong.
                2..6 => {
                    let at = 20 + number(json_end.min(file.len()) - 20);
                    if file[at].is_ascii_digit() {
                        file[at] = b'0' + number(10) as u8;
                    }
                }
                _ => {
                    let at = number(file.len());
                    file[at] ^= 1 << number(8);
                }
            }
            if file.len() <= 20 {
                break;
            }
        }
        file
    }));
}

/// Reads a file again and again, each time with another of its numbers replaced by a bad one: none may do harm.
pub(crate) fn read_with_each_number_replaced(file: &File) {
    const BAD: [&str; 14] = [
        "-1",
        "0",
        "1",
        "2",
        "3",
        "255",
        "65535",
        "4294967295",
        "4294967296",
        "1152921504606846976",
        "18446744073709551615",
        "1e308",
        "null",
        "[]",
    ];
    let text = file.json.to_string();
    let is_digit = |at: usize| text.as_bytes()[at].is_ascii_digit();
    let starts = (1..text.len()).filter(|&at| is_digit(at) && !is_digit(at - 1));
    for start in starts {
        let end = (start..text.len())
            .find(|&at| !is_digit(at))
            .expect("JSON ends with a bracket");
        for bad in BAD {
            let json = format!("{}{bad}{}", &text[..start], &text[end..]);
            let _ = refusal(&glb(&json, &file.bytes));
        }
    }
}

#[test]
fn text_with_a_number_replaced_by_a_bad_one_is_read_or_refused() {
    read_with_each_number_replaced(&orchard());
}

#[track_caller]
fn too_large(bytes: &[u8], limit_bytes: u64, place: &str) {
    let error = read_bytes(
        bytes,
        None,
        &ReadOptions {
            limit_bytes,
            ..ReadOptions::default()
        },
    )
    .expect_err("more than is allowed");
    assert!(matches!(error.rule, BrokenRule::TooLarge { .. }), "{error}");
    assert!(
        error
            .to_string()
            .starts_with(&format!("the bytes given: {place}")),
        "{error}"
    );
}

#[test]
fn what_would_take_too_much_memory_is_refused_before_it_does() {
    let file = File::leaf().glb();
    too_large(&file, 100, "the file");
    too_large(&file, file.len() as u64 + 100, "the JSON");

    // Ten million million triangles, all at the origin, in a few bytes.
    let mut zeros = File::leaf();
    zeros.json["accessors"][1] =
        json!({ "componentType": 5125, "type": "SCALAR", "count": 30_000_000_000_000_u64 });
    too_large(&zeros.glb(), 1 << 30, "meshes[0]");
    zeros.json["accessors"][1]["count"] = json!(u64::MAX);
    too_large(&zeros.glb(), 1 << 30, "meshes[0]");

    // The same million triangles in a thousand meshes.
    let mut copies = File::leaf();
    copies.json["accessors"][1] = json!({ "componentType": 5125, "type": "SCALAR", "count": 3_000_000 });
    let primitive = copies.json["meshes"][0]["primitives"][0].clone();
    for _ in 0..1000 {
        let mesh = copies.mesh(json!([primitive]));
        copies.node(json!({ "mesh": mesh }));
    }
    too_large(&copies.glb(), 1 << 30, "meshes[");

    // One mesh that would fit, if it could be built without working memory.
    let mut large = File::leaf();
    large.json["accessors"][1] = json!({ "componentType": 5125, "type": "SCALAR", "count": 30_000_000 });
    too_large(&large.glb(), 1 << 30, "the building of meshes");

    // A million items in sixteen million bytes.
    let mut items = File::leaf();
    items.json["nodes"] = Value::Array(vec![json!({ "mesh": 0 }); 1_000_000]);
    too_large(&items.glb(), 600_000_000, "the nodes");

    // A million nodes in two million bytes.
    let nodes = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{}{{}}]}}",
        "[],".repeat(1_000_000)
    );
    too_large(nodes.as_bytes(), 1 << 27, "the JSON");

    let data = format!("data:;base64,{}", "A".repeat(10_000_000));
    too_large(&File::leaf().gltf(&data), 15_000_000, "buffer 0");
}

#[test]
fn even_without_a_limit_corners_are_counted_with_32_bits() {
    let mut zeros = File::leaf();
    zeros.json["accessors"][1] = json!({ "componentType": 5125, "type": "SCALAR", "count": u64::MAX });
    let error = read_bytes(
        &zeros.glb(),
        None,
        &ReadOptions {
            limit_bytes: u64::MAX,
            ..ReadOptions::default()
        },
    )
    .expect_err("too many");
    assert!(
        error
            .to_string()
            .contains("meshes[0] has more than 4 billion corners"),
        "{error}"
    );
}

#[test]
fn a_buffer_of_ten_gigabytes_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    // A file with a hole: it is that long, but takes no room on the disk.
    let buffer = std::fs::File::create(folder.path().join("leaf.bin")).expect("a file");
    if buffer.set_len(10_000_000_000).is_err() {
        return;
    }
    let mut leaf = File::leaf();
    leaf.json["buffers"][0]["byteLength"] = json!(10_000_000_000_u64);
    let path = folder.path().join("leaf.gltf");
    std::fs::write(&path, leaf.gltf("leaf.bin")).expect("a file");
    let error = read(&path, &ReadOptions::default()).expect_err("more than is allowed");
    assert!(
        error
            .to_string()
            .contains("buffer 0 would raise the memory needed to 10 GB"),
        "{error}"
    );

    let error =
        read(&folder.path().join("leaf.bin"), &ReadOptions::default()).expect_err("more than is allowed");
    assert!(
        error
            .to_string()
            .contains("the file would raise the memory needed to 10 GB"),
        "{error}"
    );
}

#[test]
fn a_thousand_primitives_of_one_large_accessor_take_no_longer_for_it() {
    // Each draws one triangle among a million positions.
    let mut file = File::empty();
    let positions = file.positions(&vec![[0.5; 3]; 1_000_000]);
    let mut primitives = Vec::new();
    for part in 0..1000_u32 {
        let indices = [part, part + 500_000, 999_999]
            .iter()
            .flat_map(|index| index.to_le_bytes())
            .collect();
        let indices = file.indices(5125, 3, indices);
        primitives.push(json!({ "attributes": { "POSITION": positions }, "indices": indices }));
    }
    let mesh = file.mesh(Value::Array(primitives));
    file.node(json!({ "mesh": mesh }));
    let bytes = file.glb();
    let start = Instant::now();
    assert_eq!(refusal(&bytes), None);
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

#[test]
fn a_million_children_of_one_node_are_fast() {
    let mut file = File::leaf();
    let children: Vec<u32> = (1..1_000_000).collect();
    let mut nodes = vec![json!({ "children": children })];
    nodes.extend((1..1_000_000).map(|_| json!({})));
    nodes[1] = json!({ "mesh": 0 });
    file.json["nodes"] = Value::Array(nodes);
    let bytes = file.glb();
    let start = Instant::now();
    assert_eq!(refusal(&bytes), None);
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

#[test]
fn names_that_fight_each_other_are_settled_fast() {
    let mut file = File::leaf();
    let mut nodes = Vec::new();
    let mut name = "A".to_owned();
    for _ in 0..500 {
        nodes.push(json!({ "name": name, "mesh": 0 }));
        name.push_str("#1000");
    }
    nodes.resize(2000, json!({ "name": "A", "mesh": 0 }));
    file.json["nodes"] = Value::Array(nodes);
    let start = Instant::now();
    assert_eq!(refusal(&file.glb()), None);
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

/// The changes, by name.
type Change<'a> = (&'a str, &'a dyn Fn(&mut Value));

#[test]
fn a_message_stays_short_and_plain_whatever_the_file_says() {
    let long = "é\u{1b}[2J".repeat(100_000);
    let changes: [Change; 7] = [
        ("a name", &|j| j["nodes"][0] = json!({ "name": long, "mesh": 7 })),
        ("an extension", &|j| j["extensionsRequired"] = json!([long])),
        ("a version", &|j| j["asset"]["version"] = json!(long)),
        ("an alpha mode", &|j| {
            j["materials"] = json!([{ "alphaMode": long }])
        }),
        ("a type", &|j| j["accessors"][0]["type"] = json!(long)),
        ("an address", &|j| j["buffers"][0]["uri"] = json!(long)),
        ("a word for a number", &|j| j["nodes"] = json!(long)),
    ];
    for (what, change) in changes {
        let mut file = File::leaf();
        change(&mut file.json);
        let said = refusal(&file.glb()).expect("an error");
        assert!(
            said.len() < 500 && !said.contains('\u{1b}'),
            "{what}: {} bytes",
            said.len()
        );
    }
}
