//! The view of an opening's outline from the eye of one passage.
//!
//! An opening is one-sided: it is visible from its front only. An eye exactly in its plane counts as in front, so that
//! no frame is lost while a camera crosses a doorway or touches a mirror:
//! * inside the outline, the opening covers every direction that leads to the back;
//! * outside the outline, the opening is edge-on and owns no sample.
//!
//! "In the plane" means within the opening's own deviation from flatness, plus 2⁻⁴⁰ of the coordinates for rounding.

use crate::geom::{Aabb, ConvexPolygon};
use crate::view::passage::Passage;
use crate::view::screen_map::ScreenMap;
use glam::{DAffine3, DMat3, DVec3};

/// An opening that faces the eye.
pub(crate) struct OpeningView<'a> {
    /// The corners to rasterize, counter-clockwise when seen from the front.
    pub(crate) positions: &'a [[f32; 3]],
    /// Transform from the space of `positions` to (X, Y, W).
    pub(crate) screen_from_local: ScreenMap,
    /// Whether the eye is in the opening; `positions` then cover all directions that lead to the back.
    pub(crate) holds_eye: bool,
    /// Whether the eye is in the opening, or so little in front of it that orders may compute that it is behind. No
    /// occluder hides such an opening.
    #[cfg_attr(
        not(feature = "classic"),
        expect(dead_code, reason = "read by the sorted orders")
    )]
    pub(crate) touches_eye: bool,
}

/// A square around the eye in the plane of the opening that contains it.
const SQUARE: [[f32; 3]; 4] = [
    [-1.0, -1.0, 0.0],
    [1.0, -1.0, 0.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
];

/// Half the side of that square, and its distance in front of the eye, both in near distances. The square is nearer
/// than anything visible; directions within 2⁻³⁰ of the plane count as parallel to it.
const SQUARE_SIZE: f64 = 1.0 / (1 << 10) as f64;
const SQUARE_DISTANCE: f64 = SQUARE_SIZE / (1 << 30) as f64;

/// Rounding error of the distance from a plane, relative to the coordinates that it is computed from.
const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

impl<'a> OpeningView<'a> {
    /// Corner indices and face starts of the square that replaces an outline that contains the eye.
    pub(crate) const SQUARE_FACE: (&'static [u32], &'static [u32]) = (&[0, 1, 2, 3], &[0, 4]);

    /// Returns `None` if the opening faces away from the eye of `passage` or is edge-on.
    pub(crate) fn new(passage: &Passage, outline: &'a ConvexPolygon) -> Option<OpeningView<'a>> {
        let eye = DVec3::from(passage.viewpoint());
        let place = EyePosition::of(outline, eye);
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

    /// Returns the corners as (X, Y, W).
    pub(crate) fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.positions
            .iter()
            .map(|&corner| self.screen_from_local.point(DVec3::from(corner.map(f64::from))))
    }

    /// Returns the plane n · (X, Y, W) = d of the opening; n has length 1 and points away from the eye, and d ≥ 0.
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

/// The side of an opening that the eye is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EyeSide {
    Front,
    /// In the plane, inside the outline.
    Inside,
    /// In the plane, outside the outline.
    EdgeOn,
    Back,
}

/// The side of an opening that the eye is on, and whether orders may disagree about it.
struct EyePosition {
    side: EyeSide,
    touches: bool,
}

impl EyePosition {
    fn of(outline: &ConvexPolygon, eye: DVec3) -> EyePosition {
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
            return EyePosition { side, touches: false };
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
        EyePosition {
            side,
            touches: is_inside(order_tolerance),
        }
    }
}

/// Whether the eye may touch one of the openings in a box. The box is widened by their maximum deviation from flatness
/// and by rounding.
pub(crate) fn may_touch_eye(bounds: &Aabb, eye: DVec3) -> bool {
    let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
    let magnitude = min.abs().max(max.abs()).max(eye.abs()).max_element();
    let margin = 2.0
        * (ConvexPolygon::max_bend((max - min).length(), magnitude) + f64::from(f32::EPSILON) * magnitude);
    eye.cmpge(min - margin).all() && eye.cmple(max + margin).all()
}

/// Maps [`SQUARE`] to just in front of the eye. Uses only the linear part of the transform, because the eye is the
/// origin of (X, Y, W) space: nothing cancels, however far the eye is from the sector's origin.
fn screen_from_square(passage: &Passage, outline: &ConvexPolygon) -> ScreenMap {
    let normal = outline.normal_f64();
    let [u, v] = {
        let u = normal.any_orthonormal_vector();
        [u, normal.cross(u)]
    };
    let screen_from_sector = passage.screen_from_sector.linear.matrix3;
    let near = f64::from(passage.z_near) / passage.eye_scale();
    ScreenMap {
        linear: DAffine3 {
            matrix3: screen_from_sector * DMat3::from_cols(u, v, DVec3::ZERO) * (near * SQUARE_SIZE),
            translation: screen_from_sector * (-normal * (near * SQUARE_DISTANCE)),
        },
        is_parallel: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(outline: &ConvexPolygon, eye: [f64; 3], side: EyeSide) {
        assert_eq!(EyePosition::of(outline, DVec3::from(eye)).side, side, "{eye:?}");
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
