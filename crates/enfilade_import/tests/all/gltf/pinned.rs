//! Methods that are written into copies of files.

use super::file::File;
use super::rooms::{door, two_rooms};
use enfilade::Method;
use enfilade_import::{Import, PinError, ReadOptions, read, with_methods};
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

const LIMIT: u64 = 1 << 24;
/// Returns the offsets of the text files' bytes.
const BUFFER: &str = "buffer.bin";

fn written(name: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a file");
    (folder, path)
}

/// A file that was read again with methods pinned in it.
fn pinned(name: &str, file: &File, methods: &[Method]) -> (Vec<u8>, Import) {
    let is_binary = name.ends_with(".glb");
    let bytes = if is_binary { file.glb() } else { file.gltf(BUFFER) };
    let (folder, path) = written(name, &bytes);
    fs::write(folder.path().join(BUFFER), &file.bytes).expect("a file");
    let copy = with_methods(&path, methods, LIMIT).unwrap_or_else(|why| panic!("{why}"));
    let path = folder.path().join(format!("copy-of-{name}"));
    fs::write(&path, &copy).expect("a file");
    let import = read(&path, &ReadOptions::default()).unwrap_or_else(|why| panic!("{why}"));
    (copy, import)
}

fn methods(import: &Import) -> Vec<Option<Method>> {
    import.rooms.iter().map(|room| room.method).collect()
}

#[test]
fn rooms_and_what_stands_in_none_are_seen_by_the_methods_of_the_copy() {
    let stray = json!({ "name": "Lamp", "mesh": 2, "translation": [0, 9, 0] });
    let mut file = two_rooms(&[door("Door-portal", Value::Null), stray]);
    file.json["nodes"][0]["extras"] =
        json!({ "enfilade": { "kind": "room", "method": "s-buffer" }, "of": "mine" });
    let wanted = [Method::Bsp, Method::Masked, Method::ZBuffer];
    for name in ["house.glb", "house.gltf"] {
        let (copy, import) = pinned(name, &file, &wanted);
        assert_eq!(methods(&import), wanted.map(Some), "{name}");
        assert_eq!(import.portals.len(), 2, "{name}: the door is still there");
        assert_eq!(copy.starts_with(b"glTF"), name.ends_with(".glb"));
    }
}

#[test]
fn what_else_stands_in_extras_is_kept() {
    for (extras, key) in [(json!({ "of": "mine" }), "of"), (json!("mine"), "was")] {
        let mut file = two_rooms(&[]);
        file.json["nodes"][0]["extras"] = extras;
        let (copy, import) = pinned("house.gltf", &file, &[Method::Cell, Method::ZBuffer]);
        assert_eq!(methods(&import), [Some(Method::Cell), Some(Method::ZBuffer)]);
        let copy: Value = serde_json::from_slice(&copy).expect("JSON");
        assert_eq!(copy["nodes"][0]["extras"][key], "mine");
    }
}

#[test]
fn a_file_without_rooms_or_scenes_says_it_of_its_scene() {
    let mut file = File::leaf();
    for scenes in [Value::Null, json!([{ "nodes": [0], "extras": { "of": "mine" } }])] {
        if !scenes.is_null() {
            file.json["scenes"] = scenes;
        }
        let (_, import) = pinned("leaf.gltf", &file, &[Method::Svbsp]);
        assert_eq!(methods(&import), [Some(Method::Svbsp)]);
        assert_eq!(import.rooms[0].geometry.items().len(), 1);
    }
}

#[test]
fn a_method_of_a_scene_that_is_none_is_refused_with_its_place_before_any_buffer_is_looked_for() {
    let mut file = File::leaf();
    file.json["scenes"] = json!([{ "nodes": [0], "extras": { "enfilade": { "method": "magic" } } }]);
    let (_folder, path) = written("leaf.gltf", &file.gltf(BUFFER));
    let why = read(&path, &ReadOptions::default())
        .expect_err("there is no such method")
        .to_string();
    assert!(why.contains("scene 0 has the unknown method `magic`"), "{why}");
}

#[test]
fn files_that_have_no_place_for_methods_are_told() {
    let (_folder, path) = written("leaf.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let refused = with_methods(&path, &[Method::Bsp], LIMIT);
    assert!(matches!(refused, Err(PinError::NoPlace)), "{refused:?}");
    let (_folder, path) = written("cut.glb", b"glTF\x02\0\0\0");
    let refused = with_methods(&path, &[Method::Bsp], LIMIT);
    assert!(matches!(refused, Err(PinError::File(_))), "{refused:?}");
}
