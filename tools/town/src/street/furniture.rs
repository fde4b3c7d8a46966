//! Furniture of streets, parks and courts. Frames are on the ground, z toward the viewer.

use super::tree::leaves;
use crate::material::Material;
use crate::mesh::{End, Mesh, arc};
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

pub(super) fn lamp(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    mesh.material = Material::Metal;
    let sides = mesh.segments(14.0, 5);
    let height = mesh.random.between(3.7, 3.9);
    let pole = [
        (0.16, 0.0),
        (0.16, 0.12),
        (0.12, 0.16),
        (0.09, 0.5),
        (0.11, 0.56),
        (0.11, 0.62),
        (0.06, 0.7),
        (0.045, height - 0.4),
        (0.08, height - 0.34),
        (0.08, height - 0.28),
        (0.04, height - 0.2),
        (0.1, height),
    ];
    mesh.lathe(&pole, sides);
    // A ladder rest, and the lantern: a glass body between four ribs below a cap.
    let y = height - 0.45;
    mesh.tube(
        &[(v(-0.3, y, 0.0), 0.016), (v(0.3, y, 0.0), 0.016)],
        sides.div_ceil(2).max(3),
    );
    mesh.frame = frame.moved(v(0.0, height, 0.0));
    for rib in 0..4 {
        let (sine, cosine) = ((f64::from(rib) + 0.5) * TAU / 4.0).sin_cos();
        let on = |radius: f64, y: f64| (v(radius * sine, y, radius * cosine), 0.012);
        mesh.tube(&[on(0.12, 0.0), on(0.2, 0.45)], sides.div_ceil(2).max(3));
    }
    mesh.lathe(&[(0.0, 0.0), (0.13, 0.0), (0.13, 0.03), (0.0, 0.03)], sides);
    mesh.lathe(
        &[
            (0.0, 0.45),
            (0.26, 0.45),
            (0.26, 0.48),
            (0.16, 0.6),
            (0.06, 0.66),
            (0.06, 0.72),
            (0.03, 0.76),
            (0.0, 0.84),
        ],
        sides,
    );
    mesh.material = Material::Lamp;
    mesh.ellipsoid(v(0.0, 0.24, 0.0), v(0.07, 0.12, 0.07), sides);
    mesh.material = Material::Glass;
    mesh.lathe(&[(0.115, 0.03), (0.195, 0.45)], 4);
}

pub(super) fn bench(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    let round = mesh.segments(3.0, 1);
    let long = mesh.random.between(1.5, 1.7) / 2.0;
    mesh.material = Material::Wood;
    let slat = |mesh: &mut Mesh, origin: Vector, tilt: f64, width: f64| {
        let (sine, cosine) = tilt.sin_cos();
        mesh.frame = frame.then(Frame {
            origin,
            x: Vector::X,
            y: v(0.0, cosine, -sine),
            z: v(0.0, sine, cosine),
        });
        // A board with round edges: its upper side is toward +z of the slat.
        let mut profile = vec![(0.0, -0.02)];
        profile.extend(arc((0.01, 0.01), 0.01, [2.0, 1.0], round));
        profile.extend(arc((width - 0.01, 0.01), 0.01, [1.0, 0.0], round));
        profile.extend([(width, -0.02), (0.0, -0.02)]);
        mesh.extrude([-long, long], &profile, [End::Cap; 2]);
    };
    for i in 0..5 {
        slat(mesh, v(0.0, 0.45, 0.22 - 0.095 * f64::from(i)), TAU / 4.0, 0.08);
    }
    for i in 0..4 {
        let up = 0.12 * f64::from(i);
        slat(mesh, v(0.0, 0.52 + up, -0.24 - 0.25 * up), 0.25, 0.09);
    }
    mesh.frame = frame;
    mesh.material = Material::Metal;
    let sides = mesh.segments(8.0, 4);
    for x in [-0.8 * long, 0.8 * long] {
        let front = [(0.0, 0.26), (0.15, 0.22), (0.3, 0.19), (0.44, 0.2)];
        let back = [
            (0.0, -0.36),
            (0.2, -0.28),
            (0.43, -0.24),
            (0.7, -0.3),
            (1.0, -0.38),
        ];
        let seat = [(0.43, 0.24), (0.42, 0.0), (0.43, -0.24)];
        for curve in [&front[..], &back, &seat] {
            let path: Vec<_> = curve.iter().map(|&(y, z)| (v(x, y, z), 0.022)).collect();
            mesh.tube(&path, sides);
        }
        let rest: Vec<_> = arc((0.44, 0.0), 0.24, [1.0, -0.8], 2 * sides);
        let rest: Vec<_> = rest.iter().map(|&(y, z)| (v(x, y, z), 0.018)).collect();
        mesh.tube(&rest, sides);
    }
}

pub(super) fn bin(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    mesh.material = Material::Metal;
    let sides = mesh.segments(16.0, 6);
    let high = mesh.random.between(0.78, 0.84);
    mesh.lathe(
        &[
            (0.2, 0.0),
            (0.2, 0.04),
            (0.17, 0.06),
            (0.21, high - 0.04),
            (0.24, high),
            (0.22, high),
            (0.18, high - 0.3),
            (0.0, high - 0.3),
        ],
        sides,
    );
    mesh.material = Material::Wood;
    let slats = mesh.segments(18.0, 8);
    for slat in 0..slats {
        mesh.frame = frame.turned(Vector::ZERO, slat as f64 / slats as f64 * TAU);
        let half = 0.42 * 0.21 * TAU / slats as f64;
        mesh.cuboid(v(-half, 0.1, 0.19), v(half, high - 0.06, 0.23));
    }
}

pub(super) fn sign(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    mesh.material = Material::Silver;
    let sides = mesh.segments(14.0, 6);
    let y = mesh.random.between(2.3, 2.45);
    mesh.tube(&[(Vector::ZERO, 0.03), (v(0.0, y + 0.3, 0.0), 0.03)], sides);
    mesh.ellipsoid(v(0.0, y + 0.3, 0.0), v(0.032, 0.02, 0.032), sides);
    // A disc that faces along the street, its axis z.
    let turn = if mesh.random.chance(0.5) { 0.25 } else { -0.25 };
    let disc = frame.turned(v(0.0, y, 0.0), turn * TAU).then(Frame {
        origin: v(0.0, 0.0, 0.035),
        x: Vector::X,
        y: Vector::Z,
        z: -Vector::Y,
    });
    mesh.frame = disc;
    let sides = 2 * sides;
    mesh.lathe(&[(0.0, 0.0), (0.3, 0.0), (0.3, 0.012)], sides);
    mesh.material = Material::Red;
    mesh.lathe(&[(0.3, 0.012), (0.22, 0.016)], sides);
    mesh.material = mesh.random.pick(&[Material::Paint, Material::Blue]);
    mesh.lathe(&[(0.22, 0.016), (0.0, 0.016)], sides);
}

pub(super) fn planter(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    mesh.material = Material::Stone;
    let sides = mesh.segments(20.0, 8);
    mesh.lathe(
        &[
            (0.22, 0.0),
            (0.22, 0.06),
            (0.16, 0.12),
            (0.28, 0.4),
            (0.33, 0.44),
            (0.33, 0.5),
            (0.28, 0.5),
            (0.27, 0.43),
            (0.0, 0.43),
        ],
        sides,
    );
    let count = mesh.many(260.0, 20);
    let high = mesh.random.between(0.25, 0.5);
    leaves(
        mesh,
        v(0.0, 0.5 + 0.5 * high, 0.0),
        v(0.3, high, 0.3),
        count,
        0.09,
        Material::LightLeaf,
    );
    leaves(
        mesh,
        v(0.0, 0.6 + 0.5 * high, 0.0),
        v(0.3, high, 0.3),
        count / 5,
        0.05,
        Material::Red,
    );
}

/// Adds three bollards with a chain.
pub(super) fn bollards(mesh: &mut Mesh, frame: Frame) {
    mesh.material = Material::Metal;
    let sides = mesh.segments(14.0, 5);
    for x in [-1.2, 0.0, 1.2] {
        mesh.frame = frame.moved(v(x, 0.0, 0.0));
        mesh.lathe(
            &[
                (0.1, 0.0),
                (0.1, 0.08),
                (0.06, 0.12),
                (0.055, 0.7),
                (0.08, 0.74),
                (0.07, 0.82),
                (0.03, 0.88),
                (0.0, 0.89),
            ],
            sides,
        );
    }
    mesh.frame = frame;
    let links = mesh.segments(16.0, 4);
    for start in [-1.2, 0.0] {
        let path: Vec<_> = (0..=links)
            .map(|i| {
                let share = i as f64 / links as f64;
                (
                    v(start + 1.2 * share, 0.65 - 0.8 * share * (1.0 - share), 0.0),
                    0.014,
                )
            })
            .collect();
        mesh.tube(&path, sides.div_ceil(2).max(3));
    }
}

/// Adds a drain cover with a grate.
pub(super) fn drain(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame.then(Frame {
        origin: v(0.0, 0.004, 0.0),
        x: Vector::X,
        y: -Vector::Z,
        z: Vector::Y,
    });
    mesh.material = Material::Metal;
    let half = mesh.random.between(0.22, 0.25);
    mesh.ring(
        [-half; 2],
        [half; 2],
        &[(0.0, 0.0), (0.0, 0.014), (0.04, 0.014), (0.04, 0.004)],
    );
    mesh.material = Material::Dark;
    mesh.quad(
        v(-half, -half, 0.003),
        v(half, -half, 0.003),
        v(half, half, 0.003),
        v(-half, half, 0.003),
    );
    mesh.material = Material::Metal;
    let bars = mesh.segments(14.0, 5);
    for i in 0..bars {
        let [a, b] =
            [0.1, 0.7].map(|share| 0.04 - half + 2.0 * (half - 0.04) * (i as f64 + share) / bars as f64);
        mesh.ring(
            [a, 0.04 - half],
            [b, half - 0.04],
            &[(0.0, 0.003), (0.0, 0.011), (0.48 * (b - a), 0.012)],
        );
    }
}

/// Adds a table with two chairs and a parasol.
pub(super) fn table(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    let sides = mesh.segments(20.0, 8);
    mesh.material = Material::Metal;
    mesh.lathe(
        &[
            (0.25, 0.0),
            (0.25, 0.03),
            (0.05, 0.06),
            (0.035, 0.1),
            (0.035, 2.3),
            (0.0, 2.35),
        ],
        sides,
    );
    mesh.material = Material::Wood;
    mesh.lathe(
        &[
            (0.04, 0.69),
            (0.42, 0.69),
            (0.45, 0.71),
            (0.43, 0.73),
            (0.04, 0.73),
        ],
        sides,
    );
    let cloth = mesh
        .random
        .pick(&[Material::Cloth, Material::Red, Material::Paint, Material::Blue]);
    mesh.material = cloth;
    let ribs = 8;
    let rows = mesh.segments(5.0, 2);
    for rib in 0..ribs {
        let edge = |column: usize, share: f64| {
            let turn = (rib + column) as f64 / ribs as f64 * TAU;
            let radius = 0.04 + 1.1 * share;
            v(
                radius * turn.sin(),
                2.28 - 0.35 * share * share - 0.1 * share,
                radius * turn.cos(),
            )
        };
        for (sign, turned) in [(1.0, false), (-1.0, true)] {
            mesh.grid([1, rows], |column, row| {
                let share = 1.0 - row as f64 / rows as f64;
                let at = edge(if turned { 1 - column } else { column }, share);
                let normal = v(0.5 * at.x, 1.2, 0.5 * at.z).unit();
                (at - v(0.0, if turned { 0.006 } else { 0.0 }, 0.0), normal * sign)
            });
        }
    }
    for side in [-1.0, 1.0] {
        let chair = frame.turned(v(0.0, 0.0, side * 0.75), if side > 0.0 { TAU / 2.0 } else { 0.0 });
        mesh.frame = chair;
        mesh.material = Material::Metal;
        let legs = sides.div_ceil(3).max(4);
        for x in [-0.18, 0.18] {
            mesh.tube(&[(v(x, 0.0, 0.2), 0.013), (v(x, 0.45, 0.17), 0.013)], legs);
            mesh.tube(
                &[
                    (v(x, 0.0, -0.24), 0.013),
                    (v(x, 0.44, -0.18), 0.013),
                    (v(x, 0.88, -0.24), 0.013),
                ],
                legs,
            );
        }
        mesh.material = Material::Wood;
        for slat in 0..5 {
            let z = -0.18 + 0.075 * f64::from(slat);
            mesh.cuboid(v(-0.2, 0.44, z), v(0.2, 0.46, z + 0.055));
        }
        for slat in 0..3 {
            let y = 0.58 + 0.1 * f64::from(slat);
            mesh.cuboid(v(-0.19, y, -0.22), v(0.19, y + 0.06, -0.2));
        }
    }
}

/// Adds a round fountain with two basins.
pub(super) fn fountain(mesh: &mut Mesh, frame: Frame) {
    mesh.frame = frame;
    let sides = mesh.segments(48.0, 12);
    mesh.material = Material::Stone;
    mesh.lathe(
        &[
            (2.0, 0.0),
            (2.0, 0.12),
            (1.85, 0.18),
            (1.85, 0.5),
            (1.95, 0.54),
            (1.95, 0.62),
            (1.65, 0.62),
            (1.6, 0.3),
            (0.0, 0.3),
        ],
        sides,
    );
    mesh.lathe(
        &[
            (0.4, 0.3),
            (0.4, 0.5),
            (0.25, 0.6),
            (0.18, 1.0),
            (0.25, 1.3),
            (0.6, 1.42),
            (0.9, 1.6),
            (0.92, 1.66),
            (0.84, 1.66),
            (0.6, 1.54),
            (0.1, 1.5),
            (0.1, 1.9),
            (0.2, 2.0),
            (0.12, 2.2),
            (0.0, 2.35),
        ],
        sides,
    );
    mesh.material = Material::Glass;
    mesh.lathe(&[(1.63, 0.5), (0.0, 0.5)], sides);
    mesh.lathe(&[(0.8, 1.63), (0.0, 1.63)], sides);
}
