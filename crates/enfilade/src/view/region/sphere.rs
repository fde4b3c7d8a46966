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
use crate::view::screen_map::ScreenMap;
use glam::DVec3;

/// A sphere nearer to the plane of the eye than this, relative to its centre's distance, is projected as its box:
/// rounding would cost the quadratic equation too many digits.
const NEAREST: f64 = 1.0 / (1 << 20) as f64;

/// Returns the samples that may show a sphere, and its nearest reversed depth. Centre and radius must be finite and the
/// radius not negative.
pub(crate) fn sphere_on_screen(
    clip: &Clip,
    screen_from_local: &ScreenMap,
    (center, radius): ([f32; 3], f32),
) -> (Rect, f32) {
    let radius_in_f64 = f64::from(radius);
    let middle = screen_from_local
        .linear
        .transform_point3(DVec3::from(center.map(f64::from)));
    let rows = screen_from_local.linear.matrix3.transpose();
    if screen_from_local.is_parallel {
        return parallel(
            clip,
            middle,
            radius_in_f64 * DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length()),
        );
    }
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
    let rect = Rect::near(min, max, clip.spread, &clip.rect);
    (rect, nearest(nearest_w, clip.near))
}

/// As [`sphere_on_screen`] in a parallel view, by the sphere's middle and its half extents in (column, row, reversed depth).
fn parallel(clip: &Clip, middle: DVec3, half: DVec3) -> (Rect, f32) {
    let [low, high] = [middle - half, middle + half];
    // Written so that NaN counts as visible.
    if high.z * clip.near < 1.0 {
        let rect = Rect::near([low.x, low.y], [high.x, high.y], clip.spread, &clip.rect);
        return (rect, nearest(1.0 / high.z, clip.near));
    }
    if low.z * clip.near > 1.0 {
        return (Rect::default(), 0.0);
    }
    let rect = Rect::near([low.x, low.y], [high.x, high.y], clip.spread, &clip.rect);
    (rect, f32::INFINITY)
}
