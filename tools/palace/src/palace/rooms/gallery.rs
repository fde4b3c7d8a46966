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
    windows::glaze(room, PANE, GREEN_CURTAIN);
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
    let carpet = drapery::carpet(room.shop, [2.2, 12.0], Rug::Green);
    for z in [-30.0, -64.0, -74.5] {
        room.put("carpet", &carpet, spot(MIDDLE, z, 0.0));
    }
}

/// Returns the distance along a wall of the point at z.
fn along(room: &Room, side: Side, z: f32) -> f32 {
    let wall = room.wall(side);
    wall.along(vec2(wall.left.x, z))
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
