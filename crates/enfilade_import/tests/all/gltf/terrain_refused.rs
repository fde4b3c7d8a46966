//! Terrain that is none: every message names the node, the place in the grid and the remedy; and files made to do harm.

use super::file::{File, refusal};
use super::grid::Grid;
use super::hostile::{each_is_read_or_refused, numbers, read_with_each_number_replaced};
use enfilade_import::{BrokenRule, ReadOptions, read_bytes};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Long enough for a busy machine, and far too short for anything that grows with the square.
const PATIENCE: Duration = Duration::from_secs(20);

#[track_caller]
fn refuses(file: &File, words: &[&str]) {
    let text = refusal(&file.glb()).expect("it is refused");
    for word in words {
        assert!(text.contains(word), "`{text}` does not say `{word}`");
    }
}

/// A grid of 5 columns and 4 rows with something wrong in it.
fn wrong(change: impl FnOnce(&mut Grid)) -> File {
    let mut grid = Grid::at(
        [5, 4],
        |column| 10.0 * f32::from(column),
        |row| 2.0 * f32::from(row),
    );
    change(&mut grid);
    grid.file()
}

/// The six corners of the two triangles of a cell.
fn cell(grid: &mut Grid, column: usize, row: usize) -> &mut [u16] {
    let first = 6 * (row * 4 + column);
    &mut grid.corners[first..first + 6]
}

#[test]
fn a_mesh_that_is_no_grid_is_told_the_first_place_without_a_corner() {
    let ring = |corner: u16| {
        let turn = f32::from(corner) * 0.7;
        [turn.cos(), 0.0, turn.sin()]
    };
    let file = wrong(|grid| {
        grid.positions = (0..5).map(ring).collect();
        grid.corners = vec![0, 1, 2, 0, 2, 3, 0, 3, 4];
    });
    let words = [
        "the bytes given: node 0 \"hill-terrain\" is terrain, but its vertices are in 5 columns and 5 rows, but there is none at column 0, \
         row 0 (x -0.9422",
        "fill the hole, or split the terrain around it",
        "If it is no terrain, rename the node",
    ];
    refuses(&file, &words);
}

#[test]
fn holes_are_told_by_their_place() {
    // A corner that is gone, with all triangles around it.
    let file = wrong(|grid| {
        grid.corners = grid
            .corners
            .chunks(3)
            .filter(|t| !t.contains(&7))
            .flatten()
            .copied()
            .collect()
    });
    refuses(
        &file,
        &["5 columns and 4 rows, but there is none at column 2, row 1 (x 20, z 2 in object space)"],
    );
    // One triangle, or both, with all corners there.
    for gone in [3, 6] {
        let file = wrong(|grid| {
            let start = 6 * (4 + 2);
            grid.corners.drain(start..start + gone);
        });
        refuses(
            &file,
            &[
                "the cell south-east of column 2, row 1 (x 20, z 2 in object space) lacks a triangle",
                "fill the hole",
            ],
        );
    }
    // The last corner.
    let file = wrong(|grid| grid.corners.truncate(6 * 11));
    refuses(&file, &["none at column 4, row 3"]);
}

#[test]
fn heights_that_are_not_finite_are_told_by_their_position() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let file = wrong(|grid| grid.positions[7][1] = bad);
        refuses(
            &file,
            &["meshes[0].primitives[0] has a triangle at position 7, which is not finite"],
        );
    }
}

#[test]
fn one_height_over_another_is_told_by_both() {
    // A wall down from the last column: its foot stands below corners that are there.
    let file = wrong(|grid| {
        let foot = grid.positions.len() as u16;
        grid.positions.push([40.0, -9.0, 2.0]);
        grid.corners.extend([4, 9, foot]);
    });
    refuses(
        &file,
        &[
            "it has the heights 0 and -9 at column 4, row 1 (x 40, z 2 in object space)",
            "remove one of them",
        ],
    );
    // A mesh with z up stands on its edge.
    let file = wrong(|grid| grid.positions.iter_mut().for_each(|p| *p = [p[0], -p[2], p[1]]));
    refuses(&file, &["check that the mesh itself has y up"]);
}

#[test]
fn triangles_that_are_no_half_of_a_cell() {
    let file = wrong(|grid| cell(grid, 1, 1).copy_from_slice(&[6, 11, 8, 8, 11, 12]));
    refuses(
        &file,
        &[
            "a triangle with a corner at column",
            "spans more than one cell",
            "split every cell into two",
        ],
    );
    let twice = wrong(|grid| {
        let again: Vec<u16> = cell(grid, 1, 1)[..3].to_vec();
        grid.corners.extend(again);
    });
    let crossed = wrong(|grid| cell(grid, 1, 1)[3..].copy_from_slice(&[6, 11, 12]));
    for file in [twice, crossed] {
        refuses(
            &file,
            &[
                "the cell south-east of column 1, row 1 (x 10, z 2",
                "has overlapping triangles",
                "keep only the two",
            ],
        );
    }
}

#[test]
fn terrain_seen_from_below_is_to_be_flipped() {
    let one = wrong(|grid| cell(grid, 2, 1)[..3].reverse());
    refuses(
        &one,
        &[
            "a triangle in the cell south-east of column 2, row 1",
            "faces down; flip it",
        ],
    );
    let all = wrong(|grid| grid.corners.reverse());
    refuses(
        &all,
        &[
            "a triangle in the cell south-east of column 0, row 0",
            "faces down; flip it",
        ],
    );
}

#[test]
fn cells_cut_along_both_diagonals_are_not_mixed() {
    let file = wrong(|grid| cell(grid, 3, 2).copy_from_slice(&[13, 18, 19, 13, 19, 14]));
    let words = [
        "the cell south-east of column 3, row 2 (x 30, z 4 in object space) is split along another diagonal",
    ];
    refuses(&file, &words);
    refuses(&file, &["split all cells alike before exporting"]);
}

#[test]
fn a_seam_in_what_corners_carry_is_to_be_welded() {
    for (attribute, each, what) in [("TEXCOORD_0", 2, "texture coordinates"), ("COLOR_0", 3, "colors")] {
        let mut file = wrong(|grid| {
            let twin = grid.positions.len() as u16;
            grid.positions.push(grid.positions[7]);
            cell(grid, 2, 1)
                .iter_mut()
                .filter(|corner| **corner == 7)
                .for_each(|corner| *corner = twin);
        });
        let texture = file.texture(super::file::png([2, 2], |_, _| [255; 4]));
        file.material(json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": texture } } }));
        let mut values = vec![0.25; 21 * each];
        values[20 * each] = 0.5;
        let accessor = file.floats(&values, each);
        file.carry(attribute, accessor);
        refuses(
            &file,
            &[
                &format!("it has two {what} at column 2, row 1 (x 20, z 2"),
                "weld the seam",
            ],
        );
    }
}

#[test]
fn nodes_whose_terrain_could_not_stay_as_it_is() {
    let with = |change: &dyn Fn(&mut File)| {
        let mut file = wrong(|_| ());
        change(&mut file);
        file
    };
    let node = "node 0 \"hill-terrain\"";
    let none = with(&|file| file.json["nodes"][0]["mesh"] = Value::Null);
    refuses(&none, &[node, "is terrain without triangles", "rename it"]);
    let points = with(&|file| file.json["meshes"][0]["primitives"][0]["mode"] = json!(0));
    refuses(&points, &[node, "is terrain without triangles"]);
    let skinned = with(&|file| {
        file.push("skins", json!({ "joints": [0] }));
        file.json["nodes"][0]["skin"] = json!(0);
    });
    refuses(
        &skinned,
        &[node, "is terrain with a skeleton", "apply that to the mesh"],
    );
    let morphed =
        with(&|file| file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]));
    refuses(&morphed, &[node, "is terrain with morph targets"]);
    let instanced = with(&|file| {
        let places = file.floats(&[0.0; 6], 3);
        file.json["nodes"][0]["extensions"] =
            json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": places } } });
    });
    refuses(
        &instanced,
        &[node, "is terrain with instances", "a separate node"],
    );
    let two_materials = with(&|file| {
        file.push("materials", json!({}));
        let mut again = file.json["meshes"][0]["primitives"][0].clone();
        again["material"] = json!(0);
        file.json["meshes"][0]["primitives"] = json!([file.json["meshes"][0]["primitives"][0], again]);
    });
    refuses(
        &two_materials,
        &[node, "primitives 0 and 1 of its mesh differ", "one node for each"],
    );
    let line = wrong(|grid| {
        grid.positions
            .iter_mut()
            .for_each(|position| *position = [0.0, 1.0, position[2]])
    });
    refuses(
        &line,
        &[node, "2 to 65537 samples along each side, but this one has 1 x 4"],
    );
}

#[test]
fn nobody_minds_a_name_that_another_kind_overrules() {
    let mut file = wrong(|grid| grid.corners.truncate(9));
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "kind": "room" } });
    assert_eq!(refusal(&file.glb()), None);
    file.json["nodes"][0]["extras"] = json!({ "enfilade": { "kind": "terrain" } });
    assert!(refusal(&file.glb()).is_some());
}

#[test]
fn terrain_with_a_number_or_a_few_bytes_wrong_is_read_or_refused() {
    let mut file = wrong(|_| ());
    let normals = file.floats(&[0.0, 1.0, 0.0].repeat(20), 3);
    file.carry("NORMAL", normals);
    read_with_each_number_replaced(&file);
    let mut number = numbers(20_261_122);
    each_is_read_or_refused((0..5000).map(|_| {
        let mut broken = file.clone();
        // Corners, or heights: one of them stands where another should.
        let at = number(broken.bytes.len());
        broken.bytes[at] = number(256) as u8;
        broken.glb()
    }));
}

/// Returns a file of unconnected triangles with `corners` vertices; `place` returns the position of each.
fn scattered(corners: u32, place: impl Fn(u32) -> [f32; 3]) -> Vec<u8> {
    let mut file = File::empty();
    let positions: Vec<[f32; 3]> = (0..corners).map(place).collect();
    let positions = file.positions(&positions);
    file.mesh(json!([{ "attributes": { "POSITION": positions } }]));
    file.node(json!({ "name": "hill-terrain", "mesh": 0 }));
    file.glb()
}

#[test]
fn a_million_corners_that_are_no_grid_are_refused_fast() {
    const MANY: u32 = 999_999;
    let start = Instant::now();
    let at = |x: u32, y: u32, z: u32| [x as f32, y as f32, z as f32];
    // As many columns as rows as corners: their grid would have 10¹² places.
    let diagonal = scattered(MANY, |corner| at(corner, 0, MANY - corner));
    // All in one place, one over another, and in one column.
    let pile = scattered(MANY, |corner| at(7, corner, 7));
    let row = scattered(MANY, |corner| at(corner, 0, 3));
    // So near each other that they can hardly be told apart.
    let crowd = scattered(MANY, |corner| {
        [1e6 + corner as f32 / 16.0, 0.0, (corner % 3) as f32]
    });
    let sparse = scattered(MANY, |corner| at(corner % 1000, 0, corner % 999));
    for (file, words) in [
        (
            diagonal,
            "999999 columns and 999999 rows, but there is none at column 0, row 0",
        ),
        (pile, "it has the heights"),
        (row, "spans more than one cell"),
        (crowd, "hill-terrain"),
        (sparse, "hill-terrain"),
    ] {
        let said = refusal(&file).expect("no grid");
        assert!(said.contains(words), "{said}");
    }
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}

#[test]
fn what_a_terrain_takes_is_asked_for_before_anything_is_read() {
    let mut file = wrong(|_| ());
    // Each node has a separate height field and separate blocks.
    for _ in 0..2000 {
        file.node(json!({ "name": "hill-terrain", "mesh": 0 }));
    }
    let options = ReadOptions {
        limit_bytes: 4 << 20,
        ..ReadOptions::default()
    };
    let error = read_bytes(&file.glb(), None, &options).expect_err("too much");
    let BrokenRule::TooLarge { place, .. } = &error.rule else {
        panic!("{error}")
    };
    assert!(place.ends_with("\"hill-terrain\", which is terrain"), "{place}");
    // A name that every block has takes memory for each.
    let mut file = Grid::new([2, 9000]).file();
    file.json["nodes"][0]["name"] = json!(format!("{}-terrain", "A".repeat(100_000)));
    let error = read_bytes(&file.glb(), None, &options).expect_err("too much");
    assert!(matches!(error.rule, BrokenRule::TooLarge { .. }), "{error}");
}
