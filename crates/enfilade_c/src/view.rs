//! Views: what a camera shows, from matrices or from a camera.

use crate::ids::EnfiladeSectorId;
use crate::lent::Caller;
use crate::scene::{SceneState, check_reserved};
use crate::status::{EnfiladeError, EnfiladeStatus, Failure, characters, refuse};
use enfilade::{Camera, ClipDepth, View, ViewError, Viewport};
use std::ffi::c_char;

/// Depth of the near and the far plane in clip space.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnfiladeClipDepth {
    /// -1 near, 1 far: OpenGL, Unity's `Camera.projectionMatrix`, Godot.
    MinusOneToOne = 0,
    /// 0 near, 1 far: Direct3D, Vulkan, Metal.
    ZeroToOne = 1,
    /// 1 near, 0 far (reversed depth): Unreal, Bevy.
    OneToZero = 2,
}

/// A camera with its viewport: the matrices that the frame is drawn with.
///
/// Matrices are 16 doubles, column after column, and multiply column vectors: the clip position of a point is clip_from_eye x
/// eye_from_sector x (x, y, z, 1). A matrix of rows that multiply row vectors (DirectXMath, Unreal) has the same numbers in the
/// same order. Right- or left-handed, any up axis, off-centre, jittered, infinite or reversed depth, orthographic, oblique near
/// plane. There is no far plane: what is beyond it counts as visible. Matrices that mirror, as of a planar reflection, leave
/// visible, and occluding, the same sides of faces: flip the winding of your renderer for them.
///
/// If too much or too little is visible, print one matrix: a view matrix has the translation in its last four numbers, and a
/// perspective projection -1 or 1 as number 11 (the first is 0). A wrong clip_depth between the first two is not noticed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeView {
    /// The view matrix.
    pub eye_from_sector: [f64; 16],
    /// The projection matrix.
    pub clip_from_eye: [f64; 16],
    /// The sector that the eye is in, whose space eye_from_sector starts from; 0: found by the position of the eye.
    pub sector: EnfiladeSectorId,
    /// An EnfiladeClipDepth: that of clip_from_eye.
    pub clip_depth: u32,
    /// Left edge of the viewport, in pixels of the render target. Moves the scissors of passages only.
    pub left: u32,
    /// Top edge of the viewport, in pixels of the render target.
    pub top: u32,
    /// Width of the viewport, 1 to 16384 pixels.
    pub width: u32,
    /// Height of the viewport, 1 to 16384 pixels.
    pub height: u32,
    /// Must be 0.
    pub reserved: u32,
}

/// A camera by its parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EnfiladeCamera {
    /// Position of the eye, in the space of its sector.
    pub eye: [f64; 3],
    /// A point in the centre of the picture, not the eye.
    pub target: [f64; 3],
    /// Up vector, of any length; zero for +y. If it is parallel to the direction of view, another is taken.
    pub up: [f64; 3],
    /// Vertical field of view in radians, above 0 and below pi; 0 for 60 degrees.
    pub fov_y: f32,
    /// Distance of the near plane, above 0; 0 for a small one that suits the scene's scale.
    pub near_distance: f32,
    /// For an orthographic camera the height that it shows, in scene units; the eye is then in the near plane. 0 for perspective.
    pub parallel_height: f32,
    /// Must be 0.
    pub reserved: u32,
    /// The sector that the eye is in; 0, as for most cameras of files: found by its position.
    pub sector: EnfiladeSectorId,
    /// Name of a camera of a file, cut to fit; ignored as input.
    pub name: [c_char; 64],
}

/// Returns the view of a camera: its matrices, with reversed depth.
///
/// @param width Width of the viewport, 1 to 16384 pixels.
/// @param height Height of the viewport, 1 to 16384 pixels.
/// @param view Receives the view.
///
/// Errors: ENFILADE_STATUS_BAD_VIEW for numbers that are not finite or out of range.
#[allow(unsafe_code, reason = "called from C")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn enfilade_view_from_camera(
    camera: *const EnfiladeCamera,
    width: u32,
    height: u32,
    view: *mut EnfiladeView,
    error: *mut EnfiladeError,
) -> EnfiladeStatus {
    // SAFETY: the promise of the caller, as the crate's documentation says.
    let caller = unsafe { Caller::new() };
    caller.call(error, |caller| {
        // Read first: both may be in one struct of the caller.
        let camera = caller.one(camera, "camera");
        let out = caller.out(view, "view")?;
        let camera = camera?;
        check_reserved(camera.reserved)?;
        let view = view_of(&camera, [width, height])?;
        let mut matrix = [[0.0; 4]; 4];
        for (column, values) in matrix.iter_mut().zip(view.eye_from_sector().columns_f64()) {
            column[..3].copy_from_slice(&values);
        }
        matrix[3][3] = 1.0;
        out.set(EnfiladeView {
            eye_from_sector: flat(matrix),
            clip_from_eye: flat(view.clip_from_eye()),
            sector: camera.sector,
            clip_depth: EnfiladeClipDepth::OneToZero as u32,
            left: 0,
            top: 0,
            width,
            height,
            reserved: 0,
        });
        Ok(())
    })
}

fn view_of(camera: &EnfiladeCamera, size: [u32; 2]) -> Result<View, ViewError> {
    let up = if camera.up == [0.0; 3] {
        [0.0, 1.0, 0.0]
    } else {
        camera.up
    };
    if camera.parallel_height != 0.0 {
        let height = f64::from(camera.parallel_height);
        return View::parallel(camera.eye, camera.target, up, height, size);
    }
    let mut known = Camera::new(camera.eye, camera.target);
    known.up = up;
    if camera.fov_y != 0.0 {
        known.fov_y = camera.fov_y;
    }
    if camera.near_distance != 0.0 {
        known.z_near = Some(camera.near_distance);
    }
    known.view(size)
}

impl EnfiladeCamera {
    /// Returns a camera of a file.
    pub(crate) fn of(camera: &Camera, sector: EnfiladeSectorId) -> EnfiladeCamera {
        EnfiladeCamera {
            eye: camera.eye,
            target: camera.toward,
            up: camera.up,
            fov_y: camera.fov_y,
            near_distance: camera.z_near.unwrap_or(0.0),
            parallel_height: 0.0,
            reserved: 0,
            sector,
            name: characters(&camera.name),
        }
    }
}

impl EnfiladeView {
    /// Returns the view without its sector.
    pub(crate) fn anywhere(&self) -> Result<View, Failure> {
        check_reserved(self.reserved)?;
        const DEPTHS: [ClipDepth; 3] = [
            ClipDepth::MinusOneToOne,
            ClipDepth::ZeroToOne,
            ClipDepth::OneToZero,
        ];
        let Some(&depth) = DEPTHS.get(self.clip_depth as usize) else {
            let depth = self.clip_depth;
            return Err(refuse(
                "c/clip-depth",
                format_args!("clip_depth is {depth}; it must be an EnfiladeClipDepth"),
            ));
        };
        let viewport = Viewport {
            origin: [self.left, self.top],
            size: [self.width, self.height],
        };
        let [eye, clip] = [self.eye_from_sector, self.clip_from_eye].map(|numbers| columns(&numbers));
        Ok(View::from_matrices(eye, clip, depth, viewport)?)
    }

    /// Returns the view in its sector of a scene.
    pub(crate) fn within(&self, scene: &SceneState) -> Result<View, Failure> {
        let view = self.anywhere()?;
        if self.sector == 0 {
            return Ok(view);
        }
        Ok(view.in_sector(scene.sector(self.sector)?))
    }
}

fn columns(numbers: &[f64; 16]) -> [[f64; 4]; 4] {
    [0, 1, 2, 3].map(|column| [0, 1, 2, 3].map(|row| numbers[4 * column + row]))
}

fn flat(columns: [[f64; 4]; 4]) -> [f64; 16] {
    std::array::from_fn(|number| columns[number / 4][number % 4])
}
