//! Named cameras.

use enfilade::View;

/// A camera with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name of the camera, unique in its scene.
    pub name: String,
    /// Camera position.
    pub eye: [f32; 3],
    /// A point at the centre of the picture.
    pub toward: [f32; 3],
    /// Up vector.
    pub up: [f32; 3],
    /// Vertical field of view, in radians.
    pub fov_y: f32,
}

impl Camera {
    /// Creates a camera with y up and a vertical field of view of 60 degrees.
    pub fn new(name: &str, eye: [f32; 3], toward: [f32; 3]) -> Camera {
        Camera {
            name: name.to_owned(),
            eye,
            toward,
            up: [0.0, 1.0, 0.0],
            fov_y: 60.0_f32.to_radians(),
        }
    }

    /// Returns the same camera with a vertical field of view of `degrees`.
    #[must_use]
    pub fn lens(self, degrees: f32) -> Camera {
        Camera {
            fov_y: degrees.to_radians(),
            ..self
        }
    }

    /// Returns the view of this camera with a viewport of `size` pixels.
    pub fn view(&self, size: [u32; 2]) -> View {
        let mut view = View::new(self.eye, self.toward, size);
        view.up = self.up;
        view.fov_y = self.fov_y;
        view
    }
}
