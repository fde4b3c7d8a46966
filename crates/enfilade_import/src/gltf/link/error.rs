//! Why files are not joined.

use crate::{BrokenRule, ImportError};
use thiserror::Error;

/// Why files are not joined.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LinkError {
    /// A part is no sound file.
    #[error(transparent)]
    File(Box<ImportError>),
    /// What the parts come to is no sound scene.
    #[error("{0}")]
    World(Box<BrokenRule>),
    /// A name of a part that is empty, has a `/` in it, or is another's.
    #[error("`{0}` is no name for a part; give each part a unique name without a /")]
    NameTaken(String),
    /// A placing that is not finite, that flattens, or whose rotation has no length.
    #[error(
        "its transform is not possible: all numbers must be finite, the scale above 0, and the rotation not 0"
    )]
    BadPlacing,
    /// A part has no node of that name.
    #[error("part `{part}` has no node `{node}`; it has: {like}")]
    NoSuchNode {
        /// The part.
        part: String,
        /// The name.
        node: String,
        /// Names of some that it has.
        like: String,
    },
    /// A part has several nodes of that name.
    #[error("part `{part}` has several nodes `{node}`; rename all but one in the file")]
    ManyNodes {
        /// The part.
        part: String,
        /// The name.
        node: String,
    },
    /// A shape that is none.
    #[error("{0}")]
    BadShape(&'static str),
    /// A `.glb` cannot be longer.
    #[error("the world would take more than 4 GB, which no .glb can; join fewer or smaller parts")]
    TooLarge,
}

impl From<ImportError> for LinkError {
    fn from(why: ImportError) -> LinkError {
        LinkError::File(Box::new(why))
    }
}
