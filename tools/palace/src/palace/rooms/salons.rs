//! The reception rooms: red, green and blue salon, and the mirror room.

use super::*;

/// A hearth with a mirror over it, candelabra, and space for a clock between them.
fn chimney(room: &mut Room, side: Side, along: f32, marble: MaterialId) {
    let gilt = room.design.style.gilt;
    mirror(room, side, along, hearth::MANTEL + 0.12, [1.5, 1.9], 0.45);
    hearth::hearth(room, side, along, marble, gilt);
    let shelf = room.wall(side).at(along, hearth::MANTEL);
    for x in [-0.72, 0.72] {
        light::candelabrum(room, shelf * shift(x, 0.0, 0.16), 0.46, gilt);
    }
    let vase = ornament::vase(room.shop, 3, COBALT, gilt);
    room.put("vase", &vase, shelf * shift(0.0, 0.0, 0.16));
}

/// A round table with chairs around it and an item on top.
fn circle(room: &mut Room, at: Vec2, radius: f32, chair: &Arc<Mesh>, count: usize, first: f64) {
    let table = table::round_table(room.shop, radius, MAHOGANY, GOLD);
    room.put("round table", &table, spot(at.x, at.y, 0.0));
    for i in 0..count {
        let angle = first + 2.0 * PI * i as f64 / count as f64;
        let (sin, cos) = angle.sin_cos();
        let out = radius + 0.42;
        let place = spot(
            at.x + out * sin as f32,
            at.y + out * cos as f32,
            angle.to_degrees() as f32 + 180.0,
        );
        room.put("chair", chair, place);
    }
}

pub(super) fn red_salon(room: &mut Room) {
    chimney(room, Side::North, 2.45, BLACK_MARBLE);
    painting(room, Side::North, 10.7, 1.9, [2.4, 1.8]);
    painting(room, Side::South, 2.4, 1.9, [2.2, 1.7]);
    painting(room, Side::South, 10.7, 1.9, [2.2, 1.7]);
    for (side, along) in [
        (Side::West, 1.9),
        (Side::West, 7.2),
        (Side::East, 1.9),
        (Side::East, 7.2),
    ] {
        painting(room, side, along, 2.1, [1.3, 1.7]);
    }
    let sofa = seat::sofa(room.shop, GOLD, RED_SILK);
    let chair = seat::armchair(room.shop, GOLD, RED_SILK);
    room.put("sofa", &sofa, spot(4.15, -30.0, 0.0));
    room.put("sofa", &sofa, spot(4.15, -22.0, 180.0));
    room.put("sofa", &sofa, spot(-4.15, -22.0, 180.0));
    for (x, z, turn) in [
        (-3.3, -28.6, 205.0),
        (-5.2, -28.6, 155.0),
        (2.6, -24.0, 60.0),
        (5.6, -24.0, -60.0),
    ] {
        room.put("armchair", &chair, spot(x, z, turn));
    }
    circle(room, vec2(4.1, -26.0), 0.62, &chair, 4, 0.785);
    let vase = ornament::urn(room.shop, COBALT, GOLD);
    room.put(
        "urn",
        &vase,
        spot(4.1, -26.0, 30.0) * shift(0.0, 0.77, 0.0) * scaled(0.7),
    );
    let carpet = drapery::carpet(room.shop, [4.2, 5.6], Rug::Red);
    room.put("carpet", &carpet, spot(4.1, -26.0, 0.0));
    room.put("carpet", &carpet, spot(-4.1, -26.0, 0.0));
    let stand = column::pedestal(room.shop, 0.42, 1.15, BLACK_MARBLE, GOLD);
    for (x, z) in [(-6.1, -21.9), (6.1, -21.9), (6.1, -30.1), (-6.1, -30.1)] {
        room.put("pedestal", &stand, spot(x, z, 0.0));
        light::candelabrum(room, spot(x, z, 0.0) * shift(0.0, 1.15, 0.0), 0.8, GOLD);
    }
    let size = room.design.height + 1.2;
    ceiling::rose(room, vec2(0.0, -26.0), 1.6, IVORY, GOLD);
    light::chandelier(room, [0.0, -26.0], size - 3.2, 12, 1.7, GOLD);
}

pub(super) fn green_salon(room: &mut Room) {
    ceiling::coffer_flat(
        room,
        1.65,
        Coffering {
            rib: IVORY,
            step: GOLD,
            rosette: OLD_GOLD,
        },
    );
    chimney(room, Side::West, 4.05, GREEN_MARBLE);
    painting(room, Side::North, 2.5, 1.9, [2.6, 1.9]);
    painting(room, Side::North, 10.6, 1.9, [2.6, 1.9]);
    painting(room, Side::South, 2.5, 1.9, [2.6, 1.9]);
    painting(room, Side::South, 10.6, 1.9, [2.6, 1.9]);
    let chair = seat::armchair(room.shop, GOLD, GREEN_VELVET);
    let sofa = seat::sofa(room.shop, GOLD, GREEN_VELVET);
    for (x, z, turn) in [
        (-3.0, -34.3, -120.0),
        (-3.0, -36.7, -60.0),
        (-4.3, -33.6, -150.0),
        (-4.3, -37.4, -30.0),
    ] {
        room.put("armchair", &chair, spot(x, z, turn));
    }
    room.put("sofa", &sofa, spot(3.9, -39.0, 0.0));
    room.put("sofa", &sofa, spot(3.9, -32.0, 180.0));
    room.put("sofa", &sofa, spot(-3.9, -39.0, 0.0));
    circle(room, vec2(3.7, -35.5), 0.7, &chair, 3, 0.5);
    let knot = ornament::knot_sculpture(room.shop, 3, GOLD, BLACK_MARBLE);
    room.put(
        "knot",
        &knot,
        spot(3.7, -35.5, 0.0) * shift(0.0, 0.77, 0.0) * scaled(0.55),
    );
    let carpet = drapery::carpet(room.shop, [4.0, 5.0], Rug::Green);
    room.put("carpet", &carpet, spot(3.8, -35.5, 0.0));
    room.put("carpet", &carpet, spot(-3.8, -35.5, 0.0));
    let stand = column::pedestal(room.shop, 0.5, 1.1, GREEN_MARBLE, GOLD);
    for (i, (x, z)) in [(-5.9, -32.1), (5.9, -32.1), (5.9, -38.9), (-5.9, -38.9)]
        .into_iter()
        .enumerate()
    {
        let bust = statue::bust(
            room.shop,
            [Hair::Wig, Hair::Knot, Hair::Curls, Hair::Beard][i],
            WHITE_MARBLE,
            GOLD,
        );
        let facing = if z > -35.0 { 180.0 } else { 0.0 };
        room.put("pedestal", &stand, spot(x, z, 0.0));
        room.put("bust", &bust, spot(x, z, facing) * shift(0.0, 1.1, 0.0));
    }
    light::chandelier(room, [0.0, -35.5], 4.1, 12, 1.6, GOLD);
}

pub(super) fn blue_salon(room: &mut Room) {
    chimney(room, Side::West, 4.05, WHITE_MARBLE);
    for (side, along) in [
        (Side::North, 2.5),
        (Side::North, 10.6),
        (Side::South, 2.5),
        (Side::South, 10.6),
    ] {
        painting(room, side, along, 1.8, [1.7, 2.2]);
    }
    let chair = seat::armchair(room.shop, GOLD, BLUE_SILK);
    let stool = seat::stool(room.shop, GOLD, BLUE_SILK);
    let sofa = seat::sofa(room.shop, GOLD, BLUE_SILK);
    for z in [-55.1, -61.9] {
        let turn = if z > -58.0 { 180.0 } else { 0.0 };
        room.put("sofa", &sofa, spot(-4.1, z, turn));
        room.put("sofa", &sofa, spot(4.1, z, turn));
        for x in [-2.3, 2.3] {
            room.put("stool", &stool, spot(x, z, turn));
        }
    }
    for (x, z, turn) in [(-3.2, -57.3, -120.0), (-3.2, -59.7, -60.0)] {
        room.put("armchair", &chair, spot(x, z, turn));
    }
    circle(room, vec2(3.4, -60.4), 0.55, &chair, 3, 0.0);
    let globe = ornament::armillary(room.shop, GOLD, COBALT);
    room.put(
        "armillary",
        &globe,
        spot(3.4, -60.4, 0.0) * shift(0.0, 0.77, 0.0) * scaled(0.6),
    );
    let console = table::console(room.shop, 1.5, WHITE_MARBLE, GOLD);
    room.put("console", &console, spot(6.52, -61.2, -90.0));
    room.put("console", &console, spot(6.52, -55.8, -90.0));
    for (i, z) in [-61.5, -60.9, -56.1, -55.5].into_iter().enumerate() {
        let vase = ornament::vase(room.shop, i, PORCELAIN, COBALT);
        room.put("vase", &vase, spot(6.25, z, 0.0) * shift(0.0, 0.93, 0.0));
    }
    let carpet = drapery::carpet(room.shop, [9.0, 5.2], Rug::Blue);
    room.put("carpet", &carpet, spot(0.0, -58.5, 0.0));
    let size = room.design.crown();
    ceiling::rose(room, vec2(0.0, -58.5), 1.5, IVORY, GOLD);
    light::chandelier(room, [0.0, -58.5], size - 3.1, 10, 1.6, SILVER);
}

pub(super) fn mirror_room(room: &mut Room) {
    for along in [1.35, 4.05, 6.75] {
        mirror(room, Side::East, along, 0.5, [1.7, 3.1], 0.85);
    }
    let bay = room.design.plan.wall(Side::West);
    // Opposite the one in the east.
    mirror(room, Side::West, 4.05, 0.5, [1.7, 3.1], 0.85);
    for (i, along) in [1.35, 6.75].into_iter().enumerate() {
        niche(room, bay, along, 0.5, [1.5, 2.6, 0.38], BLUE_SILK);
        let base = column::pedestal(room.shop, 0.75, 0.6, WHITE_MARBLE, ROSE);
        let place = room.walls()[bay].at(along, PAVING) * shift(0.0, 0.0, 0.48);
        room.put("pedestal", &base, place);
        let statue = statue::figure(room.shop, Pose::ALL[(i + 1) % 5], WHITE_MARBLE, GOLD);
        room.put("statue", &statue, place * shift(0.0, 0.6, -0.1) * scaled(1.1));
        let from = place.point([0.0, 5.0, 3.0]);
        room.lamps
            .push(Lamp::spot(from, place.point([0.0, 1.7, 0.0]), 12.0));
    }
    let flat = column::pilaster(room.shop, 5.7, ROSE, GOLD);
    for side in [Side::East, Side::West] {
        for along in [2.7, 5.4] {
            room.hang("pilaster", &flat, side, along, 0.0);
        }
    }
    let stool = seat::stool(room.shop, GOLD, ROSE);
    for z in [-64.4, -66.2, -68.8, -70.6] {
        room.put("stool", &stool, spot(-5.6, z, 90.0));
        light::candelabrum(room, spot(5.7, z, 0.0), 1.75, GOLD);
    }
    for (side, along) in [
        (Side::North, 2.5),
        (Side::North, 10.6),
        (Side::South, 2.5),
        (Side::South, 10.6),
    ] {
        let place = room.wall(side).at(along, 2.6);
        light::sconce(room, place, GOLD);
        let console = table::console(room.shop, 1.6, BLACK_MARBLE, GOLD);
        let foot = room.wall(side).at(along, PAVING);
        room.put("console", &console, foot);
        let urn = ornament::urn(room.shop, PORCELAIN, GOLD);
        room.put("urn", &urn, foot * shift(0.0, 0.93, 0.23) * scaled(0.8));
    }
    let up = room.design.crown();
    for x in [-3.2, 3.2] {
        ceiling::rose(room, vec2(x, -67.5), 1.1, IVORY, GOLD);
        light::chandelier(room, [x, -67.5], up - 3.4, 12, 1.6, GOLD);
    }
}
