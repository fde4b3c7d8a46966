//! Visibility through open doors, closed doors and plain holes.

use crate::subject::{SIZE, drawn, limits, names, subject, viewer};
use enfilade::laws::Reference;
use enfilade::{Contract, Geometry, GeometryBuilder, ItemIndex, OpeningId, Transform};
use enfilade_scenes::BuiltIn;
use std::sync::Arc;

/// Checks the visible items of a scene from one of its cameras with every method; exact methods may return no other
/// named item.
fn sees(scene: &str, camera: &str, seen: &[&str], hidden: &[&str]) {
    let subject = subject(scene);
    for (method, scene) in &subject.seen {
        let mut viewer = viewer();
        viewer.look(scene, &subject.camera(camera));
        let names = names(scene, viewer.visible());
        let is_seen = |item: &str| names.iter().any(|name| name.ends_with(&format!("/{item}")));
        let place = format!("on @{} from `{camera}`: {names:?}", subject.name);
        for item in seen {
            assert!(is_seen(item), "{method} misses `{item}` {place}");
        }
        // Conservative methods may return more items.
        for item in hidden.iter().filter(|_| method.contract() == Contract::Exact) {
            assert!(!is_seen(item), "{method} sees `{item}` {place}");
        }
    }
}

#[test]
fn a_door_shows_only_what_is_in_line_with_it() {
    sees(
        "two-rooms",
        "in line",
        &["ball", "near box"],
        &["left box", "right box"],
    );
    sees("two-rooms", "away", &[], &["ball", "left box", "right box"]);
}

#[test]
fn a_pillar_before_a_door_hides_what_is_right_behind_it() {
    sees("pillar", "covered", &["pillar", "left", "right"], &["behind"]);
}

#[test]
fn a_gate_of_one_way_is_a_hole_from_behind() {
    sees(
        "teleport",
        "before the gate",
        &["in the gate"],
        &["behind the gate"],
    );
    sees(
        "teleport",
        "behind the gate",
        &["before it"],
        &["in the gate", "post"],
    );
}

#[test]
fn four_doors_around_a_pillar_lead_to_a_fifth_room() {
    let BuiltIn { scene, .. } = &subject("impossible").built;
    let named = |name: &str| {
        let mut all = scene.sectors();
        all.find(|&id| scene.sector_name(id) == name)
            .expect("a room of that name")
    };
    let through_its_north = |room| {
        let portal = scene.portal_of(room, OpeningId(0)).expect("it leads on");
        scene.portals()[portal.0 as usize].to
    };
    let mut room = named("first room");
    (0..4).for_each(|_| room = through_its_north(room));
    assert_eq!(room, named("fifth room"));
    assert_eq!(through_its_north(room), named("first room"));
}

#[test]
fn openings_are_holes_when_no_portal_is_followed() {
    let built = &subject("two-rooms").built;
    let flat = built.scene.without_portals();
    let mut viewer = viewer();
    let set = viewer.look(&flat, &built.cameras[0].view(SIZE));
    assert_eq!(set.passages().len(), 1);
    assert!(!set.items().is_empty());
    let reference = Reference::new(&flat);
    let view = built.cameras[0].view(SIZE);
    let truth = reference.see(&flat, &view, &limits());
    let picture = drawn(&mut viewer, &flat, &view);
    assert_eq!(truth.check(viewer.visible(), Some(&picture)).pixels_different, 0);
}

#[test]
fn a_closed_door_shows_nothing_of_what_is_behind_it() {
    let built = &subject("two-rooms").built;
    let doors: Vec<_> = (0..built.scene.portals().len() as u32)
        .map(enfilade::PortalId)
        .collect();
    let mut scene = built.scene.clone();
    doors.iter().for_each(|&door| scene.set_open(door, false));
    let mut viewer = viewer();
    let view = built.cameras[0].view(SIZE);
    assert_eq!(viewer.look(&scene, &view).passages().len(), 1);
    let truth = Reference::new(&scene).see(&scene, &view, &limits());
    let picture = drawn(&mut viewer, &scene, &view);
    let verdict = truth.check(viewer.visible(), Some(&picture));
    assert_eq!((verdict.missed.len(), verdict.pixels_different), (0, 0));
}

#[test]
fn a_fountain_that_moves_is_seen_as_it_is_at_every_moment_and_nothing_else_is_built() {
    let subject = subject("enfilade");
    let find = |scene: &enfilade::Scene| {
        let mut sectors = scene.sectors();
        sectors
            .find(|&id| scene.sector_name(id) == "Fountain")
            .expect("the palace has one")
    };
    for (method, scene) in subject
        .seen
        .iter()
        .filter(|(method, _)| method.contract().never_misses())
    {
        let mut scene = scene.clone();
        let fountain = find(&scene);
        let still = Arc::clone(scene.geometry(fountain).expect("it has geometry"));
        let before: Vec<u64> = scene.sectors().map(|id| scene.builds(id)).collect();
        let mut viewer = viewer();
        for moment in 1..=3 {
            scene
                .set_geometry(fountain, with_raised_drops(&still, 0.2 * moment as f32))
                .expect("it fits");
            let view = subject.camera("fountain");
            let truth = Reference::new(&scene).see(&scene, &view, &limits());
            let picture = drawn(&mut viewer, &scene, &view);
            let verdict = truth.check(viewer.visible(), Some(&picture));
            assert!(verdict.reference_visible > 10, "{method}");
            assert_eq!(
                (verdict.missed.len(), verdict.pixels_different),
                (0, 0),
                "{method}"
            );
            for (id, before) in scene.sectors().zip(&before) {
                let more = if id == fountain { moment } else { 0 };
                assert_eq!(
                    scene.builds(id),
                    before + more,
                    "{method}: {}",
                    scene.sector_name(id)
                );
            }
        }
    }
}

/// Returns the geometry of the fountain with its drops raised, in metres.
fn with_raised_drops(still: &Geometry, up: f32) -> Geometry {
    let mut geometry = GeometryBuilder::new(still.materials());
    geometry.textures(still.textures());
    let meshes: Vec<_> = (still.meshes().iter())
        .map(|mesh| geometry.mesh(Arc::clone(mesh)))
        .collect();
    for (number, item) in (0..).zip(still.items()) {
        let name = still.name(ItemIndex(number));
        let up = if name.starts_with("Fountain: drop") {
            up
        } else {
            0.0
        };
        let raised = Transform::translation([0.0, up, 0.0]) * item.transform();
        geometry.item(name, meshes[item.mesh.0 as usize], raised);
    }
    for opening in still.openings() {
        geometry.opening(&opening.name, opening.outline.clone());
    }
    geometry.build().expect("a fountain as before")
}
