//! Closed solids with flat faces, and the superquadric between box and ball.

use super::{Shape, loft};
use enfilade::MaterialId;
use glam::{Vec3, vec3};
use std::f64::consts::PI;

/// Creates a box between two corners.
pub(crate) fn block(material: MaterialId, min: [f32; 3], max: [f32; 3]) -> Shape {
    let corner = |bits: usize| {
        Vec3::from_array(std::array::from_fn(|axis| {
            if bits >> axis & 1 == 0 {
                min[axis]
            } else {
                max[axis]
            }
        }))
    };
    let mut shape = Shape::new();
    for face in BOX_FACES {
        shape.face(material, &face.map(corner));
    }
    shape
}

/// The faces of a box, as corner indices whose bits select minimum or maximum x, y, z.
const BOX_FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// Creates a box of width, height and depth that stands on the floor over the origin.
pub(crate) fn cuboid(material: MaterialId, [width, height, depth]: [f32; 3]) -> Shape {
    let [x, z] = [0.5 * width, 0.5 * depth];
    block(material, [-x, 0.0, -z], [x, height, z])
}

/// Creates a tapered box: width and depth of foot and head. It stands on the floor over the origin.
pub(crate) fn taper(material: MaterialId, foot: [f32; 2], height: f32, head: [f32; 2]) -> Shape {
    let corner = |bits: usize| {
        let [width, depth] = if bits & 2 == 0 { foot } else { head };
        let side = |bit: usize, size: f32| if bits & bit == 0 { -0.5 * size } else { 0.5 * size };
        vec3(
            side(1, width),
            if bits & 2 == 0 { 0.0 } else { height },
            side(4, depth),
        )
    };
    let mut shape = Shape::new();
    for face in BOX_FACES {
        shape.face(material, &face.map(corner));
    }
    shape
}

/// Extrudes a convex outline by `up`; the outline is counter-clockwise as seen from the tip of `up`.
pub(crate) fn prism(material: MaterialId, outline: &[Vec3], up: Vec3) -> Shape {
    let mut shape = Shape::new();
    let raised: Vec<Vec3> = outline.iter().map(|&corner| corner + up).collect();
    let below: Vec<Vec3> = outline.iter().rev().copied().collect();
    shape.face(material, &raised);
    shape.face(material, &below);
    for i in 0..outline.len() {
        let next = (i + 1) % outline.len();
        shape.face(material, &[outline[i], outline[next], raised[next], raised[i]]);
    }
    shape
}

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
