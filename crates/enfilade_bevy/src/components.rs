//! What an app says about its entities.

use bevy_ecs::prelude::*;
use bevy_math::Vec2;
use bevy_reflect::prelude::*;
use enfilade::{BakedCells, Method};
use std::sync::Arc;

/// An entity whose [`Mesh3d`](bevy_mesh::Mesh3d) hides what is behind it.
///
/// With the feature `pbr`, opaque entities with a `StandardMaterial` are occluders without it. Give it to entities with
/// materials of your own, if all that is drawn of them is opaque and where the mesh is: no discarded fragments, no
/// moved vertices.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
#[reflect(Component, Default)]
pub enum Occluder {
    /// Front faces hide. For materials that cull back faces, as `StandardMaterial` does.
    #[default]
    OneSided,
    /// Both sides of faces are drawn, and hide.
    TwoSided,
}

/// Another mesh that hides in the place of an entity's own, with the entity's transform: fewer triangles, and a closed wall
/// where the drawn one is of a thousand pieces. It must be inside what is drawn.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct OccluderProxy(pub bevy_asset::Handle<bevy_mesh::Mesh>);

/// An entity that hides nothing, whatever its material. It is culled as others.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct NotOccluder;

/// An entity that Enfilade neither culls nor takes as an occluder. Bevy still culls it by its frustum.
///
/// So are, without this component, those with `NoFrustumCulling`, those without `Aabb`, skinned meshes without
/// `DynamicSkinnedMeshBounds`, and meshes with morph targets.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct AlwaysVisible;

/// A camera that Enfilade does not cull for.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct NoVisibilityCulling;

/// A camera whose visible set stays that of the moment at which this was added, to be looked at from elsewhere.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct FreezeVisibility;

/// A room: its descendants with meshes are in it, and what is in it is seen from outside only through [`Portal`]s.
///
/// All other entities are outdoors, and those that reach into the box of a room are in that room too, so nothing else is
/// needed for what moves. A camera is in the room that it is a descendant of, else in the smallest whose box it is in,
/// else outdoors; if no portal leads outdoors, it is not culled for there.
///
/// What is below a room is not seen from elsewhere but through its portals, so put walls between rooms, and outer walls,
/// below no room: they reach into the rooms beside them. A room without a portal is never seen from elsewhere.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default)]
pub struct Sector;

/// An opening between two rooms, or a room and outdoors: a convex polygon in the entity's XY plane.
///
/// It joins the room that it is a descendant of, if any, with the one on the other side of the wall: rooms are looked for
/// before and behind its middle, up to half the distance from there to a corner. If the plugin cannot find both rooms, it logs a
/// warning and hides nothing until [`Portal::to`] is set or the portal is moved; if it cannot tell which is on which side, it hides
/// nothing while the portal is in view.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Portal {
    /// Corners in the entity's XY plane, in order, either way round.
    pub corners: Vec<Vec2>,
    /// Whether one sees through it. Close it while a door is shut that hides all of it.
    pub open: bool,
    /// The [`Sector`] to which it leads from the one that it is a descendant of. `None`: the one on its other side.
    pub to: Option<Entity>,
    /// Whether one sees through it from `to` as well.
    pub two_way: bool,
}

impl Portal {
    /// Creates an open portal of the width and height `size`, around the entity's origin, to be seen through from both
    /// sides.
    pub fn rectangle(size: Vec2) -> Portal {
        let half = 0.5 * size;
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        Portal::new(corners.map(|corner| half * Vec2::from(corner)))
    }

    /// Creates an open portal of these corners in the entity's XY plane, to be seen through from both sides.
    pub fn new(corners: impl IntoIterator<Item = Vec2>) -> Portal {
        Portal {
            corners: corners.into_iter().collect(),
            open: true,
            to: None,
            two_way: true,
        }
    }
}

/// A mirror: a convex polygon in the entity's XY plane that reflects the room before it, on the side of +Z.
///
/// What is seen in it becomes visible to the camera that looks at it. A camera that you render the reflection with is
/// culled like others, if its `invert_culling` is set where its matrices mirror; with rooms, make it a descendant of the room
/// that it reflects.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component)]
pub struct Mirror {
    /// Corners in the entity's XY plane, in order, either way round.
    pub corners: Vec<Vec2>,
}

impl Mirror {
    /// Creates a mirror of the width and height `size`, around the entity's origin.
    pub fn rectangle(size: Vec2) -> Mirror {
        Mirror {
            corners: Portal::rectangle(size).corners,
        }
    }
}

/// The method that culls a [`Sector`], in the place of [`EnfiladeSettings::method`](crate::EnfiladeSettings::method).
///
/// Exact methods hold for the exact picture: what GPUs round can show a pixel of what they hide. `Masked` allows for it
/// ([`ViewerOptions::growth_px`](enfilade::ViewerOptions::growth_px)), and strict ones hold at any sample.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct MethodOf(pub Method);

/// A baked PVS that culls for a camera, in the place of occlusion: a Quake map's, say, read by `enfilade_import` or by
/// another loader into [`BakedCells`].
///
/// An entity is visible if the cell of the camera may see a cell that the entity's box reaches into. Everything is visible
/// from outside all cells.
#[derive(Component, Clone, Debug)]
pub struct PvsCells {
    /// The cells, and which may see which.
    pub cells: Arc<BakedCells>,
    /// Maps Bevy's world to the space of the cells. For a Quake map this turns Y up to Z up, and metres to its units.
    pub cells_from_world: bevy_math::Affine3A,
}
