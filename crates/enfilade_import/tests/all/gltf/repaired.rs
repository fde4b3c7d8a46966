//! Files that break a rule in a way whose meaning is plain: read, with a warning that names the element.

use super::file::{File, reads, refusal, refuses, warnings};
use enfilade_import::{Import, ReadOptions, read};
use serde_json::{Value, json};

/// The names of all items, sorted, with the least corner of each.
fn items(import: &Import) -> Vec<(String, [f32; 3])> {
    let geometry = &import.rooms[0].geometry;
    let indices = (0..geometry.items().len() as u32).map(enfilade::ItemIndex);
    let mut all: Vec<_> = indices
        .map(|item| (geometry.name(item).to_owned(), geometry.item(item).bounds.min))
        .collect();
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

const REPAIRED: &str = "what breaks a rule of the format, but has a plain meaning, is read";

#[test]
fn what_is_null_is_not_there() {
    let mut file = File::leaf();
    file.json["nodes"][0]["children"] = Value::Null;
    file.json["nodes"][0]["translation"] = Value::Null;
    file.json["nodes"][0]["extras"] = json!({ "anything": null });
    file.json["meshes"][0]["primitives"][0]["targets"] = Value::Null;
    file.json["materials"] =
        json!([{ "name": "glass", "alphaMode": null, "alphaCutoff": null, "extensions": null }]);
    file.json["cameras"] = Value::Null;
    let import = reads(&file);
    assert_eq!(items(&import), [("Leaf".to_owned(), [0.0; 3])]);
    assert_eq!(
        warnings(&import),
        [format!(
            "{REPAIRED} (cameras is null, materials[0] \"glass\", in alphaCutoff is null, materials[0] \"glass\", in alphaMode is \
             null, materials[0] \"glass\", in extensions is null, meshes[0], in primitives[0].targets is null, nodes[0] \"Leaf\", \
             in children is null and 1 more)"
        )]
    );
}

#[test]
fn a_null_in_a_list_and_a_wrong_type_are_refused_with_their_place() {
    let place = |list: &str, change: &dyn Fn(&mut Value), words: &[&str]| {
        let mut file = File::leaf();
        change(&mut file.json[list]);
        refuses(&file, words);
    };
    place(
        "nodes",
        &|list| list[0]["children"] = json!([null]),
        &[
            "nodes[0] \"Leaf\", in children[0]: invalid type: null",
            " at line 1 column ",
        ],
    );
    place(
        "nodes",
        &|list| list[0]["children"] = json!({ "a": 1 }),
        &["nodes[0] \"Leaf\", in children: invalid type: map"],
    );
    place(
        "nodes",
        &|list| list[0]["mesh"] = json!(-1),
        &["nodes[0] \"Leaf\", in mesh: invalid value: integer `-1`"],
    );
    place(
        "nodes",
        &|list| list[0]["scale"] = json!([1, "x", 1]),
        &["nodes[0] \"Leaf\", in scale[1]: invalid type: string \"x\""],
    );
    place(
        "nodes",
        &|list| list[0]["scale"] = json!([1, 1]),
        &["nodes[0] \"Leaf\", in scale", "invalid length 2"],
    );
    place(
        "meshes",
        &|list| list[0]["primitives"][0]["attributes"]["POSITION"] = json!("x"),
        &["meshes[0], in primitives[0].attributes.POSITION: invalid type"],
    );
    place(
        "accessors",
        &|list| {
            list[1].as_object_mut().expect("an object").remove("count");
        },
        &["accessors[1]: missing field `count`"],
    );
    place(
        "materials",
        &|list| *list = json!([{}, { "name": "red\u{7}", "alphaCutoff": [] }]),
        &["materials[1] \"red\u{fffd}\", in alphaCutoff: invalid type"],
    );
    place(
        "skins",
        &|list| *list = json!({ "a": 3 }),
        &["skins: invalid type: map"],
    );
    // Parts that are parsed later, or are not JSON.
    place(
        "nodes",
        &|list| list[0]["skin"] = json!(0),
        &["node 0 \"Leaf\" names skin 0, but there are only 0"],
    );
    let text = File::leaf().json.to_string();
    let broken = text.replace("\"count\":3", "\"count\":NaN");
    let why = refusal(broken.as_bytes()).expect("no JSON");
    assert!(
        why.contains("accessors[0], in count: expected value at line 1"),
        "{why}"
    );
    let cut = refusal(&text.as_bytes()[..text.len() / 2]).expect("no JSON");
    assert!(cut.contains("EOF while parsing"), "{cut}");
}

#[test]
fn a_scene_that_lists_a_child_takes_it_once() {
    // 0 House [1 Hall [2 Door]], 3 Shed [4 Gate].
    let with = |roots: Value| {
        let mut file = File::leaf();
        file.json["nodes"] = json!([
            { "name": "House", "children": [1], "translation": [1, 0, 0] },
            { "name": "Hall", "mesh": 0, "children": [2], "translation": [10, 0, 0] },
            { "name": "Door", "mesh": 0, "translation": [100, 0, 0] },
            { "name": "Shed", "mesh": 0, "children": [4], "translation": [0, 5, 0] },
            { "name": "Gate", "mesh": 0, "translation": [0, 50, 0] }
        ]);
        file.json["scenes"] = json!([{ "nodes": roots }]);
        file
    };
    let all = |file: &File| -> Vec<String> {
        let line = |(name, [x, y, _]): (String, [f32; 3])| format!("{name} {x} {y}");
        items(&reads(file)).into_iter().map(line).collect()
    };
    let house = ["Door 111 0", "Hall 11 0"];
    for (roots, expected) in [
        (json!([0]), &house[..]),
        (json!([0, 1]), &house),
        (json!([2, 1, 0]), &house),
        (
            json!([0, 1, 2, 3, 4]),
            &["Door 111 0", "Gate 0 55", "Hall 11 0", "Shed 0 5"],
        ),
        // Without its parent it is a root like any other.
        (json!([1]), &["Door 110 0", "Hall 10 0"]),
        (json!([2, 4]), &["Door 100 0", "Gate 0 50"]),
        (json!([1, 2]), &["Door 110 0", "Hall 10 0"]),
    ] {
        assert_eq!(all(&with(roots.clone())), expected, "{roots}");
    }
    assert_eq!(
        warnings(&reads(&with(json!([0, 1])))),
        [format!(
            "{REPAIRED} (scene 0 lists node 1 \"Hall\", a child of node 0 \"House\")"
        )]
    );
    assert_eq!(warnings(&reads(&with(json!([0])))), [""; 0]);
}

#[test]
fn joints_are_where_the_scene_puts_them_also_below_a_parent_that_it_leaves_out() {
    let mut file = File::leaf();
    let [joints, weights] = [
        file.accessor(5121, "VEC4", 3, vec![0; 12]),
        file.floats(&[1.0, 0.0, 0.0, 0.0].repeat(3), 4),
    ];
    file.carry("JOINTS_0", joints);
    file.carry("WEIGHTS_0", weights);
    file.json["nodes"][0]["skin"] = json!(0);
    file.node(json!({ "children": [2], "translation": [1000, 0, 0] }));
    file.node(json!({ "translation": [1, 0, 0] }));
    file.json["skins"] = json!([{ "joints": [2] }]);
    file.json["scenes"] = json!([{ "nodes": [0, 2] }]);
    assert_eq!(reads(&file).rooms[0].geometry.bounds().min, [1.0, 0.0, 0.0]);
}

#[test]
fn a_hundred_thousand_listed_children_are_read_at_once() {
    let many = 50_000_u32;
    let chain = (0..many).map(|number| match number + 1 {
        last if last == many => json!({ "children": (many..2 * many).collect::<Vec<_>>() }),
        next => json!({ "children": [next] }),
    });
    let mut file = File::leaf();
    file.json["nodes"] = chain.chain((0..many).map(|_| json!({}))).collect();
    let start = std::time::Instant::now();
    for roots in [
        (many..2 * many).collect::<Vec<u32>>(),
        (0..2 * many).rev().collect(),
    ] {
        file.json["scenes"] = json!([{ "nodes": roots }]);
        reads(&file);
    }
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

#[test]
fn files_that_windows_names_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir_all(folder.path().join("parts/deep")).expect("a folder");
    let file = File::leaf();
    std::fs::write(folder.path().join("parts/deep/a b.bin"), &file.bytes).expect("written");
    let path = folder.path().join("leaf.gltf");
    for uri in [
        "parts\\deep\\a b.bin",
        "parts%5Cdeep%5ca%20b.bin",
        ".\\parts/deep\\a%20b.bin",
    ] {
        let mut file = file.clone();
        file.json["images"] = json!([{ "uri": "parts\\wood.png" }]);
        std::fs::write(&path, file.gltf(uri)).expect("written");
        let import = read(&path, &ReadOptions::default()).unwrap_or_else(|why| panic!("{uri}: {why}"));
        assert_eq!(
            warnings(&import),
            [format!(
                "{REPAIRED} (buffer 0 has \\ for / in its uri, image 0 has \\ for / in its uri)"
            )],
            "{uri}"
        );
        assert_eq!(
            import.files,
            [
                folder.path().join("parts/deep/a b.bin"),
                folder.path().join("parts/wood.png")
            ]
        );
    }
    for uri in [
        "..\\a.bin",
        "parts\\..\\..\\a.bin",
        "\\\\host\\a.bin",
        "C:\\a.bin",
    ] {
        std::fs::write(&path, file.gltf(uri)).expect("written");
        let why = read(&path, &ReadOptions::default())
            .map(drop)
            .expect_err(uri)
            .to_string();
        assert!(
            why.contains("leads out of the file's folder") || why.contains("nothing is fetched"),
            "{why}"
        );
    }
    #[cfg(not(windows))]
    {
        std::fs::write(folder.path().join("odd\\name.bin"), &file.bytes).expect("written");
        std::fs::write(&path, file.gltf("odd\\name.bin")).expect("written");
        read(&path, &ReadOptions::default()).expect("the file with that name");
    }
}
