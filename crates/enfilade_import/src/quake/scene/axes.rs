//! From the axes of maps to ours: there z is up, here y. A quarter turn about x, so that nothing is rounded.

use enfilade::Transform;

/// A point or a direction of a map as one of the scene.
pub(super) fn turned([x, y, z]: [f32; 3]) -> [f32; 3] {
    // Not −y, which would make −0 of 0.
    [x, z, 0.0 - y]
}

/// The same, exact in f64.
pub(super) fn turned_exactly([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, z, 0.0 - y]
}

/// Where a model of a map is put.
pub(super) fn placed(origin: [f32; 3]) -> Transform {
    Transform::translation(turned(origin))
}

/// The direction of a yaw, counter-clockwise from x, and a pitch upwards, both in degrees; of the scene.
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
