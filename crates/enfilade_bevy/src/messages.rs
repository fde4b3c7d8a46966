//! What changed from one frame to the next.

use bevy_ecs::prelude::*;

/// An entity came into sight of a camera, or went out of it.
///
/// Entities that leave the frustum are hidden as well. When a camera is no longer culled for, what was hidden from it in its
/// frustum is visible. Entities that are not culled ([`AlwaysVisible`](crate::AlwaysVisible))
/// send none.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct EntityVisibilityChanged {
    /// The camera.
    pub camera: Entity,
    /// The entity.
    pub entity: Entity,
    /// Whether it is visible now.
    pub visible: bool,
}

/// A [`Sector`](crate::Sector) came into sight of a camera, or went out of it. While a camera is not culled for, none is sent.
#[derive(Message, Clone, Copy, Debug, PartialEq, Eq)]
pub struct SectorVisibilityChanged {
    /// The camera.
    pub camera: Entity,
    /// The entity with the component `Sector`.
    pub sector: Entity,
    /// Whether it is visible now.
    pub visible: bool,
}
