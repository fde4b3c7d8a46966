//! The trait that every sector implements, and the types of its ray casts and contracts.

use crate::contract::Contract;
use crate::geom::Aabb;
use crate::geometry::{Alpha, Opening};
use crate::ids::{ItemId, ItemIndex};
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::memory::Memory;
use crate::view::options::ViewerOptions;
use crate::view::passage::Passage;
use std::fmt;

/// A region of the scene that computes its own visibility: a [`Geometry`](crate::Geometry) with a
/// [`Method`](crate::Method), or a custom sector added by
/// [`SceneBuilder::add_custom`](crate::SceneBuilder::add_custom).
///
/// A sector knows its openings but not where they lead; the [`Viewer`](crate::Viewer) follows the portals. Positions,
/// boxes and rays are in the space of the sector, in scene units. Source: Boreskov, Using portals to create aggregate
/// scenes ("a sector draws itself inside a given polygon of the picture plane").
#[doc(alias = "cell")]
#[doc(alias = "zone")]
#[doc(alias = "room")]
pub trait Sector: Send + Sync {
    /// Returns the AABB of all geometry in the sector.
    fn bounds(&self) -> Aabb;

    /// Returns the openings; an [`OpeningId`](crate::OpeningId) is an index into this slice.
    fn openings(&self) -> &[Opening];

    /// Returns the contract that [`Sector::gather`] and [`Sector::draw`] fulfil in a look with these options.
    fn contract(&self, options: &ViewerOptions) -> Contract;

    /// Whether [`Sector::draw`] draws only the items that [`Sector::gather`] reported just before for the same passage.
    /// Default `false`. Methods that compute which items are visible, but not at which samples, return `true`.
    fn draws_what_was_gathered(&self, _options: &ViewerOptions) -> bool {
        false
    }

    /// Reports every item and every opening that may be visible through `passage` to `seen`.
    ///
    /// [`VisibleSet::items`](crate::VisibleSet::items) keeps the order of the reports. They are not checked: an item or
    /// an opening that is missing here is missing in the set, too.
    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector);

    /// Emits the opaque spans visible through `passage` to `canvas`, and reports items and openings to `seen` as
    /// [`Sector::gather`] does.
    ///
    /// Alpha-blended and alpha-tested samples go to `seen` ([`Collector::glass`]); the viewer draws them after
    /// everything behind the openings. If [`Sector::draws_what_was_gathered`] returns `true`, `seen` already holds the
    /// gathered items.
    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas);

    /// Returns the first face along a ray, whichever side of the face the ray comes from.
    fn cast(&self, ray: &Ray) -> Option<Hit>;

    /// Returns normal, position, color and alpha of a face.
    fn surface(&self, item: ItemIndex, face: u32) -> Surface;

    /// Runs the traversal order through `passage` without a cover, to measure what the order alone costs.
    ///
    /// Returns the number of faces emitted. Default 0, for sectors without an order.
    fn walk(&self, _passage: &Passage, _memory: &mut Memory) -> u64 {
        0
    }

    /// Returns statistics of the structures that were built for this sector. Default: all zero.
    fn build_stats(&self) -> BuildStats {
        BuildStats::default()
    }

    /// Returns the memory used by the sector, in bytes. Default 0.
    fn bytes(&self) -> u64 {
        0
    }

    /// Returns the number of items; their indices are 0 up to this number, exclusive, and their generation is 0. Default 0 (unknown).
    ///
    /// Used for counting, and only for custom sectors: for others
    /// [`Scene::geometry`](crate::Scene::geometry) has the items.
    fn item_count(&self) -> u32 {
        0
    }

    /// Returns the key of an item for [`VisibleItem::key`](crate::VisibleItem::key). Default: its index.
    fn item_key(&self, item: ItemIndex) -> u64 {
        u64::from(item.0)
    }

    /// Returns the name of an item for display. Default: empty (no name).
    fn item_name(&self, _item: ItemIndex) -> String {
        String::new()
    }

    /// Returns the AABB of an item, in the space of the sector. Default: empty (unknown).
    ///
    /// The viewer projects it for [`VisibleItem::size_px`](crate::VisibleItem::size_px), which is 0 if it is empty, and
    /// [`VisibleSet::in_frustum`](crate::VisibleSet::in_frustum) tests it.
    fn item_bounds(&self, _item: ItemIndex) -> Aabb {
        Aabb::EMPTY
    }

    /// Returns the number of triangles in the given clusters of an item, or in all of them if `_clusters` is empty.
    /// Default 0 (unknown).
    fn item_triangles(&self, _item: ItemIndex, _clusters: &[u32]) -> u64 {
        0
    }
}

/// Statistics of the structures that a method built over the faces of a sector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BuildStats {
    /// Number of faces after splitting; the sector's number of faces if the method splits none.
    pub faces: u64,
    /// Number of face splits.
    pub splits: u64,
    /// Levels of the deepest tree; 0 if the method builds none.
    pub depth: u32,
}

/// A ray: a half-line in the space of a sector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start point.
    pub origin: [f32; 3],
    /// Direction, of any length above zero; [`Hit::distance`] is measured in this length.
    pub direction: [f32; 3],
}

/// The intersection of a ray with a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The item that was hit.
    pub item: ItemId,
    /// The key of the item.
    pub key: u64,
    /// Index of the face in the item's mesh.
    pub face: u32,
    /// Distance from the ray's origin, in lengths of the ray's direction; above zero.
    pub distance: f64,
    /// Whether the ray hit the back of the face.
    pub from_behind: bool,
}

/// Surface attributes of a face: position, normal, color and alpha mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Unit normal on the front side, in the space of the sector; zero for a degenerate face.
    pub normal: [f32; 3],
    /// A point on the face, in the space of the sector.
    pub point: [f32; 3],
    /// Red, green, blue and coverage, linear, 0 to 1.
    pub color: [f32; 4],
    /// Whether the face is opaque, alpha-tested or alpha-blended.
    pub alpha: Alpha,
}

/// Requirement of a [`Method`](crate::Method) on the geometry of a sector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Requirement {
    /// A PVS baked for convex cells ([`GeometryBuilder::cells`](crate::GeometryBuilder::cells)).
    BakedCells,
    /// Faces that bound a convex space: each face has all others on one side.
    Convex,
    /// A height field ([`GeometryBuilder::terrain`](crate::GeometryBuilder::terrain)).
    Terrain,
}

impl fmt::Display for Requirement {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Requirement::BakedCells => "baked cells",
            Requirement::Convex => "convex geometry",
            Requirement::Terrain => "a height field",
        })
    }
}
