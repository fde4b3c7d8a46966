//! Enfilade says what can be seen.
#![forbid(unsafe_code)]

pub mod cover;
pub mod geom;
pub mod order;

mod aperture;
mod canvas;
mod content;
mod faces;
mod fragment;
#[cfg(feature = "laws")]
pub mod laws;
mod memory;
mod mesh;
mod method;
mod passage;
mod query;
mod region;
mod scene;
mod seen;
mod stats;
mod view;
mod viewer;
mod visible;

pub use aperture::{Aperture, Rect, Rows};
pub use canvas::{Canvas, Span};
pub use content::{
    Alpha, Content, ContentBuilder, ContentError, Item, ItemId, Material, MaterialId, MeshId, Opening,
    OpeningId, Owner,
};
pub use faces::{Faces, Of};
pub use fragment::{Fragment, Hit, Ray, Surface};
pub use geom::{Aabb, ConvexPolygon, Transform};
pub use memory::Memory;
pub use mesh::{Cluster, Mesh, MeshError, Part};
pub use method::{Contract, HierarchicalZ, Method, Paired, TooLarge, ZBuffer};
pub use passage::{Passage, PassageId};
pub use query::{Standpoint, survey};
pub use region::Region;
pub use scene::{End, FragmentId, NestedId, Portal, PortalId, Scene, SceneBuilder, SceneError};
pub use seen::Seen;
pub use stats::Stats;
pub use view::{View, ViewError};
pub use viewer::{Limits, Viewer};
pub use visible::{VisibleItem, VisibleSet};
