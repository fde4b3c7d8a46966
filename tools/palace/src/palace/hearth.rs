//! A fireplace in a wall, with a fire in it.

use super::lamps::Lamp;
use super::palette::{BARK, CANDLE_FLAME, EBONY, GLOW, IRON};
use super::room::{Room, arched, shift};
use crate::envelope::Side;
use crate::shape::{Shape, ball, band, block, lathe, moulding};
use enfilade::{MaterialId, Transform};
use glam::{vec2, vec3};

/// Height of the mantel shelf.
pub(crate) const MANTEL: f32 = 1.28;

/// Cuts a hearth into the wall and builds its mantel; the stretch of wall above stays free for a mirror.
pub(crate) fn hearth(room: &mut Room, side: Side, along: f32, marble: MaterialId, gilt: MaterialId) {
    let wall = room.design.plan.wall(side);
    room.cut(
        wall,
        along,
        &arched(1.24, 0.06, 0.98, 0.0),
        0.36,
        Some(EBONY),
        IRON,
    );
    room.take(wall, along - 1.15, along + 1.15);
    let mantel = room
        .shop
        .piece(format!("mantel {} {}", marble.0, gilt.0), || mantel(marble, gilt));
    room.hang("mantel", &mantel, side, along, 0.0);
    let fire = room.shop.piece("fire".to_owned(), fire);
    room.hang("fire", &fire, side, along, 0.06);
    let glow = room.wall(side).at(along, 0.5).point([0.0, 0.0, 0.45]);
    room.lamps.push(Lamp::fire(glow));
}

fn mantel(marble: MaterialId, gilt: MaterialId) -> Shape {
    let mut shape = Shape::new();
    for side in [-1.0, 1.0] {
        let [left, right] = [side * 0.78 - 0.14, side * 0.78 + 0.14];
        shape.join(block(marble, [left, 0.0, 0.0], [right, 0.16, 0.20]));
        shape.join(block(marble, [left + 0.02, 0.16, 0.0], [right - 0.02, 1.0, 0.15]));
        shape.join(block(
            gilt,
            [left + 0.07, 0.28, 0.15],
            [right - 0.07, 0.88, 0.165],
        ));
        shape.join(block(marble, [left, 1.0, 0.0], [right, 1.16, 0.19]));
        let boss = lathe(gilt, &[[0.0, 0.0], [0.06, 0.0], [0.05, 0.02], [0.0, 0.03]], 16);
        let facing = Transform::rotation([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2);
        shape.add(&boss, shift(side * 0.78, 1.08, 0.19) * facing);
    }
    shape.join(block(marble, [-0.64, 0.98, 0.0], [0.64, 1.16, 0.14]));
    shape.join(block(gilt, [-0.42, 1.03, 0.14], [0.42, 1.11, 0.155]));
    const SHELF: [[f32; 2]; 8] = [
        [0.0, 0.0],
        [0.19, 0.0],
        [0.22, 0.03],
        [0.26, 0.05],
        [0.30, 0.06],
        [0.30, 0.10],
        [0.28, 0.12],
        [0.0, 0.12],
    ];
    let shelf = moulding(marble, &[vec2(-1.02, 0.0), vec2(1.02, 0.0)], false, 0.0, &SHELF);
    shape.add(&shelf, shift(0.0, 1.16, 0.0));
    shape.join(block(marble, [-1.05, 0.0, 0.0], [1.05, 0.04, 0.55]));
    shape
}

/// Logs on two firedogs, flames, embers, behind the wall's plane.
fn fire() -> Shape {
    let mut shape = Shape::new();
    let log = lathe(
        BARK,
        &[[0.0, 0.0], [0.05, 0.0], [0.055, 0.35], [0.045, 0.7], [0.0, 0.7]],
        9,
    );
    let lying = Transform::rotation([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2);
    for (x, y, z, turn) in [
        (0.36, 0.09, -0.12, 0.05),
        (0.34, 0.09, -0.24, -0.06),
        (0.30, 0.18, -0.18, 0.12),
    ] {
        shape.add(
            &log,
            shift(x, y, z) * Transform::rotation([0.0, 1.0, 0.0], turn) * lying,
        );
    }
    for i in 0..9 {
        let x = -0.32 + 0.08 * i as f32;
        shape.add(
            &ball(GLOW, 0.035, 6, 8),
            shift(x, 0.03, -0.10 - 0.04 * (i % 4) as f32),
        );
    }
    for (x, z, high, lean) in [
        (-0.2, -0.16, 0.34, 0.05),
        (-0.05, -0.2, 0.48, -0.04),
        (0.1, -0.16, 0.40, 0.05),
        (0.22, -0.22, 0.30, -0.05),
    ] {
        let edge = |side: f32| {
            (0..=6)
                .map(|i| i as f32 / 6.0)
                .map(|t| {
                    let wide = 0.09 * (1.0 - t).powf(0.7) * (1.0 + 0.5 * (6.0 * t).sin());
                    vec3(x + side * wide + lean * (7.0 * t).sin(), 0.12 + high * t, z)
                })
                .collect::<Vec<_>>()
        };
        shape.join(band(CANDLE_FLAME, &edge(-1.0), &edge(1.0)));
    }
    for side in [-1.0, 1.0] {
        let dog = lathe(
            IRON,
            &[
                [0.0, 0.0],
                [0.04, 0.0],
                [0.015, 0.05],
                [0.015, 0.24],
                [0.04, 0.28],
                [0.0, 0.33],
            ],
            10,
        );
        shape.add(&dog, shift(0.4 * side, 0.0, -0.05));
    }
    shape
}
