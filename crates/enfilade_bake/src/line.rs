//! Traces rays through cells; each pair of cells on a ray is visible to each other.
//!
//! A ray crosses a portal if it passes all edges on the inner side. The portal's plane is not used, so a portal that is
//! not quite flat is bounded by its edges alone. The ray leaves each cell through a portal that it crosses outwards.
//! This module does not use the code that computes pairs, so that it can verify them.

use crate::cells::Cells;
use crate::pairs::VisiblePairs;
use crate::random::Random;
use crate::ways::{Way, Ways};
use glam::DVec3;
use rayon::prelude::*;
use std::fmt;

/// A line of sight between two cells that a [`VisiblePairs`] does not contain; also the result of
/// [`PairsWork::line_between`](crate::PairsWork::line_between).
#[derive(Clone, Debug, PartialEq)]
pub struct Witness {
    /// A point of the line, in scene units.
    pub origin: [f64; 3],
    /// Direction of the line, of unit length.
    pub direction: [f64; 3],
    /// Cells along the line, from the first of the pair to the second.
    pub cells: Vec<u32>,
}

impl fmt::Display for Witness {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = [self.cells.first(), self.cells.last()].map(|cell| cell.copied().unwrap_or(0));
        let ([x, y, z], [a, b, c]) = (self.origin, self.direction);
        write!(
            out,
            "cell {from} sees cell {to}: the line from ({x} {y} {z}) along ({a} {b} {c}) goes through the cells"
        )?;
        self.cells.iter().try_for_each(|cell| write!(out, " {cell}"))
    }
}

/// Number of rays traced in parallel.
const SIDE_BY_SIDE: u64 = 1 << 14;

/// Tests a PVS with `count` random rays, each through a portal, half of them close to portal edges. Returns the first
/// ray that connects a pair of cells missing in `pairs`.
///
/// The rays depend on `seed` alone, not on the number of threads.
pub fn find_missing(cells: &Cells, pairs: &VisiblePairs, count: u64, seed: u64) -> Option<Witness> {
    let ways = Ways::of(cells);
    if ways.count() == 0 {
        return None;
    }
    (0..count.div_ceil(SIDE_BY_SIDE)).find_map(|part| {
        let numbers = part * SIDE_BY_SIDE..count.min((part + 1) * SIDE_BY_SIDE);
        numbers
            .into_par_iter()
            .map_init(Vec::new, |taken, number| {
                missed_by(
                    &ways,
                    pairs,
                    &mut Random::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number),
                    taken,
                )
            })
            .find_map_first(|witness| witness)
    })
}

/// Traces one ray from a random portal to another a random walk away, each at a random point or close to an edge.
fn missed_by(
    ways: &Ways,
    pairs: &VisiblePairs,
    random: &mut Random,
    taken: &mut Vec<u32>,
) -> Option<Witness> {
    let from = random.below(ways.count());
    let to_edge = random.unit() < 0.5;
    let start = point(&ways.all[from], to_edge, random);
    // A random walk of up to eight portals, because distant portals are seldom visible.
    let mut to = from;
    for _ in 0..=random.below(8) {
        let next = ways.out_of(ways.all[to].to);
        to = next.start + random.below(next.len());
    }
    let end = point(&ways.all[to], to_edge, random);
    let direction = (end - start).try_normalize()?;
    taken.clear();
    if !crosses(&ways.all[from], start, direction, ways.clear()) {
        return None;
    }
    taken.push(from as u32);
    walk(ways, from, start, direction, ways.clear(), taken);
    (0..taken.len()).find_map(|at| {
        let cell = ways.all[taken[at] as usize].from;
        let rest = &taken[at..];
        let unseen = rest.iter().position(|&way| {
            let other = ways.all[way as usize].to;
            !(pairs.may_see(cell, other) && pairs.may_see(other, cell))
        })?;
        let mut cells = vec![cell];
        cells.extend(rest[..=unseen].iter().map(|&way| ways.all[way as usize].to));
        Some(Witness {
            origin: start.into(),
            direction: direction.into(),
            cells,
        })
    })
}

/// Returns a random point of a portal, or with `to_edge` a point between 10⁻⁶ and 0.1 of the way from an edge or corner
/// to an interior point.
fn point(way: &Way, to_edge: bool, random: &mut Random) -> DVec3 {
    let inside = random.point_in(&way.corners);
    if !to_edge {
        return inside;
    }
    let at = random.below(way.corners.len());
    let [from, to] = [way.corners[at], way.corners[(at + 1) % way.corners.len()]];
    let along = if random.unit() < 0.3 { 0.0 } else { random.unit() };
    let edge = from.lerp(to, along);
    edge.lerp(inside, 10f64.powf(-1.0 - 5.0 * random.unit()))
}

/// Returns `true` if a ray crosses a way in its direction and inside its winding, more than about `clear` units from
/// each edge.
pub(crate) fn crosses(way: &Way, origin: DVec3, direction: DVec3, clear: f64) -> bool {
    if way.plane.normal.dot(direction) <= 0.0 {
        return false;
    }
    let mut before = way.corners[way.corners.len() - 1] - origin;
    way.corners.iter().all(|&corner| {
        let here = corner - origin;
        let side = direction.dot(before.cross(here));
        before = here;
        side > clear
    })
}

/// Appends the ways that a ray crosses after `start`, in order. The ray crosses `start`.
pub(crate) fn walk(
    ways: &Ways,
    start: usize,
    origin: DVec3,
    direction: DVec3,
    clear: f64,
    taken: &mut Vec<u32>,
) {
    let along = |way: &Way| -way.plane.above(origin) / way.plane.normal.dot(direction);
    let mut at = start;
    let mut far = along(&ways.all[start]);
    loop {
        let way = &ways.all[at];
        // Cells that are not quite convex may have a portal behind the last one: only crossings farther along count.
        let next = ways.out_of(way.to).find_map(|number| {
            let next = &ways.all[number];
            let taken = number != way.back as usize && crosses(next, origin, direction, clear);
            taken
                .then(|| (number, along(next)))
                .filter(|&(_, along)| along >= far)
        });
        let Some((next, next_far)) = next else { return };
        taken.push(next as u32);
        (at, far) = (next, next_far);
    }
}
