//! What a visible set holds, by the scene that was looked at: names and triangles, and what frustum culling alone would
//! draw.

use crate::ids::ItemIndex;
use crate::scene::Scene;
use crate::view::visible::{VisibleItem, VisibleSet};
use std::collections::BTreeSet;

impl VisibleSet {
    /// Returns the name of each visible item, in the order of [`VisibleSet::items`]: an item that is visible through
    /// two passages comes twice. The name is empty for items without one and for those of custom sectors.
    pub fn names<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = &'a str> {
        self.items.iter().map(|item| {
            let geometry = scene.geometry(self.passage(item.passage).sector);
            geometry.map_or("", |geometry| geometry.name(item.item.index))
        })
    }

    /// Returns the number of triangles in the set: for a mesh of several clusters, those of the visible clusters.
    pub fn triangle_count(&self, scene: &Scene) -> u64 {
        let triangles = |item: &VisibleItem| {
            let sector = self.passage(item.passage).sector;
            let clusters = self.clusters(item);
            let Some(geometry) = scene.geometry(sector) else {
                return scene.sector(sector).item_triangles(item.item.index, clusters);
            };
            let mesh = geometry.mesh_of(item.item.index);
            if clusters.is_empty() {
                mesh.triangle_count()
            } else {
                // The item may have another mesh by now.
                let known = clusters.iter().map(|&cluster| cluster as usize);
                let known = known.filter(|&cluster| cluster < mesh.clusters().len());
                known.map(|cluster| mesh.triangles_in(cluster)).sum()
            }
        };
        self.items.iter().map(triangles).sum()
    }

    /// Counts the items that frustum culling alone would draw in the visible sectors; returns their number and that of
    /// their triangles. Those that the look ignored or that are not drawn do not count, those that are never culled do.
    ///
    /// An item counts once, if its AABB may be inside the frustum of any passage into its sector: that of the whole
    /// screen, not of the aperture, beyond the last portal. For custom sectors uses
    /// [`Sector::item_count`](crate::Sector::item_count), [`Sector::item_bounds`](crate::Sector::item_bounds) and
    /// [`Sector::item_triangles`](crate::Sector::item_triangles).
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
                let mut meet = |item| meet(item, &|| geometry.mesh_of(item).triangle_count());
                geometry.items_in_passage(passage, |item| {
                    let placed = geometry.item(item);
                    if placed.options.is_drawn && passage.takes(placed) {
                        meet(item);
                    }
                });
                let anyway = geometry.never_culled().iter();
                anyway
                    .filter(|&&item| passage.takes_always(geometry.item(item)))
                    .for_each(|&item| meet(item));
                continue;
            }
            let own = scene.sector(passage.sector);
            for item in (0..own.item_count()).map(ItemIndex) {
                if passage.frustum_meets(&passage.screen_from_sector, &own.item_bounds(item)) {
                    meet(item, &|| own.item_triangles(item, &[]));
                }
            }
        }
        (met.len(), triangles)
    }
}
