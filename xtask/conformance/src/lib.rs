//! What must hold on every target, and come out the same, bit for bit: the laws on the small built-in scenes, and a
//! fingerprint of visible sets and pictures.
//!
//! It reads no file and prints nothing, so that it also runs where there is neither: `cargo xtask targets` builds it
//! for other targets and compares its reports with its own.

mod exports;
mod fingerprint;

pub use fingerprint::fingerprint;

use enfilade::{Limits, View, laws};
use enfilade_scenes::{CatalogEntry, Group, SCENES};

/// Viewport width and height, in pixels.
const SIZE: [u32; 2] = [96, 54];

/// Begins each line of a report that tells of a broken law.
pub const BROKEN: &str = "broken: ";

/// Returns the built-in scenes that are tested: all but those with thousands of items.
pub fn scenes() -> impl Iterator<Item = &'static CatalogEntry> {
    SCENES.iter().filter(|named| !named.is(Group::Large))
}

/// Tests the laws on a scene from all its cameras. Returns the fingerprint of these views, a line for each method and
/// view, and a line that begins with [`BROKEN`] for each violation.
pub fn report(named: &CatalogEntry) -> Vec<String> {
    let built = named.build();
    let views: Vec<View> = built
        .cameras
        .iter()
        .map(|camera| camera.view(SIZE).expect("a valid camera"))
        .collect();
    let name = named.name;
    let mut limits = Limits::default();
    // Two facing mirrors would recurse forever.
    limits.max_crossings = 6;
    let report = laws::check(&built.scene, &views, limits);
    let mut lines = vec![format!(
        "{name}: {} items certainly visible, {} layers",
        report.visible, report.layers
    )];
    lines.extend(
        report
            .broken
            .iter()
            .map(|broken| format!("{BROKEN}{name}: {broken}, {:?}", broken.view)),
    );
    if report.visible == 0 {
        lines.push(format!(
            "{BROKEN}{name}: nothing is visible, so nothing was tested"
        ));
    }
    fingerprint(name, &built.scene, &views, &mut lines);
    lines
}
