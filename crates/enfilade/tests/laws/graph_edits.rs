//! Every law holds while sectors, openings and portals come and go, with viewers that remember what was removed.

use crate::edits::{FOLLOWING, afresh, keeps_its_contract};
use crate::subject::{SIZE, Subject, names, subjects, viewer};
use enfilade::laws::Reference;
use enfilade::{Contract, GeometryBuilder, Limits, Method, PortalId, Scene, SceneBuilder, Viewer};
use enfilade_scenes::{Random, random_graph_edits};

/// Random portals form many cycles.
fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_crossings = 3;
    limits
}

fn short_sighted() -> Viewer {
    let mut viewer = viewer();
    viewer.options.limits = limits();
    viewer
}

/// Returns the same scene, built from scratch; removed sectors are empty ones.
fn built_afresh(scene: &Scene, method: Method) -> Scene {
    let mut builder = SceneBuilder::new();
    for id in scene.sectors() {
        let geometry = match scene.geometry(id) {
            Some(geometry) => afresh(geometry),
            None => GeometryBuilder::default().build().expect("nothing"),
        };
        let id = builder.add(scene.sector_name(id), geometry, method);
        if scene.is_open_above(id) {
            builder.open_above(id);
        }
    }
    for (id, portal) in (0..).map(PortalId).zip(scene.portals()) {
        if scene.has_portal(id) {
            builder.portal((portal.from, portal.opening), portal.to, portal.there_from_here);
        }
    }
    let mut built = builder.build().expect("as sound as it was");
    let kept = (0..)
        .map(PortalId)
        .zip(scene.portals())
        .filter(|&(id, _)| scene.has_portal(id));
    for ((_, portal), id) in kept.zip((0..).map(PortalId)) {
        built.set_open(id, portal.open);
    }
    built
}

/// Changes the graph round after round with each method. Returns the number of changes and of visible items.
fn laws_hold_while_the_graph_changes(subject: &Subject, rounds: u64, count: usize) -> [usize; 2] {
    let mut scenes: Vec<(Method, Scene, Viewer)> = FOLLOWING
        .iter()
        .map(|&method| (method, subject.seen_by(method).clone(), short_sighted()))
        .collect();
    let at_first = subject.built.scene.sector_count() + 3;
    let (mut changes, mut looked_at) = (0, 0);
    for round in 0..rounds {
        for (_, scene, _) in &mut scenes {
            let done = random_graph_edits(scene, count, at_first, &mut Random::new(1000 * round + 5));
            changes += done.expect("the scenes of the laws are small");
        }
        let edited = &scenes[0].1;
        let camera = &subject.built.cameras[round as usize % subject.built.cameras.len()];
        let view = camera.view(SIZE).expect("a valid view");
        let truth = Reference::new(edited).see(edited, &view, &limits());
        let anywhere = Reference::new(edited).see_anywhere(edited, &view, &limits(), 2, round);
        looked_at += truth.visible().len();
        for (method, scene, viewer) in &mut scenes {
            let place = format!("{method} on @{} in round {round}", subject.name);
            let mut forgetful = short_sighted();
            let looked = keeps_its_contract(
                *method,
                scene,
                &view,
                [viewer, &mut forgetful],
                [&truth, &anywhere],
                &place,
            );
            if method.contract() == Contract::Exact {
                let fresh = built_afresh(scene, *method);
                forgetful.look(&fresh, &view);
                assert_eq!(
                    looked,
                    names(&fresh, forgetful.visible()),
                    "{place}: built afresh"
                );
            }
        }
    }
    [changes, looked_at]
}

#[test]
fn every_law_holds_while_rooms_and_doors_come_and_go() {
    let mut changes = 0;
    for subject in subjects().iter().filter(|subject| subject.name != "enfilade") {
        let [changed, looked_at] = laws_hold_while_the_graph_changes(subject, 4, 8);
        changes += changed;
        assert!(looked_at > 0, "@{}: nothing is seen", subject.name);
    }
    assert!(changes > 600, "{changes}");
}

#[test]
fn an_edited_scene_can_be_nested_in_another() {
    for subject in subjects()
        .iter()
        .filter(|subject| subject.built.scene.portals().len() > 2)
    {
        let mut scene = subject.seen_by(Method::HierarchicalZ).clone();
        let sectors = scene.sector_count();
        random_graph_edits(&mut scene, 20, sectors + 3, &mut Random::new(1)).expect("small");
        let mut outer = SceneBuilder::new();
        outer.nest(&scene);
        let nested = outer.build().expect("as sound as the inner scene");
        for camera in &subject.built.cameras {
            let view = camera.view(SIZE).expect("a valid view");
            let [inner, outer] = [&scene, &nested].map(|scene| {
                let mut viewer = short_sighted();
                viewer.look(scene, &view);
                names(scene, viewer.visible())
            });
            assert_eq!(inner, outer, "@{} from `{}`", subject.name, camera.name);
        }
    }
}
