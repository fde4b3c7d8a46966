//! The rooms of the arts: music room, library, picture room.

use super::*;

pub(super) fn music_room(room: &mut Room) {
    ceiling::coffer_flat(
        room,
        2.1,
        Coffering {
            rib: IVORY,
            step: ROSE,
            rosette: GOLD,
        },
    );
    organ(room);
    let harpsichord = table::harpsichord(room.shop, GREEN_SILK, GOLD, [IVORY, EBONY]);
    room.put("harpsichord", &harpsichord, spot(3.6, -76.2, -60.0));
    let stool = seat::stool(room.shop, GOLD, ROSE);
    room.put("stool", &stool, spot(2.6, -75.6, 120.0));
    let chair = seat::chair(room.shop, GOLD, DARK_RED);
    for row in 0..3 {
        for seat in 0..4 {
            let z = -74.6 - 1.25 * seat as f32 - 0.2 * row as f32;
            room.put("chair", &chair, spot(-2.0 - 1.15 * row as f32, z, 90.0));
        }
    }
    let stand = room.shop.piece("music stand".to_owned(), music_stand);
    for (x, z, turn) in [(2.3, -78.4, -100.0), (2.8, -79.6, -80.0), (3.9, -80.2, -50.0)] {
        room.put("music stand", &stand, spot(x, z, turn));
        room.put("chair", &chair, spot(x + 0.75, z - 0.1, -90.0));
    }
    for (side, along) in [
        (Side::North, 2.5),
        (Side::North, 10.6),
        (Side::South, 2.5),
        (Side::South, 10.6),
    ] {
        painting(room, side, along, 1.9, [2.0, 1.6]);
    }
    for (side, along) in [(Side::West, 1.9), (Side::West, 7.2)] {
        let place = room.wall(side).at(along, 2.5);
        light::sconce(room, place, GOLD);
    }
    let carpet = drapery::carpet(room.shop, [4.6, 6.4], Rug::Rose);
    room.put("carpet", &carpet, spot(3.9, -77.0, 0.0));
    light::chandelier(room, [-3.4, -77.0], 3.9, 12, 1.5, GOLD);
    light::chandelier(room, [3.4, -77.0], 3.9, 12, 1.5, GOLD);
}

/// An organ on the eastern wall: a case, towers of pipes, a keyboard.
fn organ(room: &mut Room) {
    let middle = 0.5 * room.wall(Side::East).length();
    let wall = room.design.plan.wall(Side::East);
    room.take(wall, middle - 2.2, middle + 2.2);
    let case = room.shop.piece("organ case".to_owned(), || {
        let mut shape = block(WALNUT, [-2.1, 0.0, 0.0], [2.1, 1.5, 0.5]);
        for side in [-1.0, 1.0] {
            shape.join(block(
                WALNUT,
                [side * 2.0 - 0.1, 1.5, 0.0],
                [side * 2.0 + 0.1, 4.4, 0.46],
            ));
            shape.join(block(
                WALNUT,
                [side * 0.72 - 0.07, 1.5, 0.0],
                [side * 0.72 + 0.07, 4.9, 0.46],
            ));
            shape.join(block(
                GOLD,
                [side * 1.38 - 0.5, 0.3, 0.5],
                [side * 1.38 + 0.5, 1.2, 0.52],
            ));
            shape.join(block(
                ROSE,
                [side * 1.38 - 0.44, 0.36, 0.5],
                [side * 1.38 + 0.44, 1.14, 0.53],
            ));
            shape.join(block(
                GOLD,
                [side.min(side * 2.2), 4.4, 0.0],
                [side.max(side * 2.2), 4.56, 0.55],
            ));
        }
        shape.join(block(GOLD, [-0.9, 4.9, 0.0], [0.9, 5.1, 0.6]));
        shape.join(block(WALNUT, [-0.6, 0.72, 0.5], [0.6, 0.86, 0.8]));
        shape.join(block(IVORY, [-0.5, 0.86, 0.56], [0.5, 0.88, 0.78]));
        shape
    });
    room.hang("organ case", &case, Side::East, middle, 0.0);
    for i in 0..25_i32 {
        let off = i - 12;
        let tower = (off.abs() % 9) as f32;
        let long = if off.abs() <= 4 {
            3.2 - 0.22 * off.abs() as f32
        } else {
            1.7 + 0.16 * tower
        };
        let pipe = room.shop.piece(format!("organ pipe {}", off.abs()), || {
            let radius = 0.028 + 0.012 * long;
            let mut shape = lathe(
                SILVER,
                &[[0.01, 0.0], [radius, 0.25], [radius, long], [0.8 * radius, long]],
                16,
            );
            shape.join(block(
                EBONY,
                [-0.6 * radius, 0.3, 0.8 * radius],
                [0.6 * radius, 0.3 + radius, 1.05 * radius],
            ));
            shape
        });
        let place = room.wall(Side::East).at(middle + 0.153 * off as f32, 1.5) * shift(0.0, 0.0, 0.3);
        room.put("organ pipe", &pipe, place);
    }
    let bench = seat::stool(room.shop, WALNUT, ROSE);
    let place = room.wall(Side::East).at(middle, PAVING) * shift(0.0, 0.0, 1.2) * scaled(1.1);
    room.put("organ bench", &bench, place);
}

fn music_stand() -> Shape {
    let mut shape = lathe(
        GOLD,
        &[
            [0.0, 0.0],
            [0.2, 0.0],
            [0.18, 0.03],
            [0.03, 0.06],
            [0.02, 1.0],
            [0.0, 1.0],
        ],
        12,
    );
    let lean = Transform::rotation([1.0, 0.0, 0.0], -0.45);
    shape.add(&cuboid(GOLD, [0.46, 0.32, 0.02]), shift(0.0, 1.0, 0.0) * lean);
    shape.add(&cuboid(PAPER, [0.38, 0.26, 0.004]), shift(0.0, 1.04, 0.02) * lean);
    shape
}

pub(super) fn library(room: &mut Room) {
    for side in [Side::North, Side::South] {
        ceiling::lunette(room, side, 0.1, NIGHT_BLUE, OLD_GOLD);
    }
    ceiling::ribs(room, OAK, 0.3, 0.18, &[0.35, 2.85, 5.05, 7.25, 9.75]);
    ceiling::coffer_vault(
        room,
        4,
        Coffering {
            rib: OAK,
            step: OLD_GOLD,
            rosette: OLD_GOLD,
        },
    );
    let mut number = 0;
    let mut shelve = |room: &mut Room, side: Side, along: f32| {
        let shelf = case::bookcase(room.shop, number, 1.56, 3.9, WALNUT, OLD_GOLD);
        number += 1;
        room.hang("bookcase", &shelf, side, along, PAVING);
        let wall = room.design.plan.wall(side);
        room.take(wall, along - 0.9, along + 0.9);
    };
    for along in [0.95, 2.6, 4.25, 5.9, 7.55, 9.15] {
        shelve(room, Side::West, along);
    }
    for along in [0.95, 2.6, 7.55, 9.15] {
        shelve(room, Side::East, along);
    }
    for side in [Side::North, Side::South] {
        for along in [1.3, 3.1, 10.0, 11.8] {
            shelve(room, side, along);
        }
    }
    let hairs = [Hair::Beard, Hair::Curls, Hair::Wig];
    for (i, z) in [-83.4, -85.05, -86.7, -88.35, -90.0, -91.6]
        .into_iter()
        .enumerate()
    {
        let bust = statue::bust(room.shop, hairs[i % 3], PORCELAIN, BLACK_MARBLE);
        room.put("bust", &bust, spot(-6.3, z, 90.0) * shift(0.0, 3.9, 0.0));
    }
    let desk = table::long_table(room.shop, 3.6, MAHOGANY, GREEN_SILK);
    let chair = seat::chair(room.shop, MAHOGANY, GREEN_VELVET);
    for x in [-3.6, 3.6] {
        room.put("long table", &desk, spot(x, -87.5, 90.0));
        for i in 0..3 {
            let z = -86.3 - 1.2 * i as f32;
            room.put("chair", &chair, spot(x - 0.95, z, 90.0));
            room.put("chair", &chair, spot(x + 0.95, z, -90.0));
        }
        light::candelabrum(room, spot(x, -87.5, 0.0) * shift(0.0, 0.79, 0.0), 0.5, OLD_GOLD);
        let book = room.shop.piece("open book".to_owned(), open_book);
        for (z, turn) in [(-86.4, 80.0), (-88.5, -95.0)] {
            room.put("book", &book, spot(x, z, turn) * shift(0.0, 0.79, 0.0));
        }
    }
    let earth = ornament::globe(room.shop, MAHOGANY, VERDIGRIS, OLD_GOLD);
    let sky = ornament::globe(room.shop, MAHOGANY, NIGHT_BLUE, OLD_GOLD);
    for (x, z, globe) in [
        (-2.2, -83.6, &earth),
        (2.2, -83.6, &sky),
        (-2.2, -91.4, &sky),
        (2.2, -91.4, &earth),
    ] {
        room.put("globe", globe, spot(x, z, 20.0));
    }
    let ladder = room.shop.piece("ladder".to_owned(), || {
        let mut shape = Shape::new();
        for x in [-0.24, 0.24] {
            shape.join(block(OAK, [x - 0.025, 0.0, -0.03], [x + 0.025, 3.4, 0.03]));
        }
        for rung in 0..11 {
            let up = 0.25 + 0.29 * rung as f32;
            shape.join(block(OAK, [-0.22, up, -0.02], [0.22, up + 0.035, 0.02]));
        }
        shape
    });
    let lean = Transform::rotation([1.0, 0.0, 0.0], -0.22);
    room.put("ladder", &ladder, spot(-5.3, -89.2, 90.0) * lean);
    room.put("ladder", &ladder, spot(5.3, -84.3, -90.0) * lean);
    let carpet = drapery::carpet(room.shop, [3.2, 5.4], Rug::Red);
    room.put("carpet", &carpet, spot(-3.6, -87.5, 0.0));
    room.put("carpet", &carpet, spot(3.6, -87.5, 0.0));
    light::chandelier(room, [0.0, -87.5], 4.3, 12, 1.5, OLD_GOLD);
}

fn open_book() -> Shape {
    let mut shape = block(DARK_RED, [-0.2, 0.0, -0.14], [0.2, 0.01, 0.14]);
    for side in [-1.0, 1.0_f32] {
        let [left, right] = [0.0_f32.min(side * 0.19), 0.0_f32.max(side * 0.19)];
        shape.join(block(PAPER, [left, 0.01, -0.13], [right, 0.03, 0.13]));
    }
    shape
}

pub(super) fn picture_room(room: &mut Room) {
    const FREE: f32 = 2.3;
    let rows = [(1.35, 1.5), (3.15, 1.3), (4.75, 1.0)];
    for side in Side::ALL {
        let length = room.wall(side).length();
        let middle = 0.5 * length;
        let wall = room.design.plan.wall(side);
        // Doors in the north and the south, the living picture in the east.
        let free = side != Side::West;
        for (row, (foot, high)) in rows.into_iter().enumerate() {
            let mut along = 0.45;
            while along < length - 0.8 {
                let wide = high * room.random.pick(&[0.8, 1.0, 1.3, 1.5]);
                let [from, to] = [along, along + wide];
                let in_the_way = free && row < 2 && to > middle - FREE && from < middle + FREE;
                if in_the_way {
                    along = middle + FREE;
                    continue;
                }
                if to > length - 0.4 {
                    break;
                }
                painting(room, side, 0.5 * (from + to), foot, [wide, high]);
                along = to + 0.42;
            }
        }
        room.take(wall, 0.0, length);
        // Light on the pictures, from where the ceiling begins.
        let wall = room.wall(side);
        let from = wall.at(middle, 6.6).point([0.0, 0.0, 3.4]);
        room.lamps
            .push(Lamp::spot(from, wall.at(middle, 2.6).point([0.0; 3]), 16.0));
    }
    let sofa = seat::sofa(room.shop, GOLD, RED_VELVET);
    for x in [-3.6, 3.6] {
        room.put("sofa", &sofa, spot(x, -97.6, 180.0));
        room.put("sofa", &sofa, spot(x, -98.4, 0.0));
        let carpet = drapery::carpet(room.shop, [4.6, 5.6], Rug::Red);
        room.put("carpet", &carpet, spot(x, -98.0, 0.0));
    }
    let base = column::pedestal(room.shop, 0.55, 0.95, EBONY, OLD_GOLD);
    for (i, (x, z)) in [(-1.9, -94.2), (1.9, -94.2), (-1.9, -101.8), (1.9, -101.8)]
        .into_iter()
        .enumerate()
    {
        room.put("pedestal", &base, spot(x, z, 0.0));
        let knot = ornament::knot_sculpture(room.shop, 3 + 2 * (i as u32 % 2), BRONZE, BLACK_MARBLE);
        room.put(
            "knot",
            &knot,
            spot(x, z, 45.0 * i as f32) * shift(0.0, 0.95, 0.0) * scaled(0.9),
        );
    }
    ceiling::coffer_flat(
        room,
        1.5,
        Coffering {
            rib: IVORY,
            step: OLD_GOLD,
            rosette: OLD_GOLD,
        },
    );
    light::chandelier(room, [0.0, -98.0], 5.0, 12, 1.6, OLD_GOLD);
}
