//! Surfaces through rings of vertices: lathed shapes, tubes, balls, knots.

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

/// Creates an open ribbon between two rows with equal numbers of corners; seen from its front, `left` runs up on the
/// left.
pub(crate) fn band(material: MaterialId, left: &[Vec3], right: &[Vec3]) -> Shape {
    let mut shape = Shape::new();
    for i in 0..left.len() - 1 {
        shape.triangle(material, [left[i], right[i], right[i + 1]]);
        shape.triangle(material, [left[i], right[i + 1], left[i + 1]]);
    }
    shape
}

/// Creates a cloth through columns with equal numbers of vertices (position and texture coordinates). Seen from its
/// front, columns run from left to right, and each from its lower end up.
pub(crate) fn cloth(material: MaterialId, columns: &[Vec<(Vec3, Vec2)>]) -> Shape {
    let mut shape = Shape::new();
    for pair in columns.windows(2) {
        let [left, right] = [&pair[0], &pair[1]];
        for i in 0..left.len() - 1 {
            for corners in [
                [left[i], right[i], right[i + 1]],
                [left[i], right[i + 1], left[i + 1]],
            ] {
                shape.placed(
                    material,
                    &corners.map(|(at, _)| at),
                    &corners.map(|(_, place)| place),
                );
            }
        }
    }
    shape
}

/// Creates the surface of revolution of a profile of (radius, height), from the foot up. It is closed if both ends have
/// radius 0, or if the profile ends where it starts.
pub(crate) fn lathe(material: MaterialId, profile: &[[f32; 2]], sides: usize) -> Shape {
    fluted(material, profile, sides, 1, 0.0)
}

/// Creates a fluted surface of revolution: flutes `depth` of the radius deep, with `steps` sides each.
pub(crate) fn fluted(
    material: MaterialId,
    profile: &[[f32; 2]],
    flutes: usize,
    steps: usize,
    depth: f32,
) -> Shape {
    // Flutes have the profile of an arc; the first step of each is the ridge between two.
    let cut = |step: usize| {
        let along = step as f32 / steps as f32;
        1.0 - depth * (4.0 * along * (1.0 - along)).sqrt()
    };
    let rings: Vec<Vec<Vec3>> = (profile.iter())
        .map(|&[radius, height]| {
            around(flutes * steps)
                .enumerate()
                .map(|(i, at)| {
                    let at = at * radius * cut(i % steps);
                    vec3(at.x, height, at.y)
                })
                .collect()
        })
        .collect();
    turned(material, profile, &rings)
}

/// Creates the surface through the rings of a lathe. Its texture runs along the rings from one side to the other and
/// back mirrored, so that it has no seam; across the rings it is as long as the profile.
fn turned(material: MaterialId, profile: &[[f32; 2]], rings: &[Vec<Vec3>]) -> Shape {
    let sides = rings[0].len();
    let widest = profile.iter().fold(0.0, |most: f32, at| most.max(at[0]));
    let around = |side: usize| {
        let part = side as f32 / sides as f32;
        TAU as f32 * widest * part.min(1.0 - part)
    };
    let mut shape = Shape::new();
    let mut below = 0.0;
    for (pair, ends) in rings.windows(2).zip(profile.windows(2)) {
        let above = below - vec2(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]).length();
        for i in 0..sides {
            let next = (i + 1) % sides;
            let corner = |ring: usize, side: usize, index: usize| {
                let up = if ring == 0 { below } else { above };
                (pair[ring][index], vec2(around(side), up))
            };
            let [a, b, c, d] = [
                corner(0, i, i),
                corner(0, i + 1, next),
                corner(1, i + 1, next),
                corner(1, i, i),
            ];
            for corners in [[a, b, c], [a, c, d]] {
                shape.placed(
                    material,
                    &corners.map(|(at, _)| at),
                    &corners.map(|(_, place)| place),
                );
            }
        }
        below = above;
    }
    shape
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

/// Creates a round tube along a path, closed at both ends. `radius` is evaluated at fractions of the path's corners.
pub(crate) fn tube(material: MaterialId, path: &[Vec3], radius: impl Fn(f32) -> f32, sides: usize) -> Shape {
    let last = path.len() - 1;
    let along = |i: usize| (path[(i + 1).min(last)] - path[i.saturating_sub(1)]).normalize();
    let mut across = along(0).any_orthonormal_vector();
    let mut rings = vec![vec![path[0]; sides]];
    for (i, &center) in path.iter().enumerate() {
        let forward = along(i);
        // Parallel transport from corner to corner, so that the tube does not twist.
        across = (across - forward * across.dot(forward)).normalize();
        rings.push(ring(
            center,
            across,
            forward.cross(across),
            radius(i as f32 / last as f32),
            sides,
        ));
    }
    rings.push(vec![path[last]; sides]);
    loft(material, &rings)
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

/// Creates a torus about the y axis.
pub(crate) fn round_tube(
    material: MaterialId,
    ring_radius: f32,
    radius: f32,
    sides: usize,
    steps: usize,
) -> Shape {
    let profile: Vec<[f32; 2]> = (0..=steps)
        .map(|step| {
            let (sin, cos) = (TAU * (step % steps) as f64 / steps as f64).sin_cos();
            [ring_radius + radius * cos as f32, radius * sin as f32]
        })
        .collect();
    lathe(material, &profile, sides)
}

/// Returns a circle in the plane of `across` and `up`, counter-clockwise as seen from `across` × `up`.
fn ring(center: Vec3, across: Vec3, up: Vec3, radius: f32, sides: usize) -> Vec<Vec3> {
    around(sides)
        .map(|at| center + radius * (at.x * across - at.y * up))
        .collect()
}
