//! A fake painting in the picture room: its frame is a portal into the court.

use super::picture::gilded_frame;
use super::room::{Room, shift};
use crate::envelope::Side;
use enfilade::{OpeningId, Transform};
use glam::vec2;

/// Width and height, and height above the floor.
const SIZE: [f32; 2] = [3.4, 2.5];
const FOOT: f32 = 1.35;
/// Depth of the hole behind the frame.
const DEEP: f32 = 0.04;

/// Adds it to the middle of the eastern wall.
pub(super) fn hang(room: &mut Room) -> OpeningId {
    let wall = room.design.plan.wall(Side::East);
    let along = 0.5 * room.walls()[wall].length();
    let half = 0.5 * SIZE[0];
    let outline = [
        (-half, FOOT),
        (half, FOOT),
        (half, FOOT + SIZE[1]),
        (-half, FOOT + SIZE[1]),
    ];
    let outline = outline.map(|(x, y)| vec2(x, y));
    let gilt = room.design.style.gilt;
    let far = room.cut(wall, along, &outline, DEEP, None, gilt);
    let border = gilded_frame(room, SIZE, gilt);
    let place = room.walls()[wall].at(along - half, FOOT);
    room.put("picture frame", &border, place);
    room.opening("living picture", &far)
}

/// Returns the transform from the picture room into the court: above its northern end, looking down along its middle
/// path, because a viewer of a wall painting sees its horizon low.
pub(super) fn court_from_here() -> Transform {
    let middle = [6.55 + DEEP, FOOT + 0.5 * SIZE[1], -98.0];
    shift(-28.0, 5.2, -73.4)
        * Transform::rotation([0.0, 1.0, 0.0], -0.5 * std::f64::consts::PI)
        * Transform::rotation([0.0, 0.0, 1.0], -0.19)
        * shift(-middle[0], -middle[1], -middle[2])
}
