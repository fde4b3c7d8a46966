//! Frames: position and orientation of a node, without scale.

use enfilade::Transform;
use glam::{DAffine3, DMat3, DVec3};

/// A position and three orthonormal, right-handed axes.
///
/// The scale of a node is ignored: for a portal, it is only the size of its rectangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame(DAffine3);

impl Frame {
    /// Returns the frame of a node; `None` if its axes do not define an orientation. If they are not orthogonal, z
    /// takes precedence, because it is the direction of travel, then y. For a mirrored node, x is flipped.
    pub(crate) fn of(world_from_node: &Transform) -> Option<Frame> {
        let [x, y, z, place] = world_from_node
            .columns()
            .map(|column| DVec3::from(column.map(f64::from)));
        // If z has zero length, the other two axes still define it.
        let z = z.try_normalize().or_else(|| x.cross(y).try_normalize())?;
        let y = (y - z * y.dot(z)).try_normalize();
        let y = y.or_else(|| z.cross(x).try_normalize())?;
        Some(Frame(DAffine3 {
            matrix3: DMat3::from_cols(y.cross(z), y, z),
            translation: place,
        }))
    }

    pub(crate) fn place(&self) -> DVec3 {
        self.0.translation
    }

    /// Returns +z, which points against the direction of travel.
    pub(crate) fn back(&self) -> DVec3 {
        self.0.matrix3.z_axis
    }

    /// Returns the transform from the space in front of this frame to the space behind `exit`: rigid, but enlarged by
    /// `scale`.
    pub(crate) fn there_from_here(&self, exit: &Frame, scale: f64) -> Transform {
        let there_from_here = exit.0 * DAffine3::from_scale(DVec3::splat(scale)) * self.0.inverse();
        Transform::from_columns(
            there_from_here
                .to_cols_array_2d()
                .map(|column| column.map(|value| value as f32)),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_changes_no_frame_and_no_axis_no_frame_at_all() {
        let turned = Transform::rotation([0.0, 1.0, 0.0], 1.0);
        let here = Frame::of(&(turned * Transform::scaling([3.0, 0.5, 7.0]))).expect("a frame");
        let there = Frame::of(&turned).expect("a frame");
        let point = here.there_from_here(&there, 1.0).point([1.0, 2.0, 3.0]);
        assert!((DVec3::from(point.map(f64::from)) - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
        let point = here.there_from_here(&there, 8.0).point([1.0, 2.0, 3.0]);
        assert!((DVec3::from(point.map(f64::from)) - DVec3::new(8.0, 16.0, 24.0)).length() < 1e-5);
        assert!(Frame::of(&Transform::scaling([1.0, 1.0, 0.0])).is_some());
        assert!(Frame::of(&Transform::scaling([1.0, 0.0, 0.0])).is_none());
    }
}
