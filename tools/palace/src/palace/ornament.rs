//! Ornaments for pedestals, mantels and shelves: urns, vases, obelisks, spheres, knots.

use super::room::shift;
use super::statue::bezier;
use super::workshop::Workshop;
use crate::shape::{Shape, ball, cuboid, fluted, knot, lathe, round_tube, taper, tube};
use enfilade::{MaterialId, Mesh, Transform};
use glam::vec3;
use std::sync::Arc;

/// A covered urn with two handles, 0.8 m tall.
pub(crate) fn urn(shop: &mut Workshop, stone: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("urn {} {}", stone.0, gilt.0), || {
        let mut shape = cuboid(stone, [0.26, 0.05, 0.26]);
        let foot = [[0.12, 0.05], [0.11, 0.08], [0.045, 0.13], [0.05, 0.17]];
        shape.join(lathe(gilt, &foot, 24));
        let bowl = [[0.05, 0.17], [0.16, 0.24], [0.215, 0.33]];
        shape.join(fluted(stone, &bowl, 16, 3, 0.08));
        let body = [
            [0.222, 0.33],
            [0.225, 0.36],
            [0.20, 0.47],
            [0.155, 0.53],
            [0.15, 0.57],
            [0.20, 0.60],
        ];
        shape.join(lathe(stone, &body, 32));
        let lid = [
            [0.20, 0.60],
            [0.21, 0.615],
            [0.17, 0.65],
            [0.07, 0.70],
            [0.03, 0.72],
            [0.045, 0.76],
            [0.02, 0.80],
            [0.0, 0.81],
        ];
        shape.join(lathe(gilt, &lid, 32));
        for side in [-1.0, 1.0] {
            let path = bezier(
                [
                    vec3(side * 0.20, 0.36, 0.0),
                    vec3(side * 0.40, 0.42, 0.0),
                    vec3(side * 0.34, 0.64, 0.0),
                    vec3(side * 0.17, 0.58, 0.0),
                ],
                12,
            );
            shape.join(tube(gilt, &path, |_| 0.018, 8));
        }
        shape
    })
}

/// Vases of five shapes, 0.3 to 0.5 m tall.
pub(crate) fn vase(shop: &mut Workshop, kind: usize, clay: MaterialId, band: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("vase {} {} {}", kind % 5, clay.0, band.0), || {
        let profile: &[[f32; 2]] = match kind % 5 {
            0 => &[
                [0.0, 0.0],
                [0.07, 0.0],
                [0.075, 0.02],
                [0.15, 0.16],
                [0.16, 0.24],
                [0.11, 0.34],
                [0.05, 0.39],
                [0.055, 0.45],
                [0.085, 0.48],
                [0.0, 0.46],
            ],
            1 => &[
                [0.0, 0.0],
                [0.06, 0.0],
                [0.06, 0.03],
                [0.10, 0.08],
                [0.14, 0.28],
                [0.13, 0.33],
                [0.06, 0.37],
                [0.075, 0.40],
                [0.0, 0.39],
            ],
            2 => &[
                [0.0, 0.0],
                [0.06, 0.0],
                [0.11, 0.06],
                [0.12, 0.13],
                [0.07, 0.2],
                [0.028, 0.26],
                [0.026, 0.42],
                [0.045, 0.46],
                [0.0, 0.44],
            ],
            3 => &[
                [0.0, 0.0],
                [0.07, 0.0],
                [0.06, 0.02],
                [0.03, 0.05],
                [0.04, 0.08],
                [0.17, 0.15],
                [0.21, 0.21],
                [0.20, 0.22],
                [0.0, 0.16],
            ],
            _ => &[
                [0.0, 0.0],
                [0.08, 0.0],
                [0.14, 0.10],
                [0.15, 0.17],
                [0.12, 0.26],
                [0.08, 0.29],
                [0.09, 0.31],
                [0.06, 0.35],
                [0.02, 0.37],
                [0.03, 0.40],
                [0.0, 0.42],
            ],
        };
        let mut shape = Shape::new();
        for (i, pair) in profile.windows(2).enumerate() {
            shape.join(lathe(if i % 3 == 2 { band } else { clay }, pair, 28));
        }
        shape
    })
}

/// An obelisk on four balls, 1.9 m tall.
pub(crate) fn obelisk(shop: &mut Workshop, stone: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("obelisk {} {}", stone.0, gilt.0), || {
        let mut shape = cuboid(stone, [0.5, 0.12, 0.5]);
        for corner in 0..4 {
            let [x, z] = [corner & 1, corner >> 1].map(|bit| if bit == 0 { -0.13 } else { 0.13 });
            shape.add(&ball(gilt, 0.05, 10, 14), shift(x, 0.17, z));
        }
        shape.add(
            &taper(stone, [0.36, 0.36], 1.45, [0.2, 0.2]),
            shift(0.0, 0.22, 0.0),
        );
        shape.add(&taper(gilt, [0.2, 0.2], 0.2, [0.0, 0.0]), shift(0.0, 1.67, 0.0));
        shape
    })
}

/// An armillary sphere around a small earth, 1.2 m tall.
pub(crate) fn armillary(shop: &mut Workshop, brass: MaterialId, earth: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("armillary {} {}", brass.0, earth.0), || {
        let foot = [
            [0.0, 0.0],
            [0.2, 0.0],
            [0.2, 0.03],
            [0.1, 0.07],
            [0.03, 0.12],
            [0.05, 0.2],
            [0.02, 0.26],
            [0.02, 0.36],
            [0.0, 0.36],
        ];
        let mut shape = lathe(brass, &foot, 24);
        let middle = shift(0.0, 0.78, 0.0);
        shape.add(&ball(earth, 0.12, 14, 20), middle);
        for (axis, angle, radius) in [
            ([1.0, 0.0, 0.0], 90.0, 0.42),
            ([0.0, 0.0, 1.0], 90.0, 0.40),
            ([1.0, 0.0, 0.0], 0.0, 0.44),
            ([1.0, 0.0, 0.4], 24.0, 0.38),
            ([1.0, 0.0, -0.6], -40.0, 0.36),
        ] {
            let turn = Transform::rotation(axis, f64::to_radians(angle));
            shape.add(&round_tube(brass, radius, 0.014, 48, 6), middle * turn);
        }
        let axis = [[0.0, -0.48], [0.01, -0.48], [0.01, 0.48], [0.0, 0.5]];
        shape.add(
            &lathe(brass, &axis, 8),
            middle * Transform::rotation([0.0, 0.0, 1.0], 0.41),
        );
        shape
    })
}

/// A modern sculpture: a torus knot on a small foot, 1.1 m tall.
pub(crate) fn knot_sculpture(
    shop: &mut Workshop,
    coils: u32,
    metal: MaterialId,
    foot: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("knot {coils} {} {}", metal.0, foot.0), || {
        let mut shape = lathe(
            foot,
            &[
                [0.0, 0.0],
                [0.16, 0.0],
                [0.16, 0.04],
                [0.03, 0.1],
                [0.03, 0.2],
                [0.0, 0.2],
            ],
            20,
        );
        let upright = Transform::rotation([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2);
        shape.add(
            &knot(metal, 2, coils, 0.3, 0.12, 0.055, 160, 14),
            shift(0.0, 0.62, 0.0) * upright,
        );
        shape
    })
}

/// A terrestrial or celestial globe in a wooden stand, 1.2 m tall.
pub(crate) fn globe(
    shop: &mut Workshop,
    wood: MaterialId,
    sphere: MaterialId,
    brass: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("globe {} {}", wood.0, sphere.0), || {
        let mut shape = Shape::new();
        let leg = [
            [0.0, 0.0],
            [0.03, 0.0],
            [0.045, 0.1],
            [0.025, 0.2],
            [0.04, 0.4],
            [0.025, 0.55],
            [0.03, 0.72],
            [0.0, 0.72],
        ];
        for turn in 0..4 {
            let place = Transform::rotation([0.0, 1.0, 0.0], f64::from(turn) * std::f64::consts::FRAC_PI_2);
            shape.add(&lathe(wood, &leg, 12), place * shift(0.42, 0.0, 0.0));
        }
        let table = [
            [0.40, 0.70],
            [0.50, 0.70],
            [0.50, 0.74],
            [0.40, 0.74],
            [0.40, 0.70],
        ];
        shape.join(lathe(wood, &table, 48));
        shape.add(&cuboid(wood, [0.8, 0.04, 0.05]), shift(0.0, 0.16, 0.0));
        shape.add(&cuboid(wood, [0.05, 0.04, 0.8]), shift(0.0, 0.16, 0.0));
        shape.add(&ball(sphere, 0.37, 24, 36), shift(0.0, 0.76, 0.0));
        let upright = Transform::rotation([1.0, 0.0, 0.3], std::f64::consts::FRAC_PI_2);
        shape.add(
            &round_tube(brass, 0.39, 0.012, 48, 6),
            shift(0.0, 0.76, 0.0) * upright,
        );
        shape
    })
}
