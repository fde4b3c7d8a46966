//! A portal's outline: its width, and as much larger as the numbers of a file leave open.
//!
//! A file has its planes in numbers of 32 bits, its compiler had them in more; an edge between two planes is as far beside
//! its place as rounding can have moved both. So far it is moved outwards, for a portal may be larger than the hole that it
//! stands for, but not smaller: a hole too large costs time, one too small hides a room. Planes along an axis stand where they
//! are said to stand, so that what touches on a grid touches to the last digit.

use super::polygon::{Corner, Side};
use glam::DVec3;

/// The width of the narrowest strip that a convex polygon fits in, in units.
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

/// Takes out edges as short as rounding makes them: corners in one place become one, and where the edges on both sides of a
/// short one meet not far beyond it, they are led on to there, so that the outline does not become smaller.
pub(super) fn tidy(corners: &mut Vec<Corner>) {
    const SAME: f64 = 1e-6;
    const SHORT: f64 = 1e-3;
    let mut nth = 0;
    while nth < corners.len() && corners.len() >= 3 {
        let count = corners.len();
        let [a, b, c, d] = [count - 1, 0, 1, 2].map(|step| corners[(nth + step) % count]);
        let length = b.at.distance(c.at);
        let led_on = || {
            let [first, second] = [b.at - a.at, d.at - c.at];
            let long = count > 3 && first.length() > SHORT && second.length() > SHORT;
            let normal = normal(corners).filter(|_| long && length < SHORT)?;
            let [first, second] = [first.normalize(), second.normalize()];
            let turn = normal.dot(first.cross(second));
            let far = normal.dot((c.at - b.at).cross(second)) / turn;
            (turn > 1e-3 && (0.0..10.0 * SHORT).contains(&far)).then(|| b.at + first * far)
        };
        let at = if length < SAME { Some(b.at) } else { led_on() };
        let Some(at) = at else {
            nth += 1;
            continue;
        };
        corners[nth] = Corner { at, edge: c.edge };
        corners.remove((nth + 1) % count);
        // Its neighbours have changed.
        nth = 0;
    }
}

/// The outline in the plane of `side`, with each edge as far out as rounding can have moved it.
pub(super) fn enlarged(corners: &[Corner], side: &Side) -> Vec<DVec3> {
    /// Planes that nearly coincide meet anywhere; what they leave open is not more than compilers take for nothing.
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
    // What is so short that its direction says little may have been moved across its neighbours.
    let moved = (0..count).map(corner);
    let all = corners.iter().map(|corner| corner.at).chain(moved);
    // −0 becomes 0, which it would be sorted before.
    convex(all.map(|at| at + DVec3::ZERO).collect(), normal)
}

/// The least convex outline around points in one plane, counter-clockwise about its normal. Its corners are some of them.
fn convex(mut points: Vec<DVec3>, normal: DVec3) -> Vec<DVec3> {
    /// Nearer than this to the line between its neighbours, in units, a point is no corner.
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

/// How far rounding can have moved an edge in the plane of `side`, in units.
fn out_by(corners: &[Corner], nth: usize, side: &Side) -> f64 {
    let edge = corners[nth].edge;
    let ends = [corners[nth].at, corners[(nth + 1) % corners.len()].at];
    // Each number of a plane is off by up to 2⁻²⁴ of itself.
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
