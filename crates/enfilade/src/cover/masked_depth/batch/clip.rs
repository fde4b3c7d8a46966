//! Clips triangles with a vertex that fixed point cannot represent.
//!
//! Clips a triangle at the near plane, at the entry plane and at a guard band around the screen. The result has
//! vertices that fixed point can represent and is rasterized as triangles. New edges are the clip planes that the exact
//! covers use, or off screen; the remaining parts of old edges keep their lines. The error of a new vertex is far below
//! a unit of fixed point, the error that setup assumes for all vertices.
//! Source: Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974.
//! Cost: O(planes · corners), one triangle at a time: few cross a plane.
//! Exact: a triangle whose new vertices could have a larger error is left to f64.

use super::corners::{DEEPEST, FARTHEST, TO_INTEGER};
use super::queue::Queue;
use super::{Frame, ONE};
use crate::raster::Clipper;
use glam::DVec3;

/// Guard band: distance from the origin of fixed point at which triangles are clipped, in pixels; slightly less than
/// the largest representable coordinate.
const GUARD: f64 = FARTHEST / ONE as f64 - 64.0;

/// Maximum extent of a triangle relative to a clipped vertex's distance; below it the vertex's error is a small part of
/// a unit.
const SPREAD: f64 = (1_u64 << 28) as f64;

/// Clips a triangle and appends the result to `clipped`. Returns `false` if the result would be inaccurate or there is
/// no room. The result is empty if a vertex is not finite.
pub(super) fn clip(
    frame: &Frame,
    positions: [[f32; 3]; 3],
    number: u32,
    part: &mut Clipper,
    clipped: &mut Queue<3>,
) -> bool {
    if !positions.as_flattened().iter().all(|value| value.is_finite()) {
        return true;
    }
    let corners = positions.map(|position| frame.transform(position));
    let Some((near, entry)) = frame.clips else {
        return false;
    };
    // A face that ends at the near plane is not drawn, so it must not occlude either.
    if corners.iter().all(|corner| corner.z <= near) {
        return true;
    }
    let reach = corners.iter().fold(0.0_f64, |reach, corner| {
        reach.max(corner.x.abs() + corner.y.abs() + corner.z.abs())
    });
    let [x, y] = frame.middle;
    let guards = [
        DVec3::new(1.0, 0.0, GUARD - x),
        DVec3::new(-1.0, 0.0, GUARD + x),
        DVec3::new(0.0, 1.0, GUARD - y),
        DVec3::new(0.0, -1.0, GUARD + y),
    ];
    let planes = [(DVec3::Z, near)]
        .into_iter()
        .chain(entry)
        .chain(guards.map(|guard| (guard, 0.0)));
    let left = part.clipped(&corners, planes);
    // Written so that NaN fails too.
    let is_good = |corner: &DVec3| corner.z < DEEPEST && reach < SPREAD * corner.z;
    if !left.iter().all(is_good) || clipped.room() + 2 < left.len() {
        return false;
    }
    let fields = |corner: &DVec3| {
        let rev_depth = 1.0 / corner.z;
        let place = |at: f64, middle: f64| {
            let units = (at * rev_depth - middle) * f64::from(ONE);
            (units + TO_INTEGER).to_bits() as u32
        };
        [
            place(corner.x, x),
            place(corner.y, y),
            (rev_depth as f32).to_bits(),
        ]
    };
    for last in 2..left.len() {
        clipped.push_one([0, last - 1, last].map(|corner| fields(&left[corner])), number);
    }
    true
}
