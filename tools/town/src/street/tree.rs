//! Trees of single leaves.

use crate::material::Material;
use crate::mesh::Mesh;
use crate::random::Random;
use crate::tile::Items;
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// Returns a random direction.
fn direction(random: &mut Random) -> Vector {
    let [y, turn] = [random.around(1.0), random.between(0.0, TAU)];
    let wide = (1.0 - y * y).sqrt();
    v(wide * turn.sin(), y, wide * turn.cos())
}

/// Adds a leaf: two triangles, folded along the middle; its normals are between its own and `away`.
fn leaf(mesh: &mut Mesh, at: Vector, size: f64, away: Vector) {
    let along = (direction(&mut mesh.random) + away * 0.5 - Vector::Y * 0.3).unit();
    let aside = along.cross(direction(&mut mesh.random)).unit();
    let front = aside.cross(along);
    let [tip, fold] = [
        at + along * size,
        at + along * (0.5 * size) - front * (0.12 * size),
    ];
    let [left, right] = [fold - aside * (0.35 * size), fold + aside * (0.35 * size)];
    let normal = |turn: f64| (front + aside * turn + away).unit();
    mesh.smooth_quad([
        (at, normal(0.0)),
        (right, normal(0.4)),
        (tip, normal(0.0)),
        (left, normal(-0.4)),
    ]);
}

/// Adds leaves within an ellipsoid, more of them near its surface.
pub(crate) fn leaves(
    mesh: &mut Mesh,
    center: Vector,
    radii: Vector,
    count: usize,
    size: f64,
    material: Material,
) {
    mesh.material = material;
    for _ in 0..count {
        let away = direction(&mut mesh.random);
        let far = mesh.random.unit().sqrt();
        let at = v(away.x * radii.x, away.y * radii.y, away.z * radii.z) * far;
        let size = size * mesh.random.between(0.7, 1.3);
        leaf(mesh, center + at, size, away);
    }
}

/// Adds a tree as items: its trunk with branches, and four parts of its crown.
pub(crate) fn tree(items: &mut Items, name: &str, at: Vector, height: f64, spread: f64) {
    let mut random = items.random(&format!("{name} plan"));
    let crown = v(0.0, 0.66 * height, 0.0);
    let mut twigs = Vec::new();
    let count = 24;
    for i in 0..count {
        let turn = (i as f64 + random.unit()) / count as f64 * 4.0 * TAU;
        let up = random.between(-0.75, 0.95);
        let wide = (1.0 - up * up).sqrt() * random.between(0.6, 0.85);
        let end = crown
            + v(
                wide * spread * turn.sin(),
                0.3 * height * up,
                wide * spread * turn.cos(),
            );
        let start = 0.3 + 0.45 * random.unit() + 0.08 * up;
        twigs.push((v(0.0, start * height, 0.0), end));
    }
    let foliage = random.pick(&[Material::Leaf, Material::Leaf, Material::LightLeaf]);
    let frame = Frame::upright(at, random.between(0.0, TAU));
    items.add(&format!("{name} trunk"), |mesh| {
        mesh.frame = frame;
        mesh.material = Material::Bark;
        let sides = mesh.segments(12.0, 5);
        let thick = 0.028 * height;
        let steps = mesh.segments(10.0, 4);
        let trunk: Vec<_> = (0..=steps)
            .map(|i| {
                let share = i as f64 / steps as f64;
                let bend = 0.02 * height * (share * 5.0).sin();
                let radius = thick * (1.0 - 0.8 * share) + 0.5 * thick * (1.0 - share).powi(8);
                (v(bend, share * 0.8 * height - 0.1, 0.5 * bend), radius)
            })
            .collect();
        mesh.tube(&trunk, sides);
        for &(start, end) in &twigs {
            let middle = start.lerp(end, 0.5) + v(0.0, 0.03 * height, 0.0);
            let path = [(start, 0.25 * thick), (middle, 0.16 * thick), (end, 0.05 * thick)];
            mesh.tube(&path, sides.div_ceil(2).max(3));
        }
    });
    for quarter in 0..4 {
        items.add(&format!("{name} crown {quarter}"), |mesh| {
            mesh.frame = frame;
            for &(_, end) in &twigs[quarter * count / 4..(quarter + 1) * count / 4] {
                let count = mesh.many(100.0 * spread * spread, 10);
                let radius = 0.36 * spread;
                leaves(mesh, end, v(radius, 0.8 * radius, radius), count, 0.17, foliage);
            }
        });
    }
}

/// Adds grass on an area.
pub(crate) fn grass(mesh: &mut Mesh, low: Vector, high: Vector) {
    mesh.material = Material::Leaf;
    let count = mesh.many(28.0 * (high.x - low.x) * (high.z - low.z), 1);
    for _ in 0..count {
        let at = v(
            mesh.random.between(low.x, high.x),
            low.y,
            mesh.random.between(low.z, high.z),
        );
        let turn = mesh.random.between(0.0, TAU);
        let aside = v(turn.sin(), 0.0, turn.cos()) * 0.012;
        let tip = v(
            mesh.random.around(0.08),
            mesh.random.between(0.08, 0.2),
            mesh.random.around(0.08),
        );
        let bend = at + tip * 0.5 + v(0.0, 0.02, 0.0);
        let normal = Vector::Y;
        mesh.smooth_quad([
            (at - aside, normal),
            (at + aside, normal),
            (bend + aside, normal),
            (at + tip, normal),
        ]);
    }
}
