//! Stories of rooms and doors, told by plans.

mod plan;
mod queries;
mod refused;

use enfilade_bake::{DoorKind, RoomOptions, Up, detect_metres_per_unit, detect_up, find_rooms};
use plan::Plan;

#[test]
fn a_doorway_parts_two_rooms_and_joins_them() {
    Plan::new(
        "################
         #......#.......#
         #......#.......#
         #..A.......B...#
         #......#.......#
         #......#.......#
         ################",
    )
    .has_rooms("A B")
    .has_doors(&[(DoorKind::Opening, 'A', 'B')]);
}

#[test]
fn a_closed_door_is_a_door_and_not_a_wall() {
    Plan::new(
        "################
         #......#.......#
         #......#.......#
         #..A...|...B...#
         #......#.......#
         #......#.......#
         ################",
    )
    .has_rooms("A B")
    .has_doors(&[(DoorKind::Door, 'A', 'B')]);
}

#[test]
fn a_pane_is_a_window_to_the_outside() {
    Plan::new(
        "........................
         ........................
         ....################....
         ....#..............#....
         ....#..............#....
         ....=......A.......#..B.
         ....=..............#....
         ....#..............#....
         ....################....
         ........................
         ........................",
    )
    .has_rooms("A")
    .has_doors(&[(DoorKind::Window, 'A', 'B')]);
}

#[test]
fn columns_do_not_split_a_hall() {
    Plan::new(
        "##############################
         #............................#
         #............................#
         #.....A......................#
         #............................#
         #......#....#....#....#......#
         #............................#
         #............................#
         #......#....#....#....#......#
         #............................#
         #.....................A......#
         #............................#
         #............................#
         ##############################",
    )
    .has_rooms("A")
    .has_doors(&[]);
}

#[test]
fn a_corridor_is_no_part_of_the_rooms_along_it() {
    Plan::new(
        "#########################
         #.......#.......#.......#
         #.......#.......#.......#
         #...A...#...B...#...C...#
         #.......#.......#.......#
         #.......#.......#.......#
         ####|#######|#######|####
         #.......................#
         #..D................D...#
         #.......................#
         #########################",
    )
    .has_rooms("A B C D")
    .has_doors(&[
        (DoorKind::Door, 'A', 'D'),
        (DoorKind::Door, 'B', 'D'),
        (DoorKind::Door, 'C', 'D'),
    ]);
}

#[test]
fn rooms_are_the_same_for_any_number_of_threads() {
    let plan = Plan::new(
        "#########################
         #.......#.......#.......#
         #.......#.......=.......#
         #...A.......B...=...C...#
         #.......#.......#.......#
         ####|#######|#######|####
         #.......................#
         #...D..............o....#
         #.......................#
         #########################",
    );
    let json = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            let found = find_rooms(&plan.input(), &RoomOptions::default()).expect("rooms");
            found.graph.to_json()
        })
    };
    let one = json(1);
    assert!(one.len() > 1000);
    assert_eq!(one, json(2));
    assert_eq!(one, json(4));
}

#[test]
fn a_door_without_a_name_is_suggested() {
    let mut plan = Plan::new(
        "################
         #......#.......#
         #......#.......#
         #..A...|...B...#
         #......#.......#
         #......#.......#
         ################",
    );
    plan.leaves_are_movable = false;
    let input = plan.input();
    let found = find_rooms(&input, &RoomOptions::default()).expect("rooms");
    let suggested: Vec<&str> = found
        .suggestions
        .iter()
        .map(|door| input.items[door.item as usize].name)
        .collect();
    assert_eq!(suggested, ["leaf"]);
}

#[test]
fn the_up_axis_and_the_unit_are_those_of_a_house() {
    let plan = Plan::new(
        "################################
         #..............#...............#
         #..............#...............#
         #......A...............B.......#
         #..............#...............#
         #..............#...............#
         #..............#...............#
         ################################",
    );
    for (up, unit) in [(Up::Y, 1.0), (Up::Z, 0.01), (Up::X, 0.001)] {
        let mut input = plan.input();
        // The axes of the house in the scene: z is up if (x, y, z) become (y, z, x), for example.
        let turns = match up {
            Up::Y => 0,
            Up::Z => 1,
            Up::X => 2,
        };
        for item in &mut input.items {
            for column in &mut item.world_from_item {
                column.rotate_right(turns);
                *column = column.map(|value| value / unit);
            }
        }
        assert_eq!(detect_up(&input), up);
        assert_eq!(detect_metres_per_unit(&input, up), Some(unit));
        let mut options = RoomOptions::default();
        options.up = up;
        options.metres_per_unit = unit;
        let graph = find_rooms(&input, &options).expect("rooms").graph;
        let [a, b] = ['A', 'B'].map(|letter| {
            let mut at = plan.at(letter);
            at.rotate_right(turns);
            graph.room_at(at.map(|value| value / unit))
        });
        assert!(a.is_some() && b.is_some() && a != b, "{up:?}");
    }
}
