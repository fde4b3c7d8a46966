//! Bad input gets an error, never a panic.

use crate::plan::Plan;
use enfilade_bake::{
    RoomGraph, RoomId, RoomItem, RoomMesh, RoomOptions, RoomsError, RoomsInput, Up, detect_metres_per_unit,
    detect_up, find_rooms,
};

const IDENTITY: [[f64; 3]; 4] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]];

fn one_triangle(positions: &[[f32; 3]], triangle: [u32; 3], mesh: usize) -> RoomsInput<'_> {
    RoomsInput {
        meshes: vec![RoomMesh {
            positions,
            opaque: vec![triangle],
            see_through: Vec::new(),
        }],
        items: vec![RoomItem {
            name: "",
            mesh,
            world_from_item: IDENTITY,
            movable: false,
        }],
    }
}

#[track_caller]
fn error(input: &RoomsInput) -> RoomsError {
    match find_rooms(input, &RoomOptions::default()) {
        Ok(_) => panic!("it was accepted"),
        Err(error) => error,
    }
}

#[test]
fn an_index_out_of_range_is_named() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(
        error(&one_triangle(&positions, [0, 1, 3], 0)).to_string(),
        "mesh 0 has a triangle with position 3, but only 3 positions"
    );
    assert_eq!(
        error(&one_triangle(&positions, [0, 1, 2], 1)).to_string(),
        "item 0 has mesh 1, but there are only 1"
    );
}

#[test]
fn triangles_without_area_are_nothing() {
    for positions in [
        [[0.0; 3]; 3],
        [[0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0; 3], [f32::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0]],
    ] {
        assert_eq!(
            error(&one_triangle(&positions, [0, 1, 2], 0)),
            RoomsError::NoTriangles
        );
    }
}

#[test]
fn huge_and_tiny_triangles_need_no_more_memory() {
    for size in [1e-30_f32, 1e-3, 1e18] {
        let positions = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, size]];
        let input = one_triangle(&positions, [0, 1, 2], 0);
        let mut options = RoomOptions::default();
        options.max_voxels = 100_000;
        match find_rooms(&input, &options) {
            Ok(found) => assert!(found.voxels.size().iter().product::<usize>() <= 100_000),
            Err(error) => assert_eq!(error, RoomsError::NoTriangles),
        }
    }
}

#[test]
fn options_that_are_no_lengths_are_refused() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let input = one_triangle(&positions, [0, 1, 2], 0);
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut options = RoomOptions::default();
        options.step = step;
        assert!(matches!(
            find_rooms(&input, &options),
            Err(RoomsError::BadOption { option: "step", .. })
        ));
    }
}

#[test]
fn a_spoilt_file_is_read_or_refused() {
    let plan = Plan::new(
        "##########
         #...#....#
         #.A...B..#
         #...#....#
         ##########",
    );
    let json = plan.find().graph.to_json();
    assert!(RoomGraph::from_json(&json).is_ok());
    for other in ["", "{}", "[]", &json.replace("\"version\":1", "\"version\":2")] {
        assert!(RoomGraph::from_json(other).is_err(), "{other}");
    }
    let mut random = fastrand::Rng::with_seed(11);
    let mut refused = 0;
    for _ in 0..3000 {
        let mut bytes = json.clone().into_bytes();
        for _ in 0..random.usize(1..4) {
            let place = random.usize(..bytes.len());
            bytes[place] = *random.choice(b"0123456789-.[],{}\"e").expect("a letter");
        }
        let Ok(text) = String::from_utf8(bytes) else {
            continue;
        };
        match RoomGraph::from_json(&text) {
            Ok(graph) => {
                for point in [[1.0, 1.0, 1.0], [3.0, 1.0, 1.5], [1e300, 0.0, -1e300]] {
                    let room = graph.room_at(point);
                    assert!(room.is_none_or(|room| (room.0 as usize) < graph.rooms().len()));
                    if let Some(room) = room {
                        graph.relevant(room);
                    }
                }
                graph.path([1.0, 1.0, 1.0], [3.0, 1.0, 1.5]);
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 500);
}

#[test]
fn random_triangles_have_rooms_or_are_refused() {
    let mut random = fastrand::Rng::with_seed(5);
    let mut accepted = 0;
    for round in 0..300 {
        let scale = 10_f32.powi(random.i32(-6..7));
        let mut number = || match random.u8(..) {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::MAX,
            3..40 => 0.0,
            _ => scale * (2.0 * random.f32() - 1.0),
        };
        let positions: Vec<[f32; 3]> = (0..60).map(|_| [number(), number(), number()]).collect();
        let mut triangles =
            || -> Vec<[u32; 3]> { (0..20).map(|_| [(); 3].map(|()| random.u32(..60))).collect() };
        let meshes = vec![RoomMesh {
            positions: &positions,
            opaque: triangles(),
            see_through: triangles(),
        }];
        let items = (0..6)
            .map(|item| RoomItem {
                name: "door",
                mesh: 0,
                world_from_item: [(); 4].map(|()| [(); 3].map(|()| random.f64() * 4.0 - 2.0)),
                movable: item % 2 == 0,
            })
            .collect();
        let input = RoomsInput { meshes, items };
        let mut options = RoomOptions::default();
        options.max_voxels = 20_000;
        options.up = [Up::X, Up::Y, Up::Z][round % 3];
        options.metres_per_unit = detect_metres_per_unit(&input, options.up).unwrap_or(1.0);
        detect_up(&input);
        let Ok(found) = find_rooms(&input, &options) else {
            continue;
        };
        accepted += 1;
        let graph = RoomGraph::from_json(&found.graph.to_json()).expect("its own file");
        assert_eq!(graph.to_json(), found.graph.to_json());
        for room in 0..graph.rooms().len().min(5) as u32 {
            assert!(graph.relevant(RoomId(room)).contains(&RoomId(room)));
        }
    }
    assert!(accepted > 100, "{accepted}");
}
