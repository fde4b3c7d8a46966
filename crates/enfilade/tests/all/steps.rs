//! Looks step by step.

use enfilade::{Canvas, CoverSpan, LookStep, Method, Passage, PassageId, Span, Viewer};
use enfilade_scenes::built_in;

/// Keeps the covers that it gets.
#[derive(Default, PartialEq, Debug, Clone)]
struct Cover(Vec<(u16, Vec<CoverSpan>)>);

impl Canvas for Cover {
    fn enter(&mut self, _: PassageId, _: &Passage) {}

    fn row(&mut self, _: u16, _: &[Span]) {}

    fn wants_cover(&self) -> bool {
        true
    }

    fn cover(&mut self, y: u16, spans: &[CoverSpan]) {
        self.0.push((y, spans.to_vec()));
    }
}

#[test]
fn each_step_forwards_adds_one_and_the_last_is_the_look() {
    let scene = built_in("two-rooms").expect("a built-in scene");
    let view = scene.cameras[0].view([96, 64]).expect("a valid camera");
    let (mut tried, mut covers_differ) = (0, 0);
    for method in Method::ALL {
        let Ok(scene) = scene.scene.with_method(method, Method::DEFAULT_LIMIT) else {
            continue;
        };
        let mut viewer = Viewer::new();
        viewer.options.parallel = false;
        viewer.options.coherence = false;
        let whole: Vec<_> = viewer.look(&scene, &view).items().to_vec();
        let mut last = Cover::default();
        let all = viewer.look_steps(&scene, &view, usize::MAX, &mut last);
        assert_eq!(
            viewer.visible().items(),
            whole,
            "{method}: all steps are the look"
        );
        let is_occluder = |step: &&LookStep| matches!(step, LookStep::Occluder { .. });
        let selected = all.iter().filter(is_occluder).count() as u64;
        assert_eq!(selected, viewer.stats().occluders, "{method}");
        assert_eq!(selected > 0, method.occluders() > Some(0), "{method}");
        let is_test = |step: &&LookStep| matches!(step, LookStep::Box { .. });
        assert!(
            method == Method::Cell || all.iter().filter(is_test).count() > 1,
            "{method}: {all:?}"
        );
        let mut before = None;
        for limit in 0..=all.len() {
            let mut cover = Cover::default();
            let some = viewer.look_steps(&scene, &view, limit, &mut cover);
            assert_eq!(some, all[..limit], "{method}, {limit} steps");
            covers_differ += usize::from(before.as_ref().is_some_and(|before| *before != cover));
            before = Some(cover);
        }
        assert_eq!(before, Some(last), "{method}");
        tried += 1;
    }
    assert!(tried > 9, "{tried} methods");
    assert!(covers_differ > 50, "{covers_differ}");
}

#[test]
fn steps_tell_the_passage_that_they_belong_to() {
    let scene = built_in("two-rooms").expect("a built-in scene");
    let mut passages_met = 0;
    for camera in &scene.cameras {
        let view = camera.view([96, 64]).expect("a valid camera");
        let mut viewer = Viewer::new();
        let all = viewer.look_steps(&scene.scene, &view, usize::MAX, &mut Cover::default());
        let passages = viewer.visible().passages();
        for step in &all {
            let sector = passages[step.passage().0 as usize].sector;
            if let (LookStep::Cluster { item, .. }, Some(geometry)) = (step, scene.scene.geometry(sector)) {
                assert!(geometry.holds(*item), "{step:?}");
            }
        }
        passages_met = passages_met.max(all.iter().map(|step| step.passage().0).max().unwrap_or(0));
    }
    assert!(passages_met > 0);
}
