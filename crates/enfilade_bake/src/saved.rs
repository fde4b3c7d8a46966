//! Work that was stopped, as bytes: what has been found out so far, and apart from that the passages, which are many and do not
//! change once they are computed.
//!
//! 64-bit words, the lowest byte first: a mark, of which cells, the stage and how far it is, how many ways and cells, the
//! rows of bits without words that are zero, the order, and a sum over all that. Corrupt bytes are found out by the sum, other
//! cells by their mark; what is left is checked, so that no bytes lead to a panic.

use crate::bits::{BitRows, pack};
use crate::cells::Cells;
use crate::known::Known;
use crate::passages::Passages;
use crate::work::{PairsWork, Stage, TooLarge};
use thiserror::Error;

/// Change with the format, and with what the work does: other work does not go on where this one stopped.
const MARK: u64 = u64::from_le_bytes(*b"ENFvis3\n");
const MARK_OF_PASSAGES: u64 = u64::from_le_bytes(*b"ENFpas3\n");

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
    /// Returns what has been found out so far, without the passages, as bytes that [`PairsWork::resume`] goes on from.
    pub fn save(&self) -> Vec<u8> {
        if let Some(saved) = &self.saved {
            let Saved {
                stage,
                next,
                bound,
                known,
                order,
            } = saved;
            return self.bytes(*stage, *next, bound, known, order);
        }
        self.bytes(self.stage, self.next, &self.bound, &self.known, &self.order)
    }

    /// Returns the passages computed so far. They change in [`Stage::Passages`] alone.
    pub fn save_passages(&self) -> Vec<u8> {
        let ways = self.ways_with_passages();
        let head = [MARK_OF_PASSAGES, self.mark(), ways as u64];
        bytes_of([&head, self.passages.words()].concat())
    }

    /// Returns the number of ways whose passages are computed.
    fn ways_with_passages(&self) -> usize {
        match self.stage {
            Stage::FirstBound => 0,
            Stage::Passages => self.next,
            _ => self.ways.count(),
        }
    }

    /// Returns work that goes on where other work on the same cells was when it was saved; its end is the same as if it had
    /// never stopped.
    ///
    /// `passages` is what [`PairsWork::save_passages`] returned, then or later. Where it is missing or damaged the passages are
    /// computed again, as they are if it was saved earlier.
    ///
    /// # Errors
    /// Where `saved` is not of such work, or [`PairsWork::begin`] fails.
    pub fn resume(
        cells: &Cells,
        limit_bytes: u64,
        saved: &[u8],
        passages: &[u8],
    ) -> Result<PairsWork, ResumeError> {
        let mut work = PairsWork::begin(cells, limit_bytes)?;
        let content = content_of(saved, MARK)?;
        let [ways, cell_count] = [work.ways.count(), work.ways.cells()];
        if content.len() < HEAD {
            return Err(ResumeError::Damaged);
        }
        if content[1] != work.mark() || content[4..HEAD] != [ways as u64, cell_count as u64] {
            return Err(ResumeError::Other);
        }
        let saved = read(&content, ways, cell_count).ok_or(ResumeError::Damaged)?;
        let with_passages = match saved.stage {
            Stage::FirstBound => 0,
            _ => work.read_passages(passages).unwrap_or(0),
        };
        if saved.stage == Stage::Passages {
            work.go_on_from(saved);
            work.next = with_passages;
            if with_passages == ways {
                work.step();
            }
        } else if saved.stage == Stage::FirstBound || with_passages == ways {
            work.go_on_from(saved);
        } else {
            work.passages = Passages::none(&work.ways);
            work.saved = Some(saved);
        }
        Ok(work)
    }

    /// Takes over saved passages; returns of how many ways, `None` if it is not those of these cells.
    fn read_passages(&mut self, passages: &[u8]) -> Option<usize> {
        let content = content_of(passages, MARK_OF_PASSAGES).ok()?;
        let (head, packed) = content.split_at_checked(3)?;
        let ways = usize::try_from(head[2]).ok()?;
        if head[1] != self.mark() || ways > self.ways.count() {
            return None;
        }
        self.passages = Passages::from_words(&self.ways, ways, packed)?;
        Some(ways)
    }

    fn bytes(&self, stage: Stage, next: usize, bound: &BitRows, known: &Known, order: &[u32]) -> Vec<u8> {
        let head = [MARK, self.mark(), stage as u64, next as u64];
        let counts = [self.ways.count() as u64, self.ways.cells() as u64];
        let mut words: Vec<u64> = head.into_iter().chain(counts).collect();
        for rows in [bound, &known.cells] {
            pack(rows.words(), &mut words);
        }
        words.extend(order.iter().map(|&way| u64::from(way)));
        bytes_of(words)
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

/// Returns the words and a sum over them as bytes.
fn bytes_of(mut words: Vec<u64>) -> Vec<u8> {
    words.push(sum_of(words.iter().copied()));
    let mut bytes = vec![0; words.len() * 8];
    for (bytes, word) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
    bytes
}

/// Returns the words that have the mark and the right sum, without that.
fn content_of(bytes: &[u8], mark: u64) -> Result<Vec<u64>, ResumeError> {
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

/// `None` where words are missing, left over, or make no sense.
fn read(content: &[u64], ways: usize, cells: usize) -> Option<Saved> {
    let stages = Stage::ALL.into_iter().chain([Stage::Done]);
    let stage = stages.into_iter().find(|&stage| stage as u64 == content[2])?;
    let next = usize::try_from(content[3]).ok().filter(|&next| next <= ways)?;
    let (bound, rest) = BitRows::unpack(ways, ways, &content[HEAD..])?;
    let (known, rest) = BitRows::unpack(cells, cells, rest)?;
    let order: Vec<u32> = rest
        .iter()
        .map(|&way| u32::try_from(way).ok().filter(|&way| (way as usize) < ways))
        .collect::<Option<_>>()?;
    let wanted = if stage <= Stage::Sampling { 0 } else { ways };
    (order.len() == wanted).then_some(Saved {
        stage,
        next,
        bound,
        known: Known { cells: known },
        order,
    })
}

/// FNV-1a (Fowler, Noll, Vo), a word at a time.
fn sum_of(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |sum, word| {
        (sum ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
    })
}
