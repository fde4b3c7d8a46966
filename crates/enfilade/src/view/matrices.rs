//! Views from the matrices of an engine.
//!
//! What: takes a projection matrix apart into a map to pixels and a near plane, whatever its conventions.
//! Idea: pixels need the rows x, y and w alone; the row of z gives the near plane by the depth that it has in clip space.
//! Source: Hartley, Zisserman, Multiple View Geometry, 2nd edition, section 6.2, for the eye of a projective camera.

use super::{View, ViewError, Viewport, check_position};
use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4, Vec4Swizzles};

/// The depths z / w of the near plane and of the far end in clip space: the convention of a projection matrix.
#[doc(alias = "reversed z")]
#[doc(alias = "NDC")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClipDepth {
    /// 0 near, 1 far: Direct3D, Metal, Vulkan, WebGPU.
    ZeroToOne,
    /// 1 near, 0 far: the same with reversed depth, as in Bevy and Unreal, and in the matrices that Unity sends to the GPU.
    OneToZero,
    /// −1 near, 1 far: OpenGL, WebGL, three.js.
    MinusOneToOne,
}

impl ClipDepth {
    /// Returns the depth of the near plane and that of the far plane.
    fn ends(self) -> [f64; 2] {
        match self {
            ClipDepth::ZeroToOne => [0.0, 1.0],
            ClipDepth::OneToZero => [1.0, 0.0],
            ClipDepth::MinusOneToOne => [-1.0, 1.0],
        }
    }
}

/// Part of a row by which its direction may be off, and still count as exact: the rounding of f32 matrices.
const ROUNDING: f64 = 1e-5;

impl View {
    /// Creates a view from a view matrix and a projection matrix, perspective or parallel (orthographic), as engines have
    /// them.
    ///
    /// Both are given as four columns and multiply column vectors: the clip position of a point is `clip_from_eye` ·
    /// `eye_from_sector` · (x, y, z, 1), with y up. Right- or left-handed, any up axis, symmetric or off-centre (VR, tiles),
    /// jittered, finite or infinite, with an oblique near plane (planar reflections): what a renderer draws with the same
    /// matrices is what is looked at. `f32` matrices do: convert each value. Far from the origin, hand in `f64` matrices if
    /// you have them, or a position by [`View::from_pose`].
    ///
    /// A matrix of depth −1 to 1 that is said to be 0 to 1, or the other way round, is not noticed: its near plane is at
    /// twice or half the distance. A parallel view of the wrong `depth` looks backwards, or begins in the middle of its
    /// range. Nor is a transposed projection noticed if its near plane is at 1 or at ½. Print [`View::z_near`], [`View::fov_y`] and [`View::toward`]
    /// once. The coordinates of your world are handed in unchanged, whatever their handedness: a face is seen from where
    /// (b − a) × (c − a) points, computed from the numbers.
    ///
    /// The far plane is ignored: geometry beyond it counts as visible. A Vulkan projection with y down gives a picture upside
    /// down; negate its second row to get scissors in pixels from the top.
    ///
    /// ```
    /// use enfilade::{ClipDepth, View};
    /// // Left-handed, y up, 90 degrees, reversed depth, near plane at 0.1, no far plane; the eye is at (0, 2, -5).
    /// let eye_from_world = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], [0., -2., 5., 1.]];
    /// let clip_from_eye = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 0., 1.], [0., 0., 0.1, 0.]];
    /// let view = View::from_matrices(eye_from_world, clip_from_eye, ClipDepth::OneToZero, [512, 512])?;
    /// assert_eq!((view.eye(), view.z_near()), ([0.0, 2.0, -5.0], 0.1));
    /// assert_eq!(view.toward(), [0.0, 2.0, -4.0]);
    /// # Ok::<(), enfilade::ViewError>(())
    /// ```
    ///
    /// # Errors
    /// Returns the [`ViewError`] of the first rule that is broken.
    #[doc(alias = "projection matrix")]
    #[doc(alias = "view matrix")]
    pub fn from_matrices(
        eye_from_sector: [[f64; 4]; 4],
        clip_from_eye: [[f64; 4]; 4],
        depth: ClipDepth,
        viewport: impl Into<Viewport>,
    ) -> Result<View, ViewError> {
        let [view, clip] =
            [eye_from_sector, clip_from_eye].map(|columns| DMat4::from_cols_array_2d(&columns));
        if !view.is_finite() {
            return Err(ViewError::NotFinite("the view matrix"));
        }
        if !clip.is_finite() {
            return Err(ViewError::NotFinite("the projection matrix"));
        }
        if view.row(3).distance_squared(DVec4::W) > ROUNDING * ROUNDING {
            return Err(ViewError::NotAffine);
        }
        if is_parallel(&clip) {
            return View::of_parallel(DAffine3::from_mat4(view), clip, depth, viewport.into());
        }
        if is_transposed(&clip) {
            return Err(ViewError::Transposed);
        }
        let (eye_from_sector, clip) = eye_at_origin(DAffine3::from_mat4(view), clip)?;
        let eye = -(eye_from_sector.matrix3.inverse() * eye_from_sector.translation);
        if !eye.is_finite() {
            return Err(ViewError::Singular);
        }
        check_position("the eye", eye.into())?;
        let (oblique, z_near) = if is_oblique(&clip) {
            let (plane, nearest) = oblique_near_plane(&clip, depth)?;
            (Some(plane), nearest)
        } else {
            (None, near_distance(&clip, depth)?)
        };
        let view = View::of_projection(eye, eye_from_sector, clip, z_near as f32, viewport.into())?;
        Ok(View { oblique, ..view })
    }
}

/// Whether a projection is parallel: the row of w is constant.
fn is_parallel(clip: &DMat4) -> bool {
    let w = clip.row(3);
    w.w != 0.0 && w.xyz().length() <= 1e-12 * w.w.abs()
}

/// Whether a projection is a transposed perspective one: the column of z, (0, 0, b, 0), is where the row of w belongs, and
/// the ±1 of that row at the end of the row of z.
fn is_transposed(clip: &DMat4) -> bool {
    let [z, w] = [clip.row(2), clip.row(3)];
    z.w.abs() == 1.0 && w.xy() == DVec2::ZERO && w.w == 0.0 && w.z.abs() != 1.0
}

/// A parallel projection, taken apart.
pub(super) struct Parallel {
    /// The middle of the viewport in the near plane, in eye space.
    pub(super) eye: DVec3,
    /// The unit vector of the view direction, in eye space, and a vector that points up on the screen.
    pub(super) ahead: DVec3,
    pub(super) up: DVec3,
    /// Distance from the near plane to the far one.
    pub(super) far: f64,
    /// From eye space, with its origin moved to `eye`, to (x, y, distance from the near plane).
    pub(super) viewport_from_eye: DAffine3,
}

impl Parallel {
    pub(super) fn of(clip: &DMat4, depth: ClipDepth, size: [u32; 2]) -> Result<Parallel, ViewError> {
        let [x, y, z] = [0, 1, 2].map(|row| clip.row(row) / clip.row(3).w);
        let along = x.xyz().cross(y.xyz());
        if along.length() <= 1e-12 * x.xyz().length() * y.xyz().length() || !along.is_finite() {
            return Err(ViewError::Singular);
        }
        let [near, far] = depth.ends();
        // Clip depth goes from near to far along the view direction.
        let slope = along.normalize().dot(z.xyz()) * (far - near).signum();
        if slope.abs() <= ROUNDING * z.xyz().length() || !slope.is_finite() {
            return Err(ViewError::Parallel);
        }
        let ahead = along.normalize() * slope.signum();
        let distance = (z - near * DVec4::W) * ((far - near).signum() / slope.abs());
        let rows = DMat3::from_cols(x.xyz(), y.xyz(), distance.xyz()).transpose();
        let from_rows = rows.inverse();
        let eye = from_rows * -DVec3::new(x.w, y.w, distance.w);
        let up = from_rows * DVec3::Y;
        if !(eye.is_finite() && up.is_finite()) {
            return Err(ViewError::Singular);
        }
        let half = size.map(|side| 0.5 * f64::from(side));
        let matrix = [half[0] * x.xyz(), -half[1] * y.xyz(), distance.xyz()].map(Into::into);
        Ok(Parallel {
            eye,
            ahead,
            up,
            far: (far - near).abs() / slope.abs(),
            viewport_from_eye: DAffine3 {
                matrix3: DMat3::from_cols_array_2d(&matrix).transpose(),
                translation: DVec3::new(half[0], half[1], 0.0),
            },
        })
    }
}

/// Moves the origin of eye space to the eye, in case the projection matrix has an offset (as some stereo ones have).
fn eye_at_origin(eye_from_sector: DAffine3, clip: DMat4) -> Result<(DAffine3, DMat4), ViewError> {
    let [x, y, w] = [0, 1, 3].map(|row| clip.row(row));
    if w.xyz() == DVec3::ZERO {
        return Err(ViewError::Singular);
    }
    let offset = DVec3::new(x.w, y.w, w.w);
    if offset == DVec3::ZERO {
        return Ok((eye_from_sector, clip));
    }
    let xyw = DMat3::from_cols(x.xyz(), y.xyz(), w.xyz()).transpose();
    let eye = -(xyw.inverse() * offset);
    if !eye.is_finite() {
        return Err(ViewError::Singular);
    }
    let mut moved = clip * DMat4::from_translation(eye);
    // Zero but for rounding.
    for row in [0, 1, 3] {
        moved.w_axis[row] = 0.0;
    }
    Ok((DAffine3::from_translation(-eye) * eye_from_sector, moved))
}

/// Whether the near plane is not perpendicular to the view direction.
fn is_oblique(clip: &DMat4) -> bool {
    let [z, normal] = [clip.row(2).xyz(), clip.row(3).xyz()];
    let slope = z.dot(normal) / normal.length_squared();
    (z - slope * normal).length() > ROUNDING * z.length().max(normal.length())
}

/// Returns an oblique near plane, in eye space, and its smallest distance along the view direction within the frustum.
fn oblique_near_plane(clip: &DMat4, depth: ClipDepth) -> Result<([f64; 4], f64), ViewError> {
    let [near, far] = depth.ends();
    // Behind the near plane, z / w is on the far side of its depth there.
    let plane = (clip.row(2) - near * clip.row(3)) * (far - near).signum();
    let plane = plane / plane.xyz().length();
    // The eye is the origin.
    if plane.w >= 0.0 || !plane.is_finite() {
        return Err(ViewError::Oblique);
    }
    let xyw = DMat3::from_cols(clip.row(0).xyz(), clip.row(1).xyz(), clip.row(3).xyz()).transpose();
    let unit = clip.row(3).xyz().length();
    let per_w = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
        .map(|[x, y]| plane.xyz().dot(xyw.inverse() * DVec3::new(x, y, 1.0)) / -plane.w)
        .into_iter()
        .fold(0.0, f64::max);
    // Otherwise the plane hides all of the frustum.
    let nearest = if per_w > 0.0 {
        (1.0 - 1e-6) / (per_w * unit)
    } else {
        1.0
    };
    Ok((
        plane.into(),
        nearest.clamp(f64::from(f32::MIN_POSITIVE), f64::from(f32::MAX)),
    ))
}

/// Returns the distance of the near plane along the view direction.
fn near_distance(clip: &DMat4, depth: ClipDepth) -> Result<f64, ViewError> {
    let [z, w] = [clip.row(2), clip.row(3)];
    let normal = w.xyz();
    let slope = z.xyz().dot(normal) / normal.length_squared();
    let distance = |depth: ClipDepth| {
        // Along the view direction z / w = slope + z.w / w, so each depth is at one w.
        let [near, far] = depth.ends().map(|end| (end - slope) / z.w);
        // Reciprocals of w: zero or less is infinitely far.
        let distance = 1.0 / (near * normal.length());
        (near > 0.0 && near > far && distance.is_finite()).then_some(distance)
    };
    distance(depth).ok_or_else(|| ViewError::ClipDepth {
        depth,
        is_reversed: distance(ClipDepth::OneToZero).is_some(),
    })
}

/// Returns the map from eye space to (X, Y, W), where (X / W, Y / W) is a position in the viewport, in pixels, y down, and
/// W the distance along the view direction.
pub(super) fn viewport_from_eye(clip: &DMat4, size: [u32; 2]) -> DMat3 {
    let [x, y, w] = [0, 1, 3].map(|row| clip.row(row).xyz());
    let [width, height] = size.map(f64::from);
    let unit = w.length();
    let rows = [0.5 * width * (w + x), 0.5 * height * (w - y), w].map(|row| row / unit);
    DMat3::from_cols_array_2d(&rows.map(Into::into)).transpose()
}
