//! Joining files: what else is in them goes over whole, and nothing in them does harm.

use super::file::{File, textured_leaf};
use super::rooms::{door, two_rooms, ways};
use enfilade_import::{Linked, Linker, Placing, ReadOptions, Shape};
use serde_json::{Value, json};

/// Links files that are parts a, b, c … each ten units from the one before.
fn linked(files: &[&File], join: impl FnOnce(&mut Linker, &[enfilade_import::PartId])) -> Linked {
    let folder = tempfile::tempdir().expect("a folder");
    let mut linker = Linker::new(ReadOptions::default());
    let mut parts = Vec::new();
    for (number, file) in files.iter().enumerate() {
        let path = folder.path().join(format!("{number}.glb"));
        std::fs::write(&path, file.glb()).expect("written");
        let placing = Placing {
            translation: [10.0 * number as f64, 0.0, 0.0],
            ..Placing::default()
        };
        let name = char::from(b'a' + number as u8).to_string();
        parts.push(
            linker
                .part(&name, &path, &placing)
                .unwrap_or_else(|error| panic!("{error}")),
        );
    }
    join(&mut linker, &parts);
    linker.finish().unwrap_or_else(|error| panic!("{error}"))
}

fn document(glb: &[u8]) -> Value {
    let end = 20 + u32::from_le_bytes(glb[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&glb[20..end]).expect("JSON")
}

#[test]
fn parts_keep_their_rooms_and_portals_under_names_of_their_own() {
    let file = two_rooms(&[door("Door-portal", json!({ "to": "B-room", "one_way": 1 }))]);
    let made = linked(&[&file, &file], |linker, parts| {
        let gate = |ahead: [f64; 3]| Shape::Rectangle {
            center: [-1.0, 0.0, 0.0],
            ahead,
            up: None,
            size: Some([1.0, 1.0]),
        };
        let opening = linker
            .shape(parts[0], "gate", &gate([0.0, 0.0, -1.0]))
            .expect("a rectangle");
        let exit = linker
            .shape(parts[1], "out", &gate([0.0, 1.0, 0.0]))
            .expect("a rectangle");
        linker
            .teleport(opening, exit, (parts[1], Some("A-room")))
            .expect("the room is there");
    });
    assert_eq!(
        ways(&made.import),
        [
            "a/Door-portal: a/A-room -> a/B-room",
            "b/Door-portal: b/A-room -> b/B-room",
            "gate: a/A-room -> b/A-room",
        ]
    );
    // In along -z at (-1, 0, 0), out along +y at (9, 0, 0).
    let out = made.import.portals[2].there_from_here.point([-1.0, 0.0, -0.5]);
    assert!(
        (0..3).all(|axis| (out[axis] - [9.0, 0.5, 0.0][axis]).abs() < 1e-5),
        "{out:?}"
    );
}

#[test]
fn every_number_that_names_something_still_names_it() {
    let mut file = File::leaf();
    let pixels = file.view(b"\x89PNG, more or less".to_vec());
    file.json["images"] = json!([{ "bufferView": pixels, "mimeType": "image/png" }]);
    file.json["samplers"] = json!([{}]);
    file.json["textures"] = json!([{ "source": 0, "sampler": 0 }]);
    file.json["materials"] = json!([{
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_clearcoat": { "clearcoatTexture": { "index": 0 } }, "EXT_odd": { "mesh": 0 } }
    }]);
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "EXT_odd", "KHR_lights_punctual"]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    file.json["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    file.json["skins"] = json!([{ "joints": [0], "skeleton": 0 }]);
    file.json["animations"] = json!([{
        "samplers": [{ "input": 0, "output": 1 }], "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }]
    }]);
    let made = linked(&[&file, &file], |_, _| ());
    let world = document(&made.glb);
    let second = &world["nodes"][2];
    assert_eq!(second["name"], "b/Leaf");
    assert_eq!(second["extensions"]["KHR_lights_punctual"]["light"], 1);
    let primitive = &world["meshes"][second["mesh"].as_u64().expect("a number") as usize]["primitives"][0];
    assert_eq!(primitive["material"], 1);
    assert_eq!(primitive["attributes"]["POSITION"], 2);
    let material = &world["materials"][1];
    assert_eq!(material["pbrMetallicRoughness"]["baseColorTexture"]["index"], 1);
    assert_eq!(
        material["extensions"],
        json!({ "KHR_materials_clearcoat": { "clearcoatTexture": { "index": 1 } } })
    );
    assert_eq!(world["textures"][1], json!({ "source": 1, "sampler": 1 }));
    let view = world["images"][1]["bufferView"].as_u64().expect("a number") as usize;
    assert_eq!(world["bufferViews"][view]["byteLength"], 18);
    assert_eq!(world["skins"][1], json!({ "joints": [2], "skeleton": 2 }));
    assert_eq!(world["animations"][1]["channels"][0]["target"]["node"], 2);
    assert_eq!(
        world["animations"][1]["samplers"][0],
        json!({ "input": 2, "output": 3 })
    );
    assert_eq!(made.left_out, ["EXT_odd"]);
    assert_eq!(
        world["extensionsUsed"],
        json!(["KHR_lights_punctual", "KHR_materials_clearcoat"])
    );
}

#[test]
fn what_nobody_reads_may_be_anything() {
    let mut file = File::leaf();
    for (key, value) in [
        ("extensions", json!(5)),
        ("textures", json!([3, "x", null])),
        ("samplers", json!({ "a": 1 })),
        ("images", json!([7])),
        ("skins", json!([[1]])),
        ("animations", json!([{ "samplers": 4, "channels": [2] }])),
    ] {
        file.json[key] = value;
    }
    file.json["nodes"][0]["extras"] = json!([1, 2]);
    assert_eq!(linked(&[&file], |_, _| ()).import.rooms[0].name, "a-room");
}

#[test]
fn textures_lights_and_instances_go_over() {
    let mut file = textured_leaf();
    let places = file.floats(&[0.0, 0.0, 0.0, 0.0, 2.0, 0.0], 3);
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    file.json["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "point", "range": 3 }] } });
    file.node(
        json!({ "translation": [0.2, 0.2, 0], "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
    );
    file.json["extensionsUsed"] = json!([
        "EXT_mesh_gpu_instancing",
        "KHR_lights_punctual",
        "KHR_mesh_quantization"
    ]);
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing", "KHR_mesh_quantization"]);
    let mut other = file.clone();
    other.json["extensions"]["KHR_lights_punctual"]["lights"][0]["range"] = json!(5);
    let made = linked(&[&file, &other], |_, _| ());
    assert_eq!((made.left_out.len(), made.missing_images.len()), (0, 0));
    let import = &made.import;
    assert!(import.warnings.is_empty(), "{:?}", import.warnings);
    let lights: Vec<_> = import
        .lights
        .iter()
        .map(|light| (light.sector.0, light.range))
        .collect();
    assert_eq!(lights, [(0, 3.0), (1, 5.0)]);
    assert_eq!(import.lights[1].position, [10.2, 0.2, 0.0]);
    for room in &import.rooms {
        assert_eq!(room.geometry.items().len(), 2);
        assert_eq!(room.geometry.textures().len(), 2);
        assert!(
            room.geometry
                .textures()
                .iter()
                .all(|texture| texture.size() == [2, 2])
        );
        let bounds = room.geometry.bounds();
        assert_eq!(bounds.max[1] - bounds.min[1], 3.0);
    }
    let required = &document(&made.glb)["extensionsRequired"];
    assert_eq!(
        *required,
        json!(["EXT_mesh_gpu_instancing", "KHR_mesh_quantization"])
    );
}

#[test]
fn images_that_cannot_be_had_are_grey_in_the_world_and_named() {
    let mut file = textured_leaf();
    file.json["images"] = json!([{ "uri": "nowhere.png", "name": "Wall" }]);
    let made = linked(&[&file], |_, _| ());
    let [missing] = &made.missing_images[..] else {
        panic!("{:?}", made.missing_images)
    };
    assert!(missing.starts_with("a: image 0 is the file `"), "{missing}");
    assert!(made.import.warnings.is_empty());
    let texture = &made.import.rooms[0].geometry.textures()[0];
    assert_eq!(
        (texture.texels(), &*texture.name),
        (&[[128, 128, 128, 255]][..], "Wall")
    );
}

#[test]
fn what_is_compressed_is_plain_in_the_world() {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes);
    let mut file = File::leaf();
    let encoded = file.view(super::meshopt::vertices(corners.as_flattened(), 12));
    let source = file.json["bufferViews"][encoded].clone();
    // The fallback buffer has no bytes.
    file.push(
        "buffers",
        json!({ "byteLength": 36, "extensions": { "EXT_meshopt_compression": { "fallback": true } } }),
    );
    file.json["bufferViews"][0] = json!({ "buffer": 1, "byteLength": 36, "extensions": { "EXT_meshopt_compression": {
        "buffer": 0, "byteOffset": source["byteOffset"], "byteLength": source["byteLength"],
        "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"
    } } });
    file.json["extensionsUsed"] = json!(["EXT_meshopt_compression"]);
    file.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let made = linked(&[&file, &file], |_, _| ());
    assert!(made.left_out.is_empty(), "{:?}", made.left_out);
    let world = document(&made.glb);
    assert!(world["extensionsUsed"].is_null() && !world.to_string().contains("meshopt"));
    assert_eq!(world["buffers"].as_array().expect("a list").len(), 1);
    for (number, room) in made.import.rooms.iter().enumerate() {
        assert_eq!(room.geometry.bounds().max, [1.0 + 10.0 * number as f32, 1.0, 0.0]);
    }
}
