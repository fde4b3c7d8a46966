//! The secret passage from the gallery to the library: a one-way portal through a bookcase, which from the library is
//! an ordinary bookcase.

use super::doors::Gate;
use super::floor::{Floor, paving};
use super::open;
use super::palette::*;
use super::room::{Design, Room, Style, arched, shift, spot};
use super::{case, ceiling, light};
use crate::envelope::{Axis, Ceiling, Plan, Side};
use crate::shape::{Shape, block, surround};
use enfilade::{OpeningId, Transform};

pub(crate) const DESIGN: Design = Design {
    name: "Secret Passage",
    plan: Plan::Rectangle([-9.4, -7.45], [-91.0, -81.9]),
    height: 2.5,
    ceiling: Ceiling::Vault(Axis::NorthSouth, 0.7),
    style: Style {
        floor: Floor::Octagons(0.5, [TERRACOTTA, STONE, DARK_STONE]),
        trim: DARK_STONE,
        gilt: OLD_GOLD,
        dado: STONE,
        wall: ASHLAR,
        field: STONE,
        ceiling: PALE_STONE,
        reveal: OAK,
    },
};

/// The exit, at the library's wall.
const OUT: Gate = Gate {
    looks: Side::East,
    at: [-7.0, -88.35],
    width: 1.36,
    sill: 0.0,
    spring: 2.3,
    rise: 0.0,
};

/// Returns the transform from the passage into the library, in front of the bookcase at its wall.
pub(super) fn library_from_here() -> Transform {
    shift(0.95, 0.0, 0.0)
}

/// Cuts the exit; no portal leads back.
pub(super) fn way_out(room: &mut Room) -> OpeningId {
    open(room, "behind the bookcase", &OUT, true)
}

/// Bare masonry, the bookcase's back, and a few forgotten items.
pub(super) fn furnish(room: &mut Room) {
    let frame = room.shop.piece("jib frame".to_owned(), || {
        let outline = arched(OUT.width, 0.0, OUT.spring, 0.0);
        let path: Vec<_> = outline[1..].iter().chain(&outline[..1]).copied().collect();
        let mut shape = surround(
            OAK,
            &path,
            false,
            &[[0.0, -0.01], [0.0, 0.05], [0.13, 0.05], [0.13, 0.0]],
        );
        // Hinges and a bar, as on the back of a door.
        for up in [0.5, 1.75] {
            shape.join(block(IRON, [0.66, up, 0.05], [0.8, up + 0.06, 0.075]));
        }
        shape
    });
    let wall = room.wall(Side::East);
    let along = wall.along(glam::Vec2::from(OUT.at));
    room.put("jib frame", &frame, wall.at(along, 0.0));
    ceiling::ribs(room, DARK_STONE, 0.3, 0.1, &[0.3, 2.6, 4.8, 7.9]);
    for (side, along) in [(Side::West, 2.1), (Side::West, 6.9), (Side::East, 6.4)] {
        let place = room.wall(side).at(along, 1.75);
        light::sconce(room, place, IRON);
    }
    let chest = case::chest(room.shop, WALNUT, IRON);
    room.put("chest", &chest, spot(-9.05, -85.6, 90.0));
    let books = room.shop.piece("forgotten books".to_owned(), || {
        let mut shape = Shape::new();
        let bindings = [DARK_RED, GREEN_SILK, NIGHT_BLUE, OAK];
        for (i, binding) in bindings.into_iter().enumerate() {
            let [low, turn] = [0.055 * i as f32, 0.35 * i as f32 - 0.4];
            let book = block(binding, [-0.17, low, -0.12], [0.17, low + 0.05, 0.12]);
            shape.add(&book, Transform::rotation([0.0, 1.0, 0.0], f64::from(turn)));
        }
        shape
    });
    room.put("books", &books, spot(-7.85, -90.5, 20.0));
    room.put("books", &books, spot(-8.3, -90.7, -50.0));
    let floor = paving(room.design.plan, room.design.style.floor, DARK_STONE, 0.12);
    room.make("paving", &floor);
}
