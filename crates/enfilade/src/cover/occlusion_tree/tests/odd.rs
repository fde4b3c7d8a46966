//! Degenerate eye positions, boxes and occluders.

use super::*;

#[test]
fn a_wall_does_not_hide_itself_or_what_hangs_on_it() {
    for scale in [1e-5, 1.0, 1e7] {
        let mut both = Both::new(&[]);
        let tile = square([0.1 * scale, 0.0, 2.0 * scale], 3.0 * scale);
        both.hide(&tile.occluder(), 1e-4 * scale, None);
        let [low, high] = [-0.3 * scale, 0.3 * scale];
        for thickness in [0.0, 1e-3] {
            let on_it = volume([low, low, 2.0 * scale], [high, high, (2.0 + thickness) * scale]);
            assert!(!both.see(&on_it).contains(&Visibility::Hidden), "at {scale}");
        }
        let behind = volume([low, low, 2.000_001 * scale], [high, high, 2.5 * scale]);
        assert_eq!(both.see(&behind), [Visibility::Hidden; 2], "at {scale}");
    }
}

#[test]
fn what_the_eye_is_in_the_plane_of_hides_nothing() {
    for height in [0.0, 1e-300, -1e-18, 1e-12] {
        let corners =
            [[-3.0, 1.0], [3.0, 1.0], [3.0, 9.0], [-3.0, 9.0]].map(|[x, z]| on_screen([x, height, z]));
        for turned in [false, true] {
            let mut corners = corners;
            if turned {
                corners.reverse();
            }
            for plane in [
                (DVec3::Y, 0.0),
                (-DVec3::Y, 1e-300),
                (DVec3::new(0.0, 1.0, -400.0).normalize(), 1e-12),
            ] {
                let mut both = Both::new(&[]);
                let occluder = Occluder {
                    corners: &corners,
                    plane,
                };
                both.hide(&occluder, NEAR, None);
                let behind = volume([-1.0, -0.1, 10.0], [1.0, 0.1, 11.0]);
                assert!(!both.see(&behind).contains(&Visibility::Hidden), "{height}");
            }
        }
    }
}

#[test]
fn an_eye_in_the_corner_of_a_room_sees_its_walls_and_no_further() {
    let mut room = Vec::new();
    for [corner, along, up] in [
        [[-1e-4, -1e-4, -1e-4], [4.0, 0.0, 0.0], [0.0, 0.0, 5.0]],
        [[-1e-4, -1e-4, -1e-4], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]],
        [[-1e-4, -1e-4, -1e-4], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
        [[4.0 - 1e-4, -1e-4, -1e-4], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]],
        [[-1e-4, 3.0 - 1e-4, -1e-4], [4.0, 0.0, 0.0], [0.0, 0.0, 5.0]],
        [[-1e-4, -1e-4, 5.0 - 1e-4], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
    ] {
        let [corner, along, up] = [corner, along, up].map(DVec3::from);
        let corners = [corner, corner + along, corner + along + up, corner + up];
        room.extend(Polygon::new(&corners.map(Into::into)));
    }
    assert_eq!(room.len(), 6);
    for shift in 0..6 {
        room.rotate_left(shift);
        let mut both = Both::new(&room);
        for inside in [
            volume([1.0, 1.0, 2.0], [1.1, 1.1, 2.1]),
            volume([0.0, 0.0, 2.0], [3.9, 2.9, 4.9]),
            volume([-1e-4, -1e-4, 4.0], [0.1, 0.1, 4.5]),
            volume([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]),
        ] {
            let sights = both.see(&inside);
            assert!(!sights.contains(&Visibility::Hidden), "{sights:?}: {inside:?}");
        }
        for beyond in [
            volume([-9.0, -9.0, 6.0], [9.0, 9.0, 9.0]),
            volume([4.5, 0.0, 1.0], [9.0, 2.0, 9.0]),
            volume([-9.0, -3.0, 0.1], [9.0, -0.1, 9.0]),
        ] {
            assert_eq!(both.see(&beyond)[0], Visibility::Hidden, "{beyond:?}");
        }
    }
}

#[test]
fn what_is_before_the_near_distance_or_the_entry_plane_does_not_hide() {
    let wall = square([0.0, 0.0, 2.0], 3.0);
    let behind = volume([-0.1, -0.1, 5.0], [0.1, 0.1, 6.0]);
    let entry = |at: f64| Some((DVec3::Z, at));
    for (near, entry, hides) in [
        (1.0, None, true),
        (3.0, None, false),
        (1e-3, entry(1.0), true),
        (1e-3, entry(3.0), false),
    ] {
        let mut both = Both::new(&[]);
        both.hide(&wall.occluder(), near, entry);
        let expected = if hides {
            Visibility::Hidden
        } else {
            Visibility::Full
        };
        assert_eq!(both.see(&behind), [expected; 2], "{near} {entry:?}");
    }
    // A floor that begins behind the eye and extends to the horizon hides as much as if it began where it enters the
    // view.
    let floor = Polygon::new(&[
        [-50.0, -1.0, -50.0],
        [50.0, -1.0, -50.0],
        [50.0, -1.0, 50.0],
        [-50.0, -1.0, 50.0],
    ]);
    let mut both = Both::new(&[floor.expect("the eye is not in its plane")]);
    assert_eq!(
        both.see(&volume([-2.0, -3.0, 5.0], [2.0, -1.001, 9.0])),
        [Visibility::Hidden; 2]
    );
    assert_eq!(
        both.see(&volume([-2.0, -3.0, 5.0], [2.0, -0.9, 9.0])),
        [Visibility::Partial; 2]
    );
}

#[test]
fn only_what_is_in_the_aperture_is_seen() {
    let slanted = Polygon::new(&[
        [-1.0, -1.0, 4.0],
        [1.0, -1.0, 4.0],
        [1.5, 1.0, 4.0],
        [-0.5, 1.0, 4.0],
    ])
    .expect("the eye is not in its plane");
    let outline: Vec<[f64; 2]> = slanted.corners.iter().map(|c| [c.x / c.z, c.y / c.z]).collect();
    let mut both = Both::default();
    both.fill(&outline, &[]);
    let see = |both: &mut Both, x: [f64; 2]| both.see(&volume([x[0], -0.9, 8.0], [x[1], 0.9, 8.1]));
    assert_eq!(see(&mut both, [0.0, 1.0]), [Visibility::Full; 2]);
    assert_eq!(see(&mut both, [-3.0, -2.5]), [Visibility::Hidden; 2]);
    assert_eq!(see(&mut both, [-3.0, 0.0]), [Visibility::Partial; 2]);
    let mut both = Both::default();
    both.fill(&outline, &[square([0.0, 0.0, 5.0], 2.0)]);
    assert_eq!(see(&mut both, [-9.0, 9.0]), [Visibility::Hidden; 2]);
}

#[test]
fn a_box_that_was_flattened_is_seen_where_it_looks_over_a_wall() {
    // The wall hides everything below this height.
    const TOP: f64 = 0.5;
    let wall = Polygon::new(&[
        [-3.0, -9.0, 2.0],
        [3.0, -9.0, 2.0],
        [3.0, TOP, 2.0],
        [-3.0, TOP, 2.0],
    ]);
    let mut both = Both::new(&[wall.expect("the eye is not in its plane")]);
    let mut chance = Chance(11);
    let mut tally = [0; 2];
    for round in 0..3000 {
        let at = DVec3::new(chance.between(-1.0, 1.0), chance.between(-3.0, 1.0), 4.0);
        // All sides in one plane: sloping or axis-aligned, often with two of them parallel.
        let along = chance.direction();
        let up = if round % 3 == 0 {
            DVec3::Y
        } else {
            chance.direction()
        };
        let mut sides = [(); 3].map(|()| along * chance.between(-0.5, 0.5) + up * chance.between(-0.5, 0.5));
        if round % 2 == 0 {
            sides[2] = sides[1] * chance.between(-2.0, 2.0);
        }
        sides.rotate_left(round % 3);
        let flat = Volume {
            origin: on_screen(at.into()),
            sides: sides.map(|side| on_screen((at + side).into()) - on_screen(at.into())),
            is_parallel: false,
        };
        let highest = |corner: DVec3| (400.0 - corner.y / corner.z) / 700.0 - TOP / 2.0;
        let over = flat
            .corners()
            .map(highest)
            .into_iter()
            .fold(f64::NEG_INFINITY, f64::max);
        let sights = both.see(&flat);
        if over > 1e-9 {
            assert!(
                !sights.contains(&Visibility::Hidden),
                "round {round}: {sights:?} of {flat:?}"
            );
        }
        tally[usize::from(over > 1e-9)] += usize::from((sights[0] == Visibility::Hidden) == (over < -1e-9));
    }
    assert!(tally[0] > 1000 && tally[1] > 200, "{tally:?}");
}

#[test]
fn odd_boxes_and_occluders_are_no_trouble() {
    let wall = square([0.0, 0.0, 2.0], 3.0);
    let mut both = Both::new(std::slice::from_ref(&wall));
    let dot = |z: f64| volume([0.0, 0.0, z], [0.0, 0.0, z]);
    let rod = |z: f64| volume([-0.1, 0.0, z], [0.1, 0.0, z]);
    assert!(!both.see(&dot(1.0)).contains(&Visibility::Hidden));
    assert!(!both.see(&rod(1.0)).contains(&Visibility::Hidden));
    assert!(!both.see(&dot(0.0)).contains(&Visibility::Hidden));
    let odd = Volume {
        origin: DVec3::new(f64::NAN, 0.0, 1.0),
        sides: [DVec3::X; 3],
        is_parallel: false,
    };
    assert!(!both.see(&odd).contains(&Visibility::Hidden));
    let behind = volume([-0.1, -0.1, 5.0], [0.1, 0.1, 6.0]);
    for corners in [
        vec![],
        vec![DVec3::new(500.0, 400.0, 1.0); 5],
        wall.corners[..2].to_vec(),
        wall.corners.iter().rev().copied().collect(),
        wall.corners.iter().map(|c| *c * f64::INFINITY).collect(),
        wall.corners.iter().map(|c| *c * f64::NAN).collect(),
    ] {
        let occluder = Occluder {
            corners: &corners,
            plane: wall.plane,
        };
        let mut both = Both::new(&[]);
        both.hide(&occluder, NEAR, None);
        assert_eq!(both.see(&behind), [Visibility::Full; 2], "{corners:?}");
    }
}
