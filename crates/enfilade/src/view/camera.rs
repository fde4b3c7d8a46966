//! A camera as people place it.

use super::{View, ViewError, Viewport, check_position, check_viewport};
use crate::ids::SectorId;
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

/// A camera as people place it: a position, a target point and a vertical field of view. [`Camera::view`] makes it a
/// [`View`].
///
/// Space is right-handed. Engines that have matrices need none: see [`View::from_matrices`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Camera {
    /// Name for display and lookup; may be empty.
    pub name: String,
    /// The sector that contains the eye. `None`: [`Scene::locate`](crate::Scene::locate) finds it by position.
    pub sector: Option<SectorId>,
    /// Eye position, in scene units, in the space of its sector.
    pub eye: [f64; 3],
    /// Target point: it is projected to the centre of the viewport. Must differ from `eye`.
    pub toward: [f64; 3],
    /// Up vector, of any length. If it is zero or parallel to the view direction, +z or +x is used instead.
    pub up: [f64; 3],
    /// Vertical field of view, in radians, above 0 and below π.
    pub fov_y: f32,
    /// Near-plane distance, in scene units, above 0. `None`: 10⁻³ of the distance from `eye` to `toward`, clamped to 10⁻⁶
    /// to 0.01. See [`View::z_near`].
    pub z_near: Option<f32>,
}

impl Camera {
    /// Creates a camera without a name, with a vertical field of view of 60 degrees and up +y.
    pub fn new<T: Into<f64>>(eye: [T; 3], toward: [T; 3]) -> Camera {
        Camera {
            name: String::new(),
            sector: None,
            eye: eye.map(Into::into),
            toward: toward.map(Into::into),
            up: [0.0, 1.0, 0.0],
            fov_y: 60.0_f32.to_radians(),
            z_near: None,
        }
    }

    /// Returns the view of this camera in a viewport: a size in pixels, or a [`Viewport`].
    ///
    /// # Errors
    /// Returns the [`ViewError`] of the first rule that is broken.
    pub fn view(&self, viewport: impl Into<Viewport>) -> Result<View, ViewError> {
        let viewport = viewport.into();
        check_position("the eye", self.eye)?;
        check_position("the target point", self.toward)?;
        if self.up.iter().any(|value| !value.is_finite()) {
            return Err(ViewError::NotFinite("the up vector"));
        }
        let [eye, toward] = [self.eye, self.toward].map(DVec3::from);
        let back = eye - toward;
        if back == DVec3::ZERO {
            return Err(ViewError::NoDirection);
        }
        if !(self.fov_y > 0.0 && self.fov_y < std::f32::consts::PI) {
            return Err(ViewError::FieldOfView(self.fov_y.to_degrees()));
        }
        let z_near = self
            .z_near
            .unwrap_or_else(|| (1e-3 * back.length() as f32).clamp(1e-6, 0.01));
        check_viewport(viewport, z_near)?;
        // Rounded to f32, so that machines whose tangents differ in the last bit of f64 make the same decisions.
        let tangent = f64::from((0.5 * f64::from(self.fov_y)).tan() as f32);
        let [width, height] = viewport.size.map(f64::from);
        let focal = 0.5 * height / tangent;
        let clip_from_eye = DMat4::from_cols(
            DVec4::new(height / (width * tangent), 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / tangent, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, f64::from(z_near), 0.0),
        );
        Ok(View {
            sector: self.sector,
            eye,
            toward,
            up: DVec3::from(self.up),
            fov_y: self.fov_y,
            z_near,
            viewport,
            sample: [0.0; 2],
            eye_from_sector: self.eye_from_sector(),
            clip_from_eye,
            viewport_from_eye: DAffine3::from_mat3(DMat3::from_cols(
                DVec3::new(focal, 0.0, 0.0),
                DVec3::new(0.0, -focal, 0.0),
                DVec3::new(-0.5 * width, -0.5 * height, -1.0),
            )),
            is_parallel: false,
            far: f64::INFINITY,
            oblique: None,
            is_light: false,
        })
    }

    /// Returns the view matrix. Eye space: x right, y up, z back, origin at the eye.
    fn eye_from_sector(&self) -> DAffine3 {
        let [eye, toward, up] = [self.eye, self.toward, self.up].map(DVec3::from);
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
}
