//! Chairs, stools, sofas and the throne. Fronts look to +z.

use super::ceiling::rosette;
use super::room::shift;
use super::statue::bezier;
use super::workshop::Workshop;
use crate::shape::{Shape, ball, block, cuboid, lathe, superquadric, taper, tube};
use enfilade::{MaterialId, Mesh, Transform};
use glam::{Vec3, vec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// A cabriole leg from the floor up to `height`, curved towards `out`.
pub(crate) fn cabriole(material: MaterialId, height: f32, out: Vec3, thick: f32) -> Shape {
    let foot = out * 0.06;
    let path = bezier(
        [
            foot + out * 0.03,
            vec3(0.0, 0.35 * height, 0.0) - out * 0.10,
            vec3(0.0, 0.72 * height, 0.0) + out * 0.16,
            vec3(0.0, height, 0.0),
        ],
        8,
    );
    let mut shape = tube(material, &path, |t| thick * (0.45 + 0.75 * t), 8);
    shape.add(
        &ball(material, 0.75 * thick, 6, 8),
        shift(foot.x + 0.03 * out.x, 0.6 * thick, foot.z + 0.03 * out.z),
    );
    shape
}

/// Four cabriole legs under a seat of the given width, depth and height.
fn legs(wood: MaterialId, [wide, deep]: [f32; 2], height: f32, thick: f32) -> Shape {
    let mut shape = Shape::new();
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let leg = cabriole(wood, height, vec3(x, 0.0, z).normalize(), thick);
        shape.add(&leg, shift(0.5 * x * wide, 0.0, 0.5 * z * deep));
    }
    shape
}

/// A gilded armchair with an oval back.
pub(crate) fn armchair(shop: &mut Workshop, wood: MaterialId, silk: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("armchair {} {}", wood.0, silk.0), || {
        let mut shape = legs(wood, [0.52, 0.48], 0.36, 0.032);
        shape.add(
            &superquadric(wood, [0.32, 0.045, 0.30], 0.3, 0.35, 6, 24),
            shift(0.0, 0.38, 0.0),
        );
        shape.add(
            &superquadric(silk, [0.30, 0.075, 0.28], 0.6, 0.4, 8, 24),
            shift(0.0, 0.44, 0.0),
        );
        let lean = shift(0.0, 0.84, -0.30) * Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2 - 0.2);
        let oval = Transform::scaling([0.27, 1.0, 0.33]);
        let ring = [[1.0, -0.03], [1.1, 0.0], [1.0, 0.03], [0.9, 0.0], [1.0, -0.03]];
        shape.add(&lathe(wood, &ring, 28), lean * oval);
        let pad = [
            [0.0, -0.035],
            [0.6, -0.03],
            [0.93, 0.0],
            [0.6, 0.045],
            [0.0, 0.055],
        ];
        shape.add(&lathe(silk, &pad, 28), lean * oval);
        shape.add(&rosette(wood, 0.07, 0.04), lean * shift(0.0, 0.0, -0.35));
        for side in [-1.0, 1.0] {
            let arm = bezier(
                [
                    vec3(side * 0.25, 0.74, -0.27),
                    vec3(side * 0.36, 0.70, -0.05),
                    vec3(side * 0.33, 0.68, 0.20),
                    vec3(side * 0.29, 0.64, 0.22),
                ],
                8,
            );
            shape.join(tube(wood, &arm, |_| 0.022, 7));
            let post = bezier(
                [
                    vec3(side * 0.28, 0.40, 0.12),
                    vec3(side * 0.33, 0.50, 0.22),
                    vec3(side * 0.34, 0.58, 0.10),
                    vec3(side * 0.31, 0.66, 0.17),
                ],
                6,
            );
            shape.join(tube(wood, &post, |_| 0.02, 7));
            let back = [vec3(side * 0.16, 0.40, -0.26), vec3(side * 0.17, 0.58, -0.27)];
            shape.join(tube(wood, &back, |_| 0.022, 7));
            shape.add(
                &superquadric(silk, [0.03, 0.025, 0.10], 0.7, 0.7, 6, 10),
                shift(side * 0.335, 0.715, 0.02),
            );
        }
        shape
    })
}

/// A plain chair with a splat in its back.
pub(crate) fn chair(shop: &mut Workshop, wood: MaterialId, seat: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("chair {} {}", wood.0, seat.0), || {
        let mut shape = legs(wood, [0.40, 0.38], 0.42, 0.026);
        shape.add(&cuboid(wood, [0.46, 0.05, 0.44]), shift(0.0, 0.41, 0.0));
        shape.add(
            &superquadric(seat, [0.22, 0.05, 0.21], 0.5, 0.3, 6, 20),
            shift(0.0, 0.47, 0.0),
        );
        for side in [-1.0, 1.0] {
            let post = bezier(
                [
                    vec3(side * 0.19, 0.42, -0.20),
                    vec3(side * 0.21, 0.62, -0.20),
                    vec3(side * 0.20, 0.82, -0.24),
                    vec3(side * 0.22, 1.02, -0.29),
                ],
                6,
            );
            shape.join(tube(wood, &post, |t| 0.024 - 0.006 * t, 7));
        }
        let crest = bezier(
            [
                vec3(-0.24, 1.02, -0.29),
                vec3(-0.08, 1.10, -0.31),
                vec3(0.08, 1.10, -0.31),
                vec3(0.24, 1.02, -0.29),
            ],
            8,
        );
        shape.join(tube(wood, &crest, |_| 0.026, 8));
        let splat = taper(wood, [0.10, 0.02], 0.56, [0.17, 0.02]);
        shape.add(
            &splat,
            shift(0.0, 0.46, -0.205) * Transform::rotation([1.0, 0.0, 0.0], -0.15),
        );
        shape
    })
}

/// A stool without a back.
pub(crate) fn stool(shop: &mut Workshop, wood: MaterialId, silk: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("stool {} {}", wood.0, silk.0), || {
        let mut shape = legs(wood, [0.42, 0.34], 0.34, 0.028);
        shape.add(&cuboid(wood, [0.50, 0.05, 0.42]), shift(0.0, 0.33, 0.0));
        shape.add(
            &superquadric(silk, [0.24, 0.07, 0.20], 0.6, 0.35, 6, 20),
            shift(0.0, 0.40, 0.0),
        );
        shape
    })
}

/// A sofa for three.
pub(crate) fn sofa(shop: &mut Workshop, wood: MaterialId, silk: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("sofa {} {}", wood.0, silk.0), || {
        let mut shape = Shape::new();
        for x in [-0.9, -0.3, 0.3, 0.9] {
            shape.add(&legs(wood, [0.0, 0.52], 0.32, 0.03), shift(x, 0.0, 0.0));
        }
        shape.add(&cuboid(wood, [1.98, 0.07, 0.66]), shift(0.0, 0.31, 0.0));
        for x in [-0.62, 0.0, 0.62] {
            shape.add(
                &superquadric(silk, [0.31, 0.08, 0.31], 0.5, 0.3, 8, 24),
                shift(x, 0.43, 0.02),
            );
            shape.add(
                &superquadric(silk, [0.31, 0.26, 0.06], 0.5, 0.4, 8, 24),
                shift(x, 0.74, -0.27),
            );
        }
        let crest = bezier(
            [
                vec3(-1.0, 0.92, -0.31),
                vec3(-0.4, 1.14, -0.33),
                vec3(0.4, 1.14, -0.33),
                vec3(1.0, 0.92, -0.31),
            ],
            16,
        );
        shape.join(tube(wood, &crest, |_| 0.04, 8));
        shape.join(block(silk, [-0.98, 0.36, -0.35], [0.98, 0.94, -0.30]));
        shape.add(
            &rosette(wood, 0.13, 0.05),
            shift(0.0, 1.07, -0.30) * Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2),
        );
        for side in [-1.0, 1.0] {
            let roll = Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2);
            let bolster = [
                [0.0, -0.30],
                [0.06, -0.30],
                [0.10, -0.26],
                [0.10, 0.26],
                [0.06, 0.30],
                [0.0, 0.30],
            ];
            shape.add(&lathe(silk, &bolster, 16), shift(side * 0.93, 0.62, 0.0) * roll);
            shape.add(&rosette(wood, 0.07, 0.03), shift(side * 0.93, 0.62, 0.30) * roll);
            shape.join(block(
                wood,
                [side.min(side * 0.9), 0.36, -0.3],
                [side.max(side * 0.9), 0.55, 0.3],
            ));
        }
        shape
    })
}

/// A throne: high gilded back with a sunburst, lions' feet, red velvet.
pub(crate) fn throne(shop: &mut Workshop, gilt: MaterialId, velvet: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("throne {} {}", gilt.0, velvet.0), || {
        let mut shape = legs(gilt, [0.74, 0.62], 0.46, 0.055);
        shape.add(&cuboid(gilt, [0.92, 0.12, 0.78]), shift(0.0, 0.44, 0.0));
        shape.add(
            &superquadric(velvet, [0.42, 0.09, 0.36], 0.6, 0.35, 8, 24),
            shift(0.0, 0.60, 0.02),
        );
        shape.join(block(gilt, [-0.46, 0.50, -0.42], [0.46, 1.75, -0.32]));
        shape.add(
            &superquadric(velvet, [0.36, 0.52, 0.06], 0.4, 0.4, 10, 24),
            shift(0.0, 1.18, -0.31),
        );
        for side in [-1.0, 1.0] {
            shape.join(block(
                gilt,
                [side * 0.46 - 0.06, 0.50, -0.42],
                [side * 0.46 + 0.06, 0.94, 0.36],
            ));
            shape.add(&ball(gilt, 0.085, 10, 14), shift(side * 0.46, 0.98, 0.33));
            let post = [
                [0.0, 0.0],
                [0.07, 0.0],
                [0.05, 0.08],
                [0.04, 1.1],
                [0.07, 1.2],
                [0.05, 1.26],
                [0.08, 1.36],
                [0.0, 1.48],
            ];
            shape.add(&lathe(gilt, &post, 14), shift(side * 0.48, 0.5, -0.37));
        }
        let sun = shift(0.0, 1.98, -0.37) * Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2);
        shape.add(&sunburst(gilt, 0.42), sun);
        shape
    })
}

/// A disc with rays, flat in the plane y = 0, its middle at the origin.
pub(crate) fn sunburst(gilt: MaterialId, reach: f32) -> Shape {
    const RAYS: u32 = 24;
    let mut shape = lathe(
        gilt,
        &[
            [0.0, -0.03],
            [0.34, -0.03],
            [0.36, 0.0],
            [0.30, 0.05],
            [0.0, 0.09],
        ]
        .map(|[r, y]| [r * reach, y]),
        32,
    );
    for ray in 0..RAYS {
        let long = if ray % 2 == 0 { 1.0 } else { 0.76 } * reach;
        let one = taper(gilt, [0.085 * reach, 0.035], long, [0.0, 0.0]);
        let turn = Transform::rotation([0.0, 1.0, 0.0], 2.0 * PI * f64::from(ray) / f64::from(RAYS));
        shape.add(&one, turn * Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2));
    }
    shape
}
