//! The baked PVS: which cells can see each other through portals.

use crate::bits::{BitRows, ones};
use crate::cells::Cells;
use crate::work::{PairsWork, Stage, TooLarge};

/// Options of [`VisiblePairs::compute`].
#[derive(Clone, Copy, Debug)]
pub struct PairsOptions {
    /// Stops after the fixpoint over passages and the ray sampling, without the recursive portal flow. Two to eight
    /// times faster; returns 10 % to 100 % more pairs.
    pub fast: bool,
    /// Maximum memory of the computation, in bytes.
    pub limit_bytes: u64,
}

impl Default for PairsOptions {
    /// All stages, up to 4 GiB, which suffices for the largest compiled maps.
    fn default() -> PairsOptions {
        PairsOptions {
            fast: false,
            limit_bytes: 1 << 32,
        }
    }
}

/// Potentially visible set (PVS) of cells: the pairs in which some point of one cell may see some point of the other.
///
/// An upper bound: no visible pair is missing. Visibility is symmetric, so the pairs are too. Each cell sees itself and
/// its neighbours.
#[doc(alias("PVS", "vis"))]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VisiblePairs {
    cells: BitRows,
    proven: usize,
}

impl VisiblePairs {
    /// Computes the PVS on all threads of rayon's pool. The result does not depend on the number of threads.
    ///
    /// [`PairsWork`] computes the same in steps, for progress reports and interruption.
    ///
    /// # Errors
    /// [`TooLarge`] if the computation could exceed [`PairsOptions::limit_bytes`]. This is checked before anything is
    /// allocated, because a small file may declare four billion cells, whose pairs would need that number squared.
    pub fn compute(cells: &Cells, options: &PairsOptions) -> Result<VisiblePairs, TooLarge> {
        let mut work = PairsWork::begin(cells, options.limit_bytes)?;
        let end = if options.fast {
            Stage::Sampling
        } else {
            Stage::Done
        };
        while work.stage() < end {
            work.step();
        }
        Ok(work.pairs())
    }

    pub(crate) fn new(cells: BitRows, proven: usize) -> VisiblePairs {
        VisiblePairs { cells, proven }
    }

    /// Returns the number of cells.
    pub fn cell_count(&self) -> u32 {
        self.cells.rows() as u32
    }

    /// Returns `true` if some point of one cell may see some point of the other. Both are below
    /// [`VisiblePairs::cell_count`].
    pub fn may_see(&self, from: u32, to: u32) -> bool {
        self.cells.has(from as usize, to as usize)
    }

    /// Returns the cells potentially visible from `cell`, including itself, in ascending order.
    pub fn seen_from(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        ones(self.cells.row(cell as usize)).map(|cell| cell as u32)
    }

    /// Returns the number of pairs of different cells that may see each other; each pair counts twice, once per
    /// direction.
    pub fn count(&self) -> usize {
        self.cells.count() - self.cells.rows()
    }

    /// Returns how many pairs of [`VisiblePairs::count`] are proven visible by a sampled ray. Neighbours count as
    /// proven.
    pub fn proven(&self) -> usize {
        self.proven
    }
}
