//! Pins methods: writes into a copy of a file how each of its rooms is to be seen from then on.

use crate::budget::Budget;
use crate::{BrokenRule, ImportError, ReadOptions, gltf, read_file, terrain};
use enfilade::Method;
use std::path::Path;
use thiserror::Error;

/// Why methods are not written into a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PinError {
    /// It is no sound file.
    #[error(transparent)]
    File(#[from] Box<ImportError>),
    /// Files of its kind have no place for methods.
    #[error("methods cannot be stored in an OBJ file or a map; convert it to glTF, or leave out -o")]
    NoPlace,
    /// A `.glb` has at most 4 GiB.
    #[error("with methods it would be larger than 4 GiB, which no .glb can be; split it")]
    TooLong,
}

/// What became of a file.
enum Pinned {
    Done(Vec<u8>),
    NoPlace,
    TooLong,
}

/// A copy of a file of which room n, as [`read`](crate::read) gives them, is seen by method n. Rooms of glTF say so in
/// `extras.enfilade.method` of their nodes, and what stands in no room in that of its scene; terrain in `method`. The files that it
/// names are still looked for beside it.
///
/// # Errors
/// [`PinError`].
pub fn with_methods(path: &Path, methods: &[Method], limit_bytes: u64) -> Result<Vec<u8>, PinError> {
    let options = ReadOptions {
        limit_bytes,
        ..ReadOptions::default()
    };
    let pinned = read_file(path, &options, |bytes, _, budget| pin(bytes, methods, budget));
    match pinned.map_err(Box::new)? {
        Pinned::Done(bytes) => Ok(bytes),
        Pinned::NoPlace => Err(PinError::NoPlace),
        Pinned::TooLong => Err(PinError::TooLong),
    }
}

fn pin(bytes: &[u8], methods: &[Method], budget: Budget) -> Result<Pinned, BrokenRule> {
    if terrain::describes_terrain(bytes) {
        return match methods.first() {
            Some(&method) => terrain::with_method(bytes, method).map(Pinned::Done),
            None => Ok(Pinned::Done(bytes.to_vec())),
        };
    }
    if !gltf::begins_like_gltf(bytes) {
        return Ok(Pinned::NoPlace);
    }
    let pinned = gltf::with_methods(bytes, methods, budget)?;
    Ok(pinned.map_or(Pinned::TooLong, Pinned::Done))
}
