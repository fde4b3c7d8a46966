//! Views from the matrices of engines: off-centre, jittered, reversed, infinite, left-handed, any axis ahead.

use crate::subject::{LIMIT, limits, subject, subjects};
use crate::the_laws_hold_in;
use enfilade::laws::Contestants;
use enfilade::{Camera, Method, SectorId, View, Viewer, survey};
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

#[test]
fn lines_of_sight_begin_at_an_oblique_near_plane_in_whichever_cells_it_is() {
    let built = &subject("house").built;
    let mut contestants = Contestants::new(&built.scene, limits(), LIMIT);
    assert!(contestants.methods().any(|method| method == Method::Pvs));
    let mut random = Random::new(28);
    let mut visible = 0;
    for place in survey(&built.scene, 60).views {
        let view = oblique_view(&Camera::new(place.eye, place.toward), [64, 36], &mut random);
        let (seen, broken) = contestants.check(&view);
        assert!(broken.is_empty(), "{view:?}: {}", broken[0]);
        visible += seen;
    }
    assert!(visible > 500, "only {visible} items are visible");
}

/// Tests the laws in views straight down on a near plane that cuts through the rooms of a scene at this height.
fn the_laws_hold_in_a_plan_of(name: &str, height: f64) -> (usize, usize) {
    let scene = &subject(name).built.scene;
    let mut bounds = scene.bounds(SectorId(0));
    for sector in scene.sectors() {
        bounds = bounds.union(&scene.bounds(sector));
    }
    let [x, z] = [0, 2].map(|axis| 0.5 * f64::from(bounds.min[axis] + bounds.max[axis]));
    let side = f64::from((bounds.max[0] - bounds.min[0]).max(bounds.max[2] - bounds.min[2]));
    let plans = [1.02, 0.7, 0.31].map(|part| {
        let eye = [
            x + 0.11 * side * (1.0 - part),
            height,
            z - 0.07 * side * (1.0 - part),
        ];
        let below = [eye[0], height - 1.0, eye[2]];
        View::parallel(eye, below, [0.2, 0.0, -1.0], part * side, [97, 97]).expect("a valid view")
    });
    let visible = the_laws_hold_in(name, scene, &plans).visible;
    let mut viewer = Viewer::new();
    let roots = viewer.look(scene, &plans[0]).passages().iter();
    (visible, roots.filter(|passage| passage.parent.is_none()).count())
}

#[test]
fn a_plan_shows_every_room_that_it_cuts_through() {
    for (name, height, rooms) in [("two-rooms", 1.3, 2), ("enfilade", 1.6, 10)] {
        let (visible, roots) = the_laws_hold_in_a_plan_of(name, height);
        assert!(visible > 10, "only {visible} items are visible in @{name}");
        assert!(roots >= rooms, "only {roots} rooms are cut in @{name}");
    }
}
