//! Tests containers: binary and text, with separate and embedded buffers, whole and truncated.

use super::file::{File, glb, reads, refusal, triangles, warnings};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use enfilade_import::{BrokenRule, Import, ImportError, ReadOptions, read, read_bytes};
use serde_json::json;
use std::path::Path;

const LEAF: [&str; 1] = ["Leaf 0,0,0 1,0,0 0,1,0"];

fn read_here(path: &Path) -> Result<Import, ImportError> {
    read(path, &ReadOptions::default())
}

/// A folder with these files in it.
fn folder(files: &[(&str, &[u8])]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder inside");
        std::fs::write(path, bytes).expect("a file");
    }
    folder
}

/// Reading `a.gltf`, whose buffer is at `uri`, with these files beside it.
fn read_with(uri: &str, beside: &[(&str, &[u8])]) -> Result<Import, ImportError> {
    let folder = folder(beside);
    let path = folder.path().join("a.gltf");
    std::fs::write(&path, File::leaf().gltf(uri)).expect("a file");
    read_here(&path)
}

#[test]
fn the_first_bytes_say_what_a_file_is_and_not_its_name() {
    let leaf = File::leaf();
    let text = leaf.gltf("leaf.bin");
    let folder = folder(&[
        ("a.glb", &leaf.glb()),
        ("b.gltf", &leaf.glb()),
        ("c", &text),
        ("d.obj", &text),
        ("leaf.bin", &leaf.bytes),
    ]);
    for name in ["a.glb", "b.gltf", "c", "d.obj"] {
        let import = read_here(&folder.path().join(name)).expect("a sound file");
        assert_eq!(triangles(&import), LEAF, "{name}");
    }
}

#[test]
fn buffers_are_found_beside_the_file() {
    let bytes = File::leaf().bytes;
    // A name in percent signs, a folder inside, and bytes after the end: all as exporters write them.
    let long = [&*bytes, b"more"].concat();
    for (uri, name, bytes) in [
        ("leaf.bin", "leaf.bin", &bytes),
        ("a%20leaf%C3%A9.bin", "a leafé.bin", &bytes),
        ("a leaf.bin", "a leaf.bin", &bytes),
        ("./parts/leaf.bin", "parts/leaf.bin", &bytes),
        ("leaf.bin", "leaf.bin", &long),
    ] {
        let import = read_with(uri, &[(name, bytes)]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(triangles(&import), LEAF, "{uri}");
    }
}

#[test]
fn buffers_may_stand_in_the_text_itself() {
    let leaf = File::leaf();
    let padded = BASE64_STANDARD.encode(&leaf.bytes);
    for head in [
        "data:application/octet-stream;base64,",
        "data:;base64,",
        "DATA:application/gltf-buffer;BASE64,",
    ] {
        let broken = padded.replace('A', "A\r\n");
        for data in [&*padded, padded.trim_end_matches('='), &*broken] {
            let import = read_bytes(
                &leaf.gltf(&format!("{head}{data}")),
                None,
                &ReadOptions::default(),
            );
            assert_eq!(triangles(&import.expect("a sound file")), LEAF, "{head}");
        }
    }
}

#[test]
fn buffers_that_cannot_be_had() {
    let leaf = File::leaf();
    for (uri, expected) in [
        (
            "https://a.org/leaf.bin",
            "buffer 0 is at `https://a.org/leaf.bin`, and nothing is fetched",
        ),
        (
            "file:///leaf.bin",
            "buffer 0 is at `file:///leaf.bin`, and nothing is fetched",
        ),
        (
            "../leaf.bin",
            "buffer 0 is `../leaf.bin`, which leads out of the file's folder",
        ),
        (
            "%2e%2e/leaf.bin",
            "buffer 0 is `%2e%2e/leaf.bin`, which leads out of the file's folder",
        ),
        (
            "/leaf.bin",
            "buffer 0 is `/leaf.bin`, which leads out of the file's folder",
        ),
        ("%ff.bin", "buffer 0 has an invalid URI: `%ff.bin` is not UTF-8"),
        (
            "data:application/octet-stream;base64",
            "buffer 0 has an invalid URI: its data URI has no comma",
        ),
        (
            "data:text/plain,leaf",
            "buffer 0 has an invalid URI: its data URI is not base64",
        ),
        (
            "data:;base64,a?b=",
            "buffer 0 has an invalid URI: its data URI is not base64",
        ),
        (
            "data:;base64,AAAA",
            "buffer 0 should have 42 bytes, but only 3 are there",
        ),
        ("gone.bin", "gone.bin`, which cannot be read: "),
        ("here", "here`, which is not a file"),
        (
            "short.bin",
            "buffer 0 should have 42 bytes, but only 10 are there; copy or export it again",
        ),
        ("a%00b.bin", "which cannot be read: "),
    ] {
        let beside: [(&str, &[u8]); 2] = [("short.bin", &leaf.bytes[..10]), ("here/leaf.bin", &leaf.bytes)];
        let said = read_with(uri, &beside)
            .expect_err("a buffer that cannot be had")
            .to_string();
        assert!(
            said.contains(expected),
            "{uri}: it says\n  {said}\nand not\n  {expected}"
        );
        assert!(said.contains("a.gltf: "), "the file is named: {said}");
    }
    let said = refusal(&leaf.gltf("leaf.bin")).expect("no folder to look in");
    assert!(
        said.contains("buffer 0 is the file `leaf.bin`, but no folder was given to look for it"),
        "{said}"
    );
}

#[test]
fn buffers_that_nothing_uses_need_not_be_there() {
    let mut leaf = File::leaf();
    leaf.json["buffers"]
        .as_array_mut()
        .expect("a list")
        .push(json!({ "byteLength": 1_u64 << 40, "uri": "gone.bin" }));
    assert_eq!(refusal(&leaf.glb()), None);
}

#[test]
fn what_is_no_file_is_not_read() {
    let folder = folder(&[]);
    let missing = read_here(&folder.path().join("gone.glb")).expect_err("nothing is there");
    assert!(
        matches!(&missing.rule, BrokenRule::Unreadable(why) if why.kind() == std::io::ErrorKind::NotFound)
    );
    assert!(
        missing.to_string().contains("gone.glb: cannot be read: "),
        "{missing}"
    );
    let said = read_here(folder.path()).expect_err("a folder").to_string();
    assert!(
        said.ends_with("is not a file, but a folder, a pipe or a device; name a file"),
        "{said}"
    );
}

#[test]
fn other_formats_are_told_what_is_read() {
    let only = "name a scene in glTF 2.0 (.glb, or .gltf with its .bin files), OBJ (.obj with its .mtl files), a compiled map \
                (.bsp: BSP29, BSP2, IBSP46), or terrain (.json with its .raw file)";
    for (bytes, begins) in [
        (
            &b""[..],
            "is neither glTF nor OBJ, nor a map of Quake, terrain or a baked scene: it is empty",
        ),
        (
            b"# a poem\nby v 0 0 0",
            "is neither glTF nor OBJ, nor a map of Quake, terrain or a baked scene: it begins with `# a poem\\nby `",
        ),
        (
            b"VBSP\x14\0\0\0",
            "is neither glTF nor OBJ, nor a map of Quake, terrain or a baked scene: it begins with `VBSP\\x14\\x00\\x00\\x00`",
        ),
        (
            b"GLTF\x02\0\0\0",
            "is neither glTF nor OBJ, nor a map of Quake, terrain or a baked scene: it begins with `GLTF\\x02\\x00\\x00\\x00`",
        ),
    ] {
        let said = refusal(bytes).expect("not glTF");
        assert!(said.contains(begins) && said.contains(only), "{said}");
    }
}

#[test]
fn a_binary_file_is_noticed_wherever_it_is_cut() {
    let whole = File::leaf().glb();
    let json_end = 20 + u32::from_le_bytes(whole[12..16].try_into().expect("four bytes")) as usize;
    for length in 4..whole.len() {
        let said =
            refusal(&whole[..length]).unwrap_or_else(|| panic!("{length} bytes are read without complaint"));
        let part = match length {
            0..12 => "header",
            _ if length < json_end => "JSON chunk",
            _ => "binary chunk",
        };
        assert!(
            said.contains(&format!("is cut short: its {part} should end at byte ")),
            "{length}: {said}"
        );
        assert!(
            said.contains(&format!("but the file has only {length};")),
            "{length}: {said}"
        );
    }
    assert_eq!(
        refusal(&[&*whole, b"trailing"].concat()),
        None,
        "what follows the end is not looked at"
    );
}

#[test]
fn headers_that_lie() {
    let whole = File::leaf().glb();
    let with = |at: usize, bytes: [u8; 4]| {
        let mut file = whole.clone();
        file[at..at + 4].copy_from_slice(&bytes);
        refusal(&file).unwrap_or_default()
    };
    for (at, bytes, expected) in [
        (4, [1, 0, 0, 0], "is glTF version 1; export it again as glTF 2.0"),
        (4, [0xff; 4], "is glTF version 4294967295"),
        (8, [0xff; 4], "should end at byte 4294967295"),
        (12, [0xff; 4], "its JSON chunk should end at byte 4294967315"),
        (16, *b"BIN\0", "its first chunk is not JSON"),
    ] {
        let said = with(at, bytes);
        assert!(said.contains(expected), "bytes at {at}: {said}");
    }
}

#[test]
fn a_binary_file_may_have_no_binary_chunk_and_chunks_of_other_kinds() {
    let leaf = File::leaf();
    let uri = format!("data:;base64,{}", BASE64_STANDARD.encode(&leaf.bytes));
    let text = String::from_utf8(leaf.gltf(&uri)).expect("text");
    let mut file = glb(&text, b"something else");
    let kind = file.len() - 16 - 4;
    file[kind..kind + 4].copy_from_slice(b"ACME");
    assert_eq!(refusal(&file), None);
    file.truncate(kind - 4);
    let length = file.len() as u32;
    file[8..12].copy_from_slice(&length.to_le_bytes());
    assert_eq!(refusal(&file), None);
}

#[test]
fn json_that_is_none() {
    let deep = |inside: &str| {
        format!(
            "{{\"asset\":{{\"version\":\"2.0\"}},{inside}{}",
            "[".repeat(1 << 20)
        )
    };
    for (text, expected) in [
        (
            "{".to_owned(),
            "its JSON cannot be read: EOF while parsing an object at line 1 column ",
        ),
        ("{}".to_owned(), "its JSON cannot be read: missing field `asset`"),
        (
            "{\"asset\": 2}".to_owned(),
            "its JSON cannot be read: asset: invalid type: integer `2`",
        ),
        (deep("\"extras\":"), "its JSON cannot be read: "),
        (deep("\"nodes\":"), "its JSON cannot be read: "),
        (deep("\"asset\":"), "its JSON cannot be read: "),
        (
            "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"scale\":[1e400,1,1]}]}".to_owned(),
            "number out of range",
        ),
        (
            "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":-1}]}".to_owned(),
            "invalid value: integer `-1`",
        ),
        (
            "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":4294967296}]}".to_owned(),
            "invalid value: integer",
        ),
    ] {
        for file in [text.clone().into_bytes(), glb(&text, b"")] {
            let said = refusal(&file).unwrap_or_else(|| panic!("{} is read", &text[..40.min(text.len())]));
            assert!(
                said.contains(expected),
                "it says\n  {said}\nand not\n  {expected}"
            );
        }
    }
    let not_text = glb("{\"asset\":{\"version\":\"\u{7f}\"}}", b"")
        .iter()
        .map(|&b| if b == 0x7f { 0xff } else { b })
        .collect::<Vec<u8>>();
    assert!(refusal(&not_text).expect("not UTF-8").contains("invalid unicode"));
}

#[test]
fn what_breaks_a_rule_but_has_a_plain_meaning_is_read_with_a_warning() {
    let plain = triangles(&reads(&File::leaf()));
    let said = |import: &Import| warnings(import).join("; ");
    let mut file = File::leaf();
    file.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    let import = reads(&file);
    assert_eq!(triangles(&import), plain);
    assert!(
        said(&import).contains("node 0 \"Leaf\" has a rotation of length zero"),
        "{}",
        said(&import)
    );

    let mut file = File::leaf();
    file.node(json!({ "name": "Tree", "children": [0, 0] }));
    let import = reads(&file);
    assert_eq!(triangles(&import), plain);
    assert!(
        said(&import).contains("node 1 \"Tree\" lists node 0 \"Leaf\" twice"),
        "{}",
        said(&import)
    );

    let mut headless = File::leaf().glb();
    headless[8..12].fill(0);
    let import = read_bytes(&headless, None, &ReadOptions::default()).expect("a header without a length");
    assert_eq!(triangles(&import), plain);
    assert!(
        said(&import).contains("the header gives a length of 0"),
        "{}",
        said(&import)
    );

    let file = File::leaf();
    let import = read_bytes(
        &glb(&format!("\u{feff}{}", file.json), &file.bytes),
        None,
        &ReadOptions::default(),
    );
    assert_eq!(triangles(&import.expect("a byte order mark")), plain);

    let import = read_bytes(
        &glb(&format!("{}\0\0\0\0", file.json), &file.bytes),
        None,
        &ReadOptions::default(),
    );
    assert_eq!(triangles(&import.expect("JSON padded with zeros")), plain);
}
