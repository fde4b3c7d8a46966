//! `bake`: a baked scene is the scene for every verb, opens whatever the machine, and is refused if it is damaged.

use crate::support::Folder;
use crate::support::quake::Grid;
use serde_json::{Value, json};
use std::fs;

/// Removes what no two runs have in common: times, and the name, format and memory of the file.
fn without_times(value: &mut Value) {
    match value {
        Value::Object(entries) => {
            entries.retain(|key, _| {
                !(key.ends_with("ms")
                    || key.starts_with("ms_")
                    || ["file", "format", "bytes", "scenes", "sections"].contains(&&**key))
            });
            entries.values_mut().for_each(without_times);
        }
        Value::Array(list) => list.iter_mut().for_each(without_times),
        _ => {}
    }
}

#[test]
fn looks_at_a_baked_scene_find_the_same_and_do_the_same_work() {
    let folder = Folder::new();
    folder.add("map.bsp", Grid::row(3).bsp());
    for scene in ["scene.glb", "@two-rooms", "map.bsp"] {
        let baked = folder.json(&format!("bake {scene} -o baked.enf"));
        let length = fs::metadata(folder.path("baked.enf")).expect("it is there").len();
        assert_eq!(
            (&baked["bytes"], &baked["file"]),
            (&json!(length), &json!("baked.enf"))
        );
        let kinds: Vec<&str> = baked["sections"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|section| section["kind"].as_str().expect("a name"))
            .collect();
        assert!(
            ["scene", "meshes", "items", "names"]
                .iter()
                .all(|kind| kinds.contains(kind))
        );
        let [mut before, mut after] = [scene, "baked.enf"].map(|scene| {
            folder.json(&format!(
                "look {scene} --survey 3 --method all --size 96x54 --check"
            ))
        });
        without_times(&mut before);
        without_times(&mut after);
        assert!(before == after, "{scene}");
        let mut info = folder.json("info baked.enf");
        assert_eq!(
            (&info["format"], &info["sections"]),
            (&json!("baked scene"), &baked["sections"])
        );
        let mut plain = folder.json(&format!("info {scene}"));
        without_times(&mut info);
        without_times(&mut plain);
        if scene.starts_with('@') {
            // A baked scene without the nodes of glTF does not tell which way is up.
            assert_eq!(
                (&info["up_from"], &plain["up_from"]),
                (&json!("floors"), &json!("format"))
            );
            info["up_from"] = plain["up_from"].clone();
        }
        assert_eq!(info, plain, "{scene}");
    }
}

#[test]
fn the_same_scene_gives_the_same_bytes_and_the_same_picture() {
    let folder = Folder::new();
    let bake = |arguments: &str| {
        let run = folder.run(&format!("bake scene.glb -o baked.enf {arguments}"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        fs::read(folder.path("baked.enf")).expect("a file")
    };
    let once = bake("--threads 1");
    assert!(once == bake("--threads 3"));
    let picture = |scene: &str| {
        let run = folder.run(&format!("draw {scene} -o picture.png --size 64x36"));
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        fs::read(folder.path("picture.png")).expect("a file")
    };
    assert!(picture("scene.glb") == picture("baked.enf"));
}

#[test]
fn rooms_are_kept_and_flat_is_decided_when_baking_or_looking() {
    let folder = Folder::new();
    folder.json("bake @two-rooms -o rooms.enf");
    let names = |arguments: &str| folder.json(arguments)["views"][0]["passages"].clone();
    let [all, flat] =
        ["", " --flat"].map(|flat| names(&format!("look rooms.enf --size 64x36 --method masked{flat}")));
    assert_eq!(all, names("look @two-rooms --size 64x36 --method masked"));
    assert_eq!((all.as_u64() > Some(1), flat), (true, json!(1)));
}

#[test]
fn a_baked_scene_that_is_damaged_or_of_another_kind_is_refused_with_a_remedy() {
    let folder = Folder::new();
    folder.json("bake scene.glb -o whole.enf");
    let whole = fs::read(folder.path("whole.enf")).expect("a file");
    let refused = |bytes: &[u8], words: &[&str]| {
        folder.add("bad.enf", bytes);
        for verb in ["look", "info", "draw -o picture.png"] {
            let run = folder.run(&format!("{verb} bad.enf"));
            assert_eq!(run.code, Some(2), "{}", run.stdout);
            for word in words.iter().chain(&["bad.enf", "bake it again"]) {
                assert!(
                    run.stderr.contains(word),
                    "`{}` does not say `{word}`",
                    run.stderr
                );
            }
            assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
        }
    };
    let with = |at: usize, byte: u8| {
        let mut bytes = whole.clone();
        bytes[at] = byte;
        bytes
    };
    refused(&whole[..whole.len() - 1], &["but the file has"]);
    refused(&whole[..40], &["but the file has"]);
    refused(&[&whole[..], &[0]].concat(), &["but the file has"]);
    refused(&with(8, 99), &["format 99"]);
    refused(&with(20, whole[20] ^ 1), &["`header`"]);
    // The first section.
    refused(&with(100, whole[100] ^ 1), &["`page 0`"]);
    refused(&with(whole.len() - 3, 0x5A), &["`table of sections`"]);
    // Cut before the magic number ends, it is of no format.
    folder.add("bad.enf", &whole[..7]);
    assert_eq!(folder.run("look bad.enf").code, Some(2));
    let run = folder.run("bake scene.glb -o scene2.glb");
    assert!(
        run.code == Some(2) && run.stderr.contains(".enf"),
        "{}",
        run.stderr
    );
    assert!(!folder.path("scene2.glb").exists());
    let run = folder.run("bake whole.enf -o whole.enf");
    assert!(
        run.code == Some(2) && run.stderr.contains("it is the input"),
        "{}",
        run.stderr
    );
    let run = folder.run("bake whole.enf -o flat.enf --flat");
    assert!(
        run.code == Some(2) && run.stderr.contains("--flat"),
        "{}",
        run.stderr
    );
}

/// Three tiles of one room each, and one with portals.
fn tiles() -> Folder {
    let folder = Folder::new();
    fs::copy(folder.path("scene.glb"), folder.path("east.glb")).expect("copied");
    folder.add("west.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3");
    fs::create_dir(folder.path("parts")).expect("a folder");
    folder
}

const TILES: &str = "bake scene.glb east.glb west.obj @two-rooms";

/// Returns the tiles that were baked, and those that were up to date.
fn parts(folder: &Folder, arguments: &str) -> [usize; 2] {
    let report = folder.json(arguments);
    ["parts_baked", "parts_unchanged"].map(|key| report[key].as_array().expect("a list").len())
}

#[test]
fn a_world_has_the_same_bytes_at_once_in_shares_and_again() {
    let folder = tiles();
    folder.json(&format!("{TILES} -o world.enf"));
    let world = || fs::read(folder.path("world.enf")).expect("a file");
    let at_once = world();
    let rooms = folder.json("info world.enf");
    let names: Vec<&str> = rooms["sectors"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|sector| sector["name"].as_str().expect("a name"))
        .collect();
    assert!(
        names[0] == "world" && names[1..].iter().all(|name| name.starts_with("two-rooms/")),
        "{names:?}"
    );
    let run = folder.run(&format!("{TILES} --parts parts --merge -o world.enf"));
    assert_eq!(run.code, Some(2), "{}", run.stdout);
    assert!(run.stderr.contains("scene.enf is missing"), "{}", run.stderr);
    assert!(world() == at_once, "the old file stays");
    // Five shares of four tiles, the last first.
    let shares: Vec<[usize; 2]> = (0..5)
        .rev()
        .map(|share| parts(&folder, &format!("{TILES} --parts parts --shard {share}/5")))
        .collect();
    assert_eq!(shares, [[0, 0], [1, 0], [1, 0], [1, 0], [1, 0]]);
    assert_eq!(
        parts(&folder, &format!("{TILES} --parts parts --merge -o world.enf")),
        [0, 4]
    );
    assert!(world() == at_once);
    assert_eq!(
        parts(&folder, &format!("{TILES} --parts parts -o world.enf")),
        [0, 4]
    );
    assert!(world() == at_once);
}

#[test]
fn after_an_edit_only_the_edited_tile_is_baked_again_and_so_is_a_damaged_one() {
    let folder = tiles();
    let bake = format!("{TILES} --parts parts -o world.enf");
    assert_eq!(parts(&folder, &bake), [4, 0]);
    let same_as_at_once = || {
        let world = fs::read(folder.path("world.enf")).expect("a file");
        folder.json(&format!("{TILES} -o world.enf"));
        assert!(world == fs::read(folder.path("world.enf")).expect("a file"));
    };
    // A vertex moves, a face is added, and a material file appears.
    for text in [
        "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3",
        "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\nf 3 2 1",
        "mtllib west.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3",
    ] {
        folder.add("west.obj", text);
        assert_eq!(parts(&folder, &bake), [1, 3]);
        same_as_at_once();
    }
    folder.add("west.mtl", "newmtl red\nKd 1 0 0\n");
    assert_eq!(parts(&folder, &bake), [1, 3]);
    same_as_at_once();
    assert_eq!(parts(&folder, &format!("{bake} --skip-bad-portals")), [4, 0]);
    assert_eq!(parts(&folder, &bake), [4, 0]);
    let part = folder.path("parts/east.enf");
    let mut bytes = fs::read(&part).expect("a part");
    bytes[200] ^= 1;
    fs::write(&part, bytes).expect("damaged");
    assert_eq!(parts(&folder, &bake), [1, 3]);
    same_as_at_once();
}

#[test]
fn shares_and_tiles_that_make_no_sense_are_refused() {
    let folder = tiles();
    for (arguments, word) in [
        ("bake scene.glb", "-o"),
        ("bake -o a.enf", "SCENE"),
        ("bake scene.glb --shard 0/2", "--parts"),
        ("bake scene.glb --parts parts --shard 2/2", "the last of 2 is 1/2"),
        ("bake scene.glb --parts parts --shard 0/2 -o a.enf", "-o"),
        ("bake scene.glb --parts nowhere -o a.enf", "no such folder"),
        ("bake scene.glb --merge -o a.enf", "--parts"),
        ("bake scene.glb parts/scene.glb -o a.enf", "different names"),
        ("bake scene.glb absent.glb -o a.enf", "absent.glb"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stdout);
        assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
        assert!(!folder.path("a.enf").exists(), "{arguments}");
    }
}

#[test]
fn a_tile_with_a_damaged_image_is_baked_again() {
    let folder = Folder::new();
    folder.add("map.bsp", crate::support::map::map(true));
    let bake = "bake map.bsp --parts . -o world.enf";
    assert_eq!(parts(&folder, bake), [1, 0]);
    let part = folder.path("map.enf");
    let mut bytes = fs::read(&part).expect("a part");
    let image = bytes
        .windows(4)
        .position(|word| word == b"IDAT")
        .expect("an image");
    bytes[image + 6] ^= 1;
    fs::write(&part, bytes).expect("damaged");
    assert_eq!(parts(&folder, bake), [1, 0]);
    assert_eq!(parts(&folder, bake), [0, 1]);
}

#[test]
fn hints_have_the_same_bytes_at_once_in_shares_and_again() {
    let folder = Folder::new();
    folder.json("bake @two-rooms -o rooms.enf");
    let looks = || {
        let mut looks = folder.json("look rooms.enf --survey 3 --method all --size 96x54");
        without_times(&mut looks);
        looks
    };
    let before = looks();
    let info = folder.json("info rooms.enf");
    let rooms = info["sectors"].as_array().expect("a list").len();
    let report = folder.json("hints rooms.enf -o hinted.enf --check 4");
    assert_eq!(
        (&report["regions"], &report["sampled"]),
        (&json!(rooms), &json!(rooms))
    );
    assert!(report["items"].as_u64() > Some(rooms as u64));
    let views = |key: &str| report["check"][key].as_u64().expect("a number");
    assert!(views("views") > 0 && 10 * views("views_covered") >= 9 * views("views"));
    let hinted = fs::read(folder.path("hinted.enf")).expect("a file");
    let run = folder.run("hints rooms.enf --parts . --merge");
    assert!(
        run.code == Some(2) && run.stderr.contains("rooms.enf.00000.hint is missing"),
        "{}",
        run.stderr
    );
    let shares = ["2/3", "0/3", "1/3", "1/3"]
        .map(|share| folder.json(&format!("hints rooms.enf --parts . --shard {share}"))["sampled"].clone());
    let sampled: u64 = shares.iter().filter_map(Value::as_u64).sum();
    assert_eq!((sampled, &shares[3]), (rooms as u64, &json!(0)));
    // One is cut off, as by a full disk.
    fs::write(folder.path("rooms.enf.00000.hint"), "{\"source\":").expect("written");
    assert_eq!(
        folder.json("hints rooms.enf --parts . --shard 0/3")["sampled"],
        json!(1)
    );
    let merged = folder.json("hints rooms.enf --parts . --merge");
    assert_eq!(merged["sampled"], json!(0));
    assert!(fs::read(folder.path("rooms.enf")).expect("a file") == hinted);
    assert_eq!(looks(), before);
    // The hints of a scene before an edit are not those of the scene.
    folder.json("bake scene.glb -o rooms.enf");
    let run = folder.run("hints rooms.enf --parts . --merge");
    assert!(
        run.code == Some(2) && run.stderr.contains("of another scene"),
        "{}",
        run.stderr
    );
}

#[test]
fn hints_of_what_is_no_baked_scene_are_refused() {
    let folder = Folder::new();
    folder.json("bake scene.glb -o scene.enf");
    for (arguments, word) in [
        ("hints", "SCENE.enf"),
        ("hints scene.glb", "bake it first"),
        ("hints absent.enf", "absent.enf"),
        ("hints scene.enf --shard 0/2", "--parts"),
        ("hints scene.enf --parts nowhere", "no such folder"),
        ("hints scene.enf --positions 0", "1..=10000"),
        ("hints scene.enf --memory 99", "more than"),
        ("hints scene.enf -o scene2.glb", ".enf"),
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "{arguments}: {}", run.stdout);
        assert!(run.stderr.contains(word), "{arguments}: {}", run.stderr);
    }
}
