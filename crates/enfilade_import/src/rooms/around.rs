//! Finds the room that contains a point, by AABBs, for nodes outside every marked room.

use super::sky::{by_size, space};
use crate::Room;
use enfilade::SectorId;

/// Returns the room with the smallest AABB that contains a point. The AABB of a room without a ceiling extends upwards
/// without bound.
pub(crate) fn room_around(rooms: &[Room], point: [f32; 3]) -> Option<SectorId> {
    let numbered = (0_u32..).zip(rooms);
    numbered
        .map(|(number, room)| (SectorId(number), space(&room.geometry, room.open_above)))
        .filter(|(_, bounds)| bounds.contains(point))
        .min_by(|(a, one), (b, other)| by_size(one, other).then(a.cmp(b)))
        .map(|(room, _)| room)
}

/// Returns the room whose AABB is nearest to a point.
pub(crate) fn room_nearest(rooms: &[Room], point: [f32; 3]) -> Option<SectorId> {
    let away = |number: &u32| -> f64 {
        let bounds = rooms[*number as usize].geometry.bounds();
        let beyond = |axis: usize| (bounds.min[axis] - point[axis]).max(point[axis] - bounds.max[axis]);
        (0..3).map(|axis| f64::from(beyond(axis).max(0.0)).powi(2)).sum()
    };
    let numbers = 0..rooms.len() as u32;
    let nearest = numbers.min_by(|a, b| away(a).total_cmp(&away(b)).then(a.cmp(b)));
    nearest.map(SectorId)
}
