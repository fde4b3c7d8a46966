//! Views from the matrices of engines: off-centre, jittered, reversed, infinite, left-handed, any axis ahead.

use crate::subject::{limits, subjects};
use enfilade::View;
use enfilade::laws;
use enfilade_scenes::{Random, engine_view};

#[test]
fn the_laws_hold_in_views_from_the_matrices_of_engines() {
    let mut random = Random::new(27);
    let mut visible = 0;
    for subject in subjects().iter().filter(|subject| subject.name != "enfilade") {
        let cameras = subject.built.cameras.iter().take(3);
        let views: Vec<View> = cameras
            .map(|camera| engine_view(camera, [113, 64], &mut random))
            .collect();
        let report = laws::check(&subject.built.scene, &views, limits());
        let broken: Vec<String> = report
            .broken
            .iter()
            .map(|broken| format!("{broken}, {:?}", broken.view))
            .collect();
        assert!(broken.is_empty(), "@{}:\n{}", subject.name, broken.join("\n"));
        visible += report.visible;
    }
    assert!(visible > 1000, "only {visible} visible items were looked at");
}
