//! Cameras that move through doors, mirrors and teleports, and stop in their planes.

use crate::subject::{LIMIT, limits, viewer};
use enfilade::laws::{Contestants, views_through};
use enfilade::{Camera, Method, PortalId, View};
use enfilade_scenes::{SCENES, built_in, fuzz_scene};

/// Small: the relevant pixels are in the middle of the picture, or everywhere.
const SIZE: [u32; 2] = [32, 18];

/// Tests every method in every frame of walks through all open portals of a scene. Returns the number of certainly
/// visible items.
#[track_caller]
fn nothing_is_lost_on_the_way_through(name: &str) -> usize {
    let scene = built_in(name).expect("a built-in scene").scene;
    let mut contestants = Contestants::new(&scene, limits(), LIMIT);
    let mut visible = 0;
    for portal in (0..scene.portals().len() as u32).map(PortalId) {
        for view in views_through(&scene, portal, SIZE) {
            visible += holds(&mut contestants, &view, &format!("@{name}, {portal:?}"));
        }
    }
    visible
}

#[track_caller]
fn holds(contestants: &mut Contestants, view: &View, place: &str) -> usize {
    let (visible, broken) = contestants.check(view);
    let broken: Vec<String> = broken.iter().map(ToString::to_string).collect();
    assert!(broken.is_empty(), "{place}, {view:?}:\n{}", broken.join("\n"));
    visible
}

#[test]
fn no_frame_is_lost_on_the_way_through_a_door_a_mirror_or_a_teleport() {
    for named in SCENES.iter().filter(|named| named.name != "enfilade") {
        let visible = nothing_is_lost_on_the_way_through(named.name);
        let portals = named.build().scene.portals().len();
        assert!(visible > 0 || portals == 0, "nothing is seen in @{}", named.name);
    }
}

#[test]
fn no_frame_is_lost_on_the_way_through_the_doors_of_the_palace() {
    assert!(nothing_is_lost_on_the_way_through("enfilade") > 1000);
}

/// Tests one view with every method, as `look --check` does.
#[track_caller]
fn sees(name: &str, eye: [f32; 3], toward: [f32; 3], items: usize) {
    let scene = built_in(name).expect("a built-in scene").scene;
    let mut contestants = Contestants::new(&scene, limits(), LIMIT);
    let view = View::new(eye, toward, [48, 27]).expect("a valid view");
    assert_eq!(holds(&mut contestants, &view, &format!("@{name}")), items);
}

#[test]
fn a_doorway_nearer_than_the_near_plane_is_looked_through() {
    sees("two-rooms", [-0.002, 1.05, 0.02], [5.0, 1.05, 0.02], 8);
    // At the height of the ball's centre the eye is in a plane of the BSP tree, and the ball's edges in that plane
    // project exactly to a row of pixel centres.
    sees("two-rooms", [-0.002, 1.0, 0.0], [5.0, 1.0, 0.0], 8);
}

#[test]
fn an_eye_in_the_plane_of_a_doorway_sees_both_rooms() {
    sees("two-rooms", [0.0, 1.0, 0.0], [5.0, 1.0, 0.0], 8);
    sees("two-rooms", [0.0, 1.0, 0.0], [0.0, 1.0, 5.0], 6);
}

#[test]
fn an_eye_in_the_plane_of_a_mirror_sees_what_is_before_it_twice() {
    sees("mirrors", [-1.99, 1.0, 2.0], [-1.99, 1.5, 3.0], 4);
    sees("mirrors", [-1.99, 1.0, 2.0], [-3.0, 1.5, 3.0], 2);
}

#[test]
fn a_wall_that_counts_as_in_the_plane_of_a_doorway_hides_nothing_behind_it() {
    // The wall of the next room is 2⁻¹⁸ of the distance behind the doorway, exactly where faces begin to count as behind it.
    let scene = fuzz_scene(1_065_004).scene;
    let camera = Camera {
        up: [0.3, 0.9, -0.2],
        fov_y: 1.907_039_5,
        z_near: Some(0.5),
        ..Camera::new(
            [65.401_95_f32, 64.171_16, 97.787_96],
            [60.901_943, 64.171_16, 97.787_96],
        )
    };
    let view = camera.view([20, 12]).expect("a valid view");
    let mut contestants = Contestants::new(&scene, limits(), LIMIT);
    holds(&mut contestants, &view, "before a doorway");
    for method in [Method::Masked, Method::HierarchicalZ] {
        let scene = scene.with_method(method, LIMIT).expect("a small scene");
        for cover_size in [None, Some([20, 12]), Some([10, 6])] {
            let mut viewer = viewer();
            viewer.options.cover_size = cover_size;
            let items = viewer.look(&scene, &view).items();
            assert!(items.len() > 9, "{method} lists only {} items", items.len());
        }
    }
}

#[test]
fn every_method_keeps_its_contract_in_random_scenes_that_are_hard_to_get_right() {
    // The last fourteen once broke a contract when 400 others did not.
    let hard = [
        3566, 5626, 7690, 7893, 11_438, 25_510, 28_782, 35_971, 62_188, 1_008_130, 1_023_015, 2_001_580,
        2_007_586, 2_048_840,
    ];
    let mut visible = 0;
    for seed in (0..400).chain(hard) {
        let fuzz = fuzz_scene(seed);
        let mut contestants = Contestants::new(&fuzz.scene, limits(), LIMIT);
        for view in &fuzz.views {
            visible += holds(&mut contestants, view, &format!("seed {seed}"));
        }
    }
    assert!(visible > 1000, "{visible}");
}
