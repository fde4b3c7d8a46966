//! Curtains, swags and carpets.

use super::workshop::Workshop;
use crate::shape::{Shape, band, block, lathe};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// A curtain gathered to one side by a cord: it hangs from `wide` metres of rod, its held edge at x = 0, the free
/// one at x = `wide`. In the frame of a wall.
pub(crate) fn curtain(
    shop: &mut Workshop,
    wide: f32,
    high: f32,
    cloth: MaterialId,
    cord: MaterialId,
) -> Arc<Mesh> {
    shop.piece(format!("curtain {wide} {high} {}", cloth.0), || {
        const FOLDS: f32 = 7.0;
        const ACROSS: usize = 56;
        const DOWN: usize = 20;
        let tie = 0.4;
        let point = |across: usize, down: usize| -> Vec3 {
            let [u, v] = [across as f32 / ACROSS as f32, down as f32 / DOWN as f32];
            let up = 1.0 - v;
            // Full at the rod, a third of it at the cord, a little wider at the floor.
            let off = if up > tie {
                ((up - tie) / (1.0 - tie)).powf(1.6)
            } else {
                0.25 * ((tie - up) / tie).powf(0.7)
            };
            let breadth = wide * (0.22 + 0.78 * off);
            let deep = 0.05 + 0.03 * (1.0 - off);
            vec3(
                u * breadth,
                high * up,
                0.12 + deep * (TAU * FOLDS * u + 0.8 * v).cos(),
            )
        };
        let columns: Vec<Vec<Vec3>> = (0..=ACROSS)
            .map(|across| (0..=DOWN).rev().map(|down| point(across, down)).collect())
            .collect();
        let mut shape = Shape::new();
        for pair in columns.windows(2) {
            shape.join(band(cloth, &pair[0], &pair[1]));
        }
        let loop_at = Transform::translation([0.11 * wide, tie * high, 0.12]);
        let ring = [[1.0, -0.03], [1.1, 0.0], [1.0, 0.03], [0.94, 0.0], [1.0, -0.03]];
        shape.add(
            &lathe(cord, &ring.map(|[out, up]| [out * 0.13 * wide, up]), 20),
            loop_at,
        );
        shape
    })
}

/// Swags over a window: `count` bows of cloth under a rod, the left end at the origin.
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
            let columns: Vec<Vec<Vec3>> = (0..=ACROSS)
                .map(|across| (0..=DOWN).rev().map(|down| point(across, down)).collect())
                .collect();
            for pair in columns.windows(2) {
                shape.join(band(cloth, &pair[0], &pair[1]));
            }
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

/// A carpet: bands round a field with a medallion, thin as cloth.
pub(crate) fn carpet(
    shop: &mut Workshop,
    [wide, long]: [f32; 2],
    [ground, border, figure]: [MaterialId; 3],
) -> Arc<Mesh> {
    shop.piece(
        format!("carpet {wide} {long} {} {} {}", ground.0, border.0, figure.0),
        || {
            const THICK: f32 = 0.012;
            let [x, z] = [0.5 * wide, 0.5 * long];
            let mut shape = block(border, [-x, 0.0, -z], [x, 0.6 * THICK, z]);
            // Each layer lies a hair above the last: woven colors would be coplanar.
            for (i, (color, inset)) in [
                (figure, 0.10),
                (border, 0.14),
                (ground, 0.42),
                (figure, 0.46),
                (ground, 0.49),
            ]
            .into_iter()
            .enumerate()
            {
                let corner =
                    |a: f32, b: f32| vec3(a * (x - inset), (0.7 + 0.1 * i as f32) * THICK, b * (z - inset));
                shape.face(
                    color,
                    &[
                        corner(-1.0, 1.0),
                        corner(1.0, 1.0),
                        corner(1.0, -1.0),
                        corner(-1.0, -1.0),
                    ],
                );
            }
            let count = ((2.0 * (x - 0.28)) / 0.34) as usize;
            let rows = ((2.0 * (z - 0.28)) / 0.34) as usize;
            let mut bloom = |at: Vec3, reach: [f32; 2], color: MaterialId| {
                let [a, b] = reach;
                shape.face(
                    color,
                    &[
                        at + vec3(0.0, 0.0, b),
                        at + vec3(a, 0.0, 0.0),
                        at + vec3(0.0, 0.0, -b),
                        at + vec3(-a, 0.0, 0.0),
                    ],
                );
            };
            let up = 1.2 * THICK;
            for i in 0..=count {
                let at = (x - 0.28) * (2.0 * i as f32 / count as f32 - 1.0);
                for edge in [z - 0.28, 0.28 - z] {
                    bloom(
                        vec3(at, up, edge),
                        [0.12, 0.09],
                        if i % 2 == 0 { figure } else { ground },
                    );
                }
            }
            for i in 1..rows {
                let at = (z - 0.28) * (2.0 * i as f32 / rows as f32 - 1.0);
                for edge in [x - 0.28, 0.28 - x] {
                    bloom(
                        vec3(edge, up, at),
                        [0.09, 0.12],
                        if i % 2 == 0 { figure } else { ground },
                    );
                }
            }
            let medallions = (long / (2.2 * wide)).ceil().max(1.0);
            let [a, b] = [0.62 * (x - 0.5), 0.68 * (z - 0.5) / medallions];
            for medallion in 0..medallions as usize {
                let middle = 2.0 * (z - 0.5) * ((medallion as f32 + 0.5) / medallions - 0.5);
                for (i, size) in [1.0, 0.9, 0.6, 0.5, 0.2].into_iter().enumerate() {
                    let up = up + 0.1 * THICK * (i + 1) as f32;
                    bloom(
                        vec3(0.0, up, middle),
                        [a * size, b * size],
                        [border, figure, border, ground, figure][i],
                    );
                }
            }
            shape
        },
    )
}
