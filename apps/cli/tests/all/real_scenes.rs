//! Real scenes, from the folder in the environment variable `ENFILADE_SCENES`.

use crate::support::Folder;
use std::path::Path;

/// Asserts that no method has a false cull or a wrong pixel, except approximate ones.
fn agrees_with_the_reference(name: &str) {
    let scenes = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    // Relative to the workspace, where the variable is set, not to this package, where tests run.
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(scenes);
    let file = scenes
        .join(name)
        .canonicalize()
        .unwrap_or_else(|error| panic!("{name} in ENFILADE_SCENES: {error}"));
    let report = Folder::new().json(&format!(
        "look {} --size 160x90 --survey 2 --method all --check",
        file.display()
    ));
    let methods = report["methods"].as_array().expect("a list");
    assert!(!methods.is_empty());
    for method in methods {
        let seen = method["summary"]["items_visible_mean"]
            .as_f64()
            .expect("a number");
        assert!(seen > 0.0, "{}: nothing is seen", method["method"]);
        if method["contract"] != "approximate" {
            assert_eq!(method["summary"]["missed"], 0, "{}", method["method"]);
            assert_eq!(method["summary"]["pixels_different"], 0, "{}", method["method"]);
        }
    }
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn the_smallest_building_is_seen_rightly() {
    agrees_with_the_reference("ifc_fzk_haus.glb");
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn a_house_of_two_is_seen_rightly() {
    agrees_with_the_reference("ifc_duplex.glb");
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn a_county_of_hills_is_seen_rightly() {
    agrees_with_the_reference("terrain_jacksboro.json");
}

/// A villa with authored rooms and portals, from its four cameras.
#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn a_villa_is_seen_rightly_through_its_portals_and_as_one_room() {
    let scenes = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(scenes);
    let file = scenes
        .join("blender_villa.glb")
        .canonicalize()
        .expect("the villa");
    let truth = std::fs::read(scenes.join("blender_villa.truth.json")).expect("the truth");
    let truth: serde_json::Value = serde_json::from_slice(&truth).expect("JSON");
    let folder = Folder::new();
    let cameras = truth["cameras"].as_array().expect("a list");
    let path: String = cameras
        .iter()
        .map(|camera| {
            let (eye, toward, fov) = (&camera["eye"], &camera["toward"], &camera["yfov_deg"]);
            format!("{{\"eye\": {eye}, \"toward\": {toward}, \"fov\": {fov}}}\n")
        })
        .collect();
    folder.add("villa.jsonl", path);
    for (flat, sectors, portals) in [("", 9, 43), ("--flat", 1, 0)] {
        let look = folder.json(&format!(
            "look {} --path villa.jsonl --size 320x180 --check {flat}",
            file.display()
        ));
        assert_eq!(look["scene"]["sectors"], sectors);
        assert_eq!(look["scene"]["portals"], portals);
        assert_eq!(look["summary"]["missed"], 0, "{flat}");
        assert_eq!(look["summary"]["pixels_different"], 0, "{flat}");
        if flat.is_empty() {
            continue;
        }
        for (view, camera) in look["views"].as_array().expect("a list").iter().zip(cameras) {
            let visible: Vec<&str> = (view["visible"].as_array().expect("a list").iter())
                .filter_map(|name| name.as_str())
                .collect();
            // Items that another renderer shows in more than a few pixels; smaller ones may fall between our samples.
            for (name, pixels) in camera["visible_flat"].as_object().expect("names") {
                // Blocks of terrain are items, named with their row and column.
                let is_seen = visible
                    .iter()
                    .any(|seen| seen.split(['#', ' ']).next() == Some(name));
                assert!(
                    is_seen || name == "sky" || pixels.as_u64() < Some(60),
                    "{name} from {}",
                    camera["name"]
                );
            }
        }
    }
}
