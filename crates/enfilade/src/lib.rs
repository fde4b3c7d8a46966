//! Enfilade says what can be seen.
//!
//! ```
//! use enfilade::*;
//!
//! /// Things of one shape, and a doorway two metres high; the first opening of a room is `OpeningId(0)`.
//! fn room(things: &[(&str, [f32; 3])], doorway: ConvexPolygon) -> Result<Content, Box<dyn std::error::Error>> {
//!     let mut room = ContentBuilder::new([Material::opaque([0.8, 0.3, 0.2])]);
//!     let sail = Mesh::triangles(&[[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 1.2, 0.0]], &[0, 1, 2], MaterialId(0))?;
//!     let sail = room.mesh(sail);
//!     for (name, place) in things {
//!         room.item(name, sail, Transform::translation(*place));
//!     }
//!     room.opening("doorway", doorway);
//!     Ok(room.build()?)
//! }
//!
//! let mut scene = SceneBuilder::new();
//! let out = ConvexPolygon::rectangle([-0.5, 0.0, -3.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
//! let hall = room(&[("vase", [1.0, 0.0, -2.0]), ("bust", [0.0, 0.0, 2.0])], out.clone())?;
//! let hall = scene.add("hall", hall, Method::HierarchicalZ);
//! let study = room(&[("lamp", [0.0, 0.0, -6.0]), ("clock", [3.0, 0.0, -4.0])], out.flipped())?;
//! let study = scene.add("study", study, Method::HierarchicalZ);
//! scene.door((hall, OpeningId(0)), (study, OpeningId(0)));
//! let scene = scene.build()?;
//!
//! let mut viewer = Viewer::new();
//! let set = viewer.look(&scene, &View::new([0.0, 1.0, 0.0], [0.0, 1.0, -1.0], [640, 360]));
//! let mut seen = Vec::new();
//! for item in set.items() {
//!     let fragment = set.passage(item.passage).fragment;
//!     seen.push((scene.fragment_name(fragment), scene.content(fragment).unwrap().name(item.item)));
//! }
//! // The bust is behind the eye, the clock beside the doorway.
//! assert_eq!(seen, [("hall", "vase"), ("study", "lamp")]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Scene`] is made of fragments that portals join; each fragment is seen by the [`Method`] that suits it. A
//! [`Viewer`] looks at a scene through a [`View`] and answers with a [`VisibleSet`]: the ways from the eye into
//! fragments, and what may be seen through each. [`Viewer::draw`] paints the same on a [`Canvas`].
//!
//! A method is an [order](order) times a [cover](cover), and states its [`Contract`]; the feature `laws` adds the
//! reference that any method, also one of your own, is held against. Looking cannot fail and opens no file; what does
//! not fit together is refused when a mesh, a content or a scene is built.
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
