//! The answer to a look.

use crate::geometry::ItemId;
use crate::passage::{Passage, PassageId};
use crate::scene::Scene;
use std::collections::BTreeSet;

/// What can be seen: passages, and in each the items.
#[derive(Debug, Default)]
pub struct VisibleSet {
    pub(crate) passages: Vec<Passage>,
    pub(crate) items: Vec<VisibleItem>,
    pub(crate) clusters: Vec<u32>,
    pub(crate) complete: bool,
}

/// An item that may be seen through a passage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleItem {
    /// The way it is seen.
    pub passage: PassageId,
    /// The item, in the passage's sector.
    pub item: ItemId,
    /// The longer side of its box on the screen, in pixels, within the aperture.
    pub size_px: u16,
    /// Is any of what may be seen of it glass? Then it is to be blended over what is opaque: see
    /// [`VisibleSet::blend_order`].
    pub blends: bool,
    pub(crate) clusters: [u32; 2],
}

impl VisibleSet {
    /// The ways from the eye into sectors; the first is the one that the eye stands in, and each comes after its
    /// parent.
    pub fn passages(&self) -> &[Passage] {
        &self.passages
    }

    /// One passage.
    pub fn passage(&self, id: PassageId) -> &Passage {
        &self.passages[id.0 as usize]
    }

    /// What may be seen, passage after passage; within one, each item once.
    pub fn items(&self) -> &[VisibleItem] {
        &self.items
    }

    /// The clusters of an item's mesh that may be seen; empty stands for all.
    pub fn clusters(&self, item: &VisibleItem) -> &[u32] {
        &self.clusters[item.clusters[0] as usize..item.clusters[1] as usize]
    }

    /// Was every opening that is seen also followed? If not, a limit of the viewer stopped it.
    pub fn complete(&self) -> bool {
        self.complete
    }

    /// Returns the name of each visible item, in the order of [`VisibleSet::items`]: an item that is visible through two
    /// passages comes twice. The name is empty for items without one and for those of custom sectors.
    pub fn names<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = &'a str> {
        self.items.iter().map(|item| {
            let geometry = scene.geometry(self.passage(item.passage).sector);
            geometry.map_or("", |geometry| geometry.name(item.item))
        })
    }

    /// Triangles of what is in the set: of a large item, those of the clusters that are seen.
    pub fn triangle_count(&self, scene: &Scene) -> u64 {
        let triangles = |item: &VisibleItem| {
            let sector = self.passage(item.passage).sector;
            let clusters = self.clusters(item);
            let Some(geometry) = scene.geometry(sector) else {
                return scene.sector(sector).item_triangles(item.item, clusters);
            };
            let mesh = geometry.mesh_of(item.item);
            if clusters.is_empty() {
                mesh.triangle_count()
            } else {
                // The item may be of another mesh by now.
                let known = clusters.iter().map(|&cluster| cluster as usize);
                let known = known.filter(|&cluster| cluster < mesh.clusters().len());
                known.map(|cluster| mesh.triangles_in(cluster)).sum()
            }
        };
        self.items.iter().map(triangles).sum()
    }

    /// Items and triangles whose boxes meet the frustum, in the sectors that are seen, each item counted once: what
    /// would be left to draw if nothing hid anything.
    pub fn in_frustum(&self, scene: &Scene) -> (usize, u64) {
        let mut met = BTreeSet::new();
        let mut triangles = 0;
        for passage in &self.passages {
            let mut meet = |item, its_triangles: &dyn Fn() -> u64| {
                if met.insert((passage.sector, item)) {
                    triangles += its_triangles();
                }
            };
            if let Some(geometry) = scene.geometry(passage.sector) {
                geometry.items_in_passage(passage, |item| {
                    meet(item, &|| geometry.mesh_of(item).triangle_count());
                });
                continue;
            }
            let own = scene.sector(passage.sector);
            for item in (0..own.item_count()).map(ItemId) {
                if passage.frustum_meets(&passage.screen_from_sector, &own.item_bounds(item)) {
                    meet(item, &|| own.item_triangles(item, &[]));
                }
            }
        }
        (met.len(), triangles)
    }
}
