//! The pavilion: a round temple on the knoll, eight columns under a dome of copper.

use super::KNOLL;
use super::ground::Ground;
use crate::palace::column;
use crate::palace::palette::*;
use crate::palace::room::{Room, shift};
use crate::palace::statue::{self, Pose};
use crate::shape::{Shape, around, ball, lathe};
use enfilade::Transform;
use glam::{Vec3, vec3};
use std::f64::consts::{FRAC_PI_4, FRAC_PI_8};

/// Height of its floor above the ground, height of its columns, and their distance from its middle.
pub(super) const FLOOR: f32 = 0.54;
const COLUMNS: f32 = 4.2;
const RING: f32 = 3.6;

pub(super) fn build(room: &mut Room, ground: &Ground) {
    let place = Transform::translation(ground.on(KNOLL).into());
    let body = room.shop.piece("pavilion".to_owned(), || {
        let mut shape = steps();
        shape.join(roof());
        shape
    });
    room.put("pavilion", &body, place);
    let shaft = column::plain_column(room.shop, COLUMNS, WHITE_MARBLE, PALE_STONE);
    for i in 0..8 {
        // The gaps between columns face the four directions.
        let turn = Transform::rotation([0.0, 1.0, 0.0], FRAC_PI_8 + FRAC_PI_4 * f64::from(i));
        room.put("pavilion column", &shaft, place * turn * shift(RING, FLOOR, 0.0));
    }
    let base = column::pedestal(room.shop, 0.8, 1.1, PALE_STONE, STONE);
    let statue = statue::figure(room.shop, Pose::Torch, WHITE_MARBLE, GOLD);
    let turn = Transform::rotation([0.0, 1.0, 0.0], 2.0 * FRAC_PI_4);
    // At the back, so that it does not block the view from the middle to the palace.
    room.put("pedestal", &base, place * shift(-2.6, FLOOR, 0.0) * turn);
    room.put("statue", &statue, place * shift(-2.6, FLOOR + 1.1, 0.0) * turn);
}

/// Three steps all around, and an inlaid floor on them.
fn steps() -> Shape {
    const SIDES: usize = 48;
    let profile = [
        [5.3, -0.6],
        [5.3, 0.18],
        [4.9, 0.18],
        [4.9, 0.36],
        [4.5, 0.36],
        [4.5, FLOOR],
        [4.1, FLOOR],
    ];
    let mut shape = lathe(PALE_STONE, &profile, SIDES);
    let floor: Vec<Vec3> = around(SIDES)
        .map(|at| vec3(4.1 * at.x, FLOOR, 4.1 * at.y))
        .collect();
    shape.face(INLAID_MARBLE, &floor);
    shape
}

/// The entablature, visible from outside and inside.
fn roof() -> Shape {
    let foot = FLOOR + COLUMNS;
    let over = |profile: &[[f32; 2]]| -> Vec<[f32; 2]> {
        profile.iter().map(|&[out, up]| [out, foot + up]).collect()
    };
    let dome = |radius: f32, from: f32, high: f32| -> Vec<[f32; 2]> {
        (0..=12)
            .map(|i| {
                let (sin, cos) = (0.5 * std::f64::consts::PI * f64::from(i) / 12.0).sin_cos();
                let out = if i == 12 { 0.0 } else { radius * cos as f32 };
                [out, foot + from + high * sin as f32]
            })
            .collect()
    };
    let entablature = [
        [3.3, 0.0],
        [3.92, 0.0],
        [3.92, 0.22],
        [3.97, 0.24],
        [3.97, 0.46],
        [3.88, 0.48],
        [3.88, 0.86],
        [4.0, 0.92],
        [4.3, 0.98],
        [4.36, 1.1],
        [4.42, 1.14],
        [4.0, 1.2],
        [3.7, 1.2],
        [3.7, 1.45],
        [3.62, 1.45],
    ];
    let mut shape = lathe(PALE_STONE, &over(&entablature), 64);
    shape.join(lathe(VERDIGRIS, &dome(3.62, 1.45, 2.5), 64));
    let inner = over(&[[3.3, 0.0], [3.3, 0.5], [3.22, 0.56], [3.22, 0.7]]);
    shape.join(lathe(WHITE_MARBLE, &inner, 64).flipped());
    shape.join(lathe(PALE_BLUE, &dome(3.22, 0.7, 2.7), 64).flipped());
    let tip = foot + 3.95;
    let finial = [
        [0.3, tip - 0.06],
        [0.3, tip + 0.06],
        [0.1, tip + 0.2],
        [0.08, tip + 0.5],
    ];
    shape.join(lathe(VERDIGRIS, &finial, 16));
    shape.add(&ball(GOLD, 0.24, 10, 16), shift(0.0, tip + 0.66, 0.0));
    shape
}
