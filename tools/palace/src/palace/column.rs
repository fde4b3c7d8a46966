//! Columns, pilasters and pedestals.

use super::workshop::Workshop;
use crate::shape::{Shape, band, block, cuboid, fluted, lathe, superquadric};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// A Corinthian column: ten diameters high, fluted, swelling a little, leaves round its capital.
pub(crate) fn column(shop: &mut Workshop, height: f32, shaft: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("column {height} {} {}", shaft.0, gilt.0), || {
        let radius = 0.05 * height;
        let [base, capital] = [1.0 * radius, 2.3 * radius];
        let mut shape = attic_base(gilt, shaft, radius);
        let shaft_height = height - base - capital;
        let profile: Vec<[f32; 2]> = (0..=8)
            .map(|i| {
                let up = i as f32 / 8.0;
                [radius * swelling(up), base + shaft_height * up]
            })
            .collect();
        shape.join(fluted(shaft, &profile, 20, 4, 0.09));
        shape.add(
            &corinthian(gilt, shaft, swelling(1.0) * radius, capital),
            Transform::translation([0.0, height - capital, 0.0]),
        );
        shape
    })
}

/// A Tuscan column: plain and strong.
pub(crate) fn plain_column(
    shop: &mut Workshop,
    height: f32,
    shaft: MaterialId,
    ends: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("plain column {height} {} {}", shaft.0, ends.0), || {
        let radius = height / 18.0;
        let base = 0.8 * radius;
        let capital = height - 1.1 * radius;
        let mut shape = attic_base(ends, ends, radius);
        let profile: Vec<[f32; 2]> = (0..=8)
            .map(|i| i as f32 / 8.0)
            .map(|up| [radius * swelling(up), base + (capital - base) * up])
            .collect();
        shape.join(lathe(shaft, &profile, 32));
        let necking = [
            [0.84, 0.0],
            [0.92, 0.05],
            [0.92, 0.14],
            [0.86, 0.16],
            [0.86, 0.42],
            [1.12, 0.7],
        ];
        shape.join(lathe(
            ends,
            &necking.map(|[out, up]| [out * radius, capital + up * radius]),
            32,
        ));
        let slab = cuboid(ends, [2.4 * radius, 0.4 * radius, 2.4 * radius]);
        shape.add(&slab, Transform::translation([0.0, capital + 0.7 * radius, 0.0]));
        shape
    })
}

/// Returns the relative radius of a shaft at a fraction of its height: constant for a third, then tapering
/// increasingly.
fn swelling(up: f32) -> f32 {
    let above = ((up - 0.25) / 0.75).max(0.0);
    1.0 - 0.15 * above * (0.35 + 0.65 * above)
}

/// A square foot, two rolls and the hollow between them.
fn attic_base(foot: MaterialId, rolls: MaterialId, radius: f32) -> Shape {
    let mut shape = cuboid(foot, [2.8 * radius, 0.32 * radius, 2.8 * radius]);
    let profile: [[f32; 2]; 13] = [
        [1.30, 0.32],
        [1.39, 0.38],
        [1.41, 0.46],
        [1.36, 0.53],
        [1.24, 0.56],
        [1.16, 0.60],
        [1.12, 0.68],
        [1.15, 0.76],
        [1.19, 0.79],
        [1.23, 0.85],
        [1.20, 0.92],
        [1.10, 0.95],
        [1.0, 1.0],
    ];
    shape.join(lathe(
        rolls,
        &profile.map(|[out, up]| [out * radius, up * radius]),
        32,
    ));
    shape
}

/// A bell with two rows of leaves, volutes at its corners and a slab on top, based at the origin.
fn corinthian(gilt: MaterialId, stone: MaterialId, radius: f32, height: f32) -> Shape {
    let bell: [[f32; 2]; 7] = [
        [1.0, 0.0],
        [1.1, 0.02],
        [1.0, 0.05],
        [0.95, 0.3],
        [1.0, 0.6],
        [1.16, 0.8],
        [1.3, 0.86],
    ];
    let mut shape = lathe(stone, &bell.map(|[out, up]| [out * radius, up * height]), 24);
    for (row, foot, top) in [(0, 0.05, 0.42), (1, 0.3, 0.74)] {
        let leaf = leaf(gilt, radius, foot * height, top * height);
        for i in 0..8 {
            let turn = (i as f32 + 0.5 * row as f32) / 8.0 * TAU;
            shape.add(&leaf, Transform::rotation([0.0, 1.0, 0.0], f64::from(turn)));
        }
    }
    let curl = superquadric(gilt, [0.2 * radius, 0.3 * radius, 0.3 * radius], 1.0, 1.0, 6, 10);
    for corner in 0..4 {
        let turn = Transform::rotation([0.0, 1.0, 0.0], f64::from(TAU) * (f64::from(corner) + 0.5) / 4.0);
        shape.add(
            &curl,
            turn * Transform::translation([0.0, 0.72 * height, 1.42 * radius]),
        );
    }
    let slab = cuboid(stone, [2.5 * radius, 0.14 * height, 2.5 * radius]);
    shape.add(&slab, Transform::translation([0.0, 0.86 * height, 0.0]));
    shape
}

/// An acanthus leaf against a bell of `radius` that curls over at its tip, facing +z.
fn leaf(material: MaterialId, radius: f32, foot: f32, top: f32) -> Shape {
    const STEPS: usize = 6;
    let row = |side: f32| -> Vec<Vec3> {
        (0..=STEPS)
            .map(|i| {
                let up = i as f32 / STEPS as f32;
                let wide = 0.36 * radius * (1.0 - 0.75 * up * up) * side;
                let curl = (up - 0.55).max(0.0);
                let out = radius * (1.04 + 0.08 * up + 1.5 * curl * curl) - 0.12 * radius * side.abs();
                vec3(wide, foot + (top - foot) * (up - 1.1 * curl * curl * up), out)
            })
            .collect()
    };
    let [left, rib, right] = [row(-1.0), row(0.0), row(1.0)];
    let mut shape = band(material, &left, &rib);
    shape.join(band(material, &rib, &right));
    let back = shape.clone().flipped();
    shape.join(back);
    shape
}

/// A pilaster on a wall, in the wall's frame: foot at the origin.
pub(crate) fn pilaster(shop: &mut Workshop, height: f32, shaft: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("pilaster {height} {} {}", shaft.0, gilt.0), || {
        let half = 0.045 * height;
        let [base, capital] = [2.0 * half, 2.2 * half];
        let deep = 0.35 * half;
        let mut shape = Shape::new();
        for (low, high, wide, out) in [(0.0, 0.9, 1.3, 1.5), (0.9, 1.3, 1.22, 1.4), (1.3, 1.6, 1.1, 1.2)] {
            let top = high * base / 1.6;
            let foot = low * base / 1.6;
            shape.join(block(
                shaft,
                [-wide * half, foot, 0.0],
                [wide * half, top, out * deep],
            ));
        }
        shape.join(block(shaft, [-half, base, 0.0], [half, height - capital, deep]));
        for rib in 0..5 {
            let at = half * (rib as f32 - 2.0) * 0.38;
            let [left, right] = [at - 0.09 * half, at + 0.09 * half];
            shape.join(block(
                gilt,
                [left, base + 1.2 * half, deep],
                [right, height - capital - 1.2 * half, deep + 0.12 * half],
            ));
        }
        for (low, high, wide, out) in [(0.0, 0.1, 1.08, 1.3), (0.84, 1.0, 1.42, 1.9)] {
            let [foot, top] = [low, high].map(|up| height - capital + up * capital);
            shape.join(block(
                gilt,
                [-wide * half, foot, 0.0],
                [wide * half, top, out * deep],
            ));
        }
        shape.join(block(
            shaft,
            [-half, height - 0.9 * capital, 0.0],
            [half, height - 0.16 * capital, 0.9 * deep],
        ));
        for (side, up) in [
            (-0.7, 0.1),
            (0.0, 0.1),
            (0.7, 0.1),
            (-0.35, 0.4),
            (0.35, 0.4),
            (-1.0, 0.45),
            (1.0, 0.45),
        ] {
            let mut one = leaf(gilt, half, up * capital, (up + 0.42) * capital);
            one = one.bent(|at| vec3(0.9 * at.x, at.y, at.z - 0.5 * half));
            shape.add(&one, Transform::translation([side * half, height - capital, 0.0]));
        }
        shape
    })
}

/// A pedestal with a foot and a head: width and height.
pub(crate) fn pedestal(
    shop: &mut Workshop,
    width: f32,
    height: f32,
    stone: MaterialId,
    inlay: MaterialId,
) -> Arc<Mesh> {
    shop.piece(
        format!("pedestal {width} {height} {} {}", stone.0, inlay.0),
        || {
            let mut shape = Shape::new();
            for (low, high, wide) in [
                (0.0, 0.12, 1.2),
                (0.12, 0.17, 1.1),
                (0.17, 0.84, 0.94),
                (0.84, 0.88, 1.02),
                (0.88, 0.96, 1.14),
                (0.96, 1.0, 1.06),
            ] {
                let half = 0.5 * width * wide;
                shape.join(block(
                    stone,
                    [-half, low * height, -half],
                    [half, high * height, half],
                ));
            }
            let [half, out] = [0.33 * width, 0.477 * width];
            let tablet = block(
                inlay,
                [-half, 0.26 * height, 0.4 * width],
                [half, 0.75 * height, out],
            );
            for side in 0..4 {
                let turn = f64::from(TAU) * f64::from(side) / 4.0;
                shape.add(&tablet, Transform::rotation([0.0, 1.0, 0.0], turn));
            }
            shape
        },
    )
}
