//! Why a file of portals is not read.

use enfilade_bake::CellsError;
use thiserror::Error;

/// What is wrong in a `.prt` file, and in which line, counted from 1.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PrtError {
    /// Another kind of file.
    #[error("is not a .prt file: it {begins}, but a .prt begins with PRT1 or PRT2; compile the map again")]
    NotPrt {
        /// What it begins with: "begins with `…`", or "is empty".
        begins: String,
    },
    /// The file ends early.
    #[error("ends before {wanted}; it is cut short, so compile the map again")]
    Ends {
        /// What should follow.
        wanted: String,
    },
    /// A word that should be a number.
    #[error("line {line}: {found} is not {wanted}; compile the map again")]
    NotANumber {
        /// Which line.
        line: usize,
        /// The word in backticks, or what is there instead.
        found: String,
        /// What should be there.
        wanted: &'static str,
    },
    /// Not as many corners as the line says.
    #[error("line {line} promises {promised} corners, but has {has}; compile the map again")]
    Corners {
        /// Which line.
        line: usize,
        /// The number it begins with.
        promised: u32,
        /// How many there are.
        has: usize,
    },
    /// A portal that makes no sense.
    #[error("line {line}: {why} (both are counted from 0); correct the map there, and compile it again")]
    Portal {
        /// Which line.
        line: usize,
        /// The rule.
        why: CellsError,
    },
    /// More than the header says.
    #[error("line {line}: this is more than the {promised} that the header promises; compile the map again")]
    More {
        /// Which line.
        line: usize,
        /// What, and how many.
        promised: String,
    },
    /// A leaf that is not there, or in two clusters, or in none.
    #[error("line {line}: leaf {leaf} {why}, and there are {leafs}, counted from 0; compile the map again")]
    Leaf {
        /// Which line.
        line: usize,
        /// Which leaf.
        leaf: u32,
        /// What is wrong with it.
        why: &'static str,
        /// How many there are.
        leafs: u32,
    },
}
