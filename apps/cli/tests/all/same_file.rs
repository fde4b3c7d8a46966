//! No output replaces an input or another output of the run, by whatever name it is called.
#![cfg(unix)]

use crate::support::quake::Grid;
use crate::support::{Folder, cube, document};
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;

/// A folder with an input of every kind, each with the files that belong to it.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.add("map.bsp", Grid::row(3).bsp());
    folder.add("map.prt", Grid::row(3).prt());
    folder.add(
        "carved.bsp",
        crate::carved::carved(&crate::carved::TWO_ROOMS).bytes(crate::carved::Format::Bsp2),
    );
    folder.add("world.toml", "[[part]]\nname = 'yard'\nfile = 'scene.glb'\n");
    folder.add("cubes.toml", "[[part]]\nname = 'cubes'\nfile = 'cube.gltf'\n");
    let mut cube_file = document(&[json!({ "name": "cube", "mesh": 0 })], json!([]));
    cube_file["buffers"][0]["uri"] = json!("cube%20sides.bin");
    cube_file["images"] = json!([{ "uri": "wood.png" }]);
    cube_file["textures"] = json!([{ "source": 0 }]);
    cube_file["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    cube_file["meshes"][0]["primitives"][0]["material"] = json!(0);
    folder.add("cube.gltf", cube_file.to_string());
    folder.add("cube sides.bin", cube());
    folder.add("wood.png", "not even a picture");
    folder.add(
        "three.obj",
        "mtllib three.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    );
    folder.add("three.mtl", "newmtl red\nmap_Kd red.png\n");
    folder.add("red.png", "not even a picture");
    let valley =
        json!({ "width": 2, "height": 2, "format": "u16 little endian", "cellMetresX": 1, "cellMetresZ": 1 });
    folder.add("valley.json", valley.to_string());
    folder.add("valley.raw", [0; 8]);
    fs::create_dir(folder.path("sub")).expect("a folder");
    folder
}

fn contents(folder: &Folder) -> BTreeMap<String, Option<Vec<u8>>> {
    let names = folder.names().into_iter();
    names
        .map(|name| (name.clone(), fs::read(folder.path(&name)).ok()))
        .collect()
}

#[track_caller]
fn refused(folder: &Folder, arguments: &[&str], words: &[&str]) {
    let before = contents(folder);
    let output = folder.command("").args(arguments).output().expect("it starts");
    let run = crate::support::Run::from(output);
    assert_eq!(run.code, Some(2), "{arguments:?}: {}{}", run.stdout, run.stderr);
    assert_eq!(run.stdout, "", "{arguments:?}");
    for word in words {
        assert!(
            run.stderr.contains(word),
            "{arguments:?} does not say `{word}`: {}",
            run.stderr
        );
    }
    assert!(contents(folder) == before, "{arguments:?} changes a file");
}

#[test]
fn an_output_that_is_an_input_is_refused_on_every_verb() {
    let folder = folder();
    for (arguments, input) in [
        ("vis map.bsp --json map.bsp", "map.bsp"),
        ("vis map.bsp --json map.prt", "map.prt"),
        ("vis map.bsp -o copy.bsp --json map.bsp", "map.bsp"),
        ("vis map.bsp -o carved.bsp --compare carved.bsp", "carved.bsp"),
        (
            "vis map.bsp -o copy.bsp --compare carved.bsp --json carved.bsp",
            "carved.bsp",
        ),
        ("vis map.prt --json map.prt", "map.prt"),
        ("portals carved.bsp --json carved.bsp", "carved.bsp"),
        ("look scene.glb --json scene.glb", "scene.glb"),
        (
            "look scene.glb --path views.jsonl --json views.jsonl",
            "views.jsonl",
        ),
        ("look map.bsp --json map.prt", "map.prt"),
        ("look three.obj --json three.mtl", "three.mtl"),
        ("look three.obj --json red.png", "red.png"),
        ("look cube.gltf --json wood.png", "wood.png"),
        ("look valley.json --json valley.json", "valley.json"),
        ("look valley.json --json valley.raw", "valley.raw"),
        ("draw scene.glb -o a.png --json scene.glb", "scene.glb"),
        (
            "draw scene.glb -o a.png --path views.jsonl --json views.jsonl",
            "views.jsonl",
        ),
        ("draw cube.gltf -o wood.png", "wood.png"),
        ("draw three.obj -o red.png", "red.png"),
        ("compare scene.glb -o a.html --json scene.glb", "scene.glb"),
        (
            "compare scene.glb -o a.html --path views.jsonl --json views.jsonl",
            "views.jsonl",
        ),
        ("bench scene.glb --json scene.glb", "scene.glb"),
        (
            "bench scene.glb --path views.jsonl --json views.jsonl",
            "views.jsonl",
        ),
        ("choose scene.glb -o scene.glb", "scene.glb"),
        ("choose scene.glb --json scene.glb", "scene.glb"),
        ("choose valley.json -o valley.raw", "valley.raw"),
        ("link world.toml -o scene.glb", "scene.glb"),
        ("link world.toml -o a.glb --json world.toml", "world.toml"),
        ("link world.toml -o a.glb --json scene.glb", "scene.glb"),
        ("link cubes.toml -o a.glb --json wood.png", "wood.png"),
        ("info scene.glb --json scene.glb", "scene.glb"),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        refused(
            &folder,
            &arguments,
            &["cannot write", &format!("the input {input}")],
        );
    }
    refused(
        &folder,
        &["info", "cube.gltf", "--json", "cube sides.bin"],
        &["the input cube sides.bin"],
    );
}

#[test]
fn two_outputs_in_one_file_are_refused() {
    let folder = folder();
    for (arguments, output) in [
        ("vis map.bsp -o copy.bsp --json copy.bsp", "copy.bsp"),
        (
            "vis map.bsp --json map.bsp.vis-unfinished",
            "map.bsp.vis-unfinished",
        ),
        ("vis map.bsp --json map.bsp.vis-passages", "map.bsp.vis-passages"),
        ("portals carved.bsp --json carved.prt", "carved.prt"),
        ("portals carved.bsp -o a.prt --json sub/../a.prt", "a.prt"),
        ("draw scene.glb -o a.png --json a.png", "a.png"),
        (
            "draw scene.glb -o a.png --path views.jsonl --json ./a-001.png",
            "a-001.png",
        ),
        (
            "draw scene.glb -o a.png --method all --json a-bsp.png",
            "a-bsp.png",
        ),
        ("compare scene.glb -o a.html --json a.html", "a.html"),
        ("choose scene.glb -o a.glb --json a.glb", "a.glb"),
        ("link world.toml -o a.glb --json a.glb", "a.glb"),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        refused(&folder, &arguments, &["cannot write", output, "one file"]);
    }
}

#[test]
fn other_names_of_a_file_are_that_file() {
    let folder = folder();
    fs::hard_link(folder.path("map.bsp"), folder.path("hard.json")).expect("a link");
    symlink("map.bsp", folder.path("soft.json")).expect("a link");
    symlink(".", folder.path("here")).expect("a link");
    let whole = folder.path("map.bsp").display().to_string();
    for json in [
        "hard.json",
        "soft.json",
        "./map.bsp",
        "sub/../map.bsp",
        "here/map.bsp",
        &whole,
    ] {
        refused(
            &folder,
            &["vis", "map.bsp", "--json", json],
            &[json, "the input map.bsp"],
        );
    }
    refused(
        &folder,
        &["vis", "map.bsp", "-o", "new.bsp", "--json", "here/new.bsp"],
        &["here/new.bsp", "one file"],
    );
    // A symbolic link to the map, as the map: vis writes through it.
    symlink("map.bsp", folder.path("soft.bsp")).expect("a link");
    refused(
        &folder,
        &["vis", "soft.bsp", "--prt", "map.prt", "--json", "map.bsp"],
        &["the input soft.bsp"],
    );
}

#[test]
fn vis_may_write_into_its_own_map_by_any_name() {
    for arguments in [
        "vis map.bsp",
        "vis map.bsp -o map.bsp",
        "vis map.bsp -o ./map.bsp",
    ] {
        let folder = folder();
        let before = fs::read(folder.path("map.bsp")).expect("a map");
        for again in ["", " --compare map.bsp"] {
            let run = folder.run(&format!("{arguments}{again}"));
            assert_eq!(run.code, Some(0), "{arguments}: {}", run.stderr);
        }
        assert_ne!(fs::read(folder.path("map.bsp")).expect("a map"), before);
    }
}

#[test]
fn devices_may_be_named_twice() {
    let folder = folder();
    symlink("/dev/null", folder.path("null.png")).expect("a link");
    let run = folder.run("draw scene.glb --size 16x9 -o null.png --json /dev/null");
    assert_eq!(run.code, Some(0), "{}", run.stderr);
}
