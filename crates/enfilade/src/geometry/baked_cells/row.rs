//! Sets of cells as runs of cell numbers. Visible cells form runs because compilers number neighbouring cells in
//! sequence.

use super::BakedCellsError;
use crate::ids::CellId;

/// Sets of cells, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rows {
    /// Start of each row in `runs`, and the end of the last.
    starts: Vec<u32>,
    /// First cell and last cell + 1, ascending.
    runs: Vec<[u32; 2]>,
}

impl Rows {
    pub(super) fn new<Row: IntoIterator<Item = CellId>>(
        rows: impl IntoIterator<Item = Row>,
        cells: usize,
    ) -> Result<Rows, BakedCellsError> {
        let mut built = Rows {
            starts: vec![0],
            runs: Vec::new(),
        };
        let mut named = Vec::new();
        for (row, seen) in rows.into_iter().enumerate() {
            named.clear();
            named.extend(seen.into_iter().map(|CellId(cell)| cell));
            named.sort_unstable();
            if let Some(&cell) = named.last().filter(|&&cell| cell as usize >= cells) {
                return Err(BakedCellsError::NoSuchCellInRow { row, cell, cells });
            }
            let first = built.runs.len();
            for &cell in &named {
                match built.runs[first..].last_mut() {
                    Some(run) if cell <= run[1] => run[1] = run[1].max(cell + 1),
                    _ => built.runs.push([cell, cell + 1]),
                }
            }
            let end = u32::try_from(built.runs.len()).map_err(|_| BakedCellsError::TooManyRuns(row))?;
            built.starts.push(end);
        }
        built.runs.shrink_to_fit();
        Ok(built)
    }

    pub(super) fn count(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn get(&self, row: u32) -> &[[u32; 2]] {
        let [start, end] = [0, 1].map(|next| self.starts[row as usize + next] as usize);
        &self.runs[start..end]
    }

    pub(super) fn has(&self, row: u32, cell: u32) -> bool {
        let runs = self.get(row);
        let after = runs.partition_point(|run| run[0] <= cell);
        after > 0 && cell < runs[after - 1][1]
    }

    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(&*self.starts) + size_of_val(&*self.runs)) as u64
    }
}
