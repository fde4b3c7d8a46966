//! Upper bound by separating planes of consecutive portals, propagated to a fixpoint.
//!
//! A passage is a way into a cell and a way out of it. Whatever is outside the separating planes of the two cannot be
//! crossed after them. So the bound of a way is the union, over the passages that begin with it, of their second way
//! and the ways that are both in the second way's bound and in the passage. A smaller bound shrinks others, until
//! nothing changes.
//! Source: Teller, Séquin 1991 for the planes; the fixpoint is new.
//! Cost: each passage tests the intersection of its ways' bounds, mostly by bounding spheres; the fixpoint combines
//! words of bits.
//! Conservative: visibility is symmetric, so a pair that one end drops is dropped from the other end too.

use crate::bits::{BitRows, PackedRows, ones_besides, put};
use crate::separators::Separators;
use crate::ways::Ways;
use rayon::prelude::*;
use std::ops::Range;

/// For each passage, the ways that a ray may cross after it.
#[derive(Debug)]
pub(crate) struct Passages {
    /// For each way, the index of its first passage. It has one for each way out of the cell that it enters.
    starts: Vec<usize>,
    /// Rows of the passages computed so far, by index.
    after: PackedRows,
}

impl Passages {
    /// Creates the index of all passages, none computed.
    pub(crate) fn none(ways: &Ways) -> Passages {
        let mut starts = Vec::with_capacity(ways.count() + 1);
        let mut next = 0;
        for way in &ways.all {
            starts.push(next);
            next += ways.out_of(way.to).len();
        }
        starts.push(next);
        Passages {
            starts,
            after: PackedRows::new(ways.count()),
        }
    }

    /// Restores the passages that begin with one of the first `computed` ways from their packed words. Returns `None`
    /// if the words do not match that number.
    pub(crate) fn from_words(ways: &Ways, computed: usize, words: &[u64]) -> Option<Passages> {
        let none = Passages::none(ways);
        let after = PackedRows::from_words(none.starts[computed], ways.count(), words)?;
        Some(Passages { after, ..none })
    }

    /// Computes the passages that begin with ways `next`, from the current bounds.
    pub(crate) fn compute(&mut self, ways: &Ways, bound: &BitRows, next: Range<usize>) {
        let rows = next.into_par_iter().map_init(
            Default::default,
            |(planes, row): &mut (Separators, Vec<_>), first| {
                let mut rows = PackedRows::new(ways.count());
                for second in ways.out_of(ways.all[first].to) {
                    row.clear();
                    if bound.has(first, second) {
                        after_both(ways, bound, [first, second], planes, row);
                    }
                    rows.push(row);
                }
                rows
            },
        );
        for rows in rows.collect::<Vec<PackedRows>>() {
            self.after.append(&rows);
        }
    }

    /// Returns the packed words of the passages computed so far.
    pub(crate) fn words(&self) -> &[u64] {
        self.after.words()
    }

    /// Returns the nonzero words of the ways that a ray may cross after a passage, each with its index.
    pub(crate) fn after(
        &self,
        ways: &Ways,
        first: usize,
        second: usize,
    ) -> impl Iterator<Item = (usize, u64)> + '_ {
        self.after.row(self.number(ways, first, second))
    }

    /// Returns the index of a passage.
    pub(crate) fn number(&self, ways: &Ways, first: usize, second: usize) -> usize {
        self.starts[first] + second - ways.out_of(ways.all[first].to).start
    }

    /// Returns the number of passages, computed or not.
    pub(crate) fn count(&self) -> usize {
        *self.starts.last().unwrap_or(&0)
    }

    /// Runs one round of the fixpoint: drops from the bounds of `stale` ways what no passage leads to. Returns `true`
    /// if anything was dropped.
    ///
    /// `stale` marks the ways whose bound may change because others have changed. The order of updates does not matter:
    /// bounds only shrink, and the greatest fixpoint is unique.
    pub(crate) fn tighten(&self, ways: &Ways, bound: &mut BitRows, stale: &mut [bool]) -> bool {
        let mut reached = vec![0u64; bound.words_in_row()];
        let mut dropped = Vec::new();
        let mut changed = false;
        for first in 0..ways.count() {
            if !std::mem::take(&mut stale[first]) {
                continue;
            }
            reached.fill(0);
            for second in ways.out_of(ways.all[first].to) {
                if !bound.has(first, second) {
                    continue;
                }
                put(&mut reached, second);
                let of_second = bound.row(second);
                for (at, of_passage) in self.after(ways, first, second) {
                    reached[at] |= of_second[at] & of_passage;
                }
            }
            dropped.clear();
            dropped.extend(ones_besides(bound.row(first), &reached));
            for &then in &dropped {
                drop_pair(ways, bound, first, then);
                let back = ways.all[then].back as usize;
                stale[back] = true;
                before(ways, back).for_each(|way| stale[way] = true);
            }
            if !dropped.is_empty() {
                changed = true;
                before(ways, first).for_each(|way| stale[way] = true);
            }
        }
        changed
    }
}

/// Returns the ways into the cell that `way` leaves.
fn before(ways: &Ways, way: usize) -> impl Iterator<Item = usize> + '_ {
    ways.out_of(ways.all[way].from)
        .map(|out| ways.all[out].back as usize)
}

/// Drops the pair (`first`, `then`) and its reverse.
pub(crate) fn drop_pair(ways: &Ways, bound: &mut BitRows, first: usize, then: usize) {
    bound.take(first, then);
    bound.take(ways.all[then].back as usize, ways.all[first].back as usize);
}

fn after_both(
    ways: &Ways,
    bound: &BitRows,
    [first, second]: [usize; 2],
    planes: &mut Separators,
    row: &mut Vec<(u32, u64)>,
) {
    let both = bound.row(first).iter().zip(bound.row(second));
    let words = both.map(|(of_first, of_second)| of_first & of_second);
    row.extend((0..).zip(words).filter(|&(_, word)| word != 0));
    let windings = [first, second].map(|way| ways.all[way].corners.as_slice());
    planes.find(ways, windings, false);
    planes.keep_above(ways, windings, row);
}
