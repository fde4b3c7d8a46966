//! Which cells see each other, through portals: bounds from both sides until they meet.

use crate::aim::aim;
use crate::bits::{BitRows, count, ones, ones_besides, put};
use crate::cells::Cells;
use crate::first_bound::first_bound;
use crate::flow::Flow;
use crate::known::Known;
use crate::passages::{Passages, drop_pair};
use crate::ways::Ways;
use rayon::prelude::*;

/// How [`VisiblePairs::compute`] works.
#[derive(Clone, Copy, Debug, Default)]
pub struct PairsOptions {
    /// Stops at the bound that passages give: two to nine times as fast, and up to two thirds more pairs.
    pub fast: bool,
}

/// Which cells may see each other, from anywhere in the one to anywhere in the other: never less than do.
///
/// Sight has no direction, so the pairs are symmetric; each cell sees itself and its neighbours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VisiblePairs {
    cells: BitRows,
    proven: usize,
}

/// Ways that flow at once, without knowing of each other's answers: enough for a few threads to share.
const SIDE_BY_SIDE: usize = 16;

/// Flows from every way once.
#[derive(Debug)]
struct Round {
    /// Of each way that has flowed, its back: who sees that has been told.
    told: Vec<u64>,
    /// Whether lines are aimed at what is reached along two chains, or along one.
    twice: bool,
}

/// What one way's flow has found.
#[derive(Debug)]
struct Answer {
    dropped: Vec<u32>,
    lines: Vec<Vec<u32>>,
}

impl VisiblePairs {
    /// Computes them on all threads of rayon's pool; the same pairs for any number of threads.
    ///
    /// Takes about (2 portals)² bits, and as many bits for each pair of portals of one cell as there are portals, twice.
    pub fn compute(cells: &Cells, options: &PairsOptions) -> VisiblePairs {
        let ways = Ways::of(cells);
        let mut bound = first_bound(&ways);
        let passages = Passages::of(&ways, &bound);
        passages.tighten(&ways, &mut bound);
        let mut known = Known::new(&ways);
        if !options.fast {
            known.sample(&ways, &bound);
            flow_all(&ways, &passages, &mut bound, &mut known);
        }
        let mut seen = Known::new(&ways).cells;
        for (way, from) in ways.all.iter().enumerate() {
            let row = seen.row_mut(from.from as usize);
            ones(bound.row(way)).for_each(|then| put(row, ways.all[then].to as usize));
        }
        VisiblePairs {
            proven: known.cells.count() - ways.cells(),
            cells: seen,
        }
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

/// Flows from every way, the cheapest first: by then the dear ones have most of their answers from the other side.
///
/// Then once more in reverse: what no line has shown is asked from its other end, whose chains drop or show some of it.
fn flow_all(ways: &Ways, passages: &Passages, bound: &mut BitRows, known: &mut Known) {
    let mut order: Vec<usize> = (0..ways.count()).collect();
    order.sort_by_key(|&way| (count(bound.row(way)), way));
    for twice in [false, true] {
        flow_in(&order, twice, ways, passages, bound, known);
        order.reverse();
    }
}

/// Flows in an order; each pair is asked from that end which comes first.
fn flow_in(
    order: &[usize],
    twice: bool,
    ways: &Ways,
    passages: &Passages,
    bound: &mut BitRows,
    known: &mut Known,
) {
    let mut round = Round {
        told: vec![0; bound.words_in_row()],
        twice,
    };
    for some in order.chunks(SIDE_BY_SIDE) {
        let answers: Vec<Answer> = some
            .par_iter()
            .map_init(Flow::default, |flow, &way| {
                answer(ways, passages, bound, known, &round, way, flow)
            })
            .collect();
        for (&way, answer) in some.iter().zip(answers) {
            for then in answer.dropped {
                drop_pair(ways, bound, way, then as usize);
            }
            for line in answer.lines {
                known.take_in(ways, &line);
            }
            put(&mut round.told, ways.all[way].back as usize);
        }
    }
}

fn answer(
    ways: &Ways,
    passages: &Passages,
    bound: &BitRows,
    known: &Known,
    round: &Round,
    way: usize,
    flow: &mut Flow,
) -> Answer {
    let mut asked = bound.row(way).to_vec();
    for (word, told) in asked.iter_mut().zip(&round.told) {
        *word &= !told;
    }
    known.take_known(ways, way, &mut asked);
    let mut lines = Vec::new();
    // What a line shows is no longer asked about, but what the flow alone reaches is: only that it is not dropped.
    let reached = flow.run(ways, bound, passages, way, &mut asked, |asked, reached| {
        lines.extend(aim(ways, way, reached, round.twice, asked));
    });
    let dropped = ones_besides(&asked, reached).map(|then| then as u32).collect();
    Answer { dropped, lines }
}
