//! Nodes that are terrain: the same triangles as without the hint, in blocks, and a method that takes no other rooms.

use super::file::{File, png, reads, warnings};
use super::grid::Grid;
use super::rooms::house;
use enfilade::{ItemIndex, Mesh, Method, Scene, SectorId, View, Viewer};
use enfilade_draw::{Exposure, Settings, Stage};
use enfilade_import::Import;
use serde_json::json;

/// The same file without the hint.
fn plain(file: &File) -> File {
    let mut file = file.clone();
    for node in file.json["nodes"].as_array_mut().expect("a list") {
        if node["name"] == "hill-terrain" {
            node["name"] = json!("hill");
        }
    }
    file
}

/// Every triangle to the bit, with all that its corners carry: from the corner with the least bits round.
fn triangles(import: &Import) -> Vec<Vec<Vec<u32>>> {
    let geometry = &import.rooms[0].geometry;
    let mut all = Vec::new();
    for item in (0..geometry.items().len() as u32).map(ItemIndex) {
        let mesh: &Mesh = geometry.mesh_of(item);
        let columns = geometry.item(item).sector_from_item;
        for face in 0..mesh.face_count() {
            let bits = |&corner: &u32| {
                let corner = corner as usize;
                let carried = mesh.normals().get(corner).into_iter().flatten();
                let carried = carried.chain(mesh.texture().get(corner).into_iter().flatten());
                let carried = carried.chain(mesh.colors().get(corner).into_iter().flatten());
                let place = mesh.positions()[corner].iter().chain(columns.as_flattened());
                place.chain(carried).map(|value| value.to_bits()).collect()
            };
            let mut corners: Vec<Vec<u32>> = mesh.face(face).iter().map(bits).collect();
            let least = (0..corners.len()).min_by_key(|&corner| corners[corner].clone());
            corners.rotate_left(least.expect("three corners"));
            all.push(corners);
        }
    }
    all.sort();
    all
}

/// Checks that the geometry equals that without the hint, and that the method can be used.
#[track_caller]
fn is_the_same_as_terrain(file: &File) {
    let import = reads(file);
    assert_eq!(warnings(&import), [""; 0]);
    assert!(
        triangles(&import) == triangles(&reads(&plain(file))),
        "other triangles"
    );
    horizon(&import);
}

#[track_caller]
fn horizon(import: &Import) -> Scene {
    import
        .scene(Method::FloatingHorizon, Method::DEFAULT_LIMIT)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn names(import: &Import) -> Vec<&str> {
    let geometry = &import.rooms[0].geometry;
    (0..geometry.items().len() as u32)
        .map(|item| geometry.name(ItemIndex(item)))
        .collect()
}

#[test]
fn a_grid_is_blocks_of_the_very_same_triangles() {
    for size in [[2, 2], [5, 3], [33, 34], [100, 2]] {
        is_the_same_as_terrain(&Grid::new(size).file());
    }
    let import = reads(&Grid::new([40, 70]).file());
    let expected = ["0 0", "0 1", "1 0", "1 1", "2 0", "2 1"].map(|block| format!("hill-terrain {block}"));
    assert_eq!(names(&import), expected);
}

#[test]
fn the_diagonal_is_the_one_that_its_author_drew() {
    is_the_same_as_terrain(&Grid::new([5, 4]).cut_otherwise().file());
    // A ridge along one, or else a valley.
    let ridge = |grid: Grid| {
        let mut file = Grid {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]],
            ..grid
        }
        .file();
        file.json["nodes"][0]["translation"] = json!([10, 0, 0]);
        let ray = enfilade::Ray {
            origin: [10.499, 9.0, 0.499],
            direction: [0.0, -1.0, 0.0],
        };
        9.0 - reads(&file).rooms[0]
            .geometry
            .cast(&ray)
            .expect("ground below")
            .distance
    };
    assert!(ridge(Grid::new([2, 2])) > 0.99);
    assert!(ridge(Grid::new([2, 2]).cut_otherwise()) < 0.01);
}

#[test]
fn far_from_the_origin_and_with_uneven_steps_nothing_moves() {
    // Added up, so that errors of rounding add up too.
    let added = |line: u16| (0..line).fold(123_456.78_f32, |place, _| place + 0.1);
    is_the_same_as_terrain(&Grid::at([40, 5], added, |row| 1e-3 * f32::from(row * row + row) - 0.5).file());
    is_the_same_as_terrain(&Grid::at([4, 4], |column| 1e11 * f32::from(column), f32::from).file());
}

#[test]
fn a_grid_that_was_turned_before_it_was_exported_is_one_within_rounding() {
    let (sin, cos) = std::f32::consts::FRAC_PI_2.sin_cos();
    let mut grid = Grid::at(
        [9, 7],
        |column| 500.3 + 0.7 * f32::from(column),
        |row| 0.3 * f32::from(row),
    );
    for position in &mut grid.positions {
        let [x, y, z] = *position;
        *position = [cos * x + sin * z, y, cos * z - sin * x];
    }
    let import = reads(&grid.file());
    horizon(&import);
    let geometry = &import.rooms[0].geometry;
    assert_eq!(geometry.triangle_count(), 2 * 8 * 6);
    let mesh = geometry.mesh_of(ItemIndex(0));
    for position in &grid.positions {
        let off = |other: &[f32; 3]| {
            (0..3)
                .map(|axis| (other[axis] - position[axis]).abs())
                .fold(0.0, f32::max)
        };
        let nearest = mesh.positions().iter().map(off).fold(f32::MAX, f32::min);
        assert!(nearest < 1.3e-4, "{position:?} is {nearest} off");
    }
}

#[test]
fn nodes_move_turn_scale_and_mirror_terrain_as_anything_else() {
    for place in [
        json!({ "translation": [3, 4, 5], "rotation": [0.6, 0.0, 0.0, 0.8] }),
        json!({ "scale": [-2, 1, 3] }),
        json!({ "scale": [0, 1, 1] }),
    ] {
        let mut file = Grid::new([5, 4]).file();
        for (key, value) in place.as_object().expect("an object") {
            file.json["nodes"][0][key] = value.clone();
        }
        let import = reads(&file);
        assert!(triangles(&import) == triangles(&reads(&plain(&file))), "{place}");
        let mut visible = Viewer::new();
        visible.look(
            &horizon(&import),
            &View::new([2.0, 9.0, 20.0], [2.0, 2.0, 5.0], [64, 48]),
        );
    }
}

#[test]
fn a_grid_may_be_of_single_triangles_or_strips_or_several_primitives() {
    let grid = Grid::new([6, 5]);
    is_the_same_as_terrain(&grid.split().file());
    let mut bare = grid.split().file();
    let primitive = bare.json["meshes"][0]["primitives"][0]
        .as_object_mut()
        .expect("an object");
    primitive.remove("indices");
    is_the_same_as_terrain(&bare);

    let mut parts = File::empty();
    let north = parts.primitive(&grid.positions, &grid.corners[..60]);
    let south = parts.primitive(&grid.positions, &grid.corners[60..]);
    parts.mesh(json!([north, south]));
    parts.node(json!({ "name": "hill-terrain", "mesh": 0 }));
    is_the_same_as_terrain(&parts);

    // Row by row, with triangles of no area where one row ends and the next begins.
    let mut row = Vec::new();
    for north in 0..4 {
        let first = north * 6;
        row.extend([first, first]);
        (0..6).for_each(|column| row.extend([first + column, first + 6 + column]));
        row.extend([first + 11, first + 11]);
    }
    let mut strip = Grid { corners: row, ..grid }.file();
    strip.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    let import = reads(&strip);
    assert_eq!(import.rooms[0].geometry.triangle_count(), 2 * 5 * 4);
    horizon(&import);
}

/// A textured grid whose corners carry coordinates, colors and, if so, normals.
fn painted(grid: &Grid, normals: impl Fn(usize) -> Option<[f32; 3]>) -> File {
    let mut file = grid.file();
    let texture = file.texture(png([8, 8], |x, y| [(x * 30) as u8, (y * 30) as u8, 90, 255]));
    file.material(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
    let flat = |list: Vec<[f32; 3]>| list.into_flattened();
    let places = grid
        .positions
        .iter()
        .flat_map(|[x, y, z]| [x * 0.3 + y * 0.01, z * 0.2])
        .collect::<Vec<_>>();
    let colors = flat(
        grid.positions
            .iter()
            .map(|[x, _, z]| [1.0, 0.1 * x, 0.1 * z])
            .collect(),
    );
    let accessor = file.floats(&places, 2);
    file.carry("TEXCOORD_0", accessor);
    let accessor = file.floats(&colors, 3);
    file.carry("COLOR_0", accessor);
    let normals: Option<Vec<[f32; 3]>> = (0..grid.positions.len()).map(normals).collect();
    if let Some(normals) = normals {
        let accessor = file.floats(&flat(normals), 3);
        file.carry("NORMAL", accessor);
    }
    file
}

fn picture(import: &Import, method: Method) -> Vec<u8> {
    let scene = import.scene(method, Method::DEFAULT_LIMIT).expect("it suits");
    let mut settings = Settings::default();
    settings.exposure = Exposure::Eye(0.0);
    let view = View::new([2.3, 3.0, 8.0], [2.5, 0.5, 2.0], [96, 64]);
    let drawn = Stage::new(&scene).draw(&mut Viewer::new(), &scene, &view, &settings);
    drawn.image.into_raw()
}

#[test]
fn places_in_textures_colors_and_normals_stay_as_they_are() {
    let grid = Grid::new([6, 5]);
    let steep = |corner: usize| Some([0.1 * (corner % 7) as f32, 1.0, 0.2]);
    for file in [
        painted(&grid, steep),
        painted(&grid, |_| None),
        painted(&grid.split(), |_| None),
    ] {
        is_the_same_as_terrain(&file);
        let [with, without] = [&file, &plain(&file)].map(reads);
        let picture_without = picture(&without, Method::ZBuffer);
        for method in [Method::ZBuffer, Method::FloatingHorizon] {
            assert!(picture(&with, method) == picture_without, "{method}");
        }
    }
}

#[test]
fn a_hill_that_is_flat_shaded_stays_so() {
    let grid = Grid::new([6, 5]).split();
    let normal = |corner: usize| {
        let first = corner / 3 * 3;
        let [a, b, c] = [0, 1, 2].map(|corner| glam::Vec3::from(grid.positions[first + corner]));
        Some((b - a).cross(c - a).normalize().to_array())
    };
    let file = painted(&grid, normal);
    let [with, without] = [&file, &plain(&file)].map(reads);
    let corner_of_one_face = [0.0, 0.0, 0.0];
    let mesh = with.rooms[0].geometry.mesh_of(ItemIndex(0));
    let own = |place: &[f32; 3], normal: &[f32; 3]| {
        *normal == [0.0; 3] || *place == corner_of_one_face || place[2] == 4.0
    };
    assert!(
        mesh.positions()
            .iter()
            .zip(mesh.normals())
            .all(|(place, normal)| own(place, normal))
    );
    let [with, without] = [
        picture(&with, Method::ZBuffer),
        picture(&without, Method::ZBuffer),
    ];
    // Normals made of a face's corners differ from those given by rounding.
    let off = with.iter().zip(&without).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(off <= Some(1), "{off:?}");
}

#[test]
fn terrain_stands_in_its_room_beside_other_things() {
    let mut file = house(json!([
        { "name": "valley-room", "children": [1, 2], "extras": { "enfilade": { "method": "floating-horizon" } } },
        { "name": "ground", "mesh": 3, "extras": { "enfilade": { "kind": "terrain" } }, "children": [3] },
        { "name": "hill-terrain.001", "mesh": 3, "translation": [9, 0, 0] },
        { "name": "hut", "mesh": 0, "translation": [1, 1, 1] },
        { "name": "cellar-room", "mesh": 0, "translation": [0, -9, 0] },
        { "name": "yard-terrain", "mesh": 3, "extras": { "enfilade": { "kind": "room" } }, "translation": [0, -30, 0] },
    ]));
    let grid = Grid::new([4, 4]);
    let primitive = file.primitive(&grid.positions, &grid.corners);
    file.mesh(json!([primitive]));
    let import = reads(&file);
    assert_eq!(names(&import), ["ground 0 0", "hill-terrain.001 0 0", "hut"]);
    // `extras` take precedence over the name.
    assert_eq!(
        (import.rooms.len(), import.rooms[2].geometry.name(ItemIndex(0))),
        (3, "yard-terrain")
    );
    assert_eq!(warnings(&import), [""; 0]);
    let own = import
        .scene(Method::ZBuffer, Method::DEFAULT_LIMIT)
        .expect("each its own");
    assert_eq!(own.method(SectorId(0)), Some(Method::FloatingHorizon));
    assert_eq!(own.method(SectorId(1)), Some(Method::ZBuffer));
    let suits: Vec<bool> = import
        .rooms
        .iter()
        .map(|room| Method::FloatingHorizon.suits(&room.geometry))
        .collect();
    assert_eq!(suits, [true, false, false]);
}

#[test]
fn names_of_blocks_are_nobody_elses() {
    let mut file = Grid::new([40, 3]).file();
    file.node(json!({ "name": "hill-terrain 0 1", "mesh": 0 }));
    file.node(json!({ "name": "hill-terrain", "mesh": 0 }));
    let import = reads(&file);
    let all = names(&import);
    let expected = [
        "hill-terrain#0 0 0",
        "hill-terrain#0 0 1",
        "hill-terrain 0 1",
        "hill-terrain#2 0 0",
        "hill-terrain#2 0 1",
    ];
    assert_eq!(all, expected);
    let nodes = file.json["nodes"].as_array_mut().expect("a list");
    nodes.truncate(2);
    let all = reads(&file);
    assert_eq!(
        names(&all),
        ["hill-terrain#0 0 0", "hill-terrain#0 0 1", "hill-terrain 0 1"]
    );
}
