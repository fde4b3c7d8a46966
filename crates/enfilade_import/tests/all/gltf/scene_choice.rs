//! Files with several scenes: the default one is read, or one by name or index.

use super::file::{File, warnings};
use enfilade::ItemIndex;
use enfilade_import::{Import, ImportError, Linker, Placing, ReadOptions, read_bytes};
use serde_json::json;

/// Four scenes: Day, the default Night, 0, and one without a name.
fn file() -> File {
    let mut file = File::leaf();
    for name in ["moon", "owl", "odd"] {
        file.node(json!({ "name": name, "mesh": 0 }));
    }
    file.json["scenes"] = json!([
        { "name": "Day", "nodes": [0] },
        { "name": "Night", "nodes": [1, 2] },
        { "name": "0", "nodes": [2] },
        { "nodes": [3] }
    ]);
    file.json["scene"] = json!(1);
    file
}

fn read(file: &File, scene: Option<&str>) -> Result<Import, ImportError> {
    let options = ReadOptions {
        scene: scene.map(str::to_owned),
        ..ReadOptions::default()
    };
    read_bytes(&file.glb(), None, &options)
}

fn items(import: &Import) -> Vec<&str> {
    let geometry = &import.rooms[0].geometry;
    let all = (0..geometry.items().len() as u32).map(ItemIndex);
    all.map(|item| geometry.name(item)).collect()
}

#[test]
fn a_scene_is_read_by_its_name_or_else_by_its_index() {
    for (scene, expected, read_index) in [
        (None, &["moon", "owl"][..], 1),
        (Some("Day"), &["Leaf"], 0),
        (Some("1"), &["moon", "owl"], 1),
        (Some("0"), &["owl"], 2),
        (Some("3"), &["odd"], 3),
    ] {
        let import = read(&file(), scene).unwrap_or_else(|why| panic!("{why}"));
        assert_eq!(items(&import), expected, "{scene:?}");
        let scenes: Vec<(&str, bool, bool)> = import
            .scenes
            .iter()
            .map(|scene| (&*scene.name, scene.is_default, scene.is_read))
            .collect();
        let expected: Vec<(&str, bool, bool)> = ["Day", "Night", "0", ""]
            .iter()
            .enumerate()
            .map(|(number, name)| (*name, number == 1, number == read_index))
            .collect();
        assert_eq!(scenes, expected, "{scene:?}");
        assert_eq!(warnings(&import), ["only one scene is read, others are not (3)"]);
    }
}

#[test]
fn a_scene_that_is_not_there_is_an_error_that_lists_what_is() {
    for scene in ["Noon", "4", "", "-1", "day"] {
        let why = read(&file(), Some(scene)).map(drop).expect_err(scene).to_string();
        let list = "its scenes are 0 \"Day\", 1 \"Night\", 2 \"0\", 3";
        assert!(why.contains(&format!("no scene `{scene}`; {list}")), "{why}");
    }
    let why = read(&File::leaf(), Some("0"))
        .map(drop)
        .expect_err("none")
        .to_string();
    assert!(why.contains("no scene `0`; it lists none"), "{why}");
    let mut twice = file();
    twice.json["scenes"][3]["name"] = json!("Day");
    let why = read(&twice, Some("Day")).map(drop).expect_err("two").to_string();
    assert!(
        why.contains("several scenes with the name `Day`, at the indices 0, 3"),
        "{why}"
    );
    assert_eq!(items(&read(&twice, Some("3")).expect("by its index")), ["odd"]);
}

#[test]
fn formats_without_scenes_say_so() {
    let options = ReadOptions {
        scene: Some("Day".to_owned()),
        ..ReadOptions::default()
    };
    let why = read_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", None, &options);
    let why = why.map(drop).expect_err("OBJ").to_string();
    assert!(
        why.contains("has no scenes to choose from") && why.contains("--scene"),
        "{why}"
    );
}

#[test]
fn the_parts_of_a_world_are_the_scenes_that_are_chosen() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    let mut with_children = file();
    // Scene 0 lists a child of a node that it leaves out.
    with_children.node(json!({ "children": [0] }));
    std::fs::write(&path, with_children.glb()).expect("written");
    let mut linker = Linker::new(ReadOptions {
        scene: Some("Day".to_owned()),
        ..ReadOptions::default()
    });
    linker.part("a", &path, &Placing::default()).expect("a part");
    assert_eq!(items(&linker.finish().expect("a world").import), ["a/Leaf"]);
}
