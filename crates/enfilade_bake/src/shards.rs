//! Shards: splits the flow between machines, with the same PVS as one run.
//!
//! A shard begins like any work, or resumes such work that another machine has saved at the beginning of the flow, but
//! runs only every so many batches of the flow. It knows the drops of its own batches
//! only, so the bound of each of its flows contains that of one run. Hence two of its findings hold there, too: a way
//! that no chain reaches in the larger bound is reached in no smaller one, and a way that a ray crosses is reached in
//! any. Work that has the parts of all shards runs the whole flow again in the order of one run, but searches only for
//! ways that are in neither group, which are few.
//! Cost: without the drops of the others a shard takes longer per flow; together they take about twice the time of the
//! flow of one run.

use crate::bits::{BitRows, PackedRows, pack};
use crate::cells::Cells;
use crate::known::{LowerBound, after};
use crate::saved::{ResumeError, bytes_of, mark_of, payload_of};
use crate::ways::Ways;
use crate::work::{FLOWS, FlowResult, PairsWork, Stage};
use std::fmt::{self, Display, Formatter};
use thiserror::Error;

/// Change the version with the format, and with that of saved work.
const MARK_OF_PARTS: u64 = u64::from_le_bytes(*b"ENFprt4\n");

/// Number of words before the rows: magic number, hash, start, index and count of the shard, ways, cells, and the
/// number of words of the dropped ways.
const HEAD: usize = 8;

/// One of several equal shares of a task, numbered from 0. Its text is `INDEX/COUNT`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    count: u32,
}

impl Shard {
    /// Returns `None` if `index` is not below `count`.
    pub fn new(index: u32, count: u32) -> Option<Shard> {
        (index < count).then_some(Shard { index, count })
    }

    /// Returns the number of this shard, from 0.
    pub fn index(self) -> u32 {
        self.index
    }

    /// Returns the number of shards.
    pub fn count(self) -> u32 {
        self.count
    }

    /// Returns `true` if this shard does the part of the task with this number. Neighbouring numbers, which often cost
    /// about the same, belong to different shards.
    pub fn has(self, number: usize) -> bool {
        number % self.count as usize == self.index as usize
    }
}

impl Display for Shard {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.count)
    }
}

/// The ways that each flow of a shard has decided, one row per flow, in the order of the flows.
#[derive(Clone, Debug)]
pub(crate) struct ShardRows {
    pub(crate) shard: Shard,
    /// Ways that no chain reaches.
    dropped: PackedRows,
    /// Ways that a ray crosses.
    proven: PackedRows,
}

impl ShardRows {
    fn none(shard: Shard, ways: usize) -> ShardRows {
        ShardRows {
            shard,
            dropped: PackedRows::new(ways),
            proven: PackedRows::new(ways),
        }
    }

    /// Appends the result of a flow.
    pub(crate) fn add(&mut self, ways: &Ways, way: u32, found: &FlowResult) {
        let crossed = found.lines.iter().flat_map(|line| after(way as usize, line));
        self.proven.push(&words_of(ways, crossed));
        self.dropped.push(&words_of(ways, found.dropped.iter().copied()));
    }

    /// Appends the words of both kinds of rows, and before them the number of those of the dropped ways.
    pub(crate) fn pack(&self, words: &mut Vec<u64>) {
        words.push(self.dropped.words().len() as u64);
        words.extend(self.dropped.words());
        words.extend(self.proven.words());
    }

    /// Reads what [`ShardRows::pack`] wrote, for the flows before index `flows` of the order.
    pub(crate) fn unpack(shard: Shard, flows: usize, ways: usize, words: &[u64]) -> Option<ShardRows> {
        let (&length, words) = words.split_first()?;
        let (dropped, proven) = words.split_at_checked(usize::try_from(length).ok()?)?;
        let rows = (0..flows).filter(|at| shard.has(at / FLOWS)).count();
        Some(ShardRows {
            shard,
            dropped: PackedRows::from_words(rows, ways, dropped)?,
            proven: PackedRows::from_words(rows, ways, proven)?,
        })
    }
}

/// Returns the nonzero words of a set of ways, with their indices.
fn words_of(ways: &Ways, set: impl Iterator<Item = u32>) -> Vec<(u32, u64)> {
    let mut row = BitRows::new(1, ways.count());
    set.for_each(|way| row.put(0, way as usize));
    let words = (0..).zip(row.words().iter().copied());
    words.filter(|&(_, word)| word != 0).collect()
}

/// What one shard has found: its part of the flow.
#[derive(Clone, Debug)]
pub struct FlowPart {
    start: u64,
    known: LowerBound,
    rows: ShardRows,
}

/// Reason why a part cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PartError {
    /// Not written by [`PairsWork::save_part`], or by another version.
    #[error("is not a part of this version")]
    Foreign,
    /// Truncated or corrupt.
    #[error("is truncated or corrupt")]
    Damaged,
    /// Of other cells or portals.
    #[error("is a part of other portals")]
    Other,
    /// The flow of the part began with other bounds.
    #[error("began with other bounds than this work")]
    OtherStart,
}

/// The ways that a flow of a shard has decided: nonzero words, with their indices.
pub(crate) struct DecidedWays<D, P> {
    pub(crate) dropped: D,
    pub(crate) proven: P,
}

impl FlowPart {
    /// Reads a part that [`PairsWork::save_part`] wrote.
    ///
    /// # Errors
    /// [`PartError::Foreign`], [`PartError::Damaged`] or [`PartError::Other`].
    pub fn from_bytes(cells: &Cells, bytes: &[u8]) -> Result<FlowPart, PartError> {
        let payload = payload_of(bytes, MARK_OF_PARTS).map_err(|why| match why {
            ResumeError::Foreign => PartError::Foreign,
            _ => PartError::Damaged,
        })?;
        let all = Ways::of(cells);
        let [ways, cell_count] = [all.count(), all.cells()];
        if payload.len() < HEAD {
            return Err(PartError::Damaged);
        }
        if payload[1] != mark_of(&all) || payload[5..HEAD - 1] != [ways as u64, cell_count as u64] {
            return Err(PartError::Other);
        }
        let read = || {
            let [index, count] = [payload[3], payload[4]].map(|word| u32::try_from(word).ok());
            let shard = Shard::new(index?, count?)?;
            let length = usize::try_from(payload[HEAD - 1]).ok()?;
            let (rows, known) = payload[HEAD..].split_at_checked(length)?;
            let (known, rest) = BitRows::unpack(cell_count, cell_count, known)?;
            rest.is_empty().then_some(FlowPart {
                start: payload[2],
                known: LowerBound { cells: known },
                rows: ShardRows::unpack(shard, ways, ways, rows)?,
            })
        };
        read().ok_or(PartError::Damaged)
    }

    /// Returns the shard that has computed it.
    pub fn shard(&self) -> Shard {
        self.rows.shard
    }

    /// Returns the ways decided by the flow at an index of the order; `None` if it is not of this shard.
    pub(crate) fn decided(
        &self,
        at: usize,
    ) -> Option<DecidedWays<impl Iterator<Item = (usize, u64)>, impl Iterator<Item = (usize, u64)>>> {
        let ShardRows {
            shard,
            dropped,
            proven,
        } = &self.rows;
        let batch = at / FLOWS;
        // All earlier batches of the shard are full.
        let row = batch / shard.count as usize * FLOWS + at % FLOWS;
        shard.has(batch).then(|| DecidedWays {
            dropped: dropped.row(row),
            proven: proven.row(row),
        })
    }
}

impl PairsWork {
    /// Limits the work to one share of the flow. It is over when it reaches [`Stage::Backflow`]. Returns `None` if the
    /// flow has begun.
    ///
    /// All shards begin the flow with the same work, so one machine may compute it for all: saved at the beginning of
    /// the flow, and resumed for each shard and for the merge.
    ///
    /// ```
    /// use enfilade_bake::{Cells, FlowPart, PairsWork, Portal, Shard, Stage, VisiblePairs};
    ///
    /// let door = vec![[10.0, -1.0, 0.0], [10.0, 1.0, 0.0], [10.0, 1.0, 2.0], [10.0, -1.0, 2.0]];
    /// let rooms = Cells::new(2, vec![Portal { corners: door, cells: [0, 1] }])?;
    /// let mut work = PairsWork::begin(&rooms, 1 << 30)?;
    /// while work.stage() < Stage::Flow {
    ///     work.step();
    /// }
    /// let (saved, passages) = (work.save(), work.save_passages());
    /// // Each on a machine of its own:
    /// let mut parts = Vec::new();
    /// for index in 0..3 {
    ///     let shard = Shard::new(index, 3).expect("it is below 3");
    ///     let work = PairsWork::resume(&rooms, 1 << 30, &saved, &passages)?;
    ///     let mut work = work.with_shard(shard).expect("the flow has not begun");
    ///     while work.stage() < Stage::Backflow {
    ///         work.step();
    ///     }
    ///     parts.extend(work.save_part());
    /// }
    /// // On one of them:
    /// for part in &parts {
    ///     work.add_part(FlowPart::from_bytes(&rooms, part)?)?;
    /// }
    /// while work.stage() < Stage::Done {
    ///     work.step();
    /// }
    /// assert_eq!(work.pairs().count(), 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_shard(mut self, shard: Shard) -> Option<PairsWork> {
        let progress = self.saved.as_mut().unwrap_or(&mut self.progress);
        let has_begun = progress.stage > Stage::Flow || (progress.stage == Stage::Flow && progress.next > 0);
        progress.shard = Some(ShardRows::none(shard, self.ways.count()));
        (!has_begun).then_some(self)
    }

    /// Returns the shard that this work computes; `None` if it computes everything.
    pub fn shard(&self) -> Option<Shard> {
        let progress = self.saved.as_ref().unwrap_or(&self.progress);
        progress.shard.as_ref().map(|rows| rows.shard)
    }

    /// Saves what a shard has found; `None` before [`Stage::Backflow`], and if the work is not on a shard.
    pub fn save_part(&self) -> Option<Vec<u8>> {
        let rows = self.progress.shard.as_ref()?;
        if self.progress.stage < Stage::Backflow {
            return None;
        }
        let Shard { index, count } = rows.shard;
        let mut words = vec![MARK_OF_PARTS, mark_of(&self.ways), self.progress.start];
        words.extend([index, count].map(u64::from));
        words.extend([self.ways.count() as u64, self.ways.cells() as u64, 0]);
        rows.pack(&mut words);
        words[HEAD - 1] = (words.len() - HEAD) as u64;
        pack(self.progress.known.cells.words(), &mut words);
        Some(bytes_of(words))
    }

    /// Adds what a shard has found, which saves most of the flow. The result is the same without it. Call it when the
    /// work has reached [`Stage::Flow`].
    ///
    /// # Errors
    /// [`PartError::OtherStart`] if the part was computed with other bounds, and before [`Stage::Flow`].
    pub fn add_part(&mut self, part: FlowPart) -> Result<(), PartError> {
        let progress = self.saved.as_mut().unwrap_or(&mut self.progress);
        if progress.stage < Stage::Flow || part.start != progress.start {
            return Err(PartError::OtherStart);
        }
        progress.known.add(&part.known);
        self.parts.push(part);
        Ok(())
    }
}
