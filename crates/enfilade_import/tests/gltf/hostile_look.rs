//! Textures, lights and what corners carry, made to do harm: read with a warning or refused, never worse.

use crate::file::{File, carried, glb, material, png, reads, refusal, textured_leaf, warnings};
use enfilade_import::{Import, ReadOptions, read, read_bytes};
use serde_json::{Value, json};
use std::fs;
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

/// What is changed, and what is said then.
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
            "sampler 0 has wrapT 5, which glTF does not know; export it again",
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
            "its JSON cannot be read: textures: invalid value",
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
        // Who draws nothing need not care.
        let options = ReadOptions {
            textures: false,
            ..ReadOptions::default()
        };
        assert!(read_bytes(&file.glb(), None, &options).is_ok(), "{what}");
    }
}

/// A textured leaf with another image is read, its texture is grey, and this is the end of the warning.
#[track_caller]
fn is_grey(import: &Import, why: &str) {
    let texture = material(import).texture.expect("a texture").0 as usize;
    assert_eq!(
        import.rooms[0].content.textures()[texture].texels(),
        [[128, 128, 128, 255]]
    );
    let said = warnings(import);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("images cannot be read, and are grey (") && said[0].contains(why),
        "it says\n  {}\nand not\n  {why}",
        said[0]
    );
}

#[test]
fn images_that_cannot_be_had_are_grey_and_say_why() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    fs::create_dir_all(inner.join("folder.png")).expect("a folder");
    fs::write(folder.path().join("secret.png"), png([1, 1], |_, _| [1; 4])).expect("written");
    fs::write(inner.join("words.png"), "no image").expect("written");
    let path = inner.join("leaf.glb");
    for (image, why) in [
        (
            json!({ "uri": "../secret.png" }),
            "image 0 is `../secret.png`, which leads out of the file's folder",
        ),
        (
            json!({ "uri": "%2e%2e/secret.png" }),
            "which leads out of the file's folder",
        ),
        (
            json!({ "uri": "/etc/passwd" }),
            "which leads out of the file's folder",
        ),
        (
            json!({ "uri": "https://example.org/a.png" }),
            "image 0 lies at `https://example.org/a.png`; nothing is fetched",
        ),
        (
            json!({ "uri": "nowhere.png", "name": "Wall" }),
            "image 0 \"Wall\" is the file `",
        ),
        (json!({ "uri": "folder.png" }), "is not a file"),
        (json!({ "uri": "words.png" }), "image 0: neither PNG nor JPEG"),
        (
            json!({ "uri": "data:image/png;base64,!!!" }),
            "image 0 has a bad address: its data URI is not base64",
        ),
        (
            json!({ "uri": "data:image/png;base64" }),
            "its data URI has no comma",
        ),
        (json!({ "uri": "data:;base64," }), "image 0: neither PNG nor JPEG"),
        (json!({ "uri": "%ff.png" }), "is not UTF-8"),
        (json!({}), "image 0: it has neither an address nor a bufferView"),
        // Positions are no image.
        (json!({ "bufferView": 0 }), "image 0: neither PNG nor JPEG"),
    ] {
        let mut file = textured_leaf();
        file.json["images"] = json!([image]);
        fs::write(&path, file.glb()).expect("written");
        let import = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{image}: {error}"));
        is_grey(&import, why);
    }
    let mut file = textured_leaf();
    file.json["textures"] = json!([{ "extensions": { "EXT_texture_webp": { "source": 0 } } }]);
    is_grey(
        &reads(&file),
        "texture 0: it has no image, or one of a kind that is not read",
    );
    // Bytes have no folder.
    let mut file = textured_leaf();
    file.json["images"] = json!([{ "uri": "wall.png" }]);
    is_grey(
        &reads(&file),
        "image 0 is the file `wall.png`, but no folder was given",
    );
}

#[test]
fn a_header_of_ten_billion_texels_takes_no_memory() {
    let mut bytes = png([3, 2], |_, _| [9; 4]);
    for side in [16..20, 20..24] {
        bytes[side].copy_from_slice(&100_000_u32.to_be_bytes());
    }
    // The header's checksum must be right, or it is not even believed.
    let sum = bytes[12..29].iter().fold(!0_u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
        })
    });
    bytes[29..33].copy_from_slice(&(!sum).to_be_bytes());
    let mut file = textured_leaf();
    file.texture(bytes);
    file.json["textures"][0]["source"] = json!(1);
    let start = Instant::now();
    is_grey(&reads(&file), "image 1: ");
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

#[test]
fn images_that_are_too_much_together_are_grey_from_the_first_that_does_not_fit() {
    let mut file = textured_leaf();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let large = png([700, 700], |_, _| [9; 4]);
    let view = file.view(large);
    for _ in 0..20 {
        let image = file.push("images", json!({ "bufferView": view }));
        let texture = file.push("textures", json!({ "source": image }));
        let mut primitive = primitive.clone();
        primitive["material"] = json!(file.push(
            "materials",
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } })
        ));
        let primitives = file.json["meshes"][0]["primitives"].as_array_mut();
        primitives.expect("a list").push(primitive);
    }
    let options = ReadOptions {
        limit_bytes: 60 << 20,
        ..ReadOptions::default()
    };
    let import = read_bytes(&file.glb(), None, &options).unwrap_or_else(|error| panic!("{error}"));
    let textures = import.rooms[0].content.textures();
    let grey = textures.iter().filter(|texture| texture.size() == [1, 1]).count();
    assert!((1..20).contains(&grey), "{grey} are grey");
    let bytes: u64 = textures.iter().map(|texture| texture.bytes()).sum();
    assert!(bytes < options.limit_bytes);
    let said = warnings(&import);
    assert!(
        said[0].contains("700x700 texels need ") && said[0].contains(" bytes, more than is allowed"),
        "{said:?}"
    );
}

#[test]
fn an_image_looked_up_in_a_hundred_ways_is_not_kept_a_hundred_times_without_asking() {
    let mut file = textured_leaf();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    file.texture(png([1000, 1000], |_, _| [9; 4]));
    let ways = [10_497, 33_071, 33_648];
    for (s, t) in ways.iter().flat_map(|s| ways.map(|t| (s, t))) {
        let sampler = file.push("samplers", json!({ "wrapS": s, "wrapT": t }));
        let texture = file.push("textures", json!({ "source": 1, "sampler": sampler }));
        let mut primitive = primitive.clone();
        primitive["material"] = json!(file.push(
            "materials",
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } })
        ));
        let primitives = file.json["meshes"][0]["primitives"].as_array_mut();
        primitives.expect("a list").push(primitive);
    }
    let options = ReadOptions {
        limit_bytes: 40 << 20,
        ..ReadOptions::default()
    };
    let import = read_bytes(&file.glb(), None, &options).unwrap_or_else(|error| panic!("{error}"));
    let textures = import.rooms[0].content.textures();
    assert_eq!(textures.len(), 10);
    let grey = textures.iter().filter(|texture| texture.size() == [1, 1]).count();
    assert!((1..8).contains(&grey), "{grey} are grey");
    let said = warnings(&import);
    assert!(
        said[0].contains("once more, for another sampler, needs more memory than is allowed"),
        "{said:?}"
    );
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
                "faces have a texture, but no place in it: they have the color of its corner \
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
        ["texture coordinates are not finite, and are 0 (meshes[0].primitives[0])"]
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
    assert_eq!(import.rooms[0].content.textures().len(), MANY);
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
    const FILES: usize = 20_000;
    let limits = ReadOptions {
        limit_bytes: 1 << 26,
        ..ReadOptions::default()
    };
    let whole = tree().glb();
    let json_end = 20 + u32::from_le_bytes(whole[12..16].try_into().expect("four bytes")) as usize;
    let mut state = 20_261_122_u64;
    let mut number = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let (mut read, mut refused) = (0, 0);
    for _ in 0..FILES {
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
        match read_bytes(&file, None, &limits) {
            Ok(_) => read += 1,
            Err(error) => {
                assert!(!error.to_string().is_empty());
                refused += 1;
            }
        }
    }
    assert!(
        read > FILES / 20 && refused > FILES / 20,
        "{read} read, {refused} refused: the mutations are too mild or too wild"
    );
}

#[test]
fn a_textured_file_with_a_number_replaced_by_a_bad_one_is_read_or_refused() {
    const BAD: [&str; 10] = [
        "-1",
        "0",
        "3",
        "255",
        "65536",
        "4294967296",
        "18446744073709551615",
        "1e308",
        "null",
        "[]",
    ];
    let text = tree().json.to_string();
    let binary = tree().bytes;
    let is_digit = |at: usize| text.as_bytes()[at].is_ascii_digit();
    let starts = (1..text.len()).filter(|&at| is_digit(at) && !is_digit(at - 1));
    for start in starts {
        let end = (start..text.len())
            .find(|&at| !is_digit(at))
            .expect("JSON ends with a bracket");
        for bad in BAD {
            let _ = refusal(&glb(&format!("{}{bad}{}", &text[..start], &text[end..]), &binary));
        }
    }
}

#[test]
fn jpegs_with_a_few_bytes_wrong_are_read_or_grey() {
    let mut jpeg = Vec::new();
    image::RgbImage::from_fn(40, 24, |x, y| {
        image::Rgb([(x * 6) as u8, (y * 10) as u8, (x * y) as u8])
    })
    .write_to(&mut std::io::Cursor::new(&mut jpeg), image::ImageFormat::Jpeg)
    .expect("into memory");
    let mut file = textured_leaf();
    file.texture(jpeg.clone());
    file.json["textures"][0]["source"] = json!(1);
    let start = file.json["bufferViews"][4]["byteOffset"]
        .as_u64()
        .expect("a number") as usize;
    let mut state = 3_u64;
    let mut number = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let limits = ReadOptions {
        limit_bytes: 1 << 26,
        ..ReadOptions::default()
    };
    for _ in 0..3000 {
        let mut broken = file.clone();
        for _ in 0..=number(3) {
            broken.bytes[start + number(jpeg.len())] = number(256) as u8;
        }
        read_bytes(&broken.glb(), None, &limits).unwrap_or_else(|error| panic!("{error}"));
    }
}
