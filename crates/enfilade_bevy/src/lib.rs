//! Visibility culling for [Bevy](https://bevy.org) by [Enfilade](enfilade): on the CPU, on every platform, without a depth
//! prepass.
//!
//! ```ignore
//! App::new().add_plugins((DefaultPlugins, EnfiladePlugin::default()))
//! ```
//!
//! Nothing more is needed: what opaque meshes hide from a camera is no longer drawn for it. It never hides what can be seen.
//!
//! | to | use |
//! |---|---|
//! | let meshes with materials of your own hide others | [`Occluder`], [`OccluderProxy`] |
//! | let one hide nothing, or neither hide nor be culled | [`NotOccluder`], [`AlwaysVisible`] |
//! | see a house by rooms and doors | [`Sector`], [`Portal`], [`Mirror`], [`MethodOf`] |
//! | cull by a baked PVS, as of a Quake map | [`PvsCells`] |
//! | know what became visible or hidden | [`EntityVisibilityChanged`], [`SectorVisibilityChanged`], [`EnfiladeCameras`] |
//! | do not cull for a camera | [`NoVisibilityCulling`] |
//! | look at the visible set from outside | [`FreezeVisibility`] and the gizmos of the feature `gizmos` |
//! | ask for lines of sight and rays | [`EnfiladeScene::scene`] |
//!
//! Hidden entities are removed from `VisibleEntities` of the camera, where they can be counted. Shadows, picking and
//! `ViewVisibility` do not change. What Bevy draws by `NoCpuCulling` cannot be hidden by a CPU.
//!
//! # Features
//!
//! * `pbr` (default): opaque entities with a `StandardMaterial` are occluders.
//! * `gltf` (default): rooms and portals from the extras of glTF nodes.
//! * `gizmos`: lines for rooms, portals, the frozen frustum and the boxes of hidden entities.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod automatic;
mod cameras;
mod components;
#[cfg(feature = "gizmos")]
mod gizmos;
#[cfg(feature = "gltf")]
mod gltf;
mod meshes;
mod messages;
mod plugin;
mod portals;
mod pvs;
mod rooms;
mod scene;
mod settings;

pub use enfilade;

pub use cameras::{EnfiladeCameras, LookStats};
pub use components::{
    AlwaysVisible, FreezeVisibility, MethodOf, Mirror, NoVisibilityCulling, NotOccluder, Occluder,
    OccluderProxy, Portal, PvsCells, Sector,
};
#[cfg(feature = "gizmos")]
pub use gizmos::{EnfiladeGizmos, EnfiladeGizmosPlugin};
pub use messages::{EntityVisibilityChanged, SectorVisibilityChanged};
pub use plugin::{EnfiladePlugin, EnfiladeSystems};
pub use scene::EnfiladeScene;
pub use settings::{EnfiladeSettings, Samples};
