//! Enfilade says what can be seen.
//!
//! ```
//! use enfilade::*;
//!
//! let sail = Mesh::triangles(&[[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 1.2, 0.0]], &[0, 1, 2], MaterialId(0))?;
//! let [mut hall, mut study] = [(); 2].map(|()| ContentBuilder::new([Material::opaque([0.8, 0.3, 0.2])]));
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
//! let name = |seen: &VisibleItem| scene.content(set.passage(seen.passage).fragment).unwrap().name(seen.item);
//! assert_eq!(set.items().len(), 2); // The clock is beside the doorway.
//! assert_eq!([name(&set.items()[0]), name(&set.items()[1])], ["vase", "lamp"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Scene`] is made of fragments that portals join; each fragment is seen by the [`Method`] that suits it. A
//! [`Viewer`] looks at a scene through a [`View`] and answers with a [`VisibleSet`]: the ways from the eye into
//! fragments, and what may be seen through each. [`Viewer::draw`] paints the same on a [`Canvas`].
//!
//! A method is an [order] times a [cover], and states its [`Contract`]; the feature `laws` adds the
//! reference that any method, also one of your own, is held against. Looking cannot fail and opens no file; what does
//! not fit together is refused when a mesh, a content or a scene is built.
#![cfg_attr(docsrs, feature(doc_cfg))]
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
mod content;
mod detail;
mod entrance;
mod faces;
mod fragment;
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
mod seen;
mod simd;
mod stats;
mod terrain;
mod threads;
mod view;
mod viewer;
mod visible;

pub use aperture::{Aperture, Rect, Rows};
pub use canvas::{Canvas, CoverShape, CoverSpan, HiddenBy, Span};
pub use choose::{Aim, Cost, MethodChoice, NotTried, Terms, Trial, choose_methods};
pub use content::{
    Alpha, BakedCells, BakedCellsError, CellId, CellNode, CellSide, CellTree, Content, ContentBuilder,
    ContentError, Filter, Item, ItemId, Material, MaterialId, MeshId, Minify, Moved, Opening, OpeningId,
    Owner, Owners, Texture, TextureError, TextureId, Wrap,
};
pub use cover::OccluderMesh;
pub use detail::{
    BezierError, BezierPatch, BezierSurface, DetailError, DetailOptions, DetailSource, Details, Refined,
};
pub use faces::{Faces, Of};
pub use fragment::{Built, Contract, Fragment, Hit, Ray, Surface};
pub use geom::{Aabb, ConvexPolygon, MAX_COORDINATE, Transform};
pub use memory::Memory;
pub use mesh::{Attributes, Cluster, Mesh, MeshError, Part};
pub use method::{
    BspFront, BspPainter, Cell, Culled, Edited, FaceName, FloatingHorizon, HierarchicalS, HierarchicalZ,
    Masked, Method, Mobsp, NoTerrain, NotBaked, NotConvex, Ordered, PainterMean, PainterMin, Paired, Pvs,
    SBuffer, Svbsp, TooLarge, Unsuited, ZBuffer,
};
pub use occluders::{Choice, Chosen, Measure, Occluder, OccluderRoom, OccluderSet, OccluderSummary};
pub use passage::{Passage, PassageId};
pub use query::{
    Between, BoxError, Capsule, Cast, Met, Near, Nearby, Nearest, PairChanges, Pairs, Place, Presence,
    Reached, SightLine, Slid, Standpoint, Survey, Walked, survey, survey_hard, survey_in,
};
pub use region::{Region, Sight};
pub use scene::{
    Edit, EditError, End, FragmentId, Light, LightId, LightShape, NestedId, Portal, PortalId, Scene,
    SceneBuilder, SceneError, Way,
};
pub use seen::Seen;
pub use simd::{SimdLevelError, simd_level, simd_levels, use_simd_level};
pub use stats::{SpanStats, Stats};
pub use terrain::{
    Diagonal, HeightBytes, HeightField, HeightFieldError, HeightFormat, Heights, LargeTerrain,
};
pub use view::{View, ViewError};
pub use viewer::{Limits, Viewer};
pub use visible::{VisibleItem, VisibleSet};
