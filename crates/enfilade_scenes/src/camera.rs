//! Places to look from.

use enfilade::View;

/// A place to look from, with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// How people call it; unique in its scene.
    pub name: String,
    /// The eye's place.
    pub eye: [f32; 3],
    /// A point in the middle of the picture.
    pub toward: [f32; 3],
    /// A direction that is seen upright.
    pub up: [f32; 3],
    /// Vertical angle of the lens, in radians.
    pub fov_y: f32,
}

impl Camera {
    /// A camera with y up and a lens of 60 degrees.
    pub fn new(name: &str, eye: [f32; 3], toward: [f32; 3]) -> Camera {
        Camera {
            name: name.to_owned(),
            eye,
            toward,
            up: [0.0, 1.0, 0.0],
            fov_y: 60.0_f32.to_radians(),
        }
    }

    /// The same camera with a lens of `degrees`, measured upright.
    #[must_use]
    pub fn lens(self, degrees: f32) -> Camera {
        Camera {
            fov_y: degrees.to_radians(),
            ..self
        }
    }

    /// What it sees on a screen of `size` pixels.
    pub fn view(&self, size: [u32; 2]) -> View {
        let mut view = View::new(self.eye, self.toward, size);
        view.up = self.up;
        view.fov_y = self.fov_y;
        view
    }
}
