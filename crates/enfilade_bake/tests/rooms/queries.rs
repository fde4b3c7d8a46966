//! What games ask: ways, sound, relevance, changes of rooms.

use crate::plan::Plan;
use enfilade_bake::{DoorId, DoorKind, RoomChange, RoomGraph, RoomId, RoomTracker, SoundLoss};

fn two_rooms_and_a_corridor() -> (Plan, RoomGraph) {
    let plan = Plan::new(
        "#################
         #.......#.......#
         #.......#.......#
         #...A...#...B...#
         #.......#.......#
         #.......#.......#
         ####|#######|####
         #...............#
         #.......C.......#
         #...............#
         #################",
    );
    let graph = plan.find().graph;
    (plan, graph)
}

fn doors(graph: &RoomGraph) -> Vec<DoorId> {
    let numbered = graph.doors().iter().zip(0..);
    numbered
        .filter(|(door, _)| door.kind == DoorKind::Door)
        .map(|(_, number)| DoorId(number))
        .collect()
}

#[test]
fn a_closed_door_stops_bodies_and_damps_sound() {
    let (plan, mut graph) = two_rooms_and_a_corridor();
    let [a, b] = ['A', 'B'].map(|letter| plan.at(letter));
    assert_eq!(graph.path(a, b), None);
    let loss = SoundLoss::default();
    let behind_doors = graph.heard_from(b, a, &loss).expect("sound passes doors");
    let doors = doors(&graph);
    assert_eq!(doors.len(), 2);
    for &door in &doors {
        graph.set_open(door, true);
    }
    let path = graph.path(a, b).expect("through both doors");
    assert_eq!(path.doors.len(), 2);
    // Straight to the first door, along the corridor, straight from the second: 4 m apart, and back.
    assert!(path.length > 7.0 && path.length < 10.0, "{path:?}");
    let through_doors = graph.heard_from(b, a, &loss).expect("sound passes doors");
    assert_eq!(through_doors, path.length);
    // A gap beside a closed door may be a little nearer than the middle of the door.
    let added = behind_doors - through_doors;
    assert!(
        2.0 * loss.door - 1.0 < added && added <= 2.0 * loss.door,
        "{added}"
    );
    graph.set_open(doors[0], false);
    assert_eq!(graph.path(a, b), None);
}

#[test]
fn sound_is_heard_in_the_rooms_that_it_reaches() {
    let (plan, mut graph) = two_rooms_and_a_corridor();
    let [a, b, c] = ['A', 'B', 'C'].map(|letter| graph.room_at(plan.at(letter)).expect("a room"));
    let names = |graph: &RoomGraph, reach: f64| -> Vec<RoomId> {
        let heard = graph.audible(plan.at('A'), reach, &SoundLoss::default());
        heard.into_iter().map(|(room, _)| room).collect()
    };
    assert_eq!(names(&graph, 5.0), [a]);
    assert_eq!(names(&graph, 20.0), [a, c]);
    assert_eq!(names(&graph, 50.0), [a, c, b]);
    for door in doors(&graph) {
        graph.set_open(door, true);
    }
    assert_eq!(names(&graph, 5.0), [a, c]);
}

#[test]
fn rooms_on_the_same_side_of_a_corridor_are_not_relevant_to_each_other() {
    let (plan, mut graph) = two_rooms_and_a_corridor();
    let [a, b, c] = ['A', 'B', 'C'].map(|letter| graph.room_at(plan.at(letter)).expect("a room"));
    assert_eq!(graph.relevant(a), [a]);
    for door in doors(&graph) {
        graph.set_open(door, true);
    }
    let relevant = graph.relevant(a);
    assert!(relevant.contains(&c) && !relevant.contains(&b), "{relevant:?}");
    assert_eq!(graph.relevant(c).len(), 3);
}

#[test]
fn one_sees_through_the_gap_beside_a_closed_door() {
    for (leaf, sees) in [("|", false), ("!", true)] {
        let plan = Plan::new(
            &"################
              #......#.......#
              #......#.......#
              #..A...|...B...#
              #......#.......#
              #......#.......#
              ################"
                .replace('|', leaf),
        );
        let graph = plan.find().graph;
        let [a, b] = ['A', 'B'].map(|letter| graph.room_at(plan.at(letter)).expect("a room"));
        assert_eq!(doors(&graph).len(), 1);
        assert_eq!(graph.relevant(a).contains(&b), sees);
        assert_eq!(graph.path(plan.at('A'), plan.at('B')), None);
    }
}

#[test]
fn whoever_walks_through_a_door_changes_rooms_once() {
    let (plan, graph) = two_rooms_and_a_corridor();
    let [from, to] = ['A', 'C'].map(|letter| plan.at(letter));
    let mut tracker = RoomTracker::default();
    let changes: Vec<RoomChange> = (0..=100)
        .filter_map(|step| {
            let share = f64::from(step) / 100.0;
            // Through the door, which is right below A.
            let at = [from[0], 1.0, from[2] + share * (to[2] - from[2])];
            tracker.moved(&graph, at)
        })
        .collect();
    let [a, c] = [from, to].map(|at| graph.room_at(at));
    assert_eq!(
        changes,
        [
            RoomChange {
                left: None,
                entered: a
            },
            RoomChange { left: a, entered: c }
        ]
    );
}

#[test]
fn a_graph_is_the_same_after_a_file() {
    let (plan, graph) = two_rooms_and_a_corridor();
    let json = graph.to_json();
    let read = RoomGraph::from_json(&json).expect("its own file");
    assert_eq!(read, graph);
    assert_eq!(read.room_at(plan.at('A')), graph.room_at(plan.at('A')));
    assert_eq!(read.room_at([f64::NAN, 0.0, 0.0]), None);
    assert_eq!(read.room_at([1e9, 0.0, 0.0]), graph.outside());
}
