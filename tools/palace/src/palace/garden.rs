//! Garden furniture and plants: trees, hedges, a fountain, balustrades.

use super::crown::{Habit, grown};
use super::palette::*;
use super::room::shift;
use super::statue::bezier;
use super::workshop::Workshop;
use crate::shape::{Shape, ball, band, block, fluted, lathe, superquadric, tube};
use enfilade::{MaterialId, Mesh, Transform};
use enfilade_scenes::Random;
use glam::{Vec3, vec2, vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// One of four trees, about 4 m tall, two of them with dark leaves.
pub(crate) fn tree(shop: &mut Workshop, which: u64) -> Arc<Mesh> {
    const PALE: Habit = Habit {
        kind: "tree",
        boughs: PALE_BOUGHS,
        leaves: PALE_LEAVES,
        crown: [1.30, 1.10],
        middle: 2.85,
        masses: 15,
        mass: 0.46,
        cards: 170,
        card: 0.24,
        trunk: 0.15,
        branches: 5,
        faces: 700,
        per_length: 1.1,
    };
    const DARK: Habit = Habit {
        boughs: DARK_BOUGHS,
        leaves: DARK_LEAVES,
        ..PALE
    };
    let habit = if which.is_multiple_of(2) { PALE } else { DARK };
    grown(shop, &habit, which % 4 + 40)
}

/// A leaf about a point, from `-along` to `along`, its sides at `-aside` and `aside`.
fn leaf_of(shape: &mut Shape, color: MaterialId, at: Vec3, along: Vec3, aside: Vec3) {
    shape.placed(
        color,
        &[at - along, at - aside, at + along, at + aside],
        &[vec2(0.0, 0.5), vec2(0.5, 1.0), vec2(1.0, 0.5), vec2(0.5, 0.0)],
    );
}

/// A palm in a tub, `tall` metres.
pub(crate) fn palm(shop: &mut Workshop, tall: f32, tub: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("palm {tall} {}", tub.0), || {
        const FRONDS: usize = 14;
        let mut shape = tub_of(tub);
        let trunk = [
            vec3(0.0, 0.4, 0.0),
            vec3(0.05, 0.5 * tall, 0.02),
            vec3(0.0, 0.78 * tall, 0.05),
        ];
        shape.join(tube(
            BARK,
            &bezier([trunk[0], trunk[1], trunk[1], trunk[2]], 10),
            |t| 0.075 - 0.02 * t,
            9,
        ));
        for frond in 0..FRONDS {
            let (sin, cos) = (TAU * frond as f64 / FRONDS as f64 * 2.4).sin_cos();
            let out = vec3(cos as f32, 0.0, sin as f32);
            let reach = tall * (0.30 + 0.05 * (frond % 3) as f32);
            let rise = 0.30 * tall * (0.35 + 0.65 * frond as f32 / FRONDS as f32);
            let top = trunk[2];
            let spine = bezier(
                [
                    top,
                    top + out * 0.35 * reach + Vec3::Y * rise,
                    top + out * 0.85 * reach + Vec3::Y * rise,
                    top + out * reach + Vec3::Y * (0.25 * rise - 0.12 * tall),
                ],
                12,
            );
            let across = out.cross(Vec3::Y);
            for i in 1..12 {
                let wide = 0.16 * tall * (i as f32 / 12.0 * 3.1).sin().max(0.15);
                for side in [-1.0, 1.0] {
                    let tip = spine[i + 1] + across * side * wide - Vec3::Y * 0.35 * wide;
                    let material = if frond % 2 == 0 { LEAF } else { PALE_LEAF };
                    let places = [vec2(0.05, 0.42), vec2(0.05, 0.58), vec2(0.95, 0.5)];
                    shape.placed(material, &[spine[i - 1], spine[i], tip], &places);
                }
            }
        }
        shape
    })
}

/// An orange tree in a tub: a ball of leaves with fruit in it.
pub(crate) fn orange_tree(shop: &mut Workshop, tub: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("orange tree {}", tub.0), || {
        let mut random = Random::new(8);
        let mut shape = tub_of(tub);
        shape.join(tube(
            BARK,
            &[vec3(0.0, 0.4, 0.0), vec3(0.02, 0.8, 0.0), vec3(0.0, 1.2, 0.0)],
            |_| 0.035,
            8,
        ));
        shape.add(
            &superquadric(HEDGE, [0.40, 0.40, 0.40], 1.0, 1.0, 8, 12),
            shift(0.0, 1.55, 0.0),
        );
        for leaf in 0..260 {
            let toward = Vec3::from(random.point(1.0)).normalize_or(Vec3::Y);
            let at = vec3(0.0, 1.55, 0.0) + toward * random.between(0.40, 0.52);
            let across = (toward.any_orthonormal_vector() + Vec3::from(random.point(0.5))).normalize();
            let up = toward.cross(across).normalize_or(Vec3::Y);
            let size = random.between(0.05, 0.08);
            let color = if leaf % 2 == 0 { PALE_LEAF } else { LEAF };
            leaf_of(&mut shape, color, at, across * size, up * 0.5 * size);
        }
        for _ in 0..16 {
            let toward = Vec3::from(random.point(1.0)).normalize_or(Vec3::Y);
            let at = vec3(0.0, 1.55, 0.0) + toward * 0.50;
            shape.add(&ball(EMBER, 0.045, 6, 8), shift(at.x, at.y, at.z));
        }
        shape
    })
}

/// A tub with iron hoops, 0.45 m tall, filled with earth.
fn tub_of(material: MaterialId) -> Shape {
    let mut shape = lathe(
        material,
        &[
            [0.0, 0.0],
            [0.26, 0.0],
            [0.31, 0.42],
            [0.34, 0.42],
            [0.34, 0.46],
            [0.29, 0.46],
            [0.29, 0.41],
        ],
        20,
    );
    shape.join(lathe(BARK, &[[0.29, 0.41], [0.0, 0.41]], 20));
    for up in [0.08, 0.3] {
        let out = 0.262 + 0.12 * up;
        shape.join(lathe(
            IRON,
            &[
                [out, up],
                [out + 0.012, up],
                [out + 0.016, up + 0.04],
                [out, up + 0.04],
            ],
            20,
        ));
    }
    shape
}

/// A cone or a stack of balls, clipped out of yew.
pub(crate) fn topiary(shop: &mut Workshop, stacked: bool) -> Arc<Mesh> {
    shop.piece(format!("topiary {stacked}"), || {
        let mut shape = lathe(BARK, &[[0.06, 0.0], [0.05, 0.3]], 8);
        if stacked {
            for (up, radius) in [(0.65, 0.46), (1.35, 0.34), (1.88, 0.24)] {
                shape.add(&ball(HEDGE, radius, 12, 18), shift(0.0, up, 0.0));
            }
        } else {
            let profile = [
                [0.0, 0.15],
                [0.40, 0.16],
                [0.49, 0.20],
                [0.52, 0.29],
                [0.47, 0.60],
                [0.28, 1.40],
                [0.10, 2.12],
                [0.055, 2.28],
                [0.0, 2.35],
            ];
            shape.join(lathe(HEDGE, &profile, 28));
        }
        shape
    })
}

/// A clipped hedge: length along x.
pub(crate) fn hedge(shop: &mut Workshop, long: f32, high: f32) -> Arc<Mesh> {
    shop.piece(format!("hedge {long} {high}"), || {
        let half = 0.5 * long;
        let mut shape = block(HEDGE, [-half, 0.0, -0.25], [half, high, 0.25]);
        shape.join(block(LAWN, [-half, high, -0.25], [half, high + 0.02, 0.25]));
        shape
    })
}

/// A fountain: a wide basin, two bowls on a stem, water in all three, jets that fall.
pub(crate) fn fountain(shop: &mut Workshop, stone: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("fountain {}", stone.0), || {
        let basin = [
            [0.0, 0.0],
            [2.6, 0.0],
            [2.6, 0.1],
            [2.45, 0.16],
            [2.45, 0.46],
            [2.6, 0.52],
            [2.6, 0.62],
            [2.3, 0.62],
            [2.3, 0.12],
            [0.0, 0.12],
        ];
        let mut shape = lathe(stone, &basin, 48);
        let stem = [
            [0.5, 0.12],
            [0.5, 0.3],
            [0.3, 0.5],
            [0.22, 0.9],
            [0.3, 1.2],
            [0.2, 1.35],
        ];
        shape.join(lathe(stone, &stem, 24));
        shape.join(fluted(
            stone,
            &[[0.2, 1.35], [0.7, 1.45], [1.15, 1.62]],
            20,
            3,
            0.06,
        ));
        shape.join(lathe(
            stone,
            &[[1.16, 1.62], [1.2, 1.68], [1.08, 1.7], [0.2, 1.56]],
            60,
        ));
        shape.join(lathe(
            stone,
            &[[0.16, 1.5], [0.12, 1.9], [0.18, 2.1], [0.12, 2.2]],
            20,
        ));
        shape.join(fluted(
            stone,
            &[[0.12, 2.2], [0.35, 2.26], [0.6, 2.38]],
            16,
            3,
            0.06,
        ));
        shape.join(lathe(
            stone,
            &[[0.61, 2.38], [0.63, 2.42], [0.55, 2.43], [0.0, 2.34]],
            48,
        ));
        shape.add(&ball(stone, 0.13, 10, 14), shift(0.0, 2.5, 0.0));
        for (radius, up) in [(2.3, 0.5), (1.06, 1.68), (0.54, 2.41)] {
            shape.join(lathe(WATER, &[[radius, up], [0.0, up]], 48));
        }
        for jet in 0..12 {
            let turn = Transform::rotation([0.0, 1.0, 0.0], TAU * f64::from(jet) / 12.0);
            let fall = |out: f32, up: f32, reach: f32| {
                let point =
                    |t: f32, side: f32| vec3(out + reach * t, up - 1.15 * t * t, side * (0.05 - 0.02 * t));
                let edge = |side: f32| (0..=6).map(|i| point(i as f32 / 6.0, side)).collect::<Vec<_>>();
                band(WATER, &edge(-1.0), &edge(1.0))
            };
            shape.add(&fall(1.16, 1.68, 0.35), turn);
            if jet % 2 == 0 {
                shape.add(
                    &fall(0.62, 2.41, 0.22).bent(|at| vec3(at.x, 2.41 - 0.6 * (2.41 - at.y), at.z)),
                    turn,
                );
            }
        }
        shape
    })
}

/// One post of a balustrade, 0.7 m tall.
pub(crate) fn baluster(shop: &mut Workshop, stone: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("baluster {}", stone.0), || baluster_shape(stone))
}

/// The shape of [`baluster`], for rows that are one item.
pub(crate) fn baluster_shape(stone: MaterialId) -> Shape {
    let profile = [
        [0.07, 0.0],
        [0.07, 0.05],
        [0.04, 0.08],
        [0.085, 0.2],
        [0.09, 0.28],
        [0.04, 0.5],
        [0.05, 0.56],
        [0.04, 0.6],
        [0.07, 0.63],
        [0.07, 0.7],
    ];
    lathe(stone, &profile, 12)
}

/// A bench of stone.
pub(crate) fn bench(shop: &mut Workshop, stone: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("bench {}", stone.0), || {
        let mut shape = block(stone, [-0.9, 0.42, -0.24], [0.9, 0.5, 0.24]);
        for x in [-0.65, 0.65] {
            shape.join(block(stone, [x - 0.1, 0.0, -0.2], [x + 0.1, 0.08, 0.2]));
            shape.join(block(stone, [x - 0.07, 0.08, -0.16], [x + 0.07, 0.42, 0.16]));
        }
        shape
    })
}
