//! An opening's outline as the eye of one passage meets it.
//!
//! An opening is one-sided: it is looked through from its front. An eye exactly in its plane counts as in front, so that
//! no frame is lost while a camera crosses a doorway or touches a mirror:
//! * inside the outline, the eye looks through the opening in every direction that leads to the back;
//! * outside the outline, it sees the opening edge-on, which owns no sample.
//!
//! "In the plane" means as near to it as its own corners are, plus 2⁻⁴⁰ of the coordinates for rounding.

use crate::geom::{Aabb, ConvexPolygon};
use crate::passage::Passage;
use glam::{DAffine3, DMat3, DVec3};

/// An opening that faces the eye.
pub(crate) struct OpeningView<'a> {
    /// The corners that are rasterized, counter-clockwise from the front.
    pub(crate) positions: &'a [[f32; 3]],
    /// From the space of `positions` to (X, Y, W).
    pub(crate) screen_from_local: DAffine3,
    /// Whether the eye is in the opening; `positions` then stand for all directions that lead to the back.
    pub(crate) holds_eye: bool,
    /// Whether the eye is in the opening, or so little in front that orders may compute that it is behind. Nothing hides
    /// such an opening.
    pub(crate) touches_eye: bool,
}

/// A square around the eye in the plane of the opening that holds it.
const SQUARE: [[f32; 3]; 4] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
];

/// Half the side of that square, and how far before the eye it is, in near distances. All of it is nearer than anything
/// visible, and directions within 2⁻³⁰ of the plane are not told from those along it.
const SQUARE_SIZE: f64 = 1.0 / (1 << 10) as f64;
const SQUARE_DISTANCE: f64 = SQUARE_SIZE / (1 << 30) as f64;

/// Rounding of a distance from a plane, relative to the coordinates that it is computed from.
const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

impl<'a> OpeningView<'a> {
    /// The corners of the face where the opening holds the eye, and where they begin and end.
    pub(crate) const SQUARE_FACE: (&'static [u32], &'static [u32]) = (&[0, 1, 2, 3], &[0, 4]);

    /// Returns `None` where the opening faces away from the eye of `passage` or is seen edge-on.
    pub(crate) fn new(passage: &Passage, outline: &'a ConvexPolygon) -> Option<OpeningView<'a>> {
        let eye = DVec3::from(passage.eye());
        let place = EyePlace::of(outline, eye);
        match place.side {
            EyeSide::Front => Some(OpeningView {
                positions: outline.corners(),
                screen_from_local: passage.screen_from_sector,
                holds_eye: false,
                touches_eye: place.touches,
            }),
            EyeSide::Inside => Some(OpeningView {
                positions: &SQUARE,
                screen_from_local: screen_from_square(passage, outline),
                holds_eye: true,
                touches_eye: true,
            }),
            EyeSide::EdgeOn | EyeSide::Back => None,
        }
    }

    /// The corners as (X, Y, W).
    pub(crate) fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.positions.iter().map(|&corner| {
            self.screen_from_local
                .transform_point3(DVec3::from(corner.map(f64::from)))
        })
    }

    /// The plane n · (X, Y, W) = d of the opening; n has length 1 and points away from the eye, and d ≥ 0.
    pub(crate) fn plane(&self) -> (DVec3, f64) {
        // Newell's sum, relative to one corner so that outlines far away keep their precision.
        let mut corners = self.corners();
        let first = corners.next().unwrap_or_default();
        let mut before = corners.next().unwrap_or_default();
        let mut sum = DVec3::ZERO;
        for corner in corners {
            sum += (before - first).cross(corner - first);
            before = corner;
        }
        let normal = sum.normalize_or_zero();
        let distance = normal.dot(first);
        if distance < 0.0 {
            (-normal, -distance)
        } else {
            (normal, distance)
        }
    }
}

/// Where an eye is relative to an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EyeSide {
    Front,
    /// In the plane, inside the outline.
    Inside,
    /// In the plane, outside the outline.
    EdgeOn,
    Back,
}

/// Where an eye is relative to an opening, and whether orders may disagree on that.
struct EyePlace {
    side: EyeSide,
    touches: bool,
}

impl EyePlace {
    fn of(outline: &ConvexPolygon, eye: DVec3) -> EyePlace {
        let normal = outline.normal_f64();
        let corner = |at: usize| DVec3::from(outline.corners()[at].map(f64::from));
        let count = outline.corners().len();
        let distance = normal.dot(eye - corner(0));
        let magnitude = (0..count)
            .map(|at| corner(at).abs().max_element())
            .fold(eye.abs().max_element(), f64::max);
        // The distance is from the plane through corner 0; any other corner may be this far from it, too.
        let bend = (1..count)
            .map(|at| normal.dot(corner(at) - corner(0)).abs())
            .fold(0.0, f64::max);
        let tolerance = bend + ROUNDING * magnitude;
        // Orders compute the plane from other corners, so they may disagree on the side by as much again.
        let order_tolerance = 2.0 * tolerance;
        if distance.abs() > order_tolerance {
            let side = if distance > 0.0 {
                EyeSide::Front
            } else {
                EyeSide::Back
            };
            return EyePlace { side, touches: false };
        }
        let is_inside = |tolerance: f64| {
            (0..count).all(|at| {
                let [start, end] = [corner(at), corner((at + 1) % count)];
                normal.cross(end - start).dot(eye - start) >= -tolerance * (end - start).length()
            })
        };
        let side = if distance > tolerance {
            EyeSide::Front
        } else if distance < -tolerance {
            EyeSide::Back
        } else if is_inside(tolerance) {
            EyeSide::Inside
        } else {
            EyeSide::EdgeOn
        };
        EyePlace {
            side,
            touches: is_inside(order_tolerance),
        }
    }
}

/// A box around openings, widened so that it contains every eye that touches one of them.
pub(crate) fn may_touch_eye(bounds: &Aabb, eye: DVec3) -> bool {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    let magnitude = min.abs().max(max.abs()).max(eye.abs()).max_element();
    let margin = 2.0
        * (ConvexPolygon::max_bend((max - min).length(), magnitude) + f64::from(f32::EPSILON) * magnitude);
    eye.cmpge(min - margin).all() && eye.cmple(max + margin).all()
}

/// Maps [`SQUARE`] to just before the eye. Its axes come from the linear part alone, for the eye is the origin of screen
/// space, so nothing is lost to cancellation however far from the sector's origin it is.
fn screen_from_square(passage: &Passage, outline: &ConvexPolygon) -> DAffine3 {
    let normal = outline.normal_f64();
    let [u, v] = {
        let u = normal.any_orthonormal_vector();
        [u, normal.cross(u)]
    };
    let screen_from_sector = passage.screen_from_sector.matrix3;
    let near = f64::from(passage.near) / passage.eye_scale();
    DAffine3 {
        matrix3: screen_from_sector * DMat3::from_cols(u, v, DVec3::ZERO) * (near * SQUARE_SIZE),
        translation: screen_from_sector * (-normal * (near * SQUARE_DISTANCE)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(outline: &ConvexPolygon, eye: [f64; 3], side: EyeSide) {
        assert_eq!(EyePlace::of(outline, DVec3::from(eye)).side, side, "{eye:?}");
    }

    #[test]
    fn an_eye_in_the_plane_of_a_doorway_is_in_it_or_beside_it() {
        let doorway =
            ConvexPolygon::rectangle([2.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 2.0, 0.0]).expect("flat");
        assert_eq!(doorway.normal(), [-1.0, 0.0, 0.0]);
        check(&doorway, [1.999_999_9, 1.0, -0.5], EyeSide::Front);
        check(&doorway, [-1e9, 1.0, -0.5], EyeSide::Front);
        check(&doorway, [2.0, 1.0, -0.5], EyeSide::Inside);
        check(&doorway, [2.0, 0.0, -1.0], EyeSide::Inside);
        check(&doorway, [2.0, 2.0, -0.25], EyeSide::Inside);
        check(&doorway, [2.0, 2.000_001, -0.25], EyeSide::EdgeOn);
        check(&doorway, [2.0, 1.0, 5.0], EyeSide::EdgeOn);
        check(&doorway, [2.000_000_1, 1.0, -0.5], EyeSide::Back);
    }

    #[test]
    fn a_doorway_is_no_flatter_for_the_eye_than_its_corners_are() {
        let bent = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 4e-6],
            [0.0, 1.0, 0.0],
        ];
        let bent = ConvexPolygon::new(&bent).expect("flat enough");
        check(&bent, [0.5, 0.5, 1e-6], EyeSide::Inside);
        check(&bent, [0.5, 0.5, 3e-6], EyeSide::Inside);
        check(&bent, [0.5, 0.5, 1e-5], EyeSide::Front);
        check(&bent, [0.5, 0.5, -1e-5], EyeSide::Back);
    }
}
