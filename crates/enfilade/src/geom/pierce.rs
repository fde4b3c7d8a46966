//! Watertight line/polygon intersection.
//!
//! The polygon is tested as a fan of triangles from its first corner, with exact predicates: a line through a shared
//! edge or corner intersects at least one of the polygons that share it.
//! Source: Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, 1997.

use super::ConvexPolygon;
use glam::DVec3;
use robust::{Coord3D, orient3d};

/// Intersection of the line through two points with a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pierced {
    /// Whether the first point is in front of the plane or in it.
    pub(crate) from_front: bool,
    /// Whether the second point is behind the plane.
    pub(crate) to_behind: bool,
    /// Line parameter of the intersection with the plane: 0 at the first point, 1 at the second.
    pub(crate) at: f64,
    /// Signed distance of the first point to the plane; positive in front.
    pub(crate) distance: f64,
}

/// Intersects the line through two points with a polygon, edges included; `None` if it misses.
pub(crate) fn pierced(outline: &ConvexPolygon, [from, to]: [DVec3; 2]) -> Option<Pierced> {
    let corner = |i: usize| DVec3::from(outline.corners()[i].map(f64::from));
    (2..outline.corners().len()).find_map(|last| {
        let [a, b, c] = [corner(0), corner(last - 1), corner(last)];
        let turns = [(a, b), (b, c), (c, a)].map(|(start, end)| orient(from, to, start, end));
        let passes = turns.iter().all(|&turn| turn >= 0.0) || turns.iter().all(|&turn| turn <= 0.0);
        // All three are zero if the line is in the plane of the triangle, whether or not it meets the triangle.
        let sides = [from, to].map(|point| orient(a, b, c, point));
        if !passes || sides == [0.0; 2] {
            return None;
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let [near, far] = [from, to].map(|point| normal.dot(point - a));
        Some(Pierced {
            // The predicate is positive below a plane; "below" is the side from which the corners run clockwise.
            from_front: sides[0] <= 0.0,
            to_behind: sides[1] > 0.0,
            at: near / (near - far),
            distance: near,
        })
    })
}

/// Returns six times the signed volume of a tetrahedron, with an exact sign.
fn orient(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|DVec3 { x, y, z }| Coord3D { x, y, z });
    orient3d(a, b, c, d)
}

/// Returns the point of a convex polygon that is closest to `point`.
pub(crate) fn nearest_in(corners: &[DVec3], point: DVec3) -> DVec3 {
    let normal: DVec3 = (corners[1..].windows(2))
        .map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]))
        .sum();
    let edges = || (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
    if edges().all(|(start, end)| (end - start).cross(point - start).dot(normal) >= 0.0) {
        return point
            - normal * (normal.dot(point - corners[0]) / normal.length_squared().max(f64::MIN_POSITIVE));
    }
    edges()
        .map(|(start, end)| {
            let along = end - start;
            let part = along.dot(point - start) / along.length_squared().max(f64::MIN_POSITIVE);
            start + along * part.clamp(0.0, 1.0)
        })
        .min_by(|a, b| a.distance_squared(point).total_cmp(&b.distance_squared(point)))
        .unwrap_or(point)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f32) -> ConvexPolygon {
        ConvexPolygon::rectangle([x, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).expect("a square")
    }

    #[test]
    fn a_line_through_the_edge_of_two_squares_goes_through_both() {
        let line = [DVec3::new(1.0, 0.3, 2.0), DVec3::new(1.0, 0.7, -1.0)];
        for x in [0.0, 1.0] {
            let pierced = pierced(&square(x), line).expect("it meets the edge");
            assert!(pierced.from_front && pierced.to_behind);
            assert!((pierced.at - 2.0 / 3.0).abs() < 1e-12);
        }
        assert_eq!(pierced(&square(1.5), line), None);
    }

    #[test]
    fn a_line_that_ends_in_the_plane_is_not_behind_it_and_one_that_starts_there_is_before_it() {
        let [before, on, behind] = [1.0, 0.0, -1.0].map(|z| DVec3::new(0.25, 0.5, z));
        let ends = pierced(&square(0.0), [before, on]).expect("it ends there");
        assert!(ends.from_front && !ends.to_behind);
        let starts = pierced(&square(0.0), [on, behind]).expect("it starts there");
        assert!(starts.from_front && starts.to_behind);
        assert_eq!(pierced(&square(0.0), [on, on + DVec3::X]), None);
    }

    #[test]
    fn the_nearest_point_is_below_on_an_edge_or_a_corner() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        for (point, nearest) in [
            ([0.3, 0.6, 2.0], [0.3, 0.6, 0.0]),
            ([0.3, -2.0, 1.0], [0.3, 0.0, 0.0]),
            ([4.0, 5.0, 1.0], [1.0, 1.0, 0.0]),
        ] {
            assert_eq!(nearest_in(&corners, DVec3::from(point)), DVec3::from(nearest));
        }
    }
}
