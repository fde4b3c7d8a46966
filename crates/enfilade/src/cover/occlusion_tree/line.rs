//! Shadow planes through the eye, which are lines on the screen, and the planes of occluders.
//!
//! In the space of (X, Y, W) the eye is the origin, so the plane through it and an edge is x·X + y·Y + z·W = 0: the
//! line x·px + y·py + z = 0 on the screen. It is scaled so that x² + y² = 1; then its height at a point, divided by W,
//! is the distance on the screen in pixels, and "within s pixels of the line" is linear: height ≤ s·W. What holds for
//! the corners of a polygon holds for all of it, even for one that reaches from below the eye to the horizon.

use crate::geom::cross;
use glam::DVec3;

/// Points within this distance of a line count as on it, in pixels: 2⁻²⁴.
///
/// Rounding moves corners by about 2⁻⁴⁰ pixel on a screen of 2,000 columns, and by more where a line extends far beyond
/// the edge it was made from. A much smaller value would leave cracks between occluders that meet along a line but
/// share no edge; the samples that the conformance suite requires to agree are 2⁻¹⁰ pixel apart.
pub(super) const SLIT: f64 = 1.0 / (1_u64 << 24) as f64;

/// Relative distance by which planes of occluders are pushed away: about a hundred times the rounding error.
const PUSH: f64 = 1.0 / (1_u64 << 44) as f64;

/// A line on the screen; points inside have a positive height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) normal: DVec3,
}

impl Line {
    /// Returns the line through two points given as (X, Y, W); the inside is on the left of the direction from `from`
    /// to `to`, as seen from the eye. `None` if both project to one point.
    ///
    /// It is computed from the same end in either direction, so that neighbouring faces get the same line; and without
    /// cancellation, so that both ends are on it up to the last bits.
    pub(super) fn through(from: DVec3, to: DVec3) -> Option<Line> {
        let swap = to.to_array() < from.to_array();
        let [a, b] = if swap { [to, from] } else { [from, to] };
        let normal = cross((b, DVec3::ZERO), (a, DVec3::ZERO));
        let scale = (normal.x * normal.x + normal.y * normal.y).sqrt();
        let normal = if swap { -normal } else { normal } / scale;
        (scale > 0.0 && normal.is_finite()).then_some(Line { normal })
    }

    /// Returns the line with inside and outside exchanged.
    pub(super) fn flipped(self) -> Line {
        Line { normal: -self.normal }
    }

    /// Returns the line moved outwards by this number of pixels.
    pub(super) fn outward(self, pixels: f64) -> Line {
        let DVec3 { x, y, z } = self.normal;
        Line {
            normal: DVec3::new(x, y, z + pixels),
        }
    }

    /// Returns the height of a point: its distance inside the line in pixels, times its W.
    #[inline(always)]
    pub(super) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point)
    }
}

/// The plane of an occluder, pushed away from the eye by a little more than rounding errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Back {
    pub(super) normal: DVec3,
    pub(super) distance: f64,
}

impl Back {
    /// Creates the plane from n · p = d. Every point with a positive height above it is behind n · p = d, at any
    /// position on the screen; `None` unless d > 0 and all values are finite.
    ///
    /// `far` are the maximum |x| and |y| on the screen, in pixels. `rounding` is the maximum distance of a corner from
    /// its exact position: far from the sector's origin that is more than the eye-relative coordinates suggest.
    pub(super) fn new((normal, distance): (DVec3, f64), far: [f64; 2], rounding: f64) -> Option<Back> {
        let sum = normal.x.abs() * far[0] + normal.y.abs() * far[1] + normal.z.abs();
        let moved = rounding * (normal.x.abs() + normal.y.abs() + normal.z.abs());
        let back = Back {
            normal: normal - DVec3::Z * (PUSH * sum),
            // Once for the occluder's corners, once for those of the tested geometry.
            distance: distance * (1.0 + PUSH) + 2.0 * moved,
        };
        (distance > 0.0 && back.normal.is_finite() && back.distance.is_finite()).then_some(back)
    }

    /// Returns a value that is positive behind the plane and proportional to the distance from it.
    #[inline(always)]
    pub(super) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_has_one_line_whichever_way_it_runs() {
        let [a, b] = [DVec3::new(300.0, 200.0, 2.0), DVec3::new(-70.0, 431.0, 7.0)];
        let [there, back] =
            [(a, b), (b, a)].map(|(from, to)| Line::through(from, to).expect("the points are apart"));
        assert_eq!(there.normal, -back.normal);
    }

    #[test]
    fn heights_are_pixels_and_the_left_is_inside() {
        // Down the screen (y points down) at x = 10: seen from the eye, the left side has the larger x.
        let line = Line::through(DVec3::new(10.0, 0.0, 1.0), DVec3::new(20.0, 60.0, 2.0))
            .expect("the points are apart");
        assert!((line.height(DVec3::new(13.0, 5.0, 1.0)) - 3.0).abs() < 1e-12);
        assert!((line.outward(0.5).height(DVec3::new(13.0, 5.0, 1.0)) - 3.5).abs() < 1e-12);
    }

    #[test]
    fn the_ends_of_an_edge_lie_on_its_line_at_any_scale() {
        for scale in [1e-5, 1.0, 1e7] {
            let a = DVec3::new(612.5, 311.2, 1.7) * scale;
            let b = DVec3::new(612.6, 311.1, 1.700_001) * scale;
            let line = Line::through(a, b).expect("the points are apart");
            for end in [a, b] {
                assert!((line.height(end) / end.z).abs() < 1e-11, "at {scale}");
            }
        }
    }

    #[test]
    fn what_is_in_the_plane_of_an_occluder_is_not_behind_it() {
        let [n, at] = [DVec3::new(0.3, -0.2, 0.7), DVec3::new(100.0, 70.0, 10.0)];
        let back = Back::new((n, n.dot(at)), [2000.0; 2], 0.0).expect("the eye is not in the plane");
        assert!(back.height(at) < 0.0 && back.height(at * (1.0 + 1e-9)) > 0.0);
        assert_eq!(Back::new((n, 0.0), [1.0; 2], 0.0), None);
    }
}
