//! Lower bound: pairs of cells that sampled rays have proven visible.

use crate::bits::{BitRows, has, take};
use crate::line::{crosses, walk};
use crate::random::Random;
use crate::ways::Ways;
use glam::DVec3;
use rayon::prelude::*;

/// Pairs of cells proven visible.
#[derive(Clone, Debug)]
pub(crate) struct LowerBound {
    /// For each cell, the cells that a ray from it reaches, its neighbours, and itself.
    pub(crate) cells: BitRows,
}

/// Number of ways that sample in one step, independent of each other's rays.
pub(crate) const SIDE_BY_SIDE: usize = 64;

/// Number of consecutive misses after which the flow decides the rest faster. On real maps it is seldom reached; in a
/// grid of 6,400 rooms nearly all of 100 million rays miss.
const MAX_MISSES: usize = 1000;

impl LowerBound {
    /// Creates the bound without samples: each cell sees itself and its neighbours.
    pub(crate) fn new(ways: &Ways) -> LowerBound {
        let mut cells = BitRows::new(ways.cells(), ways.cells());
        for cell in 0..ways.cells() {
            cells.put(cell, cell);
        }
        for way in &ways.all {
            cells.put(way.from as usize, way.to as usize);
        }
        LowerBound { cells }
    }

    /// Samples from the [`SIDE_BY_SIDE`] ways from `first` on: a ray from each to each way in its upper bound whose
    /// pair of cells is not proven yet. A way stops after [`MAX_MISSES`] consecutive misses.
    ///
    /// The rays do not depend on the number of threads.
    pub(crate) fn sample(&mut self, ways: &Ways, bound: &BitRows, first: usize) {
        let some = first..ways.count().min(first + SIDE_BY_SIDE);
        let found: Vec<Vec<Vec<u32>>> = some
            .into_par_iter()
            .map(|way| self.lines_from(ways, bound, way))
            .collect();
        for line in found.into_iter().flatten() {
            self.add_line(ways, &line);
        }
    }

    fn lines_from(&self, ways: &Ways, bound: &BitRows, from: usize) -> Vec<Vec<u32>> {
        let mut random = Random::new(from as u64);
        let mut found = Vec::new();
        let mut undecided = bound.row(from).to_vec();
        self.take_known(ways, from, &mut undecided);
        let mut missed_in_a_row = 0;
        for at in 0..undecided.len() {
            while undecided[at] != 0 {
                let to = at * 64 + undecided[at].trailing_zeros() as usize;
                undecided[at] &= undecided[at] - 1;
                let start = random.point_in(&ways.all[from].corners);
                let end = random.point_in(&ways.all[to].corners);
                missed_in_a_row += 1;
                if let Some(line) = line_through(ways, from, start, end) {
                    if line.contains(&(to as u32)) {
                        missed_in_a_row = 0;
                    }
                    take_line(ways, from, &line, &mut undecided);
                    found.push(line);
                }
                if missed_in_a_row == MAX_MISSES {
                    return found;
                }
            }
        }
        found
    }

    /// Clears the ways that need no further test from `from`: those into cells proven visible from its cell.
    pub(crate) fn take_known(&self, ways: &Ways, from: usize, undecided: &mut [u64]) {
        let seen = self.cells.row(ways.all[from].from as usize);
        for at in 0..undecided.len() {
            let mut rest = undecided[at];
            while rest != 0 {
                let number = at * 64 + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if has(seen, ways.all[number].to as usize) {
                    take(undecided, number);
                }
            }
        }
    }

    /// Adds all pairs of another bound on the same cells.
    pub(crate) fn add(&mut self, other: &LowerBound) {
        for (word, more) in self.cells.rows_mut().iter_mut().zip(other.cells.words()) {
            *word |= more;
        }
    }

    /// Marks all pairs of cells along a ray as visible, in both directions.
    pub(crate) fn add_line(&mut self, ways: &Ways, line: &[u32]) {
        for (at, &first) in line.iter().enumerate() {
            let from = ways.all[first as usize].from as usize;
            for &then in &line[at + 1..] {
                let to = ways.all[then as usize].to as usize;
                self.cells.put(from, to);
                self.cells.put(to, from);
            }
        }
    }
}

/// Clears the ways into all cells that a ray reaches after crossing `from`.
pub(crate) fn take_line(ways: &Ways, from: usize, line: &[u32], undecided: &mut [u64]) {
    for way in after(from, line) {
        take_cell(ways, ways.all[way as usize].to, undecided);
    }
}

/// Returns the ways that a ray crosses after crossing `from`.
pub(crate) fn after(from: usize, line: &[u32]) -> impl Iterator<Item = u32> + '_ {
    let rest = line.iter().skip_while(move |&&way| way as usize != from);
    rest.skip(1).copied()
}

/// Clears all ways into a cell.
pub(crate) fn take_cell(ways: &Ways, cell: u32, undecided: &mut [u64]) {
    for out in ways.out_of(cell) {
        take(undecided, ways.all[out].back as usize);
    }
}

/// Traces the line through two points in both directions from `from`, and returns all ways it crosses, in order.
/// Returns `None` if it does not cross `from`.
pub(crate) fn line_through(ways: &Ways, from: usize, start: DVec3, end: DVec3) -> Option<Vec<u32>> {
    let direction = (end - start).try_normalize()?;
    if !crosses(&ways.all[from], start, direction, ways.clear()) {
        return None;
    }
    let mut line = Vec::new();
    walk(
        ways,
        ways.all[from].back as usize,
        start,
        -direction,
        ways.clear(),
        &mut line,
    );
    line.reverse();
    for way in &mut line {
        *way = ways.all[*way as usize].back;
    }
    line.push(from as u32);
    walk(ways, from, start, direction, ways.clear(), &mut line);
    Some(line)
}
