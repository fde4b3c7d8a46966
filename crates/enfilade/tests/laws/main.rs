//! The laws: each is stated once and holds for every method on every scene.

mod convex;
mod doors;
mod doorways;
mod edits;
mod extremes;
mod glass;
mod graph_edits;
mod kinds;
mod matrices;
mod mixed;
mod snapping;
mod subject;
mod suite;
mod terrain;
mod tightness;

use enfilade::laws::{self, Report};
use enfilade::{Method, Scene, View};
use enfilade_scenes::{BuiltIn, Group, SCENES, random_scene};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use subject::{SIZE, Subject, drawn, limits, names, subject, subjects, viewer};

/// Tests every law with every method from every camera.
fn the_laws_hold(name: &str, built: &BuiltIn, size: [u32; 2]) -> Report {
    let views: Vec<View> = built
        .cameras
        .iter()
        .map(|camera| camera.view(size).expect("a valid view"))
        .collect();
    the_laws_hold_in(name, &built.scene, &views)
}

/// Tests every law with every method in the given views.
fn the_laws_hold_in(name: &str, scene: &Scene, views: &[View]) -> Report {
    let report = laws::check(scene, views, limits());
    let broken: Vec<String> = report
        .broken
        .iter()
        .map(|broken| format!("{broken}, {:?}", broken.view))
        .collect();
    assert!(broken.is_empty(), "@{name}:\n{}", broken.join("\n"));
    report
}

#[test]
fn the_laws_hold_on_the_small_scenes() {
    for Subject { name, built, .. } in subjects().iter().filter(|subject| subject.name != "enfilade") {
        let report = the_laws_hold(name, built, SIZE);
        assert!(
            report.visible > 0,
            "nothing is visible in @{name}, so nothing was tested"
        );
        let few = match *name {
            "bottles" => [10_000, 5_000],
            "glass" => [1000, 500],
            _ => [0, 0],
        };
        let layers = [report.layers, report.stacked];
        assert!(
            layers[0] >= few[0] && layers[1] >= few[1],
            "@{name}: {layers:?} transparent layers"
        );
    }
}

#[test]
fn the_laws_hold_in_the_palace() {
    let report = the_laws_hold("enfilade", &subject("enfilade").built, [160, 90]);
    assert!(
        report.visible > 100 && report.layers > 1000,
        "{} {}",
        report.visible,
        report.layers
    );
}

#[test]
fn the_position_of_the_sample_changes_the_picture() {
    for name in ["mirrors", "teleport", "bottles", "cones-16", "glass"] {
        let subject = subject(name);
        let [first, last] = [0, 3].map(|number| {
            let view = subject.built.cameras[0].view(SIZE).expect("a valid view");
            let view = view
                .at_sample(View::FOUR_SAMPLES[number])
                .expect("a position in the pixel");
            drawn(&mut viewer(), subject.seen_by(Method::ZBuffer), &view)
        });
        assert!(!first.same(&last), "@{name}");
    }
}

#[test]
fn a_pyramid_over_depths_changes_no_sample_of_the_picture() {
    for subject in subjects() {
        let [flat, pyramid] = [Method::ZBuffer, Method::HierarchicalZ].map(|method| subject.seen_by(method));
        let mut painted = 0;
        for camera in &subject.built.cameras {
            let view = camera.view(SIZE).expect("a valid view");
            let picture = drawn(&mut viewer(), flat, &view);
            painted += picture.painted();
            assert!(
                drawn(&mut viewer(), pyramid, &view).same(&picture),
                "@{} from `{}`",
                subject.name,
                camera.name
            );
        }
        assert!(painted > 0, "nothing is painted of @{}", subject.name);
    }
}

#[test]
fn what_a_tree_shows_by_faces_it_also_shows_by_boxes() {
    let mut more = 0;
    for subject in subjects() {
        for camera in &subject.built.cameras {
            let [by_faces, by_boxes] = [Method::Svbsp, Method::Mobsp].map(|method| {
                let mut viewer = viewer();
                let scene = subject.seen_by(method);
                viewer.look(scene, &camera.view(SIZE).expect("a valid view"));
                names(scene, viewer.visible())
            });
            let lost: Vec<_> = by_faces.difference(&by_boxes).collect();
            assert!(
                lost.is_empty(),
                "@{} from `{}`: {lost:?}",
                subject.name,
                camera.name
            );
            more += by_boxes.len() - by_faces.len();
        }
    }
    assert!(more > 0, "nowhere do boxes show more");
}

#[test]
fn a_limit_of_crossings_is_told() {
    let BuiltIn { scene, cameras } = &subject("mirrors").built;
    let mut viewer = viewer();
    let set = viewer.look(scene, &cameras[0].view(SIZE).expect("a valid view"));
    assert!(!set.complete());
    assert!(
        set.passages()
            .iter()
            .all(|passage| passage.crossings <= limits().max_crossings)
    );
    let BuiltIn { scene, cameras } = &subject("two-rooms").built;
    assert!(
        viewer
            .look(scene, &cameras[0].view(SIZE).expect("a valid view"))
            .complete()
    );
}

#[test]
fn every_kind_of_trouble_has_a_scene() {
    use Group::*;
    for group in [
        Doors,
        Mirrors,
        Teleports,
        Nested,
        Cycles,
        Intersections,
        Coplanar,
        Glass,
        OneSided,
        Slivers,
        Extreme,
        Close,
        Large,
        Baked,
    ] {
        assert!(
            SCENES.iter().any(|named| named.is(group)),
            "no scene has {group:?}"
        );
    }
}

/// The same scenes every time, unless `PROPTEST_CASES` requests more and other ones.
pub(crate) fn by_chance() -> ProptestConfig {
    let default = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => default,
        None => ProptestConfig {
            cases: 96,
            rng_seed: RngSeed::Fixed(1),
            ..default
        },
    }
}

proptest! {
    #![proptest_config(by_chance())]

    #[test]
    fn the_laws_hold_on_random_scenes(seed in any::<u64>()) {
        the_laws_hold("random", &random_scene(seed), [64, 48]);
    }
}
