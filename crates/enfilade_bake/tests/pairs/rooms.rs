//! Rooms whose visible pairs are known.

use crate::pairs_of;
use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};

/// A door across x, from y to y, from z = 0 to 2.
fn door(x: f64, [low, high]: [f64; 2], cells: [u32; 2]) -> Portal {
    Portal {
        corners: vec![[x, low, 0.0], [x, high, 0.0], [x, high, 2.0], [x, low, 2.0]],
        cells,
    }
}

/// Rooms in a row along x, ten long, with doors from y to y between.
fn row(doors: &[[f64; 2]]) -> Cells {
    let portals = doors.iter().enumerate().map(|(at, &span)| {
        let at = at as u32;
        door(f64::from(at + 1) * 10.0, span, [at, at + 1])
    });
    Cells::new(doors.len() as u32 + 1, portals.collect()).expect("rooms")
}

#[test]
fn through_doors_in_line_one_sees_to_the_end() {
    let pairs = pairs_of(&row(&[[0.0, 1.0]; 9]));
    assert_eq!(pairs.count(), 90);
    assert_eq!(pairs.proven(), 90);
}

#[test]
fn doors_that_step_aside_hide_what_is_behind_the_third() {
    // A line through the first two climbs by at least one each room, through the last two it falls.
    let pairs = pairs_of(&row(&[[0.0, 1.0], [2.0, 3.0], [0.0, 1.0]]));
    assert!(pairs.may_see(0, 2) && pairs.may_see(1, 3));
    assert!(!pairs.may_see(0, 3) && !pairs.may_see(3, 0));
}

#[test]
fn doors_that_only_touch_the_line_of_sight_hide() {
    // Only lines along y = 1, on the edge of all three, pass through [0, 1], [1, 2] and [0, 1].
    let pairs = pairs_of(&row(&[[0.0, 1.0], [1.0, 2.0], [0.0, 1.0]]));
    assert!(!pairs.may_see(0, 3));
    let fast = VisiblePairs::compute(
        &row(&[[0.0, 1.0], [1.0, 2.0], [0.0, 1.0]]),
        &PairsOptions {
            fast: true,
            ..PairsOptions::default()
        },
    )
    .expect("within the memory limit");
    assert!(!fast.may_see(0, 3));
}

#[test]
fn a_gap_of_a_millionth_is_seen_through() {
    let gap = 1e-6;
    let pairs = pairs_of(&row(&[[0.0, 1.0], [1.0 - gap, 2.0], [0.0, 1.0]]));
    assert!(pairs.may_see(0, 3) && pairs.may_see(3, 0));
}

#[test]
fn a_gap_of_a_millionth_is_seen_through_far_from_the_origin() {
    let away = 4096.0;
    let gap = 1e-6;
    let doors = [
        [away, away + 1.0],
        [away + 1.0 - gap, away + 2.0],
        [away, away + 1.0],
    ];
    assert!(pairs_of(&row(&doors)).may_see(0, 3));
}

#[test]
fn rooms_round_a_corner_are_not_seen_into() {
    // 0 → 1 along x, then out of 1 along y into 2, and back along x into 3, which is beside 0.
    let across_y = |y: f64, x: [f64; 2], cells| Portal {
        corners: vec![[x[1], y, 0.0], [x[0], y, 0.0], [x[0], y, 2.0], [x[1], y, 2.0]],
        cells,
    };
    let back = Portal {
        corners: door(10.0, [14.0, 15.0], [3, 2]).corners,
        cells: [3, 2],
    };
    let rooms = [
        door(10.0, [4.0, 5.0], [0, 1]),
        across_y(10.0, [14.0, 15.0], [1, 2]),
        back,
    ];
    let pairs = pairs_of(&Cells::new(4, rooms.to_vec()).expect("rooms"));
    assert!(pairs.may_see(0, 1) && pairs.may_see(0, 2) && pairs.may_see(1, 3));
    assert!(!pairs.may_see(0, 3));
}

#[test]
fn two_doors_between_the_same_rooms_are_no_way_to_see_oneself() {
    let rooms = [door(10.0, [0.0, 1.0], [0, 1]), door(10.0, [2.0, 3.0], [0, 1])];
    let pairs = pairs_of(&Cells::new(2, rooms.to_vec()).expect("rooms"));
    assert_eq!(pairs.count(), 2);
    assert_eq!(pairs.seen_from(0).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn cells_without_portals_see_themselves_alone() {
    let pairs = pairs_of(&Cells::new(70, Vec::new()).expect("cells"));
    assert_eq!(pairs.count(), 0);
    assert_eq!(pairs.seen_from(69).collect::<Vec<_>>(), [69]);
    assert_eq!(
        pairs_of(&Cells::new(0, Vec::new()).expect("nothing")).cell_count(),
        0
    );
}

/// Nine rooms along a slanted line, which passes each door `gap` inside a different edge.
fn round_a_line(gap: f64) -> Cells {
    let doors = (0..8).map(|at| {
        let x = 10.0 * f64::from(at + 1);
        let (sin, cos) = (2.4 * f64::from(at)).sin_cos();
        let corners = [(-gap, -1.0), (2.0, -1.0), (2.0, 1.0), (-gap, 1.0)];
        Portal {
            corners: corners
                .map(|(u, v)| [x, 0.37 * x + u * cos - v * sin, 0.21 * x + u * sin + v * cos])
                .to_vec(),
            cells: [at, at + 1],
        }
    });
    Cells::new(9, doors.collect()).expect("rooms")
}

#[test]
fn a_thin_bundle_of_lines_between_slanted_doors_is_found() {
    for gap in [1e-1, 1e-2, 1e-3] {
        let pairs = pairs_of(&round_a_line(gap));
        assert_eq!(pairs.count(), 72);
        assert_eq!(pairs.proven(), 72, "a gap of {gap}");
    }
}

#[test]
fn a_thousand_rooms_in_a_row_are_no_trouble() {
    let pairs = pairs_of(&row(&[[0.0, 1.0]; 999]));
    assert_eq!(pairs.count(), 999_000);
}
