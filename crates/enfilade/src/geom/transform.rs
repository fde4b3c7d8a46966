//! Affine maps between spaces.

use crate::geom::Aabb;
use glam::{DAffine3, DMat3, DVec3};
use std::ops::Mul;

/// An affine map from one space to another, f64 inside.
///
/// Name a variable by both ends, target first: `sector_from_item`, `there_from_here`. Then a product reads as
/// a chain, `eye_from_item = eye_from_sector * sector_from_item`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform(pub(crate) DAffine3);

impl Transform {
    /// The map that changes nothing.
    pub const IDENTITY: Transform = Transform(DAffine3::IDENTITY);

    /// Three columns of the linear part, then the translation.
    pub fn from_columns(columns: [[f32; 3]; 4]) -> Transform {
        let [x, y, z, translation] = columns.map(|column| DVec3::from(column.map(f64::from)));
        Transform(DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation,
        })
    }

    /// Three columns of the linear part, then the translation, rounded to f32.
    pub fn columns(&self) -> [[f32; 3]; 4] {
        self.0
            .to_cols_array_2d()
            .map(|column| column.map(|value| value as f32))
    }

    /// A shift by `offset`, in scene units.
    pub fn translation(offset: [f32; 3]) -> Transform {
        Transform(DAffine3::from_translation(DVec3::from(offset.map(f64::from))))
    }

    /// A turn about `axis` (any length but zero) by `radians`, counter-clockwise seen against the axis.
    pub fn rotation(axis: [f32; 3], radians: f64) -> Transform {
        let axis = DVec3::from(axis.map(f64::from)).normalize_or(DVec3::Y);
        Transform(DAffine3::from_axis_angle(axis, radians))
    }

    /// A scaling along each axis.
    pub fn scaling(factors: [f32; 3]) -> Transform {
        Transform(DAffine3::from_scale(DVec3::from(factors.map(f64::from))))
    }

    /// A reflection in the plane through `point` with the unit normal `normal`.
    pub fn reflection(point: [f32; 3], normal: [f32; 3]) -> Transform {
        let point = DVec3::from(point.map(f64::from));
        let n = DVec3::from(normal.map(f64::from)).normalize_or(DVec3::Y);
        let matrix3 = DMat3::IDENTITY - 2.0 * DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        Transform(DAffine3 {
            matrix3,
            translation: n * (2.0 * n.dot(point)),
        })
    }

    /// The map back, or `None` where this one flattens space or is not finite.
    pub fn inverse(&self) -> Option<Transform> {
        let inverse = self.0.inverse();
        // The determinant of a tiny but sound scale is tiny too: only a map that cannot be undone is refused.
        (self.0.matrix3.determinant() != 0.0 && inverse.is_finite()).then_some(Transform(inverse))
    }

    /// Is the linear part a rotation or reflection times a factor, up to what f32 columns lose?
    pub fn is_similarity(&self) -> bool {
        let matrix = self.0.matrix3;
        let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let square = columns[0].length_squared();
        let close = |value: f64, expected: f64| (value - expected).abs() <= 1e-5 * square;
        self.is_finite()
            && square > 0.0
            && (columns.iter()).all(|column| close(column.length_squared(), square))
            && (0..3).all(|i| close(columns[i].dot(columns[(i + 1) % 3]), 0.0))
    }

    /// The factor by which lengths grow; of a map that stretches, the mean one.
    pub fn scale(&self) -> f64 {
        self.0.matrix3.determinant().abs().cbrt()
    }

    /// Does the map turn left hands into right ones?
    pub fn mirrors(&self) -> bool {
        self.0.matrix3.determinant() < 0.0
    }

    /// Where a point goes.
    pub fn point(&self, point: [f32; 3]) -> [f32; 3] {
        self.0
            .transform_point3(DVec3::from(point.map(f64::from)))
            .as_vec3()
            .into()
    }

    /// Where a point goes, unrounded.
    pub(crate) fn point_f64(&self, point: [f32; 3]) -> [f64; 3] {
        self.0.transform_point3(DVec3::from(point.map(f64::from))).into()
    }

    /// The least box of f32 that holds the place a point goes to: boxes must not lose to rounding what they hold.
    pub(crate) fn point_box(&self, point: [f32; 3]) -> Aabb {
        let exact: [f64; 3] = self.0.transform_point3(DVec3::from(point.map(f64::from))).into();
        let below = |value: f64| {
            if f64::from(value as f32) > value {
                (value as f32).next_down()
            } else {
                value as f32
            }
        };
        Aabb {
            min: exact.map(below),
            max: exact.map(|value| -below(-value)),
        }
    }

    /// Where a direction goes; its length may change.
    pub fn direction(&self, direction: [f32; 3]) -> [f32; 3] {
        self.0
            .transform_vector3(DVec3::from(direction.map(f64::from)))
            .as_vec3()
            .into()
    }

    /// Are all its numbers finite?
    pub fn is_finite(&self) -> bool {
        self.0.is_finite()
    }
}

impl Mul for Transform {
    type Output = Transform;

    fn mul(self, first: Transform) -> Transform {
        Transform(self.0 * first.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reflection_keeps_its_plane_and_swaps_its_sides() {
        let mirror = Transform::reflection([0.0, 0.0, 3.0], [0.0, 0.0, 1.0]);
        assert_eq!(mirror.point([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
        assert_eq!(mirror.point([1.0, 2.0, 5.0]), [1.0, 2.0, 1.0]);
        assert!(mirror.mirrors());
    }

    #[test]
    fn a_flattening_map_has_no_way_back_but_a_tiny_scale_has() {
        assert_eq!(Transform::scaling([1.0, 0.0, 1.0]).inverse(), None);
        let back = Transform::scaling([1e-12; 3])
            .inverse()
            .expect("a tiny scale can be undone");
        assert_eq!(back.point([1e-12; 3]), [1.0; 3]);
    }
}
