//! Furnishes the rooms.

mod arts;
mod cabinets;
pub(crate) mod court;
mod gallery;
pub(crate) mod gardens;
mod salons;
mod state;
mod throne_room;

use super::ceiling::Coffering;
use super::drapery::Rug;
use super::head::Hair;
use super::lamps::Lamp;
use super::palette::*;
use super::plan::Name;
use super::room::{PAVING, Room, arched, scaled, shift, spot};
use super::statue::Pose;
use super::trim::{cornice, dress};
use super::{
    case, ceiling, column, drapery, floor, garden, hearth, light, ornament, park, picture, seat, secret,
    statue, table, windows,
};
use crate::envelope::{Ceiling, Side, inwards};
use crate::shape::{Shape, band, block, cuboid, fluted, lathe, moulding, prism, surround};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Adds a room's items, then decorates its walls around them.
pub(crate) fn furnish(room: &mut Room, name: Name) {
    let (furnish, border): (fn(&mut Room), MaterialId) = match name {
        Name::Vestibule => (state::vestibule, STONE),
        Name::GuardRoom => (state::guard_room, DARK_STONE),
        Name::RedSalon => (salons::red_salon, MAHOGANY),
        Name::GreenSalon => (salons::green_salon, WALNUT),
        Name::Rotunda => (state::rotunda, GREEN_MARBLE),
        Name::BlueSalon => (salons::blue_salon, WALNUT),
        Name::MirrorRoom => (salons::mirror_room, BLACK_MARBLE),
        Name::MusicRoom => (arts::music_room, MAHOGANY),
        Name::Library => (arts::library, EBONY),
        Name::PictureRoom => (arts::picture_room, WALNUT),
        Name::Antechamber => (state::antechamber, RED_MARBLE),
        Name::ThroneRoom => (throne_room::throne_room, RED_MARBLE),
        Name::Gallery => (gallery::gallery, GREEN_MARBLE),
        Name::Court => {
            court::court(room);
            return;
        }
        Name::PorcelainCabinet => (cabinets::porcelain_cabinet, COBALT),
        Name::Chapel => (cabinets::chapel, BLACK_MARBLE),
        Name::WinterGarden => (cabinets::winter_garden, VERDIGRIS),
        Name::Study => (cabinets::study, EBONY),
        Name::Treasury => (cabinets::treasury, DARK_STONE),
        Name::SecretPassage => {
            secret::furnish(room);
            return;
        }
        Name::Terrace => {
            gardens::terrace(room);
            return;
        }
        Name::Garden => {
            park::furnish(room);
            return;
        }
        // Rooms outside the plan's list are built elsewhere.
        _ => return,
    };
    furnish(room);
    finish(room, border);
}

/// Paves a furnished room and decorates its walls.
pub(crate) fn finish(room: &mut Room, border: MaterialId) {
    let design = room.design;
    let size = 0.1 * design.height.min(6.4);
    dress(room, design.height, size);
    if let Ceiling::Cove(inset, rise) = design.ceiling {
        // A second, lighter cornice where the cove ends.
        let inner = inwards(&design.plan.corners(), inset - 0.02);
        cornice(room, &inner, design.height + rise, 0.5 * size);
    }
    let paving = floor::paving(design.plan, design.style.floor, border, 0.35);
    room.make("paving", &paving);
}

/// Adds a mirror: a shallow hole in the wall, whose far end is an opening back into the room, and a gilded frame.
fn mirror(room: &mut Room, side: Side, along: f32, foot: f32, [wide, spring]: [f32; 2], rise: f32) {
    let gilt = room.design.style.gilt;
    let wall = room.design.plan.wall(side);
    let outline = arched(wide, foot, foot + spring, rise);
    let far = room.cut(wall, along, &outline, 0.03, None, gilt);
    let name = format!("mirror {}", room.mirrors.len() + 1);
    let opening = room.opening(&name, &far);
    room.mirrors.push(opening);
    const PROFILE: [[f32; 2]; 9] = [
        [0.0, -0.03],
        [0.0, 0.03],
        [0.03, 0.05],
        [0.05, 0.045],
        [0.08, 0.075],
        [0.12, 0.075],
        [0.14, 0.05],
        [0.16, 0.04],
        [0.16, 0.0],
    ];
    let frame = room.shop.piece(
        format!("mirror frame {wide} {foot} {spring} {rise} {}", gilt.0),
        || surround(gilt, &outline, true, &PROFILE),
    );
    room.hang("mirror frame", &frame, side, along, 0.0);
    room.take(wall, along - 0.5 * wide - 0.2, along + 0.5 * wide + 0.2);
}

/// Cuts an arched niche into a wall; returns the transform of its floor, facing the room.
fn niche(
    room: &mut Room,
    wall: usize,
    along: f32,
    foot: f32,
    [wide, spring, depth]: [f32; 3],
    lining: MaterialId,
) -> Transform {
    let outline = arched(wide, foot, foot + spring, 0.5 * wide);
    room.cut(wall, along, &outline, depth, Some(lining), lining);
    room.take(wall, along - 0.5 * wide - 0.25, along + 0.5 * wide + 0.25);
    const PROFILE: [[f32; 2]; 6] = [
        [0.0, 0.0],
        [0.0, 0.04],
        [0.04, 0.06],
        [0.12, 0.06],
        [0.16, 0.03],
        [0.16, 0.0],
    ];
    let style = room.design.style;
    let border = room.shop.piece(
        format!("niche border {wide} {foot} {spring} {}", style.trim.0),
        || surround(style.trim, &outline, true, &PROFILE),
    );
    let place = room.walls()[wall].at(along, 0.0);
    room.put("niche border", &border, place);
    place * shift(0.0, foot, -0.5 * depth)
}

/// Adds a painting with its middle `along` a wall, its lower edge `foot` above the floor.
fn painting(room: &mut Room, side: Side, along: f32, foot: f32, size: [f32; 2]) {
    let gilt = room.design.style.gilt;
    let place = room.wall(side).at(along - 0.5 * size[0], foot) * shift(0.0, 0.0, 0.04);
    picture::hang_painting(room, place, size, gilt);
}
