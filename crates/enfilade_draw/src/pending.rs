//! Spans to be shaded, and the faces they belong to.

use enfilade::{Owner, Span};
use rayon::prelude::*;

/// Spans to be shaded, collected until a batch is full.
#[derive(Default)]
pub(crate) struct Pending {
    /// Faces of the spans. A face may occur twice, when `slots` has lost it.
    owners: Vec<Owner>,
    spans: Vec<PendingSpan>,
    /// The spans sorted by band, and the start of each band.
    sorted: Vec<PendingSpan>,
    begins: Vec<usize>,
    /// Hash table from a face to its index in `owners` plus one; 0 for an empty slot. Collisions overwrite.
    slots: Vec<u32>,
    samples: u64,
}

/// A span, with the index of its face among the owners.
#[derive(Clone, Copy)]
pub(crate) struct PendingSpan {
    pub(crate) y: u16,
    pub(crate) x0: u16,
    pub(crate) x1: u16,
    pub(crate) see_through: bool,
    pub(crate) owner: u32,
}

/// Maximum number of pending spans.
const MAX_SPANS: usize = 1 << 16;
/// Slots of the hash table: a face recurs in the next row, and is found again if fewer faces than this come between.
const SLOTS: usize = 1 << 13;

impl Pending {
    pub(crate) fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Whether it is time to shade. With shadows, each batch is tested against all that casts them, so batches are larger.
    pub(crate) fn is_full(&self, shadows: bool) -> bool {
        self.spans.len() >= if shadows { 16 * MAX_SPANS } else { MAX_SPANS }
    }

    pub(crate) fn samples(&self) -> u64 {
        self.samples
    }

    pub(crate) fn owners(&self) -> &[Owner] {
        &self.owners
    }

    pub(crate) fn push(&mut self, y: u16, span: &Span) {
        let owner = self.index(span.owner);
        self.samples += u64::from(span.x1 - span.x0);
        self.spans.push(PendingSpan {
            y,
            x0: span.x0,
            x1: span.x1,
            see_through: span.see_through,
            owner,
        });
    }

    /// Returns the index of a face among the owners; adds it if necessary.
    fn index(&mut self, owner: Owner) -> u32 {
        self.slots.resize(SLOTS, 0);
        let slot = match owner {
            Owner::Face(item, face) => item.0.wrapping_mul(0x9E37_79B9).wrapping_add(face) as usize,
            Owner::Opening(opening) => usize::from(opening.0),
        };
        let entry = &mut self.slots[slot % SLOTS];
        let before = entry.checked_sub(1);
        match before {
            Some(index) if self.owners[index as usize] == owner => index,
            _ => {
                self.owners.push(owner);
                *entry = self.owners.len() as u32;
                *entry - 1
            }
        }
    }

    /// Sorts the spans by bands of `band` rows, stably.
    pub(crate) fn sort(&mut self, rows: usize, band: usize) {
        let bands = rows.div_ceil(band);
        let of = |span: &PendingSpan| usize::from(span.y) / band;
        self.begins.clear();
        self.begins.resize(bands + 1, 0);
        for span in &self.spans {
            self.begins[of(span) + 1] += 1;
        }
        for i in 0..bands {
            self.begins[i + 1] += self.begins[i];
        }
        self.sorted.clone_from(&self.spans);
        let mut next = self.begins.clone();
        for span in &self.spans {
            let index = &mut next[of(span)];
            self.sorted[*index] = *span;
            *index += 1;
        }
    }

    /// Returns the spans of each band, after [`Pending::sort`].
    pub(crate) fn bands(&self) -> impl IndexedParallelIterator<Item = &[PendingSpan]> {
        self.begins
            .par_windows(2)
            .map(|ends| &self.sorted[ends[0]..ends[1]])
    }

    pub(crate) fn clear(&mut self) {
        self.owners.clear();
        self.spans.clear();
        self.slots.fill(0);
        self.samples = 0;
    }
}
