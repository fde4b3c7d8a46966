//! Errors in the rooms, portals and terrain that a file's author marked. Each names the node and the remedy.

use crate::GridError;
use enfilade::MAX_COORDINATE;
use thiserror::Error;

/// An error in the rooms, portals or terrain that a file's author marked. A `node` is `node 7 "Hall-portal"`.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AuthoringError {
    /// `extras.enfilade` or one of its values has the wrong JSON type.
    #[error("{node} has {key} = {found} in its extras, but {wanted} is expected")]
    WrongType {
        /// The node.
        node: String,
        /// The key.
        key: &'static str,
        /// The value, as JSON.
        found: String,
        /// The type that is expected.
        wanted: &'static str,
    },
    /// `extras.enfilade.kind` is unknown.
    #[error("{node} has the unknown kind `{kind}`; kinds are room, portal, mirror, terrain and door")]
    UnknownKind {
        /// The node.
        node: String,
        /// The value of `extras.enfilade.kind`.
        kind: String,
    },
    /// `extras.enfilade.method` is unknown.
    #[error("{node} has the unknown method `{method}`; methods are {methods}")]
    UnknownMethod {
        /// The room.
        node: String,
        /// The value of `extras.enfilade.method`.
        method: String,
        /// Names of the known methods.
        methods: String,
    },
    /// Two rooms have the same name, so `to` is ambiguous.
    #[error("{first} and {second} are rooms with the same name; rename one of them")]
    RoomsShareName {
        /// One room.
        first: String,
        /// The other.
        second: String,
    },
    /// Two rooms overlap: items in the common space would be visible from only one of them.
    #[error(
        "{first} and {second} overlap: the point {point:?} is inside both, and neither contains the other; move one of \
         them, or merge them into one room"
    )]
    RoomsOverlap {
        /// One room.
        first: String,
        /// The other.
        second: String,
        /// A point inside both, in world space.
        point: [f32; 3],
    },
    /// A portal or mirror has no mesh.
    #[error(
        "{node} has no faces for its opening: {found}; give it a flat convex mesh, or rename it if it is no portal or mirror"
    )]
    NoMesh {
        /// The portal or mirror.
        node: String,
        /// The meshes that were found at it and below it.
        found: String,
    },
    /// A portal or mirror has too many triangles.
    #[error(
        "{node} is an opening with {triangles} triangles; simplify its mesh to a flat convex polygon with few triangles"
    )]
    TooFine {
        /// The portal or mirror.
        node: String,
        /// Its number of triangles.
        triangles: u64,
    },
    /// The faces of a portal or mirror have no area.
    #[error("{node} is an opening without area; enlarge its mesh, and check for a scale of 0")]
    NoArea {
        /// The portal or mirror.
        node: String,
    },
    /// A portal or mirror extends beyond [`MAX_COORDINATE`].
    #[error(
        "{node} is an opening that extends beyond {MAX_COORDINATE:e} units; scale the scene down or move it to the origin"
    )]
    TooFar {
        /// The portal or mirror.
        node: String,
    },
    /// A portal or mirror is not flat.
    #[error(
        "{node} is an opening that is not flat: a corner is {off} units off the plane of the others; flatten its mesh, or \
         split it into several openings"
    )]
    NotFlat {
        /// The portal or mirror.
        node: String,
        /// Maximum distance of a corner from the plane, in scene units.
        off: f64,
    },
    /// A portal or mirror has a hole, a concave outline, or overlapping faces.
    #[error(
        "{node} is an opening that is not convex: its faces cover {percent:.1} % of their convex hull; make it one convex \
         polygon (a bounding rectangle is enough), or split it into several openings"
    )]
    NotConvex {
        /// The portal or mirror.
        node: String,
        /// Total area of the faces, in percent of the area of their convex hull.
        percent: f64,
    },
    /// No room has geometry near a portal or mirror.
    #[error(
        "{node} touches no room; move it into an opening of a room, and check that the surrounding nodes are below a node \
         whose name ends in -room"
    )]
    TouchesNoRoom {
        /// The portal or mirror.
        node: String,
    },
    /// A portal has geometry on one side only, and there is no room below the other side that is open above.
    #[error(
        "{node} touches only one room, {room}: there is nothing on its other side, and no room that is open above, such as \
         a garden, extends below it. Extend the ground of such a room below it, name the room by `to`, or remove the portal"
    )]
    LeadsNowhere {
        /// The portal.
        node: String,
        /// The room.
        room: String,
    },
    /// A portal leads out of the open top of a room without a ceiling.
    #[error(
        "{node} touches only one room, {room}: it leads into the open sky above it, and since {room} has no ceiling, its \
         sky belongs to it. Close its ceiling, make the portal as large as the open top, or remove the portal"
    )]
    OwnSky {
        /// The portal.
        node: String,
        /// The room.
        room: String,
    },
    /// A portal has open sky on both sides.
    #[error(
        "{node} touches only one room, {room}: there is only the open sky above it on both sides; move it into the opening \
         between two rooms, or remove it"
    )]
    OnlySky {
        /// The portal.
        node: String,
        /// The room below it.
        room: String,
    },
    /// A portal has the same room on both sides.
    #[error(
        "{node} touches only one room, {room}; move it into the opening between two rooms, or name the other by `to`"
    )]
    TouchesOneRoom {
        /// The portal.
        node: String,
        /// The room.
        room: String,
    },
    /// A one-way portal belongs to neither of its rooms, so its direction is unknown.
    #[error(
        "{node} is one-way between {rooms}, but belongs to neither; name its target room by `to`, or parent it to the other \
         room"
    )]
    OneWayFromNowhere {
        /// The portal.
        node: String,
        /// The two rooms.
        rooms: String,
    },
    /// Two portals use the same opening of a room.
    #[error("{first} and {second} are in the same opening of {room}; remove one of them")]
    SamePlace {
        /// One portal or mirror.
        first: String,
        /// The other.
        second: String,
        /// The room.
        room: String,
    },
    /// `to` names no room.
    #[error("{node} leads to `{to}`, but there is no room with that name; rooms are {rooms}")]
    NoSuchRoom {
        /// The portal.
        node: String,
        /// The value of `to`.
        to: String,
        /// Names of the rooms.
        rooms: String,
    },
    /// `exit` names no node.
    #[error(
        "{node} has the exit `{exit}`, but no node of the scene has that name; rename one, or correct the exit"
    )]
    NoSuchExit {
        /// The portal.
        node: String,
        /// The value of `exit`.
        exit: String,
    },
    /// `exit` names several nodes.
    #[error("{node} has the exit `{exit}`, but {first} and {second} both have that name; rename one of them")]
    ManyExits {
        /// The portal.
        node: String,
        /// The value of `exit`.
        exit: String,
        /// One node.
        first: String,
        /// Another.
        second: String,
    },
    /// An exit is in no room.
    #[error(
        "{node} has the exit `{exit}`, which is in no room; parent it to a room, or name the room by `to`"
    )]
    ExitInNoRoom {
        /// The portal.
        node: String,
        /// The exit.
        exit: String,
    },
    /// A zero scale leaves a node of a teleport without an orientation.
    #[error(
        "{node} is one end of a teleport, but has a scale of 0 and so no direction; give it another scale"
    )]
    NoFrame {
        /// The portal or its exit.
        node: String,
    },
    /// A teleport whose direction is parallel to its surface.
    #[error(
        "{node} is a teleport whose direction, the node's local -Z, is parallel to its face; rotate the node (and its mesh \
         the other way) so that -Z points into the face"
    )]
    Edgewise {
        /// The portal.
        node: String,
    },
    /// A mirror or portal in a file without rooms.
    #[error(
        "{node} is an opening, but the file has no rooms; rename the node above the surrounding nodes to NAME-room"
    )]
    NoRooms {
        /// The portal or mirror.
        node: String,
    },
    /// Terrain has no mesh.
    #[error(
        "{node} is terrain without triangles: {found}; give it a grid of heights, or rename it if it is no terrain"
    )]
    TerrainWithoutMesh {
        /// The terrain.
        node: String,
        /// The meshes that were found at it and below it.
        found: String,
    },
    /// Terrain without a mesh has several nodes with meshes below it.
    #[error(
        "{node} is terrain of several meshes, those of {meshes}; join them into one grid, or rename the node"
    )]
    TerrainOfSeveral {
        /// The terrain.
        node: String,
        /// The nodes with meshes.
        meshes: String,
    },
    /// Terrain has a skin or morph targets.
    #[error(
        "{node} is terrain with {what}, but terrain must be static; apply that to the mesh before exporting, or rename the \
         node"
    )]
    TerrainMoves {
        /// The terrain.
        node: String,
        /// "a skeleton" or "morph targets".
        what: &'static str,
    },
    /// Terrain has instances.
    #[error("{node} is terrain with instances; make each a separate node, or rename the node")]
    TerrainInstanced {
        /// The terrain.
        node: String,
    },
    /// The primitives of a terrain use different materials.
    #[error(
        "{node} is terrain with several materials: primitives {} and {} of its mesh differ. Use one material, or split it \
         into one node for each",
        primitives[0], primitives[1]
    )]
    TerrainMaterials {
        /// The terrain.
        node: String,
        /// Indices of two primitives with different materials.
        primitives: [usize; 2],
    },
    /// The mesh of a terrain is not a grid of heights.
    #[error("{node} is terrain, but {why}. If it is no terrain, rename the node")]
    NoGrid {
        /// The terrain.
        node: String,
        /// The rule that the grid violates.
        why: GridError,
    },
}
