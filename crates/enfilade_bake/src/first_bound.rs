//! The first bound: what a flood through portals reaches that lie before one another.
//!
//! A line that goes along one way, then along another, has some of the second before the first, and some of the first
//! behind the second. The flood goes on through every way for which that holds.
//! Source: Teller, Séquin. Visibility Preprocessing for Interactive Walkthroughs. SIGGRAPH 1991, section 3.
//! Cost: O(ways reached) each, most told by their spheres.
//! Conservative: by the corners themselves, so that snapped ones count as they stand; exactly, where rounding could decide.

use crate::bits::{BitRows, ones, put};
use crate::ways::{Way, Ways};
use crate::winding::above_exactly;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Fills the rows of some ways with those that a line may take after them.
pub(crate) fn flood_from(ways: &Ways, some: Range<usize>, bound: &mut BitRows) {
    let words = bound.words_in_row();
    bound.rows_mut()[some.start * words..some.end * words]
        .par_chunks_mut(words.max(1))
        .zip(some)
        .for_each(|(row, way)| flood(ways, way, row));
}

/// Takes out what the flood from the other end does not reach.
pub(crate) fn keep_symmetric(ways: &Ways, bound: &mut BitRows) {
    for way in 0..ways.count() {
        let back = ways.all[way].back as usize;
        let reached: Vec<usize> = ones(bound.row(way)).collect();
        for then in reached {
            if !bound.has(ways.all[then].back as usize, back) {
                bound.take(way, then);
            }
        }
    }
}

/// What the flood from one way reaches, into its row.
fn flood(ways: &Ways, start: usize, row: &mut [u64]) {
    let source = &ways.all[start];
    let mut entered = vec![false; ways.cells()];
    entered[source.from as usize] = true;
    entered[source.to as usize] = true;
    let mut waiting = vec![source.to];
    while let Some(cell) = waiting.pop() {
        for number in ways.out_of(cell) {
            let way = &ways.all[number];
            if way.to != source.from && is_before(source, way) && is_behind(way, source) {
                put(row, number);
                if !std::mem::replace(&mut entered[way.to as usize], true) {
                    waiting.push(way.to);
                }
            }
        }
    }
}

/// Whether any of `other` may lie before `way`.
fn is_before(way: &Way, other: &Way) -> bool {
    let (middle, slack) = (way.plane.above(other.centre), way.plane.slack);
    if middle.abs() > other.radius + slack {
        return middle > 0.0;
    }
    other.corners.iter().any(|&corner| {
        let above = way.plane.above(corner);
        above > slack || (above >= -slack && is_above_a_part(way, corner))
    })
}

/// Whether any of `other` may lie behind `way`: before it, seen from the other side.
fn is_behind(way: &Way, other: &Way) -> bool {
    let (middle, slack) = (way.plane.above(other.centre), way.plane.slack);
    if middle.abs() > other.radius + slack {
        return middle < 0.0;
    }
    other.corners.iter().any(|&corner| {
        let above = way.plane.above(corner);
        above < -slack || (above <= slack && is_below_a_part(way, corner))
    })
}

/// Exactly, of any of the triangles that a way can be cut into from its first corner.
fn is_above_a_part(way: &Way, point: DVec3) -> bool {
    parts(way).any(|part| above_exactly(&part, point) > 0.0)
}

fn is_below_a_part(way: &Way, point: DVec3) -> bool {
    parts(way).any(|part| above_exactly(&part, point) < 0.0)
}

fn parts(way: &Way) -> impl Iterator<Item = [DVec3; 3]> + '_ {
    let pairs = way.corners[1..].windows(2);
    pairs.map(|pair| [way.corners[0], pair[0], pair[1]])
}
