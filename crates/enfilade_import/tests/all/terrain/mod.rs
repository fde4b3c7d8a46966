//! Terrain as heights with a description beside them.

use enfilade::{Method, Ray, SectorId};
use enfilade_import::{ImportError, ReadOptions, read, read_bytes, with_methods};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A description of 3 heights from west to east, in 2 rows.
fn description() -> Value {
    json!({
        "width": 3, "height": 2,
        "format": "u16 little endian, row 0 = north, metres",
        "cellMetresX": 10.0, "cellMetresZ": 20.0,
        "license": "none"
    })
}

/// 1, 2, 3 in the north and 4, 5, 600 in the south.
fn heights() -> Vec<u8> {
    [1_u16, 2, 3, 4, 5, 600]
        .into_iter()
        .flat_map(u16::to_le_bytes)
        .collect()
}

fn written(files: &[(&str, &[u8])]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("a file");
    }
    folder
}

fn refusal(description: &Value, files: &[(&str, &[u8])]) -> String {
    let folder = written(files);
    fs::write(folder.path().join("hill.json"), description.to_string()).expect("a file");
    let error: ImportError =
        read(&folder.path().join("hill.json"), &ReadOptions::default()).expect_err("it breaks a rule");
    let folder = folder.path().display().to_string();
    error.to_string().replace(&format!("{folder}/"), "")
}

/// The height above a place, in either file of the folder.
fn height(folder: &Path, x: f32, z: f32) -> f64 {
    let import = read(&folder.join("hill.json"), &ReadOptions::default()).expect("sound terrain");
    let ray = Ray {
        origin: [x, 1000.0, z],
        direction: [0.0, -1.0, 0.0],
    };
    1000.0
        - import.rooms[0]
            .geometry
            .cast(&ray)
            .expect("ground below")
            .distance
}

#[test]
fn heights_go_east_and_then_south_whichever_byte_comes_first() {
    let big: Vec<u8> = heights().chunks(2).flat_map(|two| [two[1], two[0]]).collect();
    for (format, bytes) in [
        ("u16 little endian, row 0 = north, metres", heights()),
        ("u16le", heights()),
        ("big-endian uint16", big),
    ] {
        let mut description = description();
        description["format"] = json!(format);
        let text = description.to_string();
        let folder = written(&[("hill.json", text.as_bytes()), ("hill.raw", &bytes)]);
        for (x, z, expected) in [
            (0.0, 0.0, 1.0),
            (10.0, 0.0, 2.0),
            (20.0, 20.0, 600.0),
            (0.0, 20.0, 4.0),
        ] {
            // A little within, for rays may pass an edge on either side.
            let within = |at: f32, middle: f32| at + (middle - at) * 1e-6;
            let height = height(folder.path(), within(x, 10.0), within(z, 10.0));
            assert!(
                (height - expected).abs() < 0.01,
                "{height} at {x}, {z} in {format}"
            );
        }
    }
}

#[test]
fn the_diagonal_begins_where_the_description_says() {
    let middle = |diagonal: Option<&str>| {
        let mut description = description();
        if let Some(diagonal) = diagonal {
            description["diagonal"] = json!(diagonal);
        }
        let text = description.to_string();
        let folder = written(&[("hill.json", text.as_bytes()), ("hill.raw", &heights())]);
        height(folder.path(), 15.0, 10.0)
    };
    let north_east = middle(None);
    assert!((north_east - middle(Some("north-east"))).abs() < 1e-9);
    // Half of what its ends have: 3 and 5, or else 2 and 600.
    assert!((north_east - 4.0).abs() < 1e-3, "{north_east}");
    assert!((middle(Some("north-west")) - 301.0).abs() < 1e-3);
    let mut other = description();
    other["diagonal"] = json!("both");
    let said = refusal(&other, &[("hill.raw", &heights())]);
    assert!(
        said.contains("unknown variant `both`, expected `north-east` or `north-west`"),
        "{said}"
    );
}

#[test]
fn blocks_are_items_and_the_file_names_the_room() {
    let folder = written(&[
        ("hill.json", description().to_string().as_bytes()),
        ("hill.raw", &heights()),
    ]);
    let import = read(&folder.path().join("hill.json"), &ReadOptions::default()).expect("sound terrain");
    let room = &import.rooms[0];
    assert_eq!((import.rooms.len(), &*room.name), (1, "hill"));
    assert_eq!(room.geometry.items().len(), 1);
    assert_eq!(room.geometry.name(enfilade::ItemIndex(0)), "block 0 0");
    assert_eq!(room.geometry.triangle_count(), 4);
    assert_eq!(room.geometry.bounds().max, [20.0, 600.0, 20.0]);
}

#[test]
fn heights_are_in_the_file_named_or_the_only_one_called_so() {
    let mut named = description();
    named["file"] = json!("other.bin");
    let text = named.to_string();
    let folder = written(&[
        ("hill.json", text.as_bytes()),
        ("other.bin", &heights()),
        ("hill.raw", b""),
    ]);
    assert!(read(&folder.path().join("hill.json"), &ReadOptions::default()).is_ok());
    let text = description().to_string();
    let folder = written(&[
        ("hill.json", text.as_bytes()),
        ("hill_u16le.RAW", &heights()),
        ("valley.raw", b""),
    ]);
    assert!(read(&folder.path().join("hill.json"), &ReadOptions::default()).is_ok());
}

#[test]
fn a_file_of_heights_that_is_not_there_or_not_the_only_one_is_asked_for() {
    assert_eq!(
        refusal(&description(), &[("valley.raw", &heights())]),
        "hill.json: describes heights in a file `hill.raw` beside it, but there is none; name one as \"file\""
    );
    assert_eq!(
        refusal(
            &description(),
            &[("hill_a.raw", &heights()), ("hill_b.raw", &heights())]
        ),
        "hill.json: describes heights in a file `hill.raw` beside it, but there are hill_a.raw and hill_b.raw; name one as \
         \"file\""
    );
    let mut named = description();
    for elsewhere in [
        "../hill.raw",
        "/etc/passwd",
        "C:hill.raw",
        "a\\hill.raw",
        "",
        "..",
    ] {
        named["file"] = json!(elsewhere);
        let said = refusal(&named, &[]);
        assert!(
            said.contains("which is not in the same folder"),
            "{elsewhere}: {said}"
        );
    }
    named["file"] = json!("gone.raw");
    let said = refusal(&named, &[]);
    assert!(
        said.contains("has its heights in gone.raw, which cannot be read"),
        "{said}"
    );
    let text = description().to_string();
    let said = read_bytes(text.as_bytes(), None, &ReadOptions::default()).expect_err("no folder");
    assert!(said.to_string().contains("no folder was given"), "{said}");
}

#[test]
fn too_few_heights_and_too_many_are_told_apart_from_holes() {
    assert_eq!(
        refusal(&description(), &[("hill.raw", &heights()[1..])]),
        "hill.json: has 3 x 2 heights in hill.raw, which must have 12 bytes, but has 11; copy it again, or correct width and height"
    );
    let mut huge = description();
    huge["width"] = json!(u32::MAX);
    huge["height"] = json!(u32::MAX);
    let said = refusal(&huge, &[("hill.raw", &heights())]);
    assert!(
        said.contains("36893488130239234050 bytes") || said.contains("must have"),
        "{said}"
    );
    let mut holes = description();
    holes["noData"] = json!(600);
    assert_eq!(
        refusal(&holes, &[("hill.raw", &heights())]),
        "hill.json: has no height at column 2, row 1, which holds the noData value 600.0; fill the hole, or split the \
         terrain around it"
    );
}

#[test]
fn a_description_that_lacks_something_says_what_it_needs() {
    let files: &[(&str, &[u8])] = &[("hill.raw", &heights())];
    for key in ["height", "format", "cellMetresX", "cellMetresZ"] {
        let mut lacking = description();
        lacking.as_object_mut().expect("an object").remove(key);
        let said = refusal(&lacking, files);
        assert!(said.contains(&format!("missing field `{key}`")), "{said}");
        assert!(said.contains("it needs width, height, format"), "{said}");
    }
    for format in [
        "f64 little endian",
        "f32",
        "u16",
        "f32 u16 big",
        "u16 little big",
        "i16 little endian",
    ] {
        let mut other = description();
        other["format"] = json!(format);
        let said = refusal(&other, files);
        assert!(
            said.contains(&format!("in the unknown format `{format}`")),
            "{said}"
        );
    }
    let mut flat = description();
    flat["cellMetresX"] = json!(0.0);
    let said = refusal(&flat, files);
    assert!(
        said.contains("is not a valid terrain: cells are 0 long"),
        "{said}"
    );
    let mut line = description();
    line["width"] = json!(1);
    line["height"] = json!(6);
    let said = refusal(&line, files);
    assert!(said.contains("2 to 65537 samples along each side"), "{said}");
}

/// 50 heights from west to east in 40 rows, as numbers of 32 bits with a fraction.
fn rolling() -> (Value, Vec<u8>) {
    let mut description = description();
    description["width"] = json!(50);
    description["height"] = json!(40);
    description["format"] = json!("f32 little endian");
    let heights = (0..50 * 40_u32).flat_map(|at| ((at * 7 % 11) as f32 - 0.5).to_le_bytes());
    (description, heights.collect())
}

const LITTLE: ReadOptions = ReadOptions {
    limit_bytes: 20_000,
    flat: false,
    skip_bad_portals: false,
    scene: None,
    lenient: false,
    textures: true,
};

#[test]
fn what_takes_more_as_meshes_than_allowed_stays_in_its_file_and_is_the_same_ground() {
    let (mut description, heights) = rolling();
    for diagonal in ["north-east", "north-west"] {
        description["diagonal"] = json!(diagonal);
        let text = description.to_string();
        let folder = written(&[("hill.json", text.as_bytes()), ("hill.raw", &heights)]);
        let path = folder.path().join("hill.json");
        let [small, large] =
            [ReadOptions::default(), LITTLE].map(|options| read(&path, &options).expect("sound terrain"));
        assert!(small.rooms[0].large.is_none());
        assert!(large.rooms[0].large.is_some() && large.rooms[0].geometry.items().is_empty());
        let [small, large] = [small, large].map(|import| {
            let scene = import.scene(Method::FloatingHorizon, Method::DEFAULT_LIMIT);
            scene.expect("one room")
        });
        assert_eq!(large.sector_name(SectorId(0)), "hill");
        assert_eq!((large.item_count(), large.triangle_count()), (4, 2 * 49 * 39));
        assert_eq!(large.bounds(SectorId(0)), small.bounds(SectorId(0)));
        assert!(large.bytes() < 16_000, "{}", large.bytes());
        for at in 0..50 {
            let ray = Ray {
                origin: [3.7 + 9.1 * at as f32, 100.0, 11.3 + 14.9 * at as f32],
                direction: [0.1, -1.0, 0.03],
            };
            let [small, large] = [&small, &large].map(|scene| scene.sector(SectorId(0)).cast(&ray));
            let [small, large] = [small, large].map(|hit| hit.map(|hit| (hit.item, hit.distance)));
            assert_eq!(small, large, "{ray:?}");
        }
    }
}

#[test]
fn holes_are_told_by_their_place_wherever_heights_stay() {
    let (mut description, mut heights) = rolling();
    description["noData"] = json!(-9999);
    let mut said = |height: f32| {
        heights[4 * (33 * 50 + 7)..][..4].copy_from_slice(&height.to_le_bytes());
        let text = description.to_string();
        let folder = written(&[("hill.json", text.as_bytes()), ("hill.raw", &heights)]);
        [ReadOptions::default(), LITTLE].map(|options| {
            let refused = read(&folder.path().join("hill.json"), &options).expect_err("a hole");
            refused.to_string()
        })
    };
    for said in said(-9999.0) {
        assert!(
            said.contains("has no height at column 7, row 33, which holds the noData value -9999.0;"),
            "{said}"
        );
    }
    for said in said(f32::NAN) {
        assert!(
            said.contains("is not a valid terrain: the height at column 7, row 33 is NaN"),
            "{said}"
        );
    }
}

#[test]
fn heights_with_a_fraction_are_read_whichever_byte_comes_first() {
    let numbers = [1.25_f32, -2.0, 3.0, 4.0, 5.0, 600.5];
    let [little, big] = [f32::to_le_bytes, f32::to_be_bytes].map(|bytes| numbers.map(bytes).concat());
    for (format, bytes) in [("f32 little endian, metres", little), ("float32 big-endian", big)] {
        let mut description = description();
        description["format"] = json!(format);
        let text = description.to_string();
        let folder = written(&[("hill.json", text.as_bytes()), ("hill.raw", &bytes)]);
        let bounds = read(&folder.path().join("hill.json"), &ReadOptions::default());
        let bounds = bounds.expect("sound terrain").rooms[0].geometry.bounds();
        assert_eq!([bounds.min[1], bounds.max[1]], [-2.0, 600.5], "{format}");
    }
}

#[test]
fn a_description_says_by_which_method_its_terrain_is_seen() {
    let text = description().to_string();
    let folder = written(&[("hill.json", text.as_bytes()), ("hill.raw", &heights())]);
    let path = folder.path().join("hill.json");
    let method = |path: &Path| {
        let import = read(path, &ReadOptions::default()).expect("sound terrain");
        import.rooms[0].method
    };
    assert_eq!(method(&path), None);
    let copy = with_methods(&path, &[Method::FloatingHorizon], 1 << 20).expect("it has a place for it");
    let beside = folder.path().join("hill-pinned.json");
    fs::write(&beside, copy).expect("a file");
    fs::write(folder.path().join("hill-pinned.raw"), heights()).expect("a file");
    assert_eq!(method(&beside), Some(Method::FloatingHorizon));
    let mut description = description();
    description["method"] = json!("magic");
    let why = refusal(&description, &[("hill.raw", &heights())]);
    assert!(
        why.contains("has the unknown method `magic`; methods are painter-min"),
        "{why}"
    );
}
