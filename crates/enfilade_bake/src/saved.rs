//! Work that was stopped, as bytes: what has been found out since the fast bound, which is computed again.
//!
//! 64-bit words, the lowest byte first: a mark, of which cells, the stage and how far it is, how many ways and cells, the
//! rows of bits, the order, and a sum over all that. Corrupt bytes are found out by the sum, other cells by their mark;
//! what is left is checked, so that no bytes lead to a panic.

use crate::bits::BitRows;
use crate::cells::Cells;
use crate::known::Known;
use crate::work::{PairsWork, Stage, TooLarge};
use thiserror::Error;

/// Changes with the format, and with what the work does: other work does not go on where this one stopped.
const MARK: u64 = u64::from_le_bytes(*b"ENFvis1\n");

/// Words before the rows: mark, cells, stage, how far, ways, cells.
const HEAD: usize = 6;

/// Why work does not go on from bytes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// Not written by [`PairsWork::save`], or by another version of it.
    #[error("is no saved work of this version")]
    Foreign,
    /// Cut short, or changed since.
    #[error("is damaged")]
    Damaged,
    /// Of other cells and portals.
    #[error("is saved work on other portals")]
    Other,
    /// The work would take too much memory.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

/// What has been found out.
#[derive(Clone, Debug)]
pub(crate) struct Saved {
    pub(crate) stage: Stage,
    pub(crate) next: usize,
    pub(crate) bound: BitRows,
    pub(crate) known: Known,
    pub(crate) order: Vec<u32>,
}

impl PairsWork {
    /// What has been found out so far, as bytes that [`PairsWork::resume`] goes on from; `None` up to the fast bound,
    /// which takes little.
    pub fn save(&self) -> Option<Vec<u8>> {
        if let Some(saved) = &self.saved {
            let Saved {
                stage,
                next,
                bound,
                known,
                order,
            } = saved;
            return Some(self.bytes(*stage, *next, bound, known, order));
        }
        (self.stage >= Stage::Sampling)
            .then(|| self.bytes(self.stage, self.next, &self.bound, &self.known, &self.order))
    }

    /// Work that goes on where other work on the same cells was when it was saved, once the fast bound is computed again;
    /// its end is the same as if it had never stopped.
    ///
    /// # Errors
    /// Where the bytes are not of such work, or [`PairsWork::begin`] fails.
    pub fn resume(cells: &Cells, limit_bytes: u64, saved: &[u8]) -> Result<PairsWork, ResumeError> {
        let mut work = PairsWork::begin(cells, limit_bytes)?;
        let words: Vec<u64> = saved
            .as_chunks()
            .0
            .iter()
            .map(|&word| u64::from_le_bytes(word))
            .collect();
        if words.first() != Some(&MARK) {
            return Err(ResumeError::Foreign);
        }
        let (content, sum) = words.split_at(words.len() - 1);
        if !saved.len().is_multiple_of(8) || words.len() <= HEAD || sum != [sum_of(content.iter().copied())] {
            return Err(ResumeError::Damaged);
        }
        let [ways, cell_count] = [work.ways.count(), work.ways.cells()];
        if content[1] != work.mark() || content[4..HEAD] != [ways as u64, cell_count as u64] {
            return Err(ResumeError::Other);
        }
        work.saved = Some(read(content, ways, cell_count).ok_or(ResumeError::Damaged)?);
        Ok(work)
    }

    fn bytes(&self, stage: Stage, next: usize, bound: &BitRows, known: &Known, order: &[u32]) -> Vec<u8> {
        let head = [MARK, self.mark(), stage as u64, next as u64];
        let counts = [self.ways.count() as u64, self.ways.cells() as u64];
        let rows = [bound, &known.ways, &known.cells];
        let words = || {
            let rows = rows.into_iter().flat_map(BitRows::words).copied();
            let order = order.iter().map(|&way| u64::from(way));
            head.into_iter().chain(counts).chain(rows).chain(order)
        };
        let sum = sum_of(words());
        let mut bytes = Vec::with_capacity(8 * (words().count() + 1));
        bytes.extend(words().chain([sum]).flat_map(u64::to_le_bytes));
        bytes
    }

    /// Tells one set of cells and portals from others.
    fn mark(&self) -> u64 {
        sum_of(self.ways.all.iter().flat_map(|way| {
            let corners = way
                .corners
                .iter()
                .flat_map(|corner| corner.to_array().map(f64::to_bits));
            [way.from.into(), way.to.into(), way.corners.len() as u64]
                .into_iter()
                .chain(corners)
        }))
    }
}

/// `None` where words are missing, left over, or make no sense.
fn read(content: &[u64], ways: usize, cells: usize) -> Option<Saved> {
    let stage = match content[2] {
        stage if stage == Stage::Sampling as u64 => Stage::Sampling,
        stage if stage == Stage::Flow as u64 => Stage::Flow,
        stage if stage == Stage::Backflow as u64 => Stage::Backflow,
        stage if stage == Stage::Done as u64 => Stage::Done,
        _ => return None,
    };
    let next = usize::try_from(content[3]).ok().filter(|&next| next <= ways)?;
    let mut rest = &content[HEAD..];
    let mut rows = |count: usize| {
        let (rows, after) = BitRows::read(count, count, rest)?;
        rest = after;
        Some(rows)
    };
    let bound = rows(ways)?;
    let known = Known {
        ways: rows(ways)?,
        cells: rows(cells)?,
    };
    let order: Vec<u32> = rest
        .iter()
        .map(|&way| u32::try_from(way).ok().filter(|&way| (way as usize) < ways))
        .collect::<Option<_>>()?;
    let wanted = if stage == Stage::Sampling { 0 } else { ways };
    (order.len() == wanted).then_some(Saved {
        stage,
        next,
        bound,
        known,
        order,
    })
}

/// FNV-1a (Fowler, Noll, Vo), a word at a time.
fn sum_of(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |sum, word| {
        (sum ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
    })
}
