//! Scenes that do not stand on y: the up axis and the unit of OBJ files are found from their floors, or given.

use crate::support::{BOX_QUADS, Folder, document, glb};
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Boxes of a house of two storeys with y up, in metres, from their least to their greatest corner.
fn house() -> Vec<[[f64; 3]; 2]> {
    let mut boxes: Vec<[[f64; 3]; 2]> = [0.0, 3.0, 6.0]
        .map(|y| [[0.0, y - 0.3, 0.0], [12.0, y, 9.0]])
        .into();
    for low in [0.0, 3.0] {
        let high = low + 2.7;
        for x in [0.0, 6.0, 11.8] {
            boxes.push([[x, low, 0.0], [x + 0.2, high, 9.0]]);
        }
        for z in [0.0, 8.8] {
            boxes.push([[0.0, low, z], [12.0, high, z + 0.2]]);
        }
    }
    boxes
}

/// The house as OBJ: each point turned, and scaled.
fn obj(turned: impl Fn([f64; 3]) -> [f64; 3], scale: f64) -> String {
    let mut text = String::new();
    for (number, ends) in house().iter().enumerate() {
        let _ = writeln!(text, "o box{number}");
        for corner in 0..8 {
            let point = turned([0, 1, 2].map(|axis| ends[corner >> axis & 1][axis])).map(|part| part * scale);
            let _ = writeln!(text, "v {} {} {}", point[0], point[1], point[2]);
        }
        for quad in BOX_QUADS {
            let [a, b, c, d] = quad.map(|corner| 8 * number + usize::from(corner) + 1);
            let _ = writeln!(text, "f {a} {b} {c} {d}");
        }
    }
    text
}

fn with_z_up([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -z, y]
}

fn houses() -> Folder {
    let folder = Folder::new();
    folder.add("y.obj", obj(|point| point, 1.0));
    folder.add("z.obj", obj(with_z_up, 1.0));
    folder.add("mm.obj", obj(with_z_up, 1000.0));
    folder
}

/// The up vector of each view, and the height of its eye above the nearest floor below, along an axis.
fn eyes(report: &Value, axis: usize) -> Vec<(Value, f64)> {
    let views = report["views"].as_array().expect("views").iter();
    let eye = |view: &Value| view["eye"][axis].as_f64().expect("a number");
    views.map(|view| (view["up"].clone(), eye(view))).collect()
}

#[test]
fn the_survey_stands_on_the_floors_of_an_obj_file_whichever_axis_is_up() {
    let folder = houses();
    for (file, up, axis, metre) in [
        ("y.obj", json!([0.0, 1.0, 0.0]), 1, 1.0),
        ("z.obj", json!([0.0, 0.0, 1.0]), 2, 1.0),
        ("mm.obj", json!([0.0, 0.0, 1.0]), 2, 1000.0),
    ] {
        for verb in ["look", "bench --method z-buffer"] {
            let report = folder.json(&format!("{verb} {file} --survey 4 --size 64x48"));
            let report = report["methods"].get(0).cloned().unwrap_or(report);
            let found = eyes(&report, axis);
            assert_eq!(found.len(), 4, "{file}: {report}");
            for (view_up, height) in found {
                assert_eq!(view_up, up, "{file}");
                let above = (height / metre).rem_euclid(3.0);
                assert!((1.0..2.4).contains(&above), "{file}: {above} m above a floor");
            }
        }
    }
}

#[test]
fn the_first_picture_and_new_cameras_have_the_up_axis_that_is_found() {
    let folder = houses();
    let up = |arguments: &str| folder.json(arguments)["views"][0]["up"].clone();
    assert_eq!(up("look z.obj --size 64x48"), json!([0.0, 0.0, 1.0]));
    let there = "--eye 1,-1,1.6 --toward 5,-5,1.6 --size 64x48";
    assert_eq!(up(&format!("look z.obj {there}")), json!([0.0, 0.0, 1.0]));
    assert_eq!(up(&format!("look z.obj {there} --up y")), json!([0.0, 1.0, 0.0]));
    assert_eq!(
        up(&format!("look z.obj {there} --up 0,0,-2")),
        json!([0.0, 0.0, -1.0])
    );
    let run = folder.run("look z.obj --survey 2 --size 64x48");
    assert!(run.stderr.contains("z is up, by the floors"), "{}", run.stderr);
}

#[test]
fn info_says_which_way_is_up_and_how_long_a_unit_is() {
    let folder = houses();
    for (file, up, from, unit) in [
        ("y.obj", json!([0.0, 1.0, 0.0]), "floors", Value::Null),
        ("z.obj", json!([0.0, 0.0, 1.0]), "floors", Value::Null),
        ("mm.obj", json!([0.0, 0.0, 1.0]), "floors", json!(0.001)),
        (
            "mm.obj --up -x --unit ft",
            json!([-1.0, 0.0, 0.0]),
            "option",
            json!(0.3048),
        ),
        ("scene.glb", json!([0.0, 1.0, 0.0]), "format", Value::Null),
    ] {
        let info = folder.json(&format!("info {file}"));
        assert_eq!(
            (&info["up"], &info["up_from"], &info["metres_per_unit"]),
            (&up, &json!(from), &unit),
            "{file}"
        );
    }
    let said = folder.run("info mm.obj").stdout;
    assert!(
        said.contains("z, by the floors; --up sets it") && said.contains("0.001 m"),
        "{said}"
    );
}

#[test]
fn a_gltf_file_is_never_turned_but_info_tells_where_its_floors_are() {
    let folder = houses();
    let nodes: Vec<Value> = house()
        .iter()
        .map(|ends| {
            let [low, high] = ends.map(with_z_up);
            let middle = [0, 1, 2].map(|axis| 0.5 * (low[axis] + high[axis]));
            let size = [0, 1, 2].map(|axis| (high[axis] - low[axis]).abs());
            json!({ "name": "box", "mesh": 0, "translation": middle, "scale": size })
        })
        .collect();
    folder.add("z.glb", glb(&document(&nodes, json!([]))));
    let info = folder.json("info z.glb");
    assert_eq!(
        (&info["up"], &info["floors_face"]),
        (&json!([0.0, 1.0, 0.0]), &json!("z"))
    );
    assert!(folder.run("info z.glb").stdout.contains("--up z"));
    let up = |arguments: &str| folder.json(arguments)["views"][0]["up"].clone();
    assert_eq!(up("look z.glb --survey 2 --size 64x48"), json!([0.0, 1.0, 0.0]));
    let report = folder.json("look z.glb --survey 4 --size 64x48 --up 0,0,1");
    for (up, height) in eyes(&report, 2) {
        assert_eq!(up, json!([0.0, 0.0, 1.0]));
        assert!((1.0..2.4).contains(&height.rem_euclid(3.0)), "{height} m");
    }
    let choose = folder.run("choose z.obj --size 32x24 --unit m --up z");
    assert_eq!(choose.code, Some(0), "{}", choose.stderr);
}
