//! The doors, windows, teleport and mirror of an authored villa, each opened and closed.

use enfilade::laws::{Contestants, OwnerPicture, Reference, views_through};
use enfilade::{Camera, Limits, Method, PortalId, Scene, View, Viewer};
use enfilade_import::{ReadOptions, read};
use std::path::Path;

const SIZE: [u32; 2] = [80, 60];

/// Before a portal's opening, looking through its middle.
fn before(scene: &Scene, portal: PortalId, away: f32) -> View {
    let portal = &scene.portals()[portal.0 as usize];
    let outline = &scene.sector(portal.from).openings()[usize::from(portal.opening.0)].outline;
    let [middle, normal] = [outline.bounds().center(), outline.normal()];
    let eye = std::array::from_fn(|axis| middle[axis] + away * normal[axis]);
    let camera = Camera {
        sector: Some(portal.from),
        ..Camera::new(eye, middle)
    };
    camera.view(SIZE).expect("a valid view")
}

/// Returns `true` if a passage through the portal is visible. Every visible one is compared with the reference.
fn is_seen_through(scene: &Scene, reference: &Reference, view: &View, portal: PortalId) -> bool {
    let limits = Limits::default();
    let truth = reference.see(scene, view, &limits);
    let mut picture = OwnerPicture::new(view.size());
    let mut viewer = Viewer::new();
    viewer.draw(scene, view, &mut picture);
    let verdict = truth.check(viewer.visible(), Some(&picture));
    assert_eq!(
        (verdict.missed.len(), verdict.pixels_different),
        (0, 0),
        "{portal:?}"
    );
    let mut passages = viewer.visible().passages().iter();
    passages.any(|passage| passage.portal == Some(portal))
}

/// Returns the villa.
fn villa() -> Scene {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let file = Path::new(&folder).join("blender_villa.glb");
    let import = read(&file, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let scene = import.scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT);
    scene.expect("it fits")
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn no_frame_is_lost_on_the_way_through_the_portals_of_a_villa() {
    let scene = villa();
    let mut contestants = Contestants::new(&scene, Limits::default(), Method::DEFAULT_LIMIT);
    let mut visible = 0;
    for portal in (0..scene.portals().len() as u32).map(PortalId) {
        for view in views_through(&scene, portal, [16, 12]) {
            let (items, broken) = contestants.check(&view);
            let broken: Vec<String> = broken.iter().map(ToString::to_string).collect();
            assert!(broken.is_empty(), "{portal:?}, {view:?}:\n{}", broken.join("\n"));
            visible += items;
        }
    }
    assert!(visible > 10_000, "{visible}");
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn every_portal_of_a_villa_shows_what_is_behind_it_until_it_is_closed() {
    let mut scene = villa();
    let reference = Reference::new(&scene);
    let portals: Vec<PortalId> = (0..scene.portals().len() as u32).map(PortalId).collect();
    assert_eq!(
        portals.len(),
        43,
        "20 doors and windows of two ways, one of one way, a teleport and a mirror"
    );
    for portal in portals {
        // Curtains, hedges and furniture stand before some: from one of these places they do not.
        let views = [0.3, 0.9, 0.1].map(|away| before(&scene, portal, away));
        let seen = |scene: &Scene| {
            views
                .iter()
                .any(|view| is_seen_through(scene, &reference, view, portal))
        };
        assert!(seen(&scene), "{portal:?} shows nothing");
        let builds: Vec<u64> = scene.sectors().map(|id| scene.builds(id)).collect();
        scene.set_open(portal, false);
        assert!(!seen(&scene), "{portal:?} is closed, but seen through");
        scene.set_open(portal, true);
        assert!(scene.sectors().map(|id| scene.builds(id)).eq(builds));
    }
}
