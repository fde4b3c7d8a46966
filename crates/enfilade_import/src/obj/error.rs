//! Errors of reading an OBJ file.

use thiserror::Error;

/// The rule that an OBJ file violates. Lines are counted from 1; a continued line is named by its first.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ObjError {
    /// The file contains a NUL byte, so it is not text.
    #[error(
        "line {line} has a byte 0 in it, so this is not text; export it again, or give it its proper extension"
    )]
    NotText {
        /// The line.
        line: usize,
    },
    /// A word is not a number.
    #[error("line {line}: `{found}` is not a number; export the file again")]
    NotANumber {
        /// The line.
        line: usize,
        /// The word.
        found: String,
    },
    /// A statement has too few numbers.
    #[error("line {line}: `{keyword}` needs {wants} numbers, but has {has}; export the file again")]
    FewNumbers {
        /// The line.
        line: usize,
        /// The keyword of the statement.
        keyword: &'static str,
        /// Required numbers.
        wants: usize,
        /// Available numbers.
        has: usize,
    },
    /// A face has no corners.
    #[error("line {line} is a face without corners; export the file again")]
    NoCorners {
        /// The line.
        line: usize,
    },
    /// A corner does not have the form `1`, `1/2`, `1/2/3` or `1//3`.
    #[error(
        "line {line}: `{found}` is not a face corner, which is POSITION, POSITION/TEXTURE, POSITION/TEXTURE/NORMAL or \
         POSITION//NORMAL, each an integer; export the file again"
    )]
    BadCorner {
        /// The line.
        line: usize,
        /// The corner.
        found: String,
    },
    /// A corner has index 0.
    #[error(
        "line {line}: `{found}` names {kind} 0, but they are counted from 1, or backwards from -1; export the file again"
    )]
    NumberZero {
        /// The line.
        line: usize,
        /// The corner.
        found: String,
        /// Kind of the element.
        kind: &'static str,
    },
    /// A corner has an index that is too large.
    #[error("line {line}: `{found}` names {kind} {number}, but the file has only {count}; export it again")]
    NoSuch {
        /// The line.
        line: usize,
        /// The corner.
        found: String,
        /// Kind of the element.
        kind: &'static str,
        /// The index.
        number: i64,
        /// Number of elements of that kind.
        count: usize,
    },
    /// A corner has a relative index that reaches before the first element.
    #[error(
        "line {line}: `{found}` names {kind} {number}, but only {before} come before that line; export the file again"
    )]
    BeforeTheFirst {
        /// The line.
        line: usize,
        /// The corner.
        found: String,
        /// Kind of the element.
        kind: &'static str,
        /// The relative index.
        number: i64,
        /// Number of elements before that line.
        before: usize,
    },
    /// A vertex position that a face uses is NaN or infinite.
    #[error(
        "line {line} is a face with a corner at position {position}, which is not finite; repair the mesh and export it \
         again"
    )]
    PositionNotFinite {
        /// The line.
        line: usize,
        /// Index of the position, from 1.
        position: usize,
    },
}
