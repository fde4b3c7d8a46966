//! Cells computed ahead: a tree of planes whose leaves are cells, and for each cell the cells that may be seen from it.
//!
//! What is behind walls of another cell need not be looked for where it is known that nothing in one cell sees anything in
//! the other. Cells are as compilers of levels leave them, or as a baker makes them of convex rooms.
//! Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991; Abrash, Graphics
//!     Programming Black Book, chapter 64.
//! Cost: a row takes a stretch of numbers for each run of neighbouring cells; to find a cell, O(depth) planes.
//! The rows are believed: what they leave out is hidden for as long as the walls stand that they were computed from.

mod error;
mod row;
#[cfg(test)]
mod tests;
mod tree;

pub use error::BakedCellsError;
pub(crate) use tree::{Leaf, Room};

use crate::geom::Aabb;
use glam::DVec3;
use row::Rows;

/// A cell, by its place in the list of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellId(pub u32);

/// What lies on one side of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellSide {
    /// Another plane, by its place in [`CellTree::nodes`].
    Node(u32),
    /// A cell, which may have many leaves.
    Cell(CellId),
    /// No cell: solid, or outside. Nothing in it is seen from a cell, for the faces of walls lie before it.
    Solid,
}

/// A plane that parts space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellNode {
    /// Across the plane, of any length but zero, in the space of the sector.
    pub normal: [f64; 3],
    /// In front is where `normal · point >= distance`.
    pub distance: f64,
    /// What lies in front.
    pub front: CellSide,
    /// What lies behind.
    pub back: CellSide,
}

/// Planes that part the space of a sector into cells.
#[derive(Clone, Debug, PartialEq)]
pub struct CellTree {
    /// Where to begin: node 0 as a rule, or a cell that is all of space.
    pub root: CellSide,
    /// The planes, in any order. Each is reached once at most; those that are not reached do no harm.
    pub nodes: Vec<CellNode>,
    /// How far, in scene units, faces and openings that are meant to lie in a plane may be off it; 0 or more. What f32
    /// loses is allowed for anyway. More makes walls stand in the cells on both of their sides, never fewer things seen.
    pub tolerance: f64,
}

/// Cells computed ahead, for [`Method::Pvs`](crate::Method::Pvs): given to a geometry by
/// [`GeometryBuilder::cells`](crate::GeometryBuilder::cells).
///
/// ```
/// use enfilade::{BakedCells, CellId, CellNode, CellSide, CellTree};
/// // Two rooms with a wall between them that no one sees through: the plane x = 0.
/// let [west, east] = [CellId(0), CellId(1)];
/// let wall = CellNode {
///     normal: [1.0, 0.0, 0.0],
///     distance: 0.0,
///     front: CellSide::Cell(east),
///     back: CellSide::Cell(west),
/// };
/// let tree = CellTree { root: CellSide::Node(0), nodes: vec![wall], tolerance: 0.0 };
/// let cells = BakedCells::new(tree, &[Some(0), Some(1)], [[west], [east]])?;
/// assert_eq!(cells.cell_at([3.0, 1.0, 0.0]), Some(east));
/// assert!(!cells.sees(east, west));
/// # Ok::<(), enfilade::BakedCellsError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BakedCells {
    tree: CellTree,
    /// By cell: its row, or everything.
    row_of: Vec<Option<u32>>,
    rows: Rows,
    depth: u32,
}

impl BakedCells {
    /// Checks the tree and the rows.
    ///
    /// `row_of` says, for each cell, which of `rows` tells what may be seen from anywhere in it, its border included: many
    /// cells may share a row, as those of a cluster do. From a cell without one, everything may be seen. A row names cells
    /// in any order; its own cell is meant also where it is not named.
    ///
    /// # Errors
    /// One [`BakedCellsError`] for the first broken rule.
    pub fn new<Row: IntoIterator<Item = CellId>>(
        mut tree: CellTree,
        row_of: &[Option<u32>],
        rows: impl IntoIterator<Item = Row>,
    ) -> Result<BakedCells, BakedCellsError> {
        let cells = row_of.len();
        if cells >= u32::MAX as usize {
            return Err(BakedCellsError::TooManyCells(cells));
        }
        let depth = tree::check(&mut tree, cells)?;
        let rows = Rows::new(rows, cells)?;
        for (cell, row) in row_of.iter().enumerate() {
            if let Some(row) = row.filter(|&row| row as usize >= rows.count()) {
                return Err(BakedCellsError::NoSuchRow {
                    cell,
                    row,
                    rows: rows.count(),
                });
            }
        }
        Ok(BakedCells {
            tree,
            row_of: row_of.to_vec(),
            rows,
            depth,
        })
    }

    /// How many cells there are.
    pub fn cell_count(&self) -> usize {
        self.row_of.len()
    }

    /// The planes that part space, their normals of unit length.
    pub fn tree(&self) -> &CellTree {
        &self.tree
    }

    /// The planes on the longest way to a leaf.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The cell that a point is in; `None` where there is none. Points in a plane are in front of it.
    pub fn cell_at(&self, point: [f64; 3]) -> Option<CellId> {
        match tree::leaf_at(&self.tree, DVec3::from(point)) {
            Leaf::Cell(cell) => Some(cell),
            Leaf::Solid { .. } => None,
        }
    }

    /// May anything in one cell see anything in the other?
    pub fn sees(&self, from: CellId, to: CellId) -> bool {
        from == to || self.row(from).is_none_or(|row| self.rows.has(row, to.0))
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.tree.nodes) + size_of_val(&*self.row_of)) as u64 + self.rows.bytes()
    }

    /// The cells that may be seen from one, as stretches of their numbers, first and after the last; `None` where that is
    /// everything. The cell itself may not be among them.
    pub(crate) fn seen_from(&self, cell: CellId) -> Option<&[[u32; 2]]> {
        self.row(cell).map(|row| self.rows.get(row))
    }

    fn row(&self, cell: CellId) -> Option<u32> {
        self.row_of[cell.0 as usize]
    }

    /// What is all that a box can reach into: a leaf or a plane.
    pub(crate) fn around(&self, bounds: &Aabb) -> CellSide {
        tree::around(&self.tree, bounds)
    }

    /// Tells the leaves that something of a polygon may be in, from `side` down; `false` where that is given up.
    pub(crate) fn touched(&self, side: CellSide, room: &mut Room, each: impl FnMut(Leaf) -> bool) -> bool {
        tree::touched(&self.tree, side, room, each)
    }
}
