//! One camera: its view (position, direction, projection, viewport), its viewer, and the passages, apertures and visible
//! set of a look.

pub(crate) mod aperture;
pub(crate) mod canvas;
pub(crate) mod collector;
pub(crate) mod draw_runs;
mod entrance;
pub(crate) mod memory;
pub(crate) mod opening_view;
pub(crate) mod options;
pub(crate) mod passage;
pub(crate) mod region;
pub(crate) mod viewer;
pub(crate) mod visible;

use crate::geom::{MAX_COORDINATE, is_in_range};
use crate::ids::SectorId;
use glam::{DAffine3, DMat3, DVec3};
use thiserror::Error;

/// A perspective camera: position, direction, vertical field of view, near plane and viewport size.
///
/// Space is right-handed; there is no far plane. [`View::new`] sets defaults; change the fields directly.
#[doc(alias = "camera")]
#[doc(alias = "frustum")]
#[doc(alias = "viewport")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// The sector that contains the eye. Default `None`: [`Scene::locate`](crate::Scene::locate) finds it by position,
    /// which is ambiguous where sectors overlap.
    pub sector: Option<SectorId>,
    /// Eye position, in scene units, in the space of its sector.
    pub eye: [f32; 3],
    /// Target point: it is projected to the centre of the screen. Must differ from `eye`.
    pub toward: [f32; 3],
    /// Up vector, of any length. Default +y. If it is zero or parallel to the view direction, +z or +x is used instead.
    pub up: [f32; 3],
    /// Vertical field of view, in radians, above 0 and below π. Default 60 degrees.
    pub fov_y: f32,
    /// Viewport width and height, 1 to [`View::MAX_PIXELS`] pixels each. Sample (x, y) is at (x + ½, y + ½) plus
    /// `sample` and [`View::GENERIC_OFFSET`], with y down.
    pub size: [u32; 2],
    /// Sample position relative to the pixel centre, in pixels, −½ to ½ each. Default (0, 0). [`View::FOUR_SAMPLES`]
    /// has the positions of usual 4x multisampling.
    pub sample: [f32; 2],
    /// Near-plane distance, in scene units, above 0. Geometry between the eye and this plane is neither visible nor an
    /// occluder. Set it to your renderer's near plane: with a smaller value, geometry that your renderer clips away can
    /// still hide other geometry.
    #[doc(alias = "near plane")]
    pub near: f32,
}

/// Why a view is invalid; returned by [`View::check`].
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A coordinate is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// A coordinate is beyond ±[`MAX_COORDINATE`].
    #[error(
        "{0} is farther out than {MAX_COORDINATE:e} units; scale the scene down or move it to the origin"
    )]
    TooFar(&'static str),
    /// `eye` and `toward` are equal.
    #[error("the eye and its target point are the same; they must differ")]
    NoDirection,
    /// Width or height is 0 or above [`View::MAX_PIXELS`].
    #[error("viewport of {0}x{1} pixels; width and height must be 1 to {max}", max = View::MAX_PIXELS)]
    Size(u32, u32),
    /// `fov_y` is not above 0 and below π; the value is in degrees.
    #[error("vertical field of view of {0} degrees; it must be above 0 and below 180")]
    FieldOfView(f32),
    /// `sample` is outside its pixel.
    #[error("sample at ({0}, {1}) from the pixel centre; both must be from -0.5 to 0.5")]
    Sample(f32, f32),
    /// `near` is zero, negative or not finite.
    #[error("near-plane distance of {0}; it must be above 0 and finite")]
    Near(f32),
}

impl View {
    /// Maximum viewport width and height, in pixels.
    pub const MAX_PIXELS: u32 = 16_384;

    /// Sample positions of 4x multisampling, for [`View::sample`]: in pixels from the pixel centre, x right, y down.
    ///
    /// Source: Microsoft, Direct3D 11.3 Functional Specification, 19.2.4.1, standard sample patterns.
    pub const FOUR_SAMPLES: [[f32; 2]; 4] =
        [[-0.125, -0.375], [0.375, -0.125], [-0.375, 0.125], [0.125, 0.375]];

    /// Offset added to all sample positions, in pixels.
    ///
    /// Scenes are often modelled on a grid and viewed from grid points. Edges and planes through the eye would then
    /// pass exactly through samples, where rounding decides which face covers a sample, and two neighbours may both
    /// leave it uncovered. This offset, less than the 1/256 pixel to which GPUs round vertices, puts samples in general
    /// position.
    ///
    /// Source: Edelsbrunner, Mücke, Simulation of Simplicity, ACM Transactions on Graphics 9, 1990, for the idea.
    pub const GENERIC_OFFSET: [f64; 2] = [0.001_131, 0.000_717];

    /// Creates a view with a vertical field of view of 60 degrees, up +y, and `near` = 10⁻³ of the distance from `eye`
    /// to `toward`, clamped to 10⁻⁶ to 0.01.
    ///
    /// `size` is the viewport's width and height in pixels.
    pub fn new(eye: [f32; 3], toward: [f32; 3], size: [u32; 2]) -> View {
        let distance = DVec3::from(eye.map(f64::from)).distance(DVec3::from(toward.map(f64::from))) as f32;
        View {
            sector: None,
            eye,
            toward,
            up: [0.0, 1.0, 0.0],
            fov_y: 60.0_f32.to_radians(),
            size,
            sample: [0.0; 2],
            near: (1e-3 * distance).clamp(1e-6, 0.01),
        }
    }

    /// Checks that all fields are in range.
    ///
    /// # Errors
    /// Returns the [`ViewError`] of the first invalid field.
    pub fn check(&self) -> Result<(), ViewError> {
        let named = [
            ("the eye", self.eye),
            ("the target point", self.toward),
            ("the up vector", self.up),
        ];
        if let Some((name, _)) = named
            .iter()
            .find(|(_, point)| point.iter().any(|value| !value.is_finite()))
        {
            return Err(ViewError::NotFinite(name));
        }
        if let Some((name, _)) = named[..2]
            .iter()
            .find(|(_, point)| !point.iter().all(|&value| is_in_range(value)))
        {
            return Err(ViewError::TooFar(name));
        }
        if self.eye == self.toward {
            return Err(ViewError::NoDirection);
        }
        if self.size.iter().any(|&side| side == 0 || side > View::MAX_PIXELS) {
            return Err(ViewError::Size(self.size[0], self.size[1]));
        }
        if !(self.fov_y > 0.0 && self.fov_y < std::f32::consts::PI) {
            return Err(ViewError::FieldOfView(self.fov_y.to_degrees()));
        }
        let [dx, dy] = self.sample;
        if !(dx.abs() <= 0.5 && dy.abs() <= 0.5) {
            return Err(ViewError::Sample(dx, dy));
        }
        if !(self.near > 0.0 && self.near.is_finite()) {
            return Err(ViewError::Near(self.near));
        }
        Ok(())
    }

    /// Returns the view matrix. Eye space: x right, y up, z back, origin at the eye.
    pub(crate) fn eye_from_sector(&self) -> DAffine3 {
        let [eye, toward, up] = [self.eye, self.toward, self.up].map(|v| DVec3::from(v.map(f64::from)));
        let back = (eye - toward).normalize_or(DVec3::Z);
        let upright = |up: DVec3| {
            let right = up.normalize_or_zero().cross(back);
            (right.length_squared() > 1e-16).then_some(right)
        };
        let right = upright(up)
            .or_else(|| upright(DVec3::Z))
            .or_else(|| upright(DVec3::X))
            .unwrap_or(DVec3::X)
            .normalize();
        let rotation = DMat3::from_cols(right, back.cross(right), back).transpose();
        DAffine3 {
            matrix3: rotation,
            translation: rotation * -eye,
        }
    }

    /// Returns the projection from eye space to (X, Y, W): the pixel is (X / W, Y / W), y down, and W is the distance
    /// along the view direction. Shifted so that samples are at pixel centres, wherever the view puts them.
    pub(crate) fn screen_from_eye(&self) -> DMat3 {
        let [width, height] = self.size.map(f64::from);
        let [dx, dy] = [0, 1].map(|axis| f64::from(self.sample[axis]) + View::GENERIC_OFFSET[axis]);
        // Rounded to f32, so that machines whose tangents differ in the last bit of f64 make the same decisions.
        let focal = 0.5 * height / f64::from((0.5 * f64::from(self.fov_y)).tan() as f32);
        DMat3::from_cols(
            DVec3::new(focal, 0.0, 0.0),
            DVec3::new(0.0, -focal, 0.0),
            DVec3::new(dx - 0.5 * width, dy - 0.5 * height, -1.0),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_looked_at_is_in_the_middle_and_up_is_up() {
        let view = View::new([1.0, 2.0, 3.0], [4.0, 2.0, -7.0], [640, 480]);
        let screen = |point: [f64; 3]| {
            let at = view.screen_from_eye() * view.eye_from_sector().transform_point3(DVec3::from(point));
            (at / at.z, at.z)
        };
        let (middle, distance) = screen([4.0, 2.0, -7.0]);
        let [dx, dy] = View::GENERIC_OFFSET;
        assert!((middle.x + dx - 320.0).abs() < 1e-9 && (middle.y + dy - 240.0).abs() < 1e-9);
        assert!((distance - 109.0_f64.sqrt()).abs() < 1e-9);
        assert!(screen([4.0, 3.0, -7.0]).0.y < 240.0);
        // A sample to the right and below shows what the pixel centre showed before: the picture moves left and up.
        let mut moved = view;
        moved.sample = [0.25, 0.5];
        let off = moved.screen_from_eye() * DVec3::NEG_Z - view.screen_from_eye() * DVec3::NEG_Z;
        assert_eq!(off, DVec3::new(-0.25, -0.5, 0.0));
    }

    #[test]
    fn a_view_straight_down_is_sound() {
        let view = View::new([0.0, 5.0, 0.0], [0.0, 0.0, 0.0], [8, 8]);
        assert!(view.eye_from_sector().is_finite());
        assert_eq!(view.check(), Ok(()));
    }

    #[test]
    fn each_broken_rule_has_its_own_error() {
        let sound = View::new([0.0; 3], [0.0, 0.0, -1.0], [8, 8]);
        let error = |change: fn(&mut View)| {
            let mut view = sound;
            change(&mut view);
            view.check().expect_err("the rule is broken")
        };
        assert_eq!(error(|v| v.toward = v.eye), ViewError::NoDirection);
        assert_eq!(error(|v| v.eye[2] = -1.1e12), ViewError::TooFar("the eye"));
        assert_eq!(error(|v| v.size = [0, 0]), ViewError::Size(0, 0));
        assert_eq!(
            error(|v| v.size = [100_000, 100_000]),
            ViewError::Size(100_000, 100_000)
        );
        assert!(matches!(error(|v| v.fov_y = 4.0), ViewError::FieldOfView(_)));
        assert_eq!(error(|v| v.sample[1] = 0.6), ViewError::Sample(0.0, 0.6));
        assert!(matches!(error(|v| v.sample[0] = f32::NAN), ViewError::Sample(..)));
        assert!(matches!(error(|v| v.near = 0.0), ViewError::Near(_)));
        assert!(matches!(
            error(|v| v.eye[1] = f32::NAN),
            ViewError::NotFinite("the eye")
        ));
    }
}
