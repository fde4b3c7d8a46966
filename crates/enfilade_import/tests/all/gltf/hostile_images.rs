//! Images made to do harm, or not there at all: grey, and a warning says why.

use super::file::{File, material, png, reads, textured_leaf, warnings};
use super::hostile::numbers;
use enfilade_import::{Import, ReadOptions, read, read_bytes};
use serde_json::json;
use std::fs;
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

/// A textured leaf with another image is read, its texture is grey, and this is the end of the warning.
#[track_caller]
fn is_grey(import: &Import, why: &str) {
    let texture = material(import).texture.expect("a texture").0 as usize;
    assert_eq!(
        import.rooms[0].geometry.textures()[texture].texels(),
        [[128, 128, 128, 255]]
    );
    let said = warnings(import);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(
        said[0].starts_with("images that cannot be read are grey (") && said[0].contains(why),
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
            "image 0 is at `https://example.org/a.png`, and nothing is fetched",
        ),
        (
            json!({ "uri": "nowhere.png", "name": "Wall" }),
            "image 0 \"Wall\" is the file `",
        ),
        (json!({ "uri": "folder.png" }), "is not a file"),
        (
            json!({ "uri": "words.png" }),
            "image 0: it is neither PNG nor JPEG",
        ),
        (
            json!({ "uri": "data:image/png;base64,!!!" }),
            "image 0 has an invalid URI: its data URI is not base64",
        ),
        (
            json!({ "uri": "data:image/png;base64" }),
            "its data URI has no comma",
        ),
        (
            json!({ "uri": "data:;base64," }),
            "image 0: it is neither PNG nor JPEG",
        ),
        (json!({ "uri": "%ff.png" }), "is not UTF-8"),
        (json!({}), "image 0: it has neither a uri nor a bufferView"),
        // Positions are no image.
        (json!({ "bufferView": 0 }), "image 0: it is neither PNG nor JPEG"),
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
        "texture 0: it has no image, or one of an unsupported format",
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

/// Adds a copy of the file's first faces, with another texture.
fn show_once_more(file: &mut File, texture: usize) {
    let mut primitive = file.json["meshes"][0]["primitives"][0].clone();
    primitive["material"] = json!(file.push(
        "materials",
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } })
    ));
    let primitives = file.json["meshes"][0]["primitives"].as_array_mut();
    primitives.expect("a list").push(primitive);
}

#[test]
fn images_that_are_too_much_together_are_grey_from_the_first_that_does_not_fit() {
    let mut file = textured_leaf();
    let large = png([700, 700], |_, _| [9; 4]);
    let view = file.view(large);
    for _ in 0..20 {
        let image = file.push("images", json!({ "bufferView": view }));
        let texture = file.push("textures", json!({ "source": image }));
        show_once_more(&mut file, texture);
    }
    let options = ReadOptions {
        limit_bytes: 60 << 20,
        ..ReadOptions::default()
    };
    let import = read_bytes(&file.glb(), None, &options).unwrap_or_else(|error| panic!("{error}"));
    let textures = import.rooms[0].geometry.textures();
    let grey = textures.iter().filter(|texture| texture.size() == [1, 1]).count();
    assert!((1..20).contains(&grey), "{grey} are grey");
    let bytes: u64 = textures.iter().map(|texture| texture.bytes()).sum();
    assert!(bytes < options.limit_bytes);
    let said = warnings(&import);
    assert!(
        said[0].contains("700x700 texels need ") && said[0].contains("MB, more than the memory limit allows"),
        "{said:?}"
    );
}

#[test]
fn an_image_looked_up_in_a_hundred_ways_is_not_kept_a_hundred_times_without_asking() {
    let mut file = textured_leaf();
    file.texture(png([1000, 1000], |_, _| [9; 4]));
    let ways = [10_497, 33_071, 33_648];
    for (s, t) in ways.iter().flat_map(|s| ways.map(|t| (s, t))) {
        let sampler = file.push("samplers", json!({ "wrapS": s, "wrapT": t }));
        let texture = file.push("textures", json!({ "source": 1, "sampler": sampler }));
        show_once_more(&mut file, texture);
    }
    let options = ReadOptions {
        limit_bytes: 40 << 20,
        ..ReadOptions::default()
    };
    let import = read_bytes(&file.glb(), None, &options).unwrap_or_else(|error| panic!("{error}"));
    let textures = import.rooms[0].geometry.textures();
    assert_eq!(textures.len(), 10);
    let grey = textures.iter().filter(|texture| texture.size() == [1, 1]).count();
    assert!((1..8).contains(&grey), "{grey} are grey");
    let said = warnings(&import);
    assert!(
        said[0].contains("a copy for another sampler needs more memory than is allowed"),
        "{said:?}"
    );
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
    let mut number = numbers(3);
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
