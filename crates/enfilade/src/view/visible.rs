//! The result of a look: passages with their visible items.

use crate::ids::{ItemId, PassageId, SectorId};
use crate::view::passage::Passage;

/// The result of [`Viewer::look`](crate::Viewer::look): the passages from the eye into sectors, and the items visible
/// through each.
///
/// Empty and not [complete](VisibleSet::complete) before the first look, and for a view whose sector is not in the scene.
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
    /// The key of the item ([`GeometryBuilder::set_key`](crate::GeometryBuilder::set_key),
    /// [`Sector::item_key`](crate::Sector::item_key)).
    #[doc(alias = "user data")]
    pub key: u64,
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

    /// Returns `true` if an item of a sector may be visible, through whichever passage. Cost: O(visible items).
    pub fn sees(&self, sector: SectorId, item: ItemId) -> bool {
        let mut items = self.items.iter();
        items.any(|seen| seen.item == item && self.passage(seen.passage).sector == sector)
    }

    /// Sets the bit of each visible item's key: bit `key % 64` of word `key / 64`. Keys beyond the end of `words` are skipped.
    ///
    /// For keys that are small numbers, such as slots of an array of objects. Clear the words first.
    pub fn mark(&self, words: &mut [u64]) {
        for item in &self.items {
            if let Some(word) = usize::try_from(item.key / 64)
                .ok()
                .and_then(|at| words.get_mut(at))
            {
                *word |= 1 << (item.key % 64);
            }
        }
    }

    /// Returns `true` if every visible open portal was followed; `false` if items may be missing, because the viewer
    /// hit one of its [`Limits`](crate::Limits), or if the set is empty because the scene lacks the sector of the view.
    pub fn complete(&self) -> bool {
        self.complete
    }
}
