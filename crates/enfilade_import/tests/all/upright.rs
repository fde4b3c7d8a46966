//! Which way is up in files that do not tell it.

use enfilade::{GeometryBuilder, ItemIndex, Method, Scene, SceneBuilder, Transform, survey_with};
use enfilade_bake::Up;
use enfilade_import::{ReadOptions, detect_scene_unit, detect_scene_up, read, read_bytes, survey_options};
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

fn options() -> ReadOptions {
    ReadOptions {
        limit_bytes: 16 << 30,
        flat: true,
        textures: false,
        ..ReadOptions::default()
    }
}

/// The scene of a file, without its rooms.
fn scene_of(path: &Path) -> Scene {
    let import = read(path, &options()).unwrap_or_else(|error| panic!("{error}"));
    import.scene(Method::ZBuffer, u64::MAX).expect("a scene")
}

/// The same scene with other axes and units.
fn turned(scene: &Scene, turn: Transform) -> Scene {
    let mut builder = SceneBuilder::new();
    builder.limit_bytes(u64::MAX);
    for sector in scene.sectors() {
        let geometry = scene.geometry(sector).expect("meshes");
        let mut turned = GeometryBuilder::new(geometry.materials());
        for mesh in geometry.meshes() {
            turned.mesh(mesh.clone());
        }
        for item in geometry.items() {
            turned.item("", item.mesh, turn * item.transform());
        }
        builder.add("turned", turned.build().expect("as before"), Method::ZBuffer);
    }
    builder.build().expect("as before")
}

/// The text of an OBJ file of a scene, one object for each item.
fn obj(scene: &Scene) -> String {
    let mut text = String::new();
    let mut first = 1;
    for sector in scene.sectors() {
        let geometry = scene.geometry(sector).expect("meshes");
        for item in (0..geometry.items().len() as u32).map(ItemIndex) {
            let mesh = geometry.mesh_of(item);
            let transform = geometry.item(item).transform();
            let _ = writeln!(text, "o item{}", item.0);
            for &position in mesh.positions() {
                let [x, y, z] = transform.point(position);
                let _ = writeln!(text, "v {x} {y} {z}");
            }
            for face in 0..mesh.face_count() {
                text.push('f');
                for &corner in mesh.face(face) {
                    let _ = write!(text, " {}", first + corner);
                }
                text.push('\n');
            }
            first += mesh.positions().len() as u32;
        }
    }
    text
}

fn z_up() -> Transform {
    Transform::from_columns([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0; 3]])
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
#[allow(clippy::print_stdout, reason = "a table")]
fn every_real_scene_stands_with_y_up_z_up_and_in_millimetres() {
    let folder = std::env::var("ENFILADE_SCENES").expect("the folder of the scenes");
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut files: Vec<_> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "glb"));
    files.sort();
    let mut wrong = Vec::new();
    for path in files {
        let scene = scene_of(&path);
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let start = Instant::now();
        let upright = detect_scene_up(&scene);
        let unit = detect_scene_unit(&scene, Up::Y);
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let lying = detect_scene_up(&turned(&scene, z_up()));
        let small = turned(&scene, Transform::scaling([1000.0; 3]) * z_up());
        let in_mm = (detect_scene_up(&small), detect_scene_unit(&small, Up::Z));
        println!(
            "{name}: {upright:?}, {unit:?}; z up {lying:?}; in mm {in_mm:?}; {} triangles, {ms:.1} ms",
            scene.triangle_count()
        );
        let is_right = upright == Some(Up::Y) && lying == Some(Up::Z) && in_mm.0 == Some(Up::Z);
        if !is_right {
            wrong.push(name);
        }
    }
    assert_eq!(wrong, [""; 0]);
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
#[allow(clippy::print_stdout, reason = "a measurement")]
fn the_time_to_find_the_up_axis_is_measured_beside_that_of_reading() {
    let folder = std::env::var("ENFILADE_SCENES").expect("the folder of the scenes");
    for name in ["country_kitchen", "san_miguel"] {
        let text = obj(&scene_of(&Path::new(&folder).join(name).with_extension("glb")));
        let start = Instant::now();
        let import = read_bytes(text.as_bytes(), None, &options()).expect("OBJ");
        let scene = import.scene(Method::ZBuffer, u64::MAX).expect("a scene");
        let reading = start.elapsed().as_secs_f64();
        let start = Instant::now();
        assert!(!import.tells_up());
        let options = survey_options(&scene);
        let finding = start.elapsed().as_secs_f64();
        assert_eq!(options.up, [0.0, 1.0, 0.0]);
        println!(
            "{name}: {} bytes, {reading:.3} s read, {finding:.4} s found",
            text.len()
        );
        assert!(!survey_with(&scene, 4, &options).views.is_empty());
    }
}
