//! Which cells see each other, through portals.

use crate::bits::{BitRows, ones};
use crate::cells::Cells;
use crate::work::{PairsWork, Stage, TooLarge};

/// How [`VisiblePairs::compute`] works.
#[derive(Clone, Copy, Debug)]
pub struct PairsOptions {
    /// Stops at the bound that passages give: two to eight times as fast, and a tenth more pairs to twice as many.
    pub fast: bool,
    /// Maximum memory to take, in bytes.
    pub limit_bytes: u64,
}

impl Default for PairsOptions {
    /// All stages, in up to 4 GiB: enough for the largest compiled maps.
    fn default() -> PairsOptions {
        PairsOptions {
            fast: false,
            limit_bytes: 1 << 32,
        }
    }
}

/// Which cells may see each other, from anywhere in the one to anywhere in the other: never less than do.
///
/// Sight has no direction, so the pairs are symmetric; each cell sees itself and its neighbours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VisiblePairs {
    cells: BitRows,
    proven: usize,
}

impl VisiblePairs {
    /// Computes them on all threads of rayon's pool; the same pairs for any number of threads.
    ///
    /// [`PairsWork`] does the same in steps, so that it can be watched and stopped.
    ///
    /// # Errors
    /// [`TooLarge`] where that would take more than [`PairsOptions::limit_bytes`], before any of it is taken: a few cells
    /// and portals in a file are enough to ask for the square of four billion.
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

    /// How many cells there are.
    pub fn cell_count(&self) -> u32 {
        self.cells.rows() as u32
    }

    /// Whether anything in one cell may see anything in the other; both are below [`VisiblePairs::cell_count`].
    pub fn sees(&self, from: u32, to: u32) -> bool {
        self.cells.has(from as usize, to as usize)
    }

    /// The cells that one may see, itself among them, rising.
    pub fn seen_from(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        ones(self.cells.row(cell as usize)).map(|cell| cell as u32)
    }

    /// How many pairs of cells see each other, each counted both ways, cells with themselves not.
    pub fn count(&self) -> usize {
        self.cells.count() - self.cells.rows()
    }

    /// How many of those a sampled line has shown to be real, neighbours with them.
    pub fn proven(&self) -> usize {
        self.proven
    }
}
