//! Axis-aligned boxes as meshes: for tests, examples and proxies.

use super::{Attributes, Indices, Mesh, MeshError, Part, Vertices};
use crate::ids::MaterialId;

impl Mesh {
    /// Returns an axis-aligned box from `min` to `max`: six quads, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// [`MeshError::EmptyCuboid`] unless `min` is less than `max` on every axis; [`MeshError::NotFinite`] and
    /// [`MeshError::TooFar`] as [`Mesh::new`].
    #[doc(alias = "cube")]
    #[doc(alias = "box")]
    pub fn cuboid(min: [f32; 3], max: [f32; 3], material: MaterialId) -> Result<Mesh, MeshError> {
        if (0..3).any(|axis| max[axis] <= min[axis]) {
            return Err(MeshError::EmptyCuboid(min, max));
        }
        // Bit 0 of a corner's index selects max x, bit 1 max y, bit 2 max z.
        let positions: [[f32; 3]; 8] = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| {
                if corner >> axis & 1 == 1 {
                    max[axis]
                } else {
                    min[axis]
                }
            })
        });
        let corners = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        Mesh::new(&[Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(corners.as_flattened()),
            sides: Some(&[4; 6]),
            material,
            attributes: Attributes::default(),
        }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_cuboid_has_six_sides_that_face_outwards() {
        let cuboid = Mesh::cuboid([-1.0, 0.0, 2.0], [3.0, 0.5, 4.0], MaterialId(0)).expect("a box");
        assert_eq!((cuboid.face_count(), cuboid.triangle_count()), (6, 12));
        let center = Vec3::new(1.0, 0.25, 3.0);
        for face in 0..6 {
            let corners: Vec<Vec3> = (cuboid.face(face).iter())
                .map(|&corner| Vec3::from(cuboid.positions()[corner as usize]))
                .collect();
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            assert!(
                normal.dot(corners[0] - center) > 0.0,
                "face {face} points inwards"
            );
        }
    }

    #[test]
    fn a_cuboid_without_volume_or_with_nan_is_refused() {
        for (min, max) in [
            ([0.0; 3], [1.0, 0.0, 1.0]),
            ([0.0; 3], [1.0, -1.0, 1.0]),
            ([f32::NAN; 3], [1.0; 3]),
        ] {
            assert!(Mesh::cuboid(min, max, MaterialId(0)).is_err(), "{min:?} {max:?}");
        }
    }
}
