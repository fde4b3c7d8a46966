//! Affine transforms between spaces.

use crate::geom::Aabb;
use glam::{DAffine3, DMat3, DVec3};
use std::ops::Mul;

/// An affine transform from one space to another, stored in f64.
///
/// Name a variable by both spaces, target first: `sector_from_item`, `there_from_here`. A product then reads as a
/// chain: `eye_from_item = eye_from_sector * sector_from_item`.
#[doc(alias = "matrix")]
#[doc(alias = "affine")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(from = "[[f64; 3]; 4]", into = "[[f64; 3]; 4]"))]
pub struct Transform(pub(crate) DAffine3);

impl Transform {
    /// The identity transform.
    pub const IDENTITY: Transform = Transform(DAffine3::IDENTITY);

    /// Creates a transform from the three columns of the linear part and the translation.
    pub fn from_columns(columns: [[f32; 3]; 4]) -> Transform {
        let [x, y, z, translation] = columns.map(|column| DVec3::from(column.map(f64::from)));
        Transform(DAffine3 {
            matrix3: DMat3::from_cols(x, y, z),
            translation,
        })
    }

    /// Creates a transform from the three columns of the linear part and the translation, in f64.
    pub fn from_columns_f64(columns: [[f64; 3]; 4]) -> Transform {
        Transform(DAffine3::from_cols_array_2d(&columns))
    }

    /// Returns the three columns of the linear part and the translation, rounded to f32.
    pub fn columns(&self) -> [[f32; 3]; 4] {
        self.0
            .to_cols_array_2d()
            .map(|column| column.map(|value| value as f32))
    }

    /// Returns the columns of the linear part and the translation, in full precision.
    pub fn columns_f64(&self) -> [[f64; 3]; 4] {
        self.0.to_cols_array_2d()
    }

    /// Creates a translation by `offset`, in scene units.
    pub fn translation(offset: [f32; 3]) -> Transform {
        Transform(DAffine3::from_translation(DVec3::from(offset.map(f64::from))))
    }

    /// Creates a rotation about `axis` (any nonzero length) by `radians`, counter-clockwise when looking against the
    /// axis.
    pub fn rotation(axis: [f32; 3], radians: f64) -> Transform {
        let axis = DVec3::from(axis.map(f64::from)).normalize_or(DVec3::Y);
        Transform(DAffine3::from_axis_angle(axis, radians))
    }

    /// Creates a scaling by a factor along each axis.
    pub fn scaling(factors: [f32; 3]) -> Transform {
        Transform(DAffine3::from_scale(DVec3::from(factors.map(f64::from))))
    }

    /// Creates a reflection in the plane through `point` with the normal `normal`, which is normalized.
    pub fn reflection(point: [f32; 3], normal: [f32; 3]) -> Transform {
        let point = DVec3::from(point.map(f64::from));
        let n = DVec3::from(normal.map(f64::from)).normalize_or(DVec3::Y);
        let matrix3 = DMat3::IDENTITY - 2.0 * DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        Transform(DAffine3 {
            matrix3,
            translation: n * (2.0 * n.dot(point)),
        })
    }

    /// Returns the inverse, or `None` if this transform is singular or not finite.
    pub fn inverse(&self) -> Option<Transform> {
        let inverse = self.0.inverse();
        // The determinant of a tiny but valid scale is tiny too, so only exactly singular transforms are rejected.
        (self.0.matrix3.determinant() != 0.0 && inverse.is_finite()).then_some(Transform(inverse))
    }

    /// Returns `true` if the linear part is a rotation or reflection times a uniform scale, up to the rounding of f32
    /// columns.
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

    /// Returns the factor by which lengths grow; for a nonuniform scale, the geometric mean.
    pub fn scale(&self) -> f64 {
        self.0.matrix3.determinant().abs().cbrt()
    }

    /// Returns `true` if the transform is mirrored (negative determinant), which flips the winding of faces.
    pub fn mirrors(&self) -> bool {
        self.0.matrix3.determinant() < 0.0
    }

    /// Transforms a point.
    pub fn point(&self, point: [f32; 3]) -> [f32; 3] {
        self.0
            .transform_point3(DVec3::from(point.map(f64::from)))
            .as_vec3()
            .into()
    }

    /// Transforms a point without rounding to f32.
    pub(crate) fn point_f64(&self, point: [f32; 3]) -> [f64; 3] {
        self.0.transform_point3(DVec3::from(point.map(f64::from))).into()
    }

    /// Returns the smallest f32 box that contains the transformed points, so that bounding boxes lose nothing to
    /// rounding; empty if there are none.
    pub(crate) fn box_of(&self, points: &[[f32; 3]]) -> Aabb {
        let mut exact = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        for point in points {
            let there = self.0.transform_point3(DVec3::from(point.map(f64::from)));
            exact = [exact[0].min(there), exact[1].max(there)];
        }
        let below = |value: f64| {
            if f64::from(value as f32) > value {
                (value as f32).next_down()
            } else {
                value as f32
            }
        };
        Aabb {
            min: exact[0].to_array().map(below),
            max: exact[1].to_array().map(|value| -below(-value)),
        }
    }

    /// Transforms a direction; its length may change.
    pub fn direction(&self, direction: [f32; 3]) -> [f32; 3] {
        self.0
            .transform_vector3(DVec3::from(direction.map(f64::from)))
            .as_vec3()
            .into()
    }

    /// Returns `true` if all elements are finite.
    pub fn is_finite(&self) -> bool {
        self.0.is_finite()
    }
}

impl From<Transform> for DAffine3 {
    fn from(transform: Transform) -> DAffine3 {
        transform.0
    }
}

impl From<[[f64; 3]; 4]> for Transform {
    fn from(columns: [[f64; 3]; 4]) -> Transform {
        Transform::from_columns_f64(columns)
    }
}

impl From<Transform> for [[f64; 3]; 4] {
    fn from(transform: Transform) -> [[f64; 3]; 4] {
        transform.columns_f64()
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
