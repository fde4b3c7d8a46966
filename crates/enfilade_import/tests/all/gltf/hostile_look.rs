//! Textures, lights and what corners carry, made to do harm: read with a warning or refused, never worse.

use super::file::{File, carried, reads, refusal, textured_leaf, warnings};
use super::hostile::{each_is_read_or_refused, numbers, read_with_each_number_replaced};
use enfilade_import::{ReadOptions, read_bytes};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

/// Changes of a material, with the expected messages.
type Case<'a> = (&'a str, &'a dyn Fn(&mut Value), &'a str);

#[test]
fn numbers_that_name_no_texture_sampler_or_image_are_refused() {
    let cases: [Case; 9] = [
        (
            "a texture",
            &|j| j["textures"] = json!([]),
            "material 0 names texture 0, but there are only 0",
        ),
        (
            "a sampler",
            &|j| j["textures"][0]["sampler"] = json!(3),
            "texture 0 names sampler 3, but there are only 0",
        ),
        (
            "an image",
            &|j| j["textures"][0]["source"] = json!(4_294_967_295_u32),
            "texture 0 names image 4294967295, but there are only 1",
        ),
        (
            "a view",
            &|j| j["images"][0]["bufferView"] = json!(70),
            "image 0 names bufferView 70, but there are only 4",
        ),
        (
            "a view that is too long",
            &|j| j["bufferViews"][2]["byteLength"] = json!(1_u64 << 40),
            "bufferView 2 ends at byte 10995116",
        ),
        (
            "a way to wrap",
            &|j| {
                j["samplers"] = json!([{ "wrapT": 5 }]);
                j["textures"][0]["sampler"] = json!(0);
            },
            "sampler 0 has wrapT 5, which glTF does not define; export it again",
        ),
        (
            "a filter",
            &|j| {
                j["samplers"] = json!([{ "minFilter": 9728, "magFilter": 9987 }]);
                j["textures"][0]["sampler"] = json!(0);
            },
            "sampler 0 has magFilter 9987",
        ),
        (
            "textures that are none",
            &|j| j["textures"] = json!("none"),
            "its JSON cannot be read: textures: invalid type: string \"none\"",
        ),
        (
            "a number below zero",
            &|j| j["textures"][0]["source"] = json!(-1),
            "its JSON cannot be read: textures[0], in source: invalid value",
        ),
    ];
    for (what, change, expected) in cases {
        let mut file = textured_leaf();
        change(&mut file.json);
        let said = refusal(&file.glb()).unwrap_or_else(|| panic!("{what} is read without complaint"));
        assert!(
            said.contains(expected),
            "{what}: it says\n  {said}\nand not\n  {expected}"
        );
        // Without textures, samplers are not checked.
        let options = ReadOptions {
            textures: false,
            ..ReadOptions::default()
        };
        assert!(read_bytes(&file.glb(), None, &options).is_ok(), "{what}");
    }
}

#[test]
fn a_texture_without_coordinates_has_the_color_of_its_corner() {
    for set in [1_u32, 7, u32::MAX] {
        let mut file = textured_leaf();
        file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = json!(set);
        let import = reads(&file);
        assert!(carried(&import, |mesh| mesh.texture()).is_empty());
        assert_eq!(
            warnings(&import),
            [format!(
                "textured faces without texture coordinates have the color of the texture's corner \
                 (meshes[0].primitives[0] has no TEXCOORD_{set})"
            )]
        );
    }
}

#[test]
fn coordinates_that_a_transform_drives_to_infinity_are_zero() {
    let mut file = textured_leaf();
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({ "KHR_texture_transform": { "scale": [1e308, 1], "rotation": 1e300, "offset": [0, 1e39] } });
    let import = reads(&file);
    assert_eq!(carried(&import, |mesh| mesh.texture()), [[0.0; 2]; 3]);
    assert_eq!(
        warnings(&import),
        ["texture coordinates that are not finite are 0 (meshes[0].primitives[0])"]
    );
}

#[test]
fn ten_thousand_textures_of_ten_thousand_materials_are_settled_fast() {
    const MANY: usize = 10_000;
    let mut file = textured_leaf();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let named = |n: usize| json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": n } } });
    let of_part = |n: usize| {
        let mut primitive = primitive.clone();
        primitive["material"] = json!(n);
        primitive
    };
    file.json["materials"] = (0..MANY).map(named).collect();
    file.json["textures"] = (0..MANY).map(|n| json!({ "source": n })).collect();
    file.json["images"] = json!(vec![json!({ "bufferView": 2 }); MANY]);
    file.json["meshes"][0]["primitives"] = (0..MANY).map(of_part).collect();
    let start = Instant::now();
    let import = reads(&file);
    assert_eq!(import.rooms[0].geometry.textures().len(), MANY);
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

/// A leaf with everything: a texture, normals, colors, a light, an orthographic camera, instances, sparse elements.
fn tree() -> File {
    let mut file = textured_leaf();
    let normals = file.floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0], 3);
    file.carry("NORMAL", normals);
    let colors = file.accessor(5121, "VEC4", 3, vec![200; 12]);
    file.json["accessors"][colors]["normalized"] = json!(true);
    file.carry("COLOR_0", colors);
    let places = file.floats(&[5.0, 0.0, 0.0, 0.0, 7.0, 0.0], 3);
    let numbers = file.view(vec![0, 2]);
    let values = file.view(vec![0; 24]);
    file.json["accessors"][normals]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": numbers, "componentType": 5121 },
        "values": { "bufferView": values }
    });
    file.json["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "range": 9, "spot": { "innerConeAngle": 0.1 } }
    ] } });
    file.node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } }, "camera": 0 }));
    file.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 9 } }),
    );
    file.json["samplers"] = json!([{ "wrapS": 33071, "minFilter": 9987 }]);
    file.json["textures"][0]["sampler"] = json!(0);
    file.json["materials"][0]["emissiveFactor"] = json!([1, 1, 0]);
    file.json["materials"][0]["emissiveTexture"] = json!({ "index": 0, "texCoord": 0 });
    file.json["materials"][0]["extensions"] = json!({
        "KHR_materials_emissive_strength": { "emissiveStrength": 2 },
        "KHR_materials_transmission": { "transmissionFactor": 0.5 }
    });
    file
}

#[test]
fn a_textured_file_with_a_few_bytes_wrong_is_read_or_refused() {
    assert_eq!(warnings(&reads(&tree())), [""; 0]);
    let whole = tree().glb();
    let json_end = 20 + u32::from_le_bytes(whole[12..16].try_into().expect("four bytes")) as usize;
    let mut number = numbers(20_261_122);
    each_is_read_or_refused((0..20_000).map(|_| {
        let mut file = whole.clone();
        for _ in 0..=number(3) {
            match number(4) {
                // Digits for digits, so that much of it is still JSON and only the numbers are wrong.
                0 | 1 => {
                    let at = 20 + number(json_end - 20);
                    if file[at].is_ascii_digit() {
                        file[at] = b'0' + number(10) as u8;
                    }
                }
                2 => {
                    let at = json_end + number(file.len() - json_end);
                    file[at] = number(256) as u8;
                }
                _ => {
                    let at = number(file.len());
                    file[at] ^= 1 << number(8);
                }
            }
        }
        file
    }));
}

#[test]
fn a_textured_file_with_a_number_replaced_by_a_bad_one_is_read_or_refused() {
    read_with_each_number_replaced(&tree());
}
