//! Tests of occluder selection and projection to the screen.

use super::*;
use glam::DAffine3;

/// Builds a room full of walls: rotated, stretched, mirrored and flattened copies.
fn room(dice: &mut Dice, double_sided: bool) -> Geometry {
    let wall = Wall::of_squares(4, 3, |x, y| x != 1 || y != 1);
    let places: Vec<Transform> = (0..300)
        .map(|copy| {
            let stretch: [f32; 3] = match copy % 4 {
                0 => [1.0; 3],
                1 => [-1.0, 2.0, 0.5],
                2 => dice.point(3.0).as_vec3().into(),
                _ => [3.0, 0.0, 1.0],
            };
            let axis = dice.point(1.0).as_vec3().into();
            let (turn, reach) = (dice.between(0.0, 6.0), if copy % 5 == 0 { 5.0 } else { 60.0 });
            let place = dice.point(reach).as_vec3().into();
            Transform::translation(place) * Transform::rotation(axis, turn) * Transform::scaling(stretch)
        })
        .collect();
    wall.geometry(double_sided, &places)
}

#[test]
fn the_chosen_are_the_best_of_all() {
    let mut dice = Dice::new(5);
    let mut choice = OccluderSelection::default();
    for round in 0..60 {
        let geometry = room(&mut dice, round % 2 == 0);
        let set = OccluderSet::build(&geometry);
        let mut passage = passage(dice.point(20.0).into(), dice.point(20.0).into());
        if round % 3 == 0 {
            passage.entry = Some((DVec3::new(0.0, 0.0, 1.0), 15.0));
        }
        if round % 4 == 0 {
            // As viewed through a mirror.
            passage.screen_from_sector.linear *= Transform::scaling([-1.0, 1.0, 1.0]).0;
        }
        for measure in [OccluderMeasure::AreaAngle, OccluderMeasure::ProjectedArea] {
            for budget in [0, 1, 16, 10_000] {
                let chosen = set.choose(&geometry, &passage, measure, budget, &mut choice);
                let expected = set.choose_from_all(&geometry, &passage, measure, budget);
                assert_eq!(chosen, expected, "{measure:?} {budget}");
                assert!(
                    budget < 10_000 || chosen.len() > 10,
                    "only {} selected",
                    chosen.len()
                );
            }
        }
    }
}

#[test]
fn the_chosen_stand_in_order_on_the_screen_also_where_mirrored() {
    let mut dice = Dice::new(6);
    let (mut choice, mut room_for_one) = (OccluderSelection::default(), OccluderRoom::default());
    let mut seen = 0;
    for round in 0..20 {
        let geometry = room(&mut dice, round % 2 == 0);
        let set = OccluderSet::build(&geometry);
        let mut passage = passage(dice.point(20.0).into(), dice.point(20.0).into());
        if round % 4 == 0 {
            passage.screen_from_sector.linear *= Transform::scaling([-1.0, 1.0, 1.0]).0;
        }
        passage.entry = (round % 3 == 0).then_some((DVec3::Z, 15.0));
        for chosen in set
            .choose(
                &geometry,
                &passage,
                OccluderMeasure::ProjectedArea,
                64,
                &mut choice,
            )
            .to_vec()
        {
            let Some(occluder) = set.on_screen(&geometry, &passage, &chosen, &mut room_for_one) else {
                continue;
            };
            is_sound(&occluder, "a wall in a room");
            assert!((3..=6).contains(&occluder.corners().count()) && occluder.plane().1 > 0.0);
            for [_, _, w] in occluder.corners() {
                assert!(
                    w >= f64::from(passage.z_near),
                    "geometry in front of the near plane occludes"
                );
            }
            seen += 1;
        }
    }
    assert!(seen > 200, "{seen}");
}

#[test]
fn a_choice_among_many_copies_touches_few_of_them() {
    let wall = Wall::of_squares(1, 1, |_, _| true);
    let grid = |side: usize| -> Vec<Transform> {
        let at = |i: usize| (4 * i) as f32;
        (0..side * side * side)
            .map(|i| Transform::translation([at(i % side), at(i / side % side), at(i / side / side)]))
            .collect()
    };
    let met = [10, 40].map(|side| {
        let geometry = wall.geometry(true, &grid(side));
        let set = OccluderSet::build(&geometry);
        let middle = [2.0 * side as f64 + 1.0; 3];
        let passage = passage(middle, [middle[0] + 1.0, middle[1] + 0.3, middle[2] - 2.0]);
        let mut choice = OccluderSelection::default();
        assert_eq!(
            set.choose(&geometry, &passage, OccluderMeasure::AreaAngle, 32, &mut choice)
                .len(),
            32
        );
        choice.met()
    });
    assert!(met[1] < 2 * met[0] + 200, "{met:?}");
}

#[test]
fn the_map_of_areas_goes_with_that_of_points() {
    let map = DAffine3::from_scale(DVec3::new(2.0, 3.0, -5.0)).matrix3;
    assert_eq!(cofactor(&map) * DVec3::Z, DVec3::Z * 6.0);
    assert_eq!(cofactor(&map) * DVec3::X, DVec3::X * -15.0);
    assert!((greatest_stretch(map) - 5.0).abs() < 1e-12);
}
