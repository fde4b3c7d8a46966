//! Windows, doors and shop fronts in the openings of a facade, in the frame of the facade.

use super::House;
use super::facade::{Opening, Use, WALL};
use crate::material::Material;
use crate::mesh::{End, Mesh, arc};
use crate::street::tree::leaves;
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// What is behind the glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Behind {
    /// A shallow dark niche.
    Dark,
    /// A room, which is an item of its own.
    Room,
}

/// How the windows of a house look.
#[derive(Clone, Copy, Debug)]
pub(super) struct WindowStyle {
    pub(super) frame: Material,
    pub(super) panes: [usize; 2],
    pub(super) shutters: Option<Material>,
    pub(super) flowers: bool,
}

/// Adds what fills an opening.
pub(super) fn fill(mesh: &mut Mesh, house: &House, opening: &Opening, behind: Behind) {
    match opening.kind {
        Use::Window | Use::Balcony => window(mesh, house, opening, behind),
        Use::Shop => shop(mesh, house, opening),
        Use::Door => door(mesh, house, opening),
        // An item of its own.
        Use::Passage => {}
    }
}

/// Adds the moulded surround of an opening and its reveal, down to `depth`.
fn surround(mesh: &mut Mesh, opening: &Opening, depth: f64) {
    mesh.material = Material::Stone;
    let round = mesh.segments(3.0, 1);
    let mut profile = vec![(-0.14, 0.0), (-0.14, 0.05), (-0.09, 0.05)];
    profile.extend(arc((-0.05, 0.05), 0.04, [2.0, 1.0], round).into_iter().skip(1));
    profile.extend([(0.0, 0.06), (0.0, -depth)]);
    mesh.ring(opening.low, opening.high, &profile);
}

/// Adds a frame of wood with a rounded inner edge. Returns the corners of what it leaves free.
fn sash(
    mesh: &mut Mesh,
    low: [f64; 2],
    high: [f64; 2],
    width: f64,
    [front, back]: [f64; 2],
) -> [[f64; 2]; 2] {
    let round = mesh.segments(1.2, 0);
    let edge = (front - back).min(width) * 0.6;
    let mut profile = vec![(0.0, front)];
    if round == 0 {
        profile.push((width, front));
    } else {
        profile.extend(arc((width - edge, front - edge), edge, [1.0, 0.0], round));
    }
    profile.push((width, back));
    mesh.ring(low, high, &profile);
    [low.map(|at| at + width), high.map(|at| at - width)]
}

/// Adds glass with bars in front of it.
fn panes(mesh: &mut Mesh, low: [f64; 2], high: [f64; 2], z: f64, [across, up]: [usize; 2], bars: Material) {
    mesh.material = Material::Glass;
    mesh.quad(
        v(low[0], low[1], z),
        v(high[0], low[1], z),
        v(high[0], high[1], z),
        v(low[0], high[1], z),
    );
    mesh.material = bars;
    let round = mesh.segments(2.0, 1);
    let upright = mesh.frame;
    let bar = arc((0.0, 0.0), 0.014, [-1.0, 1.0], round);
    // In an extrusion the first number is y and the second z: half a circle from below over the front to above.
    let bar: Vec<_> = bar.iter().map(|&(z, y)| (y, z)).collect();
    for i in 1..up {
        let y = low[1] + (high[1] - low[1]) * i as f64 / up as f64;
        mesh.frame = upright.moved(v(0.0, y, z + 0.002));
        mesh.extrude([low[0], high[0]], &bar, [End::Open; 2]);
    }
    for i in 1..across {
        let x = low[0] + (high[0] - low[0]) * i as f64 / across as f64;
        mesh.frame = upright.then(Frame {
            origin: v(x, 0.0, z + 0.002),
            x: Vector::Y,
            y: -Vector::X,
            z: Vector::Z,
        });
        mesh.extrude([low[1], high[1]], &bar, [End::Open; 2]);
    }
    mesh.frame = upright;
}

fn niche(mesh: &mut Mesh, opening: &Opening) {
    mesh.material = Material::Dark;
    let [[x0, y0], [x1, y1]] = [opening.low, opening.high];
    mesh.niche(v(x0, y0, -WALL - 0.3), v(x1, y1, -WALL));
}

/// Adds half a curtain, in folds.
fn curtain(mesh: &mut Mesh, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) {
    let folds = ((x1 - x0) / 0.09).round().max(1.0);
    let per_fold = mesh.segments(5.0, 2);
    let columns = folds as usize * per_fold;
    let phase = mesh.random.between(0.0, TAU);
    mesh.grid([columns, 2], |column, row| {
        let share = column as f64 / columns as f64;
        let angle = share * folds * TAU + phase;
        let depth = 0.015 + 0.02 * row as f64 / 2.0;
        let at = v(
            x0 + (x1 - x0) * share,
            y1 + (y0 - y1) * (1.0 - row as f64 / 2.0),
            -WALL - 0.07 + depth * angle.sin(),
        );
        let slope = depth * angle.cos() * folds * TAU / (x1 - x0);
        (at, v(-slope, 0.0, 1.0).unit())
    });
}

fn window(mesh: &mut Mesh, house: &House, opening: &Opening, behind: Behind) {
    let style = &house.windows;
    surround(mesh, opening, WALL);
    let ([x0, y0], [x1, y1]) = (opening.low, opening.high);
    mesh.material = style.frame;
    let [low, high] = sash(mesh, opening.low, opening.high, 0.05, [-0.12, -0.22]);
    // A light above, two casements below.
    let transom = high[1] - 0.28 * (high[1] - low[1]);
    let middle = (low[0] + high[0]) / 2.0;
    let lights = [
        ([low[0], transom], high, [style.panes[0] * 2, 1]),
        (low, [middle, transom], style.panes),
        ([middle, low[1]], [high[0], transom], style.panes),
    ];
    for (low, high, divided) in lights {
        mesh.material = style.frame;
        let [low, high] = sash(mesh, low, high, 0.045, [-0.14, -0.19]);
        panes(mesh, low, high, -0.175, divided, style.frame);
    }
    if opening.kind == Use::Window {
        sill(mesh, opening);
    }
    if behind == Behind::Dark {
        niche(mesh, opening);
    }
    if mesh.random.chance(0.5) {
        mesh.material = Material::Plaster;
        let width = (x1 - x0) * mesh.random.between(0.15, 0.4);
        curtain(mesh, [x0 + 0.02, x0 + width], [y0 + 0.02, y1 - 0.02]);
        curtain(mesh, [x1 - width, x1 - 0.02], [y0 + 0.02, y1 - 0.02]);
    }
    if let (Some(paint), Use::Window) = (style.shutters, opening.kind) {
        let width = (x1 - x0) / 2.0 - 0.02;
        shutter(mesh, paint, [x0 - 0.15 - width, y0], [x0 - 0.15, y1]);
        shutter(mesh, paint, [x1 + 0.15, y0], [x1 + 0.15 + width, y1]);
    }
    if style.flowers && opening.kind == Use::Window && mesh.random.chance(0.5) {
        flower_box(mesh, [x0, x1], y0);
    }
}

fn sill(mesh: &mut Mesh, opening: &Opening) {
    mesh.material = Material::Stone;
    let ([x0, y], [x1, _]) = (opening.low, opening.high);
    let round = mesh.segments(4.0, 1);
    let mut profile = vec![(y - 0.15, 0.0), (y - 0.13, 0.12)];
    profile.extend(arc((y - 0.085, 0.14), 0.035, [2.0, 0.0], 2 * round));
    profile.push((y - 0.04, 0.0));
    mesh.extrude([x0 - 0.2, x1 + 0.2], &profile, [End::Cap; 2]);
}

/// Adds a shutter with slats, folded back against the wall.
fn shutter(mesh: &mut Mesh, paint: Material, low: [f64; 2], high: [f64; 2]) {
    mesh.material = paint;
    let profile = [(0.0, 0.0), (0.0, 0.05), (0.05, 0.05), (0.05, 0.0)];
    mesh.ring(low, high, &profile);
    let [low, high] = [low.map(|at| at + 0.05), high.map(|at| at - 0.05)];
    let size = mesh.piece(0.07, [0.035, 0.3]);
    let count = ((high[1] - low[1]) / size) as usize;
    for i in 0..count {
        let [y, next] = [i, i + 1].map(|i| low[1] + (high[1] - low[1]) * i as f64 / count as f64);
        let profile = [(y, 0.012), (y, 0.045), (y + 0.01, 0.045), (next, 0.02)];
        mesh.extrude([low[0], high[0]], &profile, [End::Open; 2]);
    }
}

fn flower_box(mesh: &mut Mesh, [x0, x1]: [f64; 2], y: f64) {
    mesh.material = Material::Wood;
    mesh.cuboid(v(x0, y - 0.03, 0.01), v(x1, y + 0.13, 0.16));
    let count = mesh.many(90.0, 10);
    let middle = v((x0 + x1) / 2.0, y + 0.18, 0.09);
    let radii = v((x1 - x0) / 2.0, 0.12, 0.1);
    let leaf = mesh.random.pick(&[Material::Leaf, Material::LightLeaf]);
    leaves(mesh, middle, radii, count, 0.05, leaf);
    let blossoms = count / 4;
    leaves(
        mesh,
        middle + v(0.0, 0.05, 0.02),
        radii,
        blossoms,
        0.035,
        Material::Red,
    );
}

/// Adds a leaf of a door with panels; its front is at z.
pub(super) fn panelled(mesh: &mut Mesh, low: [f64; 2], high: [f64; 2], z: f64, [across, up]: [usize; 2]) {
    let rim = 0.09;
    for i in 0..across {
        for j in 0..up {
            let corner = |axis: usize, step: usize, count: usize| {
                low[axis] + (high[axis] - low[axis]) * step as f64 / count as f64
            };
            let [a, b] = [corner(0, i, across), corner(0, i + 1, across)];
            let [c, d] = [corner(1, j, up), corner(1, j + 1, up)];
            let round = mesh.segments(4.0, 1);
            let mut profile = vec![(0.0, z), (rim, z)];
            profile.extend(arc((rim, z - 0.03), 0.03, [1.0, 0.0], round).into_iter().skip(1));
            profile.extend([(rim + 0.05, z - 0.03), (rim + 0.09, z - 0.008)]);
            mesh.ring([a, c], [b, d], &profile);
            let inset = rim + 0.09;
            mesh.quad(
                v(a + inset, c + inset, z - 0.008),
                v(b - inset, c + inset, z - 0.008),
                v(b - inset, d - inset, z - 0.008),
                v(a + inset, d - inset, z - 0.008),
            );
        }
    }
}

fn door(mesh: &mut Mesh, house: &House, opening: &Opening) {
    surround(mesh, opening, WALL);
    let ([x0, y0], [x1, y1]) = (opening.low, opening.high);
    mesh.material = house.windows.frame;
    let [low, high] = sash(mesh, [x0, y0 - 0.06], opening.high, 0.06, [-0.12, -WALL]);
    let transom = high[1] - 0.4;
    panes(mesh, [low[0], transom], high, -0.22, [4, 1], house.windows.frame);
    mesh.material = house.door;
    panelled(mesh, low, [high[0], transom], -0.18, [2, 3]);
    niche(mesh, opening);
    mesh.material = Material::Metal;
    let sides = mesh.segments(10.0, 5);
    mesh.ellipsoid(v(low[0] + 0.1, y0 + 1.05, -0.15), v(0.03, 0.03, 0.035), sides);
    // Steps from the pavement, and a hood on brackets.
    mesh.material = Material::Stone;
    let steps = ((y0 - crate::plan::KERB) / 0.15).round().max(1.0);
    for step in 0..steps as usize {
        let [a, b] = [step, step + 1].map(|i| y0 - (y0 - 0.02) * i as f64 / steps);
        let out = 0.28 * (step + 1) as f64;
        mesh.open_cuboid(v(x0 - 0.1, b, -WALL + 0.01), v(x1 + 0.1, a - 0.002, out));
    }
    let round = mesh.segments(5.0, 1);
    let y = y1 + 0.25;
    let mut hood = vec![(y, 0.0), (y, 0.3)];
    hood.extend(
        arc((y + 0.06, 0.3), 0.06, [2.0, 0.0], 2 * round)
            .into_iter()
            .skip(1),
    );
    hood.push((y + 0.16, 0.0));
    mesh.extrude([x0 - 0.3, x1 + 0.3], &hood, [End::Cap; 2]);
    for x in [x0 - 0.22, x1 + 0.14] {
        let bracket = [(y - 0.3, 0.0), (y - 0.25, 0.06), (y, 0.25), (y + 0.01, 0.0)];
        mesh.extrude([x, x + 0.08], &bracket, [End::Cap; 2]);
    }
    mesh.material = Material::Lamp;
    mesh.ellipsoid(v((x0 + x1) / 2.0, y - 0.1, 0.12), v(0.06, 0.08, 0.06), sides);
}

fn shop(mesh: &mut Mesh, house: &House, opening: &Opening) {
    surround(mesh, opening, WALL);
    let ([x0, y0], [x1, y1]) = (opening.low, opening.high);
    mesh.material = house.door;
    // A panelled base, the window above it, and a sign over both.
    let base = y0 + 0.5;
    panelled(mesh, [x0, y0], [x1, base], -0.1, [4, 1]);
    let [low, high] = sash(mesh, [x0, base], opening.high, 0.07, [-0.08, -0.2]);
    panes(mesh, low, high, -0.15, [3, 1], house.door);
    mesh.material = house.door;
    let board = [
        (y1 + 0.16, 0.0),
        (y1 + 0.16, 0.1),
        (y1 + 0.58, 0.13),
        (y1 + 0.6, 0.0),
    ];
    mesh.extrude([x0 - 0.1, x1 + 0.1], &board, [End::Cap; 2]);
    // Letters, as strokes.
    mesh.material = Material::Paint;
    let count = ((x1 - x0) / 0.3) as usize;
    for i in 0..count {
        let x = x0 + (x1 - x0) * (i as f64 + 0.2) / count as f64;
        let [bottom, top] = [y1 + 0.24, y1 + 0.5];
        let stroke = 0.04;
        mesh.open_cuboid(v(x, bottom, 0.1), v(x + stroke, top, 0.16));
        for bar in 0..3 {
            if mesh.random.chance(0.6) {
                let y = bottom + (top - bottom - stroke) * f64::from(bar) / 2.0;
                mesh.cuboid(v(x + stroke, y, 0.1), v(x + 0.16, y + stroke, 0.158));
            }
        }
    }
    awning(mesh, [x0 - 0.1, x1 + 0.1], y1 + 0.12);
}

/// Adds a striped awning with a scalloped edge.
fn awning(mesh: &mut Mesh, [x0, x1]: [f64; 2], y: f64) {
    let stripes = ((x1 - x0) / 0.22) as usize;
    let color = mesh
        .random
        .pick(&[Material::Red, Material::Blue, Material::Cloth]);
    let rows = mesh.segments(5.0, 2);
    let [out, drop] = [1.1, 0.45];
    for i in 0..stripes {
        let [a, b] = [i, i + 1].map(|i| x0 + (x1 - x0) * i as f64 / stripes as f64);
        mesh.material = if i % 2 == 0 { color } else { Material::Paint };
        let at = |x: f64, share: f64| {
            let sag = 0.06 * (share * TAU / 2.0).sin();
            let slope = v(0.0, out, drop).unit();
            (v(x, y - drop * share - sag, 0.05 + out * share), slope)
        };
        mesh.grid([1, rows], |column, row| {
            at(if column == 0 { a } else { b }, 1.0 - row as f64 / rows as f64)
        });
        // The underside.
        mesh.grid([1, rows], |column, row| {
            let (on, normal) = at(if column == 0 { a } else { b }, row as f64 / rows as f64);
            (on - v(0.0, 0.01, 0.0), -normal)
        });
        let [front, low] = [0.05 + out, y - drop];
        let middle = (a + b) / 2.0;
        let scallop = [
            v(a, low - 0.12, front),
            v(middle, low - 0.18, front),
            v(b, low - 0.12, front),
            v(b, low, front),
            v(a, low, front),
        ];
        mesh.polygon(&scallop);
        let behind = scallop.map(|at| at - v(0.0, 0.0, 0.01));
        mesh.polygon(&[behind[0], behind[4], behind[3], behind[2], behind[1]]);
    }
}

/// Adds the arch at one end of a passage; with the depth of the house also its walls, vault and gates. Called in the
/// frame of each facade.
pub(super) fn passage(mesh: &mut Mesh, opening: &Opening, depth: Option<f64>) {
    let ([x0, y0], [x1, y1]) = (opening.low, opening.high);
    mesh.material = Material::Stone;
    let round = mesh.segments(4.0, 1);
    let mut profile = vec![(-0.2, 0.0), (-0.2, 0.07)];
    profile.extend(arc((-0.05, 0.07), 0.05, [2.0, 1.0], round));
    profile.extend([(0.0, 0.08), (0.0, 0.0)]);
    mesh.ring([x0, y0 - 0.4], opening.high, &profile);
    let Some(depth) = depth else { return };
    mesh.material = Material::Plaster;
    let segments = mesh.segments(16.0, 4);
    let [half, rise, far] = [(x1 - x0) / 2.0, 0.49, -depth];
    let spring = y1 - rise - 0.01;
    let point = |i: usize| {
        let (sine, cosine) = (i as f64 / segments as f64 * TAU / 2.0).sin_cos();
        let at = v(x0 + half - half * cosine, spring + rise * sine, 0.0);
        (at, v(cosine / half, -sine / rise, 0.0).unit())
    };
    mesh.grid([1, segments], |column, row| {
        let (at, normal) = point(row);
        (v(at.x, at.y, if column == 0 { 0.0 } else { far }), normal)
    });
    // The openings are rectangular: what the vault leaves of them is closed.
    for i in 0..segments {
        let [(a, _), (b, _)] = [point(i), point(i + 1)];
        let up = |at: Vector| v(at.x, y1, 0.0);
        mesh.quad(a, b, up(b), up(a));
        let [a, b] = [a, b].map(|at| v(at.x, at.y, far));
        let up = |at: Vector| v(at.x, y1, far);
        mesh.quad(b, a, up(a), up(b));
    }
    mesh.quad(
        v(x0, y0, 0.0),
        v(x0, y0, far),
        v(x0, spring, far),
        v(x0, spring, 0.0),
    );
    mesh.quad(
        v(x1, y0, far),
        v(x1, y0, 0.0),
        v(x1, spring, 0.0),
        v(x1, spring, far),
    );
    // Gates, folded back against the walls.
    mesh.material = Material::Wood;
    let upright = mesh.frame;
    let leaf = half - 0.05;
    for (origin, turn) in [
        (v(x0 + 0.01, 0.0, -0.4), 1.0),
        (v(x1 - 0.01, 0.0, -0.4 - leaf), -1.0),
    ] {
        mesh.frame = upright.turned(origin, turn * TAU / 4.0);
        let [low, high] = [[0.0, y0 + 0.02], [leaf, spring]];
        mesh.ring(low, high, &[(0.0, 0.0), (0.0, 0.06)]);
        panelled(mesh, low, high, 0.06, [1, 3]);
    }
    mesh.frame = upright;
    mesh.material = Material::Lamp;
    let sides = mesh.segments(10.0, 5);
    mesh.ellipsoid(
        v(x0 + half, spring + rise - 0.3, far / 2.0),
        v(0.12, 0.16, 0.12),
        sides,
    );
    mesh.material = Material::Metal;
    let hanger = v(x0 + half, spring + rise, far / 2.0);
    mesh.tube(&[(hanger - v(0.0, 0.16, 0.0), 0.015), (hanger, 0.015)], sides);
}
