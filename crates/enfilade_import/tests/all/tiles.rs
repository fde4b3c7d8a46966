//! Tiles of 3D Tiles: a model with tables before it, once or at many places.

use enfilade::ItemIndex;
use enfilade_import::{
    BrokenRule, Import, NonOccluder, ReadOptions, TileError, WarningKind, read, read_bytes,
};
use serde_json::{Value, json};

/// A triangle from (0, 0, 0) to (1, 0, 0) and (0, 2, 0), at z = −3.
fn model() -> Vec<u8> {
    model_of_nodes(json!([{ "name": "Leaf", "mesh": 0, "translation": [0, 0, -3] }]))
}

/// Nodes of which mesh 0 is a triangle; node 1, if there is one, is animated.
fn model_of_nodes(nodes: Value) -> Vec<u8> {
    let mut document = json!({
        "asset": { "version": "2.0" },
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36 }],
    });
    if nodes.get(1).is_some() {
        let target = json!({ "node": 1, "path": "translation" });
        let channel = json!({ "sampler": 0, "target": target });
        document["animations"] = json!([{ "channels": [channel], "samplers": [{}] }]);
    }
    document["nodes"] = nodes;
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0];
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((12 + 8 + text.len() as u32 + 8 + 36).to_le_bytes());
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(36_u32.to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(corners.iter().flat_map(|part| part.to_le_bytes()));
    bytes
}

/// A tile with these fields after its length, and these parts.
fn tile(magic: &[u8; 4], fields: &[u32], parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    let length = 12 + 4 * fields.len() + body.len();
    let mut bytes = magic.to_vec();
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend((length as u32).to_le_bytes());
    bytes.extend(fields.iter().flat_map(|field| field.to_le_bytes()));
    bytes.extend(body);
    bytes
}

fn b3dm(features: &str, model: &[u8]) -> Vec<u8> {
    let batch = br#"{"name":["a"]}  "#;
    let fields = [features.len() as u32, 0, batch.len() as u32, 0];
    tile(b"b3dm", &fields, &[features.as_bytes(), batch, model])
}

fn i3dm(features: &str, numbers: &[u8], format: u32, model: &[u8]) -> Vec<u8> {
    let fields = [features.len() as u32, numbers.len() as u32, 0, 0, format];
    tile(b"i3dm", &fields, &[features.as_bytes(), numbers, model])
}

fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

#[track_caller]
fn reads(bytes: &[u8]) -> Import {
    read_bytes(bytes, None, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn refusal(bytes: &[u8]) -> BrokenRule {
    read_bytes(bytes, None, &ReadOptions::default())
        .expect_err("refused")
        .rule
}

#[track_caller]
fn broken(bytes: &[u8]) -> TileError {
    match refusal(bytes) {
        BrokenRule::Tile(why) => *why,
        other => panic!("{other}"),
    }
}

/// The name and the three corners of each item.
fn corners(import: &Import) -> Vec<(String, [[f32; 3]; 3])> {
    let geometry = &import.rooms[0].geometry;
    let items = (0..geometry.items().len() as u32).map(ItemIndex);
    let corners = items.map(|item| {
        let mesh = geometry.mesh_of(item);
        let transform = geometry.item(item).transform();
        let corner = |nth: usize| transform.point(mesh.positions()[nth]);
        (geometry.name(item).to_owned(), [corner(0), corner(1), corner(2)])
    });
    corners.collect()
}

#[track_caller]
fn is_near(found: [[f32; 3]; 3], expected: [[f32; 3]; 3]) {
    let pairs = found.as_flattened().iter().zip(expected.as_flattened());
    assert!(
        pairs.clone().all(|(a, b)| (a - b).abs() < 2e-4),
        "{found:?} is not {expected:?}"
    );
}

const LEAF: [[f32; 3]; 3] = [[0.0, 0.0, -3.0], [1.0, 0.0, -3.0], [0.0, 2.0, -3.0]];

fn moved(by: [f32; 3]) -> [[f32; 3]; 3] {
    LEAF.map(|corner| [0, 1, 2].map(|axis| corner[axis] + by[axis]))
}

#[test]
fn a_batched_model_is_read_behind_each_of_the_three_headers() {
    let model = model();
    let batch = br#"["a", "b"]"#;
    for bytes in [
        b3dm("", &model),
        b3dm(r#"{"BATCH_LENGTH":0}"#, &model),
        // Number of batches, length of the batch table; and the same without one.
        tile(b"b3dm", &[2, batch.len() as u32], &[batch, &model]),
        tile(b"b3dm", &[0, 0], &[&model]),
        // Lengths of the batch table, number of batches.
        tile(b"b3dm", &[batch.len() as u32, 0, 2], &[batch, &model]),
        tile(b"b3dm", &[0, 0, 0], &[&model]),
    ] {
        let import = reads(&bytes);
        assert_eq!(corners(&import), [("Leaf".to_owned(), LEAF)]);
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
    }
}

#[test]
fn the_center_of_a_tile_moves_its_model_with_z_up() {
    let bytes = b3dm(r#"{"BATCH_LENGTH":0,"RTC_CENTER":[10,20,30]}"#, &model());
    let import = reads(&bytes);
    assert_eq!(
        corners(&import),
        [("Leaf".to_owned(), moved([10.0, 30.0, -20.0]))]
    );
    assert_eq!(import.rooms[0].nodes.node(ItemIndex(0)), Some(0));
}

#[test]
fn a_tile_on_the_surface_of_the_earth_is_read_relative_to_its_center() {
    let bytes = b3dm(r#"{"RTC_CENTER":[1215019.25,-4736339.5,4081627.0]}"#, &model());
    let import = reads(&bytes);
    assert_eq!(corners(&import), [("Leaf".to_owned(), LEAF)]);
    assert_eq!(import.warnings.len(), 1);
    assert_eq!(import.warnings[0].kind, WarningKind::FarOrigin);
    let said = import.warnings[0].to_string();
    assert!(said.contains("1215019.25, -4736339.5, 4081627"), "{said}");
}

#[test]
fn each_instance_of_a_model_stands_at_its_position() {
    let positions = floats(&[1.0, 2.0, 3.0, -4.0, 5.0, 6.0]);
    for features in [
        r#"{"INSTANCES_LENGTH":2,"POSITION":{"byteOffset":0}}"#,
        r#"{"INSTANCES_LENGTH":2,"POSITION":[1,2,3,-4,5,6]}"#,
        r#"{"INSTANCES_LENGTH":2,"RTC_CENTER":[1,1,1],"POSITION":[0,1,2,-5,4,5],"SCALE":[1,1]}"#,
    ] {
        let import = reads(&i3dm(features, &positions, 1, &model()));
        let found = corners(&import);
        let names: Vec<&str> = found.iter().map(|(name, _)| &**name).collect();
        assert_eq!(names, ["Leaf[0]", "Leaf[1]"]);
        is_near(found[0].1, moved([1.0, 3.0, -2.0]));
        is_near(found[1].1, moved([-4.0, 6.0, -5.0]));
        assert_eq!(import.rooms[0].geometry.meshes().len(), 1);
    }
}

#[test]
fn a_list_of_tiles_is_no_scene_of_old_gltf() {
    for version in ["1.0", "1.1"] {
        let tileset = json!({ "asset": { "version": version }, "geometricError": 5, "root": {} });
        let why = read_bytes(tileset.to_string().as_bytes(), None, &ReadOptions::default());
        let why = why.map(drop).expect_err("a refusal").to_string();
        assert!(
            why.contains("a tileset of 3D Tiles") && why.contains(".b3dm"),
            "{why}"
        );
    }
}

#[test]
fn instances_of_a_model_that_hides_nothing_hide_nothing_for_the_same_reason() {
    let nodes = json!([{ "name": "wall", "mesh": 0 }, { "name": "fern", "mesh": 0 }]);
    let glb = model_of_nodes(nodes);
    let positions = floats(&[1.0, 2.0, 3.0, -4.0, 5.0, 6.0]);
    let import = reads(&i3dm(
        r#"{"INSTANCES_LENGTH":2,"POSITION":{"byteOffset":0}}"#,
        &positions,
        1,
        &glb,
    ));
    let room = &import.rooms[0];
    let items = (0..room.geometry.items().len() as u32).map(ItemIndex);
    let why = items.map(|item| {
        let reasons = room.non_occluders.of_item(&room.geometry, item);
        (room.geometry.name(item), reasons.into_iter().collect::<Vec<_>>())
    });
    let animated = vec![NonOccluder::Animated];
    let expected = [
        ("wall[0]", vec![]),
        ("wall[1]", vec![]),
        ("fern[0]", animated.clone()),
        ("fern[1]", animated),
    ];
    assert_eq!(why.collect::<Vec<_>>(), expected);
}

#[test]
fn quantized_positions_are_those_of_their_volume() {
    let features = r#"{"INSTANCES_LENGTH":2,"POSITION_QUANTIZED":{"byteOffset":0},
        "QUANTIZED_VOLUME_OFFSET":[1,2,3],"QUANTIZED_VOLUME_SCALE":[10,20,30]}"#;
    let numbers: Vec<u8> = [0_u16, 0, 0, u16::MAX, u16::MAX, 0]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let found = corners(&reads(&i3dm(features, &numbers, 1, &model())));
    is_near(found[0].1, moved([1.0, 3.0, -2.0]));
    is_near(found[1].1, moved([11.0, 3.0, -22.0]));
}

#[test]
fn instances_are_turned_and_scaled() {
    // Up is x of the tile, right its y: the model's x, y and z (right, back, up of the tile) go there.
    let directions = floats(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let turned = r#"{"INSTANCES_LENGTH":1,"POSITION":[0,0,0],"NORMAL_UP":{"byteOffset":0},"NORMAL_RIGHT":{"byteOffset":12},
        "SCALE":[2],"SCALE_NON_UNIFORM":[1,1,0.5]}"#;
    let found = corners(&reads(&i3dm(turned, &directions, 1, &model())));
    // In the tile the corners are (0, 3, 0), (1, 3, 0), (0, 3, 2); scaled (0, 6, 0), (2, 6, 0), (0, 6, 2); turned, x to y,
    // y to x and z to −z: (6, 0, 0), (6, 2, 0), (6, 0, −2).
    is_near(found[0].1, [[6.0, 0.0, 0.0], [6.0, 0.0, -2.0], [6.0, -2.0, 0.0]]);
    // The same directions as points of an octahedron.
    let octahedron: Vec<u8> = [65535_u16, 32768, 32768, 65535]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let same = turned
        .replace("NORMAL_UP", "NORMAL_UP_OCT32P")
        .replace("NORMAL_RIGHT", "NORMAL_RIGHT_OCT32P")
        .replace("12", "4");
    let again = corners(&reads(&i3dm(&same, &octahedron, 1, &model())));
    is_near(again[0].1, found[0].1);
}

#[test]
fn instances_on_the_globe_face_east_and_north() {
    // On the equator at 0° E: east is y, north is z, up is x.
    let features = r#"{"INSTANCES_LENGTH":2,"POSITION":[6378137,0,0,6378137,100,0],"EAST_NORTH_UP":true}"#;
    let import = reads(&i3dm(features, &[], 1, &model()));
    let found = corners(&import);
    // In the tile (0, 3, 0), (1, 3, 0), (0, 3, 2): east, north and up of the place are y, z and x of the globe.
    is_near(found[0].1, [[0.0, 3.0, 0.0], [0.0, 3.0, -1.0], [2.0, 3.0, 0.0]]);
    assert!((found[1].1[0][2] + 100.0).abs() < 0.01, "{found:?}");
    assert_eq!(import.warnings[0].kind, WarningKind::FarOrigin);
}

#[test]
fn a_model_in_another_file_is_read_from_there() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("tree.glb"), model()).expect("written");
    let features = r#"{"INSTANCES_LENGTH":1,"POSITION":[1,2,3]}"#;
    let bytes = i3dm(features, &[], 0, b"tree.glb  ");
    let path = folder.path().join("a.i3dm");
    std::fs::write(&path, &bytes).expect("written");
    let import = read(&path, &ReadOptions::default()).expect("two files");
    is_near(corners(&import)[0].1, moved([1.0, 3.0, -2.0]));
    assert_eq!(import.files, [folder.path().join("tree.glb")]);
    assert!(matches!(refusal(&bytes), BrokenRule::NoFolder { .. }));
    for (uri, said) in [
        (&b"../tree.glb"[..], "leads out"),
        (b"http://a.b/tree.glb", "nothing is fetched"),
        (b"oak.glb", "no such file"),
    ] {
        std::fs::write(&path, i3dm(features, &[], 0, uri)).expect("written");
        let error = read(&path, &ReadOptions::default())
            .expect_err("refused")
            .to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_tile_without_instances_is_empty() {
    let import = reads(&i3dm(r#"{"INSTANCES_LENGTH":0,"POSITION":[]}"#, &[], 1, &model()));
    assert_eq!(corners(&import), []);
}

#[test]
fn damaged_tiles_are_refused_with_the_rule() {
    let model = model();
    let one = |features: &str| i3dm(features, &floats(&[0.0; 3]), 1, &model);
    let says = |bytes: &[u8], word: &str| {
        let said = broken(bytes).to_string();
        assert!(said.contains(word), "{said}");
    };
    let mut future = b3dm("", &model);
    future[4] = 2;
    says(&future, "version 2");
    says(&b3dm("{", &model), "cannot be read");
    says(
        &b3dm(r#"{"RTC_CENTER":[1,2]}"#, &model),
        "2 numbers as RTC_CENTER",
    );
    says(&b3dm(r#"{"RTC_CENTER":{"byteOffset":0}}"#, &model), "RTC_CENTER");
    says(&b3dm("", b""), "no model");
    says(&one("{}"), "no INSTANCES_LENGTH");
    says(&one(r#"{"INSTANCES_LENGTH":1}"#), "no POSITION");
    says(
        &one(r#"{"INSTANCES_LENGTH":1.5,"POSITION":[0,0,0]}"#),
        "no number of instances",
    );
    says(
        &one(r#"{"INSTANCES_LENGTH":4294967295,"POSITION":{"byteOffset":0}}"#),
        "4294967295 instances",
    );
    says(
        &one(r#"{"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":18446744073709551615}}"#),
        "has 0 bytes",
    );
    says(
        &one(r#"{"INSTANCES_LENGTH":1,"POSITION":[0,0,0],"NORMAL_UP":[0,0,1]}"#),
        "no NORMAL_RIGHT",
    );
    says(
        &one(r#"{"INSTANCES_LENGTH":1,"POSITION":[0,0,0],"NORMAL_UP":[0,0,1],"NORMAL_RIGHT":[0,0,-1]}"#),
        "parallel",
    );
    says(
        &one(r#"{"INSTANCES_LENGTH":1,"POSITION_QUANTIZED":{"byteOffset":0}}"#),
        "no QUANTIZED_VOLUME_OFFSET",
    );
    says(&i3dm("", &[], 7, &model), "gltfFormat 7");
    let not_finite = i3dm(
        r#"{"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0}}"#,
        &floats(&[f32::NAN; 3]),
        1,
        &model,
    );
    says(&not_finite, "instance 0");
    assert!(matches!(refusal(&b3dm("", b"glTB")), BrokenRule::NotGltf { .. }));
}

#[test]
fn tiles_that_are_cut_short_anywhere_are_refused() {
    let features = r#"{"INSTANCES_LENGTH":1,"POSITION":{"byteOffset":0}}"#;
    for whole in [
        b3dm(r#"{"RTC_CENTER":[1,2,3]}"#, &model()),
        i3dm(features, &floats(&[0.0; 3]), 1, &model()),
    ] {
        for end in 0..whole.len() {
            let error = read_bytes(&whole[..end], None, &ReadOptions::default());
            assert!(error.is_err(), "{end} of {} bytes", whole.len());
        }
        let longer = [&*whole, b"more"].concat();
        assert_eq!(corners(&reads(&longer)).len(), 1);
    }
}

#[test]
fn a_small_tile_of_a_million_instances_is_refused_if_memory_is_short() {
    let count = 1_000_000;
    let features = format!("{{\"INSTANCES_LENGTH\":{count},\"POSITION\":{{\"byteOffset\":0}}}}");
    let bytes = i3dm(&features, &vec![0; 12 * count], 1, &model());
    let options = ReadOptions {
        limit_bytes: 200 << 20,
        ..ReadOptions::default()
    };
    let error = read_bytes(&bytes, None, &options).expect_err("too large");
    assert!(matches!(error.rule, BrokenRule::TooLarge { .. }), "{error}");
}
