//! Stories of rooms and doors, told by plans.

mod plan;
mod queries;
mod refused;

use enfilade_bake::{DoorKind, RoomOptions, find_rooms};
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
