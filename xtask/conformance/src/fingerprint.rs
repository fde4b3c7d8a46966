//! Fingerprint of a scene: visible sets and picture hashes of every method.
//!
//! Each method keeps its viewer from view to view, so temporal coherence is covered too.

use enfilade::{Method, Scene, View, Viewer, VisibleSet};
use enfilade_draw::{Settings, Stage};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Appends one line for each method and view of a scene.
pub fn fingerprint(name: &str, scene: &Scene, views: &[View], lines: &mut Vec<String>) {
    for method in Method::ALL {
        let Ok(scene) = scene.with_method(method, Method::DEFAULT_LIMIT) else {
            lines.push(format!("{name} {method}: unsuited"));
            continue;
        };
        let stage = Stage::new(&scene);
        let mut viewer = Viewer::new();
        for (number, view) in views.iter().enumerate() {
            let picture = stage.draw(&mut viewer, &scene, view, &Settings::default());
            let mut sum = Sum::new();
            sum.add_bytes(picture.image.as_raw());
            let set = viewer.visible();
            lines.push(format!(
                "{name} {method} view {number}: picture {:016x}, set {:016x}, {}",
                sum.0,
                sum_of(set),
                items_of(set)
            ));
        }
    }
}

/// Formats the items of a set by sector, as ranges of item indices: `0: 3-5 9; 2: 0`.
fn items_of(set: &VisibleSet) -> String {
    let mut by_sector: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for item in set.items() {
        let sector = set.passage(item.passage).sector;
        by_sector.entry(sector.0).or_default().push(item.item.index.0);
    }
    let mut text = format!("{} items in {} passages", set.items().len(), set.passages().len());
    if !set.complete() {
        text.push_str(", not complete");
    }
    for (sector, mut items) in by_sector {
        items.sort_unstable();
        items.dedup();
        _ = write!(text, "; {sector}:");
        for run in items.chunk_by(|a, b| a + 1 == *b) {
            _ = match run {
                [one] => write!(text, " {one}"),
                [first, .., last] => write!(text, " {first}-{last}"),
                [] => Ok(()),
            };
        }
    }
    text
}

/// Hashes a visible set: passages, items and clusters, in order.
fn sum_of(set: &VisibleSet) -> u64 {
    let mut sum = Sum::new();
    for passage in set.passages() {
        sum.add(passage.parent.map_or(u64::MAX, |parent| parent.0.into()));
        sum.add(passage.portal.map_or(u64::MAX, |portal| portal.0.into()));
        sum.add(passage.sector.0.into());
        sum.add(passage.crossings.into());
        sum.add(passage.z_near.to_bits().into());
    }
    for item in set.items() {
        sum.add(item.passage.0.into());
        sum.add(item.item.index.0.into());
        sum.add(item.size_px.into());
        sum.add(item.blends.into());
        for &cluster in set.clusters(item) {
            sum.add(cluster.into());
        }
    }
    sum.0
}

/// FNV-1a (Fowler, Noll, Vo), 64 bits.
struct Sum(u64);

impl Sum {
    fn new() -> Sum {
        Sum(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, number: u64) {
        self.add_bytes(&number.to_le_bytes());
    }

    fn add_bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
