//! Heightmaps work with every verb that reads a scene.

use crate::support::Folder;
use serde_json::json;

/// 70 x 40 heights, 10 metres apart: a ridge from north to south occludes everything east of it from the west.
fn valley() -> Folder {
    let folder = Folder::new();
    let description = json!({
        "width": 70, "height": 40, "format": "u16 little endian", "cellMetresX": 10.0, "cellMetresZ": 10.0
    });
    folder.add("valley.json", description.to_string());
    let mut heights = Vec::new();
    for row in 0..40_u16 {
        for column in 0..70_u16 {
            let ridge = 150_u16.saturating_sub(30 * column.abs_diff(30));
            heights.extend((ridge + (column * 7 + row * 5) % 4).to_le_bytes());
        }
    }
    std::fs::write(folder.path("valley.raw"), heights).expect("a file");
    folder
}

const FROM_THE_WEST: &str = "--eye 40,12,200 --toward 400,12,200 --size 64x36";

#[test]
fn info_says_what_is_in_a_field_of_heights() {
    let info = valley().json("info valley.json");
    assert_eq!(info["format"], "heightmap with a description");
    assert_eq!(info["items"], 6, "blocks of 32 by 32 cells");
    assert_eq!(info["triangles_drawn"], 2 * 69 * 39);
}

#[test]
fn a_ridge_hides_what_is_behind_it_by_every_method() {
    let folder = valley();
    let report = folder.json(&format!("look valley.json {FROM_THE_WEST} --method all --check"));
    let mut seen_by = Vec::new();
    for method in report["methods"].as_array().expect("a list") {
        let [missed, different] = ["missed", "pixels_different"].map(|key| &method["summary"][key]);
        seen_by.push(method["method"].clone());
        assert!(
            (missed == 0 && different == 0) || method["contract"] == "approximate",
            "{method}"
        );
    }
    assert!(seen_by.contains(&json!("floating-horizon")), "{seen_by:?}");
    let seen = folder.json(&format!("look valley.json {FROM_THE_WEST}"));
    let visible = seen["views"][0]["visible"].as_array().expect("a list");
    assert!(visible.contains(&json!("block 0 0")), "{visible:?}");
    assert!(!visible.contains(&json!("block 0 2")), "{visible:?}");
}

#[test]
fn heights_that_lack_their_file_are_told_where_it_should_be() {
    let folder = valley();
    std::fs::remove_file(folder.path("valley.raw")).expect("it is there");
    for verb in ["info", "look", "draw -o a.png"] {
        let run = folder.run(&format!("{verb} valley.json"));
        assert_eq!(run.code, Some(2), "{verb}: {}", run.stderr);
        let says = "valley.json: describes heights in a file `valley.raw` beside it, but there is none";
        assert!(run.stderr.contains(says), "{verb}: {}", run.stderr);
    }
}

/// Too little memory for the valley as meshes.
const LITTLE: &str = "--memory 100kB";

#[test]
fn terrain_larger_than_memory_stays_in_its_file_and_is_seen_as_if_it_did_not() {
    let folder = valley();
    let info = folder.json(&format!("info valley.json {LITTLE}"));
    assert_eq!((&info["items"], &info["meshes"]), (&json!(6), &json!(0)));
    assert_eq!(info["triangles_drawn"], 2 * 69 * 39);
    assert_eq!(info["sectors"][0]["triangles"], 2 * 69 * 39);
    for method in ["", "--method floating-horizon"] {
        let [small, large] = [LITTLE, ""]
            .map(|memory| folder.json(&format!("look valley.json {FROM_THE_WEST} {memory} {method}")));
        for key in ["items_visible", "items_in_frustum", "visible"] {
            assert_eq!(small["views"][0][key], large["views"][0][key], "{key}");
        }
        assert_eq!(small["contract"], "exact");
    }
    folder.json(&format!("draw valley.json {FROM_THE_WEST} {LITTLE} -o a.png"));
    assert!(folder.names().contains(&"a.png".to_owned()));
    // The survey finds no position, so the view is from outside.
    assert_eq!(
        folder
            .run(&format!("look valley.json {LITTLE} --size 64x36"))
            .code,
        Some(0)
    );
}

#[test]
fn what_terrain_in_its_file_cannot_do_is_said_with_a_way_out() {
    let folder = valley();
    let says = |line: &str, words: &str| {
        let run = folder.run(line);
        assert_eq!(run.code, Some(2), "{line}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    };
    let alone = "does not fit in --memory needs floating-horizon; use that --method, or raise --memory";
    says(
        &format!("look valley.json {FROM_THE_WEST} {LITTLE} --method bsp"),
        alone,
    );
    says(&format!("choose valley.json {LITTLE}"), alone);
    says(
        &format!("look valley.json {FROM_THE_WEST} {LITTLE} --check"),
        "the reference needs terrain as meshes",
    );
    let all = folder.json(&format!("look valley.json {FROM_THE_WEST} {LITTLE} --method all"));
    let seen = all["methods"].as_array().expect("a list");
    assert_eq!(seen.len(), 1);
    assert_eq!(seen[0]["method"], "floating-horizon");
    let text = std::fs::read_to_string(folder.path("valley.json")).expect("text");
    folder.add(
        "pinned.json",
        text.replacen('{', "{\"method\": \"bsp\", \"file\": \"valley.raw\",", 1),
    );
    says(&format!("look pinned.json {FROM_THE_WEST} {LITTLE}"), alone);
}
