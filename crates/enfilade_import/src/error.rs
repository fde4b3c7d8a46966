//! Errors of reading a file.

use crate::spoken::{bytes, unreadable};
use crate::{AuthoringErrors, BspError, EnfError, ObjError, PrtError, TerrainError, TileError};
use enfilade::{BakedCellsError, GeometryError, MAX_COORDINATE, MeshError};
use std::io;
use thiserror::Error;

/// A file that cannot be read, and the rule that it violates.
#[derive(Debug, Error)]
#[error("{file}: {rule}")]
pub struct ImportError {
    /// The path as the caller gave it.
    pub file: String,
    /// The violated rule.
    pub rule: BrokenRule,
}

/// The rule that a file violates. A `place` is `accessor 12`, `meshes[3].primitives[0]` or `node 7 "Door"`.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BrokenRule {
    /// The operating system reports an I/O error.
    #[error("cannot be read: {}", unreadable(.0))]
    Unreadable(io::Error),
    /// The path is a folder, a pipe or a device.
    #[error("is not a file, but a folder, a pipe or a device; name a file")]
    NotAFile,
    /// The file has neither the magic number of a `.glb` nor the start of a JSON object.
    #[error("is not glTF: it {begins}; name a glTF 2.0 file (.glb, or .gltf with its .bin files)")]
    NotGltf {
        /// First bytes of the file: "begins with `…`", or "is empty".
        begins: String,
    },
    /// The file is of no supported format.
    #[error(
        "is neither glTF nor OBJ, nor a map of Quake, terrain or a baked scene: it {begins}; name a scene in glTF 2.0 (.glb, or .gltf with \
         its .bin files), OBJ (.obj with its .mtl files), a compiled map (.bsp: BSP29, BSP2, IBSP46), or terrain (.json with \
         its .raw file)"
    )]
    UnknownFormat {
        /// First bytes of the file: "begins with `…`", or "is empty".
        begins: String,
    },
    /// The file is of a known format that is not read.
    #[error("is {format}, which is not read; {remedy}")]
    OtherFormat {
        /// The format, with an article.
        format: &'static str,
        /// The shortest way to a `.glb`.
        remedy: &'static str,
    },
    /// An OBJ file violates a rule.
    #[error("{0}")]
    Obj(Box<ObjError>),
    /// A terrain description, or its heights, violates a rule.
    #[error("{0}")]
    Terrain(Box<TerrainError>),
    /// A tile of 3D Tiles violates a rule.
    #[error("{0}")]
    Tile(Box<TileError>),
    /// A baked scene (`.enf`) cannot be read.
    #[error("{0}")]
    Enf(EnfError),
    /// A portal file (`.prt`) violates a rule.
    #[error("{0}")]
    Prt(Box<PrtError>),
    /// A compiled map violates a rule.
    #[error("{0}")]
    Bsp(Box<BspError>),
    /// A `.glb` is truncated.
    #[error(
        "is cut short: its {part} should end at byte {needs}, but the file has only {has}; copy or export it again"
    )]
    Truncated {
        /// The part in which the file ends.
        part: &'static str,
        /// Expected end of that part, in bytes from the start of the file.
        needs: u64,
        /// Length of the file, in bytes.
        has: u64,
    },
    /// The first chunk of a `.glb` is not JSON.
    #[error("its first chunk is not JSON; export it again")]
    NoJsonChunk,
    /// The file is of another glTF version.
    #[error("is glTF version {0}; export it again as glTF 2.0")]
    Version(String),
    /// The file is not valid JSON, or does not match the glTF schema.
    #[error("its JSON cannot be read: {0}; export it again")]
    Json(String),
    /// Reading needs more memory than allowed.
    #[error(
        "{place} would raise the memory needed to {}, above the limit of {}; allow more (--memory), or split the file",
        bytes(*.needs_bytes), bytes(*.limit_bytes)
    )]
    TooLarge {
        /// The element that exceeds the limit.
        place: String,
        /// Estimated memory, in bytes, including everything read before.
        needs_bytes: u64,
        /// The limit, in bytes.
        limit_bytes: u64,
    },
    /// The file requires an unsupported extension.
    #[error(
        "requires an unsupported extension: {extension}; {remedy}, or read what is left without it (--lenient)"
    )]
    ExtensionRequired {
        /// Name of the extension, or names of several.
        extension: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// A scene is requested that the file does not have.
    #[error("has no scene `{scene}`; {}", scenes_there(.there))]
    NoSuchScene {
        /// The requested name or index.
        scene: String,
        /// Names of the scenes in order, empty without a name; the first 1,000.
        there: Vec<String>,
    },
    /// A scene is requested by a name that several have.
    #[error("has several scenes with the name `{scene}`, at the indices {indices}; name one by its index")]
    ManyScenes {
        /// The requested name.
        scene: String,
        /// Indices of the first few scenes with that name.
        indices: String,
    },
    /// A scene is requested of a file whose format has no scenes.
    #[error("has no scenes to choose from, since only glTF files have; leave out --scene")]
    FormatWithoutScenes,
    /// A valid glTF feature that is not supported yet, and without which a shape would be wrong.
    #[error("{place} is {what}, which is not supported yet; {remedy}")]
    NotReadYet {
        /// The element that uses the feature.
        place: String,
        /// The feature.
        what: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
    /// An index is out of range.
    #[error("{place} names {kind} {index}, but there are only {count}; export it again")]
    NoSuch {
        /// The element that holds the index.
        place: String,
        /// Kind of the referenced element.
        kind: &'static str,
        /// The index.
        index: u32,
        /// Number of elements of that kind.
        count: usize,
    },
    /// A buffer or an image has a remote URI.
    #[error("{place} is at `{uri}`, and nothing is fetched; save it beside the file and name it there")]
    NotLocal {
        /// The buffer or image.
        place: String,
        /// The URI.
        uri: String,
    },
    /// The path of a buffer or an image is absolute or leaves the folder with `..`.
    #[error(
        "{place} is `{uri}`, which leads out of the file's folder; move it into that folder and name it there"
    )]
    LeavesFolder {
        /// The buffer or image.
        place: String,
        /// The path.
        uri: String,
    },
    /// A buffer or an image is in a separate file, and no folder was given.
    #[error(
        "{place} is the file `{uri}`, but no folder was given to look for it; give one, or embed the file"
    )]
    NoFolder {
        /// The buffer or image.
        place: String,
        /// The path.
        uri: String,
    },
    /// The URI of a buffer or an image has invalid percent encoding, or invalid base64 data.
    #[error("{place} has an invalid URI: {why}; export it again")]
    BadUri {
        /// The buffer or image.
        place: String,
        /// The error in the URI.
        why: String,
    },
    /// The file of a buffer or an image cannot be read.
    #[error("{place} is the file `{path}`, which {why}")]
    BufferFile {
        /// The buffer or image.
        place: String,
        /// The path that was tried.
        path: String,
        /// The reason why the file cannot be read.
        why: Box<BrokenRule>,
    },
    /// A buffer has neither a URI nor a binary chunk of the `.glb`.
    #[error(
        "{place} has no bytes: no uri, and it is not the binary chunk of a .glb; export it again, without compression"
    )]
    BufferWithoutBytes {
        /// The buffer.
        place: String,
    },
    /// A buffer is shorter than its `byteLength`.
    #[error("{place} should have {needs} bytes, but only {has} are there; copy or export it again")]
    BufferTooShort {
        /// The buffer.
        place: String,
        /// Its `byteLength`.
        needs: u64,
        /// Available bytes.
        has: u64,
    },
    /// A buffer view exceeds its buffer.
    #[error("{place} ends at byte {end} of buffer {buffer}, which has only {length}; export it again")]
    ViewOutOfBuffer {
        /// The buffer view.
        place: String,
        /// End of the view, in bytes from the start of the buffer.
        end: u128,
        /// Index of its buffer.
        buffer: u32,
        /// Length of the buffer, in bytes.
        length: u64,
    },
    /// An accessor exceeds its buffer view.
    #[error("{place} ends at byte {end} of bufferView {view}, which has only {length}; export it again")]
    AccessorOutOfView {
        /// The accessor.
        place: String,
        /// End of the accessor, in bytes from the start of the view.
        end: u128,
        /// Index of its buffer view.
        view: u32,
        /// Length of the view, in bytes.
        length: u64,
    },
    /// The stride of an accessor is smaller than its elements.
    #[error(
        "{place} has elements of {element} bytes, but its bufferView {view} has a byteStride of {stride}; export it again"
    )]
    BadStride {
        /// The accessor.
        place: String,
        /// Index of its buffer view.
        view: u32,
        /// Bytes from the start of one element to the start of the next.
        stride: u64,
        /// Size of an element, in bytes.
        element: u64,
    },
    /// An accessor has a type or component type that its use does not allow.
    #[error("{place} holds {found}, but {wanted} are expected; {remedy}")]
    WrongType {
        /// The accessor.
        place: String,
        /// Its component type and type.
        found: String,
        /// The types that are allowed.
        wanted: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
    /// The number of normals, texture coordinates, colors, joints or changes by a morph target differs from the number of positions.
    #[error("{place} has {count} {what}, but {positions} positions; export it again with one for each")]
    AttributeCount {
        /// The primitive.
        place: String,
        /// The attribute.
        what: &'static str,
        /// Its element count.
        count: u64,
        /// The number of positions.
        positions: u64,
    },
    /// A sparse accessor replaces more elements than it has.
    #[error("{place} has {count} sparse elements, but only {elements} in all; export it again")]
    SparseCount {
        /// The accessor.
        place: String,
        /// Number of sparse elements.
        count: u64,
        /// Number of elements of the accessor.
        elements: u64,
    },
    /// Sparse indices are out of range or do not increase.
    #[error(
        "{place} has the sparse index {number} at position {at}, but sparse indices must increase and stay below its count of \
         {elements}; export it again"
    )]
    SparseIndex {
        /// The accessor.
        place: String,
        /// Position of the invalid index in the list.
        at: usize,
        /// The index.
        number: u64,
        /// Number of elements of the accessor.
        elements: u64,
    },
    /// A compressed buffer view is damaged, or uses an unknown compression mode.
    #[error("{place} is compressed, but {why}; export it again, or without compression")]
    BadCompression {
        /// The buffer view.
        place: String,
        /// The error in it.
        why: String,
    },
    /// The instance attributes of a node have different element counts.
    #[error(
        "{node} has {first} {first_what}, but {second} {second_what}; export it again with one of each per instance"
    )]
    InstanceCount {
        /// The node.
        node: String,
        /// Element count of one attribute.
        first: u64,
        /// Name of that attribute.
        first_what: &'static str,
        /// Element count of another.
        second: u64,
        /// Name of that attribute.
        second_what: &'static str,
    },
    /// A skin cannot be applied.
    #[error("{place} {why}; export it again")]
    BadSkin {
        /// The skin, or the primitive that it should move.
        place: String,
        /// The error in it.
        why: String,
    },
    /// A mesh has too many morph targets and joints for its size.
    #[error(
        "{place} takes the sum of {terms} values to deform, above the limit of {most}; remove morph targets, or apply them \
         to the mesh"
    )]
    PoseTooCostly {
        /// The mesh.
        place: String,
        /// Number of values: vertices times morph targets and sets of joints.
        terms: u64,
        /// The limit.
        most: u64,
    },
    /// A sampler has a filter or wrap mode that glTF does not define.
    #[error("{place} has {what} {value}, which glTF does not define; export it again")]
    BadSampler {
        /// The sampler.
        place: String,
        /// The property.
        what: &'static str,
        /// The value.
        value: u32,
    },
    /// A vertex position that a triangle uses is NaN or infinite.
    #[error(
        "{place} has a triangle at position {position}, which is not finite; repair the mesh and export it again"
    )]
    PositionNotFinite {
        /// The primitive.
        place: String,
        /// Index of the position.
        position: u32,
    },
    /// A vertex index is out of range.
    #[error("{place} has index {index} at corner {corner}, but only {positions} positions; export it again")]
    IndexOutOfRange {
        /// The primitive.
        place: String,
        /// Position of the index in the index list.
        corner: usize,
        /// The vertex index.
        index: u32,
        /// Number of positions.
        positions: u64,
    },
    /// A mesh has more vertices than 32-bit indices can address.
    #[error("{place} has more than 4 billion corners; split it")]
    TooManyCorners {
        /// The mesh.
        place: String,
    },
    /// A primitive has a topology mode that glTF does not define.
    #[error("{place} has mode {mode}, but modes are 0 (points) to 6 (triangle fan); export it again")]
    BadMode {
        /// The primitive.
        place: String,
        /// The mode.
        mode: u32,
    },
    /// A material has an alpha mode that glTF does not define.
    #[error("{place} has alphaMode `{mode}`, but modes are OPAQUE, MASK and BLEND; export it again")]
    BadAlphaMode {
        /// The material.
        place: String,
        /// The mode.
        mode: String,
    },
    /// A node has two parents, or is listed twice by one.
    #[error("{node} is a child of both {first} and {second}, but a node has one parent; export it again")]
    TwoParents {
        /// The node.
        node: String,
        /// One parent.
        first: String,
        /// The other parent; equal to `first` if that lists the node twice.
        second: String,
    },
    /// A node is its own ancestor.
    #[error("its nodes form a cycle: {0}; export it again")]
    NodeCycle(String),
    /// A node matrix whose last row is not 0, 0, 0, 1.
    #[error("{0} has a matrix with perspective: its last row is not 0, 0, 0, 1; export it again")]
    NotAffine(String),
    /// A rotation quaternion of length zero.
    #[error("{0} has a rotation of length zero; correct it (no rotation is 0, 0, 0, 1) and export it again")]
    NoRotation(String),
    /// A world transform overflows 32-bit floats.
    #[error(
        "{0} has a transform that is not finite; correct its position, rotation and scale, and export it again"
    )]
    NodeNotFinite(String),
    /// A node's transform or mesh extends beyond [`MAX_COORDINATE`].
    #[error(
        "{0} extends beyond {MAX_COORDINATE:e} units; scale the scene down or move it to the origin, and export it \
         again"
    )]
    NodeTooFar(String),
    /// [`Mesh::new`](enfilade::Mesh::new) rejects a mesh.
    #[error("{place}: {why}")]
    Mesh {
        /// The mesh.
        place: String,
        /// The rule that it violates.
        why: MeshError,
    },
    /// The baked cells of a map are invalid.
    #[error("its visibility data is invalid: {0}; run vis again")]
    Cells(Box<BakedCellsError>),
    /// The [`GeometryBuilder`](enfilade::GeometryBuilder) rejects a room.
    #[error("{0}")]
    Geometry(GeometryError),
    /// All errors in rooms, portals and terrain.
    #[error("{0}")]
    Authoring(Box<AuthoringErrors>),
}

/// Returns the scenes of a file, in words.
fn scenes_there(names: &[String]) -> String {
    const FEW: usize = 24;
    let named = names.iter().enumerate().take(FEW);
    let mut all: Vec<String> = named
        .map(|(number, name)| match &**name {
            "" => number.to_string(),
            name => format!("{number} {name:?}"),
        })
        .collect();
    if names.len() > FEW {
        all.push(format!("{} more", names.len() - FEW));
    }
    match &*all {
        [] => "it lists none; leave out --scene".to_owned(),
        all => format!("its scenes are {}", all.join(", ")),
    }
}
