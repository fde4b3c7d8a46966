//! The result of a look: passages with their visible items.

use crate::ids::{ItemId, PassageId};
use crate::passage::Passage;
use crate::scene::Scene;
use std::collections::BTreeSet;

/// The result of [`Viewer::look`](crate::Viewer::look): the passages from the eye into sectors, and the items visible
/// through each.
///
/// Empty and not [complete](VisibleSet::complete) before the first look, for a view that fails
/// [`View::check`](crate::View::check), and for one whose sector is not in the scene.
#[doc(alias = "cull result")]
#[doc(alias = "PVS")]
#[doc(alias = "potentially visible set")]
#[doc(alias = "draw list")]
#[derive(Debug, Default)]
pub struct VisibleSet {
    pub(crate) passages: Vec<Passage>,
    pub(crate) items: Vec<VisibleItem>,
    pub(crate) clusters: Vec<u32>,
    pub(crate) complete: bool,
}

/// An item that may be visible through a passage.
///
/// An item that is visible through two passages, such as a door and a mirror, has an entry for each.
#[doc(alias = "visible object")]
#[doc(alias = "draw call")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleItem {
    /// The passage through which the item is visible.
    pub passage: PassageId,
    /// The item in the passage's sector.
    pub item: ItemId,
    /// Longer side of the item's screen-space bounding rectangle, clipped to the aperture, in pixels. For an item of a
    /// custom sector the rectangle is that of [`Sector::item_bounds`](crate::Sector::item_bounds); 0 if the sector does
    /// not override that method.
    pub size_px: u16,
    /// Whether any part that may be visible is alpha-blended; draw it in the transparent pass, sorted by
    /// [`VisibleSet::blend_order`]. Always `false` for an item of a custom sector, whose materials are unknown here.
    pub blends: bool,
    pub(crate) clusters: [u32; 2],
}

impl VisibleSet {
    /// Returns the passages, depth first: each is followed by those behind it. The first is that of the eye's sector.
    pub fn passages(&self) -> &[Passage] {
        &self.passages
    }

    /// Returns one passage.
    ///
    /// # Panics
    /// If `id` is not from this set.
    pub fn passage(&self, id: PassageId) -> &Passage {
        &self.passages[id.0 as usize]
    }

    /// Returns the items that may be visible, in the order of [`VisibleSet::passages`]; each item once per passage.
    ///
    /// Within a passage the items are sorted by id, not by distance; those of a custom sector are in the order in which
    /// it reported them.
    pub fn items(&self) -> &[VisibleItem] {
        &self.items
    }

    /// Returns the clusters of an item's mesh that may be visible, as indices into
    /// [`Mesh::clusters`](crate::Mesh::clusters). Empty means all clusters.
    pub fn clusters(&self, item: &VisibleItem) -> &[u32] {
        &self.clusters[item.clusters[0] as usize..item.clusters[1] as usize]
    }

    /// Returns `true` if every visible open portal was followed; `false` if items may be missing, because the viewer
    /// hit one of its [`Limits`](crate::Limits), or if the set is empty because the view is invalid.
    pub fn complete(&self) -> bool {
        self.complete
    }

    /// Returns the name of each visible item, in the order of [`VisibleSet::items`]: an item that is visible through
    /// two passages comes twice. The name is empty for items without one and for those of custom sectors.
    pub fn names<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = &'a str> {
        self.items.iter().map(|item| {
            let geometry = scene.geometry(self.passage(item.passage).sector);
            geometry.map_or("", |geometry| geometry.name(item.item))
        })
    }

    /// Returns the number of triangles in the set: for a mesh of several clusters, those of the visible clusters.
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
                // The item may have another mesh by now.
                let known = clusters.iter().map(|&cluster| cluster as usize);
                let known = known.filter(|&cluster| cluster < mesh.clusters().len());
                known.map(|cluster| mesh.triangles_in(cluster)).sum()
            }
        };
        self.items.iter().map(triangles).sum()
    }

    /// Counts the items that frustum culling alone would draw in the visible sectors; returns their number and that of
    /// their triangles.
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
