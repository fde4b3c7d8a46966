//! The small rooms east of the enfilade.

use super::*;

pub(super) fn porcelain_cabinet(room: &mut Room) {
    let clay = [PORCELAIN, COBALT, PALE_BLUE, PALE_GREEN, IVORY];
    // Three cases in the middle, two shelves of vases in each.
    for (row, z) in [-33.7, -35.5, -37.3].into_iter().enumerate() {
        let size = [2.6, 0.95, 0.7];
        let [frame, panes] = case::glass_case(room.shop, size, GOLD, IVORY);
        let place = spot(11.6, z, 0.0);
        for i in 0..7 {
            let x = -1.05 + 0.35 * i as f32;
            let vase = ornament::vase(room.shop, row + i, clay[(row + i) % 5], clay[(i + 1) % 5]);
            room.put("vase", &vase, place * shift(x, 0.76, 0.0) * scaled(0.8));
        }
        room.put("case frame", &frame, place);
        room.put("case panes", &panes, place);
    }
    let shelf = room.shop.piece("bracket".to_owned(), || {
        let mut shape = block(GOLD, [-0.16, 0.0, 0.0], [0.16, 0.03, 0.24]);
        shape.join(
            lathe(
                GOLD,
                &[
                    [0.0, -0.2],
                    [0.03, -0.18],
                    [0.05, -0.08],
                    [0.12, -0.02],
                    [0.12, 0.0],
                ],
                12,
            )
            .bent(|at| vec3(at.x, at.y, at.z.max(-0.12) + 0.12)),
        );
        shape
    });
    for side in [Side::North, Side::South, Side::East] {
        let wall = room.wall(side);
        let count = (wall.length() / 0.8) as usize;
        for row in 0..3 {
            for i in 0..count {
                let along = wall.length() * (i as f32 + 0.5) / count as f32;
                let place = wall.at(along, 1.45 + 0.85 * row as f32);
                room.put("bracket", &shelf, place);
                let vase = ornament::vase(
                    room.shop,
                    i + row,
                    clay[(i + 2 * row) % 5],
                    clay[(i + row + 1) % 5],
                );
                room.put("vase", &vase, place * shift(0.0, 0.03, 0.13) * scaled(0.75));
            }
        }
    }
    let stool = seat::stool(room.shop, GOLD, BLUE_SILK);
    for (x, z) in [(8.6, -33.0), (8.6, -38.0), (14.3, -33.0), (14.3, -38.0)] {
        room.put("stool", &stool, spot(x, z, 45.0));
    }
    let up = room.design.crown();
    ceiling::rose(room, vec2(11.2, -35.5), 1.2, IVORY, GOLD);
    light::chandelier(room, [11.2, -35.5], up - 2.3, 8, 1.1, SILVER);
}

pub(super) fn chapel(room: &mut Room) {
    stained_windows(room);
    ceiling::ribs(room, PALE_STONE, 0.3, 0.2, &[0.2, 2.3, 4.3, 6.3, 8.35]);
    ceiling::coffer_vault(
        room,
        4,
        Coffering {
            rib: PALE_STONE,
            step: OLD_GOLD,
            rosette: GOLD,
        },
    );
    let shaft = column::plain_column(room.shop, 4.5 - PAVING, RED_MARBLE, WHITE_MARBLE);
    for z in [-50.4, -43.6] {
        for x in [9.75, 11.75, 13.75, 15.75] {
            room.put("column", &shaft, spot(x, z, 0.0));
        }
    }
    let pew = room.shop.piece("pew".to_owned(), || {
        let mut shape = block(OAK, [-1.1, 0.42, -0.2], [1.1, 0.46, 0.2]);
        shape.join(block(OAK, [-1.1, 0.46, -0.24], [1.1, 0.95, -0.2]));
        for x in [-1.1, 1.1] {
            shape.join(block(WALNUT, [x - 0.04, 0.0, -0.28], [x + 0.04, 1.02, 0.24]));
        }
        shape
    });
    for row in 0..4 {
        for z in [-49.0, -45.0] {
            room.put("pew", &pew, spot(9.6 + 1.15 * row as f32, z, 90.0));
        }
    }
    ceiling::stars(room, 110, GOLD);
    let altar = room.shop.piece("altar".to_owned(), || {
        let mut shape = block(WHITE_MARBLE, [-1.9, 0.0, -0.9], [1.9, 0.16, 0.9]);
        shape.join(block(WHITE_MARBLE, [-1.6, 0.16, -0.7], [1.6, 0.32, 0.6]));
        shape.join(block(RED_MARBLE, [-1.1, 0.32, -0.4], [1.1, 1.2, 0.2]));
        shape.join(block(IVORY, [-1.2, 1.2, -0.45], [1.2, 1.28, 0.25]));
        shape.join(block(GOLD, [-0.8, 0.48, 0.2], [0.8, 1.04, 0.22]));
        shape
    });
    let front = spot(17.4, -47.0, -90.0);
    room.put("altar", &altar, front);
    for x in [-0.95, -0.6, 0.6, 0.95] {
        light::candelabrum(room, front * shift(x, 1.28, -0.1), 0.6, GOLD);
    }
    let wall = room.design.plan.wall(Side::East) + 5;
    let lining = room.walls()[wall];
    room.take(wall, 0.0, lining.length());
    room.take(wall + 1, 0.0, room.walls()[wall + 1].length());
    let sun = room.shop.piece("glory".to_owned(), || {
        let mut shape = Shape::new();
        shape.add(
            &seat::sunburst(GOLD, 1.1),
            Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2),
        );
        shape
    });
    room.put("glory", &sun, spot(19.7, -47.0, -90.0) * shift(0.0, 4.3, 0.0));
    let statue = statue::figure(room.shop, Pose::Globe, WHITE_MARBLE, GOLD);
    let base = column::pedestal(room.shop, 0.7, 1.5, RED_MARBLE, GOLD);
    let stand = spot(19.2, -47.0, -90.0);
    room.put("pedestal", &base, stand);
    room.put("statue", &statue, stand * shift(0.0, 1.5, 0.0));
    for z in [-49.6, -44.4] {
        light::candelabrum(room, spot(16.6, z, 0.0), 1.7, GOLD);
    }
    light::chandelier(room, [11.7, -47.0], 4.2, 8, 1.2, OLD_GOLD);
}

/// Windows of colored glass in the apse and between the columns, lit from behind and opaque.
fn stained_windows(room: &mut Room) {
    let apse = room.design.plan.wall(Side::East);
    let walls = room.walls();
    for off in [1, 3, 8, 10] {
        let along = 0.5 * walls[apse + off].length();
        stained_window(room, apse + off, along, [0.64, 1.5, 3.5]);
    }
    for side in [Side::North, Side::South] {
        let number = room.design.plan.wall(side);
        for x in [10.75, 12.75, 14.75] {
            let wall = walls[number];
            let along = wall.along(vec2(x, wall.left.y));
            stained_window(room, number, along, [1.0, 1.2, 3.0]);
        }
        let middle = walls[number].at(0.5 * walls[number].length(), 2.6);
        let glow = middle.point([0.0, 0.0, 1.8]);
        room.lamps.push(Lamp::daylight(glow, [1.5, 1.15, 1.5], 8.0));
    }
}

fn stained_window(room: &mut Room, wall: usize, along: f32, [wide, foot, spring]: [f32; 3]) {
    const BORDER: [[f32; 2]; 5] = [[0.0, 0.0], [0.0, 0.04], [0.05, 0.06], [0.12, 0.04], [0.12, 0.0]];
    let outline = arched(wide, foot, spring, 0.5 * wide);
    room.cut(wall, along, &outline, 0.25, Some(STAINED_GLASS), PALE_STONE);
    room.take(wall, along - 0.5 * wide - 0.16, along + 0.5 * wide + 0.16);
    let border = room.shop.piece(format!("stained window {wide}"), || {
        surround(PALE_STONE, &outline, true, &BORDER)
    });
    let place = room.walls()[wall].at(along, 0.0);
    room.put("window case", &border, place);
}

pub(super) fn winter_garden(room: &mut Room) {
    // The vault is of glass: sunlight and sky light enter through it.
    room.lamps.push(Lamp::sun(1.6));
    room.lamps
        .push(Lamp::daylight([12.2, 6.6, -61.5], [9.0, 10.0, 11.0], 16.0));
    let arches: Vec<f32> = (0..=6).map(|i| 0.15 + 1.95 * i as f32).collect();
    ceiling::ribs(room, VERDIGRIS, 0.14, 0.16, &arches);
    // Bars along the vault, so that it looks glazed.
    ceiling::coffer_vault(
        room,
        2,
        Coffering {
            rib: VERDIGRIS,
            step: WHITE_MARBLE,
            rosette: VERDIGRIS,
        },
    );
    let center = vec2(12.2, -61.5);
    let pool = garden::fountain(room.shop, WHITE_MARBLE);
    room.put("fountain", &pool, spot(center.x, center.y, 0.0) * scaled(0.62));
    for i in 0..10 {
        let (sin, cos) = (2.0 * PI * f64::from(i) / 10.0 + 0.3).sin_cos();
        let at = center + vec2(3.6 * cos as f32, 4.6 * sin as f32);
        let tall = [2.6, 3.4, 3.0][i as usize % 3];
        let palm = garden::palm(room.shop, tall, TERRACOTTA);
        room.put("palm", &palm, spot(at.x, at.y, 77.0 * i as f32));
    }
    let orange = garden::orange_tree(room.shop, PALE_OAK);
    for (x, z) in [
        (8.3, -56.4),
        (16.2, -56.4),
        (16.2, -66.6),
        (8.3, -66.6),
        (16.2, -61.5),
        (12.2, -66.7),
        (12.2, -56.3),
    ] {
        room.put("orange tree", &orange, spot(x, z, 10.0 * z));
    }
    let bench = garden::bench(room.shop, WHITE_MARBLE);
    for z in [-59.0, -64.0] {
        room.put("bench", &bench, spot(16.4, z, -90.0));
    }
    room.put("bench", &bench, spot(8.0, -63.4, 90.0));
}

pub(super) fn study(room: &mut Room) {
    ceiling::beams(room, OAK, MAHOGANY, 1.4);
    let desk = table::desk(room.shop, MAHOGANY, GREEN_SILK, OLD_GOLD);
    room.put("desk", &desk, spot(11.4, -91.0, 0.0));
    let chair = seat::armchair(room.shop, MAHOGANY, GREEN_VELVET);
    room.put("armchair", &chair, spot(11.4, -91.7, 0.0));
    for (x, z, turn) in [(9.0, -84.6, 150.0), (12.8, -84.6, 200.0)] {
        room.put("armchair", &chair, spot(x, z, turn));
    }
    light::candelabrum(
        room,
        spot(10.8, -91.0, 0.0) * shift(0.0, 0.79, 0.0),
        0.4,
        OLD_GOLD,
    );
    let knot = ornament::knot_sculpture(room.shop, 5, OLD_GOLD, BLACK_MARBLE);
    room.put(
        "knot",
        &knot,
        spot(12.0, -91.05, 0.0) * shift(0.0, 0.79, 0.0) * scaled(0.3),
    );
    for (i, along) in [1.0, 2.6, 4.2, 5.8].into_iter().enumerate() {
        for side in [Side::North, Side::South] {
            let shelf = case::bookcase(room.shop, i as u64 + side as u64, 1.5, 3.3, MAHOGANY, OLD_GOLD);
            room.hang("bookcase", &shelf, side, along, PAVING);
            let wall = room.design.plan.wall(side);
            room.take(wall, along - 0.85, along + 0.85);
        }
    }
    let globe = ornament::globe(room.shop, WALNUT, NIGHT_BLUE, OLD_GOLD);
    room.put("globe", &globe, spot(8.5, -90.9, 0.0) * scaled(0.9));
    let carpet = drapery::carpet(room.shop, [4.6, 4.6], Rug::Red);
    room.put("carpet", &carpet, spot(11.0, -87.7, 0.0));
    let clock = case::long_clock(room.shop, MAHOGANY, OLD_GOLD);
    room.put("clock", &clock, spot(14.2, -91.98, 0.0));
    for along in [1.3, 7.2] {
        painting(room, Side::East, along, 1.5, [1.2, 1.5]);
    }
}

pub(super) fn treasury(room: &mut Room) {
    for side in [Side::West, Side::East] {
        ceiling::lunette(room, side, 0.1, DARK_RED, OLD_GOLD);
    }
    ceiling::ribs(room, DARK_STONE, 0.35, 0.2, &[0.3, 2.6, 4.95, 7.25]);
    let chest = case::chest(room.shop, WALNUT, IRON);
    for (x, z, turn) in [
        (8.6, -22.7, 180.0),
        (10.2, -22.7, 180.0),
        (13.6, -22.7, 180.0),
        (8.6, -29.3, 0.0),
        (12.0, -29.3, 0.0),
        (13.7, -29.3, 0.0),
        (14.5, -24.5, -90.0),
        (14.5, -27.4, -90.0),
    ] {
        room.put("chest", &chest, spot(x, z, turn));
    }
    let [frame, panes] = case::glass_case(room.shop, [1.1, 0.8, 0.8], GOLD, RED_SILK);
    for (i, (x, z)) in [(10.0, -26.0), (12.4, -24.6), (12.4, -27.4)]
        .into_iter()
        .enumerate()
    {
        let place = spot(x, z, 0.0);
        match i {
            0 => {
                let crown = room.shop.piece("crown".to_owned(), crown);
                room.put("crown", &crown, place * shift(0.0, 0.78, 0.0));
            }
            1 => {
                let globe = ornament::armillary(room.shop, GOLD, COBALT);
                room.put("armillary", &globe, place * shift(0.0, 0.76, 0.0) * scaled(0.58));
            }
            _ => {
                let knot = ornament::knot_sculpture(room.shop, 3, GOLD, BLACK_MARBLE);
                room.put("knot", &knot, place * shift(0.0, 0.76, 0.0) * scaled(0.62));
            }
        }
        room.put("case frame", &frame, place);
        room.put("case panes", &panes, place);
    }
    let urn = ornament::urn(room.shop, GOLD, OLD_GOLD);
    for (x, z) in [(11.9, -22.7), (10.3, -29.3), (14.4, -26.0)] {
        let base = column::pedestal(room.shop, 0.5, 0.8, DARK_STONE, RED_MARBLE);
        room.put("pedestal", &base, spot(x, z, 0.0));
        room.put("urn", &urn, spot(x, z, 0.0) * shift(0.0, 0.8, 0.0));
    }
    let heap = room.shop.piece("heap".to_owned(), || {
        lathe(OLD_GOLD, &[[0.5, 0.0], [0.36, 0.09], [0.2, 0.16], [0.0, 0.2]], 14)
    });
    room.put("heap", &heap, spot(9.3, -28.2, 0.0));
    let coin = room.shop.piece("coin".to_owned(), || {
        lathe(GOLD, &[[0.0, 0.0], [0.02, 0.0], [0.02, 0.004], [0.0, 0.004]], 10)
    });
    for _ in 0..160 {
        let angle = f64::from(room.random.between(-3.0, 3.0));
        let out = 0.62 * room.random.unit().sqrt();
        let (sin, cos) = angle.sin_cos();
        let high = 0.205 * (1.0 - out / 0.5).max(0.02);
        let tilt = Transform::rotation(
            [cos as f32, 0.0, sin as f32],
            f64::from(room.random.between(-0.7, 0.7)),
        );
        let place = spot(9.3 + out * cos as f32, -28.2 + out * sin as f32, 0.0) * shift(0.0, high, 0.0);
        room.put("coin", &coin, place * tilt * scaled(1.8));
    }
    for side in [Side::North, Side::South] {
        for along in [1.6, 5.9] {
            let place = room.wall(side).at(along, 2.2);
            light::sconce(room, place, IRON);
        }
    }
}

/// A crown on a cushion.
fn crown() -> Shape {
    let mut shape = crate::shape::superquadric(RED_SILK, [0.24, 0.07, 0.24], 0.6, 0.4, 8, 20);
    let band = [
        [0.13, 0.08],
        [0.14, 0.08],
        [0.145, 0.16],
        [0.13, 0.16],
        [0.13, 0.08],
    ];
    shape.join(lathe(GOLD, &band, 32));
    for point in 0..8 {
        let turn = Transform::rotation([0.0, 1.0, 0.0], 2.0 * PI * f64::from(point) / 8.0);
        let spike = crate::shape::taper(GOLD, [0.06, 0.015], 0.11, [0.0, 0.0]);
        shape.add(&spike, turn * shift(0.0, 0.15, 0.138));
        let gem = crate::shape::ball([RED_SILK, COBALT][point as usize % 2], 0.018, 6, 8);
        shape.add(&gem, turn * shift(0.0, 0.12, 0.148));
        shape.add(
            &crate::shape::ball(IVORY, 0.014, 6, 8),
            turn * shift(0.0, 0.265, 0.138),
        );
    }
    shape
}
