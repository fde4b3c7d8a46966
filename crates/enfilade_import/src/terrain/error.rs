//! Errors of reading terrain.

use crate::BrokenRule;
use enfilade::HeightFieldError;
use thiserror::Error;

/// The rule that a terrain description, or its heightmap, violates.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TerrainError {
    /// The JSON lacks a key, or a value has the wrong type.
    #[error(
        "describes terrain, but {0}; it needs width, height, format, cellMetresX and cellMetresZ, and may have file, noData, \
         diagonal and method"
    )]
    Description(String),
    /// The sample type is not supported.
    #[error(
        "has heights in the unknown format `{0}`; formats are `u16 little endian`, `u16 big endian`, `f32 little endian` and \
         `f32 big endian`"
    )]
    Format(String),
    /// The heights are in a separate file, and no folder was given.
    #[error("describes heights in a file, but no folder was given to look for it; give one")]
    NoFolder,
    /// No heightmap was found, or several.
    #[error("describes heights in a file `{wanted}` beside it, but {found}; name one as \"file\"")]
    NoFile {
        /// The file name that was tried first.
        wanted: String,
        /// The files that were found.
        found: String,
    },
    /// `file` is a path outside the folder.
    #[error(
        "has its heights in `{0}`, which is not in the same folder; move that file there, and give only its name"
    )]
    NotBeside(String),
    /// The heightmap cannot be read.
    #[error("has its heights in {file}, which {why}")]
    File {
        /// The path that was tried.
        file: String,
        /// Why it cannot be read.
        why: Box<BrokenRule>,
    },
    /// The heightmap has the wrong length.
    #[error(
        "has {} x {} heights in {file}, which must have {needs} bytes, but has {has}; copy it again, or correct width and \
         height",
        size[0], size[1]
    )]
    Length {
        /// The heightmap.
        file: String,
        /// Number of columns and rows.
        size: [u32; 2],
        /// Required length, in bytes.
        needs: u64,
        /// Length of the file, in bytes.
        has: u64,
    },
    /// A sample has the `noData` value.
    #[error(
        "has no height at column {column}, row {row}, which holds the noData value {number:?}; fill the hole, or split the \
         terrain around it"
    )]
    NoData {
        /// The `noData` value.
        number: f32,
        /// Column, from the west, from 0.
        column: u32,
        /// Row, from the north, from 0.
        row: u32,
    },
    /// `method` is unknown.
    #[error("has the unknown method `{method}`; methods are {methods}")]
    UnknownMethod {
        /// The value of `method`.
        method: String,
        /// Names of the known methods.
        methods: String,
    },
    /// The [`HeightField`](enfilade::HeightField) rejects the heights.
    #[error("is not a valid terrain: {0}")]
    Field(HeightFieldError),
}

impl From<TerrainError> for BrokenRule {
    fn from(why: TerrainError) -> BrokenRule {
        BrokenRule::Terrain(Box::new(why))
    }
}
