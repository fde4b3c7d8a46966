//! The work of finding out which cells see each other: in steps, so that it can be watched, stopped, and gone on with.
//!
//! First comes what bounds the answer from above (floods, then [`Passages`]), then lines from below ([`Known`]), then
//! the flow for what lies between. At every moment the bound holds all that is seen, so that work may stop anywhere.
//! Each step is a batch of fixed size whose parts know nothing of each other: the bits are the same for any number of
//! threads, and whether the work was stopped or not.

use crate::aim::aim;
use crate::bits::{BitRows, count, ones, ones_besides, put};
use crate::cells::Cells;
use crate::first_bound::{flood_from, keep_symmetric};
use crate::flow::Flow;
use crate::known::{self, Known};
use crate::pairs::VisiblePairs;
use crate::passages::{Passages, drop_pair};
use crate::saved::Saved;
use crate::ways::Ways;
use rayon::prelude::*;
use thiserror::Error;

/// Finds out which cells see each other, a step at a time.
///
/// ```
/// use enfilade_bake::{Cells, PairsWork, Portal, Stage};
///
/// let door = vec![[10.0, -1.0, 0.0], [10.0, 1.0, 0.0], [10.0, 1.0, 2.0], [10.0, -1.0, 2.0]];
/// let rooms = Cells::new(2, vec![Portal { corners: door, cells: [0, 1] }])?;
/// let mut work = PairsWork::begin(&rooms, 1 << 30)?;
/// while work.stage() != Stage::Done {
///     work.step();
/// }
/// assert!(work.pairs().sees(0, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PairsWork {
    pub(crate) ways: Ways,
    pub(crate) stage: Stage,
    /// For each way those that a line may take after it.
    pub(crate) bound: BitRows,
    pub(crate) passages: Passages,
    pub(crate) known: Known,
    /// The ways whose bound may change in the fixpoint; none before it begins.
    stale: Vec<bool>,
    /// The order in which ways flow.
    pub(crate) order: Vec<u32>,
    /// How many ways the stage is done with.
    pub(crate) next: usize,
    /// For each place in the order, what all flows before it are thought to cost.
    cost_before: Vec<f64>,
    /// Where to go on, once passages that were not saved are there again.
    pub(crate) saved: Option<Saved>,
}

/// What a [`PairsWork`] does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Floods through portals that lie before one another.
    FirstBound,
    /// What a line may meet after any two portals in a row.
    Passages,
    /// What follows from that for all: here the fast bound is reached.
    Fixpoint,
    /// Lines from everywhere, which bound the answer from below.
    Sampling,
    /// Chains of portals, for what lies between the two bounds.
    Flow,
    /// Chains again, for what no line has shown, from its other end: they drop or show some of it.
    Backflow,
    /// All is known.
    Done,
}

impl Stage {
    /// The stages before [`Stage::Done`], in their order.
    pub const ALL: [Stage; 6] = [
        Stage::FirstBound,
        Stage::Passages,
        Stage::Fixpoint,
        Stage::Sampling,
        Stage::Flow,
        Stage::Backflow,
    ];
}

/// The work could take too much memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the PVS of {cells} cells and {portals} portals takes up to {} to compute, above the limit of {}",
    megabytes(*.needs_bytes), megabytes(*.limit_bytes)
)]
pub struct TooLarge {
    /// How many cells there are.
    pub cells: u32,
    /// How many portals.
    pub portals: usize,
    /// What the work takes at most, in bytes.
    pub needs_bytes: u64,
    /// What it may take.
    pub limit_bytes: u64,
}

/// `12.3 MB`, with four significant digits.
fn megabytes(bytes: u64) -> String {
    let number = format!("{:.3e}", bytes as f64 / 1e6);
    format!("{} MB", number.parse().unwrap_or(f64::INFINITY))
}

/// Ways of a step, where each takes little.
const SIDE_BY_SIDE: usize = 256;

/// Ways that flow at once, without knowing of each other's answers: enough for a few threads to share.
const FLOWS: usize = 16;

/// What one way's flow has found.
#[derive(Debug)]
struct Answer {
    dropped: Vec<u32>,
    lines: Vec<Vec<u32>>,
}

impl PairsWork {
    /// Work that has not begun.
    ///
    /// # Errors
    /// Where it could take more than `limit_bytes`: (2 portals)² bits, as many bits for each pair of portals of
    /// one cell as there are portals, 4 times, and 2 times (cells)² bits. Of those for pairs it takes about a seventh.
    pub fn begin(cells: &Cells, limit_bytes: u64) -> Result<PairsWork, TooLarge> {
        let needs_bytes = needed_bytes(cells);
        if needs_bytes > limit_bytes {
            return Err(TooLarge {
                cells: cells.count(),
                portals: cells.portals().len(),
                needs_bytes,
                limit_bytes,
            });
        }
        let ways = Ways::of(cells);
        Ok(PairsWork {
            stage: Stage::FirstBound,
            bound: BitRows::new(ways.count(), ways.count()),
            passages: Passages::none(&ways),
            known: Known::new(&ways),
            stale: Vec::new(),
            order: Vec::new(),
            next: 0,
            cost_before: Vec::new(),
            saved: None,
            ways,
        })
    }

    /// What the next step works on.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// How much of the stage is done, 0 to 1, by the time that it is thought to take.
    pub fn share(&self) -> f64 {
        match self.stage {
            Stage::FirstBound | Stage::Passages | Stage::Sampling => {
                self.next as f64 / self.ways.count().max(1) as f64
            }
            Stage::Fixpoint => 0.0,
            Stage::Flow | Stage::Backflow => {
                self.cost_before[self.next] / self.cost_before[self.order.len()].max(1.0)
            }
            Stage::Done => 1.0,
        }
    }

    /// Goes on a little, on all threads of rayon's pool. Does nothing when all is done.
    pub fn step(&mut self) {
        let some = self.next..self.ways.count().min(self.next + SIDE_BY_SIDE);
        match self.stage {
            Stage::FirstBound => {
                flood_from(&self.ways, some, &mut self.bound);
                if self.advance(SIDE_BY_SIDE, Stage::Passages) {
                    keep_symmetric(&self.ways, &mut self.bound);
                }
            }
            Stage::Passages => {
                self.passages.compute(&self.ways, &self.bound, some);
                if self.advance(SIDE_BY_SIDE, Stage::Fixpoint)
                    && let Some(saved) = self.saved.take()
                {
                    self.go_on_from(saved);
                }
            }
            Stage::Fixpoint => {
                if self.stale.is_empty() {
                    self.stale = vec![true; self.ways.count()];
                }
                if !self
                    .passages
                    .tighten(&self.ways, &mut self.bound, &mut self.stale)
                {
                    self.stage = Stage::Sampling;
                    self.stale = Vec::new();
                }
            }
            Stage::Sampling => {
                self.known.sample(&self.ways, &self.bound, self.next);
                if self.advance(known::SIDE_BY_SIDE, Stage::Flow) {
                    // The cheapest first: by then the dear ones have most of their answers from the other side.
                    self.order = (0..self.ways.count() as u32).collect();
                    let bound = &self.bound;
                    self.order
                        .sort_by_key(|&way| (count(bound.row(way as usize)), way));
                    self.foresee();
                }
            }
            Stage::Flow => {
                self.flow(false);
                if self.advance(FLOWS, Stage::Backflow) {
                    self.order.reverse();
                    self.foresee();
                }
            }
            Stage::Backflow => {
                self.flow(true);
                self.advance(FLOWS, Stage::Done);
            }
            Stage::Done => {}
        }
    }

    /// The pairs that may see each other, by all that is known now: never less than do.
    pub fn pairs(&self) -> VisiblePairs {
        let mut seen = Known::new(&self.ways).cells;
        for (number, way) in self.ways.all.iter().enumerate() {
            let row = seen.row_mut(way.from as usize);
            if self.stage == Stage::FirstBound {
                (0..self.ways.cells()).for_each(|cell| put(row, cell));
            } else {
                ones(self.bound.row(number)).for_each(|then| put(row, self.ways.all[then].to as usize));
            }
        }
        VisiblePairs::new(seen, self.known.cells.count() - self.ways.cells())
    }

    pub(crate) fn go_on_from(&mut self, saved: Saved) {
        self.stage = saved.stage;
        self.next = saved.next;
        self.bound = saved.bound;
        self.known = saved.known;
        self.order = saved.order;
        self.foresee();
    }

    /// Goes on by so many ways, and to the next stage after the last; says whether it did.
    fn advance(&mut self, by: usize, then: Stage) -> bool {
        self.next = self.ways.count().min(self.next + by);
        let is_over = self.next == self.ways.count();
        if is_over {
            self.next = 0;
            self.stage = then;
        }
        is_over
    }

    /// Estimates what each flow costs: about as much as it may see, on all maps that were tried; on the way back, as much as
    /// it still asks for.
    fn foresee(&mut self) {
        let mut sum = 0.0;
        self.cost_before.clear();
        self.cost_before.push(0.0);
        for &way in &self.order {
            let mut asked = self.bound.row(way as usize).to_vec();
            if self.stage == Stage::Backflow {
                self.known.take_known(&self.ways, way as usize, &mut asked);
            }
            sum += 1.0 + count(&asked) as f64;
            self.cost_before.push(sum);
        }
    }

    /// Flows from the next few ways in the order; each pair is asked from that end which comes first. Lines are aimed at
    /// what is reached along one chain, or along two.
    fn flow(&mut self, twice: bool) {
        // Of each way that has flowed, its back: who sees that has been told.
        let mut told = vec![0u64; self.bound.words_in_row()];
        let (before, rest) = self.order.split_at(self.next);
        for &way in before {
            put(&mut told, self.ways.all[way as usize].back as usize);
        }
        let some = &rest[..rest.len().min(FLOWS)];
        let answers: Vec<Answer> = some
            .par_iter()
            .map_init(Flow::default, |flow, &way| {
                self.answer(&told, twice, way as usize, flow)
            })
            .collect();
        for (&way, answer) in some.iter().zip(answers) {
            for then in answer.dropped {
                drop_pair(&self.ways, &mut self.bound, way as usize, then as usize);
            }
            for line in answer.lines {
                self.known.take_in(&self.ways, &line);
            }
        }
    }

    fn answer(&self, told: &[u64], twice: bool, way: usize, flow: &mut Flow) -> Answer {
        let ways = &self.ways;
        let mut asked = self.bound.row(way).to_vec();
        for (word, told) in asked.iter_mut().zip(told) {
            *word &= !told;
        }
        self.known.take_known(ways, way, &mut asked);
        let mut lines = Vec::new();
        // What a line shows is no longer asked about, but what the flow alone reaches is: only that it is not dropped.
        let (bound, passages) = (&self.bound, &self.passages);
        let reached = flow.run(ways, bound, passages, way, &mut asked, |asked, reached| {
            lines.extend(aim(ways, way, reached, twice, asked));
        });
        let dropped = ones_besides(&asked, reached).map(|then| then as u32).collect();
        Answer { dropped, lines }
    }
}

/// What the work takes at most, in bytes; nothing is set aside for it.
fn needed_bytes(cells: &Cells) -> u64 {
    let ways = cells.portals().len() as u64 * 2;
    let corners: u64 = cells
        .portals()
        .iter()
        .map(|portal| portal.corners.len() as u64)
        .sum();
    let by_cells = u64::from(cells.count()).pow(2) / 4;
    let mut ends: Vec<u32> = cells.portals().iter().flat_map(|portal| portal.cells).collect();
    ends.sort_unstable();
    let passages: u64 = ends
        .chunk_by(|a, b| a == b)
        .map(|of_cell| (of_cell.len() as u64).pow(2))
        .sum();
    by_cells
        .saturating_add(ways * (ways / 8 + 200) + corners * 48)
        .saturating_add(passages.saturating_mul(ways / 8))
}
