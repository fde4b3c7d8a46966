//! Tables, desks and instruments. Fronts look to +z.

use super::room::shift;
use super::seat::cabriole;
use super::workshop::Workshop;
use crate::shape::{Shape, block, cuboid, lathe, prism};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::sync::Arc;

/// A round table on one foot: radius of its top.
pub(crate) fn round_table(shop: &mut Workshop, radius: f32, top: MaterialId, foot: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("round table {radius} {} {}", top.0, foot.0), || {
        let stem: [[f32; 2]; 14] = [
            [0.0, 0.0],
            [0.30, 0.0],
            [0.30, 0.04],
            [0.22, 0.07],
            [0.10, 0.11],
            [0.07, 0.16],
            [0.11, 0.24],
            [0.12, 0.32],
            [0.08, 0.40],
            [0.05, 0.46],
            [0.05, 0.58],
            [0.09, 0.66],
            [0.20, 0.71],
            [0.0, 0.71],
        ];
        let mut shape = lathe(foot, &stem, 24);
        let plate = [
            [0.0, 0.71],
            [0.94, 0.71],
            [1.0, 0.73],
            [1.0, 0.75],
            [0.97, 0.77],
            [0.0, 0.77],
        ];
        shape.join(lathe(top, &plate.map(|[out, up]| [out * radius, up]), 48));
        shape
    })
}

/// A side table with a marble top and gilded legs, to stand at a wall.
pub(crate) fn console(shop: &mut Workshop, wide: f32, top: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("console {wide} {} {}", top.0, gilt.0), || {
        let deep = 0.46;
        let mut shape = Shape::new();
        for (x, z) in [(-1.0, -0.5), (1.0, -0.5), (1.0, 1.0), (-1.0, 1.0)] {
            let out = vec3(x, 0.0, z).normalize();
            let leg = cabriole(gilt, 0.78, out, 0.045);
            shape.add(&leg, shift(0.42 * x * wide, 0.0, 0.26 * deep + 0.22 * z * deep));
        }
        shape.join(block(
            gilt,
            [-0.46 * wide, 0.76, 0.03],
            [0.46 * wide, 0.88, deep - 0.03],
        ));
        shape.join(block(gilt, [-0.40 * wide, 0.14, 0.10], [0.40 * wide, 0.18, 0.30]));
        let drops = 7;
        for i in 0..drops {
            let x = wide * (i as f32 + 0.5) / drops as f32 - 0.5 * wide;
            let drop = [[0.0, -0.10], [0.03, -0.05], [0.05, 0.0]];
            shape.add(&lathe(gilt, &drop, 10), shift(0.88 * x, 0.76, deep - 0.07));
        }
        shape.join(block(top, [-0.5 * wide, 0.88, 0.0], [0.5 * wide, 0.93, deep]));
        shape
    })
}

/// A long table on turned legs.
pub(crate) fn long_table(shop: &mut Workshop, long: f32, wood: MaterialId, cloth: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("long table {long} {} {}", wood.0, cloth.0), || {
        let half = 0.5 * long;
        let mut shape = block(wood, [-half, 0.72, -0.55], [half, 0.78, 0.55]);
        shape.join(block(
            cloth,
            [-half + 0.12, 0.78, -0.43],
            [half - 0.12, 0.785, 0.43],
        ));
        shape.join(block(wood, [-half + 0.1, 0.60, -0.45], [half - 0.1, 0.72, 0.45]));
        let leg: [[f32; 2]; 11] = [
            [0.0, 0.0],
            [0.05, 0.0],
            [0.06, 0.05],
            [0.035, 0.10],
            [0.04, 0.14],
            [0.075, 0.24],
            [0.08, 0.34],
            [0.045, 0.44],
            [0.06, 0.50],
            [0.06, 0.60],
            [0.0, 0.60],
        ];
        let leg = lathe(wood, &leg, 14);
        let pairs = (long / 1.3).ceil() as usize;
        for pair in 0..=pairs {
            let x = (half - 0.18) * (2.0 * pair as f32 / pairs as f32 - 1.0);
            for z in [-0.38, 0.38] {
                shape.add(&leg, shift(x, 0.0, z));
            }
        }
        shape.join(block(
            wood,
            [-half + 0.18, 0.10, -0.04],
            [half - 0.18, 0.15, 0.04],
        ));
        shape
    })
}

/// A writing desk with drawers on both sides.
pub(crate) fn desk(
    shop: &mut Workshop,
    wood: MaterialId,
    leather: MaterialId,
    brass: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("desk {} {}", wood.0, leather.0), || {
        let mut shape = block(wood, [-0.95, 0.74, -0.45], [0.95, 0.79, 0.45]);
        shape.join(block(leather, [-0.82, 0.79, -0.34], [0.82, 0.795, 0.34]));
        for side in [-1.0, 1.0] {
            let [left, right] = [side * 0.65 - 0.25, side * 0.65 + 0.25];
            shape.join(block(wood, [left, 0.06, -0.40], [right, 0.74, 0.40]));
            shape.join(block(
                brass,
                [left - 0.01, 0.0, -0.41],
                [right + 0.01, 0.06, 0.41],
            ));
            for drawer in 0..3 {
                let up = 0.12 + 0.21 * drawer as f32;
                shape.join(block(
                    wood,
                    [left + 0.03, up, 0.40],
                    [right - 0.03, up + 0.17, 0.42],
                ));
                shape.join(block(
                    brass,
                    [side * 0.65 - 0.06, up + 0.07, 0.42],
                    [side * 0.65 + 0.06, up + 0.10, 0.445],
                ));
            }
        }
        shape.join(block(wood, [-0.40, 0.62, -0.36], [0.40, 0.74, 0.36]));
        shape
    })
}

/// A harpsichord with its lid raised; its keyboard faces +z.
pub(crate) fn harpsichord(
    shop: &mut Workshop,
    body: MaterialId,
    inside: MaterialId,
    keys: [MaterialId; 2],
) -> Arc<Mesh> {
    shop.piece(format!("harpsichord {} {}", body.0, inside.0), || {
        // The curved side as a chain of straight ones.
        let bent = [
            (0.46, 0.42),
            (0.46, -0.10),
            (0.34, -0.62),
            (0.12, -1.20),
            (-0.18, -1.66),
            (-0.46, -1.74),
            (-0.46, 0.42),
        ];
        let at = |up: f32| -> Vec<Vec3> { bent.iter().map(|&(x, z)| vec3(x, up, z)).collect() };
        let mut shape = prism(body, &at(0.66), vec3(0.0, 0.24, 0.0));
        shape.face(inside, &at(0.905));
        let hinge = Transform::rotation([0.0, 0.0, 1.0], 0.85);
        let lid = prism(body, &at(0.0), vec3(0.0, 0.025, 0.0));
        let mut lined = lid;
        let lining: Vec<Vec3> = at(-0.002).into_iter().rev().collect();
        lined.face(inside, &lining);
        shape.add(&lined, shift(-0.46, 0.92, 0.0) * hinge * shift(0.46, 0.0, 0.0));
        let prop = block(inside, [-0.012, 0.0, -0.012], [0.012, 0.66, 0.012]);
        shape.add(
            &prop,
            shift(0.30, 0.9, -0.3) * Transform::rotation([0.0, 0.0, 1.0], 0.35),
        );
        shape.join(block(body, [-0.46, 0.66, 0.42], [0.46, 0.74, 0.66]));
        for key in 0..36 {
            let left = -0.43 + 0.0239 * key as f32;
            shape.join(block(keys[0], [left, 0.74, 0.44], [left + 0.021, 0.765, 0.65]));
            if ![2, 6].contains(&(key % 7)) {
                shape.join(block(
                    keys[1],
                    [left + 0.015, 0.765, 0.44],
                    [left + 0.029, 0.778, 0.56],
                ));
            }
        }
        let leg = [
            [0.0, 0.0],
            [0.03, 0.0],
            [0.05, 0.06],
            [0.025, 0.12],
            [0.045, 0.5],
            [0.06, 0.6],
            [0.06, 0.66],
        ];
        let leg = lathe(body, &leg, 12);
        for (x, z) in [(-0.38, 0.5), (0.38, 0.5), (-0.36, -1.5), (0.2, -0.7)] {
            shape.add(&leg, shift(x, 0.0, z));
        }
        let stand = Transform::rotation([1.0, 0.0, 0.0], -0.35);
        shape.add(&cuboid(inside, [0.6, 0.28, 0.02]), shift(0.0, 0.90, 0.30) * stand);
        shape
    })
}
