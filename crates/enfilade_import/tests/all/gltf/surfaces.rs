//! Tests materials without images: normals, vertex colors, emission, transparency.

use super::file::{File, carried, material, reads, textured_leaf, warnings};
use enfilade::{Alpha, TextureId};
use serde_json::{Value, json};

#[test]
fn normals_come_as_they_are_stored() {
    let expected = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    let mut file = File::leaf();
    let normals = file.floats(expected.as_flattened(), 3);
    file.carry("NORMAL", normals);
    assert_eq!(carried(&reads(&file), |mesh| mesh.normals()), expected);

    // As normalized bytes and shorts.
    let bytes = [[0, 0, 127, 99], [127, 0, 0, 99], [0, 0x81, 0, 99]].concat();
    let shorts = [[0, 0, 32767, 99], [32767, 0, 0, 99], [0, 0x8001, 0, 99_u16]].concat();
    let shorts = shorts.iter().flat_map(|part| part.to_le_bytes()).collect();
    for (component, bytes, stride) in [(5120, bytes, 4), (5122, shorts, 8)] {
        let mut file = File::leaf();
        let view = file.view(bytes);
        file.json["bufferViews"][view]["byteStride"] = json!(stride);
        let normals = file.push(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "type": "VEC3", "count": 3, "normalized": true
            }),
        );
        file.carry("NORMAL", normals);
        assert_eq!(
            carried(&reads(&file), |mesh| mesh.normals()),
            expected,
            "{component}"
        );
    }
}

#[test]
fn colors_of_corners_are_parts_of_one_however_they_are_stored() {
    let expected = [[1.0, 0.0, 0.2, 1.0], [0.0, 1.0, 0.0, 1.0], [0.2, 0.2, 1.0, 1.0]];
    let rgb = [1.0, 0.0, 0.2, 0.0, 1.0, 0.0, 0.2, 0.2, 1.0];
    let mut file = File::leaf();
    let colors = file.floats(&rgb, 3);
    file.carry("COLOR_0", colors);
    assert_eq!(carried(&reads(&file), |mesh| mesh.colors()), expected);

    let rgba: Vec<f32> = rgb.chunks(3).flat_map(|c| [c[0], c[1], c[2], 0.4]).collect();
    let glassy = expected.map(|[r, g, b, _]| [r, g, b, 0.4]);
    let bytes: Vec<u8> = rgba.iter().map(|part| (part * 255.0).round() as u8).collect();
    let shorts = rgba.iter().map(|part| (part * 65535.0).round() as u16);
    let shorts: Vec<u8> = shorts.flat_map(u16::to_le_bytes).collect();
    // Some exporters forget to say that they are normalized.
    for (component, normalized, bytes) in [
        (5121, true, bytes.clone()),
        (5121, false, bytes),
        (5123, true, shorts),
    ] {
        let mut file = File::leaf();
        let colors = file.accessor(component, "VEC4", 3, bytes);
        file.json["accessors"][colors]["normalized"] = json!(normalized);
        file.carry("COLOR_0", colors);
        assert_eq!(
            carried(&reads(&file), |mesh| mesh.colors()),
            glassy,
            "{component}"
        );
    }

    let mut file = File::leaf();
    let colors = file.floats(&[2.0, -1.0, 0.5, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0], 3);
    file.carry("COLOR_0", colors);
    assert_eq!(
        carried(&reads(&file), |mesh| mesh.colors())[0],
        [1.0, 0.0, 0.5, 1.0]
    );
}

#[test]
fn what_is_not_finite_is_replaced_and_said() {
    let (nan, much) = (f32::NAN, f32::INFINITY);
    let mut file = textured_leaf();
    let normals = file.floats(&[0.0, 0.0, 1.0, 0.0, nan, 1.0, 0.0, 1.0, 0.0], 3);
    let places = file.floats(&[0.25, 0.5, much, 0.0, 0.0, nan], 2);
    let colors = file.floats(&[0.5, 0.5, 0.5, 0.0, -much, 0.0, 0.25, 0.25, 0.25], 3);
    file.carry("NORMAL", normals);
    file.carry("TEXCOORD_0", places);
    file.carry("COLOR_0", colors);
    let import = reads(&file);
    assert_eq!(
        warnings(&import),
        [
            "normals that are not finite are ignored: flat shading (meshes[0].primitives[0])",
            "texture coordinates that are not finite are 0 (meshes[0].primitives[0])",
            "colors that are not finite are white (meshes[0].primitives[0])",
        ]
    );
    assert_eq!(
        carried(&import, |mesh| mesh.normals()),
        [[0.0, 0.0, 1.0], [0.0; 3], [0.0, 1.0, 0.0]]
    );
    assert_eq!(
        carried(&import, |mesh| mesh.texture()),
        [[0.25, 0.5], [0.0; 2], [0.0; 2]]
    );
    assert_eq!(
        carried(&import, |mesh| mesh.colors()),
        [[0.5, 0.5, 0.5, 1.0], [1.0; 4], [0.25, 0.25, 0.25, 1.0]]
    );
}

#[test]
fn what_only_one_part_of_a_mesh_carries_stays_with_it() {
    let mut file = File::leaf();
    let colors = file.floats(&[0.5; 9], 3);
    let mut plain = file.json["meshes"][0]["primitives"][0].clone();
    let positions = file.positions(&[[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]]);
    plain["attributes"]["POSITION"] = json!(positions);
    file.carry("COLOR_0", colors);
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut();
    primitives.expect("a list").push(plain);
    let import = reads(&file);
    let mesh = &import.rooms[0].geometry.meshes()[0];
    for (position, color) in mesh.positions().iter().zip(mesh.colors()) {
        let expected = if position[2] == 5.0 {
            [1.0; 4]
        } else {
            [0.5, 0.5, 0.5, 1.0]
        };
        assert_eq!(*color, expected, "{position:?}");
    }
    assert!(mesh.normals().is_empty());
}

fn made_of(source: Value) -> enfilade::Material {
    let mut file = File::leaf();
    file.material(source);
    material(&reads(&file))
}

#[test]
fn materials_say_what_they_send_out_and_where_they_are_cut() {
    assert_eq!(made_of(json!({})).emission, [0.0; 3]);
    let glow = json!({ "emissiveFactor": [1, 0.5, 0] });
    assert_eq!(made_of(glow).emission, [1.0, 0.5, 0.0]);
    for (strength, expected) in [
        (json!(4), [4.0, 2.0, 0.0]),
        (json!(-4), [0.0; 3]),
        (json!(1e39), [f32::MAX, f32::MAX / 2.0, 0.0]),
    ] {
        let source = json!({
            "emissiveFactor": [1, 0.5, -7],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": strength } }
        });
        assert_eq!(made_of(source).emission, expected, "{strength}");
    }
    assert!(made_of(json!({ "extensions": { "KHR_materials_unlit": {} } })).unlit);
    assert!(!made_of(json!({})).unlit);
    let cut = made_of(json!({ "alphaMode": "MASK", "alphaCutoff": 0.25 }));
    assert_eq!((cut.alpha, cut.cutoff), (Alpha::Mask, 0.25));
    assert_eq!(made_of(json!({ "alphaMode": "MASK" })).cutoff, 0.5);
    assert_eq!(
        made_of(json!({ "alphaMode": "MASK", "alphaCutoff": -3 })).cutoff,
        0.0
    );
}

#[test]
fn what_transmits_light_is_seen_through_by_as_much() {
    for (factor, coverage) in [(0.5, 0.55), (1.0, 0.1), (7.0, 0.1)] {
        let glass = made_of(json!({
            "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.5] },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": factor } }
        }));
        assert_eq!(glass.alpha, Alpha::Blend);
        assert!((glass.base_color[3] - coverage).abs() < 1e-6, "{glass:?}");
    }
}

#[test]
fn what_a_material_sends_out_may_be_an_image_where_its_color_is_one() {
    let mut file = textured_leaf();
    file.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
    file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    let import = reads(&file);
    assert_eq!(warnings(&import), [""; 0]);
    let found = material(&import);
    assert_eq!(
        (found.texture, found.emission_texture),
        (Some(TextureId(0)), Some(TextureId(0)))
    );

    // Alone it says where on it faces are.
    file.json["materials"][0]["pbrMetallicRoughness"] = json!({});
    let import = reads(&file);
    let found = material(&import);
    assert_eq!(
        (found.texture, found.emission_texture),
        (None, Some(TextureId(0)))
    );
    assert_eq!(carried(&import, |mesh| mesh.texture())[1], [1.0, 0.0]);

    // Elsewhere than the color it cannot be shown; and then all of a thing would shine whose image is mostly black.
    for elsewhere in [
        json!({ "index": 0, "texCoord": 1 }),
        json!({ "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } }),
    ] {
        let mut file = textured_leaf();
        file.json["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        file.json["materials"][0]["emissiveTexture"] = elsewhere;
        let import = reads(&file);
        assert_eq!(
            warnings(&import),
            [
                "emissive textures with other coordinates than the color texture are ignored: the material emits nothing (material 0)"
            ]
        );
        let found = material(&import);
        assert_eq!((found.emission, found.emission_texture), ([0.0; 3], None));
        assert_eq!(found.texture, Some(TextureId(0)));
    }
}
