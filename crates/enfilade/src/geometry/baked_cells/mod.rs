//! Baked PVS: a BSP tree whose leaves are cells, and for each cell the cells potentially visible from it.
//!
//! If nothing in one cell can see anything in another, the items there are culled without a test. Level compilers
//! produce such cells; `enfilade_bake` computes them for convex rooms.
//! Source: Teller, Séquin, Visibility Preprocessing for Interactive Walkthroughs, SIGGRAPH 1991; Abrash, Graphics
//!     Programming Black Book, chapter 64.
//! Cost: a row stores a range of cell numbers per run of visible cells; finding a cell takes O(depth) plane tests.
//! Conservative if the rows are: they are not verified, and are valid while the walls that they were computed from
//! exist.

mod error;
mod row;
#[cfg(feature = "serde")]
mod stored;
#[cfg(test)]
mod tests;
mod tree;

pub use error::BakedCellsError;
pub(crate) use tree::{Leaf, Room};

use crate::geom::Aabb;
use crate::ids::CellId;
use glam::DVec3;
use row::Rows;

/// A child of a BSP node: what is on one side of its plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CellSide {
    /// Another node, by its index in [`CellTree::nodes`].
    Node(u32),
    /// A cell; a cell may have several leaves.
    Cell(CellId),
    /// No cell: solid or outside. Nothing in it is visible from a cell, because the faces of walls are in front of it.
    Solid,
}

/// A node of a BSP tree: a plane that splits space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellNode {
    /// Normal of the plane, of any length above zero, in the space of the sector.
    pub normal: [f64; 3],
    /// Points with `normal · point >= distance` are in front.
    pub distance: f64,
    /// The child in front of the plane.
    pub front: CellSide,
    /// The child behind the plane.
    pub back: CellSide,
}

/// A BSP tree that splits the space of a sector into cells.
#[doc(alias = "BSP")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellTree {
    /// The root: usually node 0, or a cell that fills all of space.
    pub root: CellSide,
    /// The nodes, in any order. Each must be reached at most once from the root; unreachable nodes are ignored.
    pub nodes: Vec<CellNode>,
    /// Maximum distance of faces and openings from the plane that they are meant to be in, in scene units, 0 or more;
    /// f32 rounding is allowed for in addition. A larger value puts walls into the cells on both sides of them, so more
    /// is visible; never less.
    pub tolerance: f64,
}

/// Baked PVS cells, for [`Method::Pvs`](crate::Method::Pvs); passed to
/// [`GeometryBuilder::cells`](crate::GeometryBuilder::cells).
///
/// ```
/// use enfilade::{BakedCells, CellId, CellNode, CellSide, CellTree};
/// // Two rooms with an opaque wall between them, in the plane x = 0.
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
/// assert!(!cells.may_see(east, west));
/// # Ok::<(), enfilade::BakedCellsError>(())
/// ```
#[doc(alias = "PVS")]
#[doc(alias = "potentially visible set")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "stored::StoredCells", into = "stored::StoredCells")
)]
pub struct BakedCells {
    tree: CellTree,
    /// Row of each cell; `None`: all cells are visible from it.
    row_of: Vec<Option<u32>>,
    rows: Rows,
    depth: u32,
}

impl BakedCells {
    /// Checks the BSP tree and the visibility rows.
    ///
    /// A row is a set of cells, in any order. `row_of[cell]` is the index in `rows` of the cells that may be visible
    /// from anywhere in `cell`, including its boundary; `None` means that all cells may be visible. Cells can share a
    /// row, as the cells of a cluster do. A cell always sees itself, whether or not its row contains it.
    ///
    /// # Errors
    /// Returns the [`BakedCellsError`] of the first invalid element.
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
        BakedCells::of(tree, depth, row_of.to_vec(), Rows::new(rows, cells)?)
    }

    /// Checks the row of each cell.
    fn of(
        tree: CellTree,
        depth: u32,
        row_of: Vec<Option<u32>>,
        rows: Rows,
    ) -> Result<BakedCells, BakedCellsError> {
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
            row_of,
            rows,
            depth,
        })
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> usize {
        self.row_of.len()
    }

    /// Returns the BSP tree, with unit normals.
    pub fn tree(&self) -> &CellTree {
        &self.tree
    }

    /// Returns the depth of the BSP tree: the number of nodes on the longest path to a leaf.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Returns the cell that contains a point; `None` in solid space. Points in a plane count as in front of it.
    pub fn cell_at(&self, point: [f64; 3]) -> Option<CellId> {
        match tree::leaf_at(&self.tree, DVec3::from(point)) {
            Leaf::Cell(cell) => Some(cell),
            Leaf::Solid { .. } => None,
        }
    }

    /// Returns `true` if anything in cell `to` may be visible from cell `from`.
    ///
    /// # Panics
    /// If `from` is out of range.
    pub fn may_see(&self, from: CellId, to: CellId) -> bool {
        from == to || self.row(from).is_none_or(|row| self.rows.has(row, to.0))
    }

    /// Returns the memory used, in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.tree.nodes) + size_of_val(&*self.row_of)) as u64 + self.rows.bytes()
    }

    /// Returns the cells that may be visible from a cell, as ranges of their numbers (first, last + 1); `None` if all
    /// may be. The cell itself may be missing.
    pub(crate) fn seen_from(&self, cell: CellId) -> Option<&[[u32; 2]]> {
        self.row(cell).map(|row| self.rows.get(row))
    }

    fn row(&self, cell: CellId) -> Option<u32> {
        self.row_of[cell.0 as usize]
    }

    /// Returns the deepest subtree that contains all leaves that a box overlaps: a leaf or a node.
    pub(crate) fn around(&self, bounds: &Aabb) -> CellSide {
        tree::around(&self.tree, bounds)
    }

    /// Calls `each` with the leaves below `side` that a polygon may overlap; returns `false` if `each` stopped the
    /// traversal or a coordinate is not finite.
    pub(crate) fn touched(&self, side: CellSide, room: &mut Room, each: impl FnMut(Leaf) -> bool) -> bool {
        tree::touched(&self.tree, side, room, each)
    }
}
