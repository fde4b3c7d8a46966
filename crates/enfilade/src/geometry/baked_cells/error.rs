//! Why planes and rows make no cells.

use thiserror::Error;

/// Why planes and rows make no cells.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BakedCellsError {
    /// A plane has a normal of no length, or numbers that are NaN or infinite.
    #[error("the plane of node {0} must have finite numbers, and a normal that is not zero")]
    BadPlane(usize),
    /// The tolerance is negative, NaN or infinite.
    #[error("a tolerance of {0}; it must be 0 or more, and finite")]
    Tolerance(f64),
    /// A side names a node that is not there.
    #[error("{} node {node}, but there are only {nodes}", on_a_side(*.of, *.front))]
    NoSuchNode {
        /// The node on whose side it is named; `None`: the root.
        of: Option<u32>,
        /// In front, or behind?
        front: bool,
        /// The node it names.
        node: u32,
        /// How many there are.
        nodes: usize,
    },
    /// A side names a cell that is not there.
    #[error("{} cell {cell}, but there are only {cells}", on_a_side(*.of, *.front))]
    NoSuchCell {
        /// The node on whose side it is named; `None`: the root.
        of: Option<u32>,
        /// In front, or behind?
        front: bool,
        /// The cell it names.
        cell: u32,
        /// How many there are.
        cells: usize,
    },
    /// Two sides name one node, or a node is below itself.
    #[error("node {0} is reached on two ways from the root; nodes must form a tree")]
    NoTree(u32),
    /// A cell has a row that is not there.
    #[error("cell {cell} has row {row}, but there are only {rows}")]
    NoSuchRow {
        /// Which cell.
        cell: usize,
        /// The row it names.
        row: u32,
        /// How many there are.
        rows: usize,
    },
    /// A row names a cell that is not there.
    #[error("row {row} names cell {cell}, but there are only {cells}")]
    NoSuchCellInRow {
        /// Which row.
        row: usize,
        /// The cell it names.
        cell: u32,
        /// How many there are.
        cells: usize,
    },
    /// Cells are numbered with 32 bits.
    #[error("{0} cells; have clusters of them share one cell, fewer than 4 billion in all")]
    TooManyCells(usize),
    /// Rows are kept as runs, which are numbered with 32 bits.
    #[error("the rows up to row {0} are more than 4 billion runs of cells; have cells share rows")]
    TooManyRuns(usize),
}

fn on_a_side(of: Option<u32>, front: bool) -> String {
    match (of, front) {
        (None, _) => "the root is".to_owned(),
        (Some(node), true) => format!("in front of node {node} is"),
        (Some(node), false) => format!("behind node {node} is"),
    }
}
