//! Enfilade says what can be seen.
//!
//! ```
//! use enfilade::*;
//!
//! let sail = Mesh::triangles(&[[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 1.2, 0.0]], &[0, 1, 2], MaterialId(0))?;
//! let [mut hall, mut study] = [(); 2].map(|()| GeometryBuilder::new([Material::opaque([0.8, 0.3, 0.2])]));
//! let [in_hall, in_study] = [hall.mesh(sail.clone()), study.mesh(sail)];
//! hall.item("vase", in_hall, Transform::translation([1.0, 0.0, -2.0]));
//! study.item("lamp", in_study, Transform::translation([0.0, 0.0, -6.0]));
//! study.item("clock", in_study, Transform::translation([3.0, 0.0, -4.0]));
//! let doorway = ConvexPolygon::rectangle([-0.5, 0.0, -3.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
//! let [out, back] = [hall.opening("out", doorway.clone()), study.opening("back", doorway.flipped())];
//!
//! let mut scene = SceneBuilder::new();
//! let hall = scene.add("hall", hall.build()?, Method::HierarchicalZ);
//! let study = scene.add("study", study.build()?, Method::HierarchicalZ);
//! scene.door((hall, out), (study, back));
//! let scene = scene.build()?;
//!
//! let mut viewer = Viewer::new();
//! let set = viewer.look(&scene, &View::new([0.0, 1.0, 0.0], [0.0, 1.0, -1.0], [640, 360]));
//! let name = |seen: &VisibleItem| scene.geometry(set.passage(seen.passage).sector).unwrap().name(seen.item);
//! assert_eq!(set.items().len(), 2); // The clock is beside the doorway.
//! assert_eq!([name(&set.items()[0]), name(&set.items()[1])], ["vase", "lamp"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Scene`] is made of sectors that portals join; each sector is seen by the [`Method`] that suits it. A
//! [`Viewer`] looks at a scene through a [`View`] and answers with a [`VisibleSet`]: the ways from the eye into
//! sectors, and what may be seen through each. [`Viewer::draw`] paints the same on a [`Canvas`].
//!
//! A method is an [order](order) times a [cover](cover), and states its [`Contract`]; the feature `laws` adds the
//! reference that any method, also one of your own, is held against. Looking cannot fail and opens no file; what does
//! not fit together is refused when a mesh, a geometry or a scene is built.
#![forbid(unsafe_code)]

pub mod cover;
pub mod geom;
mod opening_view;
pub mod order;

mod aperture;
mod blend;
mod canvas;
#[cfg(test)]
mod chance;
mod choose;
mod collector;
mod detail;
mod entrance;
mod faces;
mod geometry;
#[cfg(feature = "laws")]
pub mod laws;
mod memory;
mod mesh;
mod method;
mod occluders;
mod passage;
mod query;
mod region;
mod scene;
mod sector;
mod simd;
mod stats;
mod terrain;
mod threads;
mod view;
mod viewer;
mod visible;

pub use aperture::{Aperture, Rect, Rows};
pub use canvas::{Canvas, CoverShape, CoverSpan, HiddenBy, Span};
pub use choose::{ChoiceGoal, ChoiceOptions, Cost, MethodChoice, SkipReason, Trial, choose_methods};
pub use collector::Collector;
pub use cover::OccluderMesh;
pub use detail::{
    BezierError, BezierPatch, BezierSurface, DetailError, DetailOptions, DetailSource, Details, RefineStats,
};
pub use faces::{FaceSource, Faces};
pub use geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Transform};
pub use geometry::{
    Alpha, BakedCells, BakedCellsError, CellId, CellNode, CellSide, CellTree, Filter, Geometry,
    GeometryBuilder, GeometryError, Item, ItemId, Material, MaterialId, MeshId, Minify, MovedItem, Opening,
    OpeningId, Owner, Owners, Texture, TextureError, TextureId, Wrap,
};
pub use memory::Memory;
pub use mesh::{Attributes, Cluster, Mesh, MeshError, Part};
pub use method::{
    BspFront, BspPainter, Cell, Culled, EditStats, FaceName, FloatingHorizon, HierarchicalS, HierarchicalZ,
    Masked, Method, Mobsp, NotBaked, NotConvex, Ordered, PainterMean, PainterMin, Paired, Pvs, Requirement,
    SBuffer, Svbsp, TerrainUnusable, TooLarge, Unsuited, ZBuffer,
};
pub use occluders::{
    Occluder, OccluderMeasure, OccluderRoom, OccluderSelection, OccluderSet, OccluderSummary,
    SelectedOccluder,
};
pub use passage::{Passage, PassageId};
pub use query::{
    BodyInSector, BoxError, BoxVisibility, Capsule, LightReach, Location, MoveResult, NearItem, NearItems,
    NearestItem, PairChanges, Pairs, RayCast, RayEnd, SightLine, SlideResult, Survey, SurveyView, survey,
    survey_hard, survey_in,
};
pub use region::{Region, Visibility};
pub use scene::{
    Edit, EditError, ErrorSubject, Light, LightId, LightShape, NestedId, Portal, PortalEnd, PortalId, Scene,
    SceneBuilder, SceneError, SectorId,
};
pub use sector::{BuildStats, Contract, Hit, Ray, Sector, Surface};
pub use simd::{SimdLevelError, simd_level, simd_levels, use_simd_level};
pub use stats::{SpanStats, Stats};
pub use terrain::{
    Diagonal, HeightBytes, HeightField, HeightFieldError, HeightFormat, Heights, LargeTerrain,
};
pub use view::{View, ViewError};
pub use viewer::{Limits, Viewer};
pub use visible::{VisibleItem, VisibleSet};
