//! Computes the PVS in steps, so that it can report progress, stop and resume.
//!
//! The upper bound comes first (flood fill, then [`Passages`]), then the lower bound from sampled rays (`known`), then
//! the portal flow decides the remaining pairs. The upper bound holds at every step, so the work may stop anywhere.
//! Each step is a batch of fixed size whose parts are independent: the resulting bits depend neither on the number of
//! threads nor on interruptions.

use crate::aim::aim;
use crate::bits::{BitRows, count, ones, ones_besides, put};
use crate::cells::Cells;
use crate::first_bound::{flood_from, keep_symmetric};
use crate::flow::Flow;
use crate::known::{self, LowerBound};
use crate::pairs::VisiblePairs;
use crate::passages::{Passages, drop_pair};
use crate::saved::Saved;
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
    pub(crate) stage: Stage,
    /// Upper bound: for each way, the ways that a ray may cross after it.
    pub(crate) bound: BitRows,
    pub(crate) passages: Passages,
    pub(crate) known: LowerBound,
    /// Ways whose bound may still change in the fixpoint. Empty before it begins.
    stale: Vec<bool>,
    /// Order in which the ways run their flow.
    pub(crate) order: Vec<u32>,
    /// Number of ways that the current stage has finished.
    pub(crate) next: usize,
    /// For each index in `order`, the estimated cost of all flows before it.
    cost_before: Vec<f64>,
    /// Saved state to restore once the passages have been recomputed.
    pub(crate) saved: Option<Saved>,
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
const FLOWS: usize = 16;

/// Result of the portal flow from one way.
#[derive(Debug)]
struct FlowResult {
    dropped: Vec<u32>,
    lines: Vec<Vec<u32>>,
}

impl PairsWork {
    /// Creates work in its first stage.
    ///
    /// # Errors
    /// [`TooLarge`] if the computation could need more than `limit_bytes`. With `p` portals the bound counts (2 p)²
    /// bits for pairs of ways, 2 p bits for each ordered pair of portals of one cell (a passage), and 2 bits for each
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
            stage: Stage::FirstBound,
            bound: BitRows::new(ways.count(), ways.count()),
            passages: Passages::none(&ways),
            known: LowerBound::new(&ways),
            stale: Vec::new(),
            order: Vec::new(),
            next: 0,
            cost_before: Vec::new(),
            saved: None,
            ways,
        })
    }

    /// Returns the stage that the next step works on.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Returns the finished share of the current stage, 0 to 1, by estimated time.
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

    /// Runs one batch on all threads of rayon's pool. Does nothing in [`Stage::Done`].
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
                    self.restore(saved);
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
                    // Cheapest first: by the time the expensive ways flow, most of their pairs are decided from the
                    // other end.
                    self.order = (0..self.ways.count() as u32).collect();
                    let bound = &self.bound;
                    self.order
                        .sort_by_key(|&way| (count(bound.row(way as usize)), way));
                    self.estimate_costs();
                }
            }
            Stage::Flow => {
                self.flow(false);
                if self.advance(FLOWS, Stage::Backflow) {
                    self.order.reverse();
                    self.estimate_costs();
                }
            }
            Stage::Backflow => {
                self.flow(true);
                self.advance(FLOWS, Stage::Done);
            }
            Stage::Done => {}
        }
    }

    /// Returns the current PVS. It is an upper bound at every stage: no visible pair is missing.
    pub fn pairs(&self) -> VisiblePairs {
        let mut seen = LowerBound::new(&self.ways).cells;
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

    pub(crate) fn restore(&mut self, saved: Saved) {
        self.stage = saved.stage;
        self.next = saved.next;
        self.bound = saved.bound;
        self.known = saved.known;
        self.order = saved.order;
        self.estimate_costs();
    }

    /// Advances by `by` ways, and to stage `then` after the last way; returns `true` if the stage changed.
    fn advance(&mut self, by: usize, then: Stage) -> bool {
        self.next = self.ways.count().min(self.next + by);
        let is_over = self.next == self.ways.count();
        if is_over {
            self.next = 0;
            self.stage = then;
        }
        is_over
    }

    /// Estimates the cost of each flow as the size of its bound, which fits all maps measured. In the backflow only the
    /// undecided ways count.
    fn estimate_costs(&mut self) {
        let mut sum = 0.0;
        self.cost_before.clear();
        self.cost_before.push(0.0);
        for &way in &self.order {
            let mut undecided = self.bound.row(way as usize).to_vec();
            if self.stage == Stage::Backflow {
                self.known.take_known(&self.ways, way as usize, &mut undecided);
            }
            sum += 1.0 + count(&undecided) as f64;
            self.cost_before.push(sum);
        }
    }

    /// Runs the flow from the next [`FLOWS`] ways in the order. Each pair is decided from whichever end comes first.
    /// Rays are aimed along the first chain that reaches a way, or with `twice` along the first two.
    fn flow(&mut self, twice: bool) {
        // The reverses of all ways that have flowed: pairs that end there are decided.
        let mut answered = vec![0u64; self.bound.words_in_row()];
        let (before, rest) = self.order.split_at(self.next);
        for &way in before {
            put(&mut answered, self.ways.all[way as usize].back as usize);
        }
        let some = &rest[..rest.len().min(FLOWS)];
        let answers: Vec<FlowResult> = some
            .par_iter()
            .map_init(Flow::default, |flow, &way| {
                self.answer(&answered, twice, way as usize, flow)
            })
            .collect();
        for (&way, answer) in some.iter().zip(answers) {
            for then in answer.dropped {
                drop_pair(&self.ways, &mut self.bound, way as usize, then as usize);
            }
            for line in answer.lines {
                self.known.add_line(&self.ways, &line);
            }
        }
    }

    fn answer(&self, answered: &[u64], twice: bool, way: usize, flow: &mut Flow) -> FlowResult {
        let ways = &self.ways;
        let mut undecided = self.bound.row(way).to_vec();
        for (word, answered) in undecided.iter_mut().zip(answered) {
            *word &= !answered;
        }
        self.known.take_known(ways, way, &mut undecided);
        let mut lines = Vec::new();
        // Ways that a ray proves visible leave `undecided`. Ways that only the flow reaches stay in it, and are not
        // dropped.
        let (bound, passages) = (&self.bound, &self.passages);
        let reached = flow.run(
            ways,
            bound,
            passages,
            way,
            &mut undecided,
            |undecided, reached| {
                lines.extend(aim(ways, way, reached, twice, undecided));
            },
        );
        let dropped = ones_besides(&undecided, reached)
            .map(|then| then as u32)
            .collect();
        FlowResult { dropped, lines }
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
