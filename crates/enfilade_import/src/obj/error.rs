//! Why an OBJ file is not read.

use thiserror::Error;

/// What is wrong in an OBJ file, and in which line. Lines are counted from 1; one that goes on in the next is named by
/// its first.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ObjError {
    /// A byte 0, which no text has.
    #[error("line {line} has a byte 0 in it, so this is no text; export it again, or name it for what it is")]
    NotText {
        /// Which line.
        line: usize,
    },
    /// A word that should be a number.
    #[error("line {line}: `{found}` is no number; export the file again")]
    NotANumber {
        /// Which line.
        line: usize,
        /// The word.
        found: String,
    },
    /// Too few numbers.
    #[error("line {line}: `{keyword}` needs {wants} numbers, but has {has}; export the file again")]
    FewNumbers {
        /// Which line.
        line: usize,
        /// What the line begins with.
        keyword: &'static str,
        /// How many there should be.
        wants: usize,
        /// How many there are.
        has: usize,
    },
    /// A face that names no corner.
    #[error("line {line} is a face without corners; export the file again")]
    NoCorners {
        /// Which line.
        line: usize,
    },
    /// A corner that is not of the form `1`, `1/2`, `1/2/3` or `1//3`.
    #[error(
        "line {line}: `{found}` is no corner of a face, which is POSITION, POSITION/TEXTURE, POSITION/TEXTURE/NORMAL or \
         POSITION//NORMAL, each a whole number; export the file again"
    )]
    BadCorner {
        /// Which line.
        line: usize,
        /// The corner.
        found: String,
    },
    /// A corner that names number 0.
    #[error(
        "line {line}: `{found}` names {kind} 0, but they are counted from 1, or backwards from -1; export the file again"
    )]
    NumberZero {
        /// Which line.
        line: usize,
        /// The corner.
        found: String,
        /// What it names.
        kind: &'static str,
    },
    /// A corner that names more than there is.
    #[error("line {line}: `{found}` names {kind} {number}, but the file has only {count}; export it again")]
    NoSuch {
        /// Which line.
        line: usize,
        /// The corner.
        found: String,
        /// What it names.
        kind: &'static str,
        /// Which of them.
        number: i64,
        /// How many there are.
        count: usize,
    },
    /// A corner that counts back beyond the first.
    #[error(
        "line {line}: `{found}` names {kind} {number}, but only {before} come before that line; export the file again"
    )]
    BeforeTheFirst {
        /// Which line.
        line: usize,
        /// The corner.
        found: String,
        /// What it names.
        kind: &'static str,
        /// How far back.
        number: i64,
        /// How many there are so far.
        before: usize,
    },
    /// A position that a face uses is NaN or infinite.
    #[error(
        "line {line} is a face with a corner at position {position}, which is not finite; repair the mesh and export it \
         again"
    )]
    PositionNotFinite {
        /// Which line.
        line: usize,
        /// Which position, counted from 1.
        position: usize,
    },
}
