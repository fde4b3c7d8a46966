//! Triangles of which a corner cannot be put on the screen, cut to what can.
//!
//! What is left of a triangle beyond the near distance, beyond the last portal and not far off the screen has corners on the
//! screen, and goes on as triangles like others. Its new edges are those by which the exact covers bound it, or off the
//! screen; the others only end elsewhere. What a new corner may be off by is far less than a unit of fixed point, which is
//! what those who set up triangles expect of all corners anyway.
//! Source: Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974.
//! Cost: O(planes · corners), one triangle after the other: few cross anything.
//! Exact: a corner that could be off by more leaves its triangle to f64.

use super::corners::{DEEPEST, FARTHEST, TO_INTEGER};
use super::queue::Queue;
use super::{Frame, ONE};
use crate::cover::part::Part;
use glam::DVec3;

/// What is kept of triangles ends so far from the frame's middle, in pixels: a little before where corners become odd.
const GUARD: f64 = FARTHEST / ONE as f64 - 64.0;

/// A corner that was cut is off by no more than a small part of a unit where the triangle reaches less than so many times as
/// far as the corner is away.
const SPREAD: f64 = (1_u64 << 28) as f64;

/// Puts what is left of a triangle into `clipped`; `false` where that cannot be told well enough, or there is no room.
/// Nothing is left of one with a corner that is no number.
pub(super) fn clip(
    frame: &Frame,
    positions: [[f32; 3]; 3],
    number: u32,
    part: &mut Part,
    clipped: &mut Queue<3>,
) -> bool {
    if !positions.as_flattened().iter().all(|value| value.is_finite()) {
        return true;
    }
    let corners = positions.map(|position| frame.on_screen(position));
    let Some((near, entry)) = frame.clips else {
        return false;
    };
    // What ends at the near distance is not drawn, so it must not hide either.
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
    // Also where something is no number.
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
