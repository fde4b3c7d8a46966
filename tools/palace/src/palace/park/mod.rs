//! The garden before the last rooms of the enfilade: terrain, woods, a basin, and a pavilion. Pavilion and windows are
//! visible from each other.

mod facade;
mod ground;
mod parterre;
mod pavilion;
mod trees;

use super::palette::*;
use super::plan::{HALF, STONEWORK, WALL};
use super::room::{Design, Room, Style};
use super::rooms::gardens::under_the_sky;
use crate::envelope::{Ceiling, Plan, Side};
use glam::{Vec2, vec2};
use ground::Ground;

/// Extent of its walls; the terrain is larger.
pub(crate) const GARDEN: Design = Design {
    name: "Garden",
    plan: Plan::Rectangle([-66.0, -HALF - WALL], [-162.0, -92.0 - WALL]),
    height: facade::HEIGHT,
    ceiling: Ceiling::Sky,
    style: Style {
        wall: PALE_ASHLAR,
        trim: GRAVEL,
        reveal: PALE_STONE,
        ..STONEWORK
    },
};

/// The sides that have walls.
pub(crate) const WALLS: [Side; 2] = [Side::East, Side::South];

/// Axis of the middle window of the throne room, as z.
const AXIS: f32 = -117.02;
/// Positions of the pavilion and the basin; x and z.
const KNOLL: Vec2 = vec2(-90.0, AXIS);
const BASIN: Vec2 = vec2(-52.0, AXIS);
const BASIN_RADII: Vec2 = vec2(12.0, 7.5);

/// Builds the ground and everything on it.
pub(crate) fn furnish(room: &mut Room) {
    under_the_sky(room);
    let ground = Ground::new();
    ground.lay(room);
    facade::build(room);
    parterre::build(room, &ground);
    pavilion::build(room, &ground);
    trees::plant(room, &ground);
}
