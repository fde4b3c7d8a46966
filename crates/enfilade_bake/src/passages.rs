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
use crate::ways::{Way, Ways};
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

    pub(crate) fn after(&self, ways: &Ways, first: usize, second: usize) -> &[u64] {
        let seconds = ways.out_of(ways.all[first].to);
        self.after.row(self.starts[first] + second - seconds.start)
    }

    /// Takes out of the bounds what no chain of passages leads to; once round. Says whether anything was taken.
    pub(crate) fn tighten(&self, ways: &Ways, bound: &mut BitRows) -> bool {
        let mut reached = vec![0u64; bound.words_in_row()];
        let mut dropped = Vec::new();
        let mut changed = false;
        for first in 0..ways.count() {
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
            changed |= !dropped.is_empty();
            dropped
                .iter()
                .for_each(|&then| drop_pair(ways, bound, first, then));
        }
        changed
    }
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
        &ways.all[first].corners,
        &ways.all[second].corners,
        false,
        ways.size,
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
        row,
    );
}

/// Takes out of a row the ways that lie below one of the planes.
pub(crate) fn keep_within(ways: &Ways, planes: &[Plane], parted: [&[DVec3]; 2], row: &mut [u64]) {
    for (at, word) in row.iter_mut().enumerate() {
        let mut rest = *word;
        while rest != 0 {
            let bit = rest & rest.wrapping_neg();
            rest ^= bit;
            let way = &ways.all[at * 64 + bit.trailing_zeros() as usize];
            if planes.iter().any(|plane| is_below(plane, way, parted)) {
                *word ^= bit;
            }
        }
    }
}

fn is_below(plane: &Plane, way: &Way, parted: [&[DVec3]; 2]) -> bool {
    let middle = plane.above(way.centre);
    if middle.abs() > way.radius + plane.slack {
        return middle < 0.0;
    }
    let heights = way.corners.iter().map(|&corner| plane.above(corner));
    plane.hides(&way.corners, heights.fold(f64::NEG_INFINITY, f64::max), parted)
}
