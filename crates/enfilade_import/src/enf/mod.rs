//! Baked scenes (`.enf`): everything that importing computes, to be read in place.
//!
//! A file is a container of sections ([`container`]): a scene ([`stored`]), tables of meshes and items, pages of meshes that
//! are near each other, and images. It is mapped into memory; checksums and all values are checked before they are used, and
//! the lists of meshes are used where they lie.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, for pages of octree subtrees.
//! Cost: reading is bound by memory: each byte of a mesh is read twice, once for its checksum and once to check its values.
//! Hostile input: sizes are checked against the file before anything is allocated; no value is trusted. What is built is charged
//! to the memory budget before: see the table in [`crate::budget`].

mod built;
mod coarse;
mod container;
mod hints;
mod paged;
mod pages;
mod read;
mod sections;
mod stored;
#[cfg(test)]
mod tests;
mod write;

pub use hints::{Hint, bake_hints};
pub use paged::Pages;
pub use sections::{BakedSections, SectionTotal};
pub use write::{BakeError, Baker, bake};

pub(crate) use read::{begins_like_enf, import, read};

use crate::BrokenRule;
use thiserror::Error;

impl From<EnfError> for BrokenRule {
    fn from(why: EnfError) -> BrokenRule {
        BrokenRule::Enf(why)
    }
}

/// Why a baked scene cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EnfError {
    /// It was baked by another version. Holds the version of its format.
    #[error(
        "is a baked scene of format {0}, but this version reads format {version}; bake it again",
        version = container::VERSION
    )]
    Version(u32),
    /// It was to be read as [flat](crate::ReadOptions::flat), but only the rooms are stored.
    #[error("is a baked scene, whose rooms cannot become one; bake it with --flat")]
    Flat,
    /// The file is no baked scene, but only those have pages.
    #[error("is no baked scene; bake it first (enfilade bake)")]
    NotBaked,
    /// The file is longer or shorter than it says.
    #[error("is a baked scene of {needs} bytes, but the file has {has}; copy it again, or bake it again")]
    Truncated {
        /// Expected length of the file, in bytes.
        needs: u64,
        /// Length of the file, in bytes.
        has: u64,
    },
    /// A section is missing, or its checksum is wrong. Holds its name.
    #[error("its section `{0}` is damaged; copy the file again, or bake it again")]
    Damaged(String),
    /// A section breaks a rule, though its checksum is correct.
    #[error("its section `{section}` is invalid: {rule}; bake it again")]
    Invalid {
        /// Name of the section.
        section: String,
        /// The rule that it breaks.
        rule: String,
    },
}
