//! Errors of linking files.

use crate::{BrokenRule, ImportError};
use thiserror::Error;

/// Why files cannot be linked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LinkError {
    /// A part cannot be read.
    #[error(transparent)]
    File(Box<ImportError>),
    /// The linked world is not valid.
    #[error("{0}")]
    World(Box<BrokenRule>),
    /// The name of a part is empty, contains a `/`, or is already used.
    #[error("`{0}` is not a valid part name; give each part a unique name without a /")]
    NameTaken(String),
    /// The transform of a part is not finite, has a scale of 0 or less, or a rotation of length 0.
    #[error(
        "its transform is invalid: all numbers must be finite, the scale above 0, and the rotation not 0"
    )]
    BadPlacing,
    /// A part has no node with that name.
    #[error("part `{part}` has no node `{node}`; it has: {like}")]
    NoSuchNode {
        /// The part.
        part: String,
        /// The name.
        node: String,
        /// Names of similar nodes.
        like: String,
    },
    /// A part has several nodes with that name.
    #[error("part `{part}` has several nodes `{node}`; rename all but one in the file")]
    ManyNodes {
        /// The part.
        part: String,
        /// The name.
        node: String,
    },
    /// A shape is invalid.
    #[error("{0}")]
    BadShape(&'static str),
    /// The world exceeds 4 GiB, the maximum size of a `.glb`.
    #[error("the world would be larger than 4 GiB, the maximum size of a .glb; join fewer or smaller parts")]
    TooLarge,
}

impl From<ImportError> for LinkError {
    fn from(why: ImportError) -> LinkError {
        LinkError::File(Box::new(why))
    }
}
