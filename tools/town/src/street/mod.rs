//! What is outside the houses: ground, furniture of streets, cars, trees.

mod car;
mod furniture;
mod ground;
pub(crate) mod tree;

use crate::plan::{Block, KERB, PAVEMENT, Plan};
use crate::random::Random;
use crate::tile::Items;
use crate::vector::{Frame, Vector, v};
use std::f64::consts::TAU;

/// Adds the ground of a tile and all that is on it, except houses.
pub(crate) fn street(items: &mut Items, plan: &Plan) {
    ground::ground(items, plan);
    for (number, block) in plan.blocks.iter().enumerate() {
        let mut random = items.random(&format!("block {number} furniture"));
        for side in 0..4 {
            pavement(
                items,
                block,
                side,
                &format!("block {number} side {side}"),
                &mut random,
            );
        }
        if block.is_park() {
            park(items, block, &format!("park {number}"), &mut random);
        } else {
            court(items, block, &format!("court {number}"), &mut random);
        }
    }
}

/// Lines up lamps, cars and more along one side of a block.
fn pavement(items: &mut Items, block: &Block, side: usize, prefix: &str, random: &mut Random) {
    let (frame, width) = block.rect.side(side);
    let street = block.streets[side];
    let kerb = PAVEMENT - 0.35;
    let on_pavement = |x: f64| frame.moved(v(x, KERB, kerb));
    for (number, share) in [0.22, 0.78].into_iter().enumerate() {
        let place = on_pavement(share * width);
        items.add(&format!("{prefix} lamp {number}"), |mesh| {
            furniture::lamp(mesh, place)
        });
    }
    for number in 0..3 {
        let x = width * (0.34 + 0.16 * f64::from(number)) + random.around(0.4);
        let place = on_pavement(x);
        match random.below(6) {
            0 => items.add(&format!("{prefix} bin {number}"), |mesh| {
                furniture::bin(mesh, place)
            }),
            1 => items.add(&format!("{prefix} sign {number}"), |mesh| {
                furniture::sign(mesh, place)
            }),
            2 => items.add(&format!("{prefix} bench {number}"), |mesh| {
                furniture::bench(mesh, place)
            }),
            3 => items.add(&format!("{prefix} planter {number}"), |mesh| {
                furniture::planter(mesh, place)
            }),
            4 => items.add(&format!("{prefix} bollards {number}"), |mesh| {
                furniture::bollards(mesh, place)
            }),
            _ if street.width > 8.6 => {
                let at = place.origin;
                tree::tree(
                    items,
                    &format!("{prefix} tree {number}"),
                    at,
                    random.between(6.0, 8.0),
                    1.5,
                );
            }
            _ => {}
        }
    }
    if street.width > 7.9 {
        let slots = (width / 5.2) as usize;
        for slot in 0..slots {
            let x = width * (slot as f64 + 0.5) / slots as f64 + random.around(0.25);
            let turn = if random.chance(0.5) { TAU / 4.0 } else { -TAU / 4.0 } + random.around(0.02);
            let place = frame.turned(v(x, 0.0, PAVEMENT + 1.05), turn);
            if random.chance(0.5) {
                items.add(&format!("{prefix} car {slot}"), |mesh| car::car(mesh, place));
            }
        }
    }
    let x = random.between(0.3, 0.7) * width;
    items.add(&format!("{prefix} drain"), |mesh| {
        furniture::drain(mesh, frame.moved(v(x, 0.0, PAVEMENT + 0.3)));
    });
}

/// Turns an upright frame at random.
fn somewhere(at: Vector, random: &mut Random) -> Frame {
    Frame::upright(at, random.between(0.0, TAU))
}

fn court(items: &mut Items, block: &Block, prefix: &str, random: &mut Random) {
    let [x, z] = block.court.center();
    let size = block.court.size().into_iter().fold(f64::INFINITY, f64::min);
    let spread = (0.28 * size).min(3.0);
    let height = random.between(7.0, 10.0);
    let at = v(x + random.around(0.8), KERB, z + random.around(0.8));
    tree::tree(items, &format!("{prefix} tree"), at, height, spread);
    for number in 0..4 {
        // Off the axes, where passages and doors lead.
        let [right, front] = [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]][number];
        let place = v(x + right * 0.33 * size, KERB, z + front * 0.33 * size);
        let frame = somewhere(place, random);
        match random.below(4) {
            0 => items.add(&format!("{prefix} bench {number}"), |mesh| {
                furniture::bench(mesh, frame)
            }),
            1 => items.add(&format!("{prefix} table {number}"), |mesh| {
                furniture::table(mesh, frame)
            }),
            2 => items.add(&format!("{prefix} planter {number}"), |mesh| {
                furniture::planter(mesh, frame)
            }),
            _ => items.add(&format!("{prefix} bin {number}"), |mesh| {
                furniture::bin(mesh, frame)
            }),
        }
    }
}

fn park(items: &mut Items, block: &Block, prefix: &str, random: &mut Random) {
    let [x, z] = block.court.center();
    items.add(&format!("{prefix} fountain"), |mesh| {
        furniture::fountain(mesh, Frame::upright(v(x, KERB, z), 0.0));
    });
    let half = block.court.size().map(|side| side / 2.0);
    let mut number = 0;
    for right in [-1.0, 1.0] {
        for front in [-1.0, 1.0] {
            for (a, b) in [(0.35, 0.75), (0.78, 0.4), (0.75, 0.8)] {
                let at = v(
                    x + right * a * half[0] + random.around(0.5),
                    KERB - 0.02,
                    z + front * b * half[1] + random.around(0.5),
                );
                let (height, spread) = (random.between(7.0, 11.0), random.between(2.0, 2.8));
                tree::tree(items, &format!("{prefix} tree {number}"), at, height, spread);
                number += 1;
            }
            let bench = v(x + right * 1.5, KERB - 0.02, z + front * 4.0);
            let frame = Frame::upright(bench, -right * TAU / 4.0);
            items.add(&format!("{prefix} bench {number}"), |mesh| {
                furniture::bench(mesh, frame)
            });
            let table = v(x + right * 4.5, KERB - 0.02, z + front * 2.6);
            let frame = somewhere(table, random);
            items.add(&format!("{prefix} table {number}"), |mesh| {
                furniture::table(mesh, frame)
            });
        }
    }
}
