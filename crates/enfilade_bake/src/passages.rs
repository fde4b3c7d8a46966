//! A tighter bound: what a line may meet after any two ways in a row, and what follows from that for all.
//!
//! A passage is a way into a cell and a way out of it. What lies outside the planes between the two is not met after
//! them. So a way's bound is the union, over the passages that begin with it, of the second way with what is both in
//! that one's bound and in the passage; which makes that bound smaller, and others, until nothing changes any more.
//! Source: Teller, Séquin 1991 for the planes; the fixpoint is ours.
//! Cost: each passage tests what both its ways have in their bounds, most of it by spheres; then words are combined.
//! Conservative: lines have no direction, so what one end drops, the other may drop too.

use crate::bits::{BitRows, ones_besides, put};
use crate::separators::separators;
use crate::ways::Ways;
use crate::winding::Plane;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// For each passage the ways that a line may take after it.
#[derive(Debug)]
pub(crate) struct Passages {
    /// Where those of each way begin: one for each way out of the cell that it enters.
    starts: Vec<usize>,
    after: BitRows,
}

impl Passages {
    /// Of all cells, with nothing in them.
    pub(crate) fn empty(ways: &Ways) -> Passages {
        let mut starts = Vec::with_capacity(ways.count() + 1);
        let mut next = 0;
        for way in &ways.all {
            starts.push(next);
            next += ways.out_of(way.to).len();
        }
        starts.push(next);
        Passages {
            starts,
            after: BitRows::new(next, ways.count()),
        }
    }

    /// Fills in those that begin with some of the ways, given what each way may see.
    pub(crate) fn fill(&mut self, ways: &Ways, bound: &BitRows, some: Range<usize>) {
        let words = self.after.words_in_row();
        let starts = &self.starts[some.start..=some.end];
        let mut rest = &mut self.after.rows_mut()[starts[0] * words..];
        let mut rows = Vec::with_capacity(some.len());
        for pair in starts.windows(2) {
            let (mine, others) = rest.split_at_mut((pair[1] - pair[0]) * words);
            rows.push(mine);
            rest = others;
        }
        rows.into_par_iter().zip(some).for_each(|(rows, first)| {
            let mut planes = Vec::new();
            let seconds = ways.out_of(ways.all[first].to);
            for (second, row) in seconds.zip(rows.chunks_mut(words)) {
                if bound.has(first, second) {
                    after_both(ways, bound, [first, second], &mut planes, row);
                }
            }
        });
    }

    /// Returns the words of the passages that begin with one of the first `ways`.
    pub(crate) fn words(&self, ways: usize) -> &[u64] {
        self.after.words(0..self.starts[ways])
    }

    /// Fills in those that begin with one of the first `ways` from packed words; returns whether they are so many.
    pub(crate) fn unpack(&mut self, ways: usize, columns: usize, packed: &[u64]) -> bool {
        let rest = self.after.unpack_rows(0..self.starts[ways], columns, packed);
        rest.is_some_and(<[u64]>::is_empty)
    }

    pub(crate) fn after(&self, ways: &Ways, first: usize, second: usize) -> &[u64] {
        self.after.row(self.number(ways, first, second))
    }

    /// Returns the number of a passage.
    pub(crate) fn number(&self, ways: &Ways, first: usize, second: usize) -> usize {
        self.starts[first] + second - ways.out_of(ways.all[first].to).start
    }

    pub(crate) fn count(&self) -> usize {
        self.after.rows()
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
                let both = bound.row(second).iter().zip(self.after(ways, first, second));
                for (word, (of_second, of_passage)) in reached.iter_mut().zip(both) {
                    *word |= of_second & of_passage;
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
    planes: &mut Vec<Plane>,
    row: &mut [u64],
) {
    planes.clear();
    separators(
        ways,
        &ways.all[first].corners,
        &ways.all[second].corners,
        false,
        planes,
    );
    let both = bound.row(first).iter().zip(bound.row(second));
    for (word, (of_first, of_second)) in row.iter_mut().zip(both) {
        *word = of_first & of_second;
    }
    keep_within(
        ways,
        planes,
        [&ways.all[first].corners, &ways.all[second].corners],
        row.iter_mut().enumerate(),
    );
}

/// Takes out of some words of a row, each with its number, the ways that lie below one of the planes.
pub(crate) fn keep_within<'a>(
    ways: &Ways,
    planes: &[Plane],
    parted: [&[DVec3]; 2],
    words: impl Iterator<Item = (usize, &'a mut u64)>,
) {
    for (at, word) in words {
        let mut rest = *word;
        while rest != 0 {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            let number = at * 64 + bit.trailing_zeros() as usize;
            let (centre, radius) = ways.spheres[number];
            let is_far_below = |plane: &Plane| plane.above(centre) < -(radius + plane.slack);
            let is_below = |plane: &Plane| {
                plane.above(centre) <= radius + plane.slack
                    && is_hidden(plane, &ways.all[number].corners, parted)
            };
            if planes.iter().any(is_far_below) || planes.iter().any(is_below) {
                *word ^= bit;
            }
        }
    }
}

fn is_hidden(plane: &Plane, corners: &[DVec3], parted: [&[DVec3]; 2]) -> bool {
    let heights = corners.iter().map(|&corner| plane.above(corner));
    plane.hides(corners, heights.fold(f64::NEG_INFINITY, f64::max), parted)
}
