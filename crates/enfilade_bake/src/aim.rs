//! Aimed lines: through a whole chain of portals, by pushing a line that misses until it hits.
//!
//! A line is a point of the first winding and a point of the last. While it passes an edge on the wrong side, both points
//! are pushed, each in its plane, to where it would pass the worst such edge on the right side and some way off: how far
//! off is less with each push. For either point alone the lines that pass an edge well are a half of its plane, so this
//! is the relaxation of linear inequalities, on two sets of them in turn; it finds bundles of lines far too thin for chance.
//! Source: Agmon. The Relaxation Method for Linear Inequalities. Canadian Journal of Mathematics 6, 1954, section 4; that
//! the side is a determinant, linear in each point: Teller 1992, section 4.1. To push both at once is ours.
//! Cost: O(corners of the chain) a push, and no more than `PUSHES`.
//! A guess: what it gives shows nothing before it has been walked, and where it gives none there may be lines.

use crate::bits::take;
use crate::flow::Reached;
use crate::known::{line_through, take_line};
use crate::ways::Ways;
use crate::winding::centre;
use glam::DVec3;

/// How often a line is pushed before it is given up: twice as many find a fiftieth of the rest.
const PUSHES: usize = 64;

/// How far off the edge the first push aims, of the smaller of the radii of the first and the last winding.
const OFF: f64 = 0.5;

/// What each push leaves of that.
const CLOSER: f64 = 0.9;

/// Aims a line from `way` at what its flow has come to; gives the ways that the line takes.
///
/// What the line shows is taken out of `asked`. So is the way that it was aimed at, hit or not, unless that is to be aimed
/// at `twice` and this is the first time.
pub(crate) fn aim(
    ways: &Ways,
    way: usize,
    reached: &Reached,
    twice: bool,
    asked: &mut [u64],
) -> Option<Vec<u32>> {
    if !(twice && reached.first) {
        take(asked, reached.way);
    }
    let line = aimed(ways, way, reached)?.1;
    take_line(ways, way, &line, asked);
    Some(line)
}

/// Two points of a line from `way` to what its flow has come to, and the ways that the line takes.
pub(crate) fn aimed(ways: &Ways, way: usize, reached: &Reached) -> Option<([DVec3; 2], Vec<u32>)> {
    let planes = [way, reached.way].map(|end| ways.all[end].plane.normal);
    let [start, end] = push(reached, planes)?;
    Some(([start, end], line_through(ways, way, start, end)?))
}

/// Two points, one in the plane of the source and one in that of the target, whose line passes all edges well.
fn push(reached: &Reached, [source_normal, target_normal]: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let mut start = centre(reached.source);
    let mut end = centre(reached.target);
    let mut off = OFF * radius(reached.source, start).min(radius(reached.target, end));
    for _ in 0..PUSHES {
        let along = end - start;
        let Some([from, to]) = worst_edge(reached, start, along) else {
            return Some([start, end]);
        };
        // How the side of the edge grows as either point moves.
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

/// The edge that a line passes farthest off on the wrong side, if there is one.
fn worst_edge(reached: &Reached, start: DVec3, along: DVec3) -> Option<[DVec3; 2]> {
    let mut worst = 0.0;
    let mut found = None;
    for winding in reached.windings() {
        let mut before = winding[winding.len() - 1];
        for &corner in winding {
            let side = side(along, before - start, corner - start);
            if side <= 0.0 {
                // Squared, how far the line passes from that of the edge.
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

/// Six times a volume: positive where a line along `along` passes on the inner side of an edge, given from the line's start.
fn side(along: DVec3, from: DVec3, to: DVec3) -> f64 {
    along.dot(from.cross(to))
}

/// What of a vector runs in a plane.
fn within(vector: DVec3, normal: DVec3) -> DVec3 {
    vector - normal * normal.dot(vector)
}

fn radius(winding: &[DVec3], centre: DVec3) -> f64 {
    let squares = winding.iter().map(|&corner| (corner - centre).length_squared());
    squares.fold(0.0, f64::max).sqrt()
}
