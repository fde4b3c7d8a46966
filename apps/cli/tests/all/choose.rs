//! `choose`: chooses methods by measuring, and pins them.

use crate::support::Folder;
use serde_json::{Value, json};

fn methods(report: &Value) -> Vec<&str> {
    let choices = report["choices"].as_array().expect("a list");
    choices
        .iter()
        .map(|choice| choice["method"].as_str().expect("a name"))
        .collect()
}

#[test]
fn choose_says_what_every_method_costs_and_takes_the_cheapest() {
    let folder = Folder::new();
    let report = folder.json("choose @two-rooms --size 64x36 --check");
    let choices = report["choices"].as_array().expect("a list");
    assert_eq!(choices.len(), 2);
    for choice in choices {
        let trials = choice["trials"].as_array().expect("a list");
        assert_eq!(trials.len(), 14, "every method is there");
        let frame = |trial: &Value| trial["frame_ms"].as_f64();
        let best = trials.iter().filter_map(frame).fold(f64::INFINITY, f64::min);
        let chosen = trials.iter().find(|trial| trial["method"] == choice["method"]);
        let chosen = frame(chosen.expect("it is among them")).expect("it was tried");
        let is_sure = choice["sure"].as_bool().expect("a truth value");
        // A method within 8 % of the fastest counts as equally fast; an unsure choice is the default method.
        assert!(
            !is_sure || chosen <= 1.09 * best,
            "{chosen} ms, but the best takes {best} ms"
        );
        assert!(
            trials
                .iter()
                .all(|trial| frame(trial).is_some() || trial["why"].is_string())
        );
    }
    assert_eq!(
        report["held_back"]["sectors"].as_array().expect("a list").len(),
        2
    );
    let text = folder.run("choose @two-rooms --size 64x36").stdout;
    assert!(
        text.contains("not measured: masked, svbsp, mobsp, pvs: sets that may contain hidden items"),
        "{text}"
    );
}

#[test]
fn what_auto_sees_is_what_is_seen_and_the_report_says_by_what() {
    let folder = Folder::new();
    let own = folder.json("look @two-rooms --size 64x36");
    let auto = folder.json("look @two-rooms --size 64x36 --method auto --check");
    assert_eq!(
        (&auto["method"], &auto["contract"]),
        (&json!("auto"), &json!("exact"))
    );
    assert_eq!(auto["views"][0]["visible"], own["views"][0]["visible"]);
    assert_eq!(auto["summary"]["missed"], 0);
    assert_eq!(auto["summary"]["pixels_different"], 0);
    assert_eq!(methods(&auto).len(), 2);
    assert!(own.get("choices").is_none(), "nothing was chosen");
    let text = folder.run("look @two-rooms --size 64x36 --method auto").stdout;
    assert!(text.contains("chosen: ") && text.contains(" in "), "{text}");
    let [first, second] = ["auto", "z-buffer"].map(|method| {
        folder.run(&format!(
            "draw @two-rooms --size 64x36 --method {method} -o {method}.png"
        ));
        std::fs::read(folder.path(&format!("{method}.png"))).expect("a picture")
    });
    assert!(first == second, "the picture does not depend on the choice");
}

#[test]
fn methods_are_pinned_in_a_copy_and_the_copy_is_seen_by_them() {
    let folder = Folder::new();
    let run = folder.run("choose scene.glb -o pinned.glb --size 64x36 --json choices.json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let report: Value =
        serde_json::from_slice(&std::fs::read(folder.path("choices.json")).expect("a file")).expect("JSON");
    let info = folder.json("info pinned.glb");
    let sectors = info["sectors"].as_array().expect("a list");
    let pinned: Vec<&str> = sectors
        .iter()
        .map(|one| one["method"].as_str().expect("a name"))
        .collect();
    assert_eq!(pinned, methods(&report));
    let [plain, copy] = ["scene.glb", "pinned.glb"].map(|file| {
        let report = folder.json(&format!("look {file} --path views.jsonl --size 64x36"));
        report["views"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|view| view["visible"].clone())
            .collect::<Vec<_>>()
    });
    assert_eq!(plain, copy);
}

#[test]
fn what_cannot_be_pinned_is_told_before_anything_is_measured() {
    let folder = Folder::new();
    folder.add("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    std::fs::create_dir(folder.path("elsewhere")).expect("a folder");
    folder.add("b.gltf", r#"{"asset":{"version":"2.0"}}"#);
    for (arguments, message) in [
        (
            "choose @two-rooms -o a.glb",
            "cannot be written into a built-in scene",
        ),
        (
            "choose a.obj -o b.obj --size 8x8",
            "methods cannot be stored in an OBJ file or a map",
        ),
        (
            "choose b.gltf -o elsewhere/b.gltf",
            "write the copy to that folder",
        ),
        (
            "choose scene.glb --moving nowhere --size 8x8",
            "no sector `nowhere`",
        ),
        ("choose scene.glb --aim both", "look, draw"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stderr);
        assert!(run.stderr.contains(message), "{arguments}: {}", run.stderr);
    }
}
