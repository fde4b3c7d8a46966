//! Formal parts of the garden: the terrace with its beds, stairs down to the lawn, gravel paths, the basin.

use super::ground::{BANK, Ground, LAWN_LEVEL, TERRACE};
use super::{AXIS, BASIN, BASIN_RADII, KNOLL};
use crate::palace::palette::*;
use crate::palace::room::{Room, scaled, shift, spot};
use crate::palace::rooms::court::flower_bed;
use crate::palace::statue::{self, Pose};
use crate::palace::{column, garden, ornament};
use crate::shape::{Shape, block, moulding};
use enfilade::Transform;
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::TAU;

/// Height of gravel and lawns above the ground.
const GRAVEL_OVER: f32 = 0.025;
const LAWN_OVER: f32 = 0.05;

/// Half the width of the stairs and of the path along the axis.
const STAIRS: f32 = 3.2;
const WAY: f32 = 1.5;

pub(super) fn build(room: &mut Room, ground: &Ground) {
    gravel(room, ground);
    lawns(room, ground);
    stairs(room);
    basin(room);
    balustrades(room);
    ornaments(room, ground);
}

fn rectangle(x: [f32; 2], z: [f32; 2]) -> [Vec2; 4] {
    [
        vec2(x[0], z[0]),
        vec2(x[0], z[1]),
        vec2(x[1], z[1]),
        vec2(x[1], z[0]),
    ]
}

/// Gravel on the terrace, along the axis, and around the basin.
fn gravel(room: &mut Room, ground: &Ground) {
    let mut shape = Shape::new();
    for outline in [
        rectangle([-24.3, -7.3], [-158.0, -92.3]),
        rectangle([-60.0, -24.3], [-101.3, -92.3]),
        rectangle([BASIN.x + BASIN_RADII.x + 2.2, -26.5], [AXIS - WAY, AXIS + WAY]),
        rectangle(
            [KNOLL.x + 5.0, BASIN.x - BASIN_RADII.x - 2.2],
            [AXIS - WAY, AXIS + WAY],
        ),
        rectangle([-31.0, -28.0], [-146.0, AXIS - WAY]),
        rectangle([-31.0, -28.0], [AXIS + WAY, -104.0]),
    ] {
        shape.join(ground.laid(GRAVEL, &outline, GRAVEL_OVER));
    }
    const PARTS: usize = 40;
    let at = |part: usize, wider: f32| {
        let (sin, cos) = (TAU * part as f64 / PARTS as f64).sin_cos();
        BASIN + (BASIN_RADII + Vec2::splat(wider)) * vec2(cos as f32, sin as f32)
    };
    for part in 0..PARTS {
        let outline = [at(part, 0.3), at(part + 1, 0.3), at(part + 1, 2.6), at(part, 2.6)];
        shape.join(ground.laid(GRAVEL, &outline, GRAVEL_OVER + 0.008));
    }
    room.make("gravel", &shape);
}

/// Beds of the terrace, as x and z: between paths along the walls, the axis, and the balustrade.
const BEDS: [([f32; 2], [f32; 2]); 5] = [
    ([-21.6, -11.2], [-113.3, -104.2]),
    ([-21.6, -11.2], [-130.0, -120.8]),
    ([-21.6, -11.2], [-143.0, -132.6]),
    ([-36.0, -30.2], [-99.2, -95.6]),
    ([-47.0, -38.6], [-99.2, -95.6]),
];

/// Grass in the beds, and on the lawn below the terrace.
fn lawns(room: &mut Room, ground: &Ground) {
    let mut shape = Shape::new();
    for (x, z) in BEDS {
        shape.join(block(
            LAWN,
            [x[0], TERRACE - 0.05, z[0]],
            [x[1], TERRACE + 2.0 * LAWN_OVER, z[1]],
        ));
    }
    let beyond = BASIN.x - BASIN_RADII.x - 2.8;
    let before = BASIN.x + BASIN_RADII.x + 2.8;
    for side in [-1.0_f32, 1.0] {
        let z = |from: f32, to: f32| {
            let [a, b] = [AXIS + side * from, AXIS + side * to];
            [a.min(b), a.max(b)]
        };
        shape.join(ground.laid(
            LAWN,
            &rectangle([-28.0, -24.4], z(STAIRS + 0.8, 15.6)),
            GRAVEL_OVER,
        ));
        // Mowing stripes in alternating directions.
        const STRIPE: f32 = 2.0;
        for (from, count) in [(before, 3), (beyond - 6.0 * STRIPE, 6)] {
            for stripe in 0..count {
                let material = if stripe % 2 == 0 { LAWN } else { MOWN };
                let x = from + STRIPE * stripe as f32;
                let outline = rectangle([x, x + STRIPE], z(WAY, 11.5));
                shape.join(ground.laid(material, &outline, GRAVEL_OVER));
            }
        }
    }
    room.make("lawn", &shape);
    let [long, short] = [
        garden::hedge(room.shop, 8.4, 0.5),
        garden::hedge(room.shop, 6.0, 0.5),
    ];
    let [cone, stack] = [false, true].map(|stacked| garden::topiary(room.shop, stacked));
    for (number, (x, z)) in BEDS.into_iter().enumerate() {
        let middle = vec2(0.5 * (x[0] + x[1]), 0.5 * (z[0] + z[1]));
        let half = vec2(0.5 * (x[1] - x[0]), 0.5 * (z[1] - z[0]));
        for a in [-1.0, 1.0] {
            for b in [-1.0, 1.0] {
                let at = middle + half * vec2(a, b) - vec2(0.7 * a, 0.7 * b);
                let tree = if number % 2 == 0 { &cone } else { &stack };
                room.put("topiary", tree, spot(at.x, at.y, 0.0));
            }
        }
        if number < 3 {
            for a in [-1.0, 1.0] {
                room.put("hedge", &long, spot(middle.x, middle.y + a * (half.y - 1.5), 0.0));
                room.put(
                    "hedge",
                    &short,
                    spot(middle.x + a * (half.x - 1.5), middle.y, 90.0),
                );
            }
            for (row, color) in [RED_SILK, IVORY, YELLOW_SILK, PALE_BLUE].into_iter().enumerate() {
                let bed = flower_bed(room.shop, color);
                let off = -2.4 + 1.6 * row as f32;
                let place = spot(middle.x - 1.6, middle.y + off, 0.0) * shift(0.0, 0.06, 0.0);
                room.put("flowers", &bed, place);
                room.put("flowers", &bed, place * shift(3.2, 0.0, 0.0));
            }
        }
    }
}

/// From the terrace down to the lawn, between two walls.
fn stairs(room: &mut Room) {
    const STEPS: usize = 10;
    let top = -7.45 - BANK[0][0] + 0.3;
    let rise = (TERRACE + GRAVEL_OVER - LAWN_LEVEL) / STEPS as f32;
    let [tread, foot] = [0.4, LAWN_LEVEL - 0.4];
    let mut shape = Shape::new();
    for step in 0..STEPS {
        let up = TERRACE + GRAVEL_OVER + 0.01 - rise * step as f32;
        let x = top - tread * step as f32;
        shape.join(block(
            PALE_STONE,
            [x - tread, foot, AXIS - STAIRS],
            [x, up, AXIS + STAIRS],
        ));
    }
    let end = top - tread * STEPS as f32;
    for side in [-1.0, 1.0] {
        let z = AXIS + side * (STAIRS + 0.3);
        shape.join(block(
            STONE,
            [end - 0.2, foot, z - 0.3],
            [top + 0.5, TERRACE + 0.55, z + 0.3],
        ));
        shape.join(block(
            PALE_STONE,
            [end - 0.28, TERRACE + 0.55, z - 0.38],
            [top + 0.58, TERRACE + 0.67, z + 0.38],
        ));
    }
    room.make("stairs", &shape);
    let urn = ornament::urn(room.shop, TERRACOTTA, STONE);
    for side in [-1.0, 1.0] {
        for x in [end + 0.2, top + 0.1] {
            let place = shift(x, TERRACE + 0.67, AXIS + side * (STAIRS + 0.3));
            room.put("urn", &urn, place * scaled(1.5));
        }
    }
}

/// Water within a stone kerb, and a fountain in its middle.
fn basin(room: &mut Room) {
    const SIDES: usize = 64;
    let ring: Vec<Vec2> = crate::shape::around(SIDES)
        .map(|at| BASIN + BASIN_RADII * at)
        .collect();
    // Moulding paths have the room on the right, which here is the outside of the kerb.
    let kerb = [
        [-0.4, -1.6],
        [-0.4, 0.2],
        [-0.3, 0.26],
        [0.26, 0.26],
        [0.36, 0.2],
        [0.36, -0.3],
    ];
    let mut shape = moulding(PALE_STONE, &ring, true, LAWN_LEVEL, &kerb);
    let level = LAWN_LEVEL - 0.12;
    let water: Vec<Vec3> = ring.iter().map(|at| vec3(at.x, level, at.y)).collect();
    shape.face(POND, &water);
    room.make("basin", &shape);
    let fountain = garden::fountain(room.shop, PALE_STONE);
    room.put(
        "fountain",
        &fountain,
        shift(BASIN.x, level - 0.25, BASIN.y) * scaled(1.15),
    );
}

/// A balustrade along the edge of the terrace, open at the stairs.
fn balustrades(room: &mut Room) {
    const BAY: f32 = 5.0;
    let piece = room.shop.piece("garden balustrade".to_owned(), || {
        let mut shape = block(PALE_STONE, [-0.3, -0.2, -0.3], [0.3, 1.0, 0.3]);
        shape.join(block(STONE, [-0.38, 1.0, -0.38], [0.38, 1.1, 0.38]));
        shape.join(block(STONE, [0.3, -0.2, -0.2], [BAY - 0.3, 0.14, 0.2]));
        shape.join(block(STONE, [0.3, 0.84, -0.2], [BAY - 0.3, 0.98, 0.2]));
        for i in 0..10 {
            let x = 0.3 + (BAY - 0.6) * (i as f32 + 0.5) / 10.0;
            shape.add(&garden::baluster_shape(IVORY), shift(x, 0.14, 0.0));
        }
        shape
    });
    let x = -7.45 - BANK[0][0] + 0.35;
    let z = -92.45 - BANK[1][0] + 0.35;
    let quarter = |at: Vec2, degrees: f32| spot(at.x, at.y, degrees) * shift(0.0, 0.03, 0.0);
    for bay in 0..5 {
        // North of the stairs, away from them.
        let at = vec2(x, AXIS - STAIRS - 0.9 - BAY * bay as f32);
        room.put("balustrade", &piece, quarter(at, 90.0));
    }
    let corner = AXIS + STAIRS + 0.9;
    let south = ((z - corner) / BAY).floor() as usize;
    for bay in 0..south {
        let at = vec2(x, corner + BAY * bay as f32);
        room.put("balustrade", &piece, quarter(at, -90.0));
    }
    for bay in 0..5 {
        let at = vec2(x - 0.6 - BAY * bay as f32, z);
        room.put("balustrade", &piece, quarter(at, 180.0));
    }
}

/// Statues at the foot of the bank, benches, urns before the walls.
fn ornaments(room: &mut Room, ground: &Ground) {
    let base = column::pedestal(room.shop, 0.8, 1.1, PALE_STONE, STONE);
    let places = [
        ([-33.5, AXIS - 5.2], 150.0),
        ([-33.5, AXIS + 5.2], 30.0),
        ([-71.0, AXIS - 5.2], 60.0),
        ([-71.0, AXIS + 5.2], 120.0),
    ];
    for (i, (at, turn)) in places.into_iter().enumerate() {
        let statue = statue::figure(room.shop, Pose::ALL[i], WHITE_MARBLE, VERDIGRIS);
        let place = Transform::translation(ground.on(Vec2::from(at)).into())
            * Transform::rotation([0.0, 1.0, 0.0], f64::to_radians(turn));
        room.put("pedestal", &base, place * shift(0.0, -0.03, 0.0));
        room.put("statue", &statue, place * shift(0.0, 1.07, 0.0) * scaled(1.15));
    }
    let bench = garden::bench(room.shop, PALE_STONE);
    for z in [-107.0, -137.0] {
        room.put("bench", &bench, spot(-23.0, z, 90.0));
    }
    let urn = ornament::urn(room.shop, TERRACOTTA, STONE);
    for z in [-102.3, -107.0, -112.0, -122.0, -127.2, -132.2] {
        room.put(
            "urn",
            &urn,
            spot(-8.6, z, 0.0) * shift(0.0, TERRACE, 0.0) * scaled(1.5),
        );
    }
}
