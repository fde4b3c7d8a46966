//! Why terrain is not read.

use crate::BrokenRule;
use enfilade::HeightFieldError;
use thiserror::Error;

/// What is wrong with a description of terrain, or with its heights.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TerrainError {
    /// The JSON lacks something, or has it in another form.
    #[error(
        "describes terrain, but {0}; it needs width, height, format, cellMetresX and cellMetresZ, and may have file, noData and diagonal"
    )]
    Description(String),
    /// Heights are stored in a way that is not read.
    #[error(
        "has heights in the format `{0}`; `u16 little endian`, `u16 big endian`, `f32 little endian` and `f32 big endian` are read"
    )]
    Format(String),
    /// The heights are in a file, and there is no folder to look in.
    #[error("describes heights in a file, but no folder was given to look for it; give one")]
    NoFolder,
    /// There is no such file, or there are several.
    #[error("describes heights in a file `{wanted}` beside it, but {found}; name one as \"file\"")]
    NoFile {
        /// How it would be called.
        wanted: String,
        /// What is there.
        found: String,
    },
    /// The name of the file leads elsewhere.
    #[error(
        "has its heights in `{0}`, which is not beside it; move that file there, and give its name alone"
    )]
    NotBeside(String),
    /// The file of heights is not read.
    #[error("has its heights in {file}, which {why}")]
    File {
        /// Where it was looked for.
        file: String,
        /// What is wrong with it.
        why: Box<BrokenRule>,
    },
    /// The file of heights is too short, or too long.
    #[error(
        "has {} x {} heights in {file}, which must have {needs} bytes, but has {has}; copy it again, or correct width and height",
        size[0], size[1]
    )]
    Length {
        /// Which file.
        file: String,
        /// Heights from west to east and from north to south.
        size: [u32; 2],
        /// The bytes that they take.
        needs: u64,
        /// The bytes that are there.
        has: u64,
    },
    /// A hole.
    #[error(
        "has no height at column {column}, row {row}, which holds the noData value {number:?}; fill the hole, or cut the field in parts \
         around it"
    )]
    NoData {
        /// What stands there.
        number: f32,
        /// Counted from the west.
        column: u32,
        /// Counted from the north.
        row: u32,
    },
    /// It says a method that there is none of.
    #[error("is to be seen by the method `{method}`, which is not known; methods are {methods}")]
    UnknownMethod {
        /// What it says.
        method: String,
        /// What there is.
        methods: String,
    },
    /// What is left to the field to check.
    #[error("is no terrain: {0}")]
    Field(HeightFieldError),
}

impl From<TerrainError> for BrokenRule {
    fn from(why: TerrainError) -> BrokenRule {
        BrokenRule::Terrain(Box::new(why))
    }
}
