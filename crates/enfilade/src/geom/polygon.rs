//! Planar convex polygons, used for openings and portals.

use crate::geom::{Aabb, MAX_COORDINATE, is_in_range};
use glam::DVec3;
use thiserror::Error;

/// Planar convex polygon of at least three corners, counter-clockwise seen from the front.
#[doc(alias = "portal polygon")]
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<[f32; 3]>", into = "Vec<[f32; 3]>"))]
pub struct ConvexPolygon {
    corners: Vec<[f32; 3]>,
    normal: [f64; 3],
}

/// Reasons why corners do not form a convex polygon.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PolygonError {
    /// Fewer than three corners.
    #[error("a polygon needs at least 3 corners, but has {0}")]
    TooFewCorners(usize),
    /// A coordinate of a corner is NaN or infinite.
    #[error("corner {0} is not finite")]
    NotFinite(usize),
    /// A coordinate of a corner exceeds [`MAX_COORDINATE`].
    #[error(
        "corner {0} is farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to the origin"
    )]
    TooFar(usize),
    /// All corners are collinear or coincide.
    #[error("the polygon has no area: its corners are collinear or coincide")]
    NoArea,
    /// A corner is off the plane of the others.
    #[error("corner {corner} is {off:.3e} units off the plane of the others")]
    NotFlat {
        /// Index of the corner, from 0.
        corner: usize,
        /// Distance to the plane, in scene units.
        off: f64,
    },
    /// The outline is concave at a corner.
    #[error("the polygon is concave at corner {0}")]
    NotConvex(usize),
}

/// Maximum distance of a corner from the plane, relative to the polygon's size: a hundred times what the f32 positions
/// of a large planar polygon lose to rounding. The rounding of positions far from the origin is added separately.
const FLATNESS: f64 = 1e-5;

impl ConvexPolygon {
    /// Creates a polygon after checking flatness and convexity, up to the rounding of f32 positions. Takes O(corners).
    ///
    /// # Errors
    /// The [`PolygonError`] of the first broken rule; each variant names one rule and, if possible, the first corner
    /// that breaks it.
    pub fn new(corners: &[[f32; 3]]) -> Result<ConvexPolygon, PolygonError> {
        if corners.len() < 3 {
            return Err(PolygonError::TooFewCorners(corners.len()));
        }
        if let Some(corner) = corners
            .iter()
            .position(|c| c.iter().any(|value| !value.is_finite()))
        {
            return Err(PolygonError::NotFinite(corner));
        }
        if let Some(corner) = corners
            .iter()
            .position(|c| !c.iter().all(|&value| is_in_range(value)))
        {
            return Err(PolygonError::TooFar(corner));
        }
        let points: Vec<DVec3> = corners.iter().map(|&c| DVec3::from(c.map(f64::from))).collect();
        // Newell's method: the sum is twice the area times the normal, and stays valid if three consecutive corners are
        // collinear.
        let origin = points[0];
        let sum: DVec3 = (0..points.len())
            .map(|i| (points[i] - origin).cross(points[(i + 1) % points.len()] - origin))
            .sum();
        let size = points.iter().map(|&p| (p - origin).length()).fold(0.0, f64::max);
        if sum.length() <= 1e-12 * size * size || size == 0.0 {
            return Err(PolygonError::NoArea);
        }
        let normal = sum.normalize();
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let far = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let slack = ConvexPolygon::max_bend(size, far);
        for (i, &point) in points.iter().enumerate() {
            let off = normal.dot(point - middle).abs();
            if off > slack {
                return Err(PolygonError::NotFlat { corner: i, off });
            }
            let before = points[(i + points.len() - 1) % points.len()];
            let after = points[(i + 1) % points.len()];
            let turn = (point - before).cross(after - point).dot(normal);
            if turn < -slack * size {
                return Err(PolygonError::NotConvex(i));
            }
        }
        Ok(ConvexPolygon {
            corners: corners.to_vec(),
            normal: normal.into(),
        })
    }

    /// Creates a rectangle with the corners `corner`, `corner + along`, `corner + along + up`, `corner + up`. Its front
    /// is the side from which these run counter-clockwise.
    ///
    /// # Errors
    /// [`PolygonError::NoArea`], [`PolygonError::NotFinite`] or [`PolygonError::TooFar`].
    pub fn rectangle(corner: [f32; 3], along: [f32; 3], up: [f32; 3]) -> Result<ConvexPolygon, PolygonError> {
        let sum = |a: [f32; 3], b: [f32; 3]| -> [f32; 3] { std::array::from_fn(|axis| a[axis] + b[axis]) };
        ConvexPolygon::new(&[
            corner,
            sum(corner, along),
            sum(sum(corner, along), up),
            sum(corner, up),
        ])
    }

    /// Returns the corners (at least three), counter-clockwise seen from the front.
    pub fn corners(&self) -> &[[f32; 3]] {
        &self.corners
    }

    /// Returns the unit normal, which points to the front.
    pub fn normal(&self) -> [f32; 3] {
        self.normal.map(|value| value as f32)
    }

    pub(crate) fn normal_f64(&self) -> DVec3 {
        DVec3::from(self.normal)
    }

    /// Returns the tolerance for points in front of the polygon, in scene units: the distance by which rounding to f32
    /// and the flatness of outlines may put them behind it.
    pub fn slack(&self) -> f64 {
        let bounds = self.bounds();
        let farthest =
            (bounds.min.iter().chain(&bounds.max)).fold(0.0_f32, |most, value| most.max(value.abs()));
        1e-5 * f64::from(bounds.longest_side()) + 4.0 * f64::from(f32::EPSILON) * f64::from(farthest)
    }

    /// Returns the maximum accepted distance of a corner from the plane, for a polygon of this size and maximum
    /// absolute coordinate.
    pub(crate) fn max_bend(size: f64, greatest_coordinate: f64) -> f64 {
        FLATNESS * size + f64::from(f32::EPSILON) * greatest_coordinate
    }

    /// Returns the AABB of the corners.
    pub fn bounds(&self) -> Aabb {
        Aabb::of(self.corners.iter().copied())
    }

    /// Returns the same polygon with reversed winding: front and back exchanged.
    #[must_use]
    pub fn flipped(&self) -> ConvexPolygon {
        ConvexPolygon {
            corners: self.corners.iter().rev().copied().collect(),
            normal: self.normal.map(|value| -value),
        }
    }
}

impl TryFrom<Vec<[f32; 3]>> for ConvexPolygon {
    type Error = PolygonError;

    fn try_from(corners: Vec<[f32; 3]>) -> Result<ConvexPolygon, PolygonError> {
        ConvexPolygon::new(&corners)
    }
}

impl From<ConvexPolygon> for Vec<[f32; 3]> {
    fn from(polygon: ConvexPolygon) -> Vec<[f32; 3]> {
        polygon.corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f32; 3]]) -> Result<ConvexPolygon, PolygonError> {
        ConvexPolygon::new(corners)
    }

    #[test]
    fn each_broken_rule_has_its_own_error() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(polygon(&square).is_ok());
        assert_eq!(polygon(&square[..2]), Err(PolygonError::TooFewCorners(2)));
        assert_eq!(
            polygon(&[[0.0; 3], [1.0; 3], [2.0; 3]]),
            Err(PolygonError::NoArea)
        );
        assert_eq!(
            polygon(&[[f32::NAN; 3], [1.0; 3], [2.0; 3]]),
            Err(PolygonError::NotFinite(0))
        );
        assert_eq!(
            polygon(&[[0.0; 3], [1.0; 3], [0.0, 1.1e12, 0.0]]),
            Err(PolygonError::TooFar(2))
        );
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]];
        assert!(matches!(polygon(&bent), Err(PolygonError::NotFlat { .. })));
        let dart = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(polygon(&dart), Err(PolygonError::NotConvex(2)));
    }

    #[test]
    fn a_slanted_door_far_out_is_as_flat_as_its_coordinates_allow() {
        for far in [0.0, 1e3, 1e5, 1e6_f32] {
            let slanted = [[0.0, 0.0, 0.0], [0.7, 0.0, 0.7], [0.7, 2.1, 0.7], [0.0, 2.1, 0.0]];
            let corners = slanted.map(|corner: [f32; 3]| corner.map(|value| value + far));
            assert!(polygon(&corners).is_ok(), "{far} out");
        }
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]];
        let bent = bent.map(|corner: [f32; 3]| corner.map(|value| value + 1e5));
        assert!(matches!(polygon(&bent), Err(PolygonError::NotFlat { .. })));
    }

    #[test]
    fn a_flipped_polygon_faces_the_other_way() {
        let up = ConvexPolygon::rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).expect("a square");
        assert_eq!(up.normal(), [0.0, 0.0, 1.0]);
        assert_eq!(up.flipped().normal(), [0.0, 0.0, -1.0]);
        assert_eq!(
            ConvexPolygon::new(up.flipped().corners())
                .expect("still a square")
                .normal(),
            [0.0, 0.0, -1.0]
        );
    }
}
