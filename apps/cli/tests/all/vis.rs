//! `vis`: writes the PVS into maps, as a whole or not at all, however the run ends.

use crate::support::Folder;
use crate::support::quake::Grid;
use crate::support::quake::rows::{lump, seen_in_quake};
use serde_json::{Value, json};
use std::fs;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A folder with `map.bsp` and `map.prt`, and nothing else.
fn folder_of(grid: &Grid) -> Folder {
    let folder = Folder::empty();
    folder.add("map.bsp", grid.bsp());
    folder.add("map.prt", grid.prt());
    folder
}

fn map(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).expect("a map")
}

#[test]
fn a_map_gets_what_is_visible_and_nothing_is_left_behind() {
    let grid = Grid {
        // Two aligned doors, and one far aside.
        door: |from, _| if from < 2 { 0 } else { 80 },
        ..Grid::row(3)
    };
    let folder = folder_of(&grid);
    let run = folder.run("vis map.bsp --check=100000");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in [
        "map.bsp: 9 leafs in 9 clusters, 12 portals",
        "visible pairs",
        "100,000 random lines: no pair is missing",
        "written to map.bsp",
    ] {
        assert!(
            run.stdout.contains(words),
            "`{}` does not say `{words}`",
            run.stdout
        );
    }
    let map = map(&folder, "map.bsp");
    assert!(
        seen_in_quake(&map, 1).starts_with(&[1, 2, 3]),
        "through two aligned doors"
    );
    for from in 1..=9 {
        let seen = seen_in_quake(&map, from);
        assert!(seen.contains(&from));
        assert!(
            seen.iter().all(|&to| seen_in_quake(&map, to).contains(&from)),
            "visibility is symmetric"
        );
    }
    assert_eq!(folder.names(), ["map.bsp", "map.bsp.bak", "map.prt"]);
}

#[test]
fn the_map_that_is_overwritten_is_named_before_and_kept_once() {
    let folder = folder_of(&Grid::row(3));
    let first = map(&folder, "map.bsp");
    let run = folder.run("vis map.bsp --no-backup");
    assert_eq!(run.stderr, "map.bsp will be overwritten, without a backup\n");
    assert_eq!(folder.names(), ["map.bsp", "map.prt"]);
    let once = map(&folder, "map.bsp");
    folder.add("map.bsp", &first);
    let run = folder.run("vis map.bsp --no-ambient");
    let note = "map.bsp will be overwritten; the old map is kept as map.bsp.bak\n";
    assert_eq!(run.stderr, note);
    assert!(
        run.stdout.contains("; the old map is in map.bsp.bak"),
        "{}",
        run.stdout
    );
    assert!(map(&folder, "map.bsp.bak") == first);
    let report = folder.json("vis map.bsp");
    assert!(map(&folder, "map.bsp") == once && map(&folder, "map.bsp.bak") == first);
    assert_eq!(report["backup"], Value::Null, "an earlier run has kept it");
    folder.add("copy.bsp", "somebody's map");
    let report = folder.json("vis map.bsp -o copy.bsp");
    assert_eq!(report["backup"], "copy.bsp.bak");
    assert!(map(&folder, "copy.bsp") == once && map(&folder, "copy.bsp.bak") == b"somebody's map");
    assert!(map(&folder, "map.bsp.bak") == first);
}

/// Appends a BSPX block, as light and qbsp do.
fn with_bspx(map: &[u8]) -> Vec<u8> {
    let mut map = map.to_vec();
    map.resize(map.len().next_multiple_of(4), 0);
    let start = map.len() as u32 + 8 + 32;
    map.extend_from_slice(b"BSPX\x01\0\0\0RGBLIGHTING\0\0\0\0\0\0\0\0\0\0\0\0\0");
    map.extend([start, 9].map(u32::to_le_bytes).concat());
    map.extend_from_slice(b"red green");
    map
}

/// Returns the bytes of the BSPX block, found as engines find it: behind the furthest lump.
fn lighting(map: &[u8]) -> &[u8] {
    let ends = (0..if map.starts_with(b"IBSP") { 17 } else { 15 }).map(|number| lump(map, number).end);
    let at = ends.max().expect("lumps").next_multiple_of(4);
    assert_eq!(&map[at..at + 4], b"BSPX");
    let word = |at: usize| u32::from_le_bytes(map[at..at + 4].try_into().expect("four")) as usize;
    &map[word(at + 32)..][..word(at + 36)]
}

#[test]
fn colored_light_of_a_map_is_found_after_each_way_to_write_its_pvs() {
    use crate::carved::{Format, TWO_ROOMS, carved};
    let folder = Folder::empty();
    let grid = Grid::row(3);
    folder.add("quake.bsp", with_bspx(&grid.bsp()));
    folder.add("quake.prt", grid.prt());
    let quake3 = carved(&TWO_ROOMS).bytes(Format::Ibsp46);
    folder.add("quake3.bsp", with_bspx(&quake3));
    assert_eq!(folder.run("portals quake3.bsp").code, Some(0));
    for name in ["quake", "quake3"] {
        let before = map(&folder, &format!("{name}.bsp"));
        assert_eq!(lighting(&before), b"red green");
        for (arguments, target) in [
            ("-o copy.bsp", "copy.bsp"),
            ("--seconds 0", "NAME.bsp"),
            ("--resume", "NAME.bsp"),
            ("", "NAME.bsp"),
            ("--fast --no-ambient", "NAME.bsp"),
            ("", "NAME.bsp"),
        ] {
            let run = folder.run(&format!("vis {name}.bsp {arguments}"));
            assert_eq!(run.code, Some(0), "{name} {arguments}: {}", run.stderr);
            let map = map(&folder, &target.replace("NAME", name));
            assert_eq!(lighting(&map), b"red green", "{name} {arguments}");
            // Rows of the PVS, and the leafs of Quake that name them, may differ.
            let written: &[usize] = if name == "quake" { &[4, 10] } else { &[16] };
            let lumps = 0..if name == "quake" { 15 } else { 17 };
            for number in lumps.filter(|number| !written.contains(number)) {
                let [old, new] = [&before, &map].map(|map| &map[lump(map, number)]);
                assert!(old == new, "{name} {arguments}: lump {number}");
            }
        }
    }
}

#[test]
fn a_copy_leaves_the_map_as_it_is() {
    let folder = folder_of(&Grid::row(4));
    let before = map(&folder, "map.bsp");
    let report = folder.json("vis map.bsp -o copy.bsp");
    assert_eq!(map(&folder, "map.bsp"), before);
    assert_eq!(report["written"], "copy.bsp");
    for (key, value) in [
        ("leafs", json!(16)),
        ("clusters", json!(16)),
        ("portals", json!(24)),
        ("complete", json!(true)),
        ("bound", json!("full")),
        ("symmetric", json!(true)),
        ("format", json!("PRT2")),
    ] {
        assert_eq!(report[key], value, "{key}");
    }
    let pairs: usize = (1..=16)
        .map(|leaf| seen_in_quake(&map(&folder, "copy.bsp"), leaf).len() - 1)
        .sum();
    assert_eq!(report["pairs"], pairs);
    assert!(report["pairs_proven"].as_u64().expect("a number") as usize <= pairs);
    assert_eq!(report["average_leafs"], (pairs + 16) as f64 / 16.0);
    assert!(report["bytes"].as_u64().expect("a number") > 16);
    assert!(report["seconds"]["flow"].is_number() && report["threads"].is_number());
}

#[test]
fn the_portals_are_found_beside_the_map_or_where_one_says() {
    let folder = folder_of(&Grid::row(3));
    folder.add("map.novis.bsp", map(&folder, "map.bsp"));
    folder.add("elsewhere.bsp", map(&folder, "map.bsp"));
    assert_eq!(folder.run("vis map.novis.bsp").code, Some(0));
    assert_eq!(folder.run("vis elsewhere.bsp --prt map.prt").code, Some(0));
    assert_eq!(map(&folder, "map.novis.bsp"), map(&folder, "elsewhere.bsp"));
    let report = folder.json("vis map.prt");
    assert_eq!(
        (&report["written"], &report["clusters"]),
        (&json!(null), &json!(9))
    );
}

#[test]
fn a_fast_run_leaves_nothing_but_the_map() {
    let folder = folder_of(&Grid::row(7));
    folder.json("vis map.bsp --fast --save-every 0");
    assert_eq!(folder.names(), ["map.bsp", "map.bsp.bak", "map.prt"]);
}

#[test]
fn the_fast_bound_sees_no_less() {
    let folder = folder_of(&Grid::row(7));
    let full = folder.json("vis map.bsp -o full.bsp");
    let fast = folder.json("vis map.bsp -o fast.bsp --fast");
    assert_eq!(fast["bound"], "fast");
    assert!(fast["pairs"].as_u64() > full["pairs"].as_u64(), "{fast}");
    let [full, fast] = ["full.bsp", "fast.bsp"].map(|name| map(&folder, name));
    for leaf in 1..=49 {
        let fast = seen_in_quake(&fast, leaf);
        assert!(seen_in_quake(&full, leaf).iter().all(|to| fast.contains(to)));
    }
}

#[test]
fn pairs_in_which_another_vis_differs_are_listed_with_what_speaks_for_them() {
    let folder = folder_of(&Grid::row(7));
    folder.json("vis map.bsp -o right.bsp");
    folder.json("vis map.bsp -o fast.bsp --fast");
    let same = folder.json("vis map.bsp -o copy.bsp --compare right.bsp")["compare"].clone();
    assert_eq!(same["missing_there"], json!([]));
    assert_eq!(same["more_there"], json!([]));

    let more = folder.json("vis map.bsp -o copy.bsp --compare fast.bsp");
    let listed = more["compare"]["more_there"].as_array().expect("a list");
    let [pairs, there] = [&more["pairs"], &more["compare"]["other_pairs"]].map(|count| count.as_u64());
    assert!(!listed.is_empty());
    assert_eq!(
        there.expect("a count") - pairs.expect("a count"),
        listed.len() as u64
    );
    for pair in listed {
        assert!(
            pair["blocked_by"]
                .as_str()
                .is_some_and(|why| why.contains("chain")),
            "{pair}"
        );
    }

    // A PVS whose first leaf sees only itself: row 0 belongs to leaf 1.
    let mut blind = map(&folder, "right.bsp");
    let row = lump(&blind, 4).start;
    blind[row] = 1;
    folder.add("blind.bsp", &blind);
    let run = folder.run("vis map.bsp -o copy.bsp --compare blind.bsp --json blind.json");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("that it misses") && run.stdout.contains("the line from"),
        "{}",
        run.stdout
    );
    let report: Value = serde_json::from_slice(&map(&folder, "blind.json")).expect("JSON");
    let missing = report["compare"]["missing_there"].as_array().expect("a list");
    assert!(!missing.is_empty());
    for pair in missing {
        let clusters = pair["witness"]["clusters"].as_array().expect("a line of sight");
        assert_eq!(
            (clusters.first(), clusters.last()),
            (Some(&pair["from"]), Some(&pair["to"]))
        );
    }

    let refusals = [
        ("map.bsp", "map.bsp"),
        ("other.bsp", "another map"),
        ("nothing.bsp", "nothing.bsp"),
    ];
    let other = Folder::empty();
    other.add("other.bsp", Grid::row(4).bsp());
    other.add("other.prt", Grid::row(4).prt());
    other.json("vis other.bsp");
    folder.add("other.bsp", map(&other, "other.bsp"));
    for (name, word) in refusals {
        refused(&folder, &format!("vis map.bsp --compare {name}"), &[name, word]);
    }
}

#[test]
fn what_is_written_is_the_same_for_any_number_of_threads() {
    let folder = folder_of(&Grid::row(8));
    for threads in [1, 2, 4] {
        let run = folder.run(&format!("vis map.bsp -o {threads}.bsp --threads {threads}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    assert_eq!(map(&folder, "1.bsp"), map(&folder, "2.bsp"));
    assert_eq!(map(&folder, "1.bsp"), map(&folder, "4.bsp"));
}

#[test]
fn when_time_is_up_what_is_written_hides_nothing() {
    let folder = folder_of(&Grid::row(8));
    folder.json("vis map.bsp -o whole.bsp");
    let report = folder.json("vis map.bsp -o part.bsp --seconds 0 --check=10000");
    assert_eq!(report["complete"], false);
    let [whole, part] = ["whole.bsp", "part.bsp"].map(|name| map(&folder, name));
    for leaf in 1..=64 {
        let part = seen_in_quake(&part, leaf);
        assert!(seen_in_quake(&whole, leaf).iter().all(|to| part.contains(to)));
    }
}

#[test]
fn a_run_that_is_killed_again_and_again_ends_like_one_that_is_not() {
    let folder = folder_of(&Grid::row(9));
    folder.json("vis map.bsp -o whole.bsp");
    let saved = folder.path("part.bsp.vis-unfinished");
    let mut kills = 0;
    for _ in 0..3 {
        let before = fs::read(&saved).ok();
        let mut run = folder
            .command("vis map.bsp -o part.bsp --resume --save-every 0")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("it starts");
        while run.try_wait().expect("a state").is_none() {
            if fs::read(&saved).is_ok_and(|now| Some(now) != before) {
                run.kill().expect("it can be killed");
                run.wait().expect("it ends");
            } else {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        kills += usize::from(saved.exists());
    }
    assert!(kills > 0, "no run was caught at work");
    assert!(
        !folder.path("part.bsp").exists(),
        "an unfinished run writes no map"
    );
    let run = folder.run("vis map.bsp -o part.bsp --resume");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("resumed from the saved work"),
        "{}",
        run.stdout
    );
    assert_eq!(map(&folder, "part.bsp"), map(&folder, "whole.bsp"));
    assert_eq!(
        folder.names(),
        ["map.bsp", "map.prt", "part.bsp", "whole.bsp"],
        "the files of the killed runs are removed"
    );
}

#[cfg(unix)]
#[test]
fn a_run_that_is_interrupted_saves_its_work_and_says_how_to_go_on() {
    let folder = folder_of(&Grid::row(12));
    folder.json("vis map.bsp -o whole.bsp");
    let saved = folder.path("part.bsp.vis-unfinished");
    // A run may end before the signal arrives.
    let is_caught = (0..10).any(|_| {
        let mut run = folder
            .command("vis map.bsp -o part.bsp --save-every 0")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        while !saved.exists() && run.try_wait().expect("a state").is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let interrupt = Command::new("kill")
            .args(["-INT", &run.id().to_string()])
            .stderr(Stdio::null())
            .status();
        interrupt.expect("there is a command to send signals");
        let output = run.wait_with_output().expect("it ends");
        let stderr = String::from_utf8_lossy(&output.stderr);
        let is_caught = output.status.code() == Some(2);
        assert!(
            !is_caught || stderr.contains("the same command with --resume continues"),
            "{stderr}"
        );
        assert_ne!(is_caught, folder.path("part.bsp").exists());
        // A run that ended has written the copy.
        let _ = fs::remove_file(folder.path("part.bsp"));
        is_caught
    });
    assert!(is_caught, "no run was caught at work");
    let run = folder.run("vis map.bsp -o part.bsp --resume");
    assert!(
        run.stdout.contains("resumed from the saved work"),
        "{}",
        run.stdout
    );
    assert_eq!(map(&folder, "part.bsp"), map(&folder, "whole.bsp"));
}

#[test]
fn saved_work_that_is_of_no_use_is_said_so() {
    let folder = folder_of(&Grid::row(3));
    let run = folder.run("vis map.bsp --resume");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stdout.contains("started from the beginning"),
        "{}",
        run.stdout
    );
    folder.add("map.bsp.vis-unfinished", "something else");
    let run = folder.run("vis map.bsp --fast -o copy.bsp");
    assert_eq!(
        (run.code, run.stderr.as_str()),
        (Some(0), ""),
        "the saved work of another output is ignored"
    );
    let run = folder.run("vis map.bsp --seconds 0");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("--resume continues it"), "{}", run.stderr);
    let run = folder.run("vis map.bsp --resume");
    assert_eq!(run.code, Some(0), "it has been replaced: {}", run.stderr);
    folder.add("map.bsp.vis-unfinished", "something else");
    let run = folder.run("vis map.bsp --resume");
    assert_eq!(run.code, Some(2));
    assert!(
        run.stderr.contains("is not saved work of this version") && run.stderr.contains("leave out --resume")
    );
}

/// Asserts that a run fails with exit 2 and one message that contains the words, and leaves the map unchanged.
#[track_caller]
fn refused(folder: &Folder, arguments: &str, words: &[&str]) {
    let before = map(folder, "map.bsp");
    let run = folder.run(arguments);
    assert_eq!(run.code, Some(2), "{arguments}: {}", run.stdout);
    assert_eq!(run.stderr.lines().count(), 1, "one message: {}", run.stderr);
    for word in words {
        assert!(
            run.stderr.contains(word),
            "`{}` does not say `{word}`",
            run.stderr
        );
    }
    assert_eq!(map(folder, "map.bsp"), before, "{arguments}");
}

#[test]
fn what_cannot_be_done_is_said_in_one_message_and_the_map_is_untouched() {
    let folder = folder_of(&Grid::row(3));
    let prt = Grid::row(3).prt();
    refused(&folder, "vis nothing.bsp", &["nothing.bsp"]);
    refused(&folder, "vis map.map", &["map.map", ".bsp"]);
    refused(&folder, "vis map.bsp --prt other.prt", &["other.prt"]);
    refused(&folder, "vis map.prt -o copy.bsp", &["map.prt", "a report only"]);
    refused(&folder, "vis map.bsp -o copy.prt", &["copy.prt", ".bsp"]);
    refused(&folder, "vis map.bsp --memory 100", &["--memory"]);

    folder.add("lonely.bsp", map(&folder, "map.bsp"));
    refused(
        &folder,
        "vis lonely.bsp",
        &["lonely.prt", "--prt", "enfilade portals lonely.bsp"],
    );

    folder.add("map.prt", Grid::row(4).prt());
    refused(
        &folder,
        "vis map.bsp",
        &["map.bsp", "map.prt", "9 leafs", "have 16", "another map"],
    );
    let moved = Grid {
        at: 5000,
        ..Grid::row(3)
    };
    folder.add("map.prt", moved.prt());
    refused(
        &folder,
        "vis map.bsp",
        &["map.prt", "matches only", "another map"],
    );
    folder.add("map.prt", prt.replacen("4 0 1", "4 0 77", 1));
    refused(&folder, "vis map.bsp", &["map.prt", "line 5", "cell 77"]);
    folder.add("map.prt", prt.replacen("(100 ", "(103 ", 1));
    refused(&folder, "vis map.bsp", &["map.prt", "line 5", "not flat"]);
    folder.add("map.prt", "PRT1\n4000000000\n0\n");
    refused(&folder, "vis map.bsp", &["4000000000"]);
    refused(&folder, "vis map.prt", &["map.prt", "--memory"]);
    folder.add("map.prt", &prt);

    let whole = map(&folder, "map.bsp");
    folder.add("map.bsp", &whole[..whole.len() - 40]);
    refused(&folder, "vis map.bsp", &["map.bsp", "is damaged"]);
    folder.add("map.bsp", b"not a map at all");
    refused(&folder, "vis map.bsp", &["map.bsp", "not a compiled map"]);
    folder.add("map.bsp", &whole);

    let mut mode = fs::metadata(folder.path("map.bsp")).expect("there").permissions();
    mode.set_readonly(true);
    fs::set_permissions(folder.path("map.bsp"), mode).expect("set");
    refused(&folder, "vis map.bsp", &["map.bsp", "read-only", "-o"]);
    assert_eq!(folder.run("vis map.bsp -o copy.bsp").code, Some(0));
    assert_eq!(folder.names(), ["copy.bsp", "lonely.bsp", "map.bsp", "map.prt"]);
}

#[test]
fn command_lines_for_other_compilers_do_what_mappers_mean() {
    let folder = folder_of(&Grid::row(3));
    let ours = folder.json("vis map.bsp -o ours.bsp --fast");
    assert_eq!(
        ours["ambient"],
        json!({ "water": 0, "sky": 0, "lava": 0, "by": "contents" })
    );
    let run = folder.run("vis -level 2 -threads 1 -fast -noambientsky map -o theirs.bsp");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("-level 2: "), "{}", run.stderr);
    assert!(
        run.stdout.contains("fast upper bound") && run.stdout.contains("1 thread"),
        "{}",
        run.stdout
    );
    assert!(map(&folder, "theirs.bsp") == map(&folder, "ours.bsp"));
    let run = folder.run("vis -level 4 map -o full.bsp");
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""));
    let quiet = folder.json("vis map -noambient -o quiet.bsp");
    assert_eq!(quiet.get("ambient"), None);
}

#[test]
fn a_map_whose_textures_are_damaged_still_gets_what_is_visible() {
    let folder = folder_of(&Grid::row(3));
    let mut damaged = map(&folder, "map.bsp");
    // A texture lump of 3 bytes, at the offset of the entities: too short for its count.
    let entities = damaged[4..8].to_vec();
    damaged[4 + 8 * 2..][..4].copy_from_slice(&entities);
    damaged[4 + 8 * 2 + 4..][..4].copy_from_slice(&3u32.to_le_bytes());
    folder.add("map.bsp", damaged);
    let run = folder.run("vis map.bsp");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stderr.contains("no ambient sounds are written"),
        "{}",
        run.stderr
    );
    assert!(seen_in_quake(&map(&folder, "map.bsp"), 1).contains(&1));
}
