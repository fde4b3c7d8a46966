//! Finds the cells in which the lines of sight of a passage begin.
//!
//! That is not where the eye is. Geometry in front of the near plane is neither visible nor an occluder, so lines of
//! sight begin at the near plane, which may be oblique, or behind a portal at its opening. There the transformed eye may be anywhere, even in
//! an unrelated cell.

use crate::geometry::{BakedCells, Leaf, Room};
use crate::ids::CellId;
use crate::view::passage::Passage;
use glam::DVec3;
use smallvec::SmallVec;

/// Factor by which an opening must be farther away than the near plane for all lines of sight to begin at the opening.
const FARTHER: f64 = 1.0 + 1e-6;

/// Calls `each` with the cells in which lines of sight begin, some more than once. Returns `false` if some may begin in
/// no cell, or if that cannot be determined; then anything may be visible.
pub(super) fn cells_at_start(
    cells: &BakedCells,
    passage: &Passage,
    room: &mut Room,
    mut each: impl FnMut(CellId),
) -> bool {
    let mut any = false;
    let mut begin_in = |room: &mut Room, also_barely: bool| {
        cells.touched(cells.tree().root, room, |leaf| match leaf {
            Leaf::Cell(cell) => {
                any = true;
                each(cell);
                true
            }
            // An opening may be in a wall that has no cell behind it; lines of sight leave such a wall at once.
            Leaf::Solid { barely } => barely && !also_barely,
        })
    };
    if let Some(entrance) = &passage.entrance {
        let enters = match entrance.triangles() {
            Some(mut triangles) => triangles.all(|triangle| {
                room.outline(triangle);
                begin_in(room, false)
            }),
            None => {
                room.hull(entrance.corners().iter().copied());
                begin_in(room, false)
            }
        };
        if !enters {
            return false;
        }
    }
    if begins_at_near_plane(passage) {
        // In the near plane of a parallel view W is 1, so that (X, Y, W) is (column, row, reversed depth).
        let from_screen = passage.screen_from_sector.linear.inverse();
        let outline = match (&passage.entrance, passage.entry) {
            (None, Some(plane)) => match oblique_outline(passage, plane) {
                Some(outline) => outline,
                None => return false,
            },
            _ => near_outline(passage),
        };
        room.outline(outline.iter().map(|&place| from_screen.transform_point3(place)));
        if !begin_in(room, true) {
            return false;
        }
    }
    any
}

/// Returns `true` if any line of sight begins at the near plane and not at an opening beyond it.
fn begins_at_near_plane(passage: &Passage) -> bool {
    let Some(entrance) = &passage.entrance else {
        return true;
    };
    let along = |corner: &DVec3| passage.screen_from_sector.point(*corner).z;
    let limit = f64::from(passage.z_near) * FARTHER;
    // NaN is not farther.
    !entrance.corners().iter().all(|corner| along(corner) > limit)
}

/// Returns the corners of the rectangle that a passage sees, as (x, y, 1). A sample may be anywhere in its pixel; one pixel
/// more on each side is safe.
fn corners(passage: &Passage) -> [DVec3; 4] {
    let rect = passage.aperture.rect();
    let [x0, y0] = [rect.x0, rect.y0].map(|first| f64::from(first) - 1.0);
    let [x1, y1] = [rect.x1, rect.y1].map(|end| f64::from(end) + 1.0);
    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| DVec3::new(x, y, 1.0))
}

/// Returns the part of an oblique near plane that the passage sees, as a polygon of (X, Y, W); `None` if it is unbounded.
fn oblique_outline(passage: &Passage, (normal, distance): (DVec3, f64)) -> Option<SmallVec<[DVec3; 8]>> {
    let place = |corner: DVec3| {
        let along = normal.dot(corner);
        (along > 0.0).then(|| corner * (distance / along))
    };
    corners(passage).into_iter().map(place).collect()
}

/// Returns the part of the near plane that the passage sees, as a polygon of (X, Y, W); empty if all of it is in front
/// of the entry plane.
fn near_outline(passage: &Passage) -> SmallVec<[DVec3; 8]> {
    let corners = corners(passage).map(|corner| corner * f64::from(passage.z_near));
    let Some((normal, distance)) = passage.entry else {
        return SmallVec::from_slice(&corners);
    };
    let beyond = corners.map(|corner| normal.dot(corner) - distance / FARTHER);
    let mut left = SmallVec::new();
    for at in 0..corners.len() {
        let next = (at + 1) % corners.len();
        let [here, there] = [beyond[at], beyond[next]];
        if here >= 0.0 {
            left.push(corners[at]);
        }
        if (here < 0.0) != (there < 0.0) {
            left.push(corners[at] + (corners[next] - corners[at]) * (here / (here - there)));
        }
    }
    left
}
