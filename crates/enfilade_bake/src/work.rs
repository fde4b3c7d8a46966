//! Computes the PVS in steps, so that it can report progress, stop and resume.
//!
//! The upper bound comes first (flood fill, then [`Passages`]), then the lower bound from sampled rays (`known`), then
//! the portal flow decides the remaining pairs. The upper bound holds at every step, so the work may stop anywhere.
//! Each step is a batch of fixed size whose parts are independent: the resulting bits depend neither on the number of
//! threads nor on interruptions.
//!
//! Nor do they depend on the rays that the flow aims, so the flow can be split into shards (`shards`). A ray proves
//! nothing that the flow would not find by itself; it only saves the search. So that this holds, the flow decides
//! each way that sampling has not proven, even if a ray proves its pair of cells meanwhile. The backflow leaves such
//! ways out, but its chains follow a bound that shrinks only by whole pairs of cells, which no ray can prove.

use crate::aim::aim;
use crate::bits::{BitRows, count, has, ones, ones_besides, ones_of, put, take};
use crate::cells::Cells;
use crate::first_bound::{flood_from, keep_symmetric};
use crate::flow::Flow;
use crate::known::{self, LowerBound, after};
use crate::pairs::VisiblePairs;
use crate::passages::{Passages, drop_pair};
use crate::saved::sum_of;
use crate::shards::{FlowPart, ShardRows};
use crate::ways::Ways;
use rayon::prelude::*;
use thiserror::Error;

/// Computes [`VisiblePairs`] one step at a time.
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
/// assert!(work.pairs().may_see(0, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PairsWork {
    pub(crate) ways: Ways,
    pub(crate) passages: Passages,
    pub(crate) progress: WorkProgress,
    /// Ways whose bound may still change in the fixpoint. Empty before it begins.
    stale: Vec<bool>,
    /// For each index in the order of the flow, the estimated cost of all flows before it.
    cost_before: Vec<f64>,
    /// Saved progress to restore once the passages have been recomputed.
    pub(crate) saved: Option<WorkProgress>,
    /// What shards have found, for the flow.
    pub(crate) parts: Vec<FlowPart>,
}

/// What the work has computed besides the passages.
#[derive(Clone, Debug)]
pub(crate) struct WorkProgress {
    pub(crate) stage: Stage,
    /// Number of ways that the current stage has finished.
    pub(crate) next: usize,
    /// Upper bound: for each way, the ways that a ray may cross after it.
    pub(crate) bound: BitRows,
    pub(crate) known: LowerBound,
    /// In the flow: `known` as sampling left it. The flow decides all other ways.
    pub(crate) sampled: Option<LowerBound>,
    /// In the backflow: the bound that its chains follow.
    pub(crate) chains: Option<BitRows>,
    /// Order in which the ways run their flow.
    pub(crate) order: Vec<u32>,
    /// Hash of the two bounds at the beginning of the flow; 0 before it.
    pub(crate) start: u64,
    /// The share of the flow that this work runs; `None` for all of it.
    pub(crate) shard: Option<ShardRows>,
}

/// Stage of a [`PairsWork`], in the order in which the stages run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Upper bound by flood fill: through portals that are in front of one another.
    FirstBound,
    /// Separating planes: for each passage (two consecutive portals), the portals that a ray may cross after it.
    Passages,
    /// Propagates the passages until nothing changes; the bound of [`PairsOptions::fast`](crate::PairsOptions::fast).
    Fixpoint,
    /// Lower bound: rays sampled between portals.
    Sampling,
    /// Recursive portal flow for the pairs between the two bounds.
    Flow,
    /// Portal flow from the other end, for pairs that no ray has proven; it drops or proves some of them.
    Backflow,
    /// All pairs are decided.
    Done,
}

impl Stage {
    /// All stages before [`Stage::Done`], in order.
    pub const ALL: [Stage; 6] = [
        Stage::FirstBound,
        Stage::Passages,
        Stage::Fixpoint,
        Stage::Sampling,
        Stage::Flow,
        Stage::Backflow,
    ];
}

/// The computation could exceed its memory limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "the PVS of {cells} cells and {portals} portals takes up to {} to compute, above the limit of {}",
    megabytes(*.needs_bytes), megabytes(*.limit_bytes)
)]
pub struct TooLarge {
    /// Number of cells.
    pub cells: u32,
    /// Number of portals.
    pub portals: usize,
    /// Upper bound of the memory needed, in bytes.
    pub needs_bytes: u64,
    /// Memory limit, in bytes.
    pub limit_bytes: u64,
}

/// Formats bytes as `12.3 MB`, with four significant digits.
fn megabytes(bytes: u64) -> String {
    let number = format!("{:.3e}", bytes as f64 / 1e6);
    format!("{} MB", number.parse().unwrap_or(f64::INFINITY))
}

/// Number of ways per step in stages where each way is cheap.
const SIDE_BY_SIDE: usize = 256;

/// Number of ways that flow in one step, independent of each other's results: enough for a few threads.
pub(crate) const FLOWS: usize = 16;

/// Result of the portal flow from one way.
#[derive(Debug)]
pub(crate) struct FlowResult {
    /// Ways that no chain reaches.
    pub(crate) dropped: Vec<u32>,
    pub(crate) lines: Vec<Vec<u32>>,
}

impl PairsWork {
    /// Creates work in its first stage.
    ///
    /// # Errors
    /// [`TooLarge`] if the computation could need more than `limit_bytes`. With `p` portals the bound counts 2 (2 p)²
    /// bits for pairs of ways, 2 p bits for each ordered pair of portals of one cell (a passage), and 3 bits for each
    /// pair of cells. The passages typically take a seventh of their share.
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
            passages: Passages::none(&ways),
            progress: WorkProgress {
                stage: Stage::FirstBound,
                next: 0,
                bound: BitRows::new(ways.count(), ways.count()),
                known: LowerBound::new(&ways),
                sampled: None,
                chains: None,
                order: Vec::new(),
                start: 0,
                shard: None,
            },
            stale: Vec::new(),
            cost_before: Vec::new(),
            saved: None,
            parts: Vec::new(),
            ways,
        })
    }

    /// Returns the stage that the next step works on.
    pub fn stage(&self) -> Stage {
        self.progress.stage
    }

    /// Returns the finished share of the current stage, 0 to 1, by estimated time.
    pub fn share(&self) -> f64 {
        match self.progress.stage {
            Stage::FirstBound | Stage::Passages | Stage::Sampling => {
                self.progress.next as f64 / self.ways.count().max(1) as f64
            }
            Stage::Fixpoint => 0.0,
            Stage::Flow | Stage::Backflow => {
                self.cost_before[self.progress.next] / self.cost_before[self.progress.order.len()].max(1.0)
            }
            Stage::Done => 1.0,
        }
    }

    /// Runs one batch on all threads of rayon's pool. Does nothing in [`Stage::Done`].
    pub fn step(&mut self) {
        let some = self.progress.next..self.ways.count().min(self.progress.next + SIDE_BY_SIDE);
        match self.progress.stage {
            Stage::FirstBound => {
                flood_from(&self.ways, some, &mut self.progress.bound);
                if self.advance(SIDE_BY_SIDE, Stage::Passages) {
                    keep_symmetric(&self.ways, &mut self.progress.bound);
                }
            }
            Stage::Passages => {
                self.passages.compute(&self.ways, &self.progress.bound, some);
                if self.advance(SIDE_BY_SIDE, Stage::Fixpoint)
                    && let Some(saved) = self.saved.take()
                {
                    self.restore(saved);
                }
            }
            Stage::Fixpoint => {
                if self.stale.is_empty() {
                    self.stale = vec![true; self.ways.count()];
                }
                if !self
                    .passages
                    .tighten(&self.ways, &mut self.progress.bound, &mut self.stale)
                {
                    self.progress.stage = Stage::Sampling;
                    self.stale = Vec::new();
                }
            }
            Stage::Sampling => {
                self.progress
                    .known
                    .sample(&self.ways, &self.progress.bound, self.progress.next);
                if self.advance(known::SIDE_BY_SIDE, Stage::Flow) {
                    self.progress.begin_flow();
                    self.estimate_costs();
                }
            }
            Stage::Flow => {
                if self.progress.is_own_batch() {
                    self.flow();
                }
                if self.advance(FLOWS, Stage::Backflow) {
                    self.progress.begin_backflow();
                    self.estimate_costs();
                }
            }
            Stage::Backflow => {
                self.flow();
                if self.advance(FLOWS, Stage::Done) {
                    self.progress.chains = None;
                }
            }
            Stage::Done => {}
        }
    }

    /// Returns the current PVS. It is an upper bound at every stage: no visible pair is missing.
    pub fn pairs(&self) -> VisiblePairs {
        let mut seen = LowerBound::new(&self.ways).cells;
        for (number, way) in self.ways.all.iter().enumerate() {
            let row = seen.row_mut(way.from as usize);
            if self.progress.stage == Stage::FirstBound {
                (0..self.ways.cells()).for_each(|cell| put(row, cell));
            } else {
                ones(self.progress.bound.row(number))
                    .for_each(|then| put(row, self.ways.all[then].to as usize));
            }
        }
        VisiblePairs::new(seen, self.progress.known.cells.count() - self.ways.cells())
    }

    pub(crate) fn restore(&mut self, saved: WorkProgress) {
        self.progress = saved;
        self.estimate_costs();
    }

    /// Advances by `by` ways, and to stage `then` after the last way; returns `true` if the stage changed.
    fn advance(&mut self, by: usize, then: Stage) -> bool {
        self.progress.next = self.ways.count().min(self.progress.next + by);
        let is_over = self.progress.next == self.ways.count();
        if is_over {
            self.progress.next = 0;
            self.progress.stage = then;
        }
        is_over
    }

    /// Estimates the cost of each flow as the size of its bound, which fits all maps measured. In the backflow only the
    /// undecided ways count.
    fn estimate_costs(&mut self) {
        let mut sum = 0.0;
        self.cost_before.clear();
        self.cost_before.push(0.0);
        for &way in &self.progress.order {
            let mut undecided = self.progress.bound.row(way as usize).to_vec();
            if self.progress.stage == Stage::Backflow {
                self.progress
                    .known
                    .take_known(&self.ways, way as usize, &mut undecided);
            }
            sum += 1.0 + count(&undecided) as f64;
            self.cost_before.push(sum);
        }
    }

    /// Runs the flow from the next [`FLOWS`] ways in the order. Each pair is decided from whichever end comes first.
    /// In the flow, rays are aimed along the first chain that reaches a way, in the backflow along the first two.
    fn flow(&mut self) {
        // The reverses of all ways that have flowed: pairs that end there are decided.
        let mut answered = vec![0u64; self.progress.bound.words_in_row()];
        let WorkProgress { order, next, .. } = &self.progress;
        let (before, rest) = order.split_at(*next);
        for &way in before {
            put(&mut answered, self.ways.all[way as usize].back as usize);
        }
        let some: Vec<(usize, u32)> = (*next..)
            .zip(rest[..rest.len().min(FLOWS)].iter().copied())
            .collect();
        let answers: Vec<FlowResult> = some
            .par_iter()
            .map_init(Flow::default, |flow, &(at, way)| {
                self.answer(&answered, at, way as usize, flow)
            })
            .collect();
        if let Some(rows) = &mut self.progress.shard
            && self.progress.stage == Stage::Flow
        {
            for (&(_, way), answer) in some.iter().zip(&answers) {
                rows.add(&self.ways, way, answer);
            }
        }
        for (&(_, way), answer) in some.iter().zip(answers) {
            for &then in &answer.dropped {
                drop_pair(&self.ways, &mut self.progress.bound, way as usize, then as usize);
            }
            if self.progress.chains.is_some() {
                self.close_pairs(way as usize, &answer.dropped);
            }
            for line in answer.lines {
                self.progress.known.add_line(&self.ways, &line);
            }
        }
    }

    /// Drops from the bound of the backflow's chains the pairs of cells of which the last pair of ways was dropped.
    fn close_pairs(&mut self, way: usize, dropped: &[u32]) {
        let WorkProgress { bound, chains, .. } = &mut self.progress;
        let Some(chains) = chains else { return };
        let ways = &self.ways;
        let from = ways.all[way].from;
        let mut cells: Vec<u32> = dropped.iter().map(|&then| ways.all[then as usize].to).collect();
        cells.sort_unstable();
        cells.dedup();
        for cell in cells {
            let pairs = || {
                let into = move || ways.out_of(cell).map(|out| ways.all[out].back as usize);
                ways.out_of(from)
                    .flat_map(move |first| into().map(move |then| (first, then)))
            };
            if !pairs().any(|(first, then)| bound.has(first, then)) {
                pairs().for_each(|(first, then)| drop_pair(ways, chains, first, then));
            }
        }
    }

    /// Runs the flow from one way, whose index in the order is `at`.
    fn answer(&self, answered: &[u64], at: usize, way: usize, flow: &mut Flow) -> FlowResult {
        let ways = &self.ways;
        let WorkProgress {
            bound,
            known,
            sampled,
            chains,
            shard,
            ..
        } = &self.progress;
        let mut undecided = bound.row(way).to_vec();
        for (word, answered) in undecided.iter_mut().zip(answered) {
            *word &= !answered;
        }
        sampled
            .as_ref()
            .unwrap_or(known)
            .take_known(ways, way, &mut undecided);
        let mut dropped = match sampled {
            Some(_) => self.take_decided(at, &mut undecided),
            None => Vec::new(),
        };
        let mut lines = Vec::new();
        // Ways that a ray proves visible leave `undecided`. Ways that only the flow reaches stay in it, and are not
        // dropped.
        let bound = chains.as_ref().unwrap_or(bound);
        let is_back = chains.is_some();
        // A ray that proves no new pair of cells is not worth its cost, except in a shard: there it spares the merge the
        // search for the ways that it crosses.
        let mut seen =
            (!is_back && shard.is_none()).then(|| known.cells.row(ways.all[way].from as usize).to_vec());
        let reached = flow.run(
            ways,
            bound,
            &self.passages,
            way,
            &mut undecided,
            |undecided, reached| {
                if let Some(seen) = &seen
                    && has(seen, ways.all[reached.way].to as usize)
                {
                    take(undecided, reached.way);
                    return;
                }
                let Some(line) = aim(ways, way, reached, is_back, undecided) else {
                    return;
                };
                if let Some(seen) = &mut seen {
                    after(way, &line).for_each(|then| put(seen, ways.all[then as usize].to as usize));
                }
                lines.push(line);
            },
        );
        dropped.extend(ones_besides(&undecided, reached).map(|then| then as u32));
        FlowResult { dropped, lines }
    }

    /// Clears the ways that a shard has decided for the flow at index `at` of the order. Returns those that it has
    /// dropped.
    fn take_decided(&self, at: usize, undecided: &mut [u64]) -> Vec<u32> {
        let mut dropped = Vec::new();
        let parts = self.parts.iter().filter_map(|part| part.decided(at));
        for decided in parts {
            for (number, word) in decided.dropped {
                dropped.extend(ones_of(number, word & undecided[number]).map(|then| then as u32));
                undecided[number] &= !word;
            }
            for (number, word) in decided.proven {
                undecided[number] &= !word;
            }
        }
        dropped
    }
}

impl WorkProgress {
    fn begin_flow(&mut self) {
        let (bound, known) = (&self.bound, &self.known);
        // Cheapest first: by the time the expensive ways flow, most of their pairs are decided from the other end.
        self.order = (0..bound.rows() as u32).collect();
        self.order
            .sort_by_key(|&way| (count(bound.row(way as usize)), way));
        self.sampled = Some(known.clone());
        self.start = sum_of(bound.words().iter().chain(known.cells.words()).copied());
    }

    fn begin_backflow(&mut self) {
        self.sampled = None;
        self.chains = Some(self.bound.clone());
        self.order.reverse();
    }

    /// Whether the next batch of the flow is to be run: all are, except those of other shards.
    fn is_own_batch(&self) -> bool {
        let batch = self.next / FLOWS;
        self.shard.as_ref().is_none_or(|rows| rows.shard.has(batch))
    }
}

/// Returns an upper bound of the memory needed, in bytes, without allocating.
fn needed_bytes(cells: &Cells) -> u64 {
    let ways = cells.portals().len() as u64 * 2;
    let corners: u64 = cells
        .portals()
        .iter()
        .map(|portal| portal.corners.len() as u64)
        .sum();
    let by_cells = u64::from(cells.count()).pow(2) / 8 * 3;
    let mut ends: Vec<u32> = cells.portals().iter().flat_map(|portal| portal.cells).collect();
    ends.sort_unstable();
    let passages: u64 = ends
        .chunk_by(|a, b| a == b)
        .map(|of_cell| (of_cell.len() as u64).pow(2))
        .sum();
    by_cells
        .saturating_add(ways * (ways / 4 + 200) + corners * 48)
        .saturating_add(passages.saturating_mul(ways / 8))
}
