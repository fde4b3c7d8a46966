//! A box in space, as a passage sees it.

use crate::aperture::Rect;
use crate::geom::Aabb;
use crate::passage::Passage;
use glam::{DAffine3, DVec3};

/// A box in space, as a passage sees it: the samples it may touch, and how near it comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// The samples inside the aperture's rectangle that any part of the box may own.
    pub rect: Rect,
    /// Nearness (1 / distance along the line of sight) of its nearest corner, rounded up; infinite where the box
    /// reaches before the near distance.
    pub nearest: f32,
}

/// By how much nearness is rounded up in queries, relatively: more than covers lose (2⁻²⁴), less than what the
/// reference calls equal (2⁻¹⁶).
const ROUND_UP: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

impl Region {
    /// What `passage` sees of a box given in another space; `None` where no sample of the aperture's rectangle can
    /// show any of it.
    pub(crate) fn of(passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb) -> Option<Region> {
        Region::in_rect(passage, passage.aperture.rect(), screen_from_local, bounds)
            .filter(|region| !region.rect.is_empty())
    }

    /// As [`Region::of`], in another rectangle, and also where no sample shows any of it.
    pub(crate) fn in_rect(
        passage: &Passage,
        limits: Rect,
        screen_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> Option<Region> {
        if bounds.is_empty() {
            return None;
        }
        let corners = corners_on_screen(screen_from_local, bounds);
        let [x0, y0, x1, y1] = [limits.x0, limits.y0, limits.x1, limits.y1].map(f64::from);
        let near = f64::from(passage.near);
        let mut outside = 0b11_1111_u8;
        let mut nearest_w = f64::INFINITY;
        for corner in &corners {
            let DVec3 { x, y, z: w } = *corner;
            let beyond_entry = passage
                .entry
                .is_none_or(|(normal, d)| normal.dot(*corner) >= d * (1.0 - 1e-6));
            outside &= u8::from(x < x0 * w)
                | u8::from(x > x1 * w) << 1
                | u8::from(y < y0 * w) << 2
                | u8::from(y > y1 * w) << 3
                | u8::from(w < near) << 4
                | u8::from(!beyond_entry) << 5;
            nearest_w = nearest_w.min(w);
        }
        if outside != 0 {
            return None;
        }
        if nearest_w <= near {
            return Some(Region {
                rect: limits,
                nearest: f32::INFINITY,
            });
        }
        let [mut min, mut max] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for corner in &corners {
            let per_w = 1.0 / corner.z;
            for (axis, value) in [corner.x * per_w, corner.y * per_w].into_iter().enumerate() {
                min[axis] = if value < min[axis] { value } else { min[axis] };
                max[axis] = if value > max[axis] { value } else { max[axis] };
            }
        }
        Some(Region {
            rect: Rect::around(min, max, &limits),
            nearest: (ROUND_UP / nearest_w) as f32,
        })
    }
}

/// The eight corners as (X, Y, W), by adding edges to the least corner.
fn corners_on_screen(screen_from_local: &DAffine3, bounds: &Aabb) -> [DVec3; 8] {
    let least = screen_from_local.transform_point3(DVec3::from(bounds.min.map(f64::from)));
    let size: [f64; 3] =
        std::array::from_fn(|axis| f64::from(bounds.max[axis]) - f64::from(bounds.min[axis]));
    let x = screen_from_local.matrix3.x_axis * size[0];
    let y = screen_from_local.matrix3.y_axis * size[1];
    let z = screen_from_local.matrix3.z_axis * size[2];
    let (xy, far) = (x + y, least + z);
    [
        least,
        least + x,
        least + y,
        least + xy,
        far,
        far + x,
        far + y,
        far + xy,
    ]
}
