//! Aims rays through a chain of portals, by moving a missing ray until it hits.
//!
//! A ray is given by a point of the first winding and a point of the last. While it passes an edge on the wrong side,
//! both points move within their planes to where the ray passes the worst such edge on the right side with a margin,
//! which shrinks with each move. For either point alone, the rays that pass an edge with a margin form a half-plane. So
//! this is the relaxation of linear inequalities, on two sets of them in turn. It finds bundles of rays far too thin
//! for random sampling.
//! Source: Agmon. The Relaxation Method for Linear Inequalities. Canadian Journal of Mathematics 6, 1954, section 4;
//! the side as a determinant that is linear in each point: Teller 1992, section 4.1. Moving both points at once is new.
//! Cost: O(corners of the chain) per move, at most `PUSHES` moves.
//! Heuristic: a ray proves nothing before it has been traced, and a failure does not prove that no ray exists.

use crate::bits::take;
use crate::flow::ChainEnd;
use crate::known::{after, line_through, take_line};
use crate::ways::Ways;
use crate::winding::centre;
use glam::DVec3;

/// Maximum number of moves: twice as many find 2 % of the remaining rays.
const PUSHES: usize = 64;

/// Margin of the first move, relative to the smaller of the radii of the first and the last winding.
const OFF: f64 = 0.5;

/// Factor of the margin from one move to the next.
const CLOSER: f64 = 0.9;

/// Aims a ray from `way` at the end of a chain; returns the ways that the ray crosses.
///
/// Clears in `undecided` the ways that the ray crosses; in the backflow (`is_back`) all ways into the cells that it
/// reaches. The target way is cleared too, hit or not; in the backflow only from the second chain that reaches it on.
pub(crate) fn aim(
    ways: &Ways,
    way: usize,
    chain: &ChainEnd,
    is_back: bool,
    undecided: &mut [u64],
) -> Option<Vec<u32>> {
    if !(is_back && chain.first) {
        take(undecided, chain.way);
    }
    let line = aimed(ways, way, chain)?.1;
    if is_back {
        take_line(ways, way, &line, undecided);
    } else {
        after(way, &line).for_each(|then| take(undecided, then as usize));
    }
    Some(line)
}

/// Returns two points of a ray from `way` to the end of a chain, and the ways that the ray crosses.
pub(crate) fn aimed(ways: &Ways, way: usize, chain: &ChainEnd) -> Option<([DVec3; 2], Vec<u32>)> {
    let planes = [way, chain.way].map(|end| ways.all[end].plane.normal);
    let [start, end] = push(chain, planes)?;
    Some(([start, end], line_through(ways, way, start, end)?))
}

/// Returns two points, in the planes of the source and the target, whose line passes all edges on the inner side.
fn push(chain: &ChainEnd, [source_normal, target_normal]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let mut start = centre(chain.source);
    let mut end = centre(chain.target);
    let mut off = OFF * radius(chain.source, start).min(radius(chain.target, end));
    for _ in 0..PUSHES {
        let along = end - start;
        let Some([from, to]) = worst_edge(chain, start, along) else {
            return Some([start, end]);
        };
        // Gradients of the edge's side in either point.
        let by_end = within((from - start).cross(to - start), target_normal);
        let by_start = within((to - end).cross(from - end), source_normal);
        let edge = to - from;
        let lacking = off * along.cross(edge).length() - side(along, from - start, to - start);
        let part = lacking / (by_end.length_squared() + by_start.length_squared());
        if !part.is_finite() {
            return None;
        }
        start += by_start * part;
        end += by_end * part;
        off *= CLOSER;
    }
    None
}

/// Returns the edge that the line passes farthest outside, if any.
fn worst_edge(chain: &ChainEnd, start: DVec3, along: DVec3) -> Option<[DVec3; 2]> {
    let mut worst = 0.0;
    let mut found = None;
    for winding in chain.windings() {
        let mut before = winding[winding.len() - 1];
        for &corner in winding {
            let side = side(along, before - start, corner - start);
            if side <= 0.0 {
                // Squared distance between the line and the edge's line.
                let off = side * side / along.cross(corner - before).length_squared();
                if off >= worst {
                    (worst, found) = (off, Some([before, corner]));
                }
            }
            before = corner;
        }
    }
    found
}

/// Six times the volume of a tetrahedron: positive if a line along `along` passes on the inner side of an edge, whose
/// ends are relative to the line's start.
fn side(along: DVec3, from: DVec3, to: DVec3) -> f64 {
    along.dot(from.cross(to))
}

/// Projects a vector into a plane.
fn within(vector: DVec3, normal: DVec3) -> DVec3 {
    vector - normal * normal.dot(vector)
}

fn radius(winding: &[DVec3], centre: DVec3) -> f64 {
    let squares = winding.iter().map(|&corner| (corner - centre).length_squared());
    squares.fold(0.0, f64::max).sqrt()
}
