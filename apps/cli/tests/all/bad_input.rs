//! Bad input ends with exit 2 and one message that says what is wrong and what to do; unusual input only warns.

use crate::support::{Folder, document, glb, yard};
use serde_json::json;

/// Asserts that a run fails: exit 2, one error that contains every word, nothing on standard output.
fn refused(folder: &Folder, arguments: &str, words: &[&str]) {
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(2), "{arguments}: {}{}", run.stdout, run.stderr);
    assert_eq!(
        run.stderr.matches("error:").count(),
        1,
        "{arguments}: {}",
        run.stderr
    );
    assert!(
        !run.stderr.contains("panicked") && !run.stderr.contains("RUST_BACKTRACE"),
        "{}",
        run.stderr
    );
    assert_eq!(run.stdout, "", "{arguments}");
    for word in words {
        assert!(
            run.stderr.contains(word),
            "{arguments} does not say `{word}`: {}",
            run.stderr
        );
    }
}

/// Asserts that a run succeeds with a warning that contains the word.
fn warned(folder: &Folder, arguments: &str, word: &str) {
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
    assert!(
        run.stderr.contains("warning: ") && run.stderr.contains(word),
        "{arguments}: {}",
        run.stderr
    );
}

#[test]
fn what_is_mistyped_is_met_with_the_nearest() {
    let folder = Folder::new();
    refused(&folder, "lok", &["similar subcommand", "'look'"]);
    refused(&folder, "look --methd all", &["--method"]);
    refused(&folder, "look --method z-bufer", &["did you mean z-buffer?"]);
    refused(
        &folder,
        "look --method qqq",
        &["available: ", "z-buffer", "hierarchical-z"],
    );
    refused(&folder, "draw -o a.png --show imgae", &["did you mean image?"]);
    refused(
        &folder,
        "draw -o a.png --shadows --show order",
        &["--shadows works with --show image only"],
    );
    refused(
        &folder,
        "draw -o a.png --ambient-occlusion 9999",
        &["0 to 1024", "32"],
    );
    refused(&folder, "draw -o a.png --samples 3", &["1 or 4 samples"]);
    refused(
        &folder,
        "draw -o a.png --samples 4 --show items",
        &["--samples 4 works with --show image only"],
    );
    refused(&folder, "draw -o a.png --exposure bright", &["a number of stops"]);
    refused(&folder, "look @enfilad", &["did you mean @enfilade?"]);
    refused(&folder, "look enfilade", &["called @enfilade"]);
    refused(
        &folder,
        "look scene.glb --camera frnt",
        &["scene.glb", "did you mean front?", "back"],
    );
    refused(&folder, "scene.glb", &["not a verb", "enfilade look scene.glb"]);
}

#[test]
fn values_out_of_range_are_refused() {
    let folder = Folder::new();
    refused(&folder, "look scene.glb --size 0x0", &["from 1 to 16384"]);
    refused(
        &folder,
        "look scene.glb --size 100000x100000",
        &["from 1 to 16384"],
    );
    refused(&folder, "look scene.glb --size wide", &["1280x720"]);
    refused(&folder, "look scene.glb --fov 180", &["below 180"]);
    refused(&folder, "look scene.glb --threads 0", &["--threads"]);
    refused(&folder, "look scene.glb --survey 0", &["--survey"]);
    refused(&folder, "look scene.glb --memory much", &["2GB"]);
    refused(&folder, "look scene.glb --check=65", &["1 to 64"]);
    refused(
        &folder,
        "look @enfilade --memory 1 --size 64x36",
        &["@enfilade", "above the limit of 1 byte;", "raise --memory"],
    );
    refused(
        &folder,
        "look @enfilade --memory 1 --size 64x36 --method z-buffer",
        &["raise --memory"],
    );
    refused(
        &folder,
        "draw @enfilade -o a.png --memory 1MB --size 16384x16384",
        &["raise --memory"],
    );
    refused(&folder, "look scene.glb --memory 1", &["scene.glb", "limit"]);
}

#[test]
fn views_that_see_nothing_are_refused() {
    let folder = Folder::new();
    refused(
        &folder,
        "look scene.glb --eye 1,2,3 --toward 1,2,3",
        &["--eye and --toward", "the same"],
    );
    refused(
        &folder,
        "look scene.glb --eye NaN,2,3 --toward 1,2,3",
        &["`NaN` is not finite"],
    );
    refused(
        &folder,
        "look scene.glb --eye 1,2 --toward 1,2,3",
        &["three numbers"],
    );
    refused(&folder, "look scene.glb --eye 1,2,3", &["--toward"]);
    refused(&folder, "look scene.glb --toward 1,2,3", &["--eye"]);
    refused(
        &folder,
        "look scene.glb --camera front --survey 2",
        &["cannot be used with"],
    );
    refused(
        &folder,
        "look scene.glb --path views.jsonl --survey 2",
        &["cannot be used with"],
    );
    refused(
        &folder,
        "look scene.glb --eye 0,0,1 --toward 0,0,0 --path views.jsonl",
        &["cannot be used with"],
    );
    folder.add(
        "bare.glb",
        glb(&document(&[json!({ "name": "cube", "mesh": 0 })], json!([]))),
    );
    refused(
        &folder,
        "look bare.glb --camera front",
        &["bare.glb", "no cameras", "--eye"],
    );
}

#[test]
fn a_broken_path_is_refused_by_its_line() {
    let folder = Folder::new();
    let sound = r#"{"eye": [0, 1, 6], "toward": [0, 1, 0]}"#;
    for (line, word) in [
        ("{", "EOF"),
        (r#"{"eye": [0, 1]}"#, "expected an array of length 3"),
        (r#"{"eye": [0, 1, 2]}"#, "missing field `toward`"),
        (r#"{"eye": [0, 1, 2], "toward": [0, 1, 2]}"#, "the same"),
        (r#"{"eye": [0, 1, 1e99], "toward": [0, 1, 2]}"#, "finite"),
        (
            r#"{"eye": [0, 1, 6], "toward": [0, 1, 2], "fov": 180}"#,
            "below 180",
        ),
    ] {
        folder.add("broken.jsonl", format!("{sound}\n\n{line}\n"));
        refused(
            &folder,
            "look scene.glb --path broken.jsonl",
            &["broken.jsonl, line 3", word],
        );
    }
    folder.add("binary.jsonl", [0xff, 0xfe, 0x00]);
    refused(
        &folder,
        "look scene.glb --path binary.jsonl",
        &["binary.jsonl, line 1"],
    );
    folder.add("empty.jsonl", "\n");
    refused(
        &folder,
        "look scene.glb --path empty.jsonl",
        &["empty.jsonl", "no view"],
    );
    refused(
        &folder,
        "look scene.glb --path missing.jsonl",
        &["missing.jsonl", "; check the path"],
    );
}

#[test]
fn files_that_are_no_scene_are_refused() {
    let folder = Folder::new();
    let whole = glb(&yard());
    folder.add("cut.glb", &whole[..whole.len() / 2]);
    folder.add("text.glb", "once upon a time");
    folder.add("nothing.glb", "");
    for verb in ["look", "draw -o a.png", "info"] {
        refused(
            &folder,
            &format!("{verb} missing.glb"),
            &["missing.glb: cannot be read: there is no such file; check its path"],
        );
        refused(&folder, &format!("{verb} cut.glb"), &["cut.glb", "cut short"]);
        refused(
            &folder,
            &format!("{verb} text.glb"),
            &["text.glb", "neither glTF nor OBJ"],
        );
        refused(
            &folder,
            &format!("{verb} nothing.glb"),
            &["nothing.glb", "it is empty; name a scene"],
        );
        refused(&folder, &format!("{verb} ."), &["."]);
    }
}

#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("taken.png")).expect("made");
    // The scene is missing too: an error about the output shows that the output is checked first.
    refused(
        &folder,
        "draw missing.glb -o no/a.png",
        &["no/a.png", "no folder no"],
    );
    refused(
        &folder,
        "draw missing.glb -o taken.png",
        &["taken.png", "is a folder"],
    );
    refused(
        &folder,
        "draw missing.glb -o a.jpg",
        &["a.jpg", "must end in .png"],
    );
    refused(&folder, "draw missing.glb", &["--output"]);
    refused(
        &folder,
        "look missing.glb --json no/a.json",
        &["no/a.json", "no folder no"],
    );
    refused(
        &folder,
        "info missing.glb --json scene.glb/a.json",
        &["no folder scene.glb"],
    );
    assert_eq!(folder.names(), ["scene.glb", "taken.png", "views.jsonl"]);
}

#[test]
fn odd_scenes_and_views_are_warned_of() {
    let folder = Folder::new();
    folder.add(
        "empty.glb",
        glb(&document(&[json!({ "name": "nothing" })], json!([]))),
    );
    warned(&folder, "info empty.glb", "the scene is empty");
    warned(&folder, "look empty.glb --size 64x36", "the scene is empty");
    warned(
        &folder,
        "look empty.glb --size 64x36 --survey 3 --method all --check",
        "no open space",
    );
    warned(&folder, "draw empty.glb -o sky.png --size 64x36", "no open space");
    assert!(folder.names().contains(&"sky.png".to_owned()));
    warned(
        &folder,
        "look scene.glb --camera walled-in --size 64x36",
        "inside something solid",
    );
    warned(
        &folder,
        "look scene.glb --eye 0,1.2,0 --toward 0,1.2,-5 --size 64x36",
        "inside something solid",
    );
    folder.add(
        "more.jsonl",
        r#"{"eye": [0, 1, 6], "toward": [0, 1, 0], "fvo": 50}"#,
    );
    warned(&folder, "look scene.glb --path more.jsonl --size 64x36", "`fvo`");
}

#[test]
fn a_cover_size_that_makes_no_sense_is_refused() {
    let folder = Folder::new();
    refused(
        &folder,
        "look scene.glb --cover-size 0x0",
        &["--cover-size", "from 1 to 16384"],
    );
    refused(
        &folder,
        "look scene.glb --size 64x36 --cover-size 65x36",
        &["65x36 is larger than the screen", "64x36 at most"],
    );
    refused(
        &folder,
        "look scene.glb --size 64x36 --cover-size 32x18 --method z-buffer",
        &[
            "--cover-size",
            "z-buffer",
            "hierarchical-z, hierarchical-s, masked",
        ],
    );
}

#[test]
fn faces_that_no_method_would_test_are_refused() {
    let folder = Folder::new();
    refused(
        &folder,
        "look scene.glb --tightness faces --method z-buffer",
        &["--tightness faces has no effect on z-buffer", "--method masked"],
    );
    refused(
        &folder,
        "look scene.glb --size 64x36 --tightness resolved --cover-size 32x18 --method masked",
        &["--tightness resolved", "--cover-size", "leave one of them out"],
    );
}

/// The yard as a room with two portals, both of which lead nowhere.
fn yard_with_bad_portals() -> serde_json::Value {
    let mut yard = yard();
    yard["scenes"][0]["nodes"] = json!([7]);
    let nodes = yard["nodes"].as_array_mut().expect("a list");
    nodes.push(json!({ "name": "Yard-room", "children": [0, 1, 2, 3, 4, 5, 6, 8, 9] }));
    for (name, x) in [("Gate-portal", 3.0), ("Hatch-portal", 300.0)] {
        nodes.push(json!({ "name": name, "mesh": 0, "scale": [1, 1, 0.0], "translation": [x, 1, 0] }));
    }
    yard
}

#[test]
fn bad_portals_are_named_all_at_once_with_the_options_that_open_the_file() {
    let folder = Folder::new();
    folder.add("bad.glb", glb(&yard_with_bad_portals()));
    let words = [
        "bad.glb: 2 errors in its rooms",
        "node 8 \"Gate-portal\"",
        "node 9 \"Hatch-portal\"",
        "--skip-bad-portals",
        "--flat",
    ];
    refused(&folder, "info bad.glb", &words);
    refused(&folder, "look bad.glb --size 64x36", &words);
    // --skip-bad-portals would not help without room markup, so the message suggests --flat.
    let mut yard = yard_with_bad_portals();
    let nodes = yard["nodes"].as_array_mut().expect("a list");
    nodes.push(json!({ "name": "Yard-room" }));
    yard["scenes"][0]["nodes"] = json!([7, 10]);
    folder.add("twice.glb", glb(&yard));
    let run = folder.run("info twice.glb");
    assert!(run.stderr.contains("--flat") && !run.stderr.contains("--skip-bad-portals"));
}

#[test]
fn bad_portals_can_be_skipped_or_ignored() {
    let folder = Folder::new();
    folder.add("bad.glb", glb(&yard_with_bad_portals()));
    for verb in [
        "info bad.glb",
        "look bad.glb --camera front --size 64x36 --check",
        "draw bad.glb -o a.png --camera front --size 64x36",
        "choose bad.glb -o pinned.glb --size 16x9",
    ] {
        let arguments = format!("{verb} --skip-bad-portals");
        warned(&folder, &arguments, "node 8 \"Gate-portal\"");
        warned(&folder, &arguments, "node 9 \"Hatch-portal\"");
    }
    for verb in ["info bad.glb", "look bad.glb --camera front --size 64x36 --check"] {
        let run = folder.run(&format!("{verb} --flat"));
        assert_eq!((run.code, &*run.stderr), (Some(0), ""), "{verb}");
    }
    let flat = folder.json("info bad.glb --flat");
    assert_eq!((&flat["portals"], &flat["openings"]), (&json!(0), &json!(0)));
    assert_eq!(flat["items"], 4);
    assert_eq!(flat["sectors"].as_array().map(Vec::len), Some(1));
    let palace = folder.json("info @two-rooms --flat");
    assert_eq!((&palace["portals"], &palace["ways"]), (&json!(0), &json!([])));
}
