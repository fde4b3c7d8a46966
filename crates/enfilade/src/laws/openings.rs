//! Which rays go into an opening, as the docs of `opening_view` state it.

use super::bundle::Bundle;
use glam::DVec3;

/// The corners of an opening, counter-clockwise from the front.
pub(super) struct Outline {
    corners: Vec<DVec3>,
    normal: DVec3,
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
        Outline {
            normal,
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
            let w = (distance > 0.5 * in_plane)
                .then(|| self.hit(bundle, ray))
                .flatten()?;
            Some(Entered {
                w: [(w - off).max(0.0), w + off],
                sure,
            })
        };
        if distance.abs() > 2.0 * in_plane {
            return before(true);
        }
        // How far inside the outline the origin is; negative outside.
        let count = self.corners.len();
        let inside = (0..count)
            .map(|at| {
                let [start, end] = [self.corners[at], self.corners[(at + 1) % count]];
                self.normal
                    .cross(end - start)
                    .normalize_or_zero()
                    .dot(origin - start)
            })
            .fold(f64::INFINITY, f64::min);
        let back = -self.normal.dot(bundle.directions[ray].normalize_or_zero());
        if inside < -2.0 * in_plane || back <= 0.0 {
            return before(false);
        }
        Some(Entered {
            w: [0.0, off],
            sure: distance.abs() <= 0.5 * in_plane && inside >= -0.5 * in_plane,
        })
    }

    /// Where a ray meets the outline's triangles from the front.
    fn hit<const N: usize>(&self, bundle: &Bundle<N>, ray: usize) -> Option<f64> {
        let fan =
            (2..self.corners.len()).map(|last| [self.corners[0], self.corners[last - 1], self.corners[last]]);
        fan.filter_map(|triangle| bundle.meets(ray, triangle))
            .find_map(|(w, from_behind)| (!from_behind).then_some(w))
    }
}
