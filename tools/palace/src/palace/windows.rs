//! Windows: panes, bars and curtains in openings that are not doors.

use super::drapery::{self, LACE_STAND, ROD_STAND};
use super::lamps::Lamp;
use super::palette::{GOLD, IVORY, LACE};
use super::room::{Doorway, Room, arched, shift};
use crate::shape::{Shape, block, surround};
use enfilade::{MaterialId, Transform};
use glam::{Vec3, vec3};

/// Depth of panes and bars in the wall.
const DEEP: f32 = -0.3;

/// Glazes all windows of a room, adds curtains beside them, and one light for the sky, as if all of it came through the
/// middle window.
pub(crate) fn glaze(room: &mut Room, glass: MaterialId, cloth: MaterialId) {
    let windows: Vec<Doorway> = (room.doorways.iter())
        .filter(|door| door.sill > 0.0)
        .copied()
        .collect();
    if let Some(middle) = windows.get(windows.len() / 2) {
        let place = room.walls()[middle.wall].at(middle.along, 2.4);
        let sky = Lamp::daylight(place.point([0.0, 0.0, 2.4]), [1.5, 1.9, 2.4], 9.0);
        room.lamps.push(sky);
    }
    for window in windows {
        let frame = room.walls()[window.wall].at(window.along, 0.0);
        sash(room, &window, glass);
        let rod = window.spring + window.rise + 0.35;
        let reach = 0.5 * window.width + beside(room, &window);
        let [heavy, light] = [
            drapery::curtain(room.shop, 0.92 * reach - 0.2, rod - 0.12, cloth, GOLD),
            drapery::curtain(room.shop, 0.92 * reach - 0.08, rod - 0.2, LACE, IVORY),
        ];
        let swags = drapery::swags(room.shop, 2.0 * reach, 3, ROD_STAND, cloth, GOLD);
        room.put("swags", &swags, frame * shift(-reach, rod, ROD_STAND));
        for side in [-1.0, 1.0] {
            let mirrored = Transform::scaling([side, 1.0, 1.0]);
            let outer = frame * shift(-reach * side, 0.1, ROD_STAND) * mirrored;
            room.put("curtain", &heavy, outer);
            let inner = frame * shift((0.09 - reach) * side, 0.192, LACE_STAND) * mirrored;
            room.put("lace", &light, inner);
        }
    }
}

/// Returns the width of the curtains beside a window: up to the outer edge of its frame and a little more, but so that
/// the rod ends before the next window's and before the corner of the room.
fn beside(room: &Room, window: &Doorway) -> f32 {
    const USUAL: f32 = 0.38;
    const APART: f32 = 0.04;
    let [from, to] = window.reach(0.0);
    let wall = room.walls()[window.wall].length();
    let neighbours = room
        .doorways
        .iter()
        .filter(|other| other.wall == window.wall && other.along != window.along)
        .map(|other| {
            let [left, right] = other.reach(0.0);
            0.5 * (left - to).max(from - right)
        });
    let free = neighbours.fold(from.min(wall - to), f32::min);
    (free - drapery::ROD_END - APART).min(USUAL)
}

/// Panes and bars in a window.
pub(crate) fn sash(room: &mut Room, window: &Doorway, glass: MaterialId) {
    let frame = room.walls()[window.wall].at(window.along, 0.0);
    let Doorway {
        width,
        sill,
        spring,
        rise,
        ..
    } = *window;
    let kind = format!("{width} {sill} {spring} {rise} {}", glass.0);
    let pane = room
        .shop
        .piece(format!("window panes {kind}"), || panes(window, glass));
    let bar = room.shop.piece(format!("window bars {kind}"), || bars(window));
    room.put("window panes", &pane, frame);
    room.put("window bars", &bar, frame);
}

fn panes(window: &Doorway, glass: MaterialId) -> Shape {
    let outline: Vec<Vec3> = arched(window.width, window.sill, window.spring, window.rise)
        .into_iter()
        .map(|at| at.extend(DEEP))
        .collect();
    let mut shape = Shape::new();
    shape.face(glass, &outline);
    shape
}

/// A frame, a post in the middle, lighter ones beside it, and rungs up to where the arch begins.
fn bars(window: &Doorway) -> Shape {
    let Doorway {
        width,
        sill,
        spring,
        rise,
        ..
    } = *window;
    let outline = arched(width, sill, spring, rise);
    let mut shape = surround(
        IVORY,
        &outline,
        true,
        &[[-0.07, DEEP - 0.03], [-0.07, DEEP + 0.03], [0.0, DEEP + 0.03]],
    );
    let mut bar = |from: [f32; 2], to: [f32; 2], half: f32| {
        let [low, high] = [
            vec3(from[0], from[1], DEEP - half),
            vec3(to[0], to[1], DEEP + half),
        ];
        shape.join(block(IVORY, low.into(), high.into()));
    };
    bar([-0.035, sill], [0.035, spring + rise], 0.02);
    let reach = 0.5 * width - 0.03;
    let rungs = ((spring - sill) / 0.76).round().max(1.0);
    for rung in 1..=rungs as usize {
        let up = sill + (spring - sill) * rung as f32 / rungs - 0.045;
        bar([-reach, up], [reach, up + 0.045], 0.015);
    }
    for x in [-0.25 * width, 0.25 * width] {
        bar([x - 0.018, sill + 0.05], [x + 0.018, spring - 0.05], 0.01);
    }
    shape
}
