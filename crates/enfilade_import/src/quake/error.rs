//! Errors of reading a portal file.

use enfilade_bake::CellsError;
use thiserror::Error;

/// The rule that a `.prt` file violates. Lines are counted from 1.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PrtError {
    /// The file is not a `.prt`.
    #[error("is not a .prt file: it {begins}, but a .prt begins with PRT1 or PRT2; compile the map again")]
    NotPrt {
        /// First bytes of the file: "begins with `…`", or "is empty".
        begins: String,
    },
    /// The file is truncated.
    #[error("ends before {wanted}; it is truncated, so compile the map again")]
    Ends {
        /// The element that should follow.
        wanted: String,
    },
    /// A word is not the expected number or parenthesis.
    #[error("line {line}: {found} is not {wanted}; compile the map again")]
    NotANumber {
        /// The line.
        line: usize,
        /// The word in backticks, or "the end of the line".
        found: String,
        /// The element that is expected.
        wanted: &'static str,
    },
    /// The corner count of a line does not match its corners.
    #[error("line {line} promises {promised} corners, but has {has}; compile the map again")]
    Corners {
        /// The line.
        line: usize,
        /// The count at the start of the line.
        promised: u32,
        /// The number of corners in the line.
        has: usize,
    },
    /// A portal is invalid.
    #[error("line {line}: {why} (both are counted from 0); correct the map there, and compile it again")]
    Portal {
        /// The line.
        line: usize,
        /// The violated rule.
        why: CellsError,
    },
    /// The file has more lines than its header says.
    #[error("line {line}: the header promises only {promised}; compile the map again")]
    More {
        /// The first surplus line.
        line: usize,
        /// The counts in the header.
        promised: String,
    },
    /// A leaf does not exist, or is in two clusters, or in none.
    #[error("line {line}: leaf {leaf} {why}, and there are {leafs}, counted from 0; compile the map again")]
    Leaf {
        /// The line.
        line: usize,
        /// The leaf.
        leaf: u32,
        /// The violated rule.
        why: &'static str,
        /// Number of leafs.
        leafs: u32,
    },
}
