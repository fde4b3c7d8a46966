//! Ids: indices of a distinct type for each kind of thing.

/// Identifies a sector: its index in [`Scene::sectors`](crate::Scene::sectors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SectorId(pub u32);

/// Identifies a portal: its index in [`Scene::portals`](crate::Scene::portals).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortalId(pub u32);

/// Identifies an opening of a sector: its index in [`Geometry::openings`](crate::Geometry::openings).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OpeningId(pub u16);

/// Identifies a passage of a look: its index in [`VisibleSet::passages`](crate::VisibleSet::passages).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PassageId(pub u32);

/// Index of an item in [`Geometry::items`](crate::Geometry::items). The index of a removed item is reused by a later one;
/// keep an [`ItemId`] to recognize that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ItemIndex(pub u32);

/// Identifies an item of a sector for as long as the sector keeps its geometry: an index and a generation.
///
/// An item that reuses the index of a removed one has another generation, so a stale id never names another item:
/// edits return [`EditError::NoSuchItem`](crate::EditError::NoSuchItem) for it, and
/// [`Geometry::index_of`](crate::Geometry::index_of) returns `None`.
#[doc(alias = "handle")]
#[doc(alias = "instance id")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemId {
    /// Index among the items of the sector.
    pub index: ItemIndex,
    /// 0 for the items of a [`GeometryBuilder`](crate::GeometryBuilder) and of custom sectors; counts the items that
    /// edits have added to the sector.
    pub generation: u32,
}

impl From<ItemIndex> for ItemId {
    /// Returns the id of an item that was built with its geometry, or of an item of a custom sector: generation 0.
    fn from(index: ItemIndex) -> ItemId {
        ItemId { index, generation: 0 }
    }
}

/// Identifies a mesh of a geometry: its index in [`Geometry::meshes`](crate::Geometry::meshes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MeshId(pub u32);

/// Identifies a material: its index in [`Geometry::materials`](crate::Geometry::materials).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// Identifies a texture: its index in [`Geometry::textures`](crate::Geometry::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TextureId(pub u32);

/// Identifies a cell: its index in the list of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellId(pub u32);

/// Identifies a light: its index in [`Scene::lights`](crate::Scene::lights).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// Identifies a nested scene: its index in the order of [`SceneBuilder::nest`](crate::SceneBuilder::nest) calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NestedId(pub(crate) u32);
