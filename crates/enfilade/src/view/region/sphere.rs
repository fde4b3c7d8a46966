//! Projection of a sphere: screen rectangle and nearest depth.
//!
//! A column x of the screen is the plane through the eye with X = x · W. The outermost columns are the two planes that
//! touch the sphere: a quadratic equation for x. Rows likewise.
//! Source: Mara, McGuire, 2D Polyhedral Bounds of a Clipped, Perspective-Projected 3D Sphere, JCGT 2013, for the idea;
//!     here for any projection matrix.
//! Cost: O(1).
//! Exact up to the rounding of f64, which [`Rect::SLACK`] covers.

use super::{Clip, EightBoxes, nearest};
use crate::geom::Aabb;
use crate::view::aperture::Rect;
use glam::{DAffine3, DVec3};

/// A sphere nearer to the plane of the eye than this, relative to its centre's distance, is projected as its box:
/// rounding would cost the quadratic equation too many digits.
const NEAREST: f64 = 1.0 / (1 << 20) as f64;

/// Returns the samples that may show a sphere, and its nearest reversed depth. Centre and radius must be finite and the
/// radius not negative.
pub(crate) fn sphere_on_screen(
    clip: &Clip,
    screen_from_local: &DAffine3,
    (center, radius): ([f32; 3], f32),
) -> (Rect, f32) {
    let radius_in_f64 = f64::from(radius);
    let middle = screen_from_local.transform_point3(DVec3::from(center.map(f64::from)));
    let rows = screen_from_local.matrix3.transpose();
    let nearest_w = middle.z - radius_in_f64 * rows.z_axis.length();
    // Written so that NaN fails too.
    if !(nearest_w > clip.near && nearest_w > NEAREST * middle.z) {
        let bounds = Aabb {
            min: center.map(|at| (at - radius).next_down()),
            max: center.map(|at| (at + radius).next_up()),
        };
        return EightBoxes::of(*clip, screen_from_local, &[bounds]).rect(0);
    }
    let farthest_w = middle.z + radius_in_f64 * rows.z_axis.length();
    let between = |at: f64, row: DVec3| {
        let tilt = row.dot(rows.z_axis);
        let half = (at * rows.z_axis - middle.z * row).length_squared()
            - radius_in_f64 * radius_in_f64 * row.cross(rows.z_axis).length_squared();
        let half = radius_in_f64 * half.max(0.0).sqrt();
        let both = at * middle.z - radius_in_f64 * radius_in_f64 * tilt;
        let per = 1.0 / (nearest_w * farthest_w);
        [(both - half) * per, (both + half) * per]
    };
    let [columns, screen_rows] = [between(middle.x, rows.x_axis), between(middle.y, rows.y_axis)];
    let (min, max) = ([columns[0], screen_rows[0]], [columns[1], screen_rows[1]]);
    let rect = if clip.any_place {
        Rect::touched(min, max, &clip.rect)
    } else {
        Rect::around(min, max, &clip.rect)
    };
    (rect, nearest(nearest_w, clip.near))
}
