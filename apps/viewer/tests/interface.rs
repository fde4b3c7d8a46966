//! The viewer without a window: keys, clicks and pictures.

use eframe::egui::{Key, PointerButton};
use enfilade_viewer::loading::Loading;
use enfilade_viewer::offscreen::Offscreen;
use enfilade_viewer::session::Session;
use image::RgbaImage;

const SIZE: [u32; 2] = [1000, 640];

fn palace() -> Offscreen {
    Offscreen::new(SIZE, Loading::file("@enfilade")).expect("an adapter, such as that of mesa-vulkan-drivers")
}

fn session(viewer: &Offscreen) -> &Session {
    viewer.app.session.as_ref().expect("the palace is open")
}

/// Number of pixels that differ between two pictures.
fn different(a: &RgbaImage, b: &RgbaImage) -> usize {
    a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count()
}

#[test]
fn keys_move_the_camera_and_a_click_says_why_an_item_is_visible() {
    let mut viewer = palace();
    let start = session(&viewer).view.eye();
    let before = viewer.picture().expect("a picture");
    viewer.press(Key::W, 10);
    let moved = session(&viewer).view.eye();
    assert!((moved[2] - start[2]).abs() > 0.3, "from {start:?} to {moved:?}");
    let after = viewer.picture().expect("a picture");
    assert!(different(&before, &after) > 100_000);
    viewer.click([330.0, 560.0], PointerButton::Primary);
    let selected = session(&viewer).selected.as_ref().expect("an item is there");
    assert!(selected.explanation.is_visible);
    assert!(
        selected.explanation.reasons[0].contains("camera's own sector"),
        "{:?}",
        selected.explanation
    );
}

#[test]
fn a_frozen_set_is_seen_from_outside_with_ghosts_of_what_is_hidden() {
    let mut viewer = palace();
    let items = session(&viewer).stats.items;
    viewer.press(Key::F, 1);
    let frozen = session(&viewer).frozen.as_ref().expect("it is frozen");
    assert!(frozen.items.iter().any(|item| item.ghost.is_some()));
    if let Some(session) = &mut viewer.app.session {
        session.rise();
    }
    viewer.frame(Vec::new());
    let with_ghosts = viewer.picture().expect("a picture");
    if let Some(session) = &mut viewer.app.session {
        session.ghosts = false;
        session.place();
    }
    viewer.frame(Vec::new());
    let without = viewer.picture().expect("a picture");
    assert!(different(&with_ghosts, &without) > 20_000);
    // Flying around does not change the set.
    viewer.press(Key::S, 5);
    assert_eq!(session(&viewer).stats.items, items);
    viewer.press(Key::F, 1);
    assert!(session(&viewer).frozen.is_none());
}

#[test]
fn a_door_that_is_clicked_closes() {
    let mut viewer = palace();
    let open = |viewer: &Offscreen| {
        let portals = session(viewer).world.scene.portals().iter();
        portals.filter(|portal| portal.open).count()
    };
    let (before, passages) = (open(&viewer), session(&viewer).stats.passages);
    viewer.click([470.0, 330.0], PointerButton::Secondary);
    assert_eq!(open(&viewer), before - 2, "{:?}", viewer.app.message);
    assert!(session(&viewer).stats.passages < passages);
}

#[test]
fn a_file_that_cannot_be_read_leaves_the_scene_and_says_why() {
    let mut viewer = palace();
    let file = std::env::temp_dir().join("enfilade-broken.glb");
    std::fs::write(&file, b"glTF but not really").expect("written");
    viewer.app.load(Loading::file(&file.to_string_lossy()));
    while viewer.app.message.as_ref().is_none_or(|(_, is_error)| !is_error) {
        viewer.frame(Vec::new());
    }
    let (message, _) = viewer.app.message.clone().expect("it says why");
    assert!(message.contains("enfilade-broken.glb"), "{message}");
    assert_eq!(session(&viewer).world.name, "@enfilade");
    std::fs::remove_file(&file).expect("removed");
}
