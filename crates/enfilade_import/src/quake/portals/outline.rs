//! Portal outlines: width, and enlargement by the rounding error of the file.
//!
//! A file stores planes as 32-bit floats, but its compiler computed them with more digits, so an edge between two
//! planes may be off by the rounding error of both. Each edge is moved outwards by that amount: a portal may be larger
//! than its opening, but not smaller. A larger one costs time; a smaller one culls a visible room. Axis-aligned planes
//! are exact and are not moved, so portals on a grid still touch bit-exactly.

use super::polygon::{Corner, Side};
use glam::DVec3;

/// Returns the width of the narrowest strip that contains a convex polygon, in units.
pub(super) fn width(corners: &[Corner]) -> f64 {
    let Some(normal) = normal(corners) else {
        return 0.0;
    };
    let widths = edges(corners).filter_map(|[from, to]| {
        let inward = normal.cross(to - from).try_normalize()?;
        let depths = corners.iter().map(|corner| inward.dot(corner.at - from));
        Some(depths.fold(0.0, f64::max))
    });
    widths.fold(f64::INFINITY, f64::min)
}

/// Removes edges that are mere rounding noise: merges coincident corners. If the neighbours of a short edge intersect
/// not far beyond it, it is replaced by that intersection, so that the outline does not shrink.
pub(super) fn tidy(corners: &mut Vec<Corner>) {
    const SAME: f64 = 1e-6;
    const SHORT: f64 = 1e-3;
    let mut nth = 0;
    while nth < corners.len() && corners.len() >= 3 {
        let count = corners.len();
        let [a, b, c, d] = [count - 1, 0, 1, 2].map(|step| corners[(nth + step) % count]);
        let length = b.at.distance(c.at);
        let extended = || {
            let [first, second] = [b.at - a.at, d.at - c.at];
            let long = count > 3 && first.length() > SHORT && second.length() > SHORT;
            let normal = normal(corners).filter(|_| long && length < SHORT)?;
            let [first, second] = [first.normalize(), second.normalize()];
            let turn = normal.dot(first.cross(second));
            let far = normal.dot((c.at - b.at).cross(second)) / turn;
            (turn > 1e-3 && (0.0..10.0 * SHORT).contains(&far)).then(|| b.at + first * far)
        };
        let at = if length < SAME { Some(b.at) } else { extended() };
        let Some(at) = at else {
            nth += 1;
            continue;
        };
        corners[nth] = Corner { at, edge: c.edge };
        corners.remove((nth + 1) % count);
        // The neighbouring edges have changed, so start again.
        nth = 0;
    }
}

/// Returns the outline with each edge moved outwards, in the plane of `side`, by its rounding error.
pub(super) fn enlarged(corners: &[Corner], side: &Side) -> Vec<DVec3> {
    /// Limit of the move: planes that nearly coincide can intersect anywhere. Compilers ignore openings of this width.
    const MOST: f64 = 0.05;
    let Some(normal) = normal(corners) else {
        return corners.iter().map(|corner| corner.at).collect();
    };
    let count = corners.len();
    let moves = |nth: usize| out_by(corners, nth, side);
    let along = |nth: usize| (corners[(nth + 1) % count].at - corners[nth].at).normalize_or_zero();
    let corner = |nth: usize| {
        let before = (nth + count - 1) % count;
        let [first, second] = [before, nth].map(along);
        let [by_first, by_second] = [before, nth].map(moves);
        if by_first == 0.0 && by_second == 0.0 {
            return corners[nth].at;
        }
        let turn = normal.dot(first.cross(second));
        let moved = if turn > 1e-6 {
            (first * by_second - second * by_first) / turn
        } else {
            first.cross(normal) * by_first.max(by_second)
        };
        corners[nth].at + moved.clamp_length_max(MOST)
    };
    // A very short edge has an unreliable direction and may have been moved across its neighbours; the convex hull of
    // old and new corners repairs that.
    let moved = (0..count).map(corner);
    let all = corners.iter().map(|corner| corner.at).chain(moved);
    // Adding 0 turns −0 into 0; otherwise −0 would be sorted before 0.
    convex(all.map(|at| at + DVec3::ZERO).collect(), normal)
}

/// Returns the convex hull of coplanar points, counter-clockwise about the normal. Its corners are a subset of the
/// points.
fn convex(mut points: Vec<DVec3>, normal: DVec3) -> Vec<DVec3> {
    /// A corner closer than this to the line between its neighbours, in units, is removed.
    const STRAIGHT: f64 = 1e-9;
    let flat = normal.abs().max_position();
    let turned = usize::from(normal[flat] < 0.0);
    let [u, v] = [flat + 1 + turned, flat + 2 - turned].map(|axis| axis % 3);
    points.sort_by(|a, b| a[u].total_cmp(&b[u]).then(a[v].total_cmp(&b[v])));
    let mut outline: Vec<DVec3> = Vec::new();
    let half = |outline: &mut Vec<DVec3>, points: &mut dyn Iterator<Item = DVec3>| {
        let start = outline.len();
        for point in points {
            while outline.len() >= start + 2 {
                let [before, here] = [outline[outline.len() - 2], outline[outline.len() - 1]];
                let [along, on] = [point - before, here - before];
                let inside = along[u] * on[v] - along[v] * on[u];
                if inside < 0.0 {
                    break;
                }
                outline.pop();
            }
            outline.push(point);
        }
        outline.pop();
    };
    half(&mut outline, &mut points.iter().copied());
    half(&mut outline, &mut points.iter().rev().copied());
    let mut nth = 0;
    while nth < outline.len() && outline.len() > 3 {
        let count = outline.len();
        let [before, here, after] = [count - 1, 0, 1].map(|step| outline[(nth + step) % count]);
        let along = after - before;
        if along.cross(here - before).length() < STRAIGHT * along.length() {
            outline.remove(nth);
        } else {
            nth += 1;
        }
    }
    outline
}

/// Returns how far rounding may have moved an edge in the plane of `side`, in units.
fn out_by(corners: &[Corner], nth: usize, side: &Side) -> f64 {
    let edge = corners[nth].edge;
    let ends = [corners[nth].at, corners[(nth + 1) % corners.len()].at];
    // Each coefficient of a plane has a relative error of up to 2⁻²⁴.
    let far = ends
        .map(|end| end.abs().element_sum())
        .into_iter()
        .fold(0.0, f64::max);
    let off = |side: &Side| {
        if side.axis.is_some() {
            0.0
        } else {
            far * 2f64.powi(-23)
        }
    };
    let cos = side.normal.dot(edge.normal).abs();
    let sin = side.normal.cross(edge.normal).length();
    let off = off(&edge) + off(side) * cos;
    if off == 0.0 { 0.0 } else { off / sin.max(1e-6) }
}

fn edges(corners: &[Corner]) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    (0..corners.len()).map(|at| [corners[at].at, corners[(at + 1) % corners.len()].at])
}

fn normal(corners: &[Corner]) -> Option<DVec3> {
    let first = corners.first()?.at;
    let twice_area: DVec3 = corners[1..]
        .windows(2)
        .map(|pair| (pair[0].at - first).cross(pair[1].at - first))
        .sum();
    twice_area.try_normalize()
}
