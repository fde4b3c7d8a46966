//! Real scenes, where they are: the folder that the environment variable `ENFILADE_SCENES` names.

mod support;

use std::path::Path;
use support::Folder;

/// Every method but the approximate ones misses nothing and paints nothing wrong.
#[expect(clippy::print_stdout, reason = "a test that is skipped says so")]
fn held_against_the_reference(name: &str) {
    let Some(scenes) = std::env::var_os("ENFILADE_SCENES") else {
        println!("skipped: {name} is not looked at, for ENFILADE_SCENES names no folder of scenes");
        return;
    };
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
fn the_smallest_building_is_seen_rightly() {
    held_against_the_reference("ifc_fzk_haus.glb");
}

#[test]
fn a_house_of_two_is_seen_rightly() {
    held_against_the_reference("ifc_duplex.glb");
}
