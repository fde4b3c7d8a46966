//! `draw`: the pictures it writes.

use crate::support::Folder;
use enfilade::{CoverShape, Method};
use std::collections::HashSet;

/// Width and height of a PNG.
fn size(folder: &Folder, name: &str) -> [u32; 2] {
    let picture = std::fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(picture.starts_with(b"\x89PNG\r\n\x1a\n"), "{name}");
    [16, 20].map(|at| u32::from_be_bytes(picture[at..at + 4].try_into().expect("four bytes")))
}

fn drawn(folder: &Folder, arguments: &str) {
    let run = folder.run(&format!("draw scene.glb --size 80x45 {arguments}"));
    assert_eq!(
        (run.code, run.complaints()),
        (Some(0), String::new()),
        "{arguments}"
    );
}

#[test]
fn a_picture_has_the_size_asked_for_and_leaves_nothing_beside_it() {
    let folder = Folder::new();
    drawn(&folder, "-o a.png");
    assert_eq!(size(&folder, "a.png"), [80, 45]);
    assert_eq!(folder.names(), ["a.png", "scene.glb", "views.jsonl"]);
    drawn(&folder, "-o a.png --camera back");
    assert_eq!(folder.names().len(), 3, "a picture is replaced");
}

#[test]
fn every_show_is_a_picture_of_its_own() {
    let folder = Folder::new();
    let shows = ["image", "overdraw", "items", "order", "sectors"];
    let pictures = shows.map(|show| {
        drawn(&folder, &format!("-o {show}.PNG --show {show}"));
        std::fs::read(folder.path(&format!("{show}.PNG"))).expect("a picture")
    });
    for (i, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(picture), "{}", shows[i]);
    }
}

/// The colours of a picture, as red, green and blue.
fn pixels(folder: &Folder, name: &str) -> Vec<[u8; 3]> {
    let image = image::open(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    image.into_rgb8().pixels().map(|pixel| pixel.0).collect()
}

#[test]
fn four_samples_smooth_edges_and_stops_brighten_what_lamps_light() {
    let folder = Folder::new();
    let colours = |options: &str| {
        let run = folder.run(&format!("draw @mirrors -o a.png --size 80x45 {options}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        pixels(&folder, "a.png")
    };
    let different = |picture: &[[u8; 3]]| picture.iter().collect::<HashSet<_>>().len();
    let light = |picture: &[[u8; 3]]| picture.iter().flatten().map(|&byte| u64::from(byte)).sum::<u64>();
    let plain = colours("");
    assert!(different(&colours("--samples 4")) > different(&plain));
    assert!(
        light(&colours("--exposure 2")) > light(&plain) && light(&colours("--exposure -2")) < light(&plain)
    );
}

/// Mean of all channels.
fn brightness(picture: &[[u8; 3]]) -> f64 {
    let sum: u64 = picture.iter().flatten().map(|&value| u64::from(value)).sum();
    sum as f64 / picture.len() as f64
}

#[test]
fn shadows_and_ambient_occlusion_darken_a_picture() {
    let folder = Folder::new();
    let colours = |options: &str| {
        let run = folder.run(&format!("draw @mirrors -o a.png --size 80x45 {options}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        brightness(&pixels(&folder, "a.png"))
    };
    let plain = colours("");
    let [shadows, corners] = ["--shadows", "--ambient-occlusion 8"].map(colours);
    assert!(
        shadows < plain && corners < plain,
        "{shadows}, {corners} of {plain}"
    );
    let both = colours("--shadows --ambient-occlusion 8 --samples 4");
    assert!(both < shadows.min(corners), "{both} with both");
    // A scene without lights gets a sun.
    drawn(&folder, "-o sun.png --shadows");
    drawn(&folder, "-o plain.png");
    assert_ne!(pixels(&folder, "sun.png"), pixels(&folder, "plain.png"));
}

/// Returns the methods whose covers can be shown, with the shape of each.
fn shapes() -> impl Iterator<Item = (Method, CoverShape)> {
    let all = Method::ALL.into_iter();
    all.filter_map(|method| Some((method, method.cover_shape()?)))
}

#[test]
fn every_shape_of_cover_is_a_picture_of_its_own() {
    let folder = Folder::new();
    for scene in ["scene.glb", "@two-rooms"] {
        let mut pictures: Vec<(CoverShape, Vec<[u8; 3]>)> = Vec::new();
        for (method, shape) in shapes() {
            let run = folder.run(&format!(
                "draw {scene} --size 80x45 -o a.png --show cover --method {method}"
            ));
            assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{method}");
            let picture = pixels(&folder, "a.png");
            let colors: HashSet<[u8; 3]> = picture.iter().copied().collect();
            assert!(colors.len() > 4, "{scene} by {method}: {} colours", colors.len());
            for (other, before) in &pictures {
                assert_eq!(picture == *before, shape == *other, "{scene} by {method}");
            }
            pictures.push((shape, picture));
        }
        assert_eq!(pictures.len(), 6);
    }
}

#[test]
fn covers_are_shown_through_openings() {
    let folder = Folder::new();
    for (method, _) in shapes() {
        let [through, flat] = ["", "--flat"].map(|more| {
            let run = folder.run(&format!(
                "draw @two-rooms --size 80x45 -o a.png --show cover --method {method} {more}"
            ));
            assert_eq!(run.code, Some(0), "{}", run.stderr);
            pixels(&folder, "a.png")
        });
        assert_ne!(through, flat, "{method}");
    }
}

#[test]
fn a_cover_without_a_shape_is_refused_by_name_and_skipped_among_all() {
    let folder = Folder::new();
    for method in ["painter-min", "painter-mean", "bsp", "bsp-front", "z-buffer"] {
        let run = folder.run(&format!("draw scene.glb -o a.png --show cover --method {method}"));
        assert_eq!(run.code, Some(2));
        for word in [method, "s-buffer", "hierarchical-z", "masked", "mobsp"] {
            assert!(run.stderr.contains(word), "{}", run.stderr);
        }
        assert!(!folder.path("a.png").exists());
    }
    let run = folder.run("draw scene.glb -o a.png --show cover --method all --size 80x45");
    let without_a_shape = Method::ALL.len() - shapes().count();
    assert_eq!(
        (run.code, run.stdout.matches("is skipped").count()),
        (Some(0), without_a_shape)
    );
    let beside = ["scene.glb", "views.jsonl"].len();
    assert_eq!(folder.names().len(), beside + shapes().count());
}

#[test]
fn several_views_and_methods_have_several_pictures() {
    let folder = Folder::new();
    drawn(&folder, "-o a.png --path views.jsonl");
    drawn(&folder, "-o b.png --method all");
    drawn(&folder, "-o c.png --survey 2 --method z-buffer");
    let made: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|name| name.ends_with(".png") && !name.starts_with('b'))
        .collect();
    assert_eq!(made, ["a-000.png", "a-001.png", "c-000.png", "c-001.png"]);
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        assert!(folder.path(&format!("b-{method}.png")).exists(), "{method}");
    }
    let bytes = |name: &str| std::fs::read(folder.path(name)).expect("a picture");
    assert_ne!(bytes("a-000.png"), bytes("a-001.png"));
    assert_eq!(
        bytes("b-hierarchical-z.png"),
        bytes("b-z-buffer.png"),
        "methods agree on the picture"
    );
}

#[test]
fn a_report_says_how_long_drawing_took_and_where_the_pictures_are() {
    let folder = Folder::new();
    let report = folder.json("draw scene.glb --size 80x45 -o a.png --path views.jsonl");
    assert_eq!(report["views"][1]["picture"], "a-001.png");
    assert!(report["views"][1]["draw_ms"].as_f64() > Some(0.0));
    assert_eq!(report["views"][0]["items_visible"], 3);
}

#[cfg(not(feature = "levels"))]
#[test]
fn levels_in_a_build_without_them_are_an_error_that_names_the_feature() {
    let folder = Folder::new();
    let run = folder.run("draw scene.glb -o a.png --levels 1");
    assert_eq!((run.code, &*run.stdout), (Some(2), ""));
    let expected = "error: this program was built without levels of detail; leave out --levels, or build it with \
                    `cargo build --release -p enfilade-cli --features levels`";
    assert!(run.stderr.starts_with(expected), "{}", run.stderr);
    assert!(!folder.path("a.png").exists());
}

#[test]
fn levels_and_json_are_refused_together() {
    let run = Folder::new().run("draw scene.glb -o a.png --levels 1 --json -");
    assert_eq!((run.code, &*run.stdout), (Some(2), ""));
    let expected = "'--levels <PIXELS>' cannot be used with '--json <FILE>'";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
}

#[cfg(feature = "levels")]
#[test]
fn levels_save_triangles_and_say_how_many() {
    let folder = Folder::new();
    let run = folder.run("draw scene.glb --size 80x45 -o a.png --levels 1");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let small = "; 0 of them with LODs: ";
    assert!(run.stdout.contains(small), "{}", run.stdout);
    // A scene without large items is drawn at full detail.
    drawn(&folder, "-o b.png");
    assert_eq!(pixels(&folder, "a.png"), pixels(&folder, "b.png"));
    for wrong in ["0", "-1", "NaN", "much"] {
        let run = folder.run(&format!("draw scene.glb -o c.png --levels={wrong}"));
        assert_eq!(run.code, Some(2), "{wrong}: {}", run.stderr);
    }
    let run = folder.run("draw scene.glb -o c.png --levels 1 --json -");
    assert_eq!(
        run.code,
        Some(2),
        "times are those of the scene as it is: {}",
        run.stderr
    );
}
