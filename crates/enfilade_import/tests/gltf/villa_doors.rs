//! The doors, windows, teleport and mirror of an authored villa, each opened and closed.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{Limits, Method, PortalId, Scene, View, Viewer};
use enfilade_import::{ReadOptions, read};
use std::path::Path;

const SIZE: [u32; 2] = [80, 60];

/// Before a portal's opening, looking through its middle.
fn before(scene: &Scene, portal: PortalId, away: f32) -> View {
    let portal = &scene.portals()[portal.0 as usize];
    let outline = &scene.fragment(portal.from).openings()[usize::from(portal.opening.0)].outline;
    let [middle, normal] = [outline.bounds().center(), outline.normal()];
    let eye = std::array::from_fn(|axis| middle[axis] + away * normal[axis]);
    let mut view = View::new(eye, middle, SIZE);
    view.fragment = Some(portal.from);
    view
}

/// Is a passage through the portal seen? All that is, is held against the reference.
fn is_seen_through(scene: &Scene, reference: &Reference, view: &View, portal: PortalId) -> bool {
    let limits = Limits::default();
    let truth = reference.see(scene, view, &limits);
    let mut picture = OwnerPicture::new(view.size);
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

#[test]
#[allow(clippy::print_stderr, reason = "a skipped test must say so")]
fn every_portal_of_a_villa_shows_what_is_behind_it_until_it_is_closed() {
    let Some(folder) = std::env::var_os("ENFILADE_SCENES") else {
        eprintln!("skipped: ENFILADE_SCENES names no folder of .glb files");
        return;
    };
    let file = Path::new(&folder).join("blender_villa.glb");
    let import = read(&file, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut scene = import
        .scene(Method::HierarchicalZ, Method::DEFAULT_LIMIT)
        .expect("it fits");
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
        let builds: Vec<u64> = scene.fragments().map(|id| scene.builds(id)).collect();
        scene.set_open(portal, false);
        assert!(!seen(&scene), "{portal:?} is closed, but seen through");
        scene.set_open(portal, true);
        assert!(scene.fragments().map(|id| scene.builds(id)).eq(builds));
    }
}
