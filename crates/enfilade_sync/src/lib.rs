//! Mirrors the entities of any engine in an [Enfilade](enfilade) scene, and lists the visible ones by the engine's keys.
//!
//! Each frame, hand the changes of the engine's world to [`EntityMap::sync`]; after each look, hand the visible set to the
//! [`VisibleKeys`](enfilade::VisibleKeys) of that view.
//!
//! ```
//! use enfilade::*;
//! use enfilade_sync::{Changes, Entity, EntityMap, Spawn};
//!
//! let mut scene = Scene::single(GeometryBuilder::new([Material::opaque([0.6; 3])]).build()?, Method::HierarchicalZ)?;
//! let mut entities = EntityMap::new();
//! const CRATE: u64 = 7; // the engine's key of a mesh
//! entities.set_mesh(CRATE, Some(Mesh::cuboid([-1.0; 3], [1.0; 3], MaterialId(0))?.into()));
//!
//! let at = |key, z| Spawn {
//!     entity: Entity { key, sector: SectorId(0) },
//!     mesh: CRATE,
//!     bounds: Aabb { min: [-1.0; 3], max: [1.0; 3] },
//!     transform: Transform::translation([0.0, 0.0, z]),
//!     options: ItemOptions::default(),
//! };
//! let spawned = [at(100, -4.0), at(200, -9.0)];
//! entities.sync(&mut scene, &Changes { spawned: &spawned, ..Changes::default() })?;
//!
//! let (mut viewer, mut keys) = (Viewer::new(), VisibleKeys::default());
//! let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [640, 360])?;
//! let set = viewer.look(&scene, &view);
//! keys.update_with(set, entities.always_visible());
//! assert_eq!(keys.all(), [100]);
//!
//! entities.sync(&mut scene, &Changes { despawned: &[spawned[0].entity], ..Changes::default() })?;
//! let set = viewer.look(&scene, &view);
//! keys.update_with(set, entities.always_visible());
//! assert_eq!((keys.entered(), keys.left()), (&[200][..], &[100][..]));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! An entity is never lost: one without a mesh is culled by its box, and one that the scene refuses altogether is listed
//! in every view.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod entity_map;

pub use entity_map::{Changes, Entity, EntityMap, Representation, Spawn, Synced};
