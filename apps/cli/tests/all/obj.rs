//! OBJ files work with every verb that reads a scene.

use crate::support::Folder;
use serde_json::json;

/// A red wall, a green pane in front of it, and a chest behind the wall.
const YARD: &str = "mtllib yard.mtl
o wall
usemtl red
v -4 0 0
v 4 0 0
v 4 3 0
v -4 3 0
f 1 2 3 4
o pane
usemtl green
v -1 0 2
v 1 0 2
v 1 2 2
v -1 2 2
f -4 -3 -2 -1
o chest
v -1 0 -2
v 1 0 -2
v 0 1 -2
f -3 -2 -1
";

fn yard() -> Folder {
    let folder = Folder::new();
    folder.add("yard.obj", YARD);
    folder.add(
        "yard.mtl",
        "newmtl red\nKd 1 0 0\nnewmtl green\nKd 0 1 0\nd 0.5\n",
    );
    folder
}

const FROM_THE_FRONT: &str = "--eye 0,1.5,8 --toward 0,1.5,0 --size 64x36";

#[test]
fn info_says_what_is_in_an_obj_file() {
    let info = yard().json("info yard.obj");
    for (key, value) in [
        ("format", json!("OBJ")),
        ("items", json!(3)),
        ("triangles_drawn", json!(5)),
        ("sectors", json!(1)),
        ("portals", json!(0)),
        ("cameras", json!([])),
        ("warnings", json!([])),
    ] {
        let found = if key == "sectors" {
            json!(info[key].as_array().map(Vec::len))
        } else {
            info[key].clone()
        };
        assert_eq!(found, value, "{key}");
    }
    assert_eq!(
        (&info["materials"]["blend"], &info["materials"]["double_sided"]),
        (&json!(1), &json!(3))
    );
    assert_eq!(info["sectors"][0]["name"], "yard");
}

#[test]
fn what_an_obj_file_shows_is_what_rays_see() {
    let folder = yard();
    let report = folder.json(&format!("look yard.obj {FROM_THE_FRONT} --method all --check"));
    for method in report["methods"].as_array().expect("a list") {
        let summary = &method["summary"];
        assert!(
            summary["missed"] == 0 || method["contract"] == "approximate",
            "{method}"
        );
    }
    let report = folder.json(&format!("look yard.obj {FROM_THE_FRONT}"));
    assert_eq!(
        report["views"][0]["items_visible"], 2,
        "the chest is behind the wall"
    );
    let back = folder.json("look yard.obj --eye 0,1.5,-8 --toward 0,1.5,0 --size 64x36");
    assert_eq!(
        back["views"][0]["items_visible"], 2,
        "the wall is seen from both sides"
    );
}

#[test]
fn an_obj_file_is_drawn_and_compared() {
    let folder = yard();
    let run = folder.run(&format!("draw yard.obj -o yard.png {FROM_THE_FRONT}"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let picture = image::open(folder.path("yard.png"))
        .expect("a picture")
        .into_rgb8();
    let [r, g, b] = picture.get_pixel(45, 20).0;
    assert!(r > 2 * g.max(b), "the wall is red: {r} {g} {b}");
    let [r, g, b] = picture.get_pixel(32, 20).0;
    assert!(
        g > b && r > b,
        "the wall is seen through green glass: {r} {g} {b}"
    );
    let run = folder.run(&format!(
        "compare yard.obj -o page.html --pictures 1 --method z-buffer {FROM_THE_FRONT}"
    ));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}

#[test]
fn odd_obj_files_warn_and_broken_ones_are_told_where() {
    let folder = yard();
    std::fs::remove_file(folder.path("yard.mtl")).expect("it is there");
    let run = folder.run("info yard.obj");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for words in [
        "yard.obj: material files cannot be read (yard.mtl: ",
        "yard.obj: undefined materials are grey, and hide nothing (red, green)",
    ] {
        assert!(run.stderr.contains(words), "{}", run.stderr);
    }
    folder.add("broken.obj", YARD.replace("f -3 -2 -1", "f -3 -2 12"));
    for verb in ["info", "look", "draw -o a.png", "compare -o a.html"] {
        let run = folder.run(&format!("{verb} broken.obj"));
        assert_eq!(run.code, Some(2), "{verb}: {}", run.stderr);
        let says = "broken.obj: line 20: `12` names position 12, but the file has only 11";
        assert!(run.stderr.contains(says), "{verb}: {}", run.stderr);
    }
    folder.add("world.toml", "[[part]]\nname = 'yard'\nfile = 'yard.obj'");
    let run = folder.run("link world.toml -o world.glb");
    assert_eq!(run.code, Some(2), "{}", run.stderr);
    let says = "is not glTF: it begins with `mtllib yard.`; name a glTF 2.0 file";
    assert!(run.stderr.contains(says), "{}", run.stderr);
}
