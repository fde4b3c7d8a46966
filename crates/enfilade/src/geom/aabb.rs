//! Axis-aligned bounding boxes (AABBs).

use glam::{DAffine3, DVec3, Vec3, Vec3A};

/// Maximum absolute value of a coordinate, in scene units, for built and placed geometry, edits and camera positions.
///
/// Methods compare products of up to four lengths, in f32 and f64. From 10¹³ units on, such products overflow or round
/// to nothing, and visible sets would be wrong without any error. Coordinates beyond this limit are therefore rejected
/// on input.
///
/// There is no lower limit, but scenes are tested only down to 5·10⁻⁵ units across; scale smaller ones up. A coordinate
/// has 24 bits of precision: 10⁶ units from the origin, positions are multiples of 1/16 unit.
pub const MAX_COORDINATE: f32 = 1e12;

/// Returns `true` if a coordinate is a number and within [`MAX_COORDINATE`].
pub(crate) fn is_in_range(coordinate: f32) -> bool {
    coordinate.abs() <= MAX_COORDINATE
}

/// Axis-aligned bounding box, in the units and axes of the space it belongs to.
///
/// Empty if `min` exceeds `max` on any axis. Start from [`Aabb::EMPTY`] to accumulate points.
#[doc(alias = "bounding box")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Minimum corner: x, y, z.
    pub min: [f32; 3],
    /// Maximum corner: x, y, z.
    pub max: [f32; 3],
}

impl Aabb {
    /// Empty box, the identity of [`Aabb::union`]: adding a point to it gives a box of just that point.
    pub const EMPTY: Aabb = Aabb {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
    };

    /// Returns the smallest box that contains all `points`; empty if there are none.
    #[inline]
    pub fn of(points: impl IntoIterator<Item = [f32; 3]>) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for point in points {
            bounds.add(point);
        }
        bounds
    }

    /// Grows the box to contain `point`.
    #[inline]
    pub fn add(&mut self, point: [f32; 3]) {
        self.min = Vec3::from(self.min).min(Vec3::from(point)).into();
        self.max = Vec3::from(self.max).max(Vec3::from(point)).into();
    }

    /// Returns the smallest box that contains both boxes.
    #[inline]
    #[must_use]
    pub fn union(&self, other: &Aabb) -> Aabb {
        Aabb {
            min: Vec3::from(self.min).min(Vec3::from(other.min)).into(),
            max: Vec3::from(self.max).max(Vec3::from(other.max)).into(),
        }
    }

    /// Returns the overlap of both boxes; empty if they do not meet.
    #[must_use]
    pub fn intersection(&self, other: &Aabb) -> Aabb {
        Aabb {
            min: Vec3::from(self.min).max(Vec3::from(other.min)).into(),
            max: Vec3::from(self.max).min(Vec3::from(other.max)).into(),
        }
    }

    /// Returns a box that contains this box transformed by `map`, rounded outward to f32.
    pub fn placed(&self, map: &DAffine3) -> Aabb {
        let [min, max] = [self.min, self.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let [middle, half] = [0.5 * (min + max), 0.5 * (max - min)];
        let matrix = map.matrix3;
        let reach =
            matrix.x_axis.abs() * half.x + matrix.y_axis.abs() * half.y + matrix.z_axis.abs() * half.z;
        let at = map.transform_point3(middle);
        // The rounding error of f64 is smaller than one f32 step.
        Aabb {
            min: (at - reach).as_vec3().to_array().map(f32::next_down),
            max: (at + reach).as_vec3().to_array().map(f32::next_up),
        }
    }

    /// Returns `true` if the box is empty or every corner is within [`MAX_COORDINATE`].
    pub(crate) fn is_in_range(&self) -> bool {
        self.is_empty() || self.min.into_iter().chain(self.max).all(is_in_range)
    }

    /// Returns `true` if the box contains no point.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.min[axis] > self.max[axis])
    }

    /// Returns `true` if the boxes share a point. Boxes that only touch share one.
    #[inline]
    pub fn meets(&self, other: &Aabb) -> bool {
        let begins = Vec3A::from(self.min).cmple(Vec3A::from(other.max));
        let ends = Vec3A::from(other.min).cmple(Vec3A::from(self.max));
        (begins & ends).all()
    }

    /// Returns `true` if the box contains `point`, boundary included.
    #[inline]
    pub fn contains(&self, point: [f32; 3]) -> bool {
        let point = Vec3A::from(point);
        (Vec3A::from(self.min).cmple(point) & point.cmple(Vec3A::from(self.max))).all()
    }

    /// Returns the centre. The corners are halved before they are added, so that huge boxes do not overflow.
    pub fn center(&self) -> [f32; 3] {
        std::array::from_fn(|axis| 0.5 * self.min[axis] + 0.5 * self.max[axis])
    }

    /// Returns the edge lengths along x, y, z; zero on every axis for an empty box.
    pub fn size(&self) -> [f32; 3] {
        if self.is_empty() {
            return [0.0; 3];
        }
        std::array::from_fn(|axis| self.max[axis] - self.min[axis])
    }

    /// Returns the volume in cubic scene units, in f64 because f32 overflows on large scenes; zero for flat or empty
    /// boxes.
    pub fn volume(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let side = |axis: usize| f64::from(self.max[axis]) - f64::from(self.min[axis]);
        side(0) * side(1) * side(2)
    }

    /// Returns half the surface area, in f64 like the volume; zero for an empty box.
    pub(crate) fn half_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]));
        x * y + y * z + z * x
    }

    /// Returns the length of the longest edge.
    pub fn longest_side(&self) -> f32 {
        self.size().into_iter().fold(0.0, f32::max)
    }

    /// Returns the eight corners. Bits 0, 1 and 2 of the index select the maximum along x, y and z.
    pub fn corners(&self) -> [[f32; 3]; 8] {
        std::array::from_fn(|corner| {
            std::array::from_fn(|axis| {
                if corner >> axis & 1 == 0 {
                    self.min[axis]
                } else {
                    self.max[axis]
                }
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_box_grows_from_its_first_point() {
        let bounds = Aabb::of([[1.0, 2.0, 3.0], [-1.0, 5.0, 3.0]]);
        assert_eq!(
            bounds,
            Aabb {
                min: [-1.0, 2.0, 3.0],
                max: [1.0, 5.0, 3.0]
            }
        );
        assert!(Aabb::EMPTY.is_empty() && !bounds.is_empty());
    }

    #[test]
    fn boxes_that_only_touch_meet() {
        let left = Aabb {
            min: [0.0; 3],
            max: [1.0; 3],
        };
        let right = Aabb {
            min: [1.0, 0.0, 0.0],
            max: [2.0, 1.0, 1.0],
        };
        assert!(left.meets(&right));
        assert!(!left.intersection(&right).is_empty());
        assert_eq!(left.intersection(&right).volume(), 0.0);
    }
}
