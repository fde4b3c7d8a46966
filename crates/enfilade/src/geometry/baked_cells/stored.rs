//! Baked cells as serde values: rows as runs of cells, as they are kept.

use super::row::Rows;
use super::{BakedCells, BakedCellsError, CellTree, tree};
use serde::{Deserialize, Serialize};

/// What is stored of baked cells.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredCells {
    tree: CellTree,
    row_of: Vec<Option<u32>>,
    /// Number of runs of each row.
    lengths: Vec<u32>,
    /// First cell and last cell + 1 of each run.
    runs: Vec<[u32; 2]>,
}

impl From<BakedCells> for StoredCells {
    fn from(cells: BakedCells) -> StoredCells {
        let (lengths, runs) = cells.rows.into_runs();
        StoredCells {
            tree: cells.tree,
            row_of: cells.row_of,
            lengths,
            runs,
        }
    }
}

impl TryFrom<StoredCells> for BakedCells {
    type Error = BakedCellsError;

    fn try_from(stored: StoredCells) -> Result<BakedCells, BakedCellsError> {
        let StoredCells {
            mut tree,
            row_of,
            lengths,
            runs,
        } = stored;
        let cells = row_of.len();
        if cells >= u32::MAX as usize {
            return Err(BakedCellsError::TooManyCells(cells));
        }
        let depth = tree::check(&mut tree, cells)?;
        BakedCells::of(tree, depth, row_of, Rows::of_runs(&lengths, runs, cells)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{CellNode, CellSide};
    use crate::ids::CellId;

    #[test]
    fn stored_cells_are_the_same_again_and_damaged_ones_are_refused() {
        let node = CellNode {
            normal: [1.0, 2.0, 3.0],
            distance: 0.7,
            front: CellSide::Cell(CellId(0)),
            back: CellSide::Cell(CellId(1)),
        };
        let tree = CellTree {
            root: CellSide::Node(0),
            nodes: vec![node],
            tolerance: 0.1,
        };
        let rows = [vec![CellId(0), CellId(1)], vec![CellId(1)]];
        let cells = BakedCells::new(tree, &[Some(0), None], rows).expect("cells");
        let stored = || StoredCells::from(cells.clone());
        assert_eq!(BakedCells::try_from(stored()), Ok(cells.clone()));
        let refused = |change: fn(&mut StoredCells)| {
            let mut stored = stored();
            change(&mut stored);
            BakedCells::try_from(stored).is_err()
        };
        assert!(refused(|stored| stored.row_of[0] = Some(2)));
        assert!(refused(|stored| stored.runs[0] = [0, 3]));
        assert!(refused(|stored| stored.runs[0] = [1, 1]));
        assert!(refused(|stored| stored.lengths[0] = 3));
        assert!(refused(|stored| stored.lengths = vec![1]));
        assert!(refused(|stored| stored.lengths = vec![u32::MAX, 3]));
        assert!(refused(|stored| stored.tree.root = CellSide::Node(1)));
    }
}
