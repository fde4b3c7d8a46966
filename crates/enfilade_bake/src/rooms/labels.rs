//! Labels of a grid of voxels as runs: finds the room at a point in tens of nanoseconds.
//!
//! Rows of voxels with the same runs, as most rows above each other have, are stored once.
//! Cost: O(log runs of a row) for a point.

use super::grid::Grid;
use super::slice::NONE;
use std::collections::HashMap;

/// The room of each voxel, by runs along x.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LabelGrid {
    pub(super) grid: Grid,
    /// The pattern of each row, slice by slice.
    pub(super) rows: Vec<u32>,
    /// First run of each pattern, and the number of runs.
    pub(super) firsts: Vec<u32>,
    /// End column (exclusive) and room of each run.
    pub(super) runs: Vec<[u32; 2]>,
}

impl LabelGrid {
    pub(super) fn new(grid: &Grid, labels: &[u32]) -> LabelGrid {
        let mut compact = LabelGrid {
            grid: *grid,
            rows: Vec::with_capacity(grid.size[1] * grid.size[2]),
            firsts: vec![0],
            runs: Vec::new(),
        };
        let mut patterns: HashMap<Vec<[u32; 2]>, u32> = HashMap::new();
        for row in labels.chunks(grid.size[0]) {
            let mut runs: Vec<[u32; 2]> = Vec::new();
            for (column, &label) in row.iter().enumerate() {
                match runs.last_mut() {
                    Some([end, room]) if *room == label => *end = column as u32 + 1,
                    _ => runs.push([column as u32 + 1, label]),
                }
            }
            let next = patterns.len() as u32;
            let pattern = *patterns.entry(runs).or_insert_with_key(|runs| {
                compact.runs.extend(runs);
                compact.firsts.push(compact.runs.len() as u32);
                next
            });
            compact.rows.push(pattern);
        }
        compact
    }

    /// Returns the room at a point in metres; `None` outside the grid, for NaN, or if there is none.
    pub(super) fn room_at(&self, point: [f64; 3]) -> Option<u32> {
        let [x, y, z] = self.grid.cell_at(point)?;
        let pattern = self.rows[y * self.grid.size[2] + z] as usize;
        let runs = &self.runs[self.firsts[pattern] as usize..self.firsts[pattern + 1] as usize];
        let run = runs.partition_point(|&[end, _]| end as usize <= x);
        let [_, room] = *runs.get(run)?;
        (room != NONE).then_some(room)
    }

    /// Returns the memory in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.rows) + size_of_val(&*self.firsts) + size_of_val(&*self.runs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_the_label_of_every_voxel() {
        let grid = Grid {
            size: [7, 5, 6],
            origin: [-1.0, 2.0, 0.5],
            step: 0.25,
        };
        let mut random = fastrand::Rng::with_seed(1);
        let labels: Vec<u32> = (0..grid.len())
            .map(|_| if random.u8(..) < 30 { NONE } else { random.u32(..3) })
            .collect();
        let compact = LabelGrid::new(&grid, &labels);
        for (voxel, &label) in labels.iter().enumerate() {
            assert_eq!(compact.room_at(grid.center(voxel)).unwrap_or(NONE), label);
        }
        for outside in [[-1.1, 2.1, 0.6], [0.0, 3.3, 0.6], [f64::NAN, 2.1, 0.6]] {
            assert_eq!(compact.room_at(outside), None);
        }
    }
}
