//! Reads scenes from files: glTF 2.0, as `.glb` and as `.gltf` with its buffers beside it or inside it.
//!
//! ```
//! use enfilade_import::{ReadOptions, read_bytes};
//!
//! let file = br#"{
//!     "asset": { "version": "2.0" },
//!     "nodes": [{ "name": "Leaf", "mesh": 0, "translation": [0, 2, 0] }],
//!     "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
//!     "accessors": [{ "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 }],
//!     "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
//!     "buffers": [{ "byteLength": 36, "uri":
//!         "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }]
//! }"#;
//! let leaf = read_bytes(file, None, &ReadOptions::default())?;
//! assert_eq!(leaf.content.triangle_count(), 1);
//! assert_eq!(leaf.content.bounds().max, [1.0, 3.0, 0.0]);
//! # Ok::<(), enfilade_import::ImportError>(())
//! ```
//!
//! Each node with a mesh becomes an item, and nodes that share a mesh share it here too. What changes only the
//! look (textures, normals, lights) and what is not read yet is named in [`Import::warnings`], never silently
//! dropped. A file that breaks a rule, however it does, gives an [`ImportError`] that names the place and the rule.
#![forbid(unsafe_code)]

mod budget;
mod camera;
mod error;
mod gltf;
mod warning;

pub use camera::Camera;
pub use error::{BrokenRule, ImportError};
pub use warning::{Warning, WarningKind};

use budget::Budget;
use enfilade::Content;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// What a file holds.
#[derive(Debug)]
pub struct Import {
    /// Every item of the file's default scene, in one fragment, in world space: y up, metres unless the file's
    /// author thought otherwise.
    ///
    /// An item is named for its node, `NAME#nodeIndex` where nodes with meshes share the name, `node#12` where it
    /// has none. No two items have the same name.
    pub content: Content,
    /// The perspective cameras of that scene, in the order of their nodes, named as items are.
    pub cameras: Vec<Camera>,
    /// What the file has that was not read, or that is odd: one warning of each kind, worst first.
    pub warnings: Vec<Warning>,
}

/// How a file is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadOptions {
    /// Bytes that reading may take, file included. What would take more, by an estimate made before anything is
    /// allocated, is refused. 1 GiB unless told: enough for some 10 million triangles, each stored once.
    pub limit_bytes: u64,
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions { limit_bytes: 1 << 30 }
    }
}

/// Reads a file. Its first bytes say what it is, not its name.
///
/// # Errors
/// An [`ImportError`] for the first broken rule that is met; the same one every time.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Import, ImportError> {
    let failed = |rule| ImportError {
        file: path.display().to_string(),
        rule,
    };
    let mut budget = Budget::new(options.limit_bytes);
    let bytes = read_regular_file(path, None, &|| "the file".to_owned(), &mut budget).map_err(failed)?;
    gltf::import(&bytes, path.parent(), budget).map_err(failed)
}

/// Reads the bytes of a file. `folder` is where the buffers that a `.gltf` names lie; with `None`, naming one is an
/// error.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], folder: Option<&Path>, options: &ReadOptions) -> Result<Import, ImportError> {
    let failed = |rule| ImportError {
        file: "the bytes given".to_owned(),
        rule,
    };
    let mut budget = Budget::new(options.limit_bytes);
    budget
        .take(bytes.len() as u64, || "the file".to_owned())
        .map_err(failed)?;
    gltf::import(bytes, folder, budget).map_err(failed)
}

/// The first `most` bytes of a file, or all. Never waits on a pipe, and never reads more than the budget allows.
fn read_regular_file(
    path: &Path,
    most: Option<u64>,
    place: &dyn Fn() -> String,
    budget: &mut Budget,
) -> Result<Vec<u8>, BrokenRule> {
    // Asked before opening: a pipe without a writer would not open until someone writes.
    if !std::fs::metadata(path).map_err(BrokenRule::Unreadable)?.is_file() {
        return Err(BrokenRule::NotAFile);
    }
    let file = File::open(path).map_err(BrokenRule::Unreadable)?;
    let there = file.metadata().map_err(BrokenRule::Unreadable)?.len();
    let wanted = most.map_or(there, |most| most.min(there));
    budget.take(wanted, place)?;
    let mut bytes = Vec::new();
    let no_room = |_| BrokenRule::Unreadable(std::io::ErrorKind::OutOfMemory.into());
    bytes.try_reserve_exact(wanted as usize).map_err(no_room)?;
    file.take(wanted)
        .read_to_end(&mut bytes)
        .map_err(BrokenRule::Unreadable)?;
    Ok(bytes)
}
