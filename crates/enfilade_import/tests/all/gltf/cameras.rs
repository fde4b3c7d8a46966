//! Tests orthographic cameras: the distant perspective approximation moves nothing by more than half a pixel.

use super::file::{File, reads, warnings};
use enfilade::{Camera, Method, SectorId, Viewer};
use enfilade_import::Import;
use serde_json::{Value, json};

/// A scene from −10 to 10 in all directions, and an orthographic camera that shows 8 of it from bottom to top.
fn cube(node: Value) -> File {
    let mut file = File::empty();
    let primitive = file.primitive(&[[-10.0; 3], [10.0; 3], [10.0, -10.0, 0.0]], &[0, 2, 1]);
    let mesh = file.mesh(json!([primitive]));
    file.node(json!({ "name": "Cube", "mesh": mesh }));
    file.push(
        "cameras",
        json!({ "type": "orthographic", "orthographic": { "xmag": 9, "ymag": 4, "znear": 0.5, "zfar": 100 } }),
    );
    file.node(node);
    file
}

fn only(import: &Import) -> &Camera {
    assert_eq!(warnings(import), [""; 0]);
    let [camera] = &import.cameras[..] else {
        panic!("one camera")
    };
    camera
}

fn near(camera: &Camera) -> f64 {
    f64::from(camera.z_near.expect("the file gives it"))
}

/// Returns the position of a point in pixels from the centre of a 1280×720 viewport, and its depth.
fn seen(camera: &Camera, point: [f64; 3]) -> [f64; 3] {
    let Camera { eye, toward, up, .. } = *camera;
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
    };
    let unit = |a: [f64; 3]| a.map(|v| v / dot(a, a).sqrt());
    let ahead = unit(minus(toward, eye));
    let right = unit(cross(ahead, up));
    let up = cross(right, ahead);
    let focal = 360.0 / (0.5 * f64::from(camera.fov_y)).tan();
    let from_eye = minus(point, eye);
    let depth = dot(from_eye, ahead);
    [
        focal * dot(from_eye, right) / depth,
        focal * dot(from_eye, up) / depth,
        depth,
    ]
}

#[test]
fn an_orthographic_camera_shows_things_where_parallel_lines_of_sight_have_them() {
    let import = reads(&cube(
        json!({ "name": "Plan", "camera": 0, "translation": [1, 2, 30] }),
    ));
    let camera = only(&import);
    assert_eq!(
        (&*camera.name, &*import.orthographic_heights),
        ("Plan", &[Some(8.0)][..])
    );
    // 720 pixels are 8 units: 90 each. To the sides of the picture, over all depths.
    let mut worst = 0.0_f64;
    for x in [-7.1, -3.0, 0.0, 7.1] {
        for y in [-4.0, 1.0, 4.0] {
            for z in [-10.0, 0.0, 10.0] {
                let [column, row, depth] = seen(camera, [1.0 + x, 2.0 + y, z]);
                worst = worst.max((column - 90.0 * x).abs()).max((row - 90.0 * y).abs());
                assert!(depth > near(camera));
            }
        }
    }
    assert!((0.1..0.6).contains(&worst), "{worst} pixels off");
    // Its picture begins half a unit before where its author put it.
    let [_, _, begins] = seen(camera, [1.0, 2.0, 29.5]);
    assert!((begins - near(camera)).abs() < 0.01, "{begins} {camera:?}");
}

#[test]
fn what_stands_behind_an_orthographic_camera_is_not_in_its_picture() {
    // It stands in the midst of things: their near half is behind it.
    let import = reads(&cube(json!({ "camera": 0 })));
    let camera = only(&import);
    assert!(seen(camera, [0.0, 0.0, -0.6])[2] > near(camera));
    assert!(seen(camera, [0.0, 0.0, -0.4])[2] < near(camera));
    let scene = import.scene(Method::ZBuffer, 1 << 30).expect("small");
    let view = camera.view([64, 36]).expect("a valid view");
    assert_eq!(Viewer::new().look(&scene, &view).items().len(), 1);
}

#[test]
fn a_scene_far_away_flat_or_empty_can_still_be_looked_at() {
    let far = reads(&cube(json!({ "camera": 0, "translation": [0, 0, 100_000] })));
    let camera = only(&far);
    let [column, ..] = seen(camera, [4.0, 0.0, 0.0]);
    assert!((column - 360.0).abs() < 0.6, "{column}");
    let mut file = cube(json!({ "camera": 0, "translation": [0, 0, 1] }));
    file.json["nodes"][0]["scale"] = json!([1, 1, 0]);
    let import = reads(&file);
    let [column, ..] = seen(&import.cameras[0], [4.0, 0.0, 0.0]);
    assert!((column - 360.0).abs() < 0.6, "{column}");
    file.json["nodes"][0] = json!({});
    let import = reads(&file);
    assert_eq!(import.cameras.len(), 1);
    assert!(import.cameras[0].view([64, 36]).is_ok());
    // Of what is beyond its far end nothing need be in its place, and it stands the nearer for it.
    let mut file = cube(json!({ "camera": 0, "translation": [0, 0, 11] }));
    let whole = only(&reads(&file)).eye[2];
    file.json["cameras"][0]["orthographic"]["zfar"] = json!(3);
    let import = reads(&file);
    assert!(only(&import).eye[2] < 0.2 * whole, "{whole} {:?}", only(&import));
    let [column, ..] = seen(only(&import), [4.0, 0.0, 9.0]);
    assert!((column - 360.0).abs() < 0.6, "{column}");
    // All of it is behind the camera.
    let behind = reads(&cube(json!({ "camera": 0, "translation": [0, 0, -50] })));
    assert_eq!(behind.cameras.len(), 1);
}

#[test]
fn an_orthographic_camera_looks_from_the_room_that_it_stands_in() {
    let mut file = cube(json!({ "camera": 0, "translation": [100, 0, 5] }));
    let room = |file: &mut File, name: &str, x: f64| {
        let item = file.node(json!({ "mesh": 0, "translation": [x, 0, 0] }));
        file.node(json!({ "name": name, "children": [item] }))
    };
    file.json["nodes"][0] = json!({});
    room(&mut file, "A-room", 0.0);
    let there = room(&mut file, "B-room", 100.0);
    assert_eq!(only(&reads(&file)).sector, Some(SectorId(1)));
    // In none of them: in the nearest.
    file.json["nodes"][1]["translation"] = json!([70, 0, 5]);
    assert_eq!(only(&reads(&file)).sector, Some(SectorId(1)));
    // Below one of them: in that.
    file.json["nodes"][1]["translation"] = json!([0, 0, 5]);
    assert_eq!(only(&reads(&file)).sector, Some(SectorId(0)));
    let children = file.json["nodes"][there]["children"].as_array_mut();
    children.expect("a list").push(json!(1));
    assert_eq!(only(&reads(&file)).sector, Some(SectorId(1)));
    // One with a lens stands where its eye is, so that is asked.
    file.json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
    let import = reads(&file);
    assert_eq!(
        (only(&import).sector, import.orthographic_heights[0]),
        (None, None)
    );
}
