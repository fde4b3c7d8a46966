//! A little map as a scene: the same in each format, seen from inside, and what cannot be seen is left out.

use super::little::{ENTITIES, FORMATS, Format, Little};
use enfilade::{Alpha, Material, Method, Scene, SectorId, View, Viewer};
use enfilade_import::{Import, ReadOptions, read, read_bytes};

#[track_caller]
pub(crate) fn imported(map: &[u8]) -> Import {
    read_bytes(map, None, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn scene(import: &Import, method: Method) -> Scene {
    import
        .scene(method, Method::DEFAULT_LIMIT)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The names of the items that are seen, in order.
fn seen(scene: &Scene, eye: [f32; 3], toward: [f32; 3]) -> Vec<String> {
    let mut viewer = Viewer::new();
    let set = viewer.look(scene, &View::new(eye, toward, [160, 120]).expect("a valid view"));
    let geometry = scene.geometry(SectorId(0)).expect("one room");
    let mut names: Vec<String> = set
        .items()
        .iter()
        .map(|item| geometry.name(item.item.index).to_owned())
        .collect();
    names.sort();
    names
}

/// Returns the item names of the world in a format.
fn rooms_of(format: Format) -> [&'static str; 2] {
    match format {
        Format::Ibsp46 => ["cluster 0", "cluster 1"],
        _ => ["leaf 1", "leaf 2"],
    }
}

#[test]
fn a_map_has_an_item_for_each_room_and_one_for_its_door() {
    for format in FORMATS {
        let import = imported(&Little::new(format).bytes());
        let geometry = &import.rooms[0].geometry;
        let names: Vec<&str> = (0..geometry.items().len() as u32)
            .map(|item| geometry.name(enfilade::ItemIndex(item)))
            .collect();
        let [first, second] = rooms_of(format);
        assert_eq!(names, [first, second, "func_door#3"], "{format:?}");
        assert_eq!(geometry.triangle_count(), 26, "{format:?}: clip is not drawn");
        // y is up: the map's z; and its y leads away.
        assert_eq!(geometry.bounds().min, [-64.0, -32.0, -32.0]);
        assert_eq!(geometry.bounds().max, [72.0, 32.0, 32.0]);
        let sky = geometry
            .materials()
            .iter()
            .filter(|material| material.unlit)
            .count();
        assert_eq!(sky, 2, "sky and lava are as bright as they are");
        let hides = |material: &Material| material.alpha == Alpha::Opaque;
        let (bright, walls): (Vec<_>, Vec<_>) = geometry.materials().iter().partition(|of| of.unlit);
        assert!(walls.iter().all(&hides), "{format:?}: {walls:?}");
        let skies = bright.into_iter().filter(hides).count();
        let expected = usize::from(format != Format::Ibsp46);
        assert_eq!(
            skies, expected,
            "{format:?}: lava hides nothing, nor does the sky of Quake 3"
        );
        assert!(import.warnings.is_empty(), "{:?}", import.warnings);
    }
}

#[test]
fn a_start_is_a_camera_at_the_height_of_the_eye() {
    for format in FORMATS {
        let import = imported(&Little::new(format).bytes());
        let [camera] = &import.cameras[..] else {
            panic!("{:?}", import.cameras)
        };
        assert_eq!(camera.name, "info_player_start");
        let height = if format == Format::Ibsp46 { 26.0 } else { 22.0 };
        assert_eq!(camera.eye, [-40.0, height, -8.0]);
        // 90 degrees is the map's y.
        assert!(camera.toward[2] < camera.eye[2] - 0.99);
        let [lamp] = &import.lights[..] else {
            panic!("{:?}", import.lights)
        };
        assert_eq!(lamp.position, [-32.0, 16.0, 0.0]);
        assert!(lamp.range > 100.0 && lamp.color[0] > 1.0);
    }
}

#[test]
fn walls_are_seen_from_inside_alone() {
    for format in FORMATS {
        let scene = scene(&imported(&Little::new(format).bytes()), Method::ZBuffer);
        let [first, second] = rooms_of(format);
        let mut both = [second, "func_door#3"];
        both.sort();
        assert_eq!(seen(&scene, [-32.0, 0.0, 0.0], [-31.0, 0.0, 0.0]), [first]);
        assert_eq!(seen(&scene, [10.0, 0.0, 0.0], [11.0, 0.0, 0.0]), both);
        assert_eq!(seen(&scene, [60.0, 0.0, 0.0], [61.0, 0.0, 0.0]), [second]);
        // From behind, the door and the near wall are not there.
        assert_eq!(seen(&scene, [90.0, 0.0, 0.0], [0.0, 0.0, 0.0]), [second]);
    }
}

#[test]
fn what_the_rows_leave_out_is_not_looked_at() {
    for format in FORMATS {
        let little = Little::new(format);
        let import = imported(&little.bytes());
        let cells = import.rooms[0].geometry.cells().expect("rows are there");
        assert_eq!(cells.cell_count(), 2);
        let [first, second] = [-30.0, 30.0].map(|x| cells.cell_at([x, 0.0, 0.0]).expect("a cell"));
        assert!(!cells.may_see(first, second) && !cells.may_see(second, first));
        let [own, _] = rooms_of(format);
        let of_first = seen(&scene(&import, Method::Pvs), [-60.0, 0.0, 0.0], [0.0, 0.0, 0.0]);
        assert_eq!(of_first, [own]);
    }
    // Rows are believed, also where a wall is not drawn that they were computed from.
    let mut little = Little::new(Format::Bsp2);
    little.lumps[7][28 + 16] = 3;
    let import = imported(&little.bytes());
    let looks = |method| seen(&scene(&import, method), [-60.0, 0.0, 0.0], [0.0, 0.0, 0.0]);
    assert_eq!(looks(Method::ZBuffer), ["func_door#3", "leaf 1", "leaf 2"]);
    assert_eq!(looks(Method::Pvs), ["leaf 1"]);
}

#[test]
fn a_leaf_without_a_row_sees_everything() {
    for format in [Format::Bsp29, Format::Bsp2] {
        let mut little = Little::new(format);
        let leaf_bytes = little.lumps[10].len() / 3;
        little.lumps[10][leaf_bytes + 4..][..4].copy_from_slice(&(-1i32).to_le_bytes());
        let import = imported(&little.bytes());
        let cells = import.rooms[0].geometry.cells().expect("rows are there");
        let [first, second] = [-30.0, 30.0].map(|x| cells.cell_at([x, 0.0, 0.0]).expect("a cell"));
        assert!(cells.may_see(first, second) && !cells.may_see(second, first));
    }
}

#[test]
fn a_map_without_rows_has_no_cells() {
    for (format, lump) in [(Format::Bsp29, 4), (Format::Bsp2, 4), (Format::Ibsp46, 16)] {
        let mut little = Little::new(format);
        little.lumps[lump].clear();
        let import = imported(&little.bytes());
        assert!(import.rooms[0].geometry.cells().is_none());
        assert!(import.scene(Method::Pvs, Method::DEFAULT_LIMIT).is_err());
    }
}

#[test]
fn a_bent_face_is_cut_into_triangles_without_a_crack() {
    let mut little = Little::new(Format::Ibsp46);
    // The door becomes an arch of 5 by 3 corners.
    let first = little.lumps[10].len() / 44;
    for row in 0..3 {
        for column in 0..5 {
            let [x, y] = [column as f32 - 2.0, 2.0 * row as f32];
            let corner = [x, y, 4.0 - x * x];
            let mut bytes: Vec<u8> = corner.iter().flat_map(|part| part.to_le_bytes()).collect();
            bytes.resize(44, 0);
            little.lumps[10].extend(bytes);
        }
    }
    let door = little.lumps[13].len() - 104;
    let face = &mut little.lumps[13][door..];
    face[8..12].copy_from_slice(&2i32.to_le_bytes());
    face[12..16].copy_from_slice(&(first as i32).to_le_bytes());
    face[16..20].copy_from_slice(&15i32.to_le_bytes());
    face[96..100].copy_from_slice(&5i32.to_le_bytes());
    face[100..104].copy_from_slice(&3i32.to_le_bytes());
    let import = imported(&little.bytes());
    let geometry = &import.rooms[0].geometry;
    let door = geometry.mesh_of(enfilade::ItemIndex(2));
    assert_eq!(door.triangle_count(), 2 * 16 * 8);
    // Each edge inside is that of two triangles, by the bits of its ends.
    let mut edges = std::collections::HashMap::new();
    for face in 0..door.face_count() {
        let corners = door.face(face);
        for side in 0..3 {
            let mut ends =
                [side, (side + 1) % 3].map(|at| door.positions()[corners[at] as usize].map(f32::to_bits));
            ends.sort();
            *edges.entry(ends).or_insert(0) += 1;
        }
    }
    let border = edges.values().filter(|&&count| count == 1).count();
    assert_eq!(border, 2 * (16 + 8));
    assert!(edges.values().all(|&count| count <= 2));
}

#[test]
fn lamps_that_are_aimed_are_spots_and_the_sky_is_suns() {
    let text = ENTITIES.replacen(
        "\"worldspawn\"",
        "\"worldspawn\" \"_sunlight\" \"200\" \"_sun_mangle\" \"0 -90 0\"",
        1,
    );
    let aimed = "{ \"classname\" \"light_x\" \"origin\" \"0 0 9\" \"target\" \"t\" \"_color\" \"255 0 0\" \"angle\" \"60\" }\n\
                 { \"targetname\" \"t\" \"origin\" \"0 9 9\" }\n{ \"classname\" \"light\" \"light\" \"-50\" \"origin\" \"1 1 1\" }";
    let mut little = Little::new(Format::Bsp29);
    little.lumps[0] = format!("{text}{aimed}\0").into_bytes();
    let lights = imported(&little.bytes()).lights;
    assert_eq!(lights.len(), 3, "{lights:?}");
    let enfilade::LightShape::Spot { direction, outer, .. } = lights[1].shape else {
        panic!("{:?}", lights[1])
    };
    assert_eq!((direction, lights[1].color[1]), ([0.0, 0.0, -9.0], 0.0));
    assert!((outer - 30f32.to_radians()).abs() < 1e-6);
    let enfilade::LightShape::Sun { direction } = lights[2].shape else {
        panic!("{:?}", lights[2])
    };
    assert!(direction[1] < -0.999);
}

#[test]
fn a_map_is_known_by_its_first_bytes_and_named_for_its_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dm9.bsp");
    for format in FORMATS {
        std::fs::write(&path, Little::new(format).bytes()).expect("it is ours");
        let import = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(import.rooms[0].name, "dm9");
    }
    std::fs::write(&path, b"\x1e\0\0\0").expect("it is ours");
    let error = read(&path, &ReadOptions::default()).expect_err("a refusal");
    assert!(
        error
            .to_string()
            .contains("dm9.bsp: is neither glTF nor OBJ, nor a map"),
        "{error}"
    );
}
