//! Moves bodies through [Enfilade](enfilade) scenes: a capsule that slides along walls and through portals, and the pairs
//! of moving boxes that overlap.
//!
//! ```
//! use enfilade::*;
//! use enfilade_walk::Capsule;
//!
//! let mut room = GeometryBuilder::new([Material::opaque([0.6; 3])]);
//! let block = room.mesh(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0))?);
//! room.item("pillar", block, Transform::translation([3.0, 0.0, 0.0]));
//! let scene = Scene::single(room.build()?, Method::HierarchicalZ)?;
//!
//! let start = Location { sector: SectorId(0), position: [0.0; 3] };
//! let slid = Capsule::new(0.3, 1.8).slide(&scene, start, [5.0, 0.0, 0.0]);
//! // The pillar begins at x = 2.
//! assert!((1.6..1.7).contains(&slid.location.position[0]));
//! assert_eq!(slid.touched, [[-1.0, 0.0, 0.0]]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! It is no physics engine: there is no gravity, mass or response other than sliding.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod capsule;
mod pairs;

pub use capsule::{Capsule, SlideResult};
pub use pairs::{BoxError, PairChanges, Pairs};
