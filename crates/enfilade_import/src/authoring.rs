//! Why rooms, portals and terrain that a file's author marked do not make a scene. Each names the node and the remedy.

use crate::GridError;
use enfilade::MAX_COORDINATE;
use thiserror::Error;

/// Why rooms, portals and terrain that a file's author marked do not make a scene. A `node` is `node 7 "Hall-portal"`.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AuthoringError {
    /// `extras.enfilade` or one of its values is of another type.
    #[error("{node} has {key} = {found} in its extras; {wanted} is wanted there")]
    WrongType {
        /// The node.
        node: String,
        /// Which value.
        key: &'static str,
        /// What it is, as JSON.
        found: String,
        /// What it should be.
        wanted: &'static str,
    },
    /// A kind that is not known.
    #[error("{node} is of kind `{kind}`, which is not known; kinds are room, portal, mirror and terrain")]
    UnknownKind {
        /// The node.
        node: String,
        /// What `extras.enfilade.kind` says.
        kind: String,
    },
    /// A method that is not known.
    #[error("{node} is to be seen by the method `{method}`, which is not known; methods are {methods}")]
    UnknownMethod {
        /// The room.
        node: String,
        /// What `extras.enfilade.method` says.
        method: String,
        /// Those that there are.
        methods: String,
    },
    /// Two rooms have one name, so `to` cannot tell them apart.
    #[error("{first} and {second} are rooms of one name; rename one of them")]
    RoomsShareName {
        /// One room.
        first: String,
        /// The other.
        second: String,
    },
    /// Two rooms claim one space: what stands there would be seen in one and not in the other.
    #[error(
        "{first} and {second} overlap: the point {point:?} lies inside both, and neither stands within the other; \
         move one of them, or make them one room"
    )]
    RoomsOverlap {
        /// One room.
        first: String,
        /// The other.
        second: String,
        /// A point in both.
        point: [f32; 3],
    },
    /// A portal or mirror without a mesh.
    #[error(
        "{node} has no faces to be its opening; give it a flat convex mesh, or another name if it is none"
    )]
    NoMesh {
        /// The portal or mirror.
        node: String,
    },
    /// A portal or mirror of very many triangles.
    #[error(
        "{node} is an opening of {triangles} triangles; a flat convex polygon needs but a few, so simplify its mesh"
    )]
    TooFine {
        /// The portal or mirror.
        node: String,
        /// How many it has.
        triangles: u64,
    },
    /// A portal or mirror whose faces have no area.
    #[error("{node} is an opening without area; give its mesh some, and look for a scale of 0")]
    NoArea {
        /// The portal or mirror.
        node: String,
    },
    /// A portal or mirror that reaches beyond [`MAX_COORDINATE`].
    #[error(
        "{node} is an opening that reaches farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to \
         the origin"
    )]
    TooFar {
        /// The portal or mirror.
        node: String,
    },
    /// A portal or mirror that is bent.
    #[error(
        "{node} is an opening that is not flat: a corner lies {off} units off the plane of the others; \
         flatten its mesh, or make several openings of it"
    )]
    NotFlat {
        /// The portal or mirror.
        node: String,
        /// How far off a corner lies, in scene units.
        off: f64,
    },
    /// A portal or mirror with a hole, a notch, or faces over one another.
    #[error(
        "{node} is an opening that is not convex: its faces cover {percent:.1} % of their convex outline; \
         make it one convex polygon (a bounding rectangle will do), or several openings"
    )]
    NotConvex {
        /// The portal or mirror.
        node: String,
        /// Area of all faces, in percent of that of the outline around them.
        percent: f64,
    },
    /// A portal or mirror with nothing of any room near it.
    #[error(
        "{node} touches no room; move it into an opening of one, and check that what is around it is below a node \
         whose name ends in -room"
    )]
    TouchesNoRoom {
        /// The portal or mirror.
        node: String,
    },
    /// A portal with nothing on one side, above no room that could be there.
    #[error(
        "{node} touches only one room, {room}: there is nothing at its other side, and no room that is open above, such as a \
         garden, extends below it. Extend the ground of one to there, name the room by `to`, or remove the portal"
    )]
    LeadsNowhere {
        /// The portal.
        node: String,
        /// The room.
        room: String,
    },
    /// A portal out of the top of a room that has no top.
    #[error(
        "{node} touches only one room, {room}: it leads into the open sky above that, and since {room} has no top, its sky belongs \
         to it. Close its ceiling, make the portal as large as the open top, or remove the portal"
    )]
    OwnSky {
        /// The portal.
        node: String,
        /// The room.
        room: String,
    },
    /// A portal with open sky on both sides.
    #[error(
        "{node} touches only one room, {room}: there is nothing but the open sky above that at both sides; move it into the \
         opening between two rooms, or remove it"
    )]
    OnlySky {
        /// The portal.
        node: String,
        /// The room below it.
        room: String,
    },
    /// A portal with the same room on both sides.
    #[error(
        "{node} touches only one room, {room}; move it into the opening between two, or name the other by `to`"
    )]
    TouchesOneRoom {
        /// The portal.
        node: String,
        /// The room.
        room: String,
    },
    /// A one-way portal that stands in neither of its rooms.
    #[error(
        "{node} is one-way between {rooms}, but belongs to neither; name the one it leads to by `to`, or parent it to \
         the other"
    )]
    OneWayFromNowhere {
        /// The portal.
        node: String,
        /// The two rooms.
        rooms: String,
    },
    /// Two portals lead out of one opening of a room.
    #[error("{first} and {second} stand in one opening of {room}; remove one of them")]
    SamePlace {
        /// One portal or mirror.
        first: String,
        /// The other.
        second: String,
        /// The room.
        room: String,
    },
    /// `to` names no room.
    #[error("{node} leads to `{to}`, but there is no such room; rooms are {rooms}")]
    NoSuchRoom {
        /// The portal.
        node: String,
        /// What it names.
        to: String,
        /// Those that there are.
        rooms: String,
    },
    /// `exit` names no node.
    #[error(
        "{node} has the exit `{exit}`, but no node of the scene is called so; rename one, or correct the exit"
    )]
    NoSuchExit {
        /// The portal.
        node: String,
        /// What it names.
        exit: String,
    },
    /// `exit` names several nodes.
    #[error("{node} has the exit `{exit}`, but {first} and {second} are both called so; rename one of them")]
    ManyExits {
        /// The portal.
        node: String,
        /// What it names.
        exit: String,
        /// One node.
        first: String,
        /// Another.
        second: String,
    },
    /// An exit that stands in no room.
    #[error(
        "{node} has the exit `{exit}`, which stands in no room; parent it to one, or name the room by `to`"
    )]
    ExitInNoRoom {
        /// The portal.
        node: String,
        /// The exit.
        exit: String,
    },
    /// A node whose axes have no direction.
    #[error("{node} is one end of a teleport, but has a scale of 0, so it faces nowhere; give it another")]
    NoFrame {
        /// The portal or its exit.
        node: String,
    },
    /// A teleport that would be gone into along its own surface.
    #[error(
        "{node} is a teleport, which is gone into along the node's local -Z, but its face lies along that; turn the \
         node (and its mesh the other way) so that -Z points into it"
    )]
    Edgewise {
        /// The portal.
        node: String,
    },
    /// A mirror or portal in a file in which no room is marked.
    #[error(
        "{node} is an opening, but the file has no rooms; name the node above its surroundings NAME-room"
    )]
    NoRooms {
        /// The portal or mirror.
        node: String,
    },
    /// Terrain without a mesh.
    #[error(
        "{node} has no triangles to be terrain; give it a grid of heights, or another name if it is none"
    )]
    TerrainWithoutMesh {
        /// The terrain.
        node: String,
    },
    /// Terrain that changes its shape.
    #[error(
        "{node} is terrain with {what}, but terrain stands still; apply that to the mesh before exporting, or give the node \
             another name"
    )]
    TerrainMoves {
        /// The terrain.
        node: String,
        /// A skeleton, or morph targets.
        what: &'static str,
    },
    /// Terrain that is to be there many times.
    #[error("{node} is terrain with instances; give each a node of its own, or the node another name")]
    TerrainInstanced {
        /// The terrain.
        node: String,
    },
    /// Terrain of which not all is made of one material.
    #[error(
        "{node} is terrain of several materials: those of primitives {} and {} of its mesh differ. Give it one, or cut it \
         in a node for each",
        primitives[0], primitives[1]
    )]
    TerrainMaterials {
        /// The terrain.
        node: String,
        /// Two primitives of its mesh, by their numbers.
        primitives: [usize; 2],
    },
    /// Terrain whose mesh is no grid of heights.
    #[error("{node} is terrain, but {why}. If it is none, give the node another name")]
    NoGrid {
        /// The terrain.
        node: String,
        /// What is wrong with the grid.
        why: GridError,
    },
}
