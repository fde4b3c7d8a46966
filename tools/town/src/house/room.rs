//! A furnished room behind the windows of one storey, in the frame of the facade.

use super::facade::{Opening, WALL};
use crate::material::Material;
use crate::mesh::{End, Mesh};
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// Adds a room from x0 to x1, as deep as `depth`, between a floor and a ceiling.
pub(super) fn room(
    mesh: &mut Mesh,
    [x0, x1]: [f64; 2],
    [floor, ceiling]: [f64; 2],
    depth: f64,
    openings: &[Opening],
) {
    let back = -WALL - depth;
    mesh.material = mesh
        .random
        .pick(&[Material::Plaster, Material::Cream, Material::Rose]);
    mesh.niche(v(x0, floor, back), v(x1, ceiling, -WALL));
    let upright = mesh.frame;
    front(mesh, [x0, x1], [floor, ceiling], openings);
    mesh.frame = upright;
    boards(mesh, [x0, x1], [back, -WALL], floor);
    let middle = (x0 + x1) / 2.0;
    let width = x1 - x0;
    // Shelves along the back wall, a table in the middle, a lamp above it.
    let mut x = x0 + 0.2;
    while x + 1.0 < x1 {
        let wide = mesh.random.between(0.8, 1.3).min(x1 - x - 0.05);
        if mesh.random.chance(0.3) {
            mesh.frame = upright.moved(v(x, floor + 0.01, back));
            shelf(mesh, wide, ceiling - floor - 0.4);
        } else {
            mesh.frame = upright.moved(v(x, floor + 1.3, back));
            picture(mesh, wide);
        }
        x += wide + 0.1;
    }
    let place = v(
        middle + mesh.random.around(0.1 * width),
        floor + 0.01,
        back + 0.55 * depth,
    );
    mesh.frame = upright.moved(place);
    table(mesh);
    for chair_at in 0..3 {
        let turn = f64::from(chair_at) * TAU / 3.0 + mesh.random.around(0.3);
        let away = mesh.random.between(0.65, 0.8);
        mesh.frame = upright
            .moved(place)
            .turned(v(-away * turn.sin(), 0.0, -away * turn.cos()), turn);
        chair(mesh);
    }
    mesh.frame = upright.moved(v(place.x, ceiling, place.z));
    pendant(mesh);
    mesh.frame = upright;
}

/// Adds the inner face of the outer wall.
fn front(mesh: &mut Mesh, [x0, x1]: [f64; 2], [floor, ceiling]: [f64; 2], openings: &[Opening]) {
    // Seen from inside, x is to the left.
    mesh.frame = mesh.frame.then(Frame {
        origin: v(x1, 0.0, -WALL),
        x: -Vector::X,
        y: Vector::Y,
        z: -Vector::Z,
    });
    let seen: Vec<Opening> = (openings.iter())
        .map(|opening| Opening {
            low: [x1 - opening.high[0], opening.low[1]],
            high: [x1 - opening.low[0], opening.high[1]],
            ..*opening
        })
        .collect();
    super::facade::strip(mesh, x1 - x0, [floor, ceiling], 0.0, &seen);
}

fn boards(mesh: &mut Mesh, [x0, x1]: [f64; 2], [z0, z1]: [f64; 2], floor: f64) {
    mesh.material = Material::Wood;
    let size = mesh.piece(0.25, [0.12, 1.0]);
    let count = ((z1 - z0) / size).round().max(1.0) as usize;
    for i in 0..count {
        let [a, b] = [i, i + 1].map(|i| z0 + (z1 - z0) * i as f64 / count as f64);
        let joint = mesh.random.between(x0 + 0.3, x1 - 0.3);
        let y = floor + mesh.random.between(0.006, 0.01);
        for [left, right] in [[x0, joint - 0.004], [joint + 0.004, x1]] {
            mesh.stone(v(left, floor, a + 0.003), v(right, y, b - 0.003), 0.004);
        }
    }
}

fn shelf(mesh: &mut Mesh, wide: f64, high: f64) {
    mesh.material = Material::Wood;
    let [deep, board] = [0.32, 0.03];
    let count = (high / 0.36) as usize;
    for x in [0.0, wide - board] {
        mesh.cuboid(v(x, 0.0, 0.0), v(x + board, high, deep));
    }
    for level in 0..=count {
        let y = (high - board) * level as f64 / count as f64;
        mesh.material = Material::Wood;
        mesh.cuboid(v(board, y, 0.0), v(wide - board, y + board, deep));
        if level == count {
            break;
        }
        let size = mesh.piece(0.06, [0.03, 0.4]);
        let mut x = board + 0.01;
        while x + 2.0 * size < wide - board {
            let thick = size * mesh.random.between(0.6, 1.4);
            if mesh.random.chance(0.85) {
                let colors = [
                    Material::Red,
                    Material::Blue,
                    Material::Cloth,
                    Material::Paint,
                    Material::Bark,
                ];
                mesh.material = mesh.random.pick(&colors);
                let top = y + board + mesh.random.between(0.2, 0.29);
                mesh.open_cuboid(v(x, y + board, 0.06), v(x + thick, top, deep - 0.04));
            }
            x += thick + 0.003;
        }
    }
}

fn picture(mesh: &mut Mesh, wide: f64) {
    mesh.material = Material::Wood;
    let high = mesh.random.between(0.4, 0.9);
    mesh.ring(
        [0.0, 0.0],
        [wide, high],
        &[(0.0, 0.0), (0.0, 0.03), (0.03, 0.045), (0.06, 0.015)],
    );
    mesh.material = mesh
        .random
        .pick(&[Material::Blue, Material::Ochre, Material::Grey]);
    mesh.quad(
        v(0.06, 0.06, 0.015),
        v(wide - 0.06, 0.06, 0.015),
        v(wide - 0.06, high - 0.06, 0.015),
        v(0.06, high - 0.06, 0.015),
    );
}

fn turned_leg(mesh: &mut Mesh, height: f64, thick: f64) {
    let sides = mesh.segments(6.0, 3);
    let profile = [
        (0.6 * thick, 0.0),
        (0.8 * thick, 0.12 * height),
        (0.5 * thick, 0.2 * height),
        (thick, 0.6 * height),
        (0.6 * thick, 0.75 * height),
        (thick, 0.85 * height),
        (thick, height),
    ];
    mesh.lathe(&profile, sides);
}

fn table(mesh: &mut Mesh) {
    mesh.material = Material::Wood;
    let middle = mesh.frame;
    for (x, z) in [(-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4)] {
        mesh.frame = middle.moved(v(x, 0.0, z));
        turned_leg(mesh, 0.72, 0.04);
    }
    mesh.frame = middle;
    let sides = mesh.segments(18.0, 8);
    mesh.lathe(
        &[
            (0.0, 0.715),
            (0.62, 0.715),
            (0.65, 0.73),
            (0.65, 0.745),
            (0.63, 0.755),
            (0.0, 0.755),
        ],
        sides,
    );
    mesh.material = Material::Paint;
    for _ in 0..2 {
        let [turn, away] = [mesh.random.between(0.0, TAU), mesh.random.between(0.25, 0.45)];
        mesh.frame = middle.moved(v(away * turn.sin(), 0.755, away * turn.cos()));
        mesh.lathe(
            &[
                (0.03, 0.0),
                (0.05, 0.02),
                (0.045, 0.09),
                (0.038, 0.09),
                (0.04, 0.03),
            ],
            sides.min(12),
        );
    }
    mesh.frame = middle;
}

/// Adds a chair that faces +z.
fn chair(mesh: &mut Mesh) {
    mesh.material = Material::Wood;
    for (x, z) in [(-0.2, -0.2), (0.16, -0.2), (0.16, 0.16), (-0.2, 0.16)] {
        mesh.open_cuboid(v(x, 0.0, z), v(x + 0.04, 0.44, z + 0.04));
    }
    for x in [-0.18, 0.16] {
        mesh.cuboid(v(x, 0.46, -0.2), v(x + 0.02, 0.95, -0.17));
    }
    for y in [0.6, 0.72, 0.84] {
        mesh.cuboid(v(-0.16, y, -0.195), v(0.16, y + 0.05, -0.175));
    }
    mesh.material = Material::Cloth;
    let mut seat = vec![(0.44, -0.21), (0.44, 0.2)];
    seat.extend([(0.46, 0.22), (0.485, 0.2), (0.49, -0.21)]);
    mesh.extrude([-0.21, 0.21], &seat, [End::Cap; 2]);
}

/// Adds a pendant lamp below the origin.
fn pendant(mesh: &mut Mesh) {
    mesh.material = Material::Metal;
    let sides = mesh.segments(14.0, 6);
    mesh.tube(&[(v(0.0, -0.6, 0.0), 0.008), (Vector::ZERO, 0.008)], 4);
    let top = mesh.frame;
    mesh.frame = top.moved(v(0.0, -0.85, 0.0));
    mesh.lathe(
        &[(0.22, 0.0), (0.21, 0.05), (0.15, 0.15), (0.05, 0.24), (0.0, 0.26)],
        sides,
    );
    // The inside: from above down.
    mesh.lathe(&[(0.04, 0.23), (0.145, 0.15), (0.205, 0.05), (0.215, 0.0)], sides);
    mesh.material = Material::Lamp;
    mesh.ellipsoid(v(0.0, 0.08, 0.0), v(0.06, 0.07, 0.06), sides);
    mesh.frame = top;
}
