//! One camera: its view (position, direction, projection, viewport), its viewer, and the passages, apertures and visible
//! set of a look.

pub(crate) mod aperture;
mod camera;
pub(crate) mod canvas;
pub(crate) mod collector;
pub(crate) mod draw_runs;
mod entrance;
mod error;
mod matrices;
pub(crate) mod memory;
pub(crate) mod opening_view;
pub(crate) mod options;
pub(crate) mod passage;
pub(crate) mod region;
pub(crate) mod screen_map;
#[cfg(feature = "steps")]
pub(crate) mod step_log;
#[cfg(test)]
mod tests;
pub(crate) mod viewer;
pub(crate) mod viewers;
pub(crate) mod visible;
pub(crate) mod visible_keys;

pub use camera::Camera;
pub use error::ViewError;
pub use matrices::ClipDepth;

use crate::geom::{MAX_COORDINATE, Transform};
use crate::ids::SectorId;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};

/// A camera with its viewport, perspective or parallel (orthographic): what a look takes.
///
/// Five constructors: [`View::new`] from a position and a target, [`Camera::view`] with
/// more parameters, [`View::from_pose`] from a position, an orientation and the four tangents of an off-centre frustum,
/// [`View::parallel`] for suns, maps and plans, [`View::from_matrices`] from the matrices of an engine. Each refuses an
/// invalid view with the rule that it breaks, so every `View` is valid.
///
/// There is no far plane: nothing is too far away to be visible.
///
/// # Parallel views
/// All rays have the view direction and start in the near plane; the eye is the point of that plane in the middle of the
/// viewport, so [`View::z_near`] is 0. Where that plane leaves the box of the eye's sector, rays start in the sector that
/// [`Scene::locate`](crate::Scene::locate) finds, so a plan may cut through many rooms; where there is none, in the eye's.
/// Reversed depth is 1 in the near plane and falls linearly with distance, to 0 at a distance beyond all geometry of the
/// sector that is looked at.
#[doc(alias = "camera")]
#[doc(alias = "frustum")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The sector that contains the eye. `None`: [`Scene::locate`](crate::Scene::locate) finds it by position, which is
    /// ambiguous where sectors overlap.
    pub sector: Option<SectorId>,
    eye: DVec3,
    toward: DVec3,
    up: DVec3,
    fov_y: f32,
    z_near: f32,
    viewport: Viewport,
    sample: [f32; 2],
    eye_from_sector: DAffine3,
    clip_from_eye: DMat4,
    /// From eye space to (X, Y, W): the position in the viewport is (X / W, Y / W), in pixels, y down, and W is the
    /// distance along the view direction. If parallel, to (x, y, distance from the near plane).
    viewport_from_eye: DAffine3,
    is_parallel: bool,
    /// Distance from the near plane to the far one, if parallel.
    far: f64,
    /// The near plane, if it is oblique: points (x, y, z) of eye space with ax + by + cz + d ≥ 0 are behind it.
    oblique: Option<[f64; 4]>,
    /// Whether this is the view of a light: all rays start in its sector, and items take part whatever their limits of distance
    /// and size, which are meant for cameras.
    is_light: bool,
}

/// A rectangle of pixels in a render target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Viewport {
    /// Left and top edge, in pixels of the render target. Only [`Passage::scissor`](crate::Passage::scissor) uses it: all
    /// other positions are relative to the viewport.
    pub origin: [u32; 2],
    /// Width and height, 1 to [`View::MAX_PIXELS`] pixels each.
    pub size: [u32; 2],
}

impl From<[u32; 2]> for Viewport {
    /// Returns the viewport of a whole render target of `size` pixels.
    fn from(size: [u32; 2]) -> Viewport {
        Viewport { origin: [0, 0], size }
    }
}

impl View {
    /// Maximum viewport width and height, in pixels.
    pub const MAX_PIXELS: u32 = 16_384;

    /// Sample positions of 4x multisampling, for [`View::at_sample`]: in pixels from the pixel centre, x right, y down.
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

    /// Creates a view with a vertical field of view of 60 degrees, up +y, and a near plane as [`Camera::z_near`] says.
    ///
    /// `eye` and `toward` (the target point, in the centre of the picture) are in the space of the eye's sector, as `f32` or
    /// `f64`; `viewport` is a size in pixels or a [`Viewport`].
    ///
    /// # Errors
    /// Returns the [`ViewError`] of the first rule that is broken.
    pub fn new<T: Into<f64>>(
        eye: [T; 3],
        toward: [T; 3],
        viewport: impl Into<Viewport>,
    ) -> Result<View, ViewError> {
        Camera::new(eye, toward).view(viewport)
    }

    /// Creates the view of a tracked eye: a position, an orientation and the tangents of an off-centre frustum, as VR
    /// runtimes report them.
    ///
    /// * `eye`: position in the space of its sector.
    /// * `orientation`: unit quaternion (x, y, z, w) that rotates eye space (x right, y up, −z ahead) to the space of the
    ///   sector.
    /// * `tangents`: of the angles from the view direction to the left, right, bottom and top edge of the viewport, positive
    ///   to the right and up; so left and bottom are mostly negative. In OpenXR these are the tangents of `angleLeft`,
    ///   `angleRight`, `angleDown` and `angleUp`.
    /// * `z_near`: distance of the near plane along the view direction, above 0.
    ///
    /// # Errors
    /// Returns the [`ViewError`] of the first rule that is broken.
    #[doc(alias = "OpenXR")]
    #[doc(alias = "asymmetric frustum")]
    pub fn from_pose(
        eye: [f64; 3],
        orientation: [f64; 4],
        tangents: [f64; 4],
        z_near: f32,
        viewport: impl Into<Viewport>,
    ) -> Result<View, ViewError> {
        let (viewport, [left, right, bottom, top]) = (viewport.into(), tangents);
        check_position("the eye", eye)?;
        let rotation = DQuat::from_array(orientation);
        if !(rotation.is_finite() && (rotation.length_squared() - 1.0).abs() < 1e-3) {
            return Err(ViewError::Orientation);
        }
        let is_frustum = |low: f64, high: f64| low.is_finite() && high.is_finite() && low < high;
        if !(is_frustum(left, right) && is_frustum(bottom, top)) {
            return Err(ViewError::Tangents);
        }
        let [x, y] = [2.0 / (right - left), 2.0 / (top - bottom)];
        let clip_from_eye = DMat4::from_cols(
            DVec4::new(x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, y, 0.0, 0.0),
            DVec4::new(0.5 * x * (right + left), 0.5 * y * (top + bottom), 0.0, -1.0),
            DVec4::new(0.0, 0.0, f64::from(z_near), 0.0),
        );
        let eye = DVec3::from(eye);
        let from_sector = DMat3::from_quat(rotation.normalize()).transpose();
        let eye_from_sector = DAffine3 {
            matrix3: from_sector,
            translation: from_sector * -eye,
        };
        View::of_projection(eye, eye_from_sector, clip_from_eye, z_near, viewport)
    }

    /// Creates a view from a view matrix and a projection matrix, after all checks but those of the size and of `z_near`.
    /// Neither has an offset: the eye is the origin of eye space.
    fn of_projection(
        eye: DVec3,
        eye_from_sector: DAffine3,
        clip_from_eye: DMat4,
        z_near: f32,
        viewport: Viewport,
    ) -> Result<View, ViewError> {
        check_viewport(viewport, z_near)?;
        let viewport_from_eye = matrices::viewport_from_eye(&clip_from_eye, viewport.size);
        let viewport_from_sector = viewport_from_eye * eye_from_sector.matrix3;
        let sector_from_viewport = viewport_from_sector.inverse();
        if !sector_from_viewport.is_finite() {
            return Err(ViewError::Singular);
        }
        let ahead = viewport_from_sector.row(2);
        let [width, height] = viewport.size.map(f64::from);
        let [top, bottom] = [0.0, height].map(|y| sector_from_viewport * DVec3::new(0.5 * width, y, 1.0));
        Ok(View {
            sector: None,
            eye,
            toward: eye + ahead.normalize_or_zero(),
            up: (sector_from_viewport * DVec3::NEG_Y).normalize_or_zero(),
            fov_y: top.angle_between(bottom) as f32,
            z_near,
            viewport,
            sample: [0.0; 2],
            eye_from_sector,
            clip_from_eye,
            viewport_from_eye: DAffine3::from_mat3(viewport_from_eye),
            is_parallel: false,
            far: f64::INFINITY,
            oblique: None,
            is_light: false,
        })
    }

    /// Creates a parallel (orthographic) view, as of a sun, a map or a plan.
    ///
    /// * `eye`: the point of the near plane in the middle of the viewport, in the space of its sector. Nothing in front of
    ///   that plane is visible, nor hides anything: for a sun, put it before everything that casts a shadow.
    /// * `toward`: the target point; the view direction leads to it.
    /// * `up`: up vector, as in [`Camera::up`].
    /// * `height` of what the viewport shows, in scene units, above 0.
    ///
    /// For renderers, the far plane of [`View::clip_from_eye`] is 1024 times as far away as the target point; looks have
    /// none.
    ///
    /// ```
    /// use enfilade::View;
    /// // 40 units of ground, seen straight from above, with -z up on the screen.
    /// let map = View::parallel([0.0, 50.0, 0.0], [0.0; 3], [0.0, 0.0, -1.0], 40.0, [400, 400])?;
    /// assert_eq!(map.ray([200.0, 100.0]), [[0.0, 50.0, -10.0], [0.0, -1.0, 0.0]]);
    /// # Ok::<(), enfilade::ViewError>(())
    /// ```
    ///
    /// # Errors
    /// Returns the [`ViewError`] of the first rule that is broken.
    #[doc(alias = "orthographic")]
    #[doc(alias = "shadow map")]
    pub fn parallel<T: Into<f64>>(
        eye: [T; 3],
        toward: [T; 3],
        up: [f64; 3],
        height: f64,
        viewport: impl Into<Viewport>,
    ) -> Result<View, ViewError> {
        let (viewport, mut camera) = (viewport.into(), Camera::new(eye, toward));
        camera.up = up;
        // Checks the rest.
        let view = camera.view(viewport)?;
        if !(height > 0.0 && height.is_finite()) {
            return Err(ViewError::Height(height));
        }
        let [across, down] = viewport.size.map(f64::from);
        let far = 1024.0 * view.toward.distance(view.eye);
        let [x, y] = [2.0 * down / (height * across), 2.0 / height];
        let clip_from_eye = DMat4::from_cols(
            DVec4::new(x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, y, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0 / far, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 1.0),
        );
        let parallel = View::of_parallel(
            view.eye_from_sector,
            clip_from_eye,
            ClipDepth::OneToZero,
            viewport,
        )?;
        Ok(View {
            eye: view.eye,
            toward: view.toward,
            up: view.up,
            ..parallel
        })
    }

    /// Creates the parallel view of a sun: a box with `eye` in the middle of its near side, `half` its width and height and `far`
    /// deep. `axes`: its unit vectors right, up, and against the view direction.
    pub(crate) fn of_sun(
        eye: DVec3,
        axes: DMat3,
        half: [f64; 2],
        far: f64,
        viewport: Viewport,
    ) -> Result<View, ViewError> {
        let from_sector = axes.transpose();
        let eye_from_sector = DAffine3 {
            matrix3: from_sector,
            translation: from_sector * -eye,
        };
        let clip_from_eye = DMat4::from_cols(
            DVec4::new(1.0 / half[0], 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / half[1], 0.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0 / far, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 1.0),
        );
        View::of_parallel(eye_from_sector, clip_from_eye, ClipDepth::OneToZero, viewport)
    }

    /// Returns the same view as that of a light in a sector.
    pub(crate) fn of_light(self, sector: SectorId) -> View {
        View {
            is_light: true,
            ..self.in_sector(sector)
        }
    }

    pub(crate) fn is_light(&self) -> bool {
        self.is_light
    }

    /// Creates a parallel view from a view matrix and a projection matrix, after all checks but those of the size.
    fn of_parallel(
        eye_from_sector: DAffine3,
        clip_from_eye: DMat4,
        depth: ClipDepth,
        viewport: Viewport,
    ) -> Result<View, ViewError> {
        check_viewport(viewport, 1.0)?;
        let parallel = matrices::Parallel::of(&clip_from_eye, depth, viewport.size)?;
        let sector_from_eye = eye_from_sector.inverse();
        let eye = sector_from_eye.transform_point3(parallel.eye);
        let ahead = sector_from_eye
            .transform_vector3(parallel.ahead)
            .normalize_or_zero();
        let up = sector_from_eye.transform_vector3(parallel.up).normalize_or_zero();
        if !(eye.is_finite() && ahead.is_normalized() && up.is_normalized()) {
            return Err(ViewError::Singular);
        }
        check_position("the eye", eye.into())?;
        // From here on the origin of eye space is the eye.
        Ok(View {
            sector: None,
            eye,
            toward: eye + ahead,
            up,
            fov_y: 0.0,
            z_near: 0.0,
            viewport,
            sample: [0.0; 2],
            eye_from_sector: DAffine3::from_translation(-parallel.eye) * eye_from_sector,
            clip_from_eye: clip_from_eye * DMat4::from_translation(parallel.eye),
            viewport_from_eye: parallel.viewport_from_eye,
            is_parallel: true,
            far: parallel.far,
            oblique: None,
            is_light: false,
        })
    }

    /// Returns the same view of an eye in a given sector.
    #[must_use]
    pub fn in_sector(self, sector: SectorId) -> View {
        View {
            sector: Some(sector),
            ..self
        }
    }

    /// Returns the same view with its samples elsewhere in their pixels.
    ///
    /// `sample` is the position relative to the pixel centre, in pixels, −½ to ½ each, y down. Default (0, 0).
    /// [`View::FOUR_SAMPLES`] has the positions of usual 4x multisampling.
    ///
    /// # Errors
    /// Returns [`ViewError::Sample`] for a position outside the pixel.
    pub fn at_sample(self, sample: [f32; 2]) -> Result<View, ViewError> {
        let [dx, dy] = sample;
        if !(dx.abs() <= 0.5 && dy.abs() <= 0.5) {
            return Err(ViewError::Sample(dx, dy));
        }
        Ok(View { sample, ..self })
    }

    /// Returns the eye position, in the space of its sector.
    pub fn eye(&self) -> [f64; 3] {
        self.eye.into()
    }

    /// Returns the target point: that of the constructor, else the point one unit ahead of the eye along the view
    /// direction.
    pub fn toward(&self) -> [f64; 3] {
        self.toward.into()
    }

    /// Returns the up vector: that of the constructor, else the unit vector that points up on the screen.
    pub fn up(&self) -> [f64; 3] {
        self.up.into()
    }

    /// Returns the angle between the top and the bottom edge of the viewport, in radians, at its middle column; 0 in a
    /// parallel view.
    pub fn fov_y(&self) -> f32 {
        self.fov_y
    }

    /// Whether the projection is parallel (orthographic).
    #[doc(alias = "orthographic")]
    pub fn is_parallel(&self) -> bool {
        self.is_parallel
    }

    /// Returns the distance of the near plane along the view direction, in units of eye space: above 0, or 0 in a parallel
    /// view. Geometry in front of it is neither visible nor an occluder. If the near plane is oblique, its smallest distance
    /// within the frustum ([`View::near_plane`]).
    ///
    /// Set it to your renderer's near plane: with a smaller value, geometry that your renderer clips away can still hide
    /// other geometry.
    #[doc(alias = "near plane")]
    pub fn z_near(&self) -> f32 {
        self.z_near
    }

    /// Returns the distance from the near plane to the far one of a parallel view. Looks need none.
    pub(crate) fn far(&self) -> f64 {
        self.far
    }

    /// Returns the near plane if it is oblique, in the space of the eye's sector: only points (x, y, z) with
    /// ax + by + cz + d ≥ 0 are visible or hide anything. (a, b, c) has length 1. `None` if it is perpendicular to the view
    /// direction, or the view is parallel.
    #[doc(alias = "oblique near plane")]
    #[doc(alias = "clip plane")]
    pub fn near_plane(&self) -> Option<[f64; 4]> {
        let plane = DMat4::from(self.eye_from_sector).transpose() * DVec4::from(self.oblique?);
        Some((plane / plane.truncate().length()).into())
    }

    /// Returns the rectangle of the render target that the view fills.
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// Returns width and height of the viewport, in pixels. Sample (x, y) is at (x + ½, y + ½) plus [`View::sample`] and
    /// [`View::GENERIC_OFFSET`], with y down.
    pub fn size(&self) -> [u32; 2] {
        self.viewport.size
    }

    /// Returns the sample position relative to the pixel centre, in pixels ([`View::at_sample`]).
    pub fn sample(&self) -> [f32; 2] {
        self.sample
    }

    /// Returns the view matrix.
    #[doc(alias = "view matrix")]
    pub fn eye_from_sector(&self) -> Transform {
        Transform(self.eye_from_sector)
    }

    /// Returns the projection matrix, as four columns: that of [`View::from_matrices`], otherwise one with reversed infinite
    /// depth ([`ClipDepth::OneToZero`]).
    #[doc(alias = "projection matrix")]
    pub fn clip_from_eye(&self) -> [[f64; 4]; 4] {
        self.clip_from_eye.to_cols_array_2d()
    }

    /// Returns `true` if faces that are counter-clockwise from the eye, by (b − a) × (c − a), appear clockwise on the screen: in a
    /// mirrored projection, the camera of a planar reflection, or left-handed coordinates. The visible set is the same: a
    /// one-sided face is visible, and hides, from the side to which that vector points. Draw the same sides
    /// ([`Passage::mirrored`](crate::Passage::mirrored) is about portals), or do not cull by this view.
    #[doc(alias = "winding")]
    #[doc(alias = "invert culling")]
    pub fn mirrored(&self) -> bool {
        (self.viewport_from_eye.matrix3 * self.eye_from_sector.matrix3).determinant() < 0.0
    }

    /// Returns the ray through a position in the viewport, in pixels, y down: origin (the eye, or a point of the near plane
    /// of a parallel view) and direction, in the space of the sector. The direction has length 1 along the view direction,
    /// measured in eye space.
    pub fn ray(&self, [x, y]: [f64; 2]) -> [[f64; 3]; 2] {
        if self.is_parallel {
            let sector_from_viewport = (self.viewport_from_eye * self.eye_from_sector).inverse();
            let origin = sector_from_viewport.transform_point3(DVec3::new(x, y, 0.0));
            return [origin.into(), (sector_from_viewport.matrix3 * DVec3::Z).into()];
        }
        let sector_from_viewport = (self.viewport_from_eye.matrix3 * self.eye_from_sector.matrix3).inverse();
        [
            self.eye.into(),
            (sector_from_viewport * DVec3::new(x, y, 1.0)).into(),
        ]
    }

    /// Returns the view with as many columns more on the left and on the right, with samples at the same positions; `None` if
    /// it would be too wide.
    #[cfg(feature = "laws")]
    pub(crate) fn three_times_as_wide(&self) -> Option<View> {
        let [width, height] = self.viewport.size;
        let mut wide = View {
            viewport: Viewport::from([3 * width, height]),
            ..*self
        };
        wide.clip_from_eye = DMat4::from_scale(DVec3::new(1.0 / 3.0, 1.0, 1.0)) * wide.clip_from_eye;
        wide.shift([f64::from(width), 0.0]);
        (wide.viewport.size[0] <= View::MAX_PIXELS).then_some(wide)
    }

    /// Moves the picture on the screen, in pixels.
    fn shift(&mut self, by: [f64; 2]) {
        let by = DVec2::from(by).extend(0.0);
        let DAffine3 { matrix3, translation } = &mut self.viewport_from_eye;
        if self.is_parallel {
            *translation += by;
        } else {
            for column in [&mut matrix3.x_axis, &mut matrix3.y_axis, &mut matrix3.z_axis] {
                *column += by * column.z;
            }
        }
    }

    /// Returns the projection from eye space to (X, Y, W), shifted so that samples are at pixel centres, wherever the view
    /// puts them.
    pub(crate) fn screen_from_eye(&self) -> DAffine3 {
        let offset = DVec2::from(self.sample.map(f64::from)) + DVec2::from(View::GENERIC_OFFSET);
        let mut shifted = *self;
        shifted.shift((-offset).into());
        shifted.viewport_from_eye
    }
}

/// Checks a position in the space of a sector.
fn check_position(name: &'static str, position: [f64; 3]) -> Result<(), ViewError> {
    if position.iter().any(|value| !value.is_finite()) {
        return Err(ViewError::NotFinite(name));
    }
    if position
        .iter()
        .any(|value| value.abs() > f64::from(MAX_COORDINATE))
    {
        return Err(ViewError::TooFar(name));
    }
    Ok(())
}

fn check_viewport(viewport: Viewport, z_near: f32) -> Result<(), ViewError> {
    let [width, height] = viewport.size;
    if [width, height]
        .iter()
        .any(|&side| side == 0 || side > View::MAX_PIXELS)
    {
        return Err(ViewError::Size(width, height));
    }
    if viewport
        .origin
        .iter()
        .any(|&start| start > u32::MAX - View::MAX_PIXELS)
    {
        return Err(ViewError::Origin(viewport.origin[0], viewport.origin[1]));
    }
    if !(z_near > 0.0 && z_near.is_finite()) {
        return Err(ViewError::Near(z_near));
    }
    Ok(())
}
