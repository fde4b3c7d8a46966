//! A parked car. Its frame is on the ground, z toward its front.

use crate::material::Material;
use crate::mesh::Mesh;
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// A cross-section of the body: z, half width, lower and upper height.
type Station = [f64; 4];

const BODY: [Station; 11] = [
    [-2.1, 0.7, 0.45, 0.72],
    [-2.05, 0.79, 0.3, 0.85],
    [-1.8, 0.84, 0.24, 0.93],
    [-1.2, 0.87, 0.22, 0.95],
    [-0.4, 0.87, 0.22, 0.94],
    [0.4, 0.87, 0.22, 0.93],
    [0.9, 0.87, 0.22, 0.92],
    [1.4, 0.85, 0.22, 0.86],
    [1.85, 0.8, 0.24, 0.78],
    [2.05, 0.74, 0.3, 0.7],
    [2.12, 0.65, 0.4, 0.6],
];

/// Corners of the roof above the windows: z at the belt line and at the roof.
const CABIN: [[f64; 2]; 2] = [[-1.75, -1.3], [1.0, 0.3]];
const BELT: f64 = 0.92;
const AXLES: [f64; 2] = [-1.28, 1.32];
const WHEEL: f64 = 0.31;

/// Returns a station between those of [`BODY`].
fn station(share: f64) -> Station {
    let at = share * (BODY.len() - 1) as f64;
    let index = (at as usize).min(BODY.len() - 2);
    let between = at - index as f64;
    std::array::from_fn(|i| BODY[index][i] + (BODY[index + 1][i] - BODY[index][i]) * between)
}

/// Returns a point of a cross-section: a rounded rectangle that is narrower above.
fn section([z, half, low, high]: Station, turn: f64) -> Vector {
    let (sine, cosine) = turn.sin_cos();
    let round = |value: f64| value.signum() * value.abs().powf(0.5);
    let up = round(-cosine);
    let narrow = if up > 0.0 { 1.0 - 0.08 * up } else { 1.0 };
    v(
        half * narrow * round(sine),
        (low + high) / 2.0 + (high - low) / 2.0 * up,
        z,
    )
}

pub(super) fn car(mesh: &mut Mesh, place: Frame) {
    let size = mesh.random.between(0.94, 1.04);
    mesh.frame = place;
    let paint = mesh.random.pick(&[
        Material::Red,
        Material::Blue,
        Material::Silver,
        Material::Paint,
        Material::Rubber,
        Material::Ochre,
    ]);
    let roof = mesh.random.between(1.38, 1.5);
    body(mesh, paint, size);
    cabin(mesh, paint, size, roof);
    for z in AXLES {
        for side in [-1.0, 1.0] {
            mesh.frame = place.turned(v(side * 0.78 * size, WHEEL, z * size), side * TAU / 4.0);
            wheel(mesh);
        }
    }
    mesh.frame = place;
    details(mesh, size);
}

fn body(mesh: &mut Mesh, paint: Material, size: f64) {
    mesh.material = paint;
    let rows = mesh.segments(18.0, 8);
    let columns = mesh.segments(18.0, 8);
    let point =
        |column: f64, row: f64| section(station(row / rows as f64), column / columns as f64 * TAU) * size;
    let point = |column: f64, row: f64| {
        let at = point(column, row);
        v(at.x, at.y / size, at.z)
    };
    mesh.grid([columns, rows], |column, row| {
        let (column, row) = (column as f64, row as f64);
        let around = point(column + 0.3, row) - point(column - 0.3, row);
        let [before, after] = [(row - 0.5).max(0.0), (row + 0.5).min(rows as f64)];
        let along = point(column, after) - point(column, before);
        (point(column, row), around.cross(along).unit())
    });
    for (row, is_front) in [(0.0, false), (rows as f64, true)] {
        let mut cap: Vec<Vector> = (0..columns).map(|column| point(column as f64, row)).collect();
        if !is_front {
            cap.reverse();
        }
        mesh.polygon(&cap);
    }
}

fn cabin(mesh: &mut Mesh, paint: Material, size: f64, roof: f64) {
    let [[back, back_top], [front, front_top]] = CABIN.map(|end| end.map(|z| z * size));
    let [wide, narrow] = [0.8 * size, 0.62 * size];
    let low = [
        v(-wide, BELT, back),
        v(wide, BELT, back),
        v(wide, BELT, front),
        v(-wide, BELT, front),
    ];
    let high = [
        v(-narrow, roof - 0.06, back_top),
        v(narrow, roof - 0.06, back_top),
        v(narrow, roof - 0.06, front_top),
        v(-narrow, roof - 0.06, front_top),
    ];
    mesh.material = Material::Glass;
    for (a, b) in [(1, 0), (2, 1), (3, 2), (0, 3)] {
        mesh.quad(low[a], low[b], high[b], high[a]);
    }
    mesh.material = paint;
    let sides = mesh.segments(6.0, 3);
    for i in 0..4 {
        mesh.tube(&[(low[i], 0.04), (high[i], 0.035)], sides);
    }
    for side in [-1.0, 1.0] {
        let [at, top] = [v(side * wide, BELT, -0.25), v(side * narrow, roof - 0.06, -0.3)];
        mesh.tube(&[(at, 0.035), (top, 0.03)], sides);
    }
    // The roof is crowned.
    let cells = mesh.segments(10.0, 3);
    let over = |column: usize, row: usize| {
        let [x, z] = [column, row].map(|i| 2.0 * i as f64 / cells as f64 - 1.0);
        let middle = (front_top + back_top) / 2.0;
        let half = (front_top - back_top) / 2.0 + 0.04;
        let rise = 0.08 * (1.0 - x.powi(4)) * (1.0 - 0.7 * z.powi(4));
        let normal = v(0.3 * x.powi(3), 1.0, 0.2 * z.powi(3)).unit();
        (
            v(x * (narrow + 0.04), roof - 0.08 + rise, middle + z * half),
            normal,
        )
    };
    mesh.grid([cells, cells], |column, row| over(column, cells - row));
    mesh.material = Material::Dark;
    mesh.grid([cells, cells], |column, row| {
        let (at, normal) = over(column, row);
        (at - v(0.0, 0.02, 0.0), -normal)
    });
    mesh.material = Material::Cloth;
    for (x, z) in [(-0.38, 0.05), (0.38, 0.05), (-0.38, -0.85), (0.38, -0.85)] {
        let center = v(x * size, 0.0, z * size);
        mesh.ellipsoid(center + v(0.0, 0.95, 0.0), v(0.23, 0.3, 0.08), 2 * sides);
        mesh.ellipsoid(center + v(0.0, 1.24, -0.02), v(0.11, 0.08, 0.05), sides);
    }
    mesh.material = Material::Rubber;
    let wheel = v(-0.38 * size, 0.98, 0.55 * size);
    let rim: Vec<_> = (0..=2 * sides)
        .map(|i| {
            let (sine, cosine) = (i as f64 / (2 * sides) as f64 * TAU).sin_cos();
            (wheel + v(0.17 * sine, 0.16 * cosine, 0.05 * cosine), 0.014)
        })
        .collect();
    mesh.tube(&rim, sides);
}

/// Adds a wheel; its axis is z, outward.
fn wheel(mesh: &mut Mesh) {
    let upright = mesh.frame;
    let lying = Frame {
        origin: Vector::ZERO,
        x: Vector::X,
        y: Vector::Z,
        z: -Vector::Y,
    };
    mesh.frame = upright.then(lying);
    let sides = mesh.segments(22.0, 8);
    mesh.material = Material::Rubber;
    mesh.lathe(
        &[
            (0.2, -0.11),
            (WHEEL - 0.03, -0.1),
            (WHEEL, -0.06),
            (WHEEL, 0.07),
            (WHEEL - 0.03, 0.11),
            (0.2, 0.12),
        ],
        sides,
    );
    mesh.material = Material::Silver;
    mesh.lathe(&[(0.2, 0.12), (0.185, 0.12), (0.18, 0.04), (0.0, 0.05)], sides);
    for spoke in 0..6 {
        let turned = upright
            .then(lying)
            .turned(Vector::ZERO, f64::from(spoke) * TAU / 6.0);
        mesh.frame = turned;
        mesh.cuboid(v(-0.02, 0.04, 0.04), v(0.02, 0.1, 0.185));
    }
    mesh.frame = upright.then(lying);
    mesh.lathe(
        &[(0.05, 0.05), (0.05, 0.11), (0.03, 0.125), (0.0, 0.125)],
        sides / 2,
    );
    mesh.frame = upright;
}

fn details(mesh: &mut Mesh, size: f64) {
    let sides = mesh.segments(10.0, 5);
    for side in [-1.0, 1.0] {
        mesh.material = Material::Lamp;
        mesh.ellipsoid(
            v(side * 0.56 * size, 0.64, 2.04 * size),
            v(0.13, 0.07, 0.08),
            sides,
        );
        mesh.material = Material::Red;
        mesh.ellipsoid(
            v(side * 0.62 * size, 0.74, -2.04 * size),
            v(0.12, 0.07, 0.07),
            sides,
        );
        mesh.material = Material::Rubber;
        mesh.ellipsoid(
            v(side * 0.95 * size, 0.98, 0.72 * size),
            v(0.1, 0.07, 0.05),
            sides,
        );
        mesh.tube(
            &[
                (v(side * 0.8 * size, 0.93, 0.75 * size), 0.015),
                (v(side * 0.92 * size, 0.96, 0.73 * size), 0.015),
            ],
            4,
        );
        mesh.material = Material::Silver;
        for z in [-0.75, 0.15] {
            let out = side * 0.86 * size;
            mesh.ellipsoid(v(out, 0.78, z * size), v(0.025, 0.02, 0.09), sides);
        }
    }
    mesh.material = Material::Rubber;
    for (z, out) in [(2.13, 0.06), (-2.11, -0.06)] {
        let bumper: Vec<_> = (0..=8)
            .map(|i| {
                let x = f64::from(i) / 4.0 - 1.0;
                (v(0.74 * size * x, 0.42, z * size + out * (0.4 - x * x)), 0.05)
            })
            .collect();
        mesh.tube(&bumper, sides);
    }
    mesh.material = Material::Paint;
    mesh.cuboid(v(-0.26, 0.5, 2.1 * size), v(0.26, 0.61, 2.16 * size));
    mesh.cuboid(v(-0.26, 0.52, -2.16 * size), v(0.26, 0.63, -2.08 * size));
}
