//! Ray/opening intersection, as the docs of `opening_view` define it.

use super::bundle::Bundle;
use glam::DVec3;

/// The corners of an opening, counter-clockwise from the front.
pub(super) struct Outline {
    corners: Vec<DVec3>,
    normal: DVec3,
    /// For each corner, the inward direction in the plane, perpendicular to the edge that starts there.
    inwards: Vec<DVec3>,
    /// Maximum distance of a corner from the plane through the first corner.
    bend: f64,
    magnitude: f64,
}

/// Intersection of a ray with an opening.
pub(super) struct Entered {
    /// Minimum and maximum ray parameter, as the corners are not exactly coplanar.
    pub(super) w: [f64; 2],
    /// Whether the ray certainly enters.
    pub(super) sure: bool,
}

impl Outline {
    pub(super) fn new(corners: Vec<DVec3>) -> Outline {
        let count = corners.len();
        let middle = corners.iter().sum::<DVec3>() / count as f64;
        let normal = (0..count)
            .map(|at| (corners[at] - middle).cross(corners[(at + 1) % count] - middle))
            .sum::<DVec3>()
            .normalize_or_zero();
        let bend = corners.iter().map(|corner| normal.dot(corner - corners[0]).abs());
        let inwards = (0..count)
            .map(|at| {
                normal
                    .cross(corners[(at + 1) % count] - corners[at])
                    .normalize_or_zero()
            })
            .collect();
        Outline {
            normal,
            inwards,
            bend: bend.fold(0.0, f64::max),
            magnitude: corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max),
            corners,
        }
    }

    /// Intersects a ray of the bundle with the front of the opening.
    pub(super) fn entered<const N: usize>(&self, bundle: &Bundle<N>, ray: usize) -> Option<Entered> {
        let origin = bundle.origin_of(ray);
        let distance = self.normal.dot(origin - self.corners[0]);
        let magnitude = self.magnitude.max(origin.abs().max_element());
        let in_plane = self.bend + magnitude * 2.0_f64.powi(-40);
        // Uncertainty of the parameter from rounding to f32 and from corners off the plane.
        let off = (self.bend + magnitude * 0.5 * f64::from(f32::EPSILON))
            / self.normal.dot(bundle.directions[ray]).abs();
        let before = |sure| {
            let (w, inside) = (distance > 0.5 * in_plane)
                .then(|| self.hit(bundle, ray))
                .flatten()?;
            Some(Entered {
                w: [(w - off).max(0.0), w + off],
                sure: sure && inside,
            })
        };
        if distance.abs() > 2.0 * in_plane {
            return before(true);
        }
        let inside = self.inside(origin);
        let back = -self.normal.dot(bundle.directions[ray].normalize_or_zero());
        if inside < -2.0 * in_plane || back <= 0.0 {
            return before(false);
        }
        Some(Entered {
            w: [0.0, off],
            sure: distance.abs() <= 0.5 * in_plane && inside >= -0.5 * in_plane,
        })
    }

    /// Returns the distance of a point of the plane from the nearest edge; negative outside the outline.
    fn inside(&self, point: DVec3) -> f64 {
        let sides = self.inwards.iter().zip(&self.corners);
        sides
            .map(|(inwards, start)| inwards.dot(point - start))
            .fold(f64::INFINITY, f64::min)
    }

    /// Intersects a ray with the front of the outline. Returns the parameter and whether the hit is certain.
    ///
    /// The corners are coplanar only to within `bend`, so a ray at a grazing angle may pass the edge anywhere within
    /// the length of `bend` projected along the ray.
    fn hit<const N: usize>(&self, bundle: &Bundle<N>, ray: usize) -> Option<(f64, bool)> {
        let fan =
            (2..self.corners.len()).map(|last| [self.corners[0], self.corners[last - 1], self.corners[last]]);
        let hit = fan
            .filter_map(|triangle| bundle.meets(ray, triangle))
            .find_map(|(w, from_behind)| (!from_behind).then_some(w));
        let direction = bundle.directions[ray];
        let back = -self.normal.dot(direction);
        if self.bend == 0.0 || back <= 0.0 {
            return hit.map(|w| (w, true));
        }
        let origin = bundle.origin_of(ray);
        let w = self.normal.dot(origin - self.corners[0]) / back;
        let inside = self.inside(origin + direction * w);
        let slide = self.bend * direction.length() / back;
        (hit.is_some() || inside >= -slide).then_some((hit.unwrap_or(w), inside > slide))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Traces a ray from (0, 0, 1) to (x, y, 0) into a square of side 2 around the origin, one corner of which is
    /// raised by `bend`. Returns whether it certainly enters; `None` if it cannot enter.
    fn enters(x: f64, y: f64, bend: f64) -> Option<bool> {
        let corners = [
            [-1.0, -1.0, 0.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, bend],
            [-1.0, 1.0, 0.0],
        ];
        let outline = Outline::new(corners.map(DVec3::from).to_vec());
        let origin = DVec3::new(0.0, 0.0, 1.0);
        let bundle = Bundle {
            origin,
            directions: [DVec3::new(x, y, 0.0) - origin],
            offsets: None,
        };
        outline.entered(&bundle, 0).map(|entered| entered.sure)
    }

    #[test]
    fn rays_into_a_flat_opening_are_certain_up_to_its_edge() {
        for x in [0.0, 0.5, 0.999_999, -0.999_999] {
            assert_eq!(enters(x, 0.1, 0.0), Some(true), "{x}");
        }
        for x in [1.000_001, -1.000_001, 3.0] {
            assert_eq!(enters(x, 0.1, 0.0), None, "{x}");
        }
    }

    #[test]
    fn rays_past_the_edge_of_a_bent_opening_are_open_within_the_bend_alone() {
        let bend = 1e-4;
        for x in [0.0, 0.9, 0.999] {
            assert_eq!(enters(x, 0.1, bend), Some(true), "{x}");
        }
        // The plane through its centre is half of `bend` in front of z = 0; rays to the edge have not reached the edge
        // there.
        assert_eq!(enters(1.000_08, 0.1, bend), Some(false));
        for x in [1.001, -1.001, 3.0] {
            assert_eq!(enters(x, 0.1, bend), None, "{x}");
        }
    }
}
