//! LOD selection by screen-space error.

use crate::{Details, Key};
use enfilade::{Aabb, ItemId, ItemIndex, Passage, Scene, SectorId, VisibleSet};
use std::collections::BTreeMap;

/// The level that an item should have.
pub(super) struct WantedLevel {
    pub(super) key: Key,
    pub(super) level: u32,
}

impl Details {
    /// Returns the visible items, each with its target level, largest screen-space error first.
    pub(super) fn wanted(&self, scene: &Scene, seen: &[&VisibleSet]) -> Vec<WantedLevel> {
        let mut most: BTreeMap<Key, f64> = BTreeMap::new();
        let mut note = |passage: &Passage, item: ItemId| {
            let key = (passage.sector, item);
            if !self.holds(scene, key) {
                return;
            }
            let Some(geometry) = scene.geometry(key.0) else {
                return;
            };
            let bounds = &self.sources[&self.items[&key].source].bounds;
            let pixels = passage.pixels_per_unit(&geometry.item(item.index).transform(), bounds);
            let known = most.entry(key).or_default();
            *known = known.max(pixels);
        };
        for set in seen {
            for item in set.items() {
                note(set.passage(item.passage), item.item);
            }
            for passage in set.passages() {
                for item in self.entered(scene, passage) {
                    note(passage, item);
                }
            }
        }
        let mut all: Vec<(f64, WantedLevel)> = most
            .into_iter()
            .map(|(key, pixels)| {
                let shows = pixels * self.sources[&self.items[&key].source].error(self.items[&key].level);
                let level = self.level_for(key, pixels);
                (shows, WantedLevel { key, level })
            })
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.key.cmp(&b.1.key)));
        all.into_iter().map(|(_, wanted)| wanted).collect()
    }

    /// Returns the items whose AABB contains the start of a passage: the eye or the last portal. Such an item need not
    /// appear in the visible set, as no face of its volume may be in view, yet its finer levels may be in front of
    /// everything drawn.
    fn entered(&self, scene: &Scene, passage: &Passage) -> impl Iterator<Item = ItemId> {
        let begins = beginnings(scene, passage);
        let first_of = |sector| (sector, ItemId::from(ItemIndex(0)));
        let here = first_of(passage.sector)..first_of(SectorId(passage.sector.0 + 1));
        let geometry = scene.geometry(passage.sector);
        self.items.range(here).filter_map(move |(key, _)| {
            let held = geometry?;
            let bounds = &held.item(held.index_of(key.1)?).bounds;
            let begins_within = begins.iter().flatten().any(|begin| begin.meets(bounds));
            (begins_within && passage.may_show(bounds)).then_some(key.1)
        })
    }

    /// Returns the coarsest level whose error is within the tolerance. Switches to a coarser level than the current one
    /// only with the margin given by [`DetailOptions::hysteresis`](crate::DetailOptions::hysteresis).
    fn level_for(&self, key: Key, pixels: f64) -> u32 {
        let held = &self.items[&key];
        let levels = &self.sources[&held.source];
        let tolerance = f64::from(self.options.tolerance_px);
        let suffices = |level: u32, tolerance: f64| levels.error(Some(level)) * pixels <= tolerance;
        let first = |tolerance: f64| {
            (0..levels.finest())
                .find(|&level| suffices(level, tolerance))
                .unwrap_or(levels.finest())
        };
        match held.level {
            Some(now) if suffices(now, tolerance) => {
                first(tolerance / f64::from(self.options.hysteresis.max(1.0))).min(now)
            }
            _ => first(tolerance),
        }
    }
}

/// Returns AABBs around the start of a passage: around the eye with the near plane's corners, and around the last
/// portal.
fn beginnings(scene: &Scene, passage: &Passage) -> [Option<Aabb>; 2] {
    let [width, height] = passage.size.map(f64::from);
    // Rays of a parallel view begin in the near plane.
    let near = if passage.is_parallel() {
        0.0
    } else {
        f64::from(passage.z_near)
    };
    let corners = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]].map(|corner| {
        let [eye, toward] = passage.ray(corner);
        [0, 1, 2].map(|axis| (eye[axis] + near * toward[axis]) as f32)
    });
    let eye = passage.eye().map(|value| value as f32);
    let portal = passage.portal.map(|portal| {
        let portal = &scene.portals()[portal.0 as usize];
        let opening = &scene.sector(portal.from).openings()[portal.opening.0 as usize];
        let outline = opening.outline.corners().iter();
        Aabb::of(outline.map(|&corner| portal.there_from_here.point(corner)))
    });
    [Some(Aabb::of(corners.into_iter().chain([eye]))), portal]
}
