//! Upper bound by flood fill: ways reachable through portals that are in front of one another.
//!
//! A ray that crosses one way and later another has part of the second in front of the first, and part of the first
//! behind the second. The flood continues through each way that satisfies this for the source.
//! Source: Teller, Séquin. Visibility Preprocessing for Interactive Walkthroughs. SIGGRAPH 1991, section 3.
//! Cost: O(ways reached) for each way; most tests are decided by bounding spheres.
//! Conservative: tests the actual corners, so snapped ones count where they are, with exact arithmetic where rounding
//! could decide.

use crate::bits::{BitRows, ones, put};
use crate::ways::{Way, Ways};
use crate::winding::above_exactly;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Fills the rows of ways `some` with the ways that a ray may cross after them.
pub(crate) fn flood_from(ways: &Ways, some: Range<usize>, bound: &mut BitRows) {
    let words = bound.words_in_row();
    bound.rows_mut()[some.start * words..some.end * words]
        .par_chunks_mut(words.max(1))
        .zip(some)
        .for_each(|(row, way)| flood(ways, way, row));
}

/// Drops each pair that the flood from its other end did not reach.
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

/// Floods from one way into its row.
fn flood(ways: &Ways, start: usize, row: &mut [u64]) {
    let source = &ways.all[start];
    let mut entered = vec![false; ways.cells()];
    entered[source.from as usize] = true;
    entered[source.to as usize] = true;
    let mut pending = vec![source.to];
    while let Some(cell) = pending.pop() {
        for number in ways.out_of(cell) {
            let way = &ways.all[number];
            if way.to != source.from && is_before(source, way) && is_behind(way, source) {
                put(row, number);
                if !std::mem::replace(&mut entered[way.to as usize], true) {
                    pending.push(way.to);
                }
            }
        }
    }
}

/// Returns `true` if part of `other` may be in front of `way`.
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

/// Returns `true` if part of `other` may be behind `way`.
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

/// Returns `true` if `point` is exactly above the plane of any triangle in the fan from the way's first corner.
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
