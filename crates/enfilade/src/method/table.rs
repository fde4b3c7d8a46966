//! The table of methods: which order and cover each is made of. Everything else that can be asked of a method follows
//! from the types in its row.
//!
//! A new method made of existing parts is a type alias, a variant of [`Method`] and a row of [`TABLE`] here, the export
//! of the alias in `lib.rs`, and a row in ARCHITECTURE.md, which a test compares with this table.

use super::combined::{Combination, Combined};
use super::in_cells::InCells;
use super::{Culled, EditableSector, Ordered, Paired};
use crate::contract::Contract;
#[cfg(feature = "terrain")]
use crate::cover::Horizon;
use crate::cover::{ByBox, ByFaces, DepthBuffer, DepthPyramid, MaskedDepth, OcclusionTree, SpanBuffer};
#[cfg(feature = "classic")]
use crate::cover::{Mask, PaintersBuffer};
use crate::geometry::Geometry;
#[cfg(feature = "terrain")]
use crate::order::TerrainRows;
use crate::order::{BakedCellsOrder, BvhOrder, KdTreeOrder, OctreeOrder, Order, Unordered};
#[cfg(feature = "classic")]
use crate::order::{Bsp, ConvexCell, DepthSort, FarToNear, Mean, Min, NearToFar};
use crate::sector::Requirement;
use crate::unsuited::Unsuited;
use crate::view::canvas::CoverShape;
use std::sync::Arc;

/// Painter's algorithm: faces drawn back to front, sorted by their nearest corner.
///
/// No buffer but the picture, no depth test. Approximate: wrong where a face extends nearer than another that occludes
/// it (`@tetrahedron`, `@overlap`), for cyclic overlaps (`@cycle`) and for intersecting faces (`@crossing-triangles`).
///
/// Source: *Painter's algorithm and binary space partitioning* (a thesis in Russian, author unknown), section 1.1.
#[doc(alias = "depth-sort algorithm")]
#[doc(alias = "depth sort")]
#[cfg(feature = "classic")]
pub type PainterMin = Paired<DepthSort<Min>, PaintersBuffer>;

/// Painter's algorithm: faces drawn back to front, sorted by the mean distance of their corners.
///
/// Correct more often than [`PainterMin`], but wrong for long faces next to small ones (`@overlap` from its second
/// camera), for cyclic overlaps (`@cycle`) and for intersecting faces (`@crossing-triangles`).
///
/// Source: *Painter's algorithm and binary space partitioning* (a thesis in Russian, author unknown), section 1.1.
#[cfg(feature = "classic")]
pub type PainterMean = Paired<DepthSort<Mean>, PaintersBuffer>;

/// BSP tree back to front: every face is drawn, farther ones are overdrawn. Exact.
///
/// Source: Fuchs, Kedem, Naylor, On Visible Surface Generation by A Priori Tree Structures, SIGGRAPH 1980;
/// *Painter's algorithm and binary space partitioning* (a thesis in Russian, author unknown), section 1.2.
#[doc(alias = "binary space partitioning")]
#[cfg(feature = "classic")]
pub type BspPainter = Paired<Bsp<FarToNear>, PaintersBuffer>;

/// BSP tree front to back with a coverage mask: every sample is drawn once, without overdraw. Exact.
///
/// Source: Boreskov, Using portals.
#[doc(alias = "binary space partitioning")]
#[doc(alias = "coverage mask")]
#[cfg(feature = "classic")]
pub type BspFront = Paired<Bsp<NearToFar>, Mask>;

/// z-buffer: faces in any order, the nearest one wins at each sample. Exact, and needs no preprocessing.
///
/// Source: Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974; Boreskov, Using portals.
#[doc(alias = "depth buffer")]
pub type ZBuffer = Paired<Unordered, DepthBuffer>;

/// s-buffer: faces in any order, visible spans kept per scanline. Exact, and needs no preprocessing.
///
/// Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 2.
#[doc(alias = "span buffer")]
#[doc(alias = "scanline")]
pub type SBuffer = Paired<Unordered, SpanBuffer>;

/// Hierarchical z-buffer: an octree front to back, and a depth pyramid that culls whole nodes. Exact.
///
/// Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993.
#[doc(alias = "Hi-Z")]
#[doc(alias = "HZB")]
#[doc(alias = "hierarchical depth buffer")]
pub type HierarchicalZ = Paired<OctreeOrder, DepthPyramid>;

/// Hierarchical s-buffer: an octree front to back, and scanline spans that cull whole nodes. Exact.
///
/// Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3.
#[doc(alias = "hierarchical span buffer")]
pub type HierarchicalS = Paired<OctreeOrder, SpanBuffer>;

/// Masked occlusion culling: a BVH front to back, tested against a masked depth buffer. Conservative.
///
/// Each 8×4 tile holds two reversed depths and a coverage mask. Faces that the traversal finds visible are rasterized and
/// hide what comes later. Selected occluders go in first only if
/// [`ViewerOptions::occluders`](crate::ViewerOptions::occluders) asks for some.
///
/// Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016.
#[doc(alias = "masked occlusion culling")]
#[doc(alias = "MOC")]
#[doc(alias = "software occlusion culling")]
pub type Masked = Culled<BvhOrder, MaskedDepth>;

/// Shadow volume BSP (SVBSP), an occlusion tree: a BSP of the shadow volumes of selected occluders, tested with the
/// faces of a kd-tree's boxes. Strict.
///
/// Works in object space, so its result does not depend on the resolution.
///
/// Source: Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998.
#[doc(alias = "shadow volume BSP")]
#[doc(alias = "occlusion tree")]
pub type Svbsp = Culled<KdTreeOrder, OcclusionTree<ByFaces>>;

/// Modified occlusion BSP (MOBSP): an occlusion tree that tests boxes against its planes only. Cheaper than [`Svbsp`],
/// and culls less. Strict.
///
/// Source: *Better occlusion culling in modern computer games* (in Ukrainian, author unknown).
#[doc(alias = "occlusion tree")]
pub type Mobsp = Culled<KdTreeOrder, OcclusionTree<ByBox>>;

/// Potentially visible sets: visibility precomputed per cell, drawn with a z-buffer. Strict.
///
/// Requires geometry with baked cells ([`GeometryBuilder::cells`](crate::GeometryBuilder::cells)).
///
/// Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991; Boreskov, Using
/// portals.
///
/// Moving items is supported, at the cost of sorting their faces into cells. Occluders must stay: a PVS that was baked
/// with a wall keeps culling what is behind it after the wall is removed.
#[doc(alias = "potentially visible set")]
pub type Pvs = Ordered<BakedCellsOrder>;

/// Convex cell: faces of a convex room drawn in any order without depth test. Exact.
///
/// Requires geometry in which all faces are on one side of each face, as in a box-shaped room: there no face occludes
/// another that is viewed from the same side.
///
/// Source: Boreskov, Using portals.
///
/// The faces, openings included, must bound a convex space, viewed from inside or outside. Geometry that is no occluder
/// (blended, alpha-tested, or an item that is no occluder) may be anywhere. An edit that makes the sector
/// non-convex returns an error.
#[doc(alias = "convex sector")]
#[doc(alias = "convex room")]
#[cfg(feature = "classic")]
pub type Cell = Paired<ConvexCell, PaintersBuffer>;

/// Floating horizon: terrain front to back, culled below a rising horizon. Exact.
///
/// Requires geometry that has a height field ([`GeometryBuilder::terrain`](crate::GeometryBuilder::terrain)).
///
/// Source: Anderson, Hidden Line Elimination in Projected Grid Surfaces, ACM TOG 1982; Boreskov, Using portals.
///
/// Other items of the geometry are visited between its blocks by distance, and may occlude some of them. An edit that
/// changes the ground returns an error.
#[doc(alias = "terrain occlusion")]
#[doc(alias = "terrain occlusion culling")]
#[cfg(feature = "terrain")]
pub type FloatingHorizon = Paired<TerrainRows, Horizon>;

/// Visibility algorithm of a sector: a combination of an [order](crate::order) and a [cover](crate::cover).
///
/// Every method returns the same kind of result; [`Method::contract`] states its guarantee and [`Method::requires`]
/// what it needs. [`choose_methods`](crate::choose_methods) measures which one is fastest for a scene.
#[doc(alias = "algorithm")]
#[doc(alias = "technique")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// Painter's algorithm by nearest corner: [`PainterMin`](crate::PainterMin). Approximate.
    #[cfg(feature = "classic")]
    PainterMin,
    /// Painter's algorithm by mean distance: [`PainterMean`](crate::PainterMean). Approximate.
    #[cfg(feature = "classic")]
    PainterMean,
    /// BSP tree, back to front: [`BspPainter`](crate::BspPainter). Exact.
    #[cfg(feature = "classic")]
    Bsp,
    /// BSP tree, front to back with a coverage mask: [`BspFront`](crate::BspFront). Exact.
    #[cfg(feature = "classic")]
    BspFront,
    /// Depth buffer: [`ZBuffer`](crate::ZBuffer). Exact.
    #[cfg(feature = "exact")]
    ZBuffer,
    /// Scanline span buffer: [`SBuffer`](crate::SBuffer). Exact.
    #[cfg(feature = "exact")]
    SBuffer,
    /// Octree and Hi-Z depth pyramid: [`HierarchicalZ`](crate::HierarchicalZ). Exact.
    #[cfg(feature = "exact")]
    HierarchicalZ,
    /// Octree and scanline spans: [`HierarchicalS`](crate::HierarchicalS). Exact.
    #[cfg(feature = "exact")]
    HierarchicalS,
    /// Masked occlusion culling: [`Masked`](crate::Masked). Conservative.
    Masked,
    /// Occlusion tree of shadow volumes, tested by faces: [`Svbsp`](crate::Svbsp). Strict.
    #[cfg(feature = "strict")]
    Svbsp,
    /// Occlusion tree of shadow volumes, tested by boxes: [`Mobsp`](crate::Mobsp). Strict.
    #[cfg(feature = "strict")]
    Mobsp,
    /// Baked potentially visible sets: [`Pvs`](crate::Pvs). Strict; requires a baked PVS.
    #[cfg(feature = "strict")]
    Pvs,
    /// Convex room without depth test: [`Cell`](crate::Cell). Exact; requires convex geometry.
    #[cfg(feature = "classic")]
    Cell,
    /// Floating horizon over terrain: [`FloatingHorizon`](crate::FloatingHorizon). Exact; requires a height field.
    #[cfg(feature = "terrain")]
    FloatingHorizon,
}

/// Facts about a method.
pub(super) struct Row {
    pub(super) method: Method,
    pub(super) name: &'static str,
    pub(super) source: &'static str,
    pub(super) order: &'static str,
    pub(super) cover: &'static str,
    pub(super) contract: Contract,
    pub(super) requires: Option<Requirement>,
    pub(super) takes_cover_size: bool,
    pub(super) splits_faces: bool,
    pub(super) occluders: Option<u32>,
    pub(super) cover_shape: Option<CoverShape>,
    pub(super) screen_bytes: fn([u32; 2], Option<[u32; 2]>) -> u64,
    pub(super) suits: fn(&Geometry) -> bool,
    pub(super) build: Build,
}

type Build = fn(Arc<Geometry>, u64) -> Result<Arc<dyn EditableSector>, Unsuited>;

/// Returns the row of a method whose sectors are `Combined<M>`. `source`: the publication that describes it.
const fn row<M: Combination>(method: Method, name: &'static str, source: &'static str) -> Row {
    Row {
        method,
        name,
        source,
        order: M::Order::NAME,
        cover: M::COVER,
        contract: M::CONTRACT,
        requires: M::Order::REQUIRES,
        takes_cover_size: M::TAKES_COVER_SIZE,
        splits_faces: M::Order::SPLITS_FACES,
        occluders: M::OCCLUDERS,
        cover_shape: M::COVER_SHAPE,
        screen_bytes: M::screen_bytes,
        suits: M::Order::suits,
        build: Combined::<M>::build,
    }
}

/// One row for each method, in the order of [`Method`].
pub(super) const TABLE: &[Row] = &[
    #[cfg(feature = "classic")]
    row::<PainterMin>(
        Method::PainterMin,
        "painter-min",
        "Painter's algorithm and binary space partitioning (a thesis in Russian, author unknown), section 1.1",
    ),
    #[cfg(feature = "classic")]
    row::<PainterMean>(
        Method::PainterMean,
        "painter-mean",
        "Painter's algorithm and binary space partitioning (a thesis in Russian, author unknown), section 1.1",
    ),
    #[cfg(feature = "classic")]
    row::<BspPainter>(
        Method::Bsp,
        "bsp",
        "Fuchs, Kedem, Naylor, On Visible Surface Generation by A Priori Tree Structures, SIGGRAPH 1980",
    ),
    #[cfg(feature = "classic")]
    row::<BspFront>(Method::BspFront, "bsp-front", "Boreskov, Using portals"),
    #[cfg(feature = "exact")]
    row::<ZBuffer>(
        Method::ZBuffer,
        "z-buffer",
        "Catmull, A Subdivision Algorithm for Computer Display of Curved Surfaces, 1974",
    ),
    #[cfg(feature = "exact")]
    row::<SBuffer>(
        Method::SBuffer,
        "s-buffer",
        "Boreskov, Hierarchical s-buffer for scenes of high complexity, section 2",
    ),
    #[cfg(feature = "exact")]
    row::<InCells<HierarchicalZ>>(
        Method::HierarchicalZ,
        "hierarchical-z",
        "Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993",
    ),
    #[cfg(feature = "exact")]
    row::<InCells<HierarchicalS>>(
        Method::HierarchicalS,
        "hierarchical-s",
        "Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3",
    ),
    row::<InCells<Masked>>(
        Method::Masked,
        "masked",
        "Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016",
    ),
    #[cfg(feature = "strict")]
    row::<Svbsp>(
        Method::Svbsp,
        "svbsp",
        "Bittner, Havran, Slavík, Hierarchical Visibility Culling with Occlusion Trees, CGI 1998",
    ),
    #[cfg(feature = "strict")]
    row::<Mobsp>(
        Method::Mobsp,
        "mobsp",
        "Better occlusion culling in modern computer games (in Ukrainian, author unknown)",
    ),
    #[cfg(feature = "strict")]
    row::<Pvs>(
        Method::Pvs,
        "pvs",
        "Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991",
    ),
    #[cfg(feature = "classic")]
    row::<Cell>(Method::Cell, "cell", "Boreskov, Using portals"),
    #[cfg(feature = "terrain")]
    row::<FloatingHorizon>(
        Method::FloatingHorizon,
        "floating-horizon",
        "Anderson, Hidden Line Elimination in Projected Grid Surfaces, ACM TOG 1982",
    ),
];
