//! Images on faces.

use super::file::{corner, material, read_among, reads_among, warnings};
use enfilade::{Alpha, Texture, Wrap};
use enfilade_import::{Import, ReadOptions};
use image::ImageFormat;
use std::io::Cursor;

const SHEET: &str =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3";

/// Two texels beside each other: red, and half of green.
fn two_texels(format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let texels = image::RgbaImage::from_vec(2, 1, vec![255, 0, 0, 255, 0, 255, 0, 128]).expect("two texels");
    let image = image::DynamicImage::from(texels);
    let image = if format == ImageFormat::Jpeg {
        image.into_rgb8().into()
    } else {
        image
    };
    image.write_to(&mut bytes, format).expect("into memory");
    bytes.into_inner()
}

/// The sheet, made of the material `a` with these lines, with more files beside it.
fn sheet(lines: &str, files: &[(&str, &[u8])], options: &ReadOptions) -> Import {
    let materials = format!("newmtl a\n{lines}");
    let mut all = vec![("a.obj", SHEET.as_bytes()), ("a.mtl", materials.as_bytes())];
    all.extend(files);
    read_among(&all, options).unwrap_or_else(|error| panic!("{error}"))
}

fn with_wood(lines: &str) -> Import {
    let wood = two_texels(ImageFormat::Png);
    sheet(
        lines,
        &[("my wood.png", &wood), ("tex/wood.png", &wood)],
        &ReadOptions::default(),
    )
}

fn texture(import: &Import) -> &Texture {
    let id = material(import).texture.expect("an image");
    &import.rooms[0].geometry.textures()[id.0 as usize]
}

#[test]
fn an_image_lies_on_faces_and_is_multiplied_by_their_color() {
    let import = with_wood("Kd 0.5 0.25 1\nmap_Kd my wood.png");
    assert_eq!(warnings(&import), [""; 0]);
    let wood = texture(&import);
    assert_eq!(
        (wood.name.as_str(), wood.size(), wood.wrap),
        ("my wood.png", [2, 1], [Wrap::Repeat; 2])
    );
    assert_eq!(wood.texels(), [[255, 0, 0, 255], [0, 255, 0, 128]]);
    let made_of = material(&import);
    // Its alpha is not asked for, so it hides what is behind it.
    assert_eq!(
        (made_of.base_color, made_of.alpha),
        ([0.5, 0.25, 1.0, 1.0], Alpha::Opaque)
    );
    assert_eq!(corner(&import, [0.0, 1.0, 0.0]).texture, Some([0.0, 0.0]));
}

#[test]
fn jpeg_is_read_too_and_known_by_its_bytes() {
    let jpeg = two_texels(ImageFormat::Jpeg);
    let import = sheet(
        "map_Kd photo.png",
        &[("photo.png", &jpeg)],
        &ReadOptions::default(),
    );
    assert_eq!((texture(&import).size(), warnings(&import).len()), ([2, 1], 0));
}

#[test]
fn images_are_found_by_the_paths_that_other_machines_write() {
    for path in [
        "tex/wood.png",
        "tex\\wood.png",
        ".\\tex\\..\\tex/wood.png",
        "\"my wood.png\"",
        "C:\\Users\\me\\my wood.png",
        "/home/me/my wood.png",
        "../art/my wood.png",
    ] {
        let import = with_wood(&format!("map_Kd {path}"));
        assert_eq!(warnings(&import), [""; 0], "{path}");
        assert_eq!(texture(&import).size(), [2, 1], "{path}");
    }
}

#[test]
fn images_are_looked_for_beside_the_file_that_names_them_and_never_outside() {
    let wood = two_texels(ImageFormat::Png);
    let text = SHEET.replace("a.mtl", "scene/lib/a.mtl").into_bytes();
    for (path, found) in [
        ("wood.png", true),
        ("../wood.png", true),
        ("../../wood.png", true),
        ("../../../wood.png", true),
        ("sub/wood.png", false),
    ] {
        let materials = format!("newmtl a\nmap_Kd {path}");
        let import = reads_among(&[
            ("a.obj", &text),
            ("scene/lib/a.mtl", materials.as_bytes()),
            ("scene/lib/wood.png", &wood),
            ("scene/wood.png", &wood),
            ("wood.png", &wood),
        ]);
        assert_eq!(texture(&import).size() == [2, 1], found, "{path}");
    }
    // Beside the scene's folder lies one that it must not get.
    let inner = SHEET.as_bytes();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("scene")).expect("it is ours");
    for (name, bytes) in [
        ("scene/a.obj", inner),
        ("scene/a.mtl", b"newmtl a\nmap_Kd ../secret.png"),
        ("secret.png", &wood),
    ] {
        std::fs::write(folder.path().join(name), bytes).expect("it is ours");
    }
    let import = enfilade_import::read(&folder.path().join("scene/a.obj"), &ReadOptions::default());
    let said = warnings(&import.expect("sound without it"));
    assert!(
        said[0].starts_with("images that cannot be read are grey (secret.png: cannot be read: "),
        "{said:?}"
    );
}

#[test]
fn options_place_an_image_and_say_whether_it_repeats() {
    let import = with_wood("map_Kd -s 2 3 1 -o 0.5 0.25 my wood.png");
    assert_eq!(warnings(&import), [""; 0]);
    // (1, 0) is at (1·2 + 0.5, 0·3 + 0.25) from the lower left.
    assert_eq!(corner(&import, [1.0, 0.0, 0.0]).texture, Some([2.5, 0.75]));
    assert_eq!(corner(&import, [0.0, 1.0, 0.0]).texture, Some([0.5, -2.25]));
    let import = with_wood("map_Kd -clamp on my wood.png");
    assert_eq!(texture(&import).wrap, [Wrap::Clamp; 2]);
    let import = with_wood("map_Kd -clamp off -mm 0 1 -t 1 1 1 my wood.png");
    assert_eq!(texture(&import).wrap, [Wrap::Repeat; 2]);
    assert_eq!(
        warnings(&import),
        ["unknown statements in material files are ignored (a.mtl line 2: -mm, a.mtl line 2: -t)"]
    );
}

#[test]
fn an_image_under_black_or_no_color_stands_alone() {
    for lines in ["Kd 0 0 0\nmap_Kd my wood.png", "map_Kd my wood.png"] {
        assert_eq!(material(&with_wood(lines)).base_color, [1.0; 4], "{lines}");
    }
    let lamp = material(&with_wood("Kd 0.5 0.5 0.5\nmap_Ke my wood.png"));
    assert_eq!((lamp.emission, lamp.texture), ([1.0; 3], None));
    assert!(lamp.emission_texture.is_some());
    let lamp = material(&with_wood("Ke 2 2 2\nmap_Ke my wood.png\nmap_Kd my wood.png"));
    assert_eq!((lamp.emission, lamp.emission_texture), ([2.0; 3], lamp.texture));
    let odd = with_wood("map_Ke -s 2 my wood.png\nmap_Kd tex/wood.png");
    assert_eq!(
        warnings(&odd),
        ["unknown statements in material files are ignored (a: map_Ke has other options than map_Kd)"]
    );
}

#[test]
fn alpha_maps_make_cut_outs() {
    let leaf = with_wood("map_Kd my wood.png\nmap_d .\\my wood.png");
    assert_eq!(warnings(&leaf), [""; 0]);
    assert_eq!(
        (material(&leaf).alpha, material(&leaf).cutoff),
        (Alpha::Mask, 0.5)
    );
    assert_eq!(
        material(&with_wood("map_Kd my wood.png\nmap_d my wood.png\nd 0.5")).alpha,
        Alpha::Blend
    );
    for lines in ["map_Kd my wood.png\nmap_d tex/wood.png", "map_d tex/wood.png"] {
        let other = with_wood(lines);
        // It is not drawn, but who says that there are holes does not want all behind them hidden.
        assert_eq!(material(&other).alpha, Alpha::Mask, "{lines}");
        assert_eq!(
            warnings(&other),
            [
                "unknown statements in material files are ignored (a: map_d is ignored: its image differs from map_Kd)"
            ]
        );
    }
}

#[test]
fn images_that_cannot_be_had_are_grey_and_named() {
    let wood = two_texels(ImageFormat::Png);
    let bad = [
        ("cut.png", &wood[..wood.len() / 2]),
        ("text.png", b"this is no image"),
        ("folder.png/a", b""),
    ];
    for (path, why) in [
        ("gone.png", "cannot be read: "),
        ("cut.png", ""),
        ("text.png", "neither PNG nor JPEG"),
        ("folder.png", "is not a file"),
        ("..", "cannot be read: "),
    ] {
        let import = sheet(&format!("map_Kd {path}"), &bad, &ReadOptions::default());
        assert_eq!(texture(&import).texels(), [[128, 128, 128, 255]], "{path}");
        let said = warnings(&import);
        assert!(
            said.len() == 1
                && said[0].starts_with("images that cannot be read are grey (")
                && said[0].contains(why),
            "{path}: {said:?}"
        );
    }
    let few = ReadOptions {
        limit_bytes: 200_000,
        ..ReadOptions::default()
    };
    let mut large = Cursor::new(Vec::new());
    let white = image::RgbaImage::new(600, 600);
    white.write_to(&mut large, ImageFormat::Png).expect("into memory");
    let import = sheet("map_Kd large.png", &[("large.png", &large.into_inner())], &few);
    assert!(
        warnings(&import)[0].contains("large.png: 600x600 texels need"),
        "{:?}",
        warnings(&import)
    );
}

#[test]
fn who_wants_no_images_gets_none_and_the_same_faces() {
    let none = ReadOptions {
        textures: false,
        ..ReadOptions::default()
    };
    let import = sheet("map_Kd gone.png\nmap_d gone.png\nmap_Ke gone.png", &[], &none);
    assert_eq!(warnings(&import), [""; 0]);
    assert!(import.rooms[0].geometry.textures().is_empty());
    let made_of = material(&import);
    assert_eq!(
        (made_of.texture, made_of.emission_texture, made_of.emission),
        (None, None, [0.0; 3])
    );
    assert_eq!(made_of.alpha, Alpha::Mask);
    assert_eq!(corner(&import, [0.0; 3]).texture, None);
}

#[test]
fn an_image_is_read_once_however_often_it_is_named() {
    let wood = two_texels(ImageFormat::Png);
    let text = format!("{SHEET}\nusemtl b\nf 1/1 2/2 3/3\nusemtl c\nf 1/1 2/2 3/3");
    let import = reads_among(&[
        ("a.obj", text.as_bytes()),
        (
            "a.mtl",
            b"newmtl a\nmap_Kd w.png\nnewmtl b\nmap_Kd ./w.png\nnewmtl c\nmap_Kd -clamp on w.png\nnewmtl d\nmap_Kd gone.png",
        ),
        ("w.png", &wood),
    ]);
    assert_eq!(warnings(&import), [""; 0]);
    assert_eq!(import.rooms[0].geometry.textures().len(), 2);
}
