//! A tighter bound: what a line may meet after any two ways in a row, and what follows from that for all.
//!
//! A passage is a way into a cell and a way out of it. What lies outside the planes between the two is not met after
//! them. So a way's bound is the union, over the passages that begin with it, of the second way with what is both in
//! that one's bound and in the passage; which makes that bound smaller, and others, until nothing changes any more.
//! Source: Teller, Séquin 1991 for the planes; the fixpoint is ours.
//! Cost: each passage tests what both its ways have in their bounds, most of it by spheres; then words are combined.
//! Conservative: lines have no direction, so what one end drops, the other may drop too.

use crate::bits::{BitRows, PackedRows, ones_besides, put};
use crate::separators::Separators;
use crate::ways::Ways;
use rayon::prelude::*;
use std::ops::Range;

/// For each passage the ways that a line may take after it.
#[derive(Debug)]
pub(crate) struct Passages {
    /// Where those of each way begin: one for each way out of the cell that it enters.
    starts: Vec<usize>,
    /// Of those computed so far, in their order.
    after: PackedRows,
}

impl Passages {
    /// Of all cells, none computed.
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

    /// Returns those of all cells that begin with one of the first `computed` ways from their words; `None` where those are of
    /// another number.
    pub(crate) fn from_words(ways: &Ways, computed: usize, words: &[u64]) -> Option<Passages> {
        let none = Passages::none(ways);
        let after = PackedRows::from_words(none.starts[computed], ways.count(), words)?;
        Some(Passages { after, ..none })
    }

    /// Computes those that begin with the next ways, given what each way may see.
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

    /// Returns the words of those computed so far.
    pub(crate) fn words(&self) -> &[u64] {
        self.after.words()
    }

    /// Returns the words that are not zero of the ways that a line may take after a passage, each with its number.
    pub(crate) fn after(
        &self,
        ways: &Ways,
        first: usize,
        second: usize,
    ) -> impl Iterator<Item = (usize, u64)> + '_ {
        self.after.row(self.number(ways, first, second))
    }

    /// Returns the number of a passage.
    pub(crate) fn number(&self, ways: &Ways, first: usize, second: usize) -> usize {
        self.starts[first] + second - ways.out_of(ways.all[first].to).start
    }

    /// Returns how many there are, computed or not.
    pub(crate) fn count(&self) -> usize {
        *self.starts.last().unwrap_or(&0)
    }

    /// Takes out of the bounds of `stale` ways what no chain of passages leads to; once round. Says whether anything was taken.
    ///
    /// `stale` are the ways whose bound may change because others have. The order does not matter: bounds only shrink, and the
    /// largest that nothing can be taken out of is one alone.
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

/// The ways into the cell that a way leaves.
fn before(ways: &Ways, way: usize) -> impl Iterator<Item = usize> + '_ {
    ways.out_of(ways.all[way].from)
        .map(|out| ways.all[out].back as usize)
}

/// No line goes along `first`, then `then`: nor does one the other way.
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
