//! The superquadric: between box and ball.

use super::{Shape, loft};
use enfilade::MaterialId;
use glam::{Vec3, vec3};
use std::f64::consts::PI;

/// Creates a superquadric: exponents of 1 make an ellipsoid, 0 a box, 2 an octahedron.
///
/// `upright` shapes the outline from the side, `around` the outline from above. Source: Barr. Superquadrics and
/// angle-preserving transformations. 1981.
pub(crate) fn superquadric(
    material: MaterialId,
    [x, y, z]: [f32; 3],
    upright: f64,
    around: f64,
    rings: usize,
    sides: usize,
) -> Shape {
    let power = |value: f64, exponent: f64| value.signum() * value.abs().powf(exponent);
    let ring = |i: usize| -> Vec<Vec3> {
        let latitude = PI * (i as f64 / rings as f64 - 0.5);
        // The poles are exact, so that their rings are points and close the solid.
        let (out, height) = match i {
            0 => (0.0, -1.0),
            _ if i == rings => (0.0, 1.0),
            _ => (power(latitude.cos(), upright), power(latitude.sin(), upright)),
        };
        (0..sides)
            .map(|j| {
                let (sin, cos) = (2.0 * PI * j as f64 / sides as f64).sin_cos();
                let [east, south] = [power(cos, around), -power(sin, around)].map(|v| (out * v) as f32);
                vec3(x * east, y * height as f32, z * south)
            })
            .collect()
    };
    loft(material, &(0..=rings).map(ring).collect::<Vec<_>>())
}
