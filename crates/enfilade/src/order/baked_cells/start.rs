//! Which cells the lines of sight of a passage begin in.
//!
//! Not where the eye is: what is nearer than the near limit neither is seen nor hides, so that lines begin at the near limit;
//! and behind a portal, at its opening. There the eye's image may be anywhere, also in a cell that has nothing to do with it.

use crate::geometry::{BakedCells, CellId, Leaf, Room};
use crate::passage::Passage;
use glam::DVec3;
use smallvec::SmallVec;

/// By how much an opening must be farther away than the near limit for all lines to begin at it.
const FARTHER: f64 = 1.0 + 1e-6;

/// Tells the cells in which lines of sight begin, some more than once; `false` where some may begin in no cell, or one cannot
/// say: then anything may be seen.
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
            // An opening may lie in a wall that has no cell behind it: lines leave it at once.
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
    if begins_at_near(passage) {
        let from_screen = passage.screen_from_sector.inverse();
        let outline = near_outline(passage);
        room.outline(outline.iter().map(|&place| from_screen.transform_point3(place)));
        if !begin_in(room, true) {
            return false;
        }
    }
    any
}

/// Does any line of sight begin at the near limit, and not at an opening beyond it?
fn begins_at_near(passage: &Passage) -> bool {
    let Some(entrance) = &passage.entrance else {
        return true;
    };
    let along = |corner: &DVec3| passage.screen_from_sector.transform_point3(*corner).z;
    let limit = f64::from(passage.near) * FARTHER;
    // What is no number is not farther.
    !entrance.corners().iter().all(|corner| along(corner) > limit)
}

/// What the passage sees of the plane at the near limit, as (X, Y, W); nothing where all of that is before an opening.
fn near_outline(passage: &Passage) -> SmallVec<[DVec3; 8]> {
    // A sample may be anywhere in its pixel, and a pixel more does no harm.
    let rect = passage.aperture.rect();
    let [x0, y0] = [rect.x0, rect.y0].map(|first| f64::from(first) - 1.0);
    let [x1, y1] = [rect.x1, rect.y1].map(|end| f64::from(end) + 1.0);
    let near = f64::from(passage.near);
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, 1.0) * near);
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
