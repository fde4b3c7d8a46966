//! Axis-aligned boxes.

use glam::{DAffine3, DVec3, Vec3};

/// Maximum absolute value of a coordinate, in scene units: of what is built, placed, edited or looked from.
///
/// Methods compare products of up to four lengths, in f32 and f64. From 10¹³ units on, such products overflow or are
/// rounded away, and sets would be wrong without a sign, so anything farther out is refused where it comes in.
///
/// There is no lower bound, but scenes are tested only down to 5·10⁻⁵ units across: scale smaller ones up. Coordinates
/// have 24 bits: at 10⁶ units from the origin positions are multiples of 1/16 unit.
pub const MAX_COORDINATE: f32 = 1e12;

/// Whether a coordinate is a number within [`MAX_COORDINATE`].
pub(crate) fn is_in_range(coordinate: f32) -> bool {
    coordinate.abs() <= MAX_COORDINATE
}

/// An axis-aligned box, in the units and axes of the space it stands in.
///
/// Empty where `min` exceeds `max` on any axis; [`Aabb::EMPTY`] is the empty box that grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least corner: x, y, z.
    pub min: [f32; 3],
    /// The greatest corner: x, y, z.
    pub max: [f32; 3],
}

impl Aabb {
    /// The box of nothing: any point added to it becomes the whole box.
    pub const EMPTY: Aabb = Aabb {
        min: [f32::INFINITY; 3],
        max: [f32::NEG_INFINITY; 3],
    };

    /// The smallest box that holds all `points`; empty when there are none.
    pub fn of(points: impl IntoIterator<Item = [f32; 3]>) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        for point in points {
            bounds.add(point);
        }
        bounds
    }

    /// Grows the box until it holds `point`.
    #[inline]
    pub fn add(&mut self, point: [f32; 3]) {
        self.min = Vec3::from(self.min).min(Vec3::from(point)).into();
        self.max = Vec3::from(self.max).max(Vec3::from(point)).into();
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(&self, other: &Aabb) -> Aabb {
        Aabb {
            min: Vec3::from(self.min).min(Vec3::from(other.min)).into(),
            max: Vec3::from(self.max).max(Vec3::from(other.max)).into(),
        }
    }

    /// What both boxes share; empty where they do not meet.
    #[must_use]
    pub fn intersection(&self, other: &Aabb) -> Aabb {
        Aabb {
            min: Vec3::from(self.min).max(Vec3::from(other.min)).into(),
            max: Vec3::from(self.max).min(Vec3::from(other.max)).into(),
        }
    }

    /// A box around what a map makes of the box.
    pub(crate) fn placed(&self, map: &DAffine3) -> Aabb {
        let [min, max] = [self.min, self.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let [middle, half] = [0.5 * (min + max), 0.5 * (max - min)];
        let matrix = map.matrix3;
        let reach =
            matrix.x_axis.abs() * half.x + matrix.y_axis.abs() * half.y + matrix.z_axis.abs() * half.z;
        let at = map.transform_point3(middle);
        // What f64 rounds is less than a step of f32.
        Aabb {
            min: (at - reach).as_vec3().to_array().map(f32::next_down),
            max: (at + reach).as_vec3().to_array().map(f32::next_up),
        }
    }

    /// Whether every point of the box is within [`MAX_COORDINATE`].
    pub(crate) fn is_in_range(&self) -> bool {
        self.is_empty() || self.min.into_iter().chain(self.max).all(is_in_range)
    }

    /// Does the box hold no point at all?
    pub fn is_empty(&self) -> bool {
        (0..3).any(|axis| self.min[axis] > self.max[axis])
    }

    /// Do the boxes share a point? Boxes that only touch do.
    pub fn meets(&self, other: &Aabb) -> bool {
        (0..3).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }

    /// Does the box hold `point`? Points on the boundary are held.
    pub fn contains(&self, point: [f32; 3]) -> bool {
        (0..3).all(|axis| self.min[axis] <= point[axis] && point[axis] <= self.max[axis])
    }

    /// The middle of the box. Halved before adding, so that huge boxes do not overflow.
    pub fn center(&self) -> [f32; 3] {
        std::array::from_fn(|axis| 0.5 * self.min[axis] + 0.5 * self.max[axis])
    }

    /// Edge lengths along x, y, z; zero on every axis for the empty box.
    pub fn size(&self) -> [f32; 3] {
        if self.is_empty() {
            return [0.0; 3];
        }
        std::array::from_fn(|axis| self.max[axis] - self.min[axis])
    }

    /// Volume in cubic scene units, in f64 because f32 overflows on large scenes; zero for flat or empty boxes.
    pub fn volume(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let side = |axis: usize| f64::from(self.max[axis]) - f64::from(self.min[axis]);
        side(0) * side(1) * side(2)
    }

    /// Half the area of its sides, in f64 as the volume; zero for an empty box.
    pub(crate) fn half_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(self.max[axis]) - f64::from(self.min[axis]));
        x * y + y * z + z * x
    }

    /// The longest edge.
    pub fn longest_side(&self) -> f32 {
        self.size().into_iter().fold(0.0, f32::max)
    }

    /// The eight corners; bit 0 of the index chooses x, bit 1 y, bit 2 z.
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
