//! Testing the faces of what a conservative method found misses nothing, and leaves fewer hidden items; so does resolving
//! doubtful items.

use crate::subject::{SIZE, drawn, limits, names, subjects, viewer};
use enfilade::laws::Reference;
use enfilade::{Method, Scene, Tightness, View};
use enfilade_scenes::random_scene;
use proptest::prelude::*;

/// Returns how many items `masked` finds by boxes, by faces, and by resolving, and how many are certainly visible.
fn holds(scene: &Scene, views: &[View], place: &str) -> [usize; 4] {
    let scene = scene.with_method(Method::Masked, u64::MAX).expect("small");
    let reference = Reference::new(&scene);
    let mut counts = [0; 4];
    let mut viewers = [Tightness::Boxes, Tightness::Faces, Tightness::Resolved].map(|tightness| {
        let mut viewer = viewer();
        viewer.options.tightness = tightness;
        viewer
    });
    for view in views {
        let truth = reference.see(&scene, view, &limits());
        let sets = viewers.each_mut().map(|viewer| {
            let picture = drawn(viewer, &scene, view);
            let verdict = truth.check(viewer.visible(), Some(&picture));
            assert_eq!(
                (verdict.missed, verdict.pixels_different),
                (vec![], 0),
                "{place}, {view:?}"
            );
            names(&scene, viewer.visible())
        });
        for (count, set) in counts.iter_mut().zip(&sets) {
            assert!(set.is_subset(&sets[0]), "{place}, {view:?}");
            *count += set.len();
        }
        counts[3] += truth.visible().len();
    }
    counts
}

#[test]
fn what_faces_leave_out_is_nowhere_seen() {
    let mut counts = [0; 4];
    for subject in subjects() {
        let cameras = subject.built.cameras.iter();
        let views: Vec<View> = cameras
            .map(|camera| camera.view(SIZE).expect("a valid view"))
            .collect();
        let here = holds(&subject.built.scene, &views, subject.name);
        counts = [0, 1, 2, 3].map(|at| counts[at] + here[at]);
    }
    let [boxes, faces, resolved, visible] = counts;
    assert!(
        faces < boxes && boxes - faces > (boxes - visible) / 4,
        "{counts:?}"
    );
    assert!(
        resolved < faces && boxes - resolved > (boxes - visible) / 2,
        "{counts:?}"
    );
}

proptest! {
    #![proptest_config(crate::by_chance())]

    #[test]
    fn what_faces_leave_out_is_nowhere_seen_in_random_scenes(seed in any::<u64>()) {
        let built = random_scene(seed);
        let cameras = built.cameras.iter();
        let views: Vec<View> = cameras.map(|camera| camera.view([64, 48]).expect("a valid view")).collect();
        holds(&built.scene, &views, &format!("seed {seed}"));
    }
}
