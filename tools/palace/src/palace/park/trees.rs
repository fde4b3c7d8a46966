//! Woods, rows of trees and single ones; long grass and wild flowers.

use super::ground::{Ground, to_the_basin, to_the_edge};
use super::{AXIS, KNOLL};
use crate::palace::crown::{Habit, grown};
use crate::palace::palette::{
    DARK_BOUGHS, DARK_LEAVES, IVORY, LONG_GRASS, PALE_BOUGHS, PALE_LEAVES, RED_SILK, YELLOW_SILK,
};
use crate::palace::room::{Room, scaled};
use crate::palace::rooms::court::flower_bed;
use crate::shape::Shape;
use enfilade::{Mesh, Transform};
use enfilade_scenes::Random;
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Trees of the woods, one metre tall.
const TREE: Habit = Habit {
    kind: "lime",
    boughs: PALE_BOUGHS,
    leaves: PALE_LEAVES,
    crown: [0.27, 0.31],
    middle: 0.62,
    masses: 11,
    mass: 0.105,
    cards: 72,
    card: 0.080,
    trunk: 0.026,
    branches: 2,
    faces: 108,
    per_length: 7.0,
};

/// The kinds of trees; the last one is slim.
const HABITS: [Habit; 4] = [
    TREE,
    Habit {
        kind: "oak",
        crown: [0.37, 0.26],
        middle: 0.66,
        masses: 13,
        mass: 0.12,
        card: 0.090,
        trunk: 0.032,
        ..TREE
    },
    Habit {
        kind: "beech",
        boughs: DARK_BOUGHS,
        leaves: DARK_LEAVES,
        crown: [0.30, 0.32],
        ..TREE
    },
    Habit {
        kind: "poplar",
        boughs: DARK_BOUGHS,
        leaves: DARK_LEAVES,
        crown: [0.085, 0.40],
        middle: 0.55,
        masses: 12,
        mass: 0.056,
        card: 0.056,
        trunk: 0.018,
        branches: 0,
        ..TREE
    },
];

/// Woods on the hills at the edges, rows of trees beside the lawn, single ones in between.
pub(super) fn plant(room: &mut Room, ground: &Ground) {
    let kinds = [0, 1, 2, 3].map(|kind| grown(room.shop, &HABITS[kind], 60 + kind as u64));
    let mut random = Random::new(177);
    let mut trees: Vec<Vec2> = Vec::new();
    for _ in 0..2600 {
        let at = vec2(random.between(-118.0, -9.0), random.between(-175.0, -94.0));
        let edge = to_the_edge(at);
        let in_the_wood = edge > 1.2 && edge < 15.0 + 4.0 * (0.2 * (at.x + at.y)).sin();
        let apart = if edge < 9.0 { 3.6 } else { 5.0 };
        if !in_the_wood || is_cleared(at) || trees.iter().any(|tree| tree.distance(at) < apart) {
            continue;
        }
        trees.push(at);
    }
    for at in SINGLE.map(Vec2::from) {
        trees.push(at);
    }
    for (number, at) in trees.into_iter().enumerate() {
        let kind = [0, 1, 2, 1, 3, 0, 2][number % 7];
        let tall = random.between(6.5, 9.5) + if kind == 3 { 2.5 } else { 0.0 };
        let turn = random.between(0.0, 360.0);
        stand(room, "tree of the wood", &kinds[kind], ground.on(at), turn, tall);
    }
    for side in [-1.0, 1.0] {
        for i in 0..6 {
            let at = vec2(-31.0 - 8.5 * i as f32, AXIS + 13.5 * side);
            let (turn, tall) = (random.between(0.0, 360.0), random.between(5.6, 6.4));
            stand(room, "tree of the walk", &kinds[0], ground.on(at), turn, tall);
        }
    }
    long_grass(room, ground);
    wild_flowers(room, ground);
}

/// Solitary trees in the meadows: x and z.
const SINGLE: [[f32; 2]; 14] = [
    [-36.0, -140.0],
    [-44.5, -136.5],
    [-58.0, -139.0],
    [-66.0, -152.0],
    [-72.0, -136.0],
    [-84.0, -140.5],
    [-95.0, -135.0],
    [-100.0, -124.5],
    [-101.5, -109.0],
    [-90.0, -99.5],
    [-80.5, -101.0],
    [-68.0, -104.0],
    [-33.0, -154.0],
    [-48.0, -157.0],
];

/// Returns `true` for positions kept clear of trees: the views along the axis and from the hill, and the strip along
/// the walls.
fn is_cleared(at: Vec2) -> bool {
    let view = HILL_VIEW[1] - HILL_VIEW[0];
    let off = at - HILL_VIEW[0];
    let part = off.dot(view) / view.length_squared();
    let beside = off.perp_dot(view).abs() / view.length();
    let in_view = part > -0.05 && beside < 3.0 + 14.0 * part.max(0.0);
    // Crowns must not extend beyond the walls.
    let at_the_walls = at.x > -14.5 || at.y > -98.5;
    in_view || at_the_walls || at.distance(KNOLL) < 10.0
}

/// A viewpoint above the garden, and its target.
const HILL_VIEW: [Vec2; 2] = [vec2(-104.0, -158.0), vec2(-60.0, -122.0)];

fn stand(room: &mut Room, thing: &str, mesh: &Arc<Mesh>, at: Vec3, degrees: f32, size: f32) {
    let turned = Transform::rotation([0.0, 1.0, 0.0], f64::from(degrees).to_radians());
    room.put(
        thing,
        mesh,
        Transform::translation(at.into()) * turned * scaled(size),
    );
}

/// Tufts of long grass in the meadows, grouped by squares.
fn long_grass(room: &mut Room, ground: &Ground) {
    const SQUARE: f32 = 14.0;
    let mut random = Random::new(523);
    for row in 0..4 {
        for column in 0..6 {
            let corner = vec2(-112.0 + SQUARE * column as f32, -166.0 + SQUARE * row as f32);
            let mut shape = Shape::new();
            let mut tufts = 0;
            for _ in 0..150 {
                let at = corner + SQUARE * vec2(random.unit(), random.unit());
                let [turn, high] = [random.unit(), random.between(0.28, 0.6)];
                let mown = (at.y - AXIS).abs() < 17.0 || at.x > -30.0 || at.distance(KNOLL) < 14.0;
                if mown || to_the_basin(at) < 1.3 {
                    continue;
                }
                tuft(&mut shape, ground.on(at), turn, high);
                tufts += 1;
            }
            if tufts > 0 {
                room.make("long grass", &shape);
            }
        }
    }
}

/// Flowers in the valley.
fn wild_flowers(room: &mut Room, ground: &Ground) {
    let mut random = Random::new(811);
    let colors = [RED_SILK, YELLOW_SILK, IVORY];
    for number in 0..14 {
        let at = vec2(random.between(-84.0, -52.0), AXIS - random.between(22.0, 33.0));
        let color = colors[number % 3];
        let patch = flower_bed(room.shop, color);
        stand(
            room,
            "wild flowers",
            &patch,
            ground.on(at) - Vec3::Y * 0.08,
            random.between(0.0, 360.0),
            1.1,
        );
    }
}

/// Two intersecting cards.
fn tuft(shape: &mut Shape, at: Vec3, turn: f32, high: f32) {
    for quarter in [0.0, 0.25] {
        let (sin, cos) = (TAU * f64::from(turn + quarter)).sin_cos();
        let along = vec3(cos as f32, 0.0, sin as f32) * high;
        let [foot, top] = [at - Vec3::Y * 0.04, at + Vec3::Y * high];
        shape.placed(
            LONG_GRASS,
            &[foot - along, foot + along, top + along, top - along],
            &[vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)],
        );
    }
}
