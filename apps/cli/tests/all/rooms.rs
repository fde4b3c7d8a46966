//! `rooms`: rooms, doors and floor plans.

use crate::support::{Folder, document, glb};
use enfilade_bake::{DoorKind, RoomGraph};
use serde_json::json;

fn text(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).expect("text")
}

#[test]
fn the_rooms_of_a_house_are_printed_written_and_drawn() {
    let folder = Folder::empty();
    let run = folder.run("rooms @house --flat -o rooms.json --html plan.html --json report.json");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(
        run.stdout.starts_with("@house: 11 rooms on 1 storey"),
        "{}",
        run.stdout
    );
    let rooms = RoomGraph::from_json(&text(&folder, "rooms.json")).expect("a graph");
    assert_eq!(rooms.rooms().len(), 12);
    assert!(rooms.doors().iter().any(|door| door.kind == DoorKind::Opening));
    let report: serde_json::Value = serde_json::from_str(&text(&folder, "report.json")).expect("JSON");
    assert_eq!(report["rooms"].as_array().map(Vec::len), Some(12));
    let page = text(&folder, "plan.html");
    assert_eq!(page.matches("<svg ").count(), 1);
    for room in rooms.rooms().iter().filter(|room| room.name != "outside") {
        assert!(page.contains(&format!("<title>{}: ", room.name)), "{}", room.name);
    }
}

#[test]
fn marked_rooms_win_over_found_ones() {
    let folder = Folder::empty();
    let run = folder.run("rooms @house");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("\n  house ") && run.stdout.contains("\n  annex "),
        "{}",
        run.stdout
    );
}

#[test]
fn names_of_rooms_are_no_markup() {
    let folder = Folder::empty();
    let box_of = |name: &str, scale: [f32; 3], x: f32| json!({ "name": name, "mesh": 0, "translation": [x, 1.5, 0.0], "scale": scale });
    // Two closed boxes, each a marked room.
    let nodes = [
        box_of("one", [4.0, 3.0, 4.0], 0.0),
        box_of("other", [4.0, 3.0, 4.0], 9.0),
        json!({ "name": "<script>&'\"x-room", "children": [0] }),
        json!({ "name": "plain-room", "children": [1] }),
    ];
    let mut scene = document(&nodes, json!([]));
    scene["scenes"] = json!([{ "nodes": [2, 3] }]);
    folder.add("scene.glb", glb(&scene));
    let run = folder.run("rooms scene.glb --html plan.html");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let page = text(&folder, "plan.html");
    assert!(
        page.contains("&lt;script&gt;&amp;&#39;&quot;x") && !page.contains("<script"),
        "{page}"
    );
}

#[test]
fn what_is_wrong_is_said_and_nothing_is_written() {
    let folder = Folder::new();
    let before = folder.names();
    for (arguments, words) in [
        ("rooms scene.glb -o scene.glb", "scene.glb"),
        ("rooms scene.glb -o a.json --html a.json", "a.json"),
        ("rooms scene.glb --scale 0 -o a.json", "metres above 0"),
        ("rooms scene.glb --voxel x -o a.json", "metres above 0"),
        ("rooms scene.glb --up w -o a.json", "possible values: x, y, z"),
        ("rooms missing.glb -o a.json", "missing.glb"),
        ("rooms scene.glb --htlm a.html", "--html"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains(words), "{arguments}: {}", run.stderr);
        assert_eq!(folder.names(), before, "{arguments}");
    }
}
