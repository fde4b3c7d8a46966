//! Converts from the axes of maps (z up) to Enfilade's (y up): a quarter turn about x, without rounding.

use enfilade::Transform;

/// Converts a point or a direction.
pub(super) fn turned([x, y, z]: [f32; 3]) -> [f32; 3] {
    // Not `-y`, which would turn 0 into −0.
    [x, z, 0.0 - y]
}

/// The same in f64.
pub(super) fn turned_exactly([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, z, 0.0 - y]
}

/// Returns the transform of a model at `origin`.
pub(super) fn placed(origin: [f32; 3]) -> Transform {
    Transform::translation(turned(origin))
}

/// Returns the direction of a yaw, counter-clockwise from x, and an upward pitch, both in degrees, in scene space.
pub(super) fn direction(yaw: f32, pitch: f32) -> [f32; 3] {
    let [yaw, pitch] = [yaw, pitch].map(|angle| f64::from(angle).to_radians());
    let level = pitch.cos();
    turned([level * yaw.cos(), level * yaw.sin(), pitch.sin()].map(|part| part as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_stays_up_and_left_stays_left() {
        assert_eq!(turned([1.0, 0.0, 3.0]), [1.0, 3.0, 0.0]);
        assert!(turned([0.0; 3])[2].is_sign_positive());
        let [ahead, left, above] = [direction(0.0, 0.0), direction(90.0, 0.0), direction(0.0, 90.0)];
        assert!(ahead[0] > 0.999 && above[1] > 0.999);
        assert!(left[2] < -0.999, "who looks along x has −z on the left");
    }
}
