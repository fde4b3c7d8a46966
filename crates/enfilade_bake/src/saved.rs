//! Saves and resumes work. The passages are saved separately: they are large and do not change once computed.
//!
//! Format: little-endian 64-bit words. A magic number with the version, a hash of the cells, the stage and the progress
//! in it, the numbers of ways and cells, the hash of the flow's start, the shard, the bit rows without zero words, the
//! order of ways, the rows of the shard, and a checksum. The checksum detects damage and the hash detects other cells.
//! All remaining values are validated, so no input causes a panic.

use crate::bits::{BitRows, pack};
use crate::cells::Cells;
use crate::known::LowerBound;
use crate::passages::Passages;
use crate::shards::{Shard, ShardRows};
use crate::ways::Ways;
use crate::work::{PairsWork, Stage, TooLarge, WorkProgress};
use thiserror::Error;

/// Change the version with the format, and with any change of the algorithm: a different one must not resume this work.
const MARK: u64 = u64::from_le_bytes(*b"ENFvis4\n");
const MARK_OF_PASSAGES: u64 = u64::from_le_bytes(*b"ENFpas3\n");

/// Number of words before the rows: magic number, hash, stage, progress, ways, cells, start of the flow, index and
/// count of the shard. The count is 0 if the work is not on a shard.
const HEAD: usize = 9;

/// Reason why saved work cannot be resumed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// Not written by [`PairsWork::save`], or by another version.
    #[error("is not saved work of this version")]
    Foreign,
    /// Truncated or corrupt.
    #[error("is truncated or corrupt")]
    Damaged,
    /// Saved for other cells or portals.
    #[error("was saved for other portals")]
    Other,
    /// The computation could exceed its memory limit.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

impl PairsWork {
    /// Saves the work without its passages, for [`PairsWork::resume`].
    pub fn save(&self) -> Vec<u8> {
        let WorkProgress {
            stage,
            next,
            bound,
            known,
            sampled,
            chains,
            order,
            start,
            shard,
        } = self.saved.as_ref().unwrap_or(&self.progress);
        let [index, count] = shard
            .as_ref()
            .map_or([0; 2], |rows| [rows.shard.index(), rows.shard.count()]);
        let mut words = vec![MARK, mark_of(&self.ways), *stage as u64, *next as u64];
        words.extend([self.ways.count() as u64, self.ways.cells() as u64, *start]);
        words.extend([index, count].map(u64::from));
        let sampled = sampled.as_ref().map(|sampled| &sampled.cells);
        let rows = [Some(bound), Some(&known.cells), sampled, chains.as_ref()];
        rows.into_iter()
            .flatten()
            .for_each(|rows| pack(rows.words(), &mut words));
        words.extend(order.iter().map(|&way| u64::from(way)));
        if let Some(rows) = shard {
            rows.pack(&mut words);
        }
        bytes_of(words)
    }

    /// Saves the passages computed so far. They change only during [`Stage::Passages`].
    pub fn save_passages(&self) -> Vec<u8> {
        let ways = self.ways_with_passages();
        let head = [MARK_OF_PASSAGES, mark_of(&self.ways), ways as u64];
        bytes_of([&head, self.passages.words()].concat())
    }

    /// Returns the number of ways whose passages are computed.
    fn ways_with_passages(&self) -> usize {
        match self.progress.stage {
            Stage::FirstBound => 0,
            Stage::Passages => self.progress.next,
            _ => self.ways.count(),
        }
    }

    /// Resumes saved work on the same cells. It ends with the same result as work that was never stopped.
    ///
    /// `passages` comes from [`PairsWork::save_passages`], called at the same time or later. If it is missing, damaged
    /// or older, the passages are recomputed.
    ///
    /// # Errors
    /// If `saved` is not saved work on these cells, or [`PairsWork::begin`] fails.
    pub fn resume(
        cells: &Cells,
        limit_bytes: u64,
        saved: &[u8],
        passages: &[u8],
    ) -> Result<PairsWork, ResumeError> {
        let mut work = PairsWork::begin(cells, limit_bytes)?;
        let payload = payload_of(saved, MARK)?;
        let [ways, cell_count] = [work.ways.count(), work.ways.cells()];
        if payload.len() < HEAD {
            return Err(ResumeError::Damaged);
        }
        if payload[1] != mark_of(&work.ways) || payload[4..6] != [ways as u64, cell_count as u64] {
            return Err(ResumeError::Other);
        }
        let saved = read(&payload, ways, cell_count).ok_or(ResumeError::Damaged)?;
        let with_passages = match saved.stage {
            Stage::FirstBound => 0,
            _ => work.read_passages(passages).unwrap_or(0),
        };
        if saved.stage == Stage::Passages {
            work.restore(saved);
            work.progress.next = with_passages;
            if with_passages == ways {
                work.step();
            }
        } else if saved.stage == Stage::FirstBound || with_passages == ways {
            work.restore(saved);
        } else {
            work.passages = Passages::none(&work.ways);
            work.saved = Some(saved);
        }
        Ok(work)
    }

    /// Restores saved passages; returns the number of ways that they cover, or `None` if they belong to other cells.
    fn read_passages(&mut self, passages: &[u8]) -> Option<usize> {
        let payload = payload_of(passages, MARK_OF_PASSAGES).ok()?;
        let (head, packed) = payload.split_at_checked(3)?;
        let ways = usize::try_from(head[2]).ok()?;
        if head[1] != mark_of(&self.ways) || ways > self.ways.count() {
            return None;
        }
        self.passages = Passages::from_words(&self.ways, ways, packed)?;
        Some(ways)
    }
}

/// Returns a hash that identifies the cells and portals.
pub(crate) fn mark_of(ways: &Ways) -> u64 {
    sum_of(ways.all.iter().flat_map(|way| {
        let corners = way
            .corners
            .iter()
            .flat_map(|corner| corner.to_array().map(f64::to_bits));
        [way.from.into(), way.to.into(), way.corners.len() as u64]
            .into_iter()
            .chain(corners)
    }))
}

/// Appends the checksum to the words and returns them as bytes.
pub(crate) fn bytes_of(mut words: Vec<u64>) -> Vec<u8> {
    words.push(sum_of(words.iter().copied()));
    let mut bytes = vec![0; words.len() * 8];
    for (bytes, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
    bytes
}

/// Verifies the magic number and the checksum, and returns the words without the checksum.
pub(crate) fn payload_of(bytes: &[u8], mark: u64) -> Result<Vec<u64>, ResumeError> {
    let (words, rest) = bytes.as_chunks::<8>();
    let mut words: Vec<u64> = words.iter().map(|&word| u64::from_le_bytes(word)).collect();
    if words.first() != Some(&mark) {
        return Err(ResumeError::Foreign);
    }
    let sum = words.pop();
    if rest.is_empty() && sum == Some(sum_of(words.iter().copied())) {
        Ok(words)
    } else {
        Err(ResumeError::Damaged)
    }
}

/// Returns `None` if words are missing, left over, or out of range.
fn read(payload: &[u64], ways: usize, cells: usize) -> Option<WorkProgress> {
    let stages = Stage::ALL.into_iter().chain([Stage::Done]);
    let stage = stages.into_iter().find(|&stage| stage as u64 == payload[2])?;
    let next = usize::try_from(payload[3]).ok().filter(|&next| next <= ways)?;
    let (bound, rest) = BitRows::unpack(ways, ways, &payload[HEAD..])?;
    let (known, mut rest) = BitRows::unpack(cells, cells, rest)?;
    let (mut sampled, mut chains) = (None, None);
    if stage == Stage::Flow {
        let cells = take_rows(cells, &mut rest)?;
        sampled = Some(LowerBound { cells });
    } else if stage == Stage::Backflow {
        chains = Some(take_rows(ways, &mut rest)?);
    }
    let (order, rest) = rest.split_at_checked(if stage <= Stage::Sampling { 0 } else { ways })?;
    let order: Vec<u32> = order
        .iter()
        .map(|&way| u32::try_from(way).ok().filter(|&way| (way as usize) < ways))
        .collect::<Option<_>>()?;
    let shard = match [payload[7], payload[8]] {
        [0, 0] if rest.is_empty() => None,
        [index, count] => {
            let shard = Shard::new(u32::try_from(index).ok()?, u32::try_from(count).ok()?)?;
            let flows = match stage {
                Stage::Flow => next,
                _ => order.len(),
            };
            Some(ShardRows::unpack(shard, flows, ways, rest)?)
        }
    };
    Some(WorkProgress {
        stage,
        next,
        bound,
        known: LowerBound { cells: known },
        sampled,
        chains,
        order,
        start: payload[6],
        shard,
    })
}

/// Reads square bit rows from the beginning of the words.
fn take_rows(size: usize, words: &mut &[u64]) -> Option<BitRows> {
    let (rows, rest) = BitRows::unpack(size, size, words)?;
    *words = rest;
    Some(rows)
}

/// FNV-1a hash (Fowler, Noll, Vo), one word at a time.
pub(crate) fn sum_of(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |sum, word| {
        (sum ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
    })
}
