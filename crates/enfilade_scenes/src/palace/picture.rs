//! Paintings: landscapes, seascapes and still lifes made of flat colors, in gilded frames.

use super::palette::*;
use super::room::{Room, shift};
use crate::random::Random;
use crate::shape::{Shape, frame};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Hangs a painting of the given size; `place` is the wall's frame at its lower left corner.
pub(crate) fn hang_painting(room: &mut Room, place: Transform, size: [f32; 2], gilt: MaterialId) {
    let border = gilded_frame(room, size, gilt);
    room.put("picture frame", &border, place);
    let canvas = painting(&mut room.random, size).mesh();
    room.put("painting", &canvas, place * shift(0.0, 0.0, 0.2 * breadth(size)));
}

/// How broad the frame of a painting is.
fn breadth(size: [f32; 2]) -> f32 {
    0.10 + 0.04 * size[0].min(size[1])
}

/// A frame for a painting of the given size, its lower left corner at the origin.
pub(crate) fn gilded_frame(room: &mut Room, size: [f32; 2], gilt: MaterialId) -> Arc<Mesh> {
    let broad = breadth(size);
    room.shop.piece(format!("frame {size:?} {}", gilt.0), || {
        const PROFILE: [[f32; 2]; 10] = [
            [-1.0, 0.0],
            [-1.0, 0.35],
            [-0.85, 0.55],
            [-0.70, 0.45],
            [-0.60, 0.50],
            [-0.35, 0.75],
            [-0.20, 0.70],
            [-0.15, 0.55],
            [0.0, 0.40],
            [0.0, 0.15],
        ];
        frame(
            gilt,
            size,
            &PROFILE.map(|[inwards, out]| [inwards * broad, out * broad]),
        )
    })
}

/// A painting in the plane z = 0, its lower left corner at the origin.
fn painting(random: &mut Random, size: [f32; 2]) -> Shape {
    match random.below(5) {
        0 => still_life(random, size),
        1 => seascape(random, size),
        _ => landscape(random, size),
    }
}

/// One layer of a picture: the height of its upper edge along the picture, 0 to 1, and its color.
struct Layer(Box<dyn Fn(f32) -> f32>, MaterialId);

/// Layers from the bottom to the top, each from the edge of the last to its own; nothing lies over anything else.
fn layered(size: [f32; 2], layers: &[Layer]) -> Shape {
    const COLUMNS: usize = 28;
    let [wide, high] = size;
    let mut shape = Shape::new();
    let mut below = vec![0.0; COLUMNS + 1];
    for Layer(edge, color) in layers {
        let above: Vec<f32> = (0..=COLUMNS)
            .map(|i| edge(i as f32 / COLUMNS as f32).clamp(below[i], 1.0))
            .collect();
        for i in 0..COLUMNS {
            let corner = |i: usize, up: f32| vec3(wide * i as f32 / COLUMNS as f32, high * up, 0.0);
            let face = [
                corner(i, below[i]),
                corner(i + 1, below[i + 1]),
                corner(i + 1, above[i + 1]),
                corner(i, above[i]),
            ];
            shape.face(*color, &face);
        }
        below = above;
    }
    shape
}

/// Hills one behind the other: a sum of waves, rougher with every step away.
fn hills(random: &mut Random, base: f32, height: f32, waves: f32) -> Box<dyn Fn(f32) -> f32> {
    let phases: [f32; 4] = std::array::from_fn(|_| TAU * random.unit());
    Box::new(move |x| {
        let wave = |i: usize, times: f32| (waves * times * x * TAU + phases[i]).sin() / times;
        base + height * 0.4 * (wave(0, 1.0) + wave(1, 2.3) + wave(2, 4.1) + 0.7 * wave(3, 7.7))
    })
}

fn level(height: f32) -> Box<dyn Fn(f32) -> f32> {
    Box::new(move |_| height)
}

fn sky(random: &mut Random, horizon: f32) -> Vec<Layer> {
    let colors = random.pick(&[
        [PAPER, PALE_BLUE, BLUE_SILK],
        [YELLOW_SILK, ROSE, PALE_BLUE],
        [EMBER, ROSE, NIGHT_BLUE],
        [IVORY, PORCELAIN, PALE_BLUE],
    ]);
    let step = (1.0 - horizon) / 3.0;
    vec![
        Layer(hills(random, horizon + step, 0.04, 0.8), colors[0]),
        Layer(hills(random, horizon + 2.0 * step, 0.06, 0.7), colors[1]),
        Layer(level(1.0), colors[2]),
    ]
}

fn landscape(random: &mut Random, size: [f32; 2]) -> Shape {
    let horizon = random.between(0.4, 0.6);
    let mut layers = vec![
        Layer(
            hills(random, 0.12, 0.12, 0.6),
            random.pick(&[BARK, WALNUT, HEDGE]),
        ),
        Layer(
            hills(random, 0.26, 0.1, 0.9),
            random.pick(&[HEDGE, GREEN_SILK, OAK]),
        ),
        Layer(
            hills(random, 0.36, 0.08, 1.1),
            random.pick(&[LAWN, PALE_GREEN, PALE_OAK]),
        ),
        Layer(
            hills(random, horizon, 0.2, 1.6),
            random.pick(&[VERDIGRIS, PALE_BLUE, BLUE_SILK]),
        ),
    ];
    layers.extend(sky(random, horizon));
    let mut shape = layered(size, &layers);
    for _ in 0..random.below(4) {
        let at = vec3(
            size[0] * random.between(0.1, 0.9),
            size[1] * random.between(0.15, 0.3),
            0.004,
        );
        let high = size[1] * random.between(0.2, 0.42);
        tree(&mut shape, random, at, high);
    }
    shape
}

/// A trunk and a crown of overlapping discs.
fn tree(shape: &mut Shape, random: &mut Random, foot: Vec3, high: f32) {
    let thin = 0.03 * high;
    shape.face(
        BARK,
        &[
            foot - Vec3::X * thin,
            foot + Vec3::X * thin,
            foot + vec3(thin, 0.6 * high, 0.0),
            foot + vec3(-thin, 0.6 * high, 0.0),
        ],
    );
    for leaf in 0..5 {
        let off = vec3(
            random.between(-0.22, 0.22),
            random.between(0.5, 0.9),
            0.002 * (leaf + 1) as f32,
        );
        let color = random.pick(&[HEDGE, GREEN_SILK, LAWN]);
        disc(
            shape,
            color,
            foot + vec3(off.x * high, off.y * high, off.z),
            high * random.between(0.12, 0.2),
            1.0,
        );
    }
}

fn disc(shape: &mut Shape, color: MaterialId, at: Vec3, radius: f32, tall: f32) {
    let outline: Vec<Vec3> = crate::shape::around(11)
        .map(|turn| at + vec3(radius * turn.x, -radius * tall * turn.y, 0.0))
        .collect();
    shape.face(color, &outline);
}

fn seascape(random: &mut Random, size: [f32; 2]) -> Shape {
    let horizon = random.between(0.3, 0.45);
    let mut layers = vec![
        Layer(hills(random, 0.1, 0.06, 2.2), NIGHT_BLUE),
        Layer(hills(random, 0.2, 0.04, 2.8), VERDIGRIS),
        Layer(level(horizon), BLUE_SILK),
    ];
    layers.extend(sky(random, horizon));
    let mut shape = layered(size, &layers);
    for _ in 0..1 + random.below(3) {
        let high = size[1] * random.between(0.15, 0.35);
        let at = vec3(
            size[0] * random.between(0.2, 0.8),
            size[1] * random.between(0.15, horizon),
            0.004,
        );
        let corner = |x: f32, y: f32| at + vec3(x * high, y * high, 0.0);
        shape.face(
            WALNUT,
            &[
                corner(-0.3, -0.12),
                corner(0.3, -0.12),
                corner(0.42, 0.04),
                corner(-0.42, 0.04),
            ],
        );
        shape.face(
            IVORY,
            &[corner(-0.3, 0.08), corner(-0.02, 0.08), corner(-0.02, 0.85)],
        );
        shape.face(
            PAPER,
            &[corner(0.02, 0.08), corner(0.36, 0.08), corner(0.02, 1.0)],
        );
    }
    shape
}

fn still_life(random: &mut Random, size: [f32; 2]) -> Shape {
    let table = random.between(0.28, 0.38);
    let mut shape = layered(
        size,
        &[
            Layer(level(table), random.pick(&[WALNUT, DARK_RED, OAK])),
            Layer(
                hills(random, 0.8, 0.1, 0.3),
                random.pick(&[BARK, NIGHT_BLUE, HEDGE]),
            ),
            Layer(level(1.0), EBONY),
        ],
    );
    let high = 0.3 * size[1];
    let foot = vec3(0.5 * size[0], table * size[1], 0.004);
    let half = 0.16 * high;
    let corner = |x: f32, y: f32| foot + vec3(x * half, y * high, 0.0);
    let clay = random.pick(&[COBALT, TERRACOTTA, VERDIGRIS]);
    shape.face(
        clay,
        &[
            corner(-1.0, -0.2),
            corner(1.0, -0.2),
            corner(2.2, 0.5),
            corner(1.0, 0.9),
            corner(-1.0, 0.9),
            corner(-2.2, 0.5),
        ],
    );
    for flower in 0..12 {
        let at = foot
            + vec3(
                size[0] * random.between(-0.22, 0.22),
                high * random.between(1.0, 1.9),
                0.004 + 0.001 * flower as f32,
            );
        disc(
            &mut shape,
            random.pick(&[RED_SILK, ROSE, IVORY, YELLOW_SILK, LAWN]),
            at,
            high * random.between(0.12, 0.22),
            0.9,
        );
    }
    for fruit in 0..6 {
        let at = foot
            + vec3(
                size[0] * random.between(-0.35, 0.35),
                high * random.between(-0.3, 0.05),
                0.02 + 0.001 * fruit as f32,
            );
        disc(
            &mut shape,
            random.pick(&[RED_SILK, YELLOW_SILK, EMBER, DARK_RED]),
            at,
            high * random.between(0.1, 0.16),
            1.0,
        );
    }
    shape
}
