//! Curtains, swags and carpets.

use super::palette::{BLUE_RUG, GREEN_RUG, LACE, RED_RUG, ROSE_RUG, YELLOW_RUG};
use super::textures::BORDER;
use super::workshop::Workshop;
use crate::shape::{Shape, cloth as hang, lathe};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec2, Vec3, vec2, vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// Texture coordinates of cloth, for positions in metres across it and above its hem. Lace is uniform; curtains have a
/// hem 4 m below their upper edge and repeat every half metre.
fn woven(cloth: MaterialId, across: f32, up: f32) -> Vec2 {
    if cloth == LACE {
        vec2(across, -up)
    } else {
        vec2(2.0 * across, 1.0 - 0.25 * up)
    }
}

/// A curtain gathered to one side by a cord: it hangs from `wide` metres of rod, its tied edge at x = 0, the free one
/// at x = `wide`. In wall coordinates.
pub(crate) fn curtain(
    shop: &mut Workshop,
    wide: f32,
    high: f32,
    cloth: MaterialId,
    cord: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("curtain {wide} {high} {} {}", cloth.0, cord.0), || {
        const FOLDS: f32 = 6.0;
        const ACROSS: usize = 56;
        const DOWN: usize = 20;
        let tie = 0.4;
        let point = |across: usize, down: usize| -> Vec3 {
            let [u, v] = [across as f32 / ACROSS as f32, down as f32 / DOWN as f32];
            let up = 1.0 - v;
            // Full width at the rod, a third at the cord, a little wider at the floor.
            let off = if up > tie {
                ((up - tie) / (1.0 - tie)).powf(1.6)
            } else {
                0.25 * ((tie - up) / tie).powf(0.7)
            };
            let breadth = wide * (0.22 + 0.78 * off);
            // Fold depth limited for the width: deeper folds would show their dark sides.
            let deep = 0.012 + 0.24 * breadth / FOLDS;
            vec3(
                u * breadth,
                high * up,
                0.12 + deep * (TAU * FOLDS * u + 0.8 * v).cos(),
            )
        };
        let place = |across: usize, down: usize| {
            let [u, v] = [across as f32 / ACROSS as f32, down as f32 / DOWN as f32];
            // 1.5 times as wide as the rod, which makes the folds.
            woven(cloth, 1.5 * wide * u, high * (1.0 - v))
        };
        let columns: Vec<Vec<_>> = (0..=ACROSS)
            .map(|across| {
                let corner = |down| (point(across, down), place(across, down));
                (0..=DOWN).rev().map(corner).collect()
            })
            .collect();
        let mut shape = hang(cloth, &columns);
        let loop_at = Transform::translation([0.11 * wide, tie * high, 0.12]);
        let ring = [[1.0, -0.03], [1.1, 0.0], [1.0, 0.03], [0.94, 0.0], [1.0, -0.03]];
        shape.add(
            &lathe(cord, &ring.map(|[out, up]| [out * 0.13 * wide, up]), 20),
            loop_at,
        );
        shape
    })
}

/// Swags over a window: `count` arcs of cloth under a rod, the left end at the origin.
pub(crate) fn swags(
    shop: &mut Workshop,
    wide: f32,
    count: usize,
    cloth: MaterialId,
    gilt: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("swags {wide} {count} {}", cloth.0), || {
        const ACROSS: usize = 12;
        const DOWN: usize = 5;
        let step = wide / count as f32;
        let mut shape = Shape::new();
        for bow in 0..count {
            let point = |across: usize, down: usize| -> Vec3 {
                let [u, v] = [across as f32 / ACROSS as f32, down as f32 / DOWN as f32];
                let sag = (PI * u).sin();
                let out = 0.16 + 0.05 * sag * (2.5 * TAU * v).cos();
                vec3(
                    step * (bow as f32 + u),
                    -sag * (0.06 + 0.5 * v) - 0.10 * v * (1.0 - sag),
                    out,
                )
            };
            let place = |across: usize, down: usize| {
                let [u, v] = [across as f32 / ACROSS as f32, down as f32 / DOWN as f32];
                woven(cloth, 1.2 * step * u, 0.5 * (1.0 - v))
            };
            let columns: Vec<Vec<_>> = (0..=ACROSS)
                .map(|across| {
                    let corner = |down| (point(across, down), place(across, down));
                    (0..=DOWN).rev().map(corner).collect()
                })
                .collect();
            shape.join(hang(cloth, &columns));
        }
        let rod = lathe(
            gilt,
            &[
                [0.0, 0.0],
                [0.05, 0.03],
                [0.03, 0.09],
                [0.03, wide + 0.11],
                [0.05, wide + 0.17],
                [0.0, wide + 0.2],
            ],
            12,
        );
        let lying = Transform::translation([-0.1, 0.02, 0.13])
            * Transform::rotation([0.0, 0.0, 1.0], f64::from(-FRAC_PI_2));
        shape.add(&rod, lying);
        shape
    })
}

/// The rug colors: red, blue, green, rose, yellow.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rug {
    Red,
    Blue,
    Green,
    Rose,
    Yellow,
}

/// A carpet, `wide` along x, with fringes at both ends of its length along z: a border of fixed width, and as many
/// figures in the field as fit.
pub(crate) fn carpet(shop: &mut Workshop, [wide, long]: [f32; 2], rug: Rug) -> Arc<Mesh> {
    let material = match rug {
        Rug::Red => RED_RUG,
        Rug::Blue => BLUE_RUG,
        Rug::Green => GREEN_RUG,
        Rug::Rose => ROSE_RUG,
        Rug::Yellow => YELLOW_RUG,
    };
    shop.piece(format!("carpet {wide} {long} {}", material.0), || {
        const THICK: f32 = 0.012;
        let [columns, rows] = [stops(wide), stops(long)];
        let mut shape = Shape::new();
        for across in columns.windows(2) {
            for along in rows.windows(2) {
                let corners = [(0, 1), (1, 1), (1, 0), (0, 0)].map(|(i, j)| (across[i], along[j]));
                let at = corners.map(|((x, _), (z, _))| vec3(x, THICK, z));
                shape.placed(material, &at, &corners.map(|((_, u), (_, v))| vec2(u, v)));
            }
        }
        shape
    })
}

/// Returns the section boundaries of a rug along one side, relative to its middle, with their texture coordinates: the
/// border is in the texture's first half; the field repeats the second half, mirrored in turn.
fn stops(length: f32) -> Vec<(f32, f32)> {
    const FIGURE: f32 = 2.0;
    // Keeps off the texels where the border's colors blend into the field.
    const FIELD: f32 = 0.52;
    let half = 0.5 * length;
    let inner = half - BORDER;
    let quarters = 2 * (2.0 * inner / FIGURE).round().max(1.0) as usize;
    let mut stops = vec![(-half, 0.0)];
    stops.extend((0..=quarters).map(|i| {
        let at = inner * (2.0 * i as f32 / quarters as f32 - 1.0);
        (at, if i % 2 == 0 { FIELD } else { 1.0 })
    }));
    stops.push((half, 0.0));
    stops
}
