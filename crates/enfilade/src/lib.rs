//! CPU visibility: frustum, portal and occlusion culling that never culls a visible object.
//!
//! ```
//! use enfilade::*;
//!
//! let mut room = GeometryBuilder::new([Material::opaque([0.8, 0.6, 0.4])]);
//! let cube = room.mesh(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0))?);
//! room.item("crate", cube, Transform::translation([0.0, 0.0, -4.0]));
//! room.item("lamp behind the crate", cube, Transform::translation([0.0, 0.0, -9.0]));
//! let scene = Scene::single(room.build()?, Method::HierarchicalZ)?;
//!
//! let mut viewer = Viewer::new();
//! let set = viewer.look(&scene, &View::new([0.0; 3], [0.0, 0.0, -1.0], [1280, 720])?);
//! assert_eq!(set.names(&scene).collect::<Vec<_>>(), ["crate"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Scene`] consists of sectors joined by portals; each sector has the [`Method`] that suits it. A [`Viewer`] looks at a
//! scene through a [`View`] and returns a [`VisibleSet`]: the passages from the eye into sectors, and the items visible
//! through each. [`Viewer::draw`] also emits the picture to a [`Canvas`]. Two rooms and a door:
//!
//! ```
//! # use enfilade::*;
//! let [mut hall, mut study] = [0, 1].map(|_| GeometryBuilder::new([Material::opaque([0.6; 3])]));
//! let cube = Mesh::cuboid([-0.2, 0.0, -0.2], [0.2, 1.2, 0.2], MaterialId(0))?;
//! let [in_hall, in_study] = [hall.mesh(cube.clone()), study.mesh(cube)];
//! hall.item("vase", in_hall, Transform::translation([1.0, 0.0, -2.0]));
//! study.item("lamp", in_study, Transform::translation([0.0, 0.0, -6.0]));
//! study.item("clock", in_study, Transform::translation([3.0, 0.0, -4.0]));
//! // Counter-clockwise seen from the hall; the same outline flipped is the door seen from the study.
//! let doorway = ConvexPolygon::rectangle([-0.5, 0.0, -3.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
//! let [out, back] = [hall.opening("out", doorway.clone()), study.opening("back", doorway.flipped())];
//!
//! let mut scene = SceneBuilder::new();
//! let hall = scene.add("hall", hall.build()?, Method::HierarchicalZ);
//! let study = scene.add("study", study.build()?, Method::Masked);
//! scene.door((hall, out), (study, back));
//! let scene = scene.build()?;
//!
//! let mut viewer = Viewer::new();
//! let set = viewer.look(&scene, &View::new([0.0, 1.0, 0.0], [0.0, 1.0, -1.0], [640, 360])?);
//! // The clock is beside the doorway.
//! assert_eq!(set.names(&scene).collect::<Vec<_>>(), ["vase", "lamp"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! An engine that keeps its own scene can use the [`OcclusionBuffer`] alone: it draws occluders and tests boxes.
//!
//! A method is an [order] (which nodes and faces come next) times a [cover] (what is already hidden). Each
//! states its [`Contract`]; the feature `laws` adds the reference that every method can be tested
//! against. Looking cannot fail and does no I/O; inconsistent input is rejected when a mesh, a geometry or a scene is
//! built. Units are scene units, radians and pixels; space is right-handed, faces are counter-clockwise seen from their
//! front.
//!
//! # Glossary
//!
//! | here | elsewhere |
//! |---|---|
//! | [sector](Sector) | cell, room, zone |
//! | [item](Item) | instance, object, renderer, entity |
//! | [geometry](Geometry) | a sector's meshes, items, materials, openings |
//! | [opening](Opening) · [portal](Portal) | portal polygon · portal link; a door is two portals, a mirror one |
//! | [passage](Passage) | portal path, clip view |
//! | [aperture](Aperture) | clip region, portal window, scissor |
//! | [look](Viewer::look) | cull, visibility query, determine visibility |
//! | [visible set](VisibleSet) | cull result, draw list, PVS of one view |
//! | [order] · [cover] | traversal order · occlusion buffer |
//! | [canvas](Canvas) | render target |
//! | [cluster](Cluster) | meshlet |
//! | reversed depth (`rev_depth`) | 1/w in perspective views: larger is nearer |
//! | [contract](Contract) | guarantee: exact, strict, conservative or approximate |
//! | reference, laws | independent ray-cast oracle, conformance suite |
//!
//! # Features
//!
//! * `rayon` (default): builds, and looks of viewers that may, run on the current rayon pool.
//! * `simd` (default): kernels for all SIMD levels of the architecture, selected at run time. Results do not depend on it.
//! * `exact`, `strict` (default): all methods with these contracts but those below; `masked` is always there.
//! * `classic`: the painter's algorithm, BSP trees and convex cells.
//! * `terrain`: height fields, also larger than memory, and the floating horizon.
//! * `laws`: the reference and the conformance checks.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

pub mod cover;
pub mod geom;
pub mod order;

mod blend;
#[cfg(test)]
mod chance;
mod choose;
mod contract;
mod counts;
mod error_codes;
mod faces;
mod geometry;
mod ids;
#[cfg(feature = "terrain")]
mod large_terrain;
#[cfg(feature = "laws")]
pub mod laws;
mod look;
mod look_many;
mod mesh;
mod method;
mod occluders;
mod query;
mod random;
mod ranked;
mod raster;
mod scene;
mod sector;
mod shadow_casters;
mod simd;
mod starts;
mod stats;
#[cfg(feature = "terrain")]
mod terrain;
mod threads;
mod traversal;
mod unsuited;
mod view;

pub use choose::{ChoiceGoal, ChoiceOptions, Cost, MethodChoice, SkipReason, Trial, choose_methods};
pub use contract::Contract;
pub use cover::{OccluderMesh, OccluderMeshError, OcclusionBuffer};
pub use error_codes::ERROR_CODES;
pub use faces::{FaceSource, Faces};
pub use geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Transform};
#[cfg(feature = "terrain")]
pub use geometry::Terrain;
pub use geometry::{
    Alpha, BakedCells, BakedCellsError, CellNode, CellSide, CellTree, Filter, Geometry, GeometryBuilder,
    GeometryError, Item, ItemLabel, ItemOptions, Material, Minify, MovedItem, Opening, Owner, Owners,
    Texture, TextureError, Wrap,
};
pub use ids::{
    CellId, ItemId, ItemIndex, LightId, MaterialId, MeshId, NestedId, OpeningId, PassageId, PortalId,
    SectorId, TextureId,
};
#[cfg(feature = "terrain")]
pub use large_terrain::{HeightBytes, HeightFormat, Heights, LargeTerrain};
pub use mesh::{Attributes, Cluster, Indices, Mesh, MeshDataError, MeshError, Part, Vertices};
#[cfg(feature = "terrain")]
pub use method::FloatingHorizon;
#[cfg(feature = "classic")]
pub use method::{BspFront, BspPainter, Cell, PainterMean, PainterMin};
pub use method::{
    Culled, EditStats, HierarchicalS, HierarchicalZ, Masked, Method, Mobsp, Ordered, Paired, Pvs, SBuffer,
    Svbsp, UnsuitedMethod, ZBuffer,
};
pub use occluders::{
    Occluder, OccluderMeasure, OccluderRoom, OccluderSelection, OccluderSet, OccluderSummary,
    SelectedOccluder,
};
pub use query::{
    BodyInSector, BoxVisibility, LightReach, Location, MoveResult, NearItem, NearItems, NearestItem, RayCast,
    RayEnd, SightLine, Survey, SurveyOptions, SurveyView, survey, survey_hard, survey_in, survey_with,
};
pub use scene::{
    Edit, EditError, ErrorSubject, Light, LightShape, Portal, PortalEnd, Scene, SceneBuilder, SceneError,
};
pub use sector::{BuildStats, Hit, Ray, Requirement, Sector, Surface};
pub use shadow_casters::{LightView, ShadowCasters};
pub use simd::{SimdLevelError, simd_level, simd_levels, use_simd_level};
pub use stats::{SpanStats, Stats};
#[cfg(feature = "terrain")]
pub use terrain::{Diagonal, HeightField, HeightFieldError};
pub use unsuited::{FaceName, NotConvex, Unsuited};
pub use view::aperture::{Aperture, Rect, Rows};
pub use view::canvas::{Canvas, CoverShape, CoverSpan, HiddenBy, Span};
pub use view::collector::Collector;
pub use view::draw_runs::DrawRun;
pub use view::memory::Memory;
pub use view::options::{Limits, Tightness, ViewerOptions};
pub use view::passage::Passage;
pub use view::region::{Region, Visibility};
#[cfg(feature = "steps")]
#[cfg_attr(docsrs, doc(cfg(feature = "steps")))]
pub use view::step_log::LookStep;
pub use view::viewer::Viewer;
pub use view::viewers::Viewers;
pub use view::visible::{VisibleItem, VisibleSet};
pub use view::visible_keys::VisibleKeys;
pub use view::{Camera, ClipDepth, View, ViewError, Viewport};
