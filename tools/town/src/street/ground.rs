//! The ground, in pieces of 8 × 8 m: earth below, then roadways, pavements, kerbs, courts and lawns.

use super::tree::grass;
use crate::material::Material;
use crate::mesh::Mesh;
use crate::plan::{KERB, PASSAGE, PAVEMENT, Plan, Side, TILE};
use crate::tile::Items;
use crate::vector::{Rect, v};

/// Side of a piece in metres.
const PIECE: u32 = 8;

/// Width of a kerb.
const KERB_WIDTH: f64 = 0.18;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Surface {
    Asphalt,
    Cobbles,
    Slabs,
    Kerb,
    Lawn,
}

/// Returns all areas of the ground outside houses, with their surfaces. They do not overlap.
fn areas(plan: &Plan) -> Vec<(Rect, Surface)> {
    let of = |axis: usize, line: usize| match plan.streets[axis][line].cobbled {
        true => Surface::Cobbles,
        false => Surface::Asphalt,
    };
    let mut areas = Vec::new();
    for line in 0..3 {
        areas.push((plan.roadway(0, line), of(0, line)));
    }
    for line in 0..3 {
        let along = plan.roadway(1, line);
        // Crossings belong to the other streets.
        for gap in 0..2 {
            let ends = [plan.roadway(0, gap).high[0], plan.roadway(0, gap + 1).low[0]];
            areas.push((
                Rect::new(ends[0], along.low[1], ends[1], along.high[1]),
                of(1, line),
            ));
        }
    }
    for block in &plan.blocks {
        let edge = block.rect.grown(PAVEMENT);
        let walk = edge.grown(-KERB_WIDTH);
        areas.extend(edge.around(&walk).map(|rect| (rect, Surface::Kerb)));
        if block.is_park() {
            areas.extend(walk.around(&block.court).map(|rect| (rect, Surface::Slabs)));
            // Two paths cross the lawn.
            let [x, z] = block.court.center();
            let ([x0, z0], [x1, z1]) = (block.court.low, block.court.high);
            let half = 1.0;
            areas.push((Rect::new(x - half, z0, x + half, z1), Surface::Slabs));
            for [a, b] in [[x0, x - half], [x + half, x1]] {
                areas.push((Rect::new(a, z - half, b, z + half), Surface::Slabs));
                areas.push((Rect::new(a, z0, b, z - half), Surface::Lawn));
                areas.push((Rect::new(a, z + half, b, z1), Surface::Lawn));
            }
        } else {
            areas.extend(walk.around(&block.rect).map(|rect| (rect, Surface::Slabs)));
            areas.push((block.court, Surface::Cobbles));
            for lot in block.lots.iter().filter(|lot| lot.passage) {
                let street = lot.sides.iter().position(|&side| side == Side::Street);
                let axis = street.unwrap_or(0) % 2;
                let mut floor = lot.rect;
                floor.low[axis] = lot.rect.center()[axis] - PASSAGE / 2.0;
                floor.high[axis] = lot.rect.center()[axis] + PASSAGE / 2.0;
                areas.push((floor, Surface::Slabs));
            }
        }
    }
    areas
}

/// Adds the ground of a tile as items.
pub(crate) fn ground(items: &mut Items, plan: &Plan) {
    let areas = areas(plan);
    let count = TILE / PIECE;
    for row in 0..count {
        for column in 0..count {
            let [x, z] = [column, row].map(|step| f64::from(step * PIECE));
            let side = f64::from(PIECE);
            let piece = Rect::new(x, z, x + side, z + side);
            items.add(&format!("ground {column} {row}"), |mesh| {
                // Without gaps: what is above has joints.
                mesh.material = Material::Earth;
                flat(mesh, &piece, -0.06);
                for (area, surface) in &areas {
                    if let Some(rect) = area.within(&piece) {
                        let in_block = plan
                            .blocks
                            .iter()
                            .any(|block| block.rect.grown(PAVEMENT).within(&rect).is_some());
                        cover(mesh, &rect, *surface, if in_block { KERB } else { 0.0 });
                    }
                }
            });
        }
    }
}

fn flat(mesh: &mut Mesh, rect: &Rect, y: f64) {
    let ([x0, z0], [x1, z1]) = (rect.low, rect.high);
    mesh.quad(v(x0, y, z1), v(x1, y, z1), v(x1, y, z0), v(x0, y, z0));
}

fn cover(mesh: &mut Mesh, rect: &Rect, surface: Surface, y: f64) {
    match surface {
        Surface::Asphalt => {
            mesh.material = Material::Asphalt;
            flat(mesh, rect, y);
        }
        Surface::Cobbles => stones(mesh, rect, y, 0.25, [0.12, 1.5], Material::Cobble),
        Surface::Slabs => stones(mesh, rect, y, 0.36, [0.25, 2.0], Material::Paving),
        Surface::Kerb => kerb(mesh, rect, y),
        Surface::Lawn => {
            mesh.material = Material::Lawn;
            flat(mesh, rect, y - 0.02);
            let ([x0, z0], [x1, z1]) = (rect.low, rect.high);
            grass(mesh, v(x0, y - 0.02, z0), v(x1, y - 0.02, z1));
        }
    }
}

/// Covers an area with stones in rows, on a bed of sand.
fn stones(mesh: &mut Mesh, rect: &Rect, y: f64, size: f64, limits: [f64; 2], material: Material) {
    mesh.material = Material::Earth;
    flat(mesh, rect, y - 0.025);
    mesh.material = material;
    let size = mesh.piece(size, limits);
    let ([x0, z0], [wide, deep]) = (rect.low, rect.size());
    let rows = (deep / (0.8 * size)).round().max(1.0);
    let joint = 0.03 * size;
    for row in 0..rows as usize {
        let [near, far] = [row, row + 1].map(|i| z0 + deep * i as f64 / rows);
        let count = (wide / size).round().max(1.0);
        let shift = if row % 2 == 0 || count < 2.0 { 0.0 } else { 0.5 };
        for i in 0..=count as usize {
            let end = |at: f64| x0 + wide * (at / count).clamp(0.0, 1.0);
            let [left, right] = [end(i as f64 - shift), end(i as f64 + 1.0 - shift)];
            if right - left > 4.0 * joint {
                let top = y + mesh.random.between(-0.008, 0.0);
                mesh.stone(
                    v(left + joint, y - 0.025, near + joint),
                    v(right - joint, top, far - joint),
                    (0.06 * size).min(0.02),
                );
            }
        }
    }
}

fn kerb(mesh: &mut Mesh, rect: &Rect, y: f64) {
    mesh.material = Material::Stone;
    let size = mesh.piece(0.9, [0.5, 4.0]);
    let [wide, deep] = rect.size();
    let length = wide.max(deep);
    let count = (length / size).round().max(1.0) as usize;
    for i in 0..count {
        let [from, to] = [i, i + 1].map(|i| length * i as f64 / count as f64);
        let [[x0, x1], [z0, z1]] = if wide > deep {
            [[from, to], [0.0, deep]]
        } else {
            [[0.0, wide], [from, to]]
        };
        let [x, z] = rect.low;
        let top = y + mesh.random.between(0.0, 0.006);
        mesh.stone(v(x + x0, -0.05, z + z0), v(x + x1, top, z + z1), 0.015);
    }
}
