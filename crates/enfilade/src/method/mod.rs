//! Methods: an order times a cover. Only this module knows both.

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
use in_cells::InCells;
use std::fmt;
use std::sync::Arc;

/// Painter's algorithm, sorted by each face's nearest corner. Thesis Painter's Algorithm and Binary Space Partitioning,
/// 1.1.
///
/// Wrong where a face reaches nearer than another that hides it (`@tetrahedron`, `@overlap`), in cycles (`@cycle`) and
/// where faces cross (`@crossing-triangles`).
pub type PainterMin = Paired<DepthSort<Min>, PaintersBuffer>;

/// Painter's algorithm, sorted by each face's mean distance. As [`PainterMin`].
///
/// Right more often than by the nearest corner, but not on long faces beside small ones (`@overlap` from its second
/// camera), in cycles (`@cycle`) and where faces cross (`@crossing-triangles`).
pub type PainterMean = Paired<DepthSort<Mean>, PaintersBuffer>;

/// BSP tree, far to near: every face is painted. Fuchs, Kedem, Naylor, SIGGRAPH 1980; thesis Painter's Algorithm and
/// Binary Space Partitioning, 1.2.
pub type BspPainter = Paired<Bsp<FarToNear>, PaintersBuffer>;

/// BSP tree, near to far: every sample is painted once. Boreskov, Using portals.
pub type BspFront = Paired<Bsp<NearToFar>, Mask>;

/// z-buffer: any order, and at each sample the nearest face. Catmull 1974; Boreskov, Using portals.
pub type ZBuffer = Paired<Unordered, DepthBuffer>;

/// s-buffer: any order, and for each row the spans that are seen. Boreskov, Hierarchical s-buffer for scenes of high
/// complexity, section 2.
pub type SBuffer = Paired<Unordered, SpanBuffer>;

/// Hierarchical z-buffer: an octree near to far, and a pyramid of farthest depths that hides whole nodes. Greene, Kass,
/// Miller, SIGGRAPH 1993.
pub type HierarchicalZ = Paired<OctreeOrder, DepthPyramid>;

/// Hierarchical s-buffer: an octree near to far, and spans that hide whole nodes. Boreskov, Hierarchical s-buffer for
/// scenes of high complexity, section 3.
pub type HierarchicalS = Paired<OctreeOrder, SpanBuffer>;

/// Masked occlusion culling: a BVH near to far, held against a buffer of two reversed depths for each 8×4 samples that a few
/// chosen occluders and then the faces of what is found go into. Hasselgren, Andersson, Akenine-Möller, HPG 2016.
pub type Masked = Culled<BvhOrder, MaskedDepth>;

/// Occlusion tree: what chosen occluders hide as one tree of planes, and the faces of a kd-tree's boxes held against it.
/// Bittner, Havran, Slavík, CGI 1998.
pub type Svbsp = Culled<KdTreeOrder, OcclusionTree<ByFaces>>;

/// As [`Svbsp`], but boxes are only held against the planes: cheaper, and sees more. Boreskov, Better occlusion culling
/// in modern computer games.
pub type Mobsp = Culled<KdTreeOrder, OcclusionTree<ByBox>>;

/// Potentially visible sets: a geometry's cells say what may be seen from where sight begins, drawn by a z-buffer. Only for
/// geometries that have cells ([`GeometryBuilder::cells`](crate::GeometryBuilder::cells)). Teller, Séquin, SIGGRAPH 1991;
/// Boreskov, Using portals.
///
/// What moves is followed, at the cost of sorting its faces into cells. What hides must stay: rows that were computed from a
/// wall go on hiding what is behind it when it has gone.
pub type Pvs = Ordered<BakedCellsOrder>;

/// Convex cell: faces as they come, painted over each other. Only for geometries in which every face has all others on one
/// side, as in a box of a room: there, no face seen from that side hides another. Boreskov, Using portals.
///
/// Takes faces, openings included, that bound a convex space, seen from inside or outside; what hides nothing (glass,
/// cut-outs, items that never hide) may stand anywhere. An edit that leaves it convex no more is refused.
pub type Cell = Paired<ConvexCell, PaintersBuffer>;

/// Floating horizon: terrain near to far, and what stands on it, under a horizon that rises. Only for geometries that have a
/// height field ([`GeometryBuilder::terrain`](crate::GeometryBuilder::terrain)). Anderson, ACM TOG 1982; Boreskov, Using
/// portals.
///
/// What else is in the geometry comes between its blocks, by how near it is, and may hide some of it. An edit that changes the ground is refused.
pub type FloatingHorizon = Paired<TerrainRows, Horizon>;

/// How a sector is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Method {
    /// See [`PainterMin`](crate::PainterMin).
    PainterMin,
    /// See [`PainterMean`](crate::PainterMean).
    PainterMean,
    /// See [`BspPainter`](crate::BspPainter).
    Bsp,
    /// See [`BspFront`](crate::BspFront).
    BspFront,
    /// See [`ZBuffer`](crate::ZBuffer).
    ZBuffer,
    /// See [`SBuffer`](crate::SBuffer).
    SBuffer,
    /// See [`HierarchicalZ`](crate::HierarchicalZ).
    HierarchicalZ,
    /// See [`HierarchicalS`](crate::HierarchicalS).
    HierarchicalS,
    /// See [`Masked`](crate::Masked).
    Masked,
    /// See [`Svbsp`](crate::Svbsp).
    Svbsp,
    /// See [`Mobsp`](crate::Mobsp).
    Mobsp,
    /// See [`Pvs`](crate::Pvs).
    Pvs,
    /// See [`Cell`](crate::Cell).
    Cell,
    /// See [`FloatingHorizon`](crate::FloatingHorizon).
    FloatingHorizon,
}

/// What a [`Method`] needs from a sector's geometry.
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
    /// Every method there is.
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

    /// What one sector's method may build unless told otherwise, in bytes: 1 GB.
    pub const DEFAULT_LIMIT: u64 = 1_000_000_000;

    /// Its name on the command line and in files.
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

    /// The method of a name; `None` where there is none.
    pub fn by_name(name: &str) -> Option<Method> {
        Method::ALL.into_iter().find(|method| method.name() == name)
    }

    /// What it promises of its visible set.
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

    /// Can its cover have another resolution than the screen ([`Viewer::set_cover_size`](crate::Viewer::set_cover_size))?
    /// It is conservative then.
    pub fn takes_cover_size(self) -> bool {
        matches!(
            self,
            Method::HierarchicalZ | Method::HierarchicalS | Method::Masked
        )
    }

    /// What it promises where a viewer asks for covers of another resolution than the screen.
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

    /// Has a geometry what the method goes by? Of [`Method::Cell`] that costs as much as to build it.
    pub fn suits(self, geometry: &Geometry) -> bool {
        match self {
            Method::Pvs => geometry.cells().is_some(),
            Method::Cell => ConvexCell::build(geometry, u64::MAX).is_ok(),
            Method::FloatingHorizon => TerrainRows::build(geometry, u64::MAX).is_ok(),
            _ => true,
        }
    }

    /// Prepares a geometry to be seen.
    ///
    /// # Errors
    /// [`Unsuited::TooLarge`] where more than `limit_bytes` would be needed, [`Unsuited::NotBaked`], [`Unsuited::NotConvex`] and
    /// [`Unsuited::TerrainUnusable`] where the geometry has not what the method goes by.
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
            Method::HierarchicalZ => Arc::new(InCells(HierarchicalZ::build(self, geometry, limit_bytes)?)),
            Method::HierarchicalS => Arc::new(InCells(HierarchicalS::build(self, geometry, limit_bytes)?)),
            Method::Masked => Arc::new(InCells(Masked::build(self, geometry, limit_bytes)?)),
            Method::Svbsp => Arc::new(Svbsp::build(self, geometry, limit_bytes)?),
            Method::Mobsp => Arc::new(Mobsp::build(self, geometry, limit_bytes)?),
            Method::Pvs => Arc::new(Pvs::build(self, geometry, limit_bytes)?),
            Method::Cell => Arc::new(Cell::build(self, geometry, limit_bytes)?),
            Method::FloatingHorizon => Arc::new(FloatingHorizon::build(self, geometry, limit_bytes)?),
        })
    }

    /// Memory of its buffers for a screen of this size, in bytes; `cover_size` as in
    /// [`Viewer::set_cover_size`](crate::Viewer::set_cover_size).
    pub fn screen_bytes(self, size: [u32; 2], cover_size: Option<[u32; 2]>) -> u64 {
        match cover_size.filter(|&cells| self.takes_cover_size() && cells != size) {
            // Draws by a z-buffer.
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
    /// What its cover divides the screen into; `None` where that is nothing worth a picture.
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
    /// Why a screen of this size cannot be looked at within `limit_bytes`, if so.
    ///
    /// # Errors
    /// [`TooLarge`].
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
