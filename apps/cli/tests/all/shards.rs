//! `--shard` and `--merge`: several machines give the bytes of one.

use crate::support::quake::Grid;
use crate::support::{Folder, Run, cube};
use serde_json::{Value, json};
use std::fs;
use std::process::Stdio;
use std::time::Duration;

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|why| panic!("{name}: {why}"))
}

#[track_caller]
fn done(folder: &Folder, arguments: &str) -> Run {
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
    run
}

/// Asserts that a run fails with exit 2 and one message that contains the words, and writes nothing.
#[track_caller]
fn refused(folder: &Folder, arguments: &str, words: &[&str]) {
    let names = folder.names();
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(2), "{arguments}: {}", run.stdout);
    for word in words {
        assert!(
            run.stderr.contains(word),
            "`{}` does not say `{word}`",
            run.stderr
        );
    }
    assert_eq!(folder.names(), names, "{arguments}");
}

/// A check of five views by all methods.
const CHECK: &str = "look @two-rooms --survey-hard 5 --method all --check --size 32x18";

/// Returns a folder with the folder `parts` in it.
fn with_parts(folder: Folder) -> Folder {
    fs::create_dir(folder.path("parts")).expect("made");
    folder
}

/// Writes the parts of a check, which finds nothing worse than failures.
fn checked(folder: &Folder, check: &str, count: usize) {
    for index in 0..count {
        let run = folder.run(&format!("{check} --parts parts --shard {index}/{count}"));
        assert!(matches!(run.code, Some(0 | 1)), "{}", run.stderr);
    }
}

fn remove_parts(folder: &Folder) {
    fs::remove_dir_all(folder.path("parts")).expect("there");
    fs::create_dir(folder.path("parts")).expect("made");
}

#[test]
fn parts_of_a_check_give_the_bytes_of_one_run() {
    let folder = with_parts(Folder::new());
    done(
        &folder,
        &format!("{CHECK} --parts parts --shard 0/1 --json one.json"),
    );
    let one = bytes(&folder, "one.json");
    assert!(bytes(&folder, "parts/two-rooms.0-of-1.json") == one);
    let report: Value = serde_json::from_slice(&one).expect("JSON");
    let views = report["views"].as_array().expect("a list");
    assert_eq!(views.len(), 5);
    assert!(views.iter().enumerate().all(|(at, view)| view["view"] == at + 1));
    assert!(report["summary"].as_array().expect("a list").len() > 5);
    for sum in report["summary"].as_array().expect("a list") {
        assert_eq!(
            (&sum["views"], &sum["pixels"]),
            (&json!(5), &json!(5 * 32 * 18)),
            "{sum}"
        );
        assert!(sum["reference_visible"].as_u64() > Some(5), "{sum}");
    }
    // More shards than views, too.
    for count in [1, 2, 3, 7] {
        remove_parts(&folder);
        checked(&folder, CHECK, count);
        let run = done(&folder, "look @two-rooms --parts parts --merge --json all.json");
        assert!(bytes(&folder, "all.json") == one, "{count} parts");
        assert!(
            run.stdout.contains("@two-rooms: 5 views checked\n") && run.stdout.contains("hierarchical-z"),
            "{}",
            run.stdout
        );
    }
}

#[test]
fn a_part_holds_nothing_that_differs_between_runs_or_machines() {
    let folder = with_parts(Folder::new());
    fs::create_dir(folder.path("elsewhere")).expect("made");
    folder.add("elsewhere/scene.glb", bytes(&folder, "scene.glb"));
    folder.add("elsewhere/other.jsonl", bytes(&folder, "views.jsonl"));
    let check = "--method masked --check --size 64x36 --parts parts --shard 0/2";
    done(
        &folder,
        &format!("look scene.glb --path views.jsonl {check} --threads 1 --json a.json"),
    );
    done(
        &folder,
        &format!("look elsewhere/scene.glb --path elsewhere/other.jsonl {check} --threads 3 --json b.json"),
    );
    assert_eq!(
        String::from_utf8_lossy(&bytes(&folder, "a.json")),
        String::from_utf8_lossy(&bytes(&folder, "b.json"))
    );
    let report: Value = serde_json::from_slice(&bytes(&folder, "a.json")).expect("JSON");
    assert_eq!(report["scene"]["file"], "scene.glb");
    let method = &report["views"][0]["methods"][0];
    assert_eq!(
        (
            &method["items_visible"],
            &method["items_in_frustum"],
            &method["missed"]
        ),
        (&json!(3), &json!(4), &json!([]))
    );
}

#[test]
fn a_view_of_a_shard_does_not_depend_on_the_view_before() {
    let folder = with_parts(Folder::new());
    let views: Vec<String> = String::from_utf8(bytes(&folder, "views.jsonl"))
        .expect("text")
        .lines()
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect();
    folder.add("both.jsonl", views.join("\n"));
    folder.add("second.jsonl", &views[1]);
    let methods = |path: &str, number: usize| {
        let mut report = folder.json(&format!(
            "look scene.glb --path {path} --method masked --check --size 64x36 --parts parts --shard 0/1"
        ));
        report["views"][number]["methods"].take()
    };
    assert_eq!(methods("both.jsonl", 1), methods("second.jsonl", 0));
}

#[test]
fn a_merge_fails_like_one_run_if_a_part_has_found_something_wrong() {
    let folder = with_parts(Folder::new());
    checked(
        &folder,
        "look scene.glb --path views.jsonl --method z-buffer --check --size 64x36",
        2,
    );
    let part = "parts/scene.glb.1-of-2.json";
    let text = String::from_utf8(bytes(&folder, part)).expect("text");
    let wrong = text.replace(r#""missed":[]"#, r#""missed":["chest"]"#);
    assert_ne!(text, wrong);
    folder.add(part, wrong);
    let merge = "look scene.glb --parts parts --merge";
    let run = folder.run(&format!("{merge} --json all.json"));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(
        run.stderr
            .contains("check: z-buffer, view 2 (eye 0, 1.5, -6): missed chest"),
        "{}",
        run.stderr
    );
    let report: Value = serde_json::from_slice(&bytes(&folder, "all.json")).expect("JSON");
    assert_eq!(report["summary"][0]["missed"], 1);
    folder.add(
        part,
        text.replace(r#""pixels_different":0"#, r#""pixels_different":3"#),
    );
    let run = folder.run(merge);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(
        run.stderr.contains("view 2 (eye 0, 1.5, -6): 3 wrong pixels"),
        "{}",
        run.stderr
    );
}

#[test]
fn parts_of_a_check_that_do_not_belong_together_are_refused() {
    let folder = with_parts(Folder::new());
    let check = "look scene.glb --path views.jsonl --method z-buffer --check --size 32x18";
    let merge = "look scene.glb --json all.json --parts parts --merge";
    refused(&folder, merge, &["parts: there is no part of scene.glb"]);
    checked(&folder, check, 3);
    let name = "parts/scene.glb.1-of-3.json";
    let own = bytes(&folder, name);
    fs::remove_file(folder.path(name)).expect("there");
    refused(
        &folder,
        merge,
        &["parts: 1 of 3 parts of scene.glb missing: 1/3", "--shard 1/3"],
    );
    folder.add(name, &own);
    done(&folder, &format!("{check} --parts parts --shard 0/2"));
    refused(
        &folder,
        merge,
        &[
            "scene.glb.0-of-2.json is of 2 shards",
            "scene.glb.0-of-3.json of 3",
        ],
    );
    fs::remove_file(folder.path("parts/scene.glb.0-of-2.json")).expect("there");
    folder.add(name, bytes(&folder, "parts/scene.glb.0-of-3.json"));
    refused(&folder, merge, &["1-of-3.json is the part of shard 0/3"]);
    done(&folder, &format!("{check} --json report.json"));
    folder.add(name, bytes(&folder, "report.json"));
    refused(
        &folder,
        merge,
        &["1-of-3.json is not a part that `look --shard` wrote"],
    );

    let other = |check: &str, words: &[&str]| {
        done(&folder, &format!("{check} --parts parts --shard 1/3"));
        refused(
            &folder,
            merge,
            &[
                &["scene.glb.1-of-3.json is of another run than parts/scene.glb.0-of-3.json"],
                words,
            ]
            .concat(),
        );
    };
    other(&check.replace("32x18", "16x9"), &["--size 32x18 and 16x9"]);
    other(
        &check.replace("z-buffer", "masked"),
        &["--method z-buffer and masked"],
    );
    other(&check.replace("--check", "--check=2"), &["--check 1 and 2"]);
    other(
        &check.replace("--path views.jsonl", "--survey-hard 4"),
        &["--survey-hard not given and 4"],
    );
    folder.add("other.jsonl", r#"{"eye": [0, 1.5, 7], "toward": [0, 1, 0]}"#);
    other(
        &check.replace("views.jsonl", "other.jsonl"),
        &["the views differ"],
    );
    // Four more bytes in the binary chunk, which nothing reads.
    let mut changed = bytes(&folder, "scene.glb");
    let chunk = changed.len() - cube().len() - 8;
    changed.extend([0; 4]);
    let whole = changed.len() as u32;
    changed[8..12].copy_from_slice(&whole.to_le_bytes());
    changed[chunk..chunk + 4].copy_from_slice(&(cube().len() as u32 + 4).to_le_bytes());
    let before = bytes(&folder, "scene.glb");
    folder.add("scene.glb", changed);
    other(check, &["the bytes of scene.glb differ"]);
    folder.add("scene.glb", before);

    let text = String::from_utf8(own).expect("text");
    let damaged = |text: String, words: &[&str]| {
        folder.add(name, text);
        refused(&folder, merge, &[&["scene.glb.1-of-3.json"], words].concat());
    };
    damaged(
        text.replace("look part 1", "look part 0"),
        &["another version", "compute the part again"],
    );
    damaged(
        text.replace(env!("CARGO_PKG_VERSION"), "0.0.0"),
        &["program versions", "0.0.0"],
    );
    damaged(
        text.replace(r#""view":2"#, r#""view":3"#),
        &["a damaged part", "lacks views"],
    );
    damaged(
        text.replace("items_in_frustum", "items"),
        &["a damaged part", "copy it again"],
    );
    damaged(
        text.replace("view_count", "count"),
        &["a damaged part", "view_count"],
    );
    damaged(text[..text.len() / 2].to_owned(), &[]);
}

#[test]
fn what_a_shard_of_a_check_cannot_do_is_said() {
    let folder = with_parts(Folder::new());
    let look = "look scene.glb --size 32x18";
    refused(
        &folder,
        &format!("{look} --parts parts --shard 0/2"),
        &["--check"],
    );
    refused(&folder, &format!("{look} --check --shard 0/2"), &["--parts"]);
    refused(&folder, &format!("{look} --merge"), &["--parts"]);
    refused(
        &folder,
        &format!("{look} --check --parts parts"),
        &["--shard", "--merge"],
    );
    refused(
        &folder,
        &format!("{look} --check --parts none --shard 0/2"),
        &["none: there is no such folder"],
    );
    refused(
        &folder,
        &format!("{look} --check --parts parts --shard 2/2"),
        &["the last of 2 is 1/2"],
    );
    refused(
        &folder,
        &format!("{look} --check --parts parts --shard 2"),
        &["such as 0/4 to 3/4"],
    );
    refused(
        &folder,
        &format!("{look} --check --parts parts --shard 0/2 --method auto"),
        &["--method auto", "name a method"],
    );
    refused(
        &folder,
        "look scene.glb --parts parts --merge --check",
        &["cannot be used with"],
    );
}

/// A folder with `map.bsp` and `map.prt`, and `one.bsp`, the map after one run.
fn baked() -> Folder {
    let folder = with_parts(Folder::empty());
    folder.add("map.bsp", Grid::row(9).bsp());
    folder.add("map.prt", Grid::row(9).prt());
    done(&folder, "vis map.bsp -o one.bsp");
    folder
}

/// Writes the parts of a map.
fn parts_of(folder: &Folder, count: usize) {
    for index in 0..count {
        done(
            folder,
            &format!("vis map.bsp --parts parts --shard {index}/{count}"),
        );
    }
}

const MERGE: &str = "vis map.bsp -o all.bsp --parts parts --merge";

#[test]
fn parts_of_a_map_give_the_bytes_of_one_run() {
    let folder = baked();
    let one = bytes(&folder, "one.bsp");
    for count in [1, 2, 3, 7, 30] {
        remove_parts(&folder);
        parts_of(&folder, count);
        let run = done(&folder, MERGE);
        assert!(run.stdout.contains("merged from "), "{}", run.stdout);
        assert!(bytes(&folder, "all.bsp") == one, "{count} parts");
    }
    let names = folder.names();
    assert!(names.iter().all(|name| !name.contains("vis-")), "{names:?}");
    let [full, fast] = ["vis map.prt", "vis map.prt --fast"].map(|run| folder.json(run)["pairs"].as_u64());
    assert!(fast > full, "the flow drops pairs");
    let report = folder.json("vis map.prt --parts parts --shard 1/2");
    assert_eq!(
        (&report["shard"], &report["written"], &report["clusters"]),
        (&json!("1/2"), &json!("parts/map.prt.1-of-2.vis"), &json!(81))
    );
    assert_eq!(report["bytes"], bytes(&folder, "parts/map.prt.1-of-2.vis").len());
}

#[test]
fn what_shards_begin_with_is_computed_once() {
    let folder = baked();
    let report = |arguments: &str| folder.json(arguments);
    let prepare = "vis map.bsp --parts parts --prepare";
    let shard = "vis map.bsp --parts parts --shard 0/2";
    let first = report(prepare);
    assert_eq!(
        (&first["prepared"], &first["written"], &first["shard"]),
        (&json!(false), &json!("parts/map.bsp.start.vis"), &Value::Null)
    );
    let [start, passages] = ["parts/map.bsp.start.vis", "parts/map.bsp.passages.vis"];
    let whole = [start, passages].map(|name| bytes(&folder, name));
    assert_eq!(first["bytes"], whole[0].len());
    let text = done(&folder, prepare).stdout;
    assert!(text.contains("map.bsp.start.vis is up to date"), "{text}");
    assert_eq!(report(shard)["prepared"], true);
    let part = bytes(&folder, "parts/map.bsp.0-of-2.vis");

    // What is missing, damaged, of other portals or a part of another kind is computed and written again.
    let mut damaged = whole[0].clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    folder.add("other.prt", Grid::row(8).prt());
    done(&folder, "vis other.prt --parts parts --prepare");
    let of_others = bytes(&folder, "parts/other.prt.start.vis");
    for wrong in [
        &b""[..],
        &whole[0][..middle],
        &damaged,
        &of_others,
        &part,
        &whole[1],
    ] {
        for name in [start, passages] {
            folder.add(name, wrong);
            if *wrong == whole[1][..] && name == passages {
                continue;
            }
            assert_eq!(report(shard)["prepared"], false);
            assert!(bytes(&folder, "parts/map.bsp.0-of-2.vis") == part);
            assert!(
                [start, passages].map(|name| bytes(&folder, name)) == whole,
                "{name}"
            );
        }
    }
    done(&folder, "vis map.bsp --parts parts --shard 1/2");
    assert_eq!(report(MERGE)["prepared"], true);
    assert!(bytes(&folder, "all.bsp") == bytes(&folder, "one.bsp"));
    // A merge does without it, too.
    fs::remove_file(folder.path(start)).expect("there");
    let merged = report(MERGE);
    assert_eq!(merged.get("prepared"), None);
    assert!(bytes(&folder, "all.bsp") == bytes(&folder, "one.bsp"));
    assert!(bytes(&folder, start) == whole[0]);
}

#[test]
fn a_shard_that_is_killed_goes_on_where_it_was() {
    let folder = baked();
    parts_of(&folder, 2);
    let part = "parts/map.bsp.1-of-2.vis";
    let whole = bytes(&folder, part);
    let shard = "vis map.bsp --parts parts --shard 1/2 --save-every 0";
    let saved = folder.path("parts/map.bsp.1-of-2.vis.vis-unfinished");
    // With what shards begin with, and without.
    for file in ["parts/map.bsp.1-of-2.vis", "parts/map.bsp.start.vis"] {
        let _ = fs::remove_file(folder.path(part));
        let _ = fs::remove_file(folder.path(file));
        let mut run = folder
            .command(shard)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        while !saved.exists() && run.try_wait().expect("a state").is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        run.kill().expect("it can be killed");
        run.wait().expect("it ends");
        assert!(saved.exists(), "the run was not caught at work");
        let text = done(&folder, &format!("{shard} --resume")).stdout;
        assert!(text.contains("resumed from the saved work"), "{text}");
        assert!(bytes(&folder, part) == whole);
        assert!(!saved.exists());
    }
    done(&folder, MERGE);
    assert!(bytes(&folder, "all.bsp") == bytes(&folder, "one.bsp"));
}

#[test]
fn parts_of_a_map_that_do_not_belong_together_are_refused() {
    let folder = baked();
    refused(&folder, MERGE, &["parts: there is no part of map.bsp"]);
    parts_of(&folder, 3);
    let name = "parts/map.bsp.1-of-3.vis";
    let whole = bytes(&folder, name);
    fs::remove_file(folder.path(name)).expect("there");
    refused(
        &folder,
        MERGE,
        &["1 of 3 parts of map.bsp missing: 1/3", "--shard 1/3"],
    );
    folder.add(name, bytes(&folder, "parts/map.bsp.0-of-3.vis"));
    refused(&folder, MERGE, &["1-of-3.vis is the part of shard 0/3"]);
    folder.add(name, &whole);
    done(&folder, "vis map.bsp --parts parts --shard 1/2");
    refused(
        &folder,
        MERGE,
        &["map.bsp.1-of-2.vis is of 2 shards", "map.bsp.0-of-3.vis of 3"],
    );
    fs::remove_file(folder.path("parts/map.bsp.1-of-2.vis")).expect("there");
    let wrong = |bytes: &[u8], words: &[&str]| {
        folder.add(name, bytes);
        refused(
            &folder,
            MERGE,
            &[words, &["1-of-3.vis", "compute shard 1/3 again"]].concat(),
        );
    };
    wrong(&bytes(&folder, "map.prt"), &["is not a part of this version"]);
    wrong(&whole[..whole.len() - 8], &["is truncated or corrupt"]);
    let mut other = whole.clone();
    // The version in the magic number.
    other[6] -= 1;
    wrong(&other, &["is not a part of this version"]);
    folder.add("other.prt", Grid::row(8).prt());
    done(&folder, "vis other.prt --parts parts --shard 1/3");
    wrong(
        &bytes(&folder, "parts/other.prt.1-of-3.vis"),
        &["is a part of other portals, not those of map.bsp"],
    );
    for (arguments, words) in [
        ("--shard 0/2", "--parts"),
        ("--merge", "--parts"),
        ("--prepare", "--parts"),
        ("--parts parts", "--shard"),
        ("--parts parts --shard 0/2 -o x.bsp", "cannot be used with"),
        ("--parts parts --shard 0/2 --fast", "cannot be used with"),
        ("--parts parts --shard 0/2 --merge", "cannot be used with"),
        ("--parts parts --shard 0/2 --prepare", "cannot be used with"),
        ("--parts parts --merge --fast", "cannot be used with"),
        ("--parts none --merge", "none: there is no such folder"),
    ] {
        refused(&folder, &format!("vis map.bsp {arguments}"), &[words]);
    }
}
