//! Finds rooms without a ceiling: gardens, courtyards, rooms whose ceiling is missing.
//!
//! Such a room extends upwards without bound, so an opening to the open sky leads into it, however far above its faces
//! the opening is. Up is +Y, as in glTF.
//! Vertical rays on a grid decide whether a room has a ceiling: a column is open if its highest face is the ground. No
//! portal may be above it, because the space above a portal belongs to the room on its other side.

use enfilade::{Aabb, ConvexPolygon, Geometry, Ray};
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Ordering;

/// Columns along each side of a room's AABB.
const COLUMNS: usize = 12;
/// Minimum fraction of open columns among those that hit the room: more than the balcony of a bedroom, less than a
/// garden with a house.
const OPEN: f64 = 0.3;
/// Maximum thickness of the ground, relative to the height of the room or to the shorter side of the ground: a slab,
/// not a storey.
const THICK: [f64; 2] = [1.0 / 8.0, 1.0 / 32.0];

/// Returns whether each room has no ceiling. `lids` are the outlines of all portals and mirrors.
pub(super) fn open_above(rooms: &[Geometry], lids: &[ConvexPolygon]) -> Vec<bool> {
    let is_open = |room: &Geometry| {
        let bounds = room.bounds();
        !bounds.is_empty() && {
            let near: Vec<&ConvexPolygon> = lids.iter().filter(|lid| is_over(lid, &bounds)).collect();
            has_no_top(room, &bounds, &near)
        }
    };
    rooms.par_iter().map(is_open).collect()
}

/// Returns the space of a room: its AABB, unbounded upwards if the room has no ceiling.
pub(crate) fn space(room: &Geometry, open_above: bool) -> Aabb {
    let mut space = room.bounds();
    if open_above && !space.is_empty() {
        space.max[1] = f32::INFINITY;
    }
    space
}

/// Compares spaces by volume; unbounded ones by their footprint.
pub(crate) fn by_size(a: &Aabb, b: &Aabb) -> Ordering {
    let ground = |space: &Aabb| sides(space)[0] * sides(space)[2];
    let volumes = a.volume().total_cmp(&b.volume());
    volumes.then(ground(a).total_cmp(&ground(b)))
}

fn sides(bounds: &Aabb) -> [f64; 3] {
    [0, 1, 2].map(|axis| f64::from(bounds.max[axis]) - f64::from(bounds.min[axis]))
}

fn is_over(lid: &ConvexPolygon, bounds: &Aabb) -> bool {
    let held = lid.bounds();
    [0, 2]
        .into_iter()
        .all(|axis| held.min[axis] <= bounds.max[axis] && bounds.min[axis] <= held.max[axis])
}

fn has_no_top(room: &Geometry, bounds: &Aabb, lids: &[&ConvexPolygon]) -> bool {
    let [width, height, depth] = sides(bounds);
    let thick = (THICK[0] * height).max(THICK[1] * width.min(depth));
    let outside = 0.1 * width.max(height).max(depth);
    let at = |axis: usize, column: usize| {
        f64::from(bounds.min[axis]) + sides(bounds)[axis] * (column as f64 + 0.5) / COLUMNS as f64
    };
    let [low, high] = [
        f64::from(bounds.min[1]) - outside,
        f64::from(bounds.max[1]) + outside,
    ];
    let (mut met, mut open) = (0, 0);
    for column in 0..COLUMNS * COLUMNS {
        let [x, z] = [at(0, column % COLUMNS), at(2, column / COLUMNS)];
        let cast = |y: f64, up: f64| {
            let ray = Ray {
                origin: DVec3::new(x, y, z).as_vec3().into(),
                direction: [0.0, up as f32, 0.0],
            };
            let hit = room.cast(&ray)?;
            Some((y + up * hit.distance, hit.from_behind))
        };
        let (Some((highest, is_ceiling)), Some((lowest, _))) = (cast(high, -1.0), cast(low, 1.0)) else {
            continue;
        };
        met += 1;
        let is_ground = !is_ceiling && highest - lowest <= thick;
        let ground = DVec3::new(x, highest, z);
        open += usize::from(is_ground && !lids.iter().any(|lid| is_below(ground, lid)));
    }
    open > 0 && f64::from(open as u32) >= OPEN * f64::from(met)
}

/// Returns `true` if the vertical ray up from a point hits a polygon.
fn is_below(point: DVec3, polygon: &ConvexPolygon) -> bool {
    let corner = |i: usize| {
        let corners = polygon.corners();
        DVec3::from(corners[i % corners.len()].map(f64::from))
    };
    let normal = DVec3::from(polygon.normal().map(f64::from));
    // A vertical polygon covers nothing below it.
    if normal.y.abs() < 1e-3 {
        return false;
    }
    let up = normal.dot(corner(0) - point) / normal.y;
    let met = point + DVec3::Y * up;
    up >= 0.0
        && (0..polygon.corners().len())
            .all(|i| normal.cross(corner(i + 1) - corner(i)).dot(met - corner(i)) >= 0.0)
}
