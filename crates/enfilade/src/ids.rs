//! Ids: indices of a distinct type for each kind of thing.

/// Identifies a sector: its index in [`Scene::sectors`](crate::Scene::sectors).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SectorId(pub u32);

/// Identifies a portal: its index in [`Scene::portals`](crate::Scene::portals).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PortalId(pub u32);

/// Identifies an opening of a sector: its index in [`Geometry::openings`](crate::Geometry::openings).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OpeningId(pub u16);

/// Identifies a passage of a look: its index in [`VisibleSet::passages`](crate::VisibleSet::passages).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PassageId(pub u32);

/// Identifies an item of a sector: its index in [`Geometry::items`](crate::Geometry::items).
#[doc(alias = "instance id")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ItemIndex(pub u32);

/// Identifies a mesh of a geometry: its index in [`Geometry::meshes`](crate::Geometry::meshes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MeshId(pub u32);

/// Identifies a material: its index in [`Geometry::materials`](crate::Geometry::materials).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// Identifies a texture: its index in [`Geometry::textures`](crate::Geometry::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureId(pub u32);

/// Identifies a cell: its index in the list of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellId(pub u32);

/// Identifies a light: its index in [`Scene::lights`](crate::Scene::lights).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// Identifies a nested scene: its index in the order of [`SceneBuilder::nest`](crate::SceneBuilder::nest) calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NestedId(pub(crate) u32);
