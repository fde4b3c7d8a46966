//! Compares trees with an oracle that tests each occluder separately.

use super::*;

/// Number of boxes hidden by faces, hidden by box, hidden according to the oracle, and fully visible.
#[derive(Default, Debug)]
struct Tally {
    by_faces: usize,
    by_box: usize,
    hidden: usize,
    fully: usize,
}

/// Compares the results of both trees with the oracle.
fn check(occluders: &[Polygon], volumes: &[Volume], chance: &mut Chance, tally: &mut Tally) {
    let mut both = Both::new(occluders);
    for volume in volumes {
        let [by_faces, by_box] = both.see(volume);
        let places: Vec<DVec3> = chance.places(volume).into_iter().filter(in_view).collect();
        let hidden = |slack: f64| {
            let is_hidden = |place: &&DVec3| occluders.iter().any(|polygon| polygon.hides(**place, slack));
            places.iter().filter(is_hidden).count()
        };
        if by_faces == Visibility::Hidden {
            assert_eq!(
                hidden(1e-4),
                places.len(),
                "false cull by faces: {volume:?} behind {occluders:?}"
            );
        }
        if by_box == Visibility::Hidden {
            assert_eq!(
                by_faces,
                Visibility::Hidden,
                "hidden by box but not by faces: {volume:?} behind {occluders:?}"
            );
        }
        if by_faces == Visibility::Full || by_box == Visibility::Full {
            assert_eq!(
                hidden(-1e-4),
                0,
                "reported as fully visible, but hidden in part: {volume:?} behind {occluders:?}"
            );
        }
        tally.by_faces += usize::from(by_faces == Visibility::Hidden);
        tally.by_box += usize::from(by_box == Visibility::Hidden);
        tally.hidden += usize::from(!places.is_empty() && hidden(0.0) == places.len());
        tally.fully += usize::from(by_faces == Visibility::Full);
    }
}

#[test]
fn what_is_called_hidden_is_hidden_in_scenes_made_by_chance() {
    let mut chance = Chance(0x9E37_79B9_7F4A_7C15);
    let mut tally = Tally::default();
    for scene in 0..600 {
        let sizes = [[0.05, 0.4], [0.3, 1.5], [0.5, 4.0]][scene % 3];
        let occluders: Vec<Polygon> = (0..1 + chance.below(40))
            .filter_map(|_| chance.polygon([1.0, 6.0], sizes))
            .collect();
        let volumes: Vec<Volume> = (0..60).map(|_| chance.volume([0.5, 20.0])).collect();
        check(&occluders, &volumes, &mut chance, &mut tally);
    }
    assert!(tally.by_box > 1000 && tally.fully > 300, "{tally:?}");
    assert!(
        tally.by_faces >= tally.by_box && tally.by_faces * 10 > tally.hidden * 7,
        "{tally:?}"
    );
}

#[test]
fn grazing_walls_hide_what_is_behind_them_and_no_more() {
    let mut chance = Chance(5);
    let mut tally = Tally::default();
    for exponent in 1..7 {
        // Floors and walls just beside the eye, extending to the horizon.
        let hair = 0.1_f64.powi(exponent);
        let floor = Polygon::new(&[
            [-9.0, -hair, -1.0],
            [9.0, -hair, -1.0],
            [9.0, -hair, 1e4],
            [-9.0, -hair, 1e4],
        ]);
        let wall = Polygon::new(&[
            [hair, -9.0, 0.0],
            [hair, 9.0, -3.0],
            [hair, 9.0, 1e3],
            [hair, -9.0, 1e3],
        ]);
        let sloping = Polygon::new(&[[-1.0, -hair, 0.1], [-5.0, -hair, 0.1], [0.0, 2.0 * hair, 1e5]]);
        let occluders: Vec<Polygon> = [floor, wall, sloping].into_iter().flatten().collect();
        assert_eq!(occluders.len(), 3);
        let mut volumes: Vec<Volume> = (0..300).map(|_| chance.volume([0.5, 20.0])).collect();
        let thin = |chance: &mut Chance| {
            let z = chance.between(1.0, 100.0);
            let below = -hair * chance.between(0.5, 3.0);
            volume([-1.0, below - hair, z], [1.0, below, z + 1.0])
        };
        volumes.extend((0..300).map(|_| thin(&mut chance)));
        check(&occluders, &volumes, &mut chance, &mut tally);
    }
    assert!(
        tally.by_faces > 500 && tally.by_faces * 10 > tally.hidden * 8,
        "{tally:?}"
    );
}

#[test]
fn the_order_of_insertion_changes_the_cost_only() {
    let mut chance = Chance(77);
    let [mut least, mut most] = [usize::MAX, 0];
    for _ in 0..20 {
        let occluders: Vec<Polygon> = (0..12)
            .filter_map(|_| chance.polygon([1.0, 6.0], [0.3, 1.5]))
            .collect();
        let volumes: Vec<Volume> = (0..100).map(|_| chance.volume([0.5, 20.0])).collect();
        let mut before: Option<Vec<bool>> = None;
        for _ in 0..6 {
            let mut both = Both::new(&shuffled(&occluders, &mut chance));
            least = least.min(both.faces.tree.nodes.len());
            most = most.max(both.faces.tree.nodes.len());
            let hidden = |volume| both.see(volume)[0] == Visibility::Hidden;
            let hidden: Vec<bool> = volumes.iter().map(hidden).collect();
            assert_eq!(before.get_or_insert_with(|| hidden.clone()), &hidden);
        }
    }
    assert!(least < most, "{least} to {most} nodes");
}

#[test]
fn a_full_tree_hides_less_and_is_still_right() {
    let mut chance = Chance(11);
    let mut both = Both::new(&[]);
    let occluders: Vec<Polygon> = (0..30_000)
        .filter_map(|_| chance.polygon([1.0, 30.0], [0.001, 0.01]))
        .collect();
    both.fill(&SCREEN, &occluders);
    assert!(both.faces.tree.nodes.len() <= MAX_NODES && both.faces.tree.nodes.len() + 9 > MAX_NODES);
    for _ in 0..200 {
        let volume = chance.volume([0.5, 50.0]);
        if both.see(&volume)[0] == Visibility::Hidden {
            for place in chance.places(&volume).iter().filter(|place| in_view(place)) {
                assert!(occluders.iter().any(|polygon| polygon.hides(*place, 1e-4)));
            }
        }
    }
}
