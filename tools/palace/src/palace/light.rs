//! Candles and candle holders. Every candle is an item.

use super::lamps::{Lamp, over};
use super::palette::{CANDLE_FLAME, CRYSTAL, WAX};
use super::room::{Room, scaled, shift};
use super::statue::bezier;
use super::workshop::Workshop;
use crate::shape::{Shape, ball, block, lathe, round_tube, tube};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

fn candle(shop: &mut Workshop) -> Arc<Mesh> {
    shop.piece("candle".to_owned(), || {
        let mut shape = lathe(
            WAX,
            &[
                [0.0, 0.0],
                [0.016, 0.0],
                [0.015, 0.17],
                [0.008, 0.175],
                [0.0, 0.172],
            ],
            8,
        );
        let flame = [
            [0.0, 0.178],
            [0.008, 0.19],
            [0.011, 0.205],
            [0.006, 0.23],
            [0.0, 0.25],
        ];
        shape.join(lathe(CANDLE_FLAME, &flame, 6));
        shape
    })
}

/// A dish for a candle at the end of an arm, at the origin.
fn dish(metal: MaterialId) -> Shape {
    let profile = [
        [0.0, -0.03],
        [0.012, -0.03],
        [0.02, -0.01],
        [0.05, 0.01],
        [0.05, 0.02],
        [0.022, 0.018],
        [0.02, 0.04],
        [0.0, 0.04],
    ];
    lathe(metal, &profile, 12)
}

/// Adds a chandelier of `arms` arms that hangs from the ceiling over (x, z), its lowest point at a given height.
pub(crate) fn chandelier(
    room: &mut Room,
    [x, z]: [f32; 2],
    height: f32,
    arms: usize,
    size: f32,
    metal: MaterialId,
) {
    let ceiling = room.design.crown();
    let arm = |i: usize| -> Transform { Transform::rotation([0.0, 1.0, 0.0], TAU * i as f64 / arms as f64) };
    let out = vec3(0.62, 0.30, 0.0);
    let body = room.shop.piece(format!("chandelier {arms} {}", metal.0), || {
        let stem: [[f32; 2]; 16] = [
            [0.0, 0.0],
            [0.03, 0.02],
            [0.05, 0.06],
            [0.02, 0.10],
            [0.10, 0.18],
            [0.13, 0.26],
            [0.10, 0.33],
            [0.03, 0.38],
            [0.05, 0.42],
            [0.03, 0.48],
            [0.03, 0.62],
            [0.08, 0.70],
            [0.06, 0.78],
            [0.02, 0.84],
            [0.02, 1.0],
            [0.0, 1.0],
        ];
        let mut shape = lathe(metal, &stem, 16);
        let mut branch = tube(
            metal,
            &bezier(
                [
                    vec3(0.08, 0.22, 0.0),
                    vec3(0.30, 0.02, 0.0),
                    vec3(0.62, 0.06, 0.0),
                    out - Vec3::Y * 0.03,
                ],
                10,
            ),
            |_| 0.014,
            6,
        );
        branch.add(&dish(metal), shift(out.x, out.y, 0.0));
        branch.join(tube(
            metal,
            &bezier(
                [
                    vec3(0.05, 0.62, 0.0),
                    vec3(0.20, 0.84, 0.0),
                    vec3(0.34, 0.66, 0.0),
                    vec3(0.26, 0.58, 0.0),
                ],
                8,
            ),
            |t| 0.012 - 0.006 * t,
            6,
        ));
        let drop = lathe(
            CRYSTAL,
            &[[0.0, -0.11], [0.022, -0.07], [0.012, -0.02], [0.0, 0.0]],
            6,
        );
        branch.add(&drop, shift(0.62, 0.26, 0.0));
        branch.add(&drop, shift(0.26, 0.56, 0.0));
        branch.add(&drop, shift(0.34, 0.09, 0.0));
        for i in 0..arms {
            shape.add(&branch, arm(i));
        }
        shape.add(&ball(CRYSTAL, 0.06, 8, 12), shift(0.0, -0.06, 0.0));
        let ring = round_tube(metal, 0.3, 0.012, 32, 6);
        shape.add(&ring, shift(0.0, 0.12, 0.0));
        shape
    });
    let place = shift(x, height, z) * scaled(size);
    // Below it, where the chandelier does not block the light.
    room.lamps
        .push(Lamp::candles(over(place, -0.6), 0.45 * size * arms as f32));
    room.put("chandelier", &body, place);
    let chain = room.shop.piece(format!("chain {}", metal.0), || {
        lathe(metal, &[[0.012, 0.0], [0.012, 1.0]], 6)
    });
    let long = ceiling - height - size;
    room.put(
        "chain",
        &chain,
        shift(x, height + size, z) * Transform::scaling([1.0, long, 1.0]),
    );
    let candle = candle(room.shop);
    for i in 0..arms {
        let top = place * arm(i) * shift(out.x, out.y + 0.04, 0.0);
        room.put("candle", &candle, top);
    }
}

/// Adds a candelabrum with five candles, `tall` metres high.
pub(crate) fn candelabrum(room: &mut Room, place: Transform, tall: f32, metal: MaterialId) {
    let branch = tall.min(1.2) * 0.24;
    let stand = room.shop.piece(format!("candelabrum {tall} {}", metal.0), || {
        let foot = 0.16 * tall.min(1.4);
        let stem: [[f32; 2]; 13] = [
            [0.0, 0.0],
            [1.0, 0.0],
            [0.95, 0.02],
            [0.4, 0.05],
            [0.14, 0.10],
            [0.22, 0.16],
            [0.12, 0.22],
            [0.10, 0.50],
            [0.22, 0.54],
            [0.12, 0.58],
            [0.10, 0.76],
            [0.24, 0.82],
            [0.0, 0.86],
        ];
        let mut shape = lathe(metal, &stem.map(|[out, up]| [out * foot, up * tall]), 18);
        let mut arm = tube(
            metal,
            &bezier(
                [
                    vec3(0.02, 0.80 * tall, 0.0),
                    vec3(branch, 0.74 * tall, 0.0),
                    vec3(branch, 0.84 * tall, 0.0),
                    vec3(branch, 0.92 * tall, 0.0),
                ],
                8,
            ),
            |_| 0.012,
            6,
        );
        arm.add(&dish(metal), shift(branch, 0.92 * tall + 0.03, 0.0));
        for i in 0..4 {
            shape.add(
                &arm,
                Transform::rotation([0.0, 1.0, 0.0], TAU * (f64::from(i) + 0.5) / 4.0),
            );
        }
        shape.join(lathe(metal, &[[0.012, 0.85 * tall], [0.012, 0.97 * tall]], 8));
        shape.add(&dish(metal), shift(0.0, tall, 0.0));
        shape
    });
    room.candles.push(Lamp::candles(over(place, tall + 0.3), 1.4));
    room.put("candelabrum", &stand, place);
    let candle = candle(room.shop);
    room.put("candle", &candle, place * shift(0.0, tall + 0.04, 0.0));
    for i in 0..4 {
        let turn = Transform::rotation([0.0, 1.0, 0.0], TAU * (f64::from(i) + 0.5) / 4.0);
        room.put(
            "candle",
            &candle,
            place * turn * shift(branch, 0.92 * tall + 0.07, 0.0),
        );
    }
}

/// Adds a bracket with three candles to a wall; `place` is the wall frame.
pub(crate) fn sconce(room: &mut Room, place: Transform, metal: MaterialId) {
    let ends = [
        vec3(-0.16, 0.14, 0.17),
        vec3(0.0, 0.20, 0.26),
        vec3(0.16, 0.14, 0.17),
    ];
    let bracket = room.shop.piece(format!("sconce {}", metal.0), || {
        let mut shape = block(metal, [-0.05, -0.16, 0.0], [0.05, 0.22, 0.025]);
        let facing = Transform::rotation([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2);
        let shield = [[0.0, 0.0], [1.0, 0.0], [0.9, 0.03], [0.0, 0.06]];
        let shield = lathe(metal, &shield.map(|[out, up]| [out * 0.11, up]), 20);
        shape.add(
            &shield,
            shift(0.0, 0.04, 0.02) * facing * Transform::scaling([0.8, 1.0, 1.3]),
        );
        for end in ends {
            let start = vec3(0.0, 0.0, 0.05);
            let path = bezier(
                [
                    start,
                    start + vec3(end.x, -0.12, 0.05),
                    end - Vec3::Y * 0.2,
                    end - Vec3::Y * 0.03,
                ],
                8,
            );
            shape.join(tube(metal, &path, |_| 0.011, 6));
            shape.add(&dish(metal), shift(end.x, end.y, end.z));
        }
        shape
    });
    // Off the wall, so that the wall is not overexposed.
    room.candles
        .push(Lamp::candles(place.point([0.0, 0.45, 0.6]), 1.3));
    room.put("sconce", &bracket, place);
    let candle = candle(room.shop);
    for end in ends {
        room.put("candle", &candle, place * shift(end.x, end.y + 0.04, end.z));
    }
}
