//! Invariants of all built-in scenes.

use enfilade::{ConvexPolygon, Portal, Scene};
use enfilade_scenes::{BuiltIn, Group, NAMES, SCENES, built_in, figures, law_scenes, random_scene};
use std::collections::BTreeSet;

#[test]
fn names_are_unique_and_lead_to_their_scenes() {
    let names: BTreeSet<&str> = NAMES.into_iter().collect();
    assert_eq!(names.len(), NAMES.len());
    assert_eq!(law_scenes().count(), NAMES.len() - 1);
    assert!(SCENES.iter().all(|named| !named.about.is_empty()));
    assert!(NAMES.iter().all(|name| built_in(name).is_some()));
    assert!(built_in("no such scene").is_none());
}

#[test]
fn every_camera_sees_with_a_sound_view_and_has_a_name_of_its_own() {
    for named in &SCENES {
        let BuiltIn { cameras, scene } = named.build();
        // Figures have fixed cameras.
        let few = named.name == "random" || figures().any(|figure| figure.name == named.name);
        let least = if few { 1 } else { 3 };
        assert!(cameras.len() >= least, "{} has too few cameras", named.name);
        let names: BTreeSet<&str> = cameras.iter().map(|camera| &*camera.name).collect();
        assert_eq!(names.len(), cameras.len());
        for camera in &cameras {
            let view = camera.view([128, 96]);
            assert!(view.is_ok(), "{}, {}: {view:?}", named.name, camera.name);
            assert!(scene.locate(camera.eye, camera.toward).is_some());
        }
    }
}

#[test]
fn both_sides_of_every_door_have_one_outline() {
    let mut doors = 0;
    let mut teleports = BTreeSet::new();
    for named in &SCENES {
        let scene = named.build().scene;
        for portal in scene.portals() {
            let outline = outline(&scene, portal);
            let there: Vec<[f32; 3]> = outline
                .corners()
                .iter()
                .map(|&corner| portal.there_from_here.point(corner))
                .collect();
            let geometry = scene.geometry(portal.to).expect("a sector with geometry");
            // A mirror leads back through its own outline; other portals exchange front and back.
            let arrives = geometry.openings().iter().any(|opening| {
                let mut corners = opening.outline.corners().to_vec();
                if !portal.there_from_here.mirrors() {
                    corners.reverse();
                }
                coincide(&there, &corners)
            });
            if arrives {
                doors += 1;
            } else {
                assert!(
                    named.is(Group::Teleports),
                    "{}: opening {} leads nowhere",
                    named.name,
                    portal.opening.0
                );
                teleports.insert(named.name);
            }
        }
    }
    assert!(doors > 80);
    let listed: BTreeSet<&str> = SCENES
        .iter()
        .filter(|named| named.is(Group::Teleports))
        .map(|named| named.name)
        .collect();
    assert_eq!(teleports, listed, "scenes listed as having teleports");
}

fn outline<'a>(scene: &'a Scene, portal: &Portal) -> &'a ConvexPolygon {
    let geometry = scene.geometry(portal.from).expect("a sector with geometry");
    &geometry.openings()[usize::from(portal.opening.0)].outline
}

/// Returns `true` for the same corners in the same order, from any start, up to f32 rounding.
fn coincide(a: &[[f32; 3]], b: &[[f32; 3]]) -> bool {
    let size = a
        .iter()
        .flatten()
        .fold(0.0_f32, |most, value| most.max(value.abs()));
    let close = |p: &[f32; 3], q: &[f32; 3]| (0..3).all(|axis| (p[axis] - q[axis]).abs() <= 2e-6 * size);
    a.len() == b.len()
        && (0..b.len()).any(|first| (0..a.len()).all(|i| close(&a[i], &b[(first + i) % b.len()])))
}

#[test]
fn scenes_contain_what_they_say() {
    for named in &SCENES {
        let scene = named.build().scene;
        let leads = |portal: &&Portal| !portal.there_from_here.mirrors();
        assert_eq!(
            scene.portals().iter().any(|portal| leads(&portal)),
            named.is(Group::Doors) || named.is(Group::Nested),
            "doors of {}",
            named.name
        );
        assert_eq!(
            scene.portals().iter().any(|portal| !leads(&portal)),
            named.is(Group::Mirrors),
            "mirrors of {}",
            named.name
        );
        let large = scene.item_count() > 1000 || scene.triangle_count() > 10_000;
        assert_eq!(large, named.is(Group::Large), "size of {}", named.name);
    }
}

#[test]
fn random_scenes_follow_from_their_seed() {
    let count = |seed| random_scene(seed).scene.triangle_count();
    let counts: Vec<u64> = (0..200).map(count).collect();
    assert!((0..200).all(|seed| count(seed) == counts[seed as usize]));
    assert!(counts.iter().collect::<BTreeSet<_>>().len() > 50);
    for seed in 0..200 {
        let BuiltIn { cameras, .. } = random_scene(seed);
        assert!(!cameras.is_empty());
        assert!(cameras.iter().all(|camera| camera.view([64, 48]).is_ok()));
    }
}
