//! Camera data for a GPU: projection matrix relative to the eye, and frustum planes.

use enfilade::{Aabb, View};
use glam::{DMat3, DVec3, Mat4, Vec3, Vec4};

/// Depth is near / distance: 1 at the near plane, 0 at infinity. Reversed depth keeps f32 precise far away.
pub(crate) struct Lens {
    /// Camera position.
    pub(crate) eye: DVec3,
    /// Unit vector against the view direction.
    pub(crate) back: DVec3,
    /// From positions relative to the eye, with the scene's axes, to clip space.
    pub(crate) clip_from_relative: Mat4,
    /// The direction of the viewport's upper left corner, and its change per pixel to the right and down.
    pub(crate) sky: [Vec3; 3],
    /// Points inside have `plane · (position relative to the eye, 1)` ≥ 0.
    planes: [Vec4; 5],
}

impl Lens {
    pub(crate) fn new(view: &View) -> Lens {
        let [eye, toward, up] = [view.eye(), view.toward(), view.up()].map(DVec3::from);
        let back = (eye - toward).normalize();
        let right = up.cross(back).normalize();
        let up = back.cross(right);
        let [width, height] = view.size().map(f64::from);
        let slope = (0.5 * f64::from(view.fov_y())).tan();
        let near = f64::from(view.z_near());
        let clip_from_relative = Mat4::from_cols_array_2d(
            &[
                (right * (height / (width * slope))).extend(0.0).as_vec4(),
                (up / slope).extend(0.0).as_vec4(),
                Vec4::new(0.0, 0.0, 0.0, near as f32),
                (-back).extend(0.0).as_vec4(),
            ]
            .map(|row| row.to_array()),
        )
        .transpose();
        let step = 2.0 * slope / height;
        let [rightward, downward] = [right * step, -up * step];
        let corner = -back - rightward * (0.5 * width) - downward * (0.5 * height);
        let [x, y, z, w] = [0, 1, 2, 3].map(|row| clip_from_relative.row(row));
        Lens {
            eye,
            back,
            clip_from_relative,
            sky: [corner, rightward, downward].map(|v| v.as_vec3()),
            planes: [w + x, w - x, w + y, w - y, w - z],
        }
    }

    /// Returns `true` if a box in scene space may intersect the frustum; `true` when unsure.
    pub(crate) fn may_show(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let relative = |corner: [f32; 3]| (DVec3::from(corner.map(f64::from)) - self.eye).as_vec3();
        let [min, max] = [relative(bounds.min), relative(bounds.max)];
        self.planes.iter().all(|plane| {
            let innermost = Vec3::select(plane.truncate().cmpge(Vec3::ZERO), max, min);
            plane.dot(innermost.extend(1.0)) >= 0.0
        })
    }

    /// Returns an item's transform relative to the eye, as matrix rows: linear part unchanged, translation relative.
    pub(crate) fn relative(&self, matrix: &DMat3, translation: DVec3) -> [[f32; 4]; 3] {
        let translation = translation - self.eye;
        [0, 1, 2].map(|row| matrix.row(row).extend(translation[row]).as_vec4().into())
    }
}
