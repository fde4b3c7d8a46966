//! The lower bound: what sampled lines have shown to be seen, and who need not be asked about any more.

use crate::bits::{BitRows, has, take};
use crate::line::{crosses, walk};
use crate::random::Random;
use crate::ways::Ways;
use glam::DVec3;
use rayon::prelude::*;

/// What is known to be seen.
#[derive(Clone, Debug)]
pub(crate) struct Known {
    /// For each cell those that a line leads to, and those next to it.
    pub(crate) cells: BitRows,
}

/// Ways that sample at once, without knowing of each other's lines.
pub(crate) const SIDE_BY_SIDE: usize = 64;

/// Number of lines in a row that miss what they are shot at, after which the flow finds out the rest in less time. On real
/// maps it is seldom reached; in a grid of 6,400 rooms nearly all of 100 million lines miss.
const MAX_MISSES: usize = 1000;

impl Known {
    /// What is known without sampling: each cell sees itself and its neighbours.
    pub(crate) fn new(ways: &Ways) -> Known {
        let mut cells = BitRows::new(ways.cells(), ways.cells());
        for cell in 0..ways.cells() {
            cells.put(cell, cell);
        }
        for way in &ways.all {
            cells.put(way.from as usize, way.to as usize);
        }
        Known { cells }
    }

    /// Shoots a line from each of the [`SIDE_BY_SIDE`] ways from `first` on to each that it may see, where no line is
    /// known yet between their cells; but no more lines after [`MAX_MISSES`] in a row.
    ///
    /// The same lines for any number of threads.
    pub(crate) fn sample(&mut self, ways: &Ways, bound: &BitRows, first: usize) {
        let some = first..ways.count().min(first + SIDE_BY_SIDE);
        let found: Vec<Vec<Vec<u32>>> = some
            .into_par_iter()
            .map(|way| self.lines_from(ways, bound, way))
            .collect();
        for line in found.into_iter().flatten() {
            self.take_in(ways, &line);
        }
    }

    fn lines_from(&self, ways: &Ways, bound: &BitRows, from: usize) -> Vec<Vec<u32>> {
        let mut random = Random::new(from as u64);
        let mut found = Vec::new();
        let mut asked = bound.row(from).to_vec();
        self.take_known(ways, from, &mut asked);
        let mut missed_in_a_row = 0;
        for at in 0..asked.len() {
            while asked[at] != 0 {
                let to = at * 64 + asked[at].trailing_zeros() as usize;
                asked[at] &= asked[at] - 1;
                let start = random.point_in(&ways.all[from].corners);
                let end = random.point_in(&ways.all[to].corners);
                missed_in_a_row += 1;
                if let Some(line) = line_through(ways, from, start, end) {
                    if line.contains(&(to as u32)) {
                        missed_in_a_row = 0;
                    }
                    take_line(ways, from, &line, &mut asked);
                    found.push(line);
                }
                if missed_in_a_row == MAX_MISSES {
                    return found;
                }
            }
        }
        found
    }

    /// Takes out of a row what `from` need not be asked about: ways into cells that its own cell is known to see.
    pub(crate) fn take_known(&self, ways: &Ways, from: usize, asked: &mut [u64]) {
        let seen = self.cells.row(ways.all[from].from as usize);
        for at in 0..asked.len() {
            let mut rest = asked[at];
            while rest != 0 {
                let number = at * 64 + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                if has(seen, ways.all[number].to as usize) {
                    take(asked, number);
                }
            }
        }
    }

    /// Every cell of a line sees those after it and before it.
    pub(crate) fn take_in(&mut self, ways: &Ways, line: &[u32]) {
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

/// Takes out of a row what a line has shown that `from` need not be asked about.
pub(crate) fn take_line(ways: &Ways, from: usize, line: &[u32], asked: &mut [u64]) {
    let after = line.iter().skip_while(|&&way| way as usize != from);
    for &way in after.skip(1) {
        take_cell(ways, ways.all[way as usize].to, asked);
    }
}

/// Takes all ways into a cell out of a row.
pub(crate) fn take_cell(ways: &Ways, cell: u32, asked: &mut [u64]) {
    for out in ways.out_of(cell) {
        take(asked, ways.all[out].back as usize);
    }
}

/// The ways that the line from one point to another takes, both ways from `from`, which it crosses.
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
