//! The palace's facades towards the garden: the end of the enfilade in the east, the wing of the painted gallery in the
//! south.

use super::AXIS;
use crate::envelope::Side;
use crate::palace::palette::*;
use crate::palace::room::{Room, shift};
use crate::palace::rooms::court::{lower_window, upper_window, window_cases};
use crate::palace::{column, garden, windows};
use crate::shape::{Shape, block, moulding, prism};
use enfilade::{MaterialId, Transform};
use glam::{Vec2, Vec3, vec2, vec3};

/// Height of the walls, below the roof.
pub(super) const HEIGHT: f32 = 9.0;

/// Bays of the eastern wall: middles as z, and which of them have pilasters between. Bays without a window get a blind
/// one.
const EAST_BAYS: [f32; 15] = [
    -95.1, -99.9, -104.65, -109.35, -114.27, AXIS, -119.77, -124.7, -129.7, -134.7, -139.7, -144.7, -149.7,
    -154.7, -159.0,
];
const EAST_PILASTERS: [f32; 14] = [
    -93.0, -97.5, -102.3, -107.0, -112.0, -122.0, -127.2, -132.2, -137.2, -142.2, -147.2, -152.2, -157.2,
    -161.4,
];

/// Bays of the southern wall, as x.
const SOUTH_BAYS: [f32; 14] = [
    -9.6, -12.5, -17.0, -21.0, -25.0, -27.75, -30.5, -34.5, -38.5, -43.5, -48.5, -53.5, -58.5, -63.5,
];
const SOUTH_PILASTERS: [f32; 11] = [
    -14.9, -19.0, -23.2, -32.3, -36.5, -41.0, -46.0, -51.0, -56.0, -61.0, -65.4,
];

/// Extent of the pedimented middle of the eastern wall, as z.
const MIDDLE: [f32; 2] = [-122.6, -111.4];

pub(super) fn build(room: &mut Room) {
    window_cases(room);
    let painted: Vec<_> = (room.doorways.iter())
        .filter(|door| door.wall == room.design.plan.wall(Side::South))
        .copied()
        .collect();
    for window in painted {
        windows::sash(room, &window, PANE);
    }
    bays(room, Side::East, &EAST_BAYS, &EAST_PILASTERS);
    bays(room, Side::South, &SOUTH_BAYS, &SOUTH_PILASTERS);
    let corners = room.design.plan.corners();
    let path = [corners[2], corners[3], corners[0]];
    let mut shape = Shape::new();
    for (material, foot, profile) in [
        (PALE_STONE, 0.0, &PLINTH[..]),
        (PALE_STONE, 4.85, &STRING),
        (PALE_STONE, 7.4, &CORNICE),
        (PALE_STONE, HEIGHT - 1.0, &RAIL_FOOT),
        (PALE_STONE, HEIGHT - 0.22, &RAIL),
        (SLATE, HEIGHT, &ROOF),
    ] {
        shape.join(moulding(material, &path, false, foot, profile));
    }
    room.make("mouldings", &shape);
    parapet(room, &path);
    pediment(room);
    chimneys(room);
}

const PLINTH: [[f32; 2]; 4] = [[0.0, 0.0], [0.12, 0.0], [0.12, 0.6], [0.0, 0.7]];
const STRING: [[f32; 2]; 5] = [[0.0, 0.0], [0.06, 0.04], [0.12, 0.14], [0.12, 0.2], [0.0, 0.26]];
const CORNICE: [[f32; 2]; 8] = [
    [0.0, 0.0],
    [0.26, 0.0],
    [0.26, 0.16],
    [0.34, 0.2],
    [0.34, 0.34],
    [0.52, 0.46],
    [0.58, 0.58],
    [0.0, 0.6],
];
const RAIL_FOOT: [[f32; 2]; 4] = [[0.0, 0.0], [0.34, 0.0], [0.34, 0.1], [0.0, 0.1]];
const RAIL: [[f32; 2]; 5] = [[0.0, 0.0], [0.3, 0.0], [0.36, 0.08], [0.3, 0.2], [0.0, 0.2]];
/// Steep, because the roof has only half of the wall's depth.
const ROOF: [[f32; 2]; 4] = [[0.0, 0.0], [-0.28, 2.3], [-0.24, 2.32], [-0.36, 2.5]];

/// Adds pilasters and blind windows.
fn bays(room: &mut Room, side: Side, bays: &[f32], pilasters: &[f32]) {
    let [upper, lower] = [upper_window(room.shop), lower_window(room.shop)];
    let giant = column::pilaster(room.shop, 7.4, PALE_STONE, STONE);
    let wall = room.wall(side);
    let along = |at: f32| {
        let at = if side == Side::East {
            vec2(wall.left.x, at)
        } else {
            vec2(at, wall.left.y)
        };
        wall.along(at)
    };
    let open: Vec<f32> = (room.doorways.iter())
        .filter(|door| door.wall == room.design.plan.wall(side))
        .map(|door| door.along)
        .collect();
    for middle in bays.iter().map(|&at| along(at)) {
        let nearest = open
            .iter()
            .fold(f32::INFINITY, |least, door| least.min((door - middle).abs()));
        room.put("upper window", &upper, wall.at(middle, 5.4));
        if nearest > 1.2 {
            room.put("blind window", &lower, wall.at(middle, 0.0));
        }
    }
    for &at in pilasters {
        room.put("pilaster", &giant, wall.at(along(at), 0.0));
    }
}

/// Adds a balustrade along the top of the walls, except at the pediment.
fn parapet(room: &mut Room, path: &[Vec2; 3]) {
    const BAY: f32 = 4.0;
    let row = room.shop.piece("row of balusters".to_owned(), || {
        let mut shape = block(PALE_STONE, [-0.25, 0.0, 0.0], [0.25, 0.72, 0.3]);
        for i in 0..9 {
            let x = 0.25 + (BAY - 0.5) * (f32::from(i as u8) + 0.5) / 9.0;
            shape.add(&garden::baluster_shape(IVORY), shift(x, 0.0, 0.15));
        }
        shape
    });
    for ends in path.windows(2) {
        let long = ends[0].distance(ends[1]);
        let right = (ends[1] - ends[0]) / long;
        for bay in 0..(long / BAY) as usize {
            let at = ends[0] + right * (BAY * bay as f32 + 0.3);
            let middle = at + right * 2.0;
            if middle.x > -8.0 && middle.y > MIDDLE[0] - 1.0 && middle.y < MIDDLE[1] + 1.0 {
                continue;
            }
            let place = Transform::from_columns([
                [right.x, 0.0, right.y],
                [0.0, 1.0, 0.0],
                [-right.y, 0.0, right.x],
                [at.x, HEIGHT - 0.92, at.y],
            ]);
            room.put("balustrade", &row, place);
        }
    }
}

/// A gable over the middle of the eastern wall, with a round window in it.
fn pediment(room: &mut Room) {
    let wall = room.wall(Side::East);
    let middle = wall.along(vec2(wall.left.x, 0.5 * (MIDDLE[0] + MIDDLE[1])));
    let half = 0.5 * (MIDDLE[1] - MIDDLE[0]);
    let [foot, rise] = [HEIGHT - 1.0, 2.9];
    let flat = |corners: &[[f32; 2]], out: f32| -> Vec<Vec3> {
        corners.iter().map(|&[x, y]| vec3(x, y, out)).collect()
    };
    let mut shape = prism(
        PALE_ASHLAR,
        &flat(&[[-half, foot], [half, foot], [0.0, foot + rise]], 0.0),
        Vec3::Z * 0.2,
    );
    let [wide, thick] = [half + 0.45, 0.36];
    let slope = [
        [
            [-wide, foot - 0.1],
            [0.0, foot + rise],
            [0.0, foot + rise + thick],
            [-wide, foot - 0.1 + thick],
        ],
        [
            [0.0, foot + rise],
            [wide, foot - 0.1],
            [wide, foot - 0.1 + thick],
            [0.0, foot + rise + thick],
        ],
    ];
    for outline in slope {
        shape.join(prism(PALE_STONE, &flat(&outline, 0.0), Vec3::Z * 0.62));
    }
    shape.join(block(
        PALE_STONE,
        [-wide, foot - 0.12, 0.0],
        [wide, foot + 0.14, 0.6],
    ));
    let disc = |material: MaterialId, radius: f32, out: f32| {
        let around: Vec<[f32; 2]> = crate::shape::around(24)
            .map(|at| [radius * at.x, foot + 1.15 - radius * at.y])
            .collect();
        prism(material, &flat(&around, 0.2), Vec3::Z * out)
    };
    shape.join(disc(PALE_STONE, 0.72, 0.12));
    shape.join(disc(NIGHT_BLUE, 0.52, 0.14));
    let mesh = shape.dressed(dress);
    room.put("pediment", &mesh, wall.at(middle, 0.0));
}

/// The roof, as thin as the walls' depth allows.
fn chimneys(room: &mut Room) {
    let mut shape = Shape::new();
    for z in [-98.0, -108.0, -126.0, -138.0, -150.0] {
        shape.join(block(TERRACOTTA, [-7.35, 11.0, z - 0.7], [-7.06, 12.6, z + 0.7]));
        shape.join(block(PALE_STONE, [-7.4, 12.6, z - 0.8], [-7.03, 12.8, z + 0.8]));
    }
    for x in [-16.0, -27.75, -40.0, -52.0] {
        shape.join(block(
            TERRACOTTA,
            [x - 0.7, 11.0, -92.35],
            [x + 0.7, 12.4, -92.06],
        ));
        shape.join(block(PALE_STONE, [x - 0.8, 12.4, -92.4], [x + 0.8, 12.6, -92.03]));
    }
    room.make("chimneys", &shape);
}
