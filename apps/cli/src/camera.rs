//! A camera of a scene.

use crate::args::CameraArgs;
use enfilade::{SectorId, View};

/// A camera of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) name: String,
    pub(crate) eye: [f32; 3],
    pub(crate) toward: [f32; 3],
    pub(crate) up: [f32; 3],
    /// Vertical field of view, in radians.
    pub(crate) fov_y: f32,
    /// Near-plane distance; `None` if the scene does not give one.
    pub(crate) near: Option<f32>,
    /// Sector of the eye; `None` to locate it by its position.
    pub(crate) sector: Option<SectorId>,
    /// Height of the view of an orthographic camera, in scene units; `None` for a perspective one.
    pub(crate) height: Option<f32>,
}

impl From<enfilade_import::Camera> for Camera {
    fn from(camera: enfilade_import::Camera) -> Camera {
        let enfilade_import::Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            near,
            sector,
            height,
        } = camera;
        Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            near: Some(near),
            sector,
            height,
        }
    }
}

impl From<enfilade_scenes::Camera> for Camera {
    fn from(camera: enfilade_scenes::Camera) -> Camera {
        let enfilade_scenes::Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            ..
        } = camera;
        Camera {
            name,
            eye,
            toward,
            up,
            fov_y,
            near: None,
            sector: None,
            height: None,
        }
    }
}

impl Camera {
    /// Returns the view of this camera. `--fov` and `--up` take precedence over its own values.
    pub(crate) fn view(&self, args: &CameraArgs) -> View {
        let mut view = View::new(self.eye, self.toward, args.size);
        view.up = args.up.unwrap_or(self.up);
        view.fov_y = args.fov.map_or(self.fov_y, f32::to_radians);
        view.near = self.near.unwrap_or(view.near);
        view.sector = self.sector;
        view
    }
}
