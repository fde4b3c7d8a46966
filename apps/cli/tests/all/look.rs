//! `look` and `info`: what they report.

use crate::support::{Folder, document, glb, yard};
use enfilade::Method;
use serde_json::{Value, json};

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .expect("an object")
        .keys()
        .map(String::as_str)
        .collect()
}

#[test]
fn the_report_has_its_stable_shape() {
    let report = Folder::new().json("look scene.glb --size 160x90 --check");
    let top = [
        "build_ms",
        "bytes",
        "contract",
        "depth",
        "faces_built",
        "method",
        "scene",
        "simd",
        "size",
        "splits",
        "stats",
        "summary",
        "threads",
        "views",
    ];
    assert_eq!(keys(&report), top);
    assert_eq!(
        report["scene"],
        json!({ "file": "scene.glb", "items": 4, "triangles": 48, "sectors": 1, "portals": 0 })
    );
    assert_eq!(report["method"], "own");
    assert_eq!(report["contract"], "exact");
    assert_eq!(report["size"], json!([160, 90]));
    let view = [
        "check",
        "complete",
        "eye",
        "fov",
        "items_in_frustum",
        "items_visible",
        "ms",
        "passages",
        "through",
        "toward",
        "triangles_in_frustum",
        "triangles_visible",
        "up",
        "visible",
        "visible_items",
    ];
    assert_eq!(keys(&report["views"][0]), view);
    assert_eq!(
        report["views"][0]["through"],
        json!([{ "sector": "scene", "crossings": 0, "contract": "exact", "items_visible": 3 }])
    );
    assert_eq!(
        keys(&report["views"][0]["check"]),
        [
            "certain",
            "contested",
            "extra",
            "missed",
            "pixels_contested",
            "pixels_different",
            "reference_visible"
        ]
    );
    let summary = [
        "certain",
        "items_in_frustum_mean",
        "items_visible_mean",
        "missed",
        "ms_median",
        "ms_p99",
        "pixels_different",
        "views",
    ];
    assert_eq!(keys(&report["summary"]), summary);
}

#[test]
fn a_wall_hides_what_is_behind_it() {
    let folder = Folder::new();
    for (camera, seen) in [
        ("front", ["floor", "wall", "table"]),
        ("back", ["floor", "wall", "chest"]),
    ] {
        let report = folder.json(&format!("look scene.glb --camera {camera} --size 160x90 --check"));
        let view = &report["views"][0];
        assert_eq!(view["visible"], json!(seen));
        assert_eq!(view["items_visible"], 3);
        assert_eq!(view["items_in_frustum"], 4);
        assert_eq!(view["check"]["reference_visible"], 3);
        assert_eq!(view["check"]["missed"], json!([]));
    }
}

#[test]
fn without_occluders_trees_leave_out_only_what_is_out_of_view() {
    let folder = Folder::new();
    for method in ["masked", "svbsp", "mobsp"] {
        let report = folder.json(&format!(
            "look scene.glb --camera front --size 160x90 --check --occluders 0 --method {method}"
        ));
        let view = &report["views"][0];
        assert_eq!(report["stats"]["occluders"], 0, "{method}");
        // `masked` also rasterizes the visible items it meets.
        if method != "masked" {
            assert_eq!(view["items_visible"], view["items_in_frustum"], "{method}");
        }
        assert_eq!(view["check"]["missed"], json!([]), "{method}");
    }
    let report =
        folder.json("look scene.glb --camera front --size 160x90 --occluders 0 --method hierarchical-z");
    assert_eq!(report["views"][0]["items_visible"], 3, "it chooses none anyway");
}

#[test]
fn all_methods_see_the_same() {
    let folder = Folder::new();
    let report = folder.json("look scene.glb --path views.jsonl --size 160x90 --method all --check");
    assert_eq!(keys(&report), ["methods", "skipped"]);
    let methods = report["methods"].as_array().expect("a list");
    let names: Vec<&Value> = methods.iter().map(|method| &method["method"]).collect();
    let suited = Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none());
    assert_eq!(names, suited.map(Method::name).collect::<Vec<_>>());
    assert_eq!(report["skipped"][0]["method"], "pvs");
    for method in methods
        .iter()
        .filter(|method| method["contract"] != "approximate")
    {
        assert_eq!(method["summary"]["views"], 2);
        assert_eq!(method["summary"]["items_visible_mean"], 3.0);
        assert_eq!(
            (
                &method["summary"]["missed"],
                &method["summary"]["pixels_different"]
            ),
            (&json!(0), &json!(0))
        );
    }
}

#[test]
fn a_method_that_needs_too_much_is_skipped_where_all_were_asked_for() {
    let report = Folder::new().json("look @enfilade --memory 1 --method all --size 16x9");
    assert_eq!(report["methods"], json!([]));
    assert_eq!(report["skipped"][0]["method"], Method::ALL[0].name());
    assert!(
        report["skipped"][1]["why"]
            .as_str()
            .expect("a reason")
            .contains("above the limit of 1 byte")
    );
}

#[test]
fn a_convex_scene_is_seen_as_one_and_another_is_told_what_stands_in_the_way() {
    let folder = Folder::new();
    let block = json!({ "name": "block", "mesh": 0 });
    folder.add("block.glb", glb(&document(&[block], json!([]))));
    let report = folder.json("look block.glb --method cell --eye 2,1,3 --toward 0,0,0 --size 96x54 --check");
    assert_eq!([&report["method"], &report["contract"]], ["cell", "exact"]);
    assert_eq!(report["summary"]["items_visible_mean"], 1.0);
    assert_eq!(report["summary"]["pixels_different"], 0);
    let run = folder.run("look scene.glb --method cell");
    assert_eq!(run.code, Some(2));
    for word in [
        "scene.glb: method cell needs a convex sector",
        "`floor`",
        "use hierarchical-z",
    ] {
        assert!(run.stderr.contains(word), "{}", run.stderr);
    }
    let report = folder.json("look scene.glb --method all --size 16x9");
    let skipped = &report["skipped"][1];
    assert_eq!(skipped["method"], "cell");
    assert!(
        skipped["why"]
            .as_str()
            .expect("a reason")
            .starts_with("method cell needs a convex sector")
    );
    // The same for a room of a file that names its method.
    let mut room = yard();
    let marked = json!({ "name": "yard", "children": [0, 1, 2, 3], "extras": { "enfilade": { "kind": "room", "method": "cell" } } });
    room["nodes"].as_array_mut().expect("nodes").push(marked);
    room["scenes"][0]["nodes"] = json!([4, 5, 6, 7]);
    folder.add("room.glb", glb(&room));
    let run = folder.run("look room.glb");
    assert_eq!(run.code, Some(2));
    for word in [
        "room.glb: sector `yard`: method cell needs a convex sector",
        "--method overrides the method in the file",
    ] {
        assert!(run.stderr.contains(word), "{}", run.stderr);
    }
}

#[test]
fn cells_computed_ahead_are_gone_by_where_there_are_some_and_asked_for_where_not() {
    let folder = Folder::new();
    let report = folder.json("look @house --method pvs --size 96x54 --survey 4 --check=2");
    assert_eq!([&report["method"], &report["contract"]], ["pvs", "strict"]);
    assert_eq!(report["summary"]["missed"], 0);
    let run = folder.run("look scene.glb --method pvs");
    assert_eq!(run.code, Some(2));
    for word in ["scene.glb: method pvs needs a baked PVS", "use hierarchical-z"] {
        assert!(run.stderr.contains(word), "{}", run.stderr);
    }
    let report = folder.json("look scene.glb --method all --size 16x9");
    let skipped = &report["skipped"][0];
    assert_eq!(skipped["method"], "pvs");
    assert!(
        skipped["why"]
            .as_str()
            .expect("a reason")
            .starts_with("method pvs needs a baked PVS")
    );
}

#[test]
fn cameras_come_from_the_file_the_path_the_survey_or_the_command_line() {
    let folder = Folder::new();
    let view = |arguments: &str| {
        folder.json(&format!("look scene.glb --size 32x18 {arguments}"))["views"][0].clone()
    };
    let first = view("");
    assert_eq!(first["eye"], json!([0.0, 1.2, 6.0]), "the file's first camera");
    assert_eq!(first["fov"], 51.5662);
    assert_eq!(view("--camera back")["eye"], json!([0.0, 1.2, -6.0]));
    assert_eq!(view("--camera back --fov 40")["fov"], 40.0);
    let given = view("--eye -1,2,3 --toward 0,0,-.5 --up 0,0,1");
    assert_eq!(
        (&given["eye"], &given["up"]),
        (&json!([-1.0, 2.0, 3.0]), &json!([0.0, 0.0, 1.0]))
    );
    assert_eq!(given["fov"], 60.0);
    assert_eq!(given["parallel"], json!(null));
    let plan = view("--eye 0,9,0 --toward 0,0,0 --up 0,0,-1 --parallel 12 --check");
    assert_eq!((&plan["parallel"], &plan["fov"]), (&json!(12.0), &json!(0.0)));
    let path = folder.json("look scene.glb --size 32x18 --path views.jsonl --fov 70");
    assert_eq!(
        (&path["views"][0]["fov"], &path["views"][1]["fov"]),
        (&json!(70.0), &json!(50.0))
    );
    let survey = || folder.json("look scene.glb --size 32x18 --survey 3")["views"].clone();
    let places = |views: Value| -> Vec<Value> { (0..3).map(|i| views[i]["eye"].clone()).collect() };
    assert_eq!(places(survey()), places(survey()));
}

#[test]
fn threads_and_coherence_do_not_change_what_is_seen() {
    let folder = Folder::new();
    let seen = |options: &str| {
        let report = folder.json(&format!("look @enfilade --size 160x90 --survey 2 {options}"));
        (0..2)
            .map(|i| report["views"][i]["visible"].clone())
            .collect::<Vec<_>>()
    };
    let plain = seen("");
    assert!(
        plain
            .iter()
            .any(|visible| visible.as_array().is_some_and(|items| !items.is_empty()))
    );
    for options in [
        "--threads 1",
        "--threads 3",
        "--no-coherence",
        "--method z-buffer",
    ] {
        assert_eq!(seen(options), plain, "{options}");
    }
    assert_eq!(
        folder.json("look @enfilade --size 16x9 --threads 3")["threads"],
        3
    );
}

#[test]
fn flat_follows_no_portal() {
    let folder = Folder::new();
    let passages = |options: &str| {
        folder.json(&format!("look @enfilade --size 160x90 {options}"))["views"][0]["passages"].clone()
    };
    assert_eq!(passages("--flat"), 1);
    assert!(passages("").as_u64() > Some(1));
}

#[test]
fn names_are_unique() {
    let report = Folder::new().json("look @enfilade --size 160x90");
    let mut names: Vec<&str> = report["views"][0]["visible"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert!(count > 0);
    assert_eq!(names.len(), count);
}

#[test]
fn a_report_in_a_file_leaves_the_text_for_people() {
    let folder = Folder::new();
    let run = folder.run("look scene.glb --size 160x90 --check --json look.json");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    assert!(
        run.stdout.contains("visible: floor, wall, table\n"),
        "{}",
        run.stdout
    );
    assert!(
        run.stdout.contains("check: 0 missed of 3 certainly visible"),
        "{}",
        run.stdout
    );
    let report: Value =
        serde_json::from_slice(&std::fs::read(folder.path("look.json")).expect("there")).expect("JSON");
    assert_eq!(report["views"][0]["items_visible"], 3);
}

#[test]
fn info_says_what_is_in_a_file() {
    let folder = Folder::new();
    let info = folder.json("info scene.glb");
    for (key, value) in [
        ("format", json!("glTF 2.0, binary")),
        ("items", json!(4)),
        ("meshes", json!(1)),
        ("triangles_unique", json!(12)),
        ("triangles_drawn", json!(48)),
        ("portals", json!(0)),
        ("warnings", json!([])),
    ] {
        assert_eq!(info[key], value, "{key}");
    }
    assert_eq!(info["cameras"][1]["name"], "back");
    assert_eq!(info["sectors"][0]["method"], "hierarchical-z");
    assert_eq!(info["bounds"]["min"], json!([-10.0, -0.2, -10.0]));
    let text = folder.run("info scene.glb").stdout;
    assert!(
        text.contains("48 drawn, 12 unique") && text.contains("front: from"),
        "{text}"
    );
    assert!(folder.json("info @enfilade")["openings"].as_u64() > Some(0));
    // Six sides of a box, two triangles each.
    let occluders = &info["occluders"];
    let counts = ["polygons", "polygons_placed", "triangles_merged", "area_share"].map(|key| &occluders[key]);
    assert_eq!(json!(counts), json!([6, 24, 12, 1.0]), "{occluders}");
    assert!(
        text.contains("6 of 12 triangles, 100.0 % of all opaque area"),
        "{text}"
    );
}

#[test]
fn what_hides_nothing_is_listed_and_counted_with_the_reason() {
    let folder = Folder::new();
    let mtl = "newmtl wall\nKd 1 1 1\nnewmtl pane\nKd 1 1 1\nd 0.5\n";
    folder.add("house.mtl", mtl);
    let quad = |z: i32| format!("v -1 0 {z}\nv 1 0 {z}\nv 1 2 {z}\nv -1 2 {z}\n");
    let faces = "usemtl wall\nf 1 2 3 4\ng glazed\nf 5 6 7 8\nusemtl pane\nf 9 10 11 12\ng lost\nusemtl lost\nf 13 14 15 16\n";
    let places: String = [-2, -3, -4, -5].map(quad).concat();
    folder.add("house.obj", format!("mtllib house.mtl\ng wall\n{places}{faces}"));
    let look = "look house.obj --eye 0,1,0 --toward 0,1,-1 --non-occluders";
    let text = folder.run(look).stdout;
    let listed = "2 items with faces that hide nothing:\n  glazed: blended; other faces hide\n  lost: material-unread\n";
    assert!(text.ends_with(listed), "{text}");
    assert_eq!(
        folder.json(look)["scene"]["non_occluders"],
        json!([
            { "item": "glazed", "reasons": ["blended"], "hides_partly": true },
            { "item": "lost", "reasons": ["material-unread"], "hides_partly": false },
        ])
    );
    let info = folder.json("info house.obj");
    assert_eq!(info["triangles_occluding"], 4);
    assert_eq!(
        info["non_occluders"],
        json!([
            { "reason": "blended", "items": 1, "triangles": 2 },
            { "reason": "material-unread", "items": 1, "triangles": 2 },
        ])
    );
    let text = folder.run("info house.obj").stdout;
    assert!(text.contains("material-unread: 1 item, 2 triangles"), "{text}");
    folder.run("bake house.obj -o house.enf");
    let baked = folder.json("info house.enf");
    assert_eq!(baked["non_occluders"], info["non_occluders"]);
}

#[test]
fn an_orthographic_camera_is_looked_through_like_others() {
    let fixture = "/../../crates/enfilade_import/fixtures/cameras.glb";
    let file = format!("{}{fixture}", env!("CARGO_MANIFEST_DIR"));
    let report = Folder::new().json(&format!(
        "look {file} --camera orthographic --size 64x36 --method hierarchical-z"
    ));
    let view = &report["views"][0];
    assert!(view["fov"].as_f64().expect("degrees") < 0.1, "{view}");
    assert_eq!(view["items_visible"], 5, "{view}");
}
