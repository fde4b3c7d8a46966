//! Chests, bookcases, glass cases and clocks. Backs are against a wall, fronts face +z.

use super::palette::*;
use super::room::shift;
use super::workshop::Workshop;
use crate::shape::{Shape, ball, block, cuboid, lathe};
use enfilade::{MaterialId, Mesh, Transform};
use enfilade_scenes::Random;
use glam::{Vec3, vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// A chest with a round lid and iron bands.
pub(crate) fn chest(shop: &mut Workshop, wood: MaterialId, iron: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("chest {} {}", wood.0, iron.0), || {
        const STEPS: usize = 8;
        let mut shape = Shape::new();
        let mut banded = |material: MaterialId, x: [f32; 2], out: f32| {
            let half = 0.3 + out;
            shape.join(block(material, [x[0], 0.08 - out, -half], [x[1], 0.5, half]));
            let arc = |x: f32| -> Vec<Vec3> {
                (0..=STEPS)
                    .map(|i| PI * i as f32 / STEPS as f32)
                    .map(|turn| vec3(x, 0.5 + half * 0.75 * turn.sin(), half * turn.cos()))
                    .collect()
            };
            let [left, right] = x.map(arc);
            for i in 0..STEPS {
                shape.face(material, &[left[i], right[i], right[i + 1], left[i + 1]]);
            }
            shape.face(material, &right.iter().rev().copied().collect::<Vec<_>>());
            shape.face(material, &left);
        };
        banded(wood, [-0.55, 0.55], 0.0);
        for x in [-0.5, -0.17, 0.17, 0.5] {
            banded(iron, [x - 0.035, x + 0.035], 0.012);
        }
        shape.join(block(iron, [-0.08, 0.38, 0.3], [0.08, 0.56, 0.33]));
        for (x, z) in [(-0.45, -0.24), (0.45, -0.24), (0.45, 0.24), (-0.45, 0.24)] {
            shape.add(&ball(iron, 0.05, 8, 10), shift(x, 0.05, z));
        }
        shape
    })
}

const BINDINGS: [MaterialId; 7] = [DARK_RED, GREEN_SILK, NIGHT_BLUE, OAK, WALNUT, RED_SILK, OLD_GOLD];

/// A bookcase full of books, of four that differ: width and height.
pub(crate) fn bookcase(
    shop: &mut Workshop,
    which: u64,
    wide: f32,
    high: f32,
    wood: MaterialId,
    gilt: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("bookcase {} {wide} {high} {}", which % 4, wood.0), || {
        let mut random = Random::new(which % 4);
        let half = 0.5 * wide;
        let deep = 0.36;
        let mut shape = Shape::new();
        shape.join(block(wood, [-half, 0.0, 0.0], [half, 0.5, deep + 0.08]));
        for side in [-1.0, 1.0] {
            let [left, right] = [
                side * half - 0.04 * (1.0 + side),
                side * half + 0.04 * (1.0 - side),
            ];
            shape.join(block(wood, [left, 0.5, 0.0], [right, high - 0.25, deep]));
            let panel = side * 0.25 * wide;
            let reach = 0.19 * wide;
            shape.join(block(
                gilt,
                [panel - reach, 0.09, deep + 0.08],
                [panel + reach, 0.44, deep + 0.095],
            ));
            shape.join(block(
                wood,
                [panel - reach + 0.02, 0.11, deep + 0.08],
                [panel + reach - 0.02, 0.42, deep + 0.10],
            ));
        }
        shape.face(
            EBONY,
            &[
                vec3(-half, 0.5, 0.02),
                vec3(half, 0.5, 0.02),
                vec3(half, high - 0.25, 0.02),
                vec3(-half, high - 0.25, 0.02),
            ],
        );
        let shelves = ((high - 0.75) / 0.42).round().max(1.0);
        let step = (high - 0.75) / shelves;
        for shelf in 0..shelves as usize {
            let foot = 0.5 + step * shelf as f32;
            shape.join(block(
                wood,
                [-half + 0.08, foot, 0.02],
                [half - 0.08, foot + 0.025, deep - 0.01],
            ));
            books(
                &mut shape,
                &mut random,
                [-half + 0.1, half - 0.1],
                foot + 0.025,
                step - 0.07,
            );
        }
        shape.join(block(
            wood,
            [-half - 0.04, high - 0.25, 0.0],
            [half + 0.04, high - 0.12, deep + 0.04],
        ));
        shape.join(block(
            gilt,
            [-half - 0.05, high - 0.12, 0.0],
            [half + 0.05, high - 0.09, deep + 0.06],
        ));
        shape.join(block(
            wood,
            [-half - 0.09, high - 0.09, 0.0],
            [half + 0.09, high, deep + 0.11],
        ));
        shape
    })
}

/// A row of books on a shelf, some leaning, some missing.
fn books(shape: &mut Shape, random: &mut Random, [from, to]: [f32; 2], foot: f32, room: f32) {
    let mut left = from;
    let mut binding = random.pick(&BINDINGS);
    while left < to - 0.05 {
        if random.once_in(5) {
            binding = random.pick(&BINDINGS);
        }
        let thick = random.between(0.03, 0.065).min(to - left);
        let high = room * random.between(0.72, 0.98);
        let deep = random.between(0.2, 0.24);
        let mut book = block(binding, [0.0, 0.0, 0.06], [thick * 0.96, high, 0.06 + deep]);
        let label = [0.62 * high, 0.74 * high];
        book.join(block(
            OLD_GOLD,
            [0.15 * thick, label[0], 0.06 + deep],
            [0.8 * thick, label[1], 0.063 + deep],
        ));
        let lean: f32 = if random.once_in(14) { 0.16 } else { 0.0 };
        let slack = high * lean;
        if left + slack + thick > to {
            break;
        }
        let tilt = Transform::rotation([0.0, 0.0, 1.0], f64::from(lean));
        shape.add(&book, shift(left + slack, foot, 0.0) * tilt);
        left += thick + slack + if random.once_in(18) { 0.1 } else { 0.002 };
    }
}

/// A glass case on legs: its wooden frame and its panes are two meshes. Width, height and depth of the glass.
pub(crate) fn glass_case(
    shop: &mut Workshop,
    size: [f32; 3],
    wood: MaterialId,
    shelf: MaterialId,
) -> [Arc<Mesh>; 2] {
    let [wide, high, deep] = size;
    let [x, z] = [0.5 * wide, 0.5 * deep];
    let foot = 0.75;
    let frame = shop.piece(format!("case frame {size:?} {} {}", wood.0, shelf.0), || {
        let mut shape = block(wood, [-x, foot - 0.1, -z], [x, foot, z]);
        shape.join(block(
            shelf,
            [-x + 0.03, foot, -z + 0.03],
            [x - 0.03, foot + 0.01, z - 0.03],
        ));
        shape.join(block(
            wood,
            [-x - 0.02, foot + high, -z - 0.02],
            [x + 0.02, foot + high + 0.05, z + 0.02],
        ));
        let leg = [
            [0.0, 0.0],
            [0.025, 0.0],
            [0.04, 0.08],
            [0.025, 0.14],
            [0.04, 0.5],
            [0.045, foot - 0.1],
        ];
        let leg = lathe(wood, &leg, 10);
        for corner in 0..4 {
            let [a, b] = [corner & 1, corner >> 1].map(|bit| if bit == 0 { -1.0 } else { 1.0 });
            shape.add(&leg, shift(a * (x - 0.06), 0.0, b * (z - 0.06)));
            shape.add(
                &cuboid(wood, [0.035, high, 0.035]),
                shift(a * (x - 0.018), foot, b * (z - 0.018)),
            );
        }
        shape
    });
    let panes = shop.piece(format!("case panes {size:?}"), || {
        let mut shape = Shape::new();
        let [x, z] = [x - 0.018, z - 0.018];
        let corners = [(-x, z), (x, z), (x, -z), (-x, -z)];
        for i in 0..4 {
            let [(ax, az), (bx, bz)] = [corners[i], corners[(i + 1) % 4]];
            let corner = |x: f32, z: f32, up: f32| vec3(x, foot + up, z);
            shape.face(
                PANE,
                &[
                    corner(ax, az, 0.0),
                    corner(bx, bz, 0.0),
                    corner(bx, bz, high),
                    corner(ax, az, high),
                ],
            );
        }
        shape
    });
    [frame, panes]
}

/// A clock as tall as a man.
pub(crate) fn long_clock(shop: &mut Workshop, wood: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("long clock {} {}", wood.0, gilt.0), || {
        let mut shape = block(wood, [-0.28, 0.0, 0.0], [0.28, 0.45, 0.3]);
        shape.join(block(wood, [-0.2, 0.45, 0.03], [0.2, 1.55, 0.26]));
        shape.join(block(wood, [-0.28, 1.55, 0.0], [0.28, 2.1, 0.3]));
        shape.join(block(gilt, [-0.31, 2.1, 0.0], [0.31, 2.15, 0.33]));
        shape.join(block(EBONY, [-0.13, 0.6, 0.26], [0.13, 1.45, 0.265]));
        let facing = Transform::rotation([1.0, 0.0, 0.0], f64::from(PI) / 2.0);
        let dial = [[0.0, 0.0], [0.22, 0.0], [0.22, 0.02], [0.19, 0.025]];
        shape.add(&lathe(gilt, &dial, 32), shift(0.0, 1.83, 0.3) * facing);
        shape.add(
            &lathe(IVORY, &[[0.19, 0.018], [0.0, 0.018]], 32),
            shift(0.0, 1.83, 0.3) * facing,
        );
        for (long, wide, turn) in [(0.11, 0.02, 0.9), (0.16, 0.014, -1.9)] {
            let hand = block(EBONY, [-0.5 * wide, 0.0, 0.32], [0.5 * wide, long, 0.325]);
            shape.add(
                &hand,
                shift(0.0, 1.83, 0.0) * Transform::rotation([0.0, 0.0, 1.0], turn),
            );
        }
        shape.add(
            &lathe(gilt, &[[0.0, 0.0], [0.08, 0.0], [0.08, 0.015], [0.0, 0.02]], 20),
            shift(0.0, 0.8, 0.27) * facing,
        );
        shape.join(block(gilt, [-0.006, 0.8, 0.27], [0.006, 1.4, 0.275]));
        for x in [-0.24, 0.0, 0.24] {
            let finial = [
                [0.0, 0.0],
                [0.04, 0.0],
                [0.02, 0.03],
                [0.05, 0.09],
                [0.02, 0.15],
                [0.0, 0.2],
            ];
            shape.add(&lathe(gilt, &finial, 12), shift(x, 2.15, 0.16));
        }
        shape
    })
}
