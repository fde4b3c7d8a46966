//! Heads for statues and busts: a ball displaced by bumps.

use crate::shape::{Shape, loft};
use enfilade::MaterialId;
use glam::{Vec3, vec3};
use std::f64::consts::PI;

/// Hairstyle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hair {
    /// Waves, and a knot at the back.
    Knot,
    /// Short curls.
    Curls,
    /// A wig down to the shoulders.
    Wig,
    /// Curls and a beard.
    Beard,
}

/// A soft bump: position on the ball (right, up, towards the viewer), width, height.
struct Bump(Vec3, f32, f32);

const FACE: [Bump; 13] = [
    // The nose, from its tip to its bridge.
    Bump(vec3(0.0, -0.12, 0.98), 0.10, 0.20),
    Bump(vec3(0.0, 0.03, 1.0), 0.09, 0.12),
    Bump(vec3(0.0, 0.16, 0.98), 0.10, 0.05),
    // Eye sockets, with the eyeballs in them.
    Bump(vec3(-0.34, 0.10, 0.92), 0.17, -0.10),
    Bump(vec3(0.34, 0.10, 0.92), 0.17, -0.10),
    Bump(vec3(-0.32, 0.08, 0.93), 0.08, 0.06),
    Bump(vec3(0.32, 0.08, 0.93), 0.08, 0.06),
    // Brow, cheeks, lips, chin.
    Bump(vec3(0.0, 0.30, 0.94), 0.30, 0.05),
    Bump(vec3(-0.48, -0.16, 0.82), 0.22, 0.04),
    Bump(vec3(0.48, -0.16, 0.82), 0.22, 0.04),
    Bump(vec3(0.0, -0.38, 0.90), 0.13, 0.09),
    Bump(vec3(0.0, -0.50, 0.84), 0.10, -0.03),
    Bump(vec3(0.0, -0.66, 0.72), 0.18, 0.12),
];

/// A head facing +z, its middle at the origin, `size` from chin to crown.
pub(crate) fn head(material: MaterialId, size: f32, hair: Hair) -> Shape {
    const RINGS: usize = 30;
    const SIDES: usize = 36;
    let point = |ring: usize, side: usize| {
        let (sin, cos) = (PI * ring as f64 / RINGS as f64).sin_cos();
        let (turn_sin, turn_cos) = (2.0 * PI * side as f64 / SIDES as f64).sin_cos();
        let out = if ring == 0 || ring == RINGS { 0.0 } else { sin };
        let toward = vec3((out * turn_cos) as f32, -cos as f32, -(out * turn_sin) as f32);
        toward * radius(toward, hair) * vec3(0.40, 0.5, 0.47) * size
    };
    let rings: Vec<Vec<Vec3>> = (0..=RINGS)
        .map(|ring| (0..SIDES).map(|side| point(ring, side)).collect())
        .collect();
    loft(material, &rings)
}

fn radius(toward: Vec3, hair: Hair) -> f32 {
    let bump = |Bump(at, width, height): &Bump| {
        let off = toward.distance(at.normalize()) / width;
        height * (-0.5 * off * off).exp()
    };
    // Jaws are narrower than brows.
    let jaw = 1.0 - 0.16 * (-toward.y).max(0.0) * (1.0 - toward.z.max(0.0));
    jaw + FACE.iter().map(bump).sum::<f32>() + hair_height(toward, hair)
}

fn hair_height(toward: Vec3, hair: Hair) -> f32 {
    let turn = toward.x.atan2(toward.z);
    let step = |value: f32, width: f32| (0.5 + value / width).clamp(0.0, 1.0);
    // Distance behind the hairline, which runs over the brow and before the ears.
    let scalp = step(toward.y - 0.45 + 1.3 * (0.25 - toward.z).max(-0.3), 0.16);
    let back = step(-0.05 - toward.z, 0.3) * step(toward.y + 0.75, 0.3);
    match hair {
        Hair::Knot => {
            let waves = 0.02 * (14.0 * turn).sin() * (9.0 * toward.y).cos();
            let knot = toward.distance(vec3(0.0, 0.25, -0.97)) / 0.34;
            scalp.max(back) * (0.10 + waves) + 0.42 * (-knot * knot * knot * knot).exp()
        }
        Hair::Curls => scalp.max(back) * (0.10 + 0.05 * (13.0 * turn).sin() * (15.0 * toward.y).sin()),
        Hair::Wig => {
            let sides = step(toward.x.abs() - 0.62, 0.2) * step(0.75 - toward.z, 0.3);
            let rolls = 0.06 * (16.0 * toward.y).sin();
            scalp.max(back).max(sides) * (0.2 + rolls) + sides.max(back) * 0.35 * (-toward.y).max(0.0)
        }
        Hair::Beard => {
            let curls = 0.05 * (13.0 * turn).sin() * (15.0 * toward.y).sin();
            let beard = step(-0.42 - toward.y, 0.2) * step(toward.z - 0.05, 0.3);
            scalp.max(back) * (0.10 + curls) + beard * (0.2 + 0.5 * curls)
        }
    }
}
