//! Closest points between a segment and a triangle.
//!
//! The minimum distance is either between an end of the segment and the interior of the triangle, or between the
//! segment and an edge. It is zero if the segment pierces the triangle.
//! Source: Ericson, Real-Time Collision Detection, 2005, sections 5.1.9 and 5.1.10.
//! Cost: O(1): three pairs of segments, two points.
//! Exact up to f64 rounding. Zero-length segments and triangles without area are valid input.

use glam::DVec3;

/// Returns the closest points of a segment and a triangle: one on the segment, one on the triangle.
pub fn nearest_points(segment: [DVec3; 2], triangle: [DVec3; 3]) -> [DVec3; 2] {
    let [a, b, c] = triangle;
    let mut best = of_segments(segment, [a, b]);
    let mut least = best[0].distance_squared(best[1]);
    let mut take = |pair: [DVec3; 2]| {
        let square = pair[0].distance_squared(pair[1]);
        if square < least {
            (best, least) = (pair, square);
        }
    };
    take(of_segments(segment, [b, c]));
    take(of_segments(segment, [c, a]));
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square > 0.0 {
        let holds = |point: DVec3| {
            [(a, b), (b, c), (c, a)]
                .iter()
                .all(|&(start, end)| (end - start).cross(point - start).dot(normal) >= 0.0)
        };
        let heights = segment.map(|end| normal.dot(end - a));
        for (end, height) in segment.into_iter().zip(heights) {
            let below = end - normal * (height / square);
            if holds(below) {
                take([end, below]);
            }
        }
        if heights[0] * heights[1] < 0.0 {
            let through = segment[0].lerp(segment[1], heights[0] / (heights[0] - heights[1]));
            if holds(through) {
                take([through; 2]);
            }
        }
    }
    best
}

/// Returns the closest points of two segments.
fn of_segments([p, p_end]: [DVec3; 2], [q, q_end]: [DVec3; 2]) -> [DVec3; 2] {
    let [d, e, r] = [p_end - p, q_end - q, p - q];
    let [dd, ee, de] = [d.length_squared(), e.length_squared(), d.dot(e)];
    let [dr, er] = [d.dot(r), e.dot(r)];
    let part = |of: f64, whole: f64| {
        if whole > 0.0 {
            (of / whole).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    // For nearly parallel lines the determinant is unreliable and any `s` will do: clamping to the ends decides.
    let determinant = dd * ee - de * de;
    let s = if determinant > 1e-14 * dd * ee {
        ((de * er - dr * ee) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let t = part(de * s + er, ee);
    // `t` may have been clamped to the other segment's end, so `s` is computed again.
    let s = part(de * t - dr, dd);
    [p + d * s, q + e * t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn above_beside_and_through_a_triangle() {
        let apart = |segment: [[f64; 3]; 2], triangle| {
            let [near, on] = nearest_points(segment.map(DVec3::from), triangle);
            near.distance(on)
        };
        assert_eq!(apart([[0.2, 0.2, 2.0], [0.2, 0.2, 5.0]], TRIANGLE), 2.0);
        assert_eq!(apart([[0.2, 0.2, -1.0], [0.2, 0.2, 5.0]], TRIANGLE), 0.0);
        assert_eq!(apart([[-3.0, 0.5, -1.0], [-3.0, 0.5, 5.0]], TRIANGLE), 3.0);
        assert_eq!(apart([[-3.0, -4.0, 0.0]; 2], TRIANGLE), 5.0);
        // Without area, and without length.
        assert_eq!(
            apart([[0.5, 3.0, 0.0]; 2], [DVec3::ZERO, DVec3::X, DVec3::X * 0.3]),
            3.0
        );
        assert_eq!(apart([[0.0, 3.0, 4.0]; 2], [DVec3::ZERO; 3]), 5.0);
    }

    #[test]
    fn no_pair_of_points_is_nearer() {
        let mut dice = Dice::new(1);
        for _ in 0..2000 {
            let [p, q, a, b, c] = [(); 5].map(|()| dice.point(0.5));
            let [near, on] = nearest_points([p, q], [a, b, c]);
            for i in 0..=20 {
                let s = f64::from(i) / 20.0;
                for j in 0..=20 {
                    for k in 0..=20 - j {
                        let [u, v] = [j, k].map(|part| f64::from(part) / 20.0);
                        let other = a + (b - a) * u + (c - a) * v;
                        assert!(p.lerp(q, s).distance(other) >= near.distance(on) - 1e-12);
                    }
                }
            }
        }
    }
}
