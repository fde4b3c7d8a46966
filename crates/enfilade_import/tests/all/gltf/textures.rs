//! Images on faces: which, where on them, and how they are looked up.

use super::file::{File, carried, material, png, reads, textured_leaf, warnings};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use enfilade::{Filter, Minify, Texture, TextureId, Wrap};
use enfilade_import::{Import, ReadOptions, read, read_bytes};
use serde_json::{Value, json};
use std::fs;

fn textures(import: &Import) -> Vec<&Texture> {
    let textures = import.rooms[0].geometry.textures();
    textures.iter().map(|texture| &**texture).collect()
}

fn base(file: &mut File) -> &mut Value {
    &mut file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
}

#[test]
fn a_texture_is_on_the_faces_that_name_it_texel_by_texel() {
    let import = reads(&textured_leaf());
    assert_eq!(warnings(&import), [""; 0]);
    assert_eq!(material(&import).texture, Some(TextureId(0)));
    let [texture] = textures(&import)[..] else {
        panic!("one texture")
    };
    assert_eq!((texture.size(), &*texture.name), ([2, 2], "image#0"));
    assert_eq!(
        texture.texels(),
        [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255; 4]]
    );
    assert_eq!(
        carried(&import, |mesh| mesh.texture()),
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    );
}

#[test]
fn who_wants_no_textures_gets_none_and_loses_nothing_else() {
    let mut file = textured_leaf();
    // It is not even looked at.
    file.json["images"] = json!([{ "uri": "../nowhere.png" }]);
    let options = ReadOptions {
        textures: false,
        ..ReadOptions::default()
    };
    let import = read_bytes(&file.glb(), None, &options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings(&import), [""; 0]);
    assert_eq!(material(&import).texture, None);
    assert!(textures(&import).is_empty() && carried(&import, |mesh| mesh.texture()).is_empty());
    assert_eq!(import.rooms[0].geometry.triangle_count(), 1);
}

#[test]
fn coordinates_may_be_bytes_or_shorts_and_come_from_the_set_that_the_texture_names() {
    let shorts =
        |values: [u16; 6]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let fifth = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.2]];
    for (component, normalized, bytes, expected) in [
        (5121, true, vec![0, 0, 255, 0, 0, 51], fifth),
        (
            5121,
            false,
            vec![0, 0, 2, 0, 0, 3],
            [[0.0, 0.0], [2.0, 0.0], [0.0, 3.0]],
        ),
        (5123, true, shorts([0, 0, 65535, 0, 0, 13107]), fifth),
        // The least is as far from 0 as the greatest.
        (
            5122,
            true,
            shorts([0, 0, 0x8000, 0, 0, 32767]),
            [[0.0, 0.0], [-1.0, 0.0], [0.0, 1.0]],
        ),
        (
            5120,
            false,
            vec![0, 0, 0xff, 0, 0, 7],
            [[0.0, 0.0], [-1.0, 0.0], [0.0, 7.0]],
        ),
    ] {
        let mut file = textured_leaf();
        // Elements of a view begin at multiples of four.
        let size = bytes.len() / 6;
        let apart = bytes
            .chunks(2 * size)
            .flat_map(|each| [each, &[0; 4][2 * size % 4..]].concat());
        let accessor = file.accessor(component, "VEC2", 3, apart.collect());
        file.json["accessors"][accessor]["normalized"] = json!(normalized);
        let view = file.json["accessors"][accessor]["bufferView"]
            .as_u64()
            .expect("a number") as usize;
        file.json["bufferViews"][view]["byteStride"] = json!(if size == 1 { 4 } else { 8 });
        file.carry("TEXCOORD_1", accessor);
        base(&mut file)["texCoord"] = json!(1);
        assert_eq!(
            carried(&reads(&file), |mesh| mesh.texture()),
            expected,
            "{component} {normalized}"
        );
    }
}

#[test]
fn a_texture_that_is_moved_turned_and_scaled_is_so_on_every_face() {
    let mut file = textured_leaf();
    let other = file.floats(&[0.0, 0.0, 0.5, 0.0, 0.0, 0.5], 2);
    file.carry("TEXCOORD_1", other);
    // By the extension's own word a turn goes counter-clockwise where v goes down: (1, 0) comes to (0, -1).
    base(&mut file)["extensions"] = json!({ "KHR_texture_transform": {
        "offset": [0.25, 0.5], "rotation": std::f64::consts::FRAC_PI_2, "scale": [2, 4], "texCoord": 1
    } });
    let places = carried(&reads(&file), |mesh| mesh.texture());
    for (place, expected) in places.iter().zip([[0.25, 0.5], [0.25, -0.5], [2.25, 0.5]]) {
        let off = (0..2)
            .map(|axis| (place[axis] - expected[axis]).abs())
            .fold(0.0_f32, f32::max);
        assert!(off < 1e-6, "{place:?}, not {expected:?}");
    }
}

#[test]
fn samplers_say_what_is_beyond_the_sides_and_between_texels() {
    let minify = |texels, levels| Minify { texels, levels };
    let (near, soft) = (Filter::Nearest, Filter::Linear);
    let repeat = [Wrap::Repeat; 2];
    for (sampler, wrap, magnify, minify) in [
        (json!({}), repeat, soft, minify(soft, Some(soft))),
        (
            json!({ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9728 }),
            [Wrap::Clamp, Wrap::Mirror],
            near,
            minify(near, None),
        ),
        (
            json!({ "wrapS": 33648, "wrapT": 10497, "magFilter": 9729, "minFilter": 9729 }),
            [Wrap::Mirror, Wrap::Repeat],
            soft,
            minify(soft, None),
        ),
        (
            json!({ "minFilter": 9984 }),
            repeat,
            soft,
            minify(near, Some(near)),
        ),
        (
            json!({ "minFilter": 9985 }),
            repeat,
            soft,
            minify(soft, Some(near)),
        ),
        (
            json!({ "minFilter": 9986 }),
            repeat,
            soft,
            minify(near, Some(soft)),
        ),
        (
            json!({ "minFilter": 9987 }),
            repeat,
            soft,
            minify(soft, Some(soft)),
        ),
    ] {
        let mut file = textured_leaf();
        file.json["samplers"] = json!([sampler]);
        file.json["textures"][0]["sampler"] = json!(0);
        let import = reads(&file);
        let texture = textures(&import)[0];
        assert_eq!(
            (texture.wrap, texture.magnify, texture.minify),
            (wrap, magnify, minify),
            "{sampler}"
        );
    }
}

#[test]
fn what_a_file_says_twice_is_kept_once() {
    let mut file = textured_leaf();
    // Three textures of one image, two of them looked up as the first is, and an image that no used material names.
    file.json["samplers"] = json!([{}, { "minFilter": 9987 }, { "wrapS": 33071 }]);
    for sampler in 0..3 {
        let texture = file.push("textures", json!({ "source": 0, "sampler": sampler }));
        let material = file.push(
            "materials",
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }),
        );
        let mut primitive = file.json["meshes"][0]["primitives"][0].clone();
        primitive["material"] = json!(material);
        let primitives = file.json["meshes"][0]["primitives"].as_array_mut();
        primitives.expect("a list").push(primitive);
    }
    file.push("images", json!({ "uri": "nobody-names-it.png" }));
    let unused = file.push("textures", json!({ "source": 1 }));
    file.push(
        "materials",
        json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": unused } } }),
    );
    let import = reads(&file);
    assert_eq!(warnings(&import), [""; 0]);
    let found = textures(&import);
    let wraps: Vec<Wrap> = found.iter().map(|texture| texture.wrap[0]).collect();
    assert_eq!(wraps, [Wrap::Repeat, Wrap::Clamp]);
    assert_eq!(found[0].texels(), found[1].texels());
    let materials = import.rooms[0].geometry.materials().iter();
    let named: Vec<_> = materials.map(|material| material.texture).collect();
    let [same, other] = [Some(TextureId(0)), Some(TextureId(1))];
    assert_eq!(named, [same, same, same, other, None, None]);
}

#[test]
fn images_may_be_inside_beside_or_in_the_address_itself() {
    let folder = tempfile::tempdir().expect("a folder");
    let tile = png([1, 1], |_, _| [10, 20, 30, 40]);
    fs::create_dir(folder.path().join("images")).expect("a folder");
    fs::write(folder.path().join("images/my tile é.png"), &tile).expect("written");
    let beside = "images/my%20tile%20%C3%A9.png";
    let inside = format!("data:image/png;base64,{}", STANDARD.encode(&tile));
    for (uri, name) in [(beside, beside), (&*inside, "image#0")] {
        let mut file = textured_leaf();
        file.json["images"] = json!([{ "uri": uri }]);
        let path = folder.path().join("leaf.glb");
        fs::write(&path, file.glb()).expect("written");
        let import = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(warnings(&import), [""; 0]);
        let texture = textures(&import)[0];
        assert_eq!(
            (texture.texels(), &*texture.name),
            (&[[10, 20, 30, 40]][..], name)
        );
    }
}

#[test]
fn a_jpeg_is_known_by_its_bytes_whatever_the_file_calls_it() {
    let mut jpeg = Vec::new();
    image::RgbImage::from_pixel(8, 8, image::Rgb([200, 100, 50]))
        .write_to(&mut std::io::Cursor::new(&mut jpeg), image::ImageFormat::Jpeg)
        .expect("into memory");
    let with = |bytes: &[u8]| {
        let mut file = textured_leaf();
        file.texture(bytes.to_vec());
        file.json["textures"][0]["source"] = json!(1);
        reads(&file)
    };
    let import = with(&jpeg);
    let texture = textures(&import)[0];
    let near = |texel: &[u8; 4]| (0..3).all(|part| texel[part].abs_diff([200, 100, 50][part]) < 4);
    assert!(
        texture.size() == [8, 8] && texture.texels().iter().all(near),
        "{texture:?}"
    );
    // Something after its end does no harm; what is missing at its end would be made up.
    assert_eq!(
        warnings(&with(&[&jpeg[..], b"\xFF\xDA and more"].concat())),
        [""; 0]
    );
    let cut = warnings(&with(&jpeg[..jpeg.len() - 2]));
    assert_eq!(
        cut,
        ["images that cannot be read are grey (image 1: it is truncated)"]
    );
}

#[test]
fn many_images_are_decoded_each_in_its_place() {
    let mut file = File::leaf();
    let places = file.floats(&[0.0; 6], 2);
    file.carry("TEXCOORD_0", places);
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    let mut primitives = Vec::new();
    for number in 0..40_u8 {
        let texture = file.texture(png([1 + u32::from(number), 2], |_, _| [number; 4]));
        let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } });
        let mut primitive = primitive.clone();
        primitive["material"] = json!(file.push("materials", material));
        primitives.push(primitive);
    }
    file.json["meshes"][0]["primitives"] = json!(primitives);
    let import = reads(&file);
    for (number, texture) in textures(&import).into_iter().enumerate() {
        assert_eq!(texture.size(), [1 + number as u32, 2]);
        assert_eq!(texture.texels()[0], [number as u8; 4]);
    }
    assert_eq!(textures(&import).len(), 40);
}
