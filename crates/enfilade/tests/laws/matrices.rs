//! Views from the matrices of engines: off-centre, jittered, reversed, infinite, left-handed, any axis ahead.

use crate::subject::subjects;
use crate::the_laws_hold_in;
use enfilade::{Camera, View};
use enfilade_scenes::{Random, engine_view, oblique_view, parallel_view};

/// Tests the laws in views that `make` returns for cameras of all small scenes.
fn the_laws_hold_in_views_by(make: fn(&Camera, [u32; 2], &mut Random) -> View) {
    let mut random = Random::new(27);
    let mut visible = 0;
    for subject in subjects().iter().filter(|subject| subject.name != "enfilade") {
        let cameras = subject.built.cameras.iter().take(3);
        let views: Vec<View> = cameras
            .map(|camera| make(camera, [113, 64], &mut random))
            .collect();
        visible += the_laws_hold_in(subject.name, &subject.built.scene, &views).visible;
    }
    assert!(visible > 1000, "only {visible} visible items were looked at");
}

#[test]
fn the_laws_hold_in_views_from_the_matrices_of_engines() {
    the_laws_hold_in_views_by(engine_view);
}

#[test]
fn the_laws_hold_in_parallel_views() {
    the_laws_hold_in_views_by(parallel_view);
}

#[test]
fn the_laws_hold_behind_oblique_near_planes() {
    the_laws_hold_in_views_by(oblique_view);
}
