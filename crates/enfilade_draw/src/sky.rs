//! What is behind everything.

use enfilade::View;
use glam::{DVec3, Vec3};

/// Directions of samples, for what is behind everything.
pub(crate) struct Sky {
    corner: DVec3,
    right: DVec3,
    down: DVec3,
}

impl Sky {
    pub(crate) fn new(view: &View) -> Sky {
        let [eye, toward, up] = [view.eye, view.toward, view.up].map(|v| DVec3::from(v.map(f64::from)));
        let forward = (toward - eye).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        let down = forward.cross(right);
        let [width, height] = view.size.map(f64::from);
        let [dx, dy] = view.sample.map(f64::from);
        let step = 2.0 * (0.5 * f64::from(view.fov_y)).tan() / height;
        let corner =
            forward + right * (step * (dx + 0.5 - 0.5 * width)) + down * (step * (dy + 0.5 - 0.5 * height));
        Sky {
            corner,
            right: right * step,
            down: down * step,
        }
    }

    /// The color behind pixel (x, y), linear.
    pub(crate) fn at(&self, [x, y]: [usize; 2]) -> Vec3 {
        sky(self.corner + self.right * x as f64 + self.down * y as f64)
    }
}

/// The sky in a direction whose y is up.
fn sky(direction: DVec3) -> Vec3 {
    let up = direction.normalize_or_zero().y as f32;
    let horizon = Vec3::new(0.78, 0.84, 0.90);
    if up >= 0.0 {
        horizon.lerp(Vec3::new(0.18, 0.36, 0.68), up.sqrt())
    } else {
        horizon.lerp(Vec3::new(0.28, 0.27, 0.26), (-3.0 * up).min(1.0))
    }
}
