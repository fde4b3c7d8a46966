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

/// Writes the parts `NAME-I.json`, and returns their names.
fn checked(folder: &Folder, check: &str, name: &str, count: usize) -> Vec<String> {
    let parts = (0..count).map(|index| {
        let part = format!("{name}-{index}.json");
        let run = folder.run(&format!("{check} --shard {index}/{count} --json {part}"));
        assert!(matches!(run.code, Some(0 | 1)), "{}", run.stderr);
        part
    });
    parts.collect()
}

#[test]
fn parts_of_a_check_in_any_order_give_the_bytes_of_one_run() {
    let folder = Folder::new();
    done(&folder, &format!("{CHECK} --shard 0/1 --json one.json"));
    let one = bytes(&folder, "one.json");
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
        let mut parts = checked(&folder, CHECK, "part", count);
        for _ in 0..2 {
            done(
                &folder,
                &format!("look --merge {} --json all.json", parts.join(" ")),
            );
            assert!(bytes(&folder, "all.json") == one, "{count} parts");
            parts.reverse();
            parts.rotate_left(count / 2);
        }
    }
    // A merged report is a part, of which there is one.
    done(&folder, "look --merge all.json --json again.json");
    assert!(bytes(&folder, "again.json") == one);
    let text = done(&folder, "look --merge all.json").stdout;
    assert!(
        text.contains("@two-rooms: 5 views checked\n") && text.contains("hierarchical-z"),
        "{text}"
    );
}

#[test]
fn a_part_holds_nothing_that_differs_between_runs_or_machines() {
    let folder = Folder::new();
    fs::create_dir(folder.path("elsewhere")).expect("made");
    folder.add("elsewhere/scene.glb", bytes(&folder, "scene.glb"));
    folder.add("elsewhere/other.jsonl", bytes(&folder, "views.jsonl"));
    let check = "--method masked --check --size 64x36 --shard 0/2";
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
    let folder = Folder::new();
    let views: Vec<String> = String::from_utf8(bytes(&folder, "views.jsonl"))
        .expect("text")
        .lines()
        .filter(|line| !line.is_empty())
        .map(str::to_owned)
        .collect();
    folder.add("both.jsonl", views.join("\n"));
    folder.add("second.jsonl", &views[1]);
    let methods = |path: &str, number: usize| {
        let check = format!("look scene.glb --path {path} --method masked --check --size 64x36 --shard 0/1");
        let mut report = folder.json(&check);
        report["views"][number]["methods"].take()
    };
    assert_eq!(methods("both.jsonl", 1), methods("second.jsonl", 0));
}

#[test]
fn a_merge_fails_like_one_run_if_a_part_has_found_something_wrong() {
    let folder = Folder::new();
    let parts = checked(
        &folder,
        "look scene.glb --path views.jsonl --method z-buffer --check --size 64x36",
        "part",
        2,
    );
    let text = String::from_utf8(bytes(&folder, &parts[1])).expect("text");
    let wrong = text.replace(r#""missed":[]"#, r#""missed":["chest"]"#);
    assert_ne!(text, wrong);
    folder.add(&parts[1], wrong);
    let run = folder.run(&format!("look --merge {} --json all.json", parts.join(" ")));
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
        &parts[1],
        text.replace(r#""pixels_different":0"#, r#""pixels_different":3"#),
    );
    let run = folder.run(&format!("look --merge {}", parts.join(" ")));
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert!(
        run.stderr.contains("view 2 (eye 0, 1.5, -6): 3 wrong pixels"),
        "{}",
        run.stderr
    );
}

#[test]
fn parts_of_a_check_that_do_not_belong_together_are_refused() {
    let folder = Folder::new();
    let check = "look scene.glb --path views.jsonl --method z-buffer --check --size 32x18";
    let parts = checked(&folder, check, "part", 3);
    let [a, b, c] = [&parts[0], &parts[1], &parts[2]];
    let merge = "look --json all.json --merge";
    refused(
        &folder,
        &format!("{merge} {a} {c}"),
        &["1 of 3 parts missing: 1/3", "--shard 1/3"],
    );
    refused(
        &folder,
        &format!("{merge} {a} {b} {c} {a}"),
        &["part-0.json and part-0.json are both part 0/3"],
    );
    folder.add("copy.json", bytes(&folder, b));
    refused(
        &folder,
        &format!("{merge} {a} {b} copy.json"),
        &["part-1.json and copy.json are both part 1/3"],
    );
    refused(
        &folder,
        &format!("{merge} {a} {b} {c} none.json"),
        &["none.json", "check the path"],
    );
    done(&folder, &format!("{check} --json report.json"));
    refused(
        &folder,
        &format!("{merge} report.json {a}"),
        &["report.json is not a part", "look --shard"],
    );
    refused(
        &folder,
        &format!("{merge} scene.glb {a}"),
        &["scene.glb is not a part"],
    );

    let other = |name: &str, check: &str, words: &[&str]| {
        checked(&folder, check, name, 3);
        refused(
            &folder,
            &format!("{merge} {a} {name}-1.json {c}"),
            &[
                &[&*format!("{name}-1.json is of another run than part-0.json")],
                words,
            ]
            .concat(),
        );
    };
    other(
        "size",
        &check.replace("32x18", "16x9"),
        &["--size 32x18 and 16x9"],
    );
    other(
        "method",
        &check.replace("z-buffer", "masked"),
        &["--method z-buffer and masked"],
    );
    other(
        "samples",
        &check.replace("--check", "--check=2"),
        &["--check 1 and 2"],
    );
    other(
        "hard",
        &check.replace("--path views.jsonl", "--survey-hard 4"),
        &["--survey-hard not given and 4"],
    );
    folder.add("other.jsonl", r#"{"eye": [0, 1.5, 7], "toward": [0, 1, 0]}"#);
    other(
        "views",
        &check.replace("views.jsonl", "other.jsonl"),
        &["the views differ"],
    );
    other(
        "scene",
        &check.replace("scene.glb", "@two-rooms"),
        &["scenes scene.glb and @two-rooms"],
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
    other("bytes", check, &["the bytes of scene.glb differ"]);
    folder.add("scene.glb", before);

    let text = String::from_utf8(bytes(&folder, b)).expect("text");
    let damaged = |text: String, words: &[&str]| {
        folder.add("bad.json", text);
        refused(
            &folder,
            &format!("{merge} {a} bad.json {c}"),
            &[&["bad.json"], words].concat(),
        );
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
    damaged(text[..text.len() / 2].to_owned(), &["bad.json"]);
}

#[test]
fn what_a_shard_of_a_check_cannot_do_is_said() {
    let folder = Folder::new();
    let look = "look scene.glb --size 32x18";
    refused(
        &folder,
        &format!("{look} --shard 0/2 --json a.json"),
        &["--check"],
    );
    refused(&folder, &format!("{look} --check --shard 0/2"), &["--json"]);
    refused(
        &folder,
        &format!("{look} --check --shard 2/2 --json a.json"),
        &["the last of 2 is 1/2"],
    );
    refused(
        &folder,
        &format!("{look} --check --shard 2 --json a.json"),
        &["such as 0/4 to 3/4"],
    );
    refused(
        &folder,
        &format!("{look} --check --shard 0/2 --json a.json --method auto"),
        &["--method auto", "name a method"],
    );
    refused(&folder, "look scene.glb --merge a.json", &["cannot be used with"]);
}

/// A folder with `map.bsp` and `map.prt`, and `one.bsp`, the map after one run.
fn baked() -> Folder {
    let folder = Folder::empty();
    folder.add("map.bsp", Grid::row(9).bsp());
    folder.add("map.prt", Grid::row(9).prt());
    done(&folder, "vis map.bsp -o one.bsp");
    folder
}

/// Writes the parts `I.part`, and returns their names.
fn parts_of(folder: &Folder, count: usize) -> Vec<String> {
    let parts = (0..count).map(|index| {
        let part = format!("{index}.part");
        done(folder, &format!("vis map.bsp --shard {index}/{count} -o {part}"));
        part
    });
    parts.collect()
}

#[test]
fn parts_of_a_map_in_any_order_give_the_bytes_of_one_run() {
    let folder = baked();
    let one = bytes(&folder, "one.bsp");
    for count in [1, 2, 3, 7, 30] {
        let mut parts = parts_of(&folder, count);
        for _ in 0..2 {
            let run = done(
                &folder,
                &format!("vis map.bsp -o all.bsp --merge {}", parts.join(" ")),
            );
            assert!(run.stdout.contains("merged from "), "{}", run.stdout);
            assert!(bytes(&folder, "all.bsp") == one, "{count} parts");
            parts.reverse();
            parts.rotate_left(count / 2);
        }
    }
    let names = folder.names();
    assert!(names.iter().all(|name| !name.contains("vis-")), "{names:?}");
    let [full, fast] = ["vis map.prt", "vis map.prt --fast"].map(|run| folder.json(run)["pairs"].as_u64());
    assert!(fast > full, "the flow drops pairs");
    let report = folder.json("vis map.prt --shard 1/2 -o again.part");
    assert_eq!(
        (&report["shard"], &report["written"], &report["clusters"]),
        (&json!("1/2"), &json!("again.part"), &json!(81))
    );
    assert_eq!(report["bytes"], bytes(&folder, "again.part").len());
}

#[test]
fn a_shard_that_is_killed_goes_on_where_it_was() {
    let folder = baked();
    let parts = parts_of(&folder, 2);
    let whole = bytes(&folder, "1.part");
    fs::remove_file(folder.path("1.part")).expect("there");
    let shard = "vis map.bsp --shard 1/2 -o 1.part --save-every 0";
    let saved = folder.path("1.part.vis-unfinished");
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
    let other = shard.replace("1/2", "0/2");
    refused(
        &folder,
        &format!("{other} --resume"),
        &["1.part.vis-unfinished", "shard 1/2", "--resume"],
    );
    let text = done(&folder, &format!("{shard} --resume")).stdout;
    assert!(text.contains("resumed from the saved work"), "{text}");
    assert!(bytes(&folder, "1.part") == whole);
    assert!(!saved.exists());
    done(
        &folder,
        &format!("vis map.bsp -o all.bsp --merge {}", parts.join(" ")),
    );
    assert!(bytes(&folder, "all.bsp") == bytes(&folder, "one.bsp"));
}

#[test]
fn parts_of_a_map_that_do_not_belong_together_are_refused() {
    let folder = baked();
    parts_of(&folder, 3);
    let merge = "vis map.bsp -o all.bsp --merge";
    refused(
        &folder,
        &format!("{merge} 0.part 2.part"),
        &["1 of 3 parts missing: 1/3", "--shard 1/3"],
    );
    refused(
        &folder,
        &format!("{merge} 0.part 1.part 2.part 1.part"),
        &["1.part and 1.part are both part 1/3"],
    );
    done(&folder, "vis map.bsp --shard 1/2 -o half.part");
    refused(
        &folder,
        &format!("{merge} 0.part half.part 2.part"),
        &["half.part is part 1/2, but 0.part is part 0/3"],
    );
    refused(
        &folder,
        &format!("{merge} 0.part none.part"),
        &["none.part", "check the path"],
    );
    refused(
        &folder,
        &format!("{merge} map.prt"),
        &["map.prt: is not a part of this version", "vis --shard"],
    );
    let whole = bytes(&folder, "1.part");
    folder.add("cut.part", &whole[..whole.len() - 8]);
    refused(
        &folder,
        &format!("{merge} 0.part cut.part 2.part"),
        &["cut.part: is truncated or corrupt"],
    );
    let mut other = whole.clone();
    // The version in the magic number.
    other[6] -= 1;
    folder.add("old.part", other);
    refused(
        &folder,
        &format!("{merge} 0.part old.part 2.part"),
        &["old.part: is not a part of this version"],
    );
    folder.add("other.prt", Grid::row(8).prt());
    done(&folder, "vis other.prt --shard 1/3 -o other.part");
    refused(
        &folder,
        &format!("{merge} 0.part other.part 2.part"),
        &["other.part: is a part of other portals, not those of map.bsp"],
    );
    refused(&folder, "vis map.bsp --shard 0/2", &["--output"]);
    refused(
        &folder,
        "vis map.bsp --shard 0/2 -o x.bsp",
        &["x.bsp", "names a part and no map"],
    );
    refused(
        &folder,
        "vis map.bsp --shard 0/2 -o x.part --fast",
        &["cannot be used with"],
    );
    refused(
        &folder,
        "vis map.bsp --merge 0.part --fast",
        &["cannot be used with"],
    );
}
