//! The contracts hold for any sample position within the pixel.

use crate::subject::{SIZE, drawn, limits, subject, viewer};
use enfilade::laws::Reference;
use enfilade::{Method, View};

#[test]
fn samples_that_stand_aside_show_what_rays_through_them_meet() {
    for name in ["mirrors", "teleport", "bottles", "cones-16", "glass"] {
        let subject = subject(name);
        let camera = &subject.built.cameras[0];
        let reference = Reference::new(&subject.built.scene);
        let mut pictures = Vec::new();
        for sample in View::FOUR_SAMPLES {
            let mut view = camera.view(SIZE);
            view.sample = sample;
            let truth = reference.see(&subject.built.scene, &view, &limits());
            for (method, scene) in &subject.seen {
                let mut viewer = viewer();
                let picture = drawn(&mut viewer, scene, &view);
                let verdict = truth.check(viewer.look(scene, &view), Some(&picture));
                if method.contract().never_misses() {
                    assert_eq!(verdict.missed, [], "{method} on @{name} at {sample:?}");
                    assert_eq!(verdict.pixels_different, 0, "{method} on @{name} at {sample:?}");
                }
                if *method == Method::ZBuffer {
                    pictures.push(picture);
                }
            }
        }
        assert!(
            !pictures[0].same(&pictures[3]),
            "@{name}: the sample position has no effect"
        );
    }
}
