//! Maps that leak: every verb that misses their portals says so, and `vis` writes the line to the hole.

use crate::carved::{Format, Room, carved};
use crate::support::Folder;

/// A hall; with a hole, it joins the void.
fn map(has_hole: bool) -> Vec<u8> {
    const FAR: i32 = 200_000;
    let mut rooms = vec![Room([0, 0, 0], [256, 256, 128], -1)];
    if has_hole {
        rooms.push(Room([256, 96, 32], [272, 112, 48], -1));
        rooms.push(Room([272, -FAR, -FAR], [FAR, FAR, FAR], -1));
    }
    let mut bytes = carved(&rooms).bytes(Format::Bsp29);
    let entities = "{\"classname\" \"info_player_start\" \"origin\" \"40 40 24\"}";
    let entry = [bytes.len() as u32, entities.len() as u32]
        .map(u32::to_le_bytes)
        .concat();
    bytes[4..12].copy_from_slice(&entry);
    bytes.extend(entities.as_bytes());
    bytes
}

fn folder(has_hole: bool) -> Folder {
    let folder = Folder::empty();
    folder.add("map.bsp", map(has_hole));
    folder
}

#[test]
fn vis_of_a_map_that_leaks_writes_the_line_to_the_hole() {
    let folder = folder(true);
    for arguments in ["vis map.bsp", "vis map.bsp --parts . --prepare"] {
        let _ = std::fs::remove_file(folder.path("map.pts"));
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{}", run.stdout);
        for word in [
            "there is no map.prt",
            "has a leak",
            "info_player_start#0 at 40, 40, 24",
            "the void",
            "map.pts",
        ] {
            assert!(run.stderr.contains(word), "no `{word}`: {}", run.stderr);
        }
        let line = std::fs::read_to_string(folder.path("map.pts")).expect("written");
        assert!(line.starts_with("40.000 40.000 24.000\n"), "{line}");
        let last: Vec<f64> = line
            .lines()
            .last()
            .expect("points")
            .split(' ')
            .map(|number| number.parse().expect("a number"))
            .collect();
        assert!(last[0] > 272.0, "{last:?}");
    }
}

#[test]
fn portals_that_lead_into_the_void_are_warned_of() {
    let run = folder(true).run("portals map.bsp");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(run.stderr.contains("has a leak"), "{}", run.stderr);
    assert_eq!(folder(false).run("portals map.bsp").stderr, "");
}

#[test]
fn the_line_of_the_compiler_is_kept() {
    let folder = folder(true);
    folder.add("map.pts", "1 2 3\n");
    let run = folder.run("vis map.bsp");
    assert!(run.stderr.contains("map.pts is there already"), "{}", run.stderr);
    assert_eq!(
        std::fs::read_to_string(folder.path("map.pts")).expect("kept"),
        "1 2 3\n"
    );
}

#[test]
fn info_tells_of_a_leak_and_a_sealed_map_has_none() {
    let leaks = folder(true).json("info map.bsp");
    assert_eq!(leaks["map"]["leak"]["entity"], "info_player_start#0");
    let run = folder(true).run("info map.bsp");
    assert!(
        run.stdout.contains("has a leak") && run.stdout.contains("enfilade vis map.bsp"),
        "{}",
        run.stdout
    );
    let sealed = folder(false);
    assert!(sealed.json("info map.bsp")["map"]["leak"].is_null());
    let run = sealed.run("vis map.bsp");
    assert!(
        run.stderr.contains("there is no map.prt") && !run.stderr.contains("leak"),
        "{}",
        run.stderr
    );
    assert_eq!(sealed.names(), ["map.bsp"]);
}
