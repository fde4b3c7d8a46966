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

    /// Returns the number of runs of each row, and all runs.
    #[cfg(feature = "serde")]
    pub(super) fn into_runs(self) -> (Vec<u32>, Vec<[u32; 2]>) {
        let lengths = self.starts.windows(2).map(|ends| ends[1] - ends[0]);
        (lengths.collect(), self.runs)
    }

    /// Returns the rows that [`Rows::into_runs`] took apart, checked.
    #[cfg(feature = "serde")]
    pub(super) fn of_runs(
        lengths: &[u32],
        runs: Vec<[u32; 2]>,
        cells: usize,
    ) -> Result<Rows, BakedCellsError> {
        let mut starts = vec![0_usize];
        for (row, &length) in lengths.iter().enumerate() {
            let start = starts[row];
            let end = start.saturating_add(length as usize);
            let of_row = runs.get(start..end).ok_or(BakedCellsError::BadRuns(row))?;
            let is_sound = of_row.iter().all(|run| run[0] < run[1])
                && of_row.windows(2).all(|pair| pair[0][1] < pair[1][0]);
            if !is_sound {
                return Err(BakedCellsError::BadRuns(row));
            }
            if let Some(&[_, end]) = of_row.last().filter(|run| run[1] as usize > cells) {
                let cell = end - 1;
                return Err(BakedCellsError::NoSuchCellInRow { row, cell, cells });
            }
            starts.push(end);
        }
        if starts[lengths.len()] != runs.len() {
            return Err(BakedCellsError::BadRuns(lengths.len()));
        }
        let too_many = BakedCellsError::TooManyRuns(lengths.len());
        let starts = starts.into_iter().map(u32::try_from).collect::<Result<_, _>>();
        Ok(Rows {
            starts: starts.map_err(|_| too_many)?,
            runs,
        })
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
