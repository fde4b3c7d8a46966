//! Named cameras.

use enfilade::Camera;

/// Returns a camera with y up and a vertical field of view of 60 degrees.
pub(crate) fn camera(name: &str, eye: [f32; 3], toward: [f32; 3]) -> Camera {
    camera_with_fov(name, eye, toward, 60.0)
}

/// Returns a camera with y up and a vertical field of view of `degrees`.
pub(crate) fn camera_with_fov(name: &str, eye: [f32; 3], toward: [f32; 3], degrees: f32) -> Camera {
    Camera {
        name: name.to_owned(),
        fov_y: degrees.to_radians(),
        ..Camera::new(eye, toward)
    }
}
