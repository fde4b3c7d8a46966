//! `link`: separately exported files become one world; invalid worlds are refused with a reason.

use crate::support::{Folder, document, glb};
use serde_json::json;
use std::path::Path;

/// Two yards, 40 units apart; a gate in the first leads to the second.
const YARDS: &str = r#"
[[part]]
name = "near"
file = "scene.glb"
[[part]]
name = "far"
file = "scene.glb"
translation = [40, 0, 0]
rotation = { axis = [0, 1, 0], degrees = 90 }
[[portal]]
name = "gate"
from = { part = "near", center = [0, 1.5, 4], ahead = [0, 0, -1], size = [2, 2] }
to = { part = "far", center = [0, 1.5, 4], ahead = [0, 0, -1], size = [2, 2] }
"#;

fn refused(folder: &Folder, world: &str, words: &[&str]) {
    folder.add("world.toml", world);
    let run = folder.run("link world.toml -o world.glb");
    assert_eq!(run.code, Some(2), "{world}: {}{}", run.stdout, run.stderr);
    assert!(!folder.path("world.glb").exists(), "{world}");
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    for word in words {
        assert!(
            run.stderr.contains(word),
            "`{}` does not say `{word}`",
            run.stderr
        );
    }
}

#[test]
fn one_sees_from_a_part_into_another_through_a_teleport() {
    let folder = Folder::new();
    folder.add("world.toml", YARDS);
    let made = folder.json("link world.toml -o world.glb");
    assert_eq!(
        (&made["parts"], &made["rooms"], &made["portals"]),
        (&json!(2), &json!(2), &json!(1))
    );
    assert_eq!(
        folder.names(),
        ["scene.glb", "views.jsonl", "world.glb", "world.toml"]
    );
    // In front of the gate the far wall and table are visible, behind it only the near yard.
    let look = folder.json("look world.glb --eye 0,1.5,6 --toward 0,1.5,0 --check --size 160x90");
    let view = &look["views"][0];
    assert_eq!(view["passages"], 2);
    assert_eq!(view["check"]["missed"], json!([]));
    let visible = view["visible"].as_array().expect("a list");
    assert!(
        visible.contains(&json!("far/wall")) && visible.contains(&json!("near/floor")),
        "{visible:?}"
    );
    let back = folder.json("look world.glb --eye 0,1.5,3 --toward 0,1.5,6 --check --size 160x90");
    assert_eq!(back["views"][0]["passages"], 1);
    // The world has the cameras of both parts.
    let info = folder.json("info world.glb");
    let names: Vec<&str> = info["cameras"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|camera| camera["name"].as_str())
        .collect();
    assert_eq!(names.len(), 6);
    assert!(names.contains(&"far/front"), "{names:?}");
    assert_eq!(info["ways"][0]["kind"], "teleport");
    // A world can be a part of another.
    folder.add("more.toml", "[[part]]\nname = 'all'\nfile = 'world.glb'");
    folder.run("link more.toml -o more.glb");
    let more = folder.json("info more.glb");
    assert_eq!(more["sectors"][1]["name"], "all/far-room");
    assert_eq!(more["portals"], 1);
}

#[test]
fn openings_in_files_become_doors_between_parts_that_touch() {
    let folder = Folder::new();
    // Two open sheds, back to back at x = 3, and a square in the part `left` that touches no second room.
    let item = |name: &str, translation: [f64; 3], scale: [f64; 3]| json!({ "name": name, "mesh": 0, "translation": translation, "scale": scale });
    let square = json!({ "name": "Door-portal", "mesh": 0, "translation": [3, 1, 0], "scale": [0, 2, 1] });
    let shed = [
        item("floor", [0.0, 0.0, 0.0], [6.0, 0.1, 6.0]),
        item("back", [-3.0, 1.0, 0.0], [0.1, 2.0, 6.0]),
    ];
    folder.add("shed.glb", glb(&document(&shed, json!([]))));
    folder.add(
        "left.glb",
        glb(&document(&[shed[0].clone(), shed[1].clone(), square], json!([]))),
    );
    let world = |portal: &str| {
        format!(
            "[[part]]\nname = 'left'\nfile = 'left.glb'\n\
             [[part]]\nname = 'right'\nfile = 'shed.glb'\ntranslation = [6, 0, 0]\n\
             rotation = {{ axis = [0, 1, 0], degrees = 180 }}\n{portal}"
        )
    };
    for (portal, portals) in [
        (
            "[[portal]]\nname = 'd'\nfrom = { part = 'left', node = 'Door-portal' }\nto = { part = 'right' }",
            2,
        ),
        (
            "[[portal]]\nname = 'd'\nfrom = { part = 'left', node = 'Door-portal' }",
            2,
        ),
        (
            "[[portal]]\nname = 'd'\nfrom = { part = 'left', node = 'Door-portal' }\nto = { part = 'right' }\ntwo_way = false",
            1,
        ),
    ] {
        folder.add("world.toml", world(portal));
        let made = folder.json("link world.toml -o world.glb");
        assert_eq!(made["portals"], portals, "{portal}");
        assert_eq!(made["warnings"], json!([]), "{portal}");
    }
    let mirror = "[[portal]]\nname = 'm'\nfrom = { part = 'left', outline = [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]] }\nmirror = true";
    folder.add(
        "world.toml",
        world(&format!(
            "[[portal]]\nname = 'd'\nfrom = {{ part = 'left', node = 'Door-portal' }}\n{mirror}"
        )),
    );
    assert_eq!(folder.json("link world.toml -o world.glb")["portals"], 3);
    std::fs::remove_file(folder.path("world.glb")).expect("it is there");
    // A portal without `to` leads to the room behind it, so there must be one.
    refused(
        &folder,
        &world("").replace("[6, 0, 0]", "[60, 0, 0]"),
        &[
            "[[part]] \"left\"",
            "left/Door-portal",
            "touches only one room",
            "[[portal]]",
        ],
    );
}

#[test]
fn what_is_wrong_in_a_world_names_the_place_and_the_remedy() {
    let folder = Folder::new();
    folder.add("notes.txt", "hello");
    let portal = |text: &str| {
        let parts = YARDS.split("[[portal]]").next().expect("parts");
        format!("{parts}[[portal]]\nname = 'gate'\n{text}")
    };
    let from = "from = { part = 'near', center = [0, 1.5, 4], ahead = [0, 0, -1], size = [2, 2] }\n";
    for (world, words) in [
        ("".to_owned(), &["world.toml", "no [[part]]"][..]),
        (
            "[[part]]\nname = 'a'\n".to_owned(),
            &["world.toml", "line 1", "file"],
        ),
        (
            "[[part]]\nname = 'a'\nfile = 'no.glb'".to_owned(),
            &["[[part]] \"a\"", "no.glb", "cannot be read"],
        ),
        (
            "[[part]]\nname = 'a'\nfile = 'notes.txt'".to_owned(),
            &["[[part]] \"a\"", "is not glTF"],
        ),
        (
            "[[part]]\nname = 'a'\nfile = 'world.toml'".to_owned(),
            &["[[part]] \"a\"", "link world.toml first"],
        ),
        (
            "[[part]]\nname = 'a/b'\nfile = 'scene.glb'".to_owned(),
            &["without a /"],
        ),
        (
            "[[part]]\nname = 'a'\nfile = 'scene.glb'\nscale = 0".to_owned(),
            &["[[part]] \"a\"", "scale above 0"],
        ),
        (
            portal("from = { part = 'neer', node = 'x' }"),
            &["[[portal]] \"gate\"", "from", "did you mean near?"],
        ),
        (
            portal("from = { part = 'near', node = 'x' }"),
            &["from", "no node `x`"],
        ),
        (
            portal("from = { part = 'near' }"),
            &["from", "`node`", "`outline`"],
        ),
        (
            portal("from = { part = 'near', center = [0, 1, 2] }"),
            &["from", "`size`"],
        ),
        (
            portal("from = { part = 'near', center = [0, 1, 2], size = [1, 1] }"),
            &["from", "`ahead`"],
        ),
        (
            portal("from = { part = 'near', center = [0, 1, 2], size = [1, 0], ahead = [1, 0, 0] }"),
            &["from", "above 0"],
        ),
        (
            portal("from = { part = 'near', center = [0, 1, 2], size = [1, 1], ahead = [0, 0, 0] }"),
            &["from", "`ahead` must not be 0"],
        ),
        (
            portal("from = { part = 'near', node = 'wall', center = [0, 1, 2] }"),
            &["from", "given twice"],
        ),
        (
            portal("from = { part = 'near', size = [1, 2] }"),
            &["from", "`center`"],
        ),
        (
            portal("from = { part = 'near', outline = [[0, 0, 0], [1, 0, 0]] }"),
            &["from", "3 corners"],
        ),
        (
            portal("from = { part = 'near', outline = [[0, 0, 0], [1, 0, 0], [2, 0, 0]] }"),
            &["from", "no area"],
        ),
        (
            portal(
                "from = { part = 'near', outline = [[0, 0, 4], [1, 0, 4], [1, 1, 5], [0, 1, 4]] }\nmirror = true",
            ),
            &["[[portal]] \"gate\"", "not flat", "flatten"],
        ),
        (
            portal("from = { part = 'near', node = 'wall' }\nmirror = true"),
            &["[[portal]] \"gate\"", "near/wall", "not flat"],
        ),
        (
            portal(&format!("{from}mirror = true\nto = {{ part = 'far' }}")),
            &["[[portal]] \"gate\"", "a mirror leads back"],
        ),
        (
            portal(from),
            &["[[portal]] \"gate\"", "touches only one room", "near-room"],
        ),
        (
            portal(&format!("{from}to = {{ part = 'far', room = 'Hall' }}")),
            &["to", "no node `Hall`"],
        ),
        (
            portal(&format!(
                "{from}to = {{ part = 'far', center = [0, 1, 4], ahead = [0, 0, -1] }}\ntwo_way = true"
            )),
            &["[[portal]] \"gate\"", "to", "`size`"],
        ),
        (
            format!("{YARDS}\n[[portal]]\nname = 'gate'\n{from}"),
            &["two [[portal]]", "rename one"],
        ),
        (format!("{}\nwidth = 3", portal(from)), &["unknown field `width`"]),
    ] {
        refused(&folder, &world, words);
    }
    let run = folder.run("link nothing.toml -o world.glb");
    assert!(
        run.code == Some(2) && run.stderr.contains("cannot read nothing.toml"),
        "{}",
        run.stderr
    );
    let run = folder.run("link world.toml -o world.obj");
    assert!(
        run.code == Some(2) && run.stderr.contains("must end in .glb"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_world_is_no_part_of_itself_and_parts_in_one_place_are_warned_of() {
    let folder = Folder::new();
    folder.add("world.toml", "[[part]]\nname = 'a'\nfile = 'scene.glb'\n[[part]]\nname = 'b'\nfile = 'scene.glb'\ntranslation = [0.5, 0.2, 0.5]");
    let run = folder.run("link world.toml -o scene.glb");
    assert!(
        run.code == Some(2) && run.stderr.contains("it is the input scene.glb"),
        "{}",
        run.stderr
    );
    let run = folder.run("link world.toml -o world.glb");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(
        run.stderr.contains("no door joins them") && run.stderr.contains("along x"),
        "{}",
        run.stderr
    );
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn two_real_houses_are_seen_from_each_other() {
    let scenes = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(scenes);
    let file = |name: &str| {
        scenes
            .join(name)
            .canonicalize()
            .expect("it is in ENFILADE_SCENES")
    };
    let folder = Folder::new();
    folder.add(
        "world.toml",
        format!(
            "[[part]]\nname = 'duplex'\nfile = '{}'\n[[part]]\nname = 'haus'\nfile = '{}'\ntranslation = [40, 0, 0]\n\
             [[portal]]\nname = 'gate'\ntwo_way = true\n\
             from = {{ part = 'duplex', center = [7, 4.1, 12.03], ahead = [1, 0, 0], size = [1, 1.8] }}\n\
             to = {{ part = 'haus', center = [1.22, 2.5, -4.6], ahead = [0, 0, -1], size = [0.8, 0.8] }}\n",
            file("ifc_duplex.glb").display(),
            file("ifc_fzk_haus.glb").display()
        ),
    );
    assert_eq!(folder.json("link world.toml -o world.glb")["portals"], 2);
    for (eye, other) in [
        ("4.72,4.1,12.03 --toward 8.75,4.1,12.1", "haus/"),
        ("41.22,2.6,-7.5 --toward 41.22,2.5,-4", "duplex/"),
    ] {
        let look = folder.json(&format!("look world.glb --check --size 320x180 --eye {eye}"));
        let view = &look["views"][0];
        assert!(view["passages"].as_u64() > Some(1), "{eye}");
        assert_eq!(view["check"]["missed"], json!([]), "{eye}");
        let visible = view["visible"].as_array().expect("a list");
        assert!(
            visible
                .iter()
                .any(|name| name.as_str().is_some_and(|name| name.starts_with(other))),
            "{eye}"
        );
    }
}
