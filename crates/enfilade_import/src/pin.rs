//! Stores chosen methods: writes the visibility method of each room into a copy of a file.

use crate::budget::Budget;
use crate::{BrokenRule, ImportError, ReadOptions, gltf, read_file, terrain};
use enfilade::Method;
use std::path::Path;
use thiserror::Error;

/// Errors of [`with_methods`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PinError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] Box<ImportError>),
    /// The format cannot store methods.
    #[error("methods cannot be stored in an OBJ file or a map; convert it to glTF, or leave out -o")]
    NoPlace,
    /// The result exceeds 4 GiB, the maximum size of a `.glb`.
    #[error("with methods it would be larger than 4 GiB, the maximum size of a .glb; split it")]
    TooLong,
}

/// Result of writing the methods.
enum PinResult {
    Done(Vec<u8>),
    NoPlace,
    TooLong,
}

/// Returns a copy of a file in which room n, as numbered by [`read`](crate::read), has method n. For glTF, the method
/// is written to `extras.enfilade.method` of the room's node, and of the scene for the room of nodes outside every
/// room; for terrain, to `method` of its description. Store the copy in the same folder, because its references are
/// relative.
///
/// # Errors
/// Returns a [`PinError`] if the file cannot be read, cannot store methods, or would become too large.
pub fn with_methods(path: &Path, methods: &[Method], limit_bytes: u64) -> Result<Vec<u8>, PinError> {
    let options = ReadOptions {
        limit_bytes,
        ..ReadOptions::default()
    };
    let pinned = read_file(path, &options, |bytes, _, budget| pin(bytes, methods, budget));
    match pinned.map_err(Box::new)? {
        PinResult::Done(bytes) => Ok(bytes),
        PinResult::NoPlace => Err(PinError::NoPlace),
        PinResult::TooLong => Err(PinError::TooLong),
    }
}

fn pin(bytes: &[u8], methods: &[Method], budget: Budget) -> Result<PinResult, BrokenRule> {
    if terrain::describes_terrain(bytes) {
        return match methods.first() {
            Some(&method) => terrain::with_method(bytes, method).map(PinResult::Done),
            None => Ok(PinResult::Done(bytes.to_vec())),
        };
    }
    if !gltf::begins_like_gltf(bytes) {
        return Ok(PinResult::NoPlace);
    }
    let pinned = gltf::with_methods(bytes, methods, budget)?;
    Ok(pinned.map_or(PinResult::TooLong, PinResult::Done))
}
