//! Impossible spaces: rooms that could not be built.

use super::openings::shell;
use super::stage::{
    BLUE, BROWN, Doorway, GREEN, GREY, RED, Stage, WHITE, YELLOW, YELLOW_SHEET, both_ways, finished,
};
use crate::BuiltIn;
use crate::camera::camera;
use crate::envelope::Side;
use crate::shape::{ball, block, cuboid};
use enfilade::{MaterialId, Method, OpeningId, SceneBuilder, SectorId, Transform};
use glam::{Vec3, vec3};

/// A yard with impossible rooms.
///
/// A hut of two metres contains a hall of ten. Three windows in a row show one chamber from three sides. A door of the
/// hall leads into a corridor whose two ends are joined: its ball is visible again and again along it. The hall's other
/// door leads to a pillar in the corner of a room; each door beside that pillar leads by a right angle into the next
/// such room, and after four of them comes a fifth room, not the first.
pub(crate) fn impossible() -> BuiltIn {
    let mut scene = SceneBuilder::new();
    let (yard, hut, windows) = yard(&mut scene);
    let (hall, hall_doors) = add(&mut scene, "hall", hall());
    let [entrance, to_corridor, to_pillar] = hall_doors[..] else {
        unreachable!("a hall of three doors")
    };
    let hall_from_yard = Transform::translation([30.0, 0.0, 6.16]);
    both_ways(&mut scene, (yard, hut), (hall, entrance), hall_from_yard);

    let chamber = scene.add("chamber", chamber().build(), Method::HierarchicalZ);
    for (number, (window, there)) in windows
        .into_iter()
        .zip([[87.2, 1.4, 0.0], [90.0, 1.4, 2.8], [92.8, 1.4, 0.0]])
        .enumerate()
    {
        let [from, to] = window_at(number).along;
        let chamber_from_yard = Transform::translation(there)
            * Transform::rotation([0.0, 1.0, 0.0], 0.5 * std::f64::consts::PI * number as f64)
            * Transform::translation([-6.1, -1.4, -0.5 * (from + to)]);
        scene.portal((yard, window), chamber, chamber_from_yard);
    }

    let (corridor, ends) = add(&mut scene, "corridor", corridor());
    let [north, south, door] = ends[..] else {
        unreachable!("a corridor of two ends and a door")
    };
    let onwards = Transform::translation([0.0, 0.0, 4.2]);
    both_ways(&mut scene, (corridor, north), (corridor, south), onwards);
    let corridor_from_hall = Transform::translation([36.2, 0.0, 0.0]);
    both_ways(
        &mut scene,
        (hall, to_corridor),
        (corridor, door),
        corridor_from_hall,
    );

    around_the_pillar(&mut scene, (hall, to_pillar));
    finished(
        scene,
        vec![
            camera("yard", [0.6, 1.7, 4.6], [0.2, 1.0, -1.0]),
            camera("beside the hut", [-3.6, 1.7, -1.2], [0.0, 1.0, -2.0]),
            camera("at the hut", [0.1, 1.5, -1.0], [-0.8, 1.3, -6.0]),
            camera("three windows", [0.6, 1.6, 0.8], [6.0, 1.3, -0.2]),
            camera("a window, aslant", [5.2, 1.5, -1.4], [6.1, 1.4, 0.0]),
            camera("hall", [33.6, 1.7, 3.4], [27.0, 1.4, -3.0]),
            camera("out of the hut", [29.8, 1.6, 1.0], [30.0, 1.1, 5.0]),
            camera("along the corridor", [59.7, 1.5, 1.2], [60.1, 1.3, -2.0]),
            camera("in the corridor's end", [60.2, 1.4, -2.0999], [60.0, 1.3, 2.0]),
            camera("into the corridor", [26.0, 1.6, 0.6], [24.0, 1.4, 0.1]),
            camera("at the pillar", [122.4, 1.6, 2.6], [121.4, 1.3, 0.0]),
            camera("round the pillar", [181.3, 1.5, 1.3], [181.9, 1.3, -0.4]),
        ],
    )
}

fn add(
    scene: &mut SceneBuilder,
    name: &str,
    (stage, openings): (Stage, Vec<OpeningId>),
) -> (SectorId, Vec<OpeningId>) {
    (scene.add(name, stage.build(), Method::HierarchicalZ), openings)
}

/// Returns a hole in the wall in a plane, from the floor to a height.
fn hole(name: &'static str, side: Side, plane: f32, along: [f32; 2], height: f32) -> Doorway {
    Doorway {
        name,
        side,
        plane,
        along,
        up: [0.0, height],
    }
}

fn window_at(number: usize) -> Doorway {
    let from = -3.0 + 2.5 * number as f32;
    Doorway {
        up: [0.8, 2.0],
        ..hole("window", Side::East, 6.1, [from, from + 1.0], 2.0)
    }
}

/// Builds the yard; returns its sector, the hut's opening, and the windows.
fn yard(scene: &mut SceneBuilder) -> (SectorId, OpeningId, Vec<OpeningId>) {
    let mut yard = Stage::new();
    let windows = yard.room([-6.0, 6.0], [-6.0, 6.0], 4.0, &[0, 1, 2].map(window_at));
    let door: Vec<Vec3> = [(-0.5, 0.1), (0.5, 0.1), (0.5, 1.9), (-0.5, 1.9)]
        .map(|(x, y)| vec3(x, y, -1.06))
        .to_vec();
    yard.thing("hut", &shell(BROWN, &door, [-1.0, 1.0], [0.0, 2.2], [-3.2, -1.0]));
    yard.thing("behind the hut", &block(RED, [-0.4, 0.0, -5.0], [0.4, 3.0, -4.2]));
    yard.thing(
        "before the hut",
        &block(YELLOW, [-0.9, 0.0, 0.6], [-0.5, 1.0, 1.0]),
    );
    let hut = yard.opening("hut", &door);
    let yard = scene.add("yard", yard.build(), Method::HierarchicalZ);
    (yard, hut, windows)
}

/// Builds the inside of the hut.
fn hall() -> (Stage, Vec<OpeningId>) {
    let entrance = Doorway {
        up: [0.1, 1.9],
        ..hole("entrance", Side::South, 5.1, [29.5, 30.5], 1.9)
    };
    let doors = [
        entrance,
        hole("to the corridor", Side::West, 24.9, [-0.5, 0.5], 2.0),
        hole("to the pillar", Side::North, -5.1, [29.5, 30.5], 2.0),
    ];
    let mut hall = Stage::new();
    let openings = hall.room([25.0, 35.0], [-5.0, 5.0], 4.2, &doors);
    for (x, z) in [(27.0, -2.5), (33.0, -2.5), (27.0, 2.5), (33.0, 2.5)] {
        let place = Transform::translation([x, 0.0, z]);
        hall.placed("column", &cuboid(GREY, [0.4, 4.2, 0.4]), place);
    }
    let place = Transform::translation([31.4, 0.8, -1.0]);
    hall.placed("ball", &ball(GREEN, 0.8, 10, 14), place);
    (hall, openings)
}

/// A chamber with four different walls, which show the view direction.
fn chamber() -> Stage {
    let mut chamber = Stage::new();
    chamber.room([87.0, 93.0], [-3.0, 3.0], 3.0, &[]);
    for (name, material, min, max) in [
        ("west", RED, [87.0, 0.0, 1.4], [87.8, 2.2, 2.4]),
        ("north", GREEN, [88.6, 0.0, -3.0], [89.6, 1.2, -2.4]),
        ("east", BLUE, [92.2, 0.0, -2.2], [93.0, 1.8, -1.2]),
        ("south", YELLOW, [91.0, 0.0, 2.2], [92.2, 0.9, 3.0]),
    ] {
        chamber.thing(name, &block(material, min, max));
    }
    let place = Transform::translation([90.0, 1.1, 0.0]);
    chamber.placed("ball", &ball(WHITE, 0.5, 10, 14), place);
    chamber
}

/// A corridor whose northern end leads to its southern one.
fn corridor() -> (Stage, Vec<OpeningId>) {
    let doors = [
        hole("north", Side::North, -2.1, [59.1, 60.9], 2.4),
        hole("south", Side::South, 2.1, [59.1, 60.9], 2.4),
        hole("door", Side::East, 61.1, [-0.5, 0.5], 2.0),
    ];
    let mut corridor = Stage::new();
    let openings = corridor.room([59.0, 61.0], [-2.0, 2.0], 2.6, &doors);
    let place = Transform::translation([59.5, 0.4, -1.1]);
    corridor.placed("ball", &ball(RED, 0.35, 8, 12), place);
    corridor.thing("shelf", &block(BLUE, [59.0, 1.1, 0.6], [59.25, 1.2, 1.6]));
    (corridor, openings)
}

/// Five rooms in a ring about an axis, each joined to the next by a right angle.
fn around_the_pillar(scene: &mut SceneBuilder, hall: (SectorId, OpeningId)) {
    const ROOMS: usize = 5;
    let corner = |room: usize| 120.0 + 20.0 * room as f32;
    let names = [
        "first room",
        "second room",
        "third room",
        "fourth room",
        "fifth room",
    ];
    let balls: [MaterialId; ROOMS] = [RED, GREEN, BLUE, YELLOW_SHEET, BROWN];
    let rooms: Vec<(SectorId, Vec<OpeningId>)> = (0..ROOMS)
        .map(|room| {
            let x = corner(room);
            let mut doors = vec![
                hole("one way round", Side::North, 0.0, [x + 1.4, x + 2.6], 2.1),
                hole("the other way round", Side::West, x, [1.4, 2.6], 2.1),
            ];
            if room == 0 {
                doors.push(hole("to the hall", Side::South, 4.1, [x + 1.5, x + 2.5], 2.0));
            }
            let mut stage = Stage::new();
            let openings = stage.room([x + 0.1, x + 4.0], [0.1, 4.0], 2.8, &doors);
            stage.thing("pillar", &block(GREY, [x + 0.1, 0.0, 0.1], [x + 0.9, 2.8, 0.9]));
            let place = Transform::translation([x + 3.0, 0.7 + 0.25 * room as f32, 2.2]);
            stage.placed("ball", &ball(balls[room], 0.4, 8, 12), place);
            add(scene, names[room], (stage, openings))
        })
        .collect();
    for room in 0..ROOMS {
        let next = (room + 1) % ROOMS;
        let there_from_here = Transform::from_columns([
            [0.0, 0.0, 1.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [corner(next), 0.0, -corner(room)],
        ]);
        let [here, there] = [
            (rooms[room].0, rooms[room].1[0]),
            (rooms[next].0, rooms[next].1[1]),
        ];
        both_ways(scene, here, there, there_from_here);
    }
    let first_from_hall = Transform::translation([92.0, 0.0, 9.2]);
    both_ways(scene, hall, (rooms[0].0, rooms[0].1[2]), first_from_hall);
}
