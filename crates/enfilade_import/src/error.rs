//! Why a file is not read.

use crate::spoken::{bytes, unreadable};
use crate::{AuthoringErrors, BspError, ObjError, PrtError, TerrainError};
use enfilade::{BakedCellsError, GeometryError, MAX_COORDINATE, MeshError};
use std::io;
use thiserror::Error;

/// A file that is not read, and the rule that it breaks.
#[derive(Debug, Error)]
#[error("{file}: {rule}")]
pub struct ImportError {
    /// The file, as it was named.
    pub file: String,
    /// What is wrong in it.
    pub rule: BrokenRule,
}

/// What is wrong in a file. A `place` is `accessor 12`, `meshes[3].primitives[0]` or `node 7 "Door"`.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BrokenRule {
    /// The system does not hand out the file.
    #[error("cannot be read: {}", unreadable(.0))]
    Unreadable(io::Error),
    /// A folder, a pipe or a device.
    #[error("is not a file, but a folder, a pipe or a device; name a file")]
    NotAFile,
    /// Neither the magic number of a `.glb` nor the start of a JSON object.
    #[error("is not glTF: it {begins}; name a glTF 2.0 file (.glb, or .gltf with its .bin files)")]
    NotGltf {
        /// What it begins with: "begins with `…`", or "is empty".
        begins: String,
    },
    /// Neither glTF nor OBJ, nor a map, nor a description of terrain.
    #[error(
        "is neither glTF nor OBJ, nor a map of Quake, nor terrain: it {begins}; name a scene in glTF 2.0 (.glb, or .gltf with \
         its .bin files), OBJ (.obj with its .mtl files), a compiled map (.bsp: BSP29, BSP2, IBSP46), or terrain (.json with \
         its .raw file)"
    )]
    UnknownFormat {
        /// What it begins with: "begins with `…`", or "is empty".
        begins: String,
    },
    /// An OBJ file that breaks a rule.
    #[error("{0}")]
    Obj(Box<ObjError>),
    /// A description of terrain that breaks a rule, or heights that do.
    #[error("{0}")]
    Terrain(Box<TerrainError>),
    /// A file of portals that breaks a rule.
    #[error("{0}")]
    Prt(Box<PrtError>),
    /// A compiled map that breaks a rule.
    #[error("{0}")]
    Bsp(Box<BspError>),
    /// A `.glb` ends early.
    #[error(
        "is cut short: its {part} should end at byte {needs}, but the file has only {has}; copy or export it again"
    )]
    Truncated {
        /// The part in which it ends.
        part: &'static str,
        /// Where that part should end.
        needs: u64,
        /// Bytes that are there.
        has: u64,
    },
    /// A `.glb` that does not begin with its JSON.
    #[error("its first chunk is not JSON; export it again")]
    NoJsonChunk,
    /// Another version of glTF.
    #[error("is of glTF version {0}; export it again as glTF 2.0")]
    Version(String),
    /// Not JSON, or not what glTF wants there.
    #[error("its JSON cannot be read: {0}; export it again")]
    Json(String),
    /// More memory is needed than allowed.
    #[error(
        "{place} would raise the memory needed to {}, above the limit of {}; allow more (--memory), or split the file",
        bytes(*.needs_bytes), bytes(*.limit_bytes)
    )]
    TooLarge {
        /// What would take it.
        place: String,
        /// About what is needed, with all that was read before.
        needs_bytes: u64,
        /// What was allowed.
        limit_bytes: u64,
    },
    /// The file cannot be shown rightly without an extension.
    #[error("needs what is not read here: {extension}; {remedy}")]
    ExtensionRequired {
        /// Its name, or the names of several.
        extension: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// Something that is glTF, but not read yet, and without which a shape would be wrong.
    #[error("{place} is {what}, which is not read yet; {remedy}")]
    NotReadYet {
        /// Where.
        place: String,
        /// What it is.
        what: &'static str,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A number that names nothing.
    #[error("{place} names {kind} {index}, but there are only {count}; export it again")]
    NoSuch {
        /// Where.
        place: String,
        /// What it names.
        kind: &'static str,
        /// Which of them.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A buffer or an image is to be fetched from elsewhere.
    #[error("{place} is at `{uri}`, and nothing is fetched; save it beside the file and name it there")]
    NotLocal {
        /// Which of them.
        place: String,
        /// The address.
        uri: String,
    },
    /// The path of a buffer or an image is absolute or climbs with `..`.
    #[error(
        "{place} is `{uri}`, which leads out of the file's folder; move it into that folder and name it there"
    )]
    LeavesFolder {
        /// Which of them.
        place: String,
        /// The path.
        uri: String,
    },
    /// A buffer or an image stands in a file, and there is no folder to look in.
    #[error(
        "{place} is the file `{uri}`, but no folder was given to look for it; give one, or embed the file"
    )]
    NoFolder {
        /// Which of them.
        place: String,
        /// The path.
        uri: String,
    },
    /// The address of a buffer or an image has bad percent signs, or its data are not base64.
    #[error("{place} has a bad address: {why}; export it again")]
    BadUri {
        /// Which of them.
        place: String,
        /// What is bad about it.
        why: String,
    },
    /// The file of a buffer or an image is not read.
    #[error("{place} is the file `{path}`, which {why}")]
    BufferFile {
        /// Which of them.
        place: String,
        /// Where it was looked for.
        path: String,
        /// What is wrong with it.
        why: Box<BrokenRule>,
    },
    /// A buffer with neither an address nor a chunk of the `.glb`.
    #[error(
        "{place} has no bytes: no uri, and it is not the binary chunk of a .glb; export it again, without compression"
    )]
    BufferWithoutBytes {
        /// Which buffer.
        place: String,
    },
    /// A buffer is shorter than it says.
    #[error("{place} should have {needs} bytes, but only {has} are there; copy or export it again")]
    BufferTooShort {
        /// Which buffer.
        place: String,
        /// What it says.
        needs: u64,
        /// What is there.
        has: u64,
    },
    /// A buffer view reaches past its buffer.
    #[error("{place} ends at byte {end} of buffer {buffer}, which has only {length}; export it again")]
    ViewOutOfBuffer {
        /// Which buffer view.
        place: String,
        /// Where it ends.
        end: u128,
        /// Its buffer.
        buffer: u32,
        /// The bytes of that.
        length: u64,
    },
    /// An accessor reaches past its buffer view.
    #[error("{place} ends at byte {end} of bufferView {view}, which has only {length}; export it again")]
    AccessorOutOfView {
        /// Which accessor.
        place: String,
        /// Where it ends.
        end: u128,
        /// Its buffer view.
        view: u32,
        /// The bytes of that.
        length: u64,
    },
    /// Elements overlap.
    #[error(
        "{place} has elements of {element} bytes, but its bufferView {view} has a byteStride of {stride}; export it again"
    )]
    BadStride {
        /// Which accessor.
        place: String,
        /// Its buffer view.
        view: u32,
        /// From one element to the next.
        stride: u64,
        /// The bytes of an element.
        element: u64,
    },
    /// An accessor holds something else than what it is used for.
    #[error("{place} holds {found}, but {wanted} are wanted; {remedy}")]
    WrongType {
        /// Which accessor.
        place: String,
        /// What it holds.
        found: String,
        /// What is wanted.
        wanted: &'static str,
        /// What to do about it.
        remedy: &'static str,
    },
    /// Normals, texture coordinates or colors are not as many as positions.
    #[error("{place} has {count} {what}, but {positions} positions; export it again with one for each")]
    AttributeCount {
        /// Which primitive.
        place: String,
        /// Which of them.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// How many there should be.
        positions: u64,
    },
    /// More elements stand instead of others than there are others.
    #[error("{place} has {count} sparse elements, but only {elements} in all; export it again")]
    SparseCount {
        /// Which accessor.
        place: String,
        /// Elements that stand instead of others.
        count: u64,
        /// All elements.
        elements: u64,
    },
    /// The elements that stand instead of others have numbers that are out of range or out of order.
    #[error(
        "{place} has the sparse index {number} at position {at}, but sparse indices must increase and stay below its count of \
         {elements}; export it again"
    )]
    SparseIndex {
        /// Which accessor.
        place: String,
        /// Which of the indices.
        at: usize,
        /// The element it names.
        number: u64,
        /// All elements.
        elements: u64,
    },
    /// A compressed buffer view is damaged, or not compressed in a way that is known.
    #[error("{place} is compressed, but {why}; export it again, or without compression")]
    BadCompression {
        /// Which buffer view.
        place: String,
        /// What is wrong with it.
        why: String,
    },
    /// The instances of a node are given by lists of different lengths.
    #[error(
        "{node} has {first} {first_what}, but {second} {second_what}; export it again with one of each per instance"
    )]
    InstanceCount {
        /// The node.
        node: String,
        /// How many there are of one.
        first: u64,
        /// Of which.
        first_what: &'static str,
        /// How many of another.
        second: u64,
        /// Of which.
        second_what: &'static str,
    },
    /// A way to look a texture up that glTF does not know.
    #[error("{place} has {what} {value}, which glTF does not know; export it again")]
    BadSampler {
        /// Which sampler.
        place: String,
        /// Which of its values.
        what: &'static str,
        /// The value.
        value: u32,
    },
    /// A position that a triangle uses is NaN or infinite.
    #[error(
        "{place} has a triangle at position {position}, which is not finite; repair the mesh and export it again"
    )]
    PositionNotFinite {
        /// Which primitive.
        place: String,
        /// Which position.
        position: u32,
    },
    /// An index names a position that is not there.
    #[error("{place} has index {index} at corner {corner}, but only {positions} positions; export it again")]
    IndexOutOfRange {
        /// Which primitive.
        place: String,
        /// Which of its indices.
        corner: usize,
        /// The position it names.
        index: u32,
        /// How many there are.
        positions: u64,
    },
    /// Corners are numbered with 32 bits.
    #[error("{place} has more than 4 billion corners; cut it in pieces")]
    TooManyCorners {
        /// Which mesh.
        place: String,
    },
    /// A drawing mode that glTF does not know.
    #[error("{place} has mode {mode}, but modes are 0 (points) to 6 (triangle fan); export it again")]
    BadMode {
        /// Which primitive.
        place: String,
        /// Its mode.
        mode: u32,
    },
    /// An alpha mode that glTF does not know.
    #[error("{place} has alphaMode `{mode}`, but modes are OPAQUE, MASK and BLEND; export it again")]
    BadAlphaMode {
        /// Which material.
        place: String,
        /// Its mode.
        mode: String,
    },
    /// A node is a child twice.
    #[error("{node} is a child of both {first} and {second}, but a node has one parent; export it again")]
    TwoParents {
        /// The node.
        node: String,
        /// One parent.
        first: String,
        /// The other; the same one where it names the node twice.
        second: String,
    },
    /// A node is its own ancestor.
    #[error("these nodes are each other's children, in a cycle: {0}; export it again")]
    NodeCycle(String),
    /// A scene begins in the middle of a tree.
    #[error("{scene} names {node} as a root, but it is a child of {parent}; export it again")]
    NotARoot {
        /// The scene.
        scene: String,
        /// The node.
        node: String,
        /// The node's parent.
        parent: String,
    },
    /// A matrix whose last row is not 0, 0, 0, 1.
    #[error("{0} has a matrix with perspective: its last row is not 0, 0, 0, 1; export it again")]
    NotAffine(String),
    /// A rotation of length zero.
    #[error("{0} has a rotation of length zero; correct it (no rotation is 0, 0, 0, 1) and export it again")]
    NoRotation(String),
    /// A place beyond what 32-bit numbers hold.
    #[error(
        "{0} has a transform that is not finite; correct its position, rotation and scale, and export it again"
    )]
    NodeNotFinite(String),
    /// A node whose transform or mesh reaches beyond [`MAX_COORDINATE`].
    #[error(
        "{0} reaches farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to the origin, and export \
         it again"
    )]
    NodeTooFar(String),
    /// What is left to the mesh to check.
    #[error("{place}: {why}")]
    Mesh {
        /// Which mesh.
        place: String,
        /// The rule it breaks.
        why: MeshError,
    },
    /// What is left to the cells to check.
    #[error("what is visible in it cannot be used: {0}; run vis again")]
    Cells(Box<BakedCellsError>),
    /// What is left to the geometry to check.
    #[error("{0}")]
    Geometry(GeometryError),
    /// Rooms, portals or terrain that do not make a scene: all that is wrong with them.
    #[error("{0}")]
    Authoring(Box<AuthoringErrors>),
}
