//! Spans that wait to be shaded, and the faces that they are of.

use enfilade::{Owner, Span};
use rayon::prelude::*;

/// Spans that wait to be shaded.
#[derive(Default)]
pub(crate) struct Pending {
    /// Each face once, but for what the table below forgets.
    owners: Vec<Owner>,
    spans: Vec<Waiting>,
    /// The spans by bands, and where those of each band begin.
    sorted: Vec<Waiting>,
    begins: Vec<usize>,
    /// Where a face stands among the owners, plus one, by a hash of it; 0 for nowhere.
    known: Vec<u32>,
    samples: u64,
}

/// A span, and the place of its face among the owners.
#[derive(Clone, Copy)]
pub(crate) struct Waiting {
    pub(crate) y: u16,
    pub(crate) x0: u16,
    pub(crate) x1: u16,
    pub(crate) see_through: bool,
    pub(crate) owner: u32,
}

/// Spans that wait, at most.
const MAX_SPANS: usize = 1 << 16;
/// A face is met again in its next row: so many are found again, if they are not more.
const KNOWN: usize = 1 << 13;

impl Pending {
    pub(crate) fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    pub(crate) fn is_full(&self) -> bool {
        self.spans.len() >= MAX_SPANS
    }

    pub(crate) fn samples(&self) -> u64 {
        self.samples
    }

    pub(crate) fn owners(&self) -> &[Owner] {
        &self.owners
    }

    pub(crate) fn push(&mut self, y: u16, span: &Span) {
        let owner = self.place(span.owner);
        self.samples += u64::from(span.x1 - span.x0);
        self.spans.push(Waiting {
            y,
            x0: span.x0,
            x1: span.x1,
            see_through: span.see_through,
            owner,
        });
    }

    /// Where a face stands among the owners.
    fn place(&mut self, owner: Owner) -> u32 {
        self.known.resize(KNOWN, 0);
        let slot = match owner {
            Owner::Face(item, face) => item.0.wrapping_mul(0x9E37_79B9).wrapping_add(face) as usize,
            Owner::Opening(opening) => usize::from(opening.0),
        };
        let known = &mut self.known[slot % KNOWN];
        let before = known.checked_sub(1);
        match before {
            Some(place) if self.owners[place as usize] == owner => place,
            _ => {
                self.owners.push(owner);
                *known = self.owners.len() as u32;
                *known - 1
            }
        }
    }

    /// Sorts the spans by bands of so many rows; in each they keep the order in which they came.
    pub(crate) fn sort(&mut self, rows: usize, band: usize) {
        let bands = rows.div_ceil(band);
        let of = |span: &Waiting| usize::from(span.y) / band;
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
            let place = &mut next[of(span)];
            self.sorted[*place] = *span;
            *place += 1;
        }
    }

    /// The spans of each band, once they are sorted.
    pub(crate) fn bands(&self) -> impl IndexedParallelIterator<Item = &[Waiting]> {
        self.begins
            .par_windows(2)
            .map(|ends| &self.sorted[ends[0]..ends[1]])
    }

    pub(crate) fn clear(&mut self) {
        self.owners.clear();
        self.spans.clear();
        self.known.fill(0);
        self.samples = 0;
    }
}
