//! Statues: draped figures and busts.

use super::head::{Hair, head};
use super::room::shift;
use super::workshop::Workshop;
use crate::shape::{Shape, around, ball, lathe, loft, round_tube, superquadric, tube};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Pose and attributes of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pose {
    /// One arm raised with a torch.
    Torch,
    /// A globe held at the breast.
    Globe,
    /// A jug at the hip, one hand on it.
    Jug,
    /// Leaning on a staff.
    Staff,
    /// Both arms raised to a bowl on the head.
    Bowl,
}

impl Pose {
    pub(crate) const ALL: [Pose; 5] = [Pose::Torch, Pose::Globe, Pose::Jug, Pose::Staff, Pose::Bowl];
}

/// A robe from hem to neck: height, half width, half depth, how deep its folds are.
const ROBE: [[f32; 4]; 13] = [
    [0.00, 0.34, 0.30, 0.16],
    [0.05, 0.33, 0.29, 0.16],
    [0.30, 0.28, 0.25, 0.14],
    [0.60, 0.245, 0.215, 0.11],
    [0.85, 0.225, 0.185, 0.07],
    [1.00, 0.205, 0.155, 0.05],
    [1.10, 0.175, 0.13, 0.05],
    [1.22, 0.185, 0.145, 0.04],
    [1.32, 0.20, 0.155, 0.03],
    [1.42, 0.20, 0.125, 0.02],
    [1.49, 0.165, 0.10, 0.01],
    [1.535, 0.085, 0.075, 0.0],
    [1.62, 0.055, 0.058, 0.0],
];

/// A draped figure, 1.9 m tall, at the origin, facing +z.
pub(crate) fn figure(shop: &mut Workshop, pose: Pose, stone: MaterialId, gilt: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("figure {pose:?} {} {}", stone.0, gilt.0), || {
        let mut shape = robe(stone, pose as u8 as f32);
        let hair = if pose == Pose::Staff {
            Hair::Beard
        } else {
            Hair::Knot
        };
        let nod = Transform::rotation([0.3, 1.0, 0.0], 0.25 - 0.12 * f64::from(pose as u8));
        shape.add(&head(stone, 0.27, hair), shift(sway(1.7), 1.715, 0.015) * nod);
        arms(&mut shape, pose, stone);
        mantle(&mut shape, stone);
        carry(&mut shape, pose, gilt);
        let foot = [
            [0.0, -0.06],
            [0.37, -0.06],
            [0.385, -0.03],
            [0.37, 0.0],
            [0.0, 0.0],
        ];
        shape.join(lathe(stone, &foot, 24));
        let mut raised = Shape::new();
        raised.add(&shape, shift(0.0, 0.06, 0.0));
        raised
    })
}

/// Contrapposto: sideways offset of the body at a height.
fn sway(height: f32) -> f32 {
    0.045 * (PI * (height / 1.5).min(1.2)).sin() - 0.02 * height
}

fn robe(stone: MaterialId, turn: f32) -> Shape {
    const SIDES: usize = 56;
    const BETWEEN: usize = 3;
    let mut rings = vec![vec![Vec3::ZERO; SIDES]];
    let ring = |[height, wide, deep, fold]: [f32; 4]| -> Vec<Vec3> {
        around(SIDES)
            .enumerate()
            .map(|(i, at)| {
                let angle = TAU * i as f32 / SIDES as f32;
                // Folds of two sizes fall straight from the hips and fade towards the breast.
                let falls =
                    (9.0 * angle + turn).cos() + 0.6 * (14.0 * angle + 1.7 * turn + 2.0 * height).cos();
                // The knee of the free leg presses through.
                let knee = 0.09 * (-40.0 * (height - 0.55).powi(2) - 5.0 * (angle - 5.3).powi(2)).exp();
                let out = 1.0 + 0.62 * fold * falls + knee / wide;
                vec3(sway(height) + wide * at.x * out, height, deep * at.y * out)
            })
            .collect()
    };
    for pair in ROBE.windows(2) {
        for step in 0..BETWEEN {
            let t = step as f32 / BETWEEN as f32;
            rings.push(ring(std::array::from_fn(|i| {
                pair[0][i] + (pair[1][i] - pair[0][i]) * t
            })));
        }
    }
    rings.push(ring(ROBE[ROBE.len() - 1]));
    let top = vec3(sway(1.65), 1.66, 0.0);
    rings.push(vec![top; SIDES]);
    loft(stone, &rings)
}

fn arms(shape: &mut Shape, pose: Pose, stone: MaterialId) {
    let x = sway(1.4);
    let right_shoulder = vec3(x - 0.185, 1.42, 0.0);
    let left_shoulder = vec3(x + 0.185, 1.42, 0.0);
    let (right, left) = match pose {
        Pose::Torch => (
            [vec3(-0.40, 1.52, 0.06), vec3(-0.36, 1.80, 0.12)],
            [vec3(0.30, 1.14, -0.02), vec3(0.24, 0.92, 0.12)],
        ),
        Pose::Globe => (
            [vec3(-0.30, 1.16, 0.04), vec3(-0.08, 1.16, 0.24)],
            [vec3(0.30, 1.16, 0.04), vec3(0.10, 1.20, 0.24)],
        ),
        Pose::Jug => (
            [vec3(-0.30, 1.14, 0.02), vec3(-0.26, 0.92, 0.16)],
            [vec3(0.34, 1.18, 0.0), vec3(0.26, 1.0, 0.16)],
        ),
        Pose::Staff => (
            [vec3(-0.32, 1.20, 0.06), vec3(-0.34, 1.30, 0.26)],
            [vec3(0.30, 1.14, 0.0), vec3(0.12, 1.06, 0.20)],
        ),
        Pose::Bowl => (
            [vec3(-0.38, 1.58, 0.02), vec3(-0.20, 1.84, 0.04)],
            [vec3(0.34, 1.58, 0.02), vec3(0.16, 1.84, 0.04)],
        ),
    };
    for (shoulder, [elbow, wrist]) in [(right_shoulder, right), (left_shoulder, left)] {
        let bent = bezier([shoulder, elbow, elbow, wrist], 10);
        shape.join(tube(stone, &bent, |t| 0.062 - 0.028 * t, 12));
        let sleeve = bezier(
            [
                shoulder,
                shoulder.lerp(elbow, 0.5),
                shoulder.lerp(elbow, 0.8),
                elbow,
            ],
            6,
        );
        shape.join(tube(stone, &sleeve, |t| 0.068 + 0.03 * t, 12));
        let hand = superquadric(stone, [0.04, 0.055, 0.03], 0.9, 0.9, 6, 10);
        shape.add(&hand, shift(wrist.x, wrist.y, wrist.z));
    }
}

/// A cloak over one shoulder and round the hips, as a rope of cloth.
fn mantle(shape: &mut Shape, stone: MaterialId) {
    let round = |turn: f32, height: f32, out: f32| {
        vec3(
            sway(height) - out * 1.12 * turn.sin(),
            height,
            out * 0.92 * turn.cos(),
        )
    };
    let path: Vec<Vec3> = (0..=22)
        .map(|i| {
            let t = i as f32 / 22.0;
            // From the left shoulder, across the breast, round the right hip to the back, and down at the left.
            let turn = -1.3 + 5.2 * t;
            let height = 1.46 - 0.62 * (t * 1.25).min(1.0) - 0.25 * (t - 0.8).max(0.0);
            round(turn, height, 0.15 + 0.07 * t.min(0.75))
        })
        .collect();
    shape.join(tube(stone, &path, |t| 0.03 + 0.03 * (PI * t).sin(), 10));
    let fall: Vec<Vec3> = (0..=8)
        .map(|i| i as f32 / 8.0)
        .map(|t| vec3(0.24 + 0.03 * (3.0 * t).sin(), 0.98 - 0.62 * t, 0.06 + 0.03 * t))
        .collect();
    shape.join(tube(stone, &fall, |t| 0.045 + 0.02 * t, 9));
}

fn carry(shape: &mut Shape, pose: Pose, gilt: MaterialId) {
    match pose {
        Pose::Torch => {
            let shaft = [
                [0.0, 0.0],
                [0.012, 0.0],
                [0.02, 0.30],
                [0.045, 0.36],
                [0.03, 0.38],
                [0.0, 0.38],
            ];
            shape.add(&lathe(gilt, &shaft, 12), shift(-0.36, 1.66, 0.12));
            let flame = [
                [0.0, 0.0],
                [0.035, 0.03],
                [0.045, 0.07],
                [0.03, 0.13],
                [0.012, 0.19],
                [0.0, 0.23],
            ];
            shape.add(&lathe(gilt, &flame, 10), shift(-0.36, 2.03, 0.12));
        }
        Pose::Globe => {
            shape.add(&ball(gilt, 0.115, 14, 20), shift(0.01, 1.24, 0.30));
            let band = round_tube(gilt, 0.12, 0.008, 24, 6);
            let tilt = Transform::rotation([0.0, 0.0, 1.0], 0.5);
            shape.add(&band, shift(0.01, 1.24, 0.30) * tilt);
        }
        Pose::Jug => {
            let jug = [
                [0.0, 0.0],
                [0.05, 0.0],
                [0.03, 0.03],
                [0.09, 0.14],
                [0.08, 0.2],
                [0.03, 0.25],
                [0.05, 0.31],
                [0.0, 0.29],
            ];
            shape.add(&lathe(gilt, &jug, 16), shift(0.28, 0.78, 0.18));
        }
        Pose::Staff => {
            let staff = [
                [0.0, 0.0],
                [0.018, 0.0],
                [0.014, 1.75],
                [0.04, 1.80],
                [0.03, 1.86],
                [0.0, 1.88],
            ];
            shape.add(&lathe(gilt, &staff, 10), shift(-0.34, 0.0, 0.28));
        }
        Pose::Bowl => {
            let bowl = [
                [0.0, 0.0],
                [0.05, 0.0],
                [0.06, 0.03],
                [0.22, 0.12],
                [0.24, 0.16],
                [0.22, 0.16],
                [0.0, 0.08],
            ];
            shape.add(&lathe(gilt, &bowl, 24), shift(sway(1.7), 1.85, 0.02));
        }
    }
}

/// Points of a cubic curve that ends in its first and last control point.
pub(crate) fn bezier([a, b, c, d]: [Vec3; 4], steps: usize) -> Vec<Vec3> {
    (0..=steps)
        .map(|i| i as f32 / steps as f32)
        .map(|t| {
            a.lerp(b, t)
                .lerp(b.lerp(c, t), t)
                .lerp(b.lerp(c, t).lerp(c.lerp(d, t), t), t)
        })
        .collect()
}

/// A bust on its round foot, 0.75 m tall.
pub(crate) fn bust(shop: &mut Workshop, hair: Hair, stone: MaterialId, foot: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("bust {hair:?} {} {}", stone.0, foot.0), || {
        let socle = [
            [0.0, 0.0],
            [0.12, 0.0],
            [0.12, 0.04],
            [0.07, 0.07],
            [0.06, 0.12],
            [0.09, 0.15],
            [0.0, 0.15],
        ];
        let mut shape = lathe(foot, &socle, 24);
        let sizes: [[f32; 3]; 8] = [
            [0.15, 0.06, 0.06],
            [0.18, 0.16, 0.10],
            [0.24, 0.235, 0.13],
            [0.32, 0.255, 0.135],
            [0.38, 0.20, 0.115],
            [0.42, 0.09, 0.085],
            [0.47, 0.062, 0.066],
            [0.55, 0.06, 0.064],
        ];
        const SIDES: usize = 32;
        let mut rings = vec![vec![vec3(0.0, 0.15, 0.0); SIDES]];
        rings.extend(sizes.iter().map(|&[height, wide, deep]| {
            around(SIDES)
                .enumerate()
                .map(|(i, at)| {
                    let folds = 1.0 + 0.05 * (TAU * 7.0 * i as f32 / SIDES as f32 + 9.0 * height).cos();
                    let folds = if height > 0.4 { 1.0 } else { folds };
                    vec3(wide * at.x * folds, height, deep * at.y * folds)
                })
                .collect()
        }));
        rings.push(vec![vec3(0.0, 0.56, 0.0); SIDES]);
        shape.join(loft(stone, &rings));
        let turn = Transform::rotation([0.0, 1.0, 0.0], 0.35);
        shape.add(&head(stone, 0.28, hair), shift(0.0, 0.63, 0.01) * turn);
        shape
    })
}
