//! Which rays go into an opening, as the docs of `opening_view` state it.

use super::bundle::Bundle;
use glam::DVec3;

/// The corners of an opening, counter-clockwise from the front.
pub(super) struct Outline {
    corners: Vec<DVec3>,
    normal: DVec3,
    /// Per corner, the direction in the plane from the next side inwards.
    inwards: Vec<DVec3>,
    /// How far any corner is from the plane through the first.
    bend: f64,
    magnitude: f64,
}

/// Where a ray goes into an opening.
pub(super) struct Entered {
    /// The least and the greatest parameter that the corners, which are not quite flat, leave open.
    pub(super) w: [f64; 2],
    /// Whether the ray certainly goes into it.
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

    /// Where a ray of the bundle goes into the opening from its front.
    pub(super) fn entered<const N: usize>(&self, bundle: &Bundle<N>, ray: usize) -> Option<Entered> {
        let origin = bundle.origin;
        let distance = self.normal.dot(origin - self.corners[0]);
        let magnitude = self.magnitude.max(origin.abs().max_element());
        let in_plane = self.bend + magnitude * 2.0_f64.powi(-40);
        // How much nearer or farther rounding to f32 and corners off the plane may put it.
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

    /// How far a point of the plane is inside the outline; negative outside.
    fn inside(&self, point: DVec3) -> f64 {
        let sides = self.inwards.iter().zip(&self.corners);
        sides
            .map(|(inwards, start)| inwards.dot(point - start))
            .fold(f64::INFINITY, f64::min)
    }

    /// Where a ray may meet the outline from the front, and whether it certainly does.
    ///
    /// The corners are flat to `bend` alone, so a ray at a grazing angle may pass the edge anywhere within the bend's length along it.
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
        let w = self.normal.dot(bundle.origin - self.corners[0]) / back;
        let inside = self.inside(bundle.origin + direction * w);
        let slide = self.bend * direction.length() / back;
        (hit.is_some() || inside >= -slide).then_some((hit.unwrap_or(w), inside > slide))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a ray from (0, 0, 1) to a point of the plane z = 0 enters a square of side 2 around the origin, and if so certainly;
    /// one corner of it is `bend` before the plane.
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
        // The plane through its middle is half the bend before z = 0, where rays to the edge are not yet at it.
        assert_eq!(enters(1.000_08, 0.1, bend), Some(false));
        for x in [1.001, -1.001, 3.0] {
            assert_eq!(enters(x, 0.1, bend), None, "{x}");
        }
    }
}
