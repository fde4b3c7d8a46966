//! Errors of baked cells.

use thiserror::Error;

/// Why baked cells are invalid; returned by [`BakedCells::new`](super::BakedCells::new).
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BakedCellsError {
    /// The normal of a plane is zero, or a number of the plane is NaN or infinite.
    #[error("the plane of node {0} must have finite numbers, and a normal that is not zero")]
    BadPlane(usize),
    /// The tolerance is negative, NaN or infinite.
    #[error("a tolerance of {0}; it must be 0 or more, and finite")]
    Tolerance(f64),
    /// A node refers to a child node that does not exist.
    #[error("{} node {node}, but there are only {nodes}", on_a_side(*.of, *.front))]
    NoSuchNode {
        /// The parent; `None` for the root.
        of: Option<u32>,
        /// Whether the child is on the front side.
        front: bool,
        /// Index of the child.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// A node refers to a cell that does not exist.
    #[error("{} cell {cell}, but there are only {cells}", on_a_side(*.of, *.front))]
    NoSuchCell {
        /// The parent; `None` for the root.
        of: Option<u32>,
        /// Whether the cell is on the front side.
        front: bool,
        /// Index of the cell.
        cell: u32,
        /// Number of cells.
        cells: usize,
    },
    /// A node has two parents, or is its own descendant.
    #[error("node {0} is reached by two paths from the root; nodes must form a tree")]
    NoTree(u32),
    /// A cell refers to a row that does not exist.
    #[error("cell {cell} has row {row}, but there are only {rows}")]
    NoSuchRow {
        /// Index of the cell.
        cell: usize,
        /// Index of the row.
        row: u32,
        /// Number of rows.
        rows: usize,
    },
    /// A row refers to a cell that does not exist.
    #[error("row {row} names cell {cell}, but there are only {cells}")]
    NoSuchCellInRow {
        /// Index of the row.
        row: usize,
        /// Index of the cell.
        cell: u32,
        /// Number of cells.
        cells: usize,
    },
    /// There are too many cells; cells have 32-bit numbers.
    #[error("{0} cells; merge some of them until there are fewer than 4 billion")]
    TooManyCells(usize),
    /// The rows have too many runs of cells; runs have 32-bit numbers. Holds the row that exceeds the limit.
    #[error("the rows up to row {0} have more than 4 billion runs of cells; let cells share rows")]
    TooManyRuns(usize),
    /// The runs of a stored row are empty, out of order, or not as many as it says. Holds the row.
    #[error("the stored runs of row {0} are damaged")]
    BadRuns(usize),
}

fn on_a_side(of: Option<u32>, front: bool) -> String {
    match (of, front) {
        (None, _) => "the root is".to_owned(),
        (Some(node), true) => format!("in front of node {node} is"),
        (Some(node), false) => format!("behind node {node} is"),
    }
}
