//! Which levels are wanted: by how far an error shows on the screen.

use super::Details;
use crate::content::ItemId;
use crate::scene::{FragmentId, Scene};
use crate::visible::VisibleSet;
use std::collections::BTreeMap;

/// A level that an item wants.
pub(super) struct Wanted {
    pub(super) key: (FragmentId, ItemId),
    pub(super) level: u32,
}

impl Details {
    /// What was seen, each with the level that it wants, those first whose errors show most.
    pub(super) fn wanted(&self, scene: &Scene, seen: &[&VisibleSet]) -> Vec<Wanted> {
        let mut most: BTreeMap<(FragmentId, ItemId), f64> = BTreeMap::new();
        for set in seen {
            for item in set.items() {
                let passage = set.passage(item.passage);
                let key = (passage.fragment, item.item);
                let Some((held, content)) = self.items.get(&key).zip(scene.content(key.0)) else {
                    continue;
                };
                let bounds = self.sources[&held.source].source.bounds();
                let pixels = passage.pixels_per_unit(&content.item(item.item).transform(), &bounds);
                let known = most.entry(key).or_default();
                *known = known.max(pixels);
            }
        }
        let mut all: Vec<(f64, Wanted)> = most
            .into_iter()
            .map(|(key, pixels)| {
                let held = &self.items[&key];
                let source = &*self.sources[&held.source].source;
                let shows = held
                    .level
                    .map_or(f64::INFINITY, |level| f64::from(source.error(level)) * pixels);
                let level = self.level_for(held.source, held.level, pixels);
                (shows, Wanted { key, level })
            })
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.key.cmp(&b.1.key)));
        all.into_iter().map(|(_, wanted)| wanted).collect()
    }

    /// The coarsest level whose error is within the tolerance; one coarser than now only where it is so by far.
    fn level_for(&self, source: usize, now: Option<u32>, pixels: f64) -> u32 {
        let source = &*self.sources[&source].source;
        let finest = source.levels().saturating_sub(1);
        let tolerance = f64::from(self.options.tolerance_px);
        let suffices = |level: u32, tolerance: f64| f64::from(source.error(level)) * pixels <= tolerance;
        let first = |tolerance: f64| {
            (0..finest)
                .find(|&level| suffices(level, tolerance))
                .unwrap_or(finest)
        };
        match now {
            Some(now) if suffices(now, tolerance) => {
                first(tolerance / f64::from(self.options.hysteresis.max(1.0))).min(now)
            }
            _ => first(tolerance),
        }
    }
}
