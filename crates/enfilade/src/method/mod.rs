//! Visibility methods: each combines an order with a cover. Only this module depends on both.

mod count;
mod culled;
mod editable;
mod enlarged;
mod found;
mod gathered;
mod in_cells;
mod large_terrain;
mod ordered;
mod paired;
mod shares;
mod strips;
mod unsuited;

pub use culled::Culled;
pub use editable::EditStats;
pub(crate) use editable::EditableSector;
pub use ordered::Ordered;
pub use paired::Paired;
pub use unsuited::{FaceName, NotBaked, NotConvex, TerrainUnusable, TooLarge, Unsuited};

use crate::canvas::CoverShape;
use crate::cover::{
    ByBox, ByFaces, CoarseCoverage, Cover, DepthBuffer, DepthPyramid, Horizon, Mask, MaskedDepth,
    OcclusionTree, PaintersBuffer, SpanBuffer,
};
use crate::geometry::Geometry;
use crate::order::{
    BakedCellsOrder, Bsp, BvhOrder, ConvexCell, DepthSort, FarToNear, KdTreeOrder, Mean, Min, NearToFar,
    OctreeOrder, Order, TerrainRows, Unordered,
};
use crate::sector::{Contract, Sector};
use crate::view::View;
use in_cells::CoarseAdapter;
use std::fmt;
use std::sync::Arc;

/// Painter's algorithm: faces drawn back to front, sorted by their nearest corner.
///
/// No buffer but the picture, no depth test. Approximate: wrong where a face extends nearer than another that occludes
/// it (`@tetrahedron`, `@overlap`), for cyclic overlaps (`@cycle`) and for intersecting faces (`@crossing-triangles`).
///
/// Source: *Painter's algorithm and binary space partitioning* (a thesis in Russian, author unknown), section 1.1.
#[doc(alias = "depth-sort algorithm")]
#[doc(alias = "depth sort")]
pub type PainterMin = Paired<DepthSort<Min>, PaintersBuffer>;

/// Painter's algorithm: faces drawn back to front, sorted by the mean distance of their corners.
///
/// Correct more often than [`PainterMin`], but wrong for long faces next to small ones (`@overlap` from its second
/// camera), for cyclic overlaps (`@cycle`) and for intersecting faces (`@crossing-triangles`).
///
/// Source: *Painter's algorithm and binary space partitioning* (a thesis in Russian, author unknown), section 1.1.
pub type PainterMean = Paired<DepthSort<Mean>, PaintersBuffer>;

/// BSP tree back to front: every face is drawn, farther ones are overdrawn. Exact.
///
/// Source: Fuchs, Kedem, Naylor, On Visible Surface Generation by A Priori Tree Structures, SIGGRAPH 1980;
/// *Painter's algorithm and binary space partitioning* (a thesis in Russian, author unknown), section 1.2.
#[doc(alias = "binary space partitioning")]
pub type BspPainter = Paired<Bsp<FarToNear>, PaintersBuffer>;

/// BSP tree front to back with a coverage mask: every sample is drawn once, without overdraw. Exact.
///
/// Source: Boreskov, Using portals.
#[doc(alias = "binary space partitioning")]
#[doc(alias = "coverage mask")]
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
/// [`Viewer::set_occluders`](crate::Viewer::set_occluders) asks for some.
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
/// (blended, alpha-tested, or an item with `set_occluder(false)`) may be anywhere. An edit that makes the sector
/// non-convex returns an error.
#[doc(alias = "convex sector")]
#[doc(alias = "convex room")]
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
    PainterMin,
    /// Painter's algorithm by mean distance: [`PainterMean`](crate::PainterMean). Approximate.
    PainterMean,
    /// BSP tree, back to front: [`BspPainter`](crate::BspPainter). Exact.
    Bsp,
    /// BSP tree, front to back with a coverage mask: [`BspFront`](crate::BspFront). Exact.
    BspFront,
    /// Depth buffer: [`ZBuffer`](crate::ZBuffer). Exact.
    ZBuffer,
    /// Scanline span buffer: [`SBuffer`](crate::SBuffer). Exact.
    SBuffer,
    /// Octree and Hi-Z depth pyramid: [`HierarchicalZ`](crate::HierarchicalZ). Exact.
    HierarchicalZ,
    /// Octree and scanline spans: [`HierarchicalS`](crate::HierarchicalS). Exact.
    HierarchicalS,
    /// Masked occlusion culling: [`Masked`](crate::Masked). Conservative.
    Masked,
    /// Occlusion tree of shadow volumes, tested by faces: [`Svbsp`](crate::Svbsp). Strict.
    Svbsp,
    /// Occlusion tree of shadow volumes, tested by boxes: [`Mobsp`](crate::Mobsp). Strict.
    Mobsp,
    /// Baked potentially visible sets: [`Pvs`](crate::Pvs). Strict; requires a baked PVS.
    Pvs,
    /// Convex room without depth test: [`Cell`](crate::Cell). Exact; requires convex geometry.
    Cell,
    /// Floating horizon over terrain: [`FloatingHorizon`](crate::FloatingHorizon). Exact; requires a height field.
    FloatingHorizon,
}

/// Requirement of a [`Method`] on the geometry of a sector.
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

impl Method {
    /// All methods. Not every geometry meets the [requirement](Method::requires) of each; test with [`Method::suits`]. A
    /// method that accepted any geometry instead (geometry without baked cells as one large cell, for example) would
    /// only look as if it worked.
    pub const ALL: [Method; 14] = [
        Method::PainterMin,
        Method::PainterMean,
        Method::Bsp,
        Method::BspFront,
        Method::ZBuffer,
        Method::SBuffer,
        Method::HierarchicalZ,
        Method::HierarchicalS,
        Method::Masked,
        Method::Svbsp,
        Method::Mobsp,
        Method::Pvs,
        Method::Cell,
        Method::FloatingHorizon,
    ];

    /// Default memory limit per sector for what its method builds, in bytes: 1 GB.
    pub const DEFAULT_LIMIT: u64 = 1_000_000_000;

    /// Returns the name used on the command line and in files, such as `hierarchical-z`.
    pub fn name(self) -> &'static str {
        match self {
            Method::PainterMin => "painter-min",
            Method::PainterMean => "painter-mean",
            Method::Bsp => "bsp",
            Method::BspFront => "bsp-front",
            Method::ZBuffer => "z-buffer",
            Method::SBuffer => "s-buffer",
            Method::HierarchicalZ => "hierarchical-z",
            Method::HierarchicalS => "hierarchical-s",
            Method::Masked => "masked",
            Method::Svbsp => "svbsp",
            Method::Mobsp => "mobsp",
            Method::Pvs => "pvs",
            Method::Cell => "cell",
            Method::FloatingHorizon => "floating-horizon",
        }
    }

    /// Returns the method with the given name; `None` if there is none.
    pub fn by_name(name: &str) -> Option<Method> {
        Method::ALL.into_iter().find(|method| method.name() == name)
    }

    /// Returns the guarantee on the visible set.
    pub fn contract(self) -> Contract {
        match self {
            Method::PainterMin | Method::PainterMean => Contract::Approximate,
            Method::Bsp
            | Method::BspFront
            | Method::Cell
            | Method::FloatingHorizon
            | Method::ZBuffer
            | Method::SBuffer
            | Method::HierarchicalZ
            | Method::HierarchicalS => Contract::Exact,
            Method::Masked => Contract::Conservative,
            Method::Svbsp | Method::Mobsp | Method::Pvs => Contract::Strict,
        }
    }

    /// Returns `true` if the cover can have another resolution than the screen
    /// ([`Viewer::set_cover_size`](crate::Viewer::set_cover_size)). The method is conservative then.
    pub fn takes_cover_size(self) -> bool {
        matches!(
            self,
            Method::HierarchicalZ | Method::HierarchicalS | Method::Masked
        )
    }

    /// Returns the guarantee on the visible set if a viewer uses a cover of another resolution than the screen.
    pub fn contract_in_cells(self) -> Contract {
        if self.takes_cover_size() {
            Contract::Conservative
        } else {
            self.contract()
        }
    }

    /// Returns what the geometry must have for this method; `None` if it takes any geometry.
    pub fn requires(self) -> Option<Requirement> {
        match self {
            Method::Pvs => Some(Requirement::BakedCells),
            Method::Cell => Some(Requirement::Convex),
            Method::FloatingHorizon => Some(Requirement::Terrain),
            _ => None,
        }
    }

    /// Returns `true` if building sorts all faces into a BSP tree. That splits some, and takes long for many faces.
    pub(crate) fn builds_bsp(self) -> bool {
        matches!(self, Method::Bsp | Method::BspFront)
    }

    /// Returns `true` if a geometry meets the [requirement](Method::requires) of the method. For [`Method::Cell`] and
    /// [`Method::FloatingHorizon`] this costs as much as building it.
    pub fn suits(self, geometry: &Geometry) -> bool {
        match self {
            Method::Pvs => geometry.cells().is_some(),
            Method::Cell => ConvexCell::build(geometry, u64::MAX).is_ok(),
            Method::FloatingHorizon => TerrainRows::build(geometry, u64::MAX).is_ok(),
            _ => true,
        }
    }

    /// Builds the method for a geometry.
    ///
    /// # Errors
    /// Returns [`Unsuited::TooLarge`] if more than `limit_bytes` are needed; [`Unsuited::NotBaked`],
    /// [`Unsuited::NotConvex`] or [`Unsuited::TerrainUnusable`] if the geometry does not meet the
    /// [requirement](Method::requires).
    pub fn build(self, geometry: Arc<Geometry>, limit_bytes: u64) -> Result<Arc<dyn Sector>, Unsuited> {
        Ok(self.build_editable(geometry, limit_bytes)?)
    }

    pub(crate) fn build_editable(
        self,
        geometry: Arc<Geometry>,
        limit_bytes: u64,
    ) -> Result<Arc<dyn EditableSector>, Unsuited> {
        Ok(match self {
            Method::PainterMin => Arc::new(PainterMin::build(self, geometry, limit_bytes)?),
            Method::PainterMean => Arc::new(PainterMean::build(self, geometry, limit_bytes)?),
            Method::Bsp => Arc::new(BspPainter::build(self, geometry, limit_bytes)?),
            Method::BspFront => Arc::new(BspFront::build(self, geometry, limit_bytes)?),
            Method::ZBuffer => Arc::new(ZBuffer::build(self, geometry, limit_bytes)?),
            Method::SBuffer => Arc::new(SBuffer::build(self, geometry, limit_bytes)?),
            Method::HierarchicalZ => {
                Arc::new(CoarseAdapter(HierarchicalZ::build(self, geometry, limit_bytes)?))
            }
            Method::HierarchicalS => {
                Arc::new(CoarseAdapter(HierarchicalS::build(self, geometry, limit_bytes)?))
            }
            Method::Masked => Arc::new(CoarseAdapter(Masked::build(self, geometry, limit_bytes)?)),
            Method::Svbsp => Arc::new(Svbsp::build(self, geometry, limit_bytes)?),
            Method::Mobsp => Arc::new(Mobsp::build(self, geometry, limit_bytes)?),
            Method::Pvs => Arc::new(Pvs::build(self, geometry, limit_bytes)?),
            Method::Cell => Arc::new(Cell::build(self, geometry, limit_bytes)?),
            Method::FloatingHorizon => Arc::new(FloatingHorizon::build(self, geometry, limit_bytes)?),
        })
    }

    /// Returns the memory of its screen buffers, in bytes, for a viewport of `size` [width, height] in pixels;
    /// `cover_size` as in [`Viewer::set_cover_size`](crate::Viewer::set_cover_size).
    pub fn screen_bytes(self, size: [u32; 2], cover_size: Option<[u32; 2]>) -> u64 {
        match cover_size.filter(|&cells| self.takes_cover_size() && cells != size) {
            // At another cover size, the picture is drawn with a z-buffer.
            Some(cells) => {
                self.cover_bytes(cells) + CoarseCoverage::needs_bytes(cells) + DepthBuffer::needs_bytes(size)
            }
            None => self.cover_bytes(size),
        }
    }

    fn cover_bytes(self, size: [u32; 2]) -> u64 {
        match self {
            Method::BspFront => Mask::needs_bytes(size),
            Method::PainterMin | Method::PainterMean | Method::Bsp | Method::Cell => {
                PaintersBuffer::needs_bytes(size)
            }
            Method::ZBuffer | Method::Pvs => DepthBuffer::needs_bytes(size),
            Method::SBuffer | Method::HierarchicalS => SpanBuffer::needs_bytes(size),
            Method::HierarchicalZ => DepthPyramid::needs_bytes(size),
            Method::FloatingHorizon => Horizon::needs_bytes(size),
            Method::Masked => MaskedDepth::needs_bytes(size),
            Method::Svbsp => OcclusionTree::<ByFaces>::needs_bytes(size),
            Method::Mobsp => OcclusionTree::<ByBox>::needs_bytes(size),
        }
    }
}

impl Method {
    /// Returns how the cover divides the screen, for visualization; `None` if there is nothing to show.
    pub fn cover_shape(self) -> Option<CoverShape> {
        match self {
            Method::BspFront => Mask::SHAPE,
            Method::PainterMin | Method::PainterMean | Method::Bsp | Method::Cell => PaintersBuffer::SHAPE,
            Method::ZBuffer | Method::Pvs => DepthBuffer::SHAPE,
            Method::SBuffer | Method::HierarchicalS => SpanBuffer::SHAPE,
            Method::HierarchicalZ => DepthPyramid::SHAPE,
            Method::FloatingHorizon => Horizon::SHAPE,
            Method::Masked => MaskedDepth::SHAPE,
            Method::Svbsp => OcclusionTree::<ByFaces>::SHAPE,
            Method::Mobsp => OcclusionTree::<ByBox>::SHAPE,
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Method {
    /// Checks that the screen buffers for a view fit in `limit_bytes`.
    ///
    /// # Errors
    /// Returns [`TooLarge`] if they do not.
    pub fn check_screen(
        self,
        view: &View,
        cover_size: Option<[u32; 2]>,
        limit_bytes: u64,
    ) -> Result<(), TooLarge> {
        let needs_bytes = self.screen_bytes(view.size, cover_size);
        if needs_bytes > limit_bytes {
            return Err(TooLarge::new(self, needs_bytes, limit_bytes));
        }
        Ok(())
    }
}
