//! Surfaces through rings of vertices: lathed shapes, balls, knots.

use super::Shape;
use enfilade::MaterialId;
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::TAU;

/// Returns points of the unit circle as (x, z), counter-clockwise as seen from above, starting at x = 1.
pub(crate) fn around(sides: usize) -> impl Iterator<Item = Vec2> {
    (0..sides).map(move |side| {
        let (sin, cos) = (TAU * side as f64 / sides as f64).sin_cos();
        vec2(cos as f32, -sin as f32)
    })
}

/// Creates the surface through closed rings with equal numbers of corners. Each ring is counter-clockwise as seen from
/// the last; a ring of equal corners is a tip.
pub(crate) fn loft(material: MaterialId, rings: &[Vec<Vec3>]) -> Shape {
    let mut shape = Shape::new();
    for pair in rings.windows(2) {
        let [below, above] = [&pair[0], &pair[1]];
        for i in 0..below.len() {
            let next = (i + 1) % below.len();
            shape.triangle(material, [below[i], below[next], above[next]]);
            shape.triangle(material, [below[i], above[next], above[i]]);
        }
    }
    shape
}

/// Creates the surface of revolution of a profile of (radius, height), from the foot up. It is closed if both ends have
/// radius 0, or if the profile ends where it starts.
pub(crate) fn lathe(material: MaterialId, profile: &[[f32; 2]], sides: usize) -> Shape {
    let rings: Vec<Vec<Vec3>> = (profile.iter())
        .map(|&[radius, height]| {
            around(sides)
                .map(|at| vec3(radius * at.x, height, radius * at.y))
                .collect()
        })
        .collect();
    loft(material, &rings)
}

/// Creates a ball around the origin.
pub(crate) fn ball(material: MaterialId, radius: f32, rings: usize, sides: usize) -> Shape {
    let profile: Vec<[f32; 2]> = (0..=rings)
        .map(|ring| {
            let (sin, cos) = (0.5 * TAU * ring as f64 / rings as f64).sin_cos();
            let out = if ring == 0 || ring == rings {
                0.0
            } else {
                sin as f32
            };
            [radius * out, -radius * cos as f32]
        })
        .collect();
    lathe(material, &profile, sides)
}

/// Creates a tube along a torus knot about the y axis: `turns` times around the axis, `coils` times around the ring.
#[expect(
    clippy::too_many_arguments,
    reason = "the numbers of a knot, each with its own meaning"
)]
pub(crate) fn knot(
    material: MaterialId,
    turns: u32,
    coils: u32,
    ring_radius: f32,
    coil_radius: f32,
    radius: f32,
    steps: usize,
    sides: usize,
) -> Shape {
    let at = |step: usize| -> (Vec3, Vec3) {
        let part = (step % steps) as f64 / steps as f64;
        let (sin, cos) = (TAU * f64::from(turns) * part).sin_cos();
        let (coil_sin, coil_cos) = (TAU * f64::from(coils) * part).sin_cos();
        let out = vec3(cos as f32, 0.0, -sin as f32);
        let from_ring = out * coil_cos as f32 + Vec3::Y * coil_sin as f32;
        (out * ring_radius + from_ring * coil_radius, from_ring)
    };
    let rings: Vec<Vec<Vec3>> = (0..=steps)
        .map(|step| {
            let (center, from_ring) = at(step);
            let forward = (at(step + 1).0 - at(step + steps - 1).0).normalize();
            let across = (from_ring - forward * from_ring.dot(forward)).normalize();
            ring(center, across, forward.cross(across), radius, sides)
        })
        .collect();
    loft(material, &rings)
}

/// Returns a circle in the plane of `across` and `up`, counter-clockwise as seen from `across` × `up`.
fn ring(center: Vec3, across: Vec3, up: Vec3, radius: f32, sides: usize) -> Vec<Vec3> {
    around(sides)
        .map(|at| center + radius * (at.x * across - at.y * up))
        .collect()
}
