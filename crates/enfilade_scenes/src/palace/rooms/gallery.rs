//! The long gallery beside the enfilade, between the salons and the court.

use super::*;

/// The middle of the gallery's floor.
const MIDDLE: f32 = -11.0;

pub(super) fn gallery(room: &mut Room) {
    let [south, north] = [-22.0, -81.0];
    // An arch between every two windows.
    let arches: Vec<f32> = [
        -24.5, -29.0, -34.0, -39.0, -44.0, -49.0, -54.0, -59.0, -64.0, -69.0, -74.0, -78.5,
    ]
    .map(|z: f32| south - z)
    .to_vec();
    for side in [Side::North, Side::South] {
        ceiling::lunette(room, side, 0.1, GREEN_MARBLE, GOLD);
    }
    ceiling::ribs(room, IVORY, 0.5, 0.2, &arches);
    ceiling::coffer_vault(
        room,
        3,
        Coffering {
            rib: IVORY,
            step: GOLD,
            rosette: GOLD,
        },
    );
    let flat = column::pilaster(room.shop, 4.55, WHITE_MARBLE, GOLD);
    for arch in &arches {
        for side in [Side::West, Side::East] {
            let at = along(room, side, south - arch);
            room.hang("pilaster", &flat, side, at, 0.0);
        }
    }
    windows(room);
    eastern_wall(room);
    for (i, z) in [-28.0, -37.5, -46.9, -56.4, -65.8, -75.0].into_iter().enumerate() {
        light::chandelier(
            room,
            [MIDDLE, z],
            4.3,
            10,
            1.4,
            if i % 2 == 0 { GOLD } else { SILVER },
        );
    }
    let bench = seat::stool(room.shop, GOLD, GREEN_VELVET);
    for z in [-29.0, -34.0, -39.0, -44.0, -59.0, -64.0, -69.0, -74.0] {
        room.put("stool", &bench, spot(-13.9, z, 90.0));
    }
    for (z, turn) in [(south - 0.9, 180.0), (north + 0.9, 0.0)] {
        let base = column::pedestal(room.shop, 1.1, 1.0, RED_MARBLE, GOLD);
        room.put("pedestal", &base, spot(MIDDLE, z, turn));
        let statue = statue::figure(
            room.shop,
            if turn == 0.0 { Pose::Torch } else { Pose::Staff },
            BRONZE,
            GOLD,
        );
        room.put(
            "statue",
            &statue,
            spot(MIDDLE, z, turn) * shift(0.0, 1.0, 0.0) * scaled(1.35),
        );
    }
    let carpet = drapery::carpet(room.shop, [2.2, 12.0], [GREEN_SILK, DARK_RED, GOLD]);
    for z in [-30.0, -64.0, -74.5] {
        room.put("carpet", &carpet, spot(MIDDLE, z, 0.0));
    }
}

/// The place along a wall that lies at z.
fn along(room: &Room, side: Side, z: f32) -> f32 {
    let wall = room.wall(side);
    wall.along(vec2(wall.left.x, z))
}

/// Panes, bars and curtains of the windows to the court.
fn windows(room: &mut Room) {
    let panes = room.shop.piece("window panes".to_owned(), || {
        let mut shape = Shape::new();
        let outline: Vec<Vec3> = arched(2.0, 0.9, 3.2, 1.0)
            .into_iter()
            .map(|at| at.extend(-0.3))
            .collect();
        shape.face(PANE, &outline);
        shape
    });
    let bars = room.shop.piece("window bars".to_owned(), || {
        let outline = arched(2.0, 0.9, 3.2, 1.0);
        let mut shape = surround(
            IVORY,
            &outline,
            true,
            &[[-0.07, -0.33], [-0.07, -0.27], [0.0, -0.27]],
        );
        shape.join(block(IVORY, [-0.035, 0.9, -0.32], [0.035, 4.2, -0.28]));
        for up in [1.65, 2.4, 3.15] {
            shape.join(block(IVORY, [-0.97, up, -0.315], [0.97, up + 0.045, -0.285]));
        }
        for x in [-0.5, 0.5] {
            shape.join(block(IVORY, [x - 0.018, 0.95, -0.31], [x + 0.018, 3.15, -0.29]));
        }
        shape
    });
    let cloth = drapery::curtain(room.shop, 0.95, 4.3, GREEN_VELVET, GOLD);
    let lace = drapery::curtain(room.shop, 0.8, 4.2, LACE, IVORY);
    let swags = drapery::swags(room.shop, 2.9, 3, GREEN_VELVET, GOLD);
    for z in doors::WINDOWS_AT {
        let at = along(room, Side::West, z);
        let frame = room.wall(Side::West).at(at, 0.0);
        room.put("window panes", &panes, frame);
        room.put("window bars", &bars, frame);
        room.put("swags", &swags, frame * shift(-1.45, 4.55, 0.0));
        for side in [-1.0, 1.0] {
            let place = frame * shift(-1.42 * side, 0.1, 0.0) * Transform::scaling([side, 1.0, 1.0]);
            room.put("curtain", &cloth, place);
            let inner = frame * shift(-1.35 * side, 0.2, -0.06) * Transform::scaling([side, 1.0, 1.0]);
            room.put("lace", &lace, inner);
        }
    }
}

/// Statues on pedestals and paintings between the doors.
fn eastern_wall(room: &mut Room) {
    let wall = room.design.plan.wall(Side::East);
    let base = column::pedestal(room.shop, 0.62, 1.05, GREEN_MARBLE, GOLD);
    let hairs = [Hair::Curls, Hair::Wig, Hair::Beard, Hair::Knot];
    for (i, z) in [-31.5, -36.5, -41.5, -51.5, -56.5, -61.5, -66.5, -71.5]
        .into_iter()
        .enumerate()
    {
        let at = along(room, Side::East, z);
        if i % 2 == 0 {
            niche(room, wall, at, 0.5, [1.6, 2.5, 0.38], RED_MARBLE);
            let place = room.walls()[wall].at(at, PAVING) * shift(0.0, 0.0, 0.5);
            let plinth = column::pedestal(room.shop, 0.8, 0.6, WHITE_MARBLE, GREEN_MARBLE);
            room.put("pedestal", &plinth, place);
            let statue = statue::figure(room.shop, Pose::ALL[i / 2], WHITE_MARBLE, GOLD);
            room.put("statue", &statue, place * shift(0.0, 0.6, -0.1) * scaled(1.15));
        } else {
            painting(room, Side::East, at, 1.9, [2.0, 1.6]);
            room.put("pedestal", &base, spot(-8.0, z, -90.0));
            let bust = statue::bust(room.shop, hairs[i / 2], WHITE_MARBLE, GOLD);
            room.put("bust", &bust, spot(-8.0, z, -90.0) * shift(0.0, 1.05, 0.0));
        }
    }
    for (i, z) in [-24.5, -29.0, -49.5, -44.5, -74.0, -78.9].into_iter().enumerate() {
        room.put("pedestal", &base, spot(-8.05, z, -90.0));
        let urn = ornament::urn(room.shop, [COBALT, GREEN_MARBLE, RED_MARBLE][i % 3], GOLD);
        room.put(
            "urn",
            &urn,
            spot(-8.05, z, 0.0) * shift(0.0, 1.05, 0.0) * scaled(1.1),
        );
    }
}
