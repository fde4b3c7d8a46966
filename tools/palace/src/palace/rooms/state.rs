//! The rooms of state: vestibule, guard room, rotunda, antechamber.

use super::*;

/// A beam from wall to wall over a row of columns, with a cornice on its free side: x from the wall to the front.
pub(super) fn entablature(
    room: &mut Room,
    side: f32,
    front: f32,
    z: [f32; 2],
    foot: f32,
    stone: MaterialId,
    gilt: MaterialId,
) {
    let top = room.design.height;
    let wall = 6.55 * side;
    let [left, right] = [wall.min(front * side), wall.max(front * side)];
    let mut shape = block(stone, [left, foot, z[0]], [right, top, z[1]]);
    // Paths keep the room on their right.
    let path = if side > 0.0 {
        [vec2(front, z[0]), vec2(front, z[1])]
    } else {
        [vec2(-front, z[1]), vec2(-front, z[0])]
    };
    const LEDGE: [[f32; 2]; 9] = [
        [0.0, 0.0],
        [0.05, 0.02],
        [0.05, 0.1],
        [0.12, 0.16],
        [0.22, 0.2],
        [0.22, 0.28],
        [0.28, 0.33],
        [0.30, 0.38],
        [0.0, 0.40],
    ];
    shape.join(moulding(stone, &path, false, top - 0.40, &LEDGE));
    let line = [[0.0, 0.0], [0.04, 0.0], [0.04, 0.05], [0.0, 0.06]];
    shape.join(moulding(gilt, &path, false, foot + 0.14, &line));
    room.make("entablature", &shape);
}

pub(super) fn vestibule(room: &mut Room) {
    let shaft = column::column(room.shop, 4.7 - PAVING, RED_MARBLE, WHITE_MARBLE);
    let urn = ornament::urn(room.shop, GREEN_MARBLE, OLD_GOLD);
    let stand = column::pedestal(room.shop, 0.5, 1.0, STONE, GREEN_MARBLE);
    let hairs = [Hair::Curls, Hair::Beard, Hair::Wig];
    for side in [-1.0, 1.0] {
        for row in 0..5 {
            let z = -1.35 - 2.325 * row as f32;
            room.put("column", &shaft, spot(5.4 * side, z, 0.0));
            if row < 4 {
                let between = z - 1.16;
                room.put("pedestal", &stand, spot(6.05 * side, between, -90.0 * side));
                let on_top = spot(6.05 * side, between, -90.0 * side) * shift(0.0, 1.0, 0.0);
                if row % 2 == 0 {
                    let bust = statue::bust(
                        room.shop,
                        hairs[(row + usize::from(side > 0.0)) % 3],
                        WHITE_MARBLE,
                        BLACK_MARBLE,
                    );
                    room.put("bust", &bust, on_top);
                } else {
                    room.put("urn", &urn, on_top);
                }
            }
        }
        entablature(room, side, 4.95, [-11.55, -0.45], 4.7, PALE_STONE, OLD_GOLD);
    }
    ceiling::coffer_vault(
        room,
        3,
        Coffering {
            rib: PLASTER,
            step: OLD_GOLD,
            rosette: GOLD,
        },
    );
    let torch = statue::figure(room.shop, Pose::Torch, BRONZE, GOLD);
    let bowl = statue::figure(room.shop, Pose::Bowl, BRONZE, GOLD);
    let base = column::pedestal(room.shop, 0.8, 0.9, RED_MARBLE, BLACK_MARBLE);
    for (x, statue) in [(-2.9, &torch), (2.9, &bowl)] {
        room.put("pedestal", &base, spot(x, -11.0, 0.0));
        room.put(
            "statue",
            statue,
            spot(x, -11.0, 0.0) * shift(0.0, 0.9, 0.0) * scaled(1.05),
        );
    }
    for side in [Side::North, Side::South] {
        ceiling::lunette(room, side, 0.3, NIGHT_BLUE, GOLD);
    }
    light::chandelier(room, [0.0, -8.4], 4.9, 12, 1.6, OLD_GOLD);
    windows::glaze(room, LEADED_GLASS, GREEN_CURTAIN);
    let runner = drapery::carpet(room.shop, [2.6, 10.0], Rug::Red);
    room.put("carpet", &runner, spot(0.0, -6.0, 0.0));
}

pub(super) fn guard_room(room: &mut Room) {
    ceiling::beams(room, OAK, WALNUT, 1.8);
    windows::glaze(room, LEADED_GLASS, RED_CURTAIN);
    hearth::hearth(room, Side::West, 4.05, DARK_STONE, IRON);
    painting(room, Side::West, 4.05, hearth::MANTEL + 0.5, [1.9, 1.5]);
    let table = table::long_table(room.shop, 3.4, OAK, GREEN_VELVET);
    room.put("long table", &table, spot(3.7, -16.5, 90.0));
    let chair = seat::chair(room.shop, WALNUT, DARK_RED);
    for i in 0..4 {
        let z = -15.2 - 0.85 * i as f32;
        room.put("chair", &chair, spot(2.8, z, 90.0));
        room.put("chair", &chair, spot(4.6, z, -90.0));
    }
    for z in [-15.6, -17.4] {
        light::candelabrum(room, spot(3.7, z, 0.0) * shift(0.0, 0.77, 0.0), 0.55, IRON);
    }
    let shield = shield(room, DARK_RED);
    let blue_shield = self::shield(room, NIGHT_BLUE);
    let spear = room.shop.piece("spear".to_owned(), || {
        let mut shape = lathe(WALNUT, &[[0.0, 0.0], [0.018, 0.0], [0.018, 2.2], [0.0, 2.2]], 8);
        shape.join(lathe(
            SILVER,
            &[[0.0, 2.14], [0.03, 2.2], [0.055, 2.32], [0.0, 2.6]],
            4,
        ));
        shape
    });
    for (side, along) in [
        (Side::North, 2.4),
        (Side::North, 10.7),
        (Side::South, 2.4),
        (Side::South, 10.7),
        (Side::East, 1.4),
        (Side::East, 6.7),
    ] {
        let place = room.wall(side).at(along, 2.9);
        let arms = if along < 5.0 { &shield } else { &blue_shield };
        room.put("shield", arms, place * shift(0.0, 0.0, 0.06));
        for lean in [-0.7, 0.7] {
            let turn = Transform::rotation([0.0, 0.0, 1.0], lean);
            room.put(
                "spear",
                &spear,
                place * shift(0.0, 0.0, 0.04) * turn * shift(0.0, -1.3, 0.0),
            );
        }
    }
    let rack: Vec<f32> = (0..7).map(|i| -13.4 - 0.22 * i as f32).collect();
    for z in rack {
        let lean = Transform::rotation([0.0, 0.0, 1.0], -0.1);
        room.put("spear", &spear, spot(6.1, z, 0.0) * lean);
    }
    let chest = case::chest(room.shop, OAK, IRON);
    for (x, z) in [(-4.9, -12.95), (-3.4, -12.95), (3.2, -12.95)] {
        room.put("chest", &chest, spot(x, z, 180.0));
    }
    room.put("chest", &chest, spot(-3.6, -20.05, 0.0));
    for (side, along) in [
        (Side::North, 4.5),
        (Side::North, 8.6),
        (Side::South, 4.5),
        (Side::South, 8.6),
    ] {
        let place = room.wall(side).at(along, 2.3);
        light::sconce(room, place, IRON);
    }
    light::chandelier(room, [0.0, -16.5], 4.0, 8, 1.3, IRON);
}

/// A round shield with a boss.
fn shield(room: &mut Room, color: MaterialId) -> Arc<Mesh> {
    room.shop.piece(format!("shield {}", color.0), || {
        let mut shape = lathe(color, &[[0.56, 0.0], [0.5, 0.06], [0.3, 0.12], [0.16, 0.14]], 32);
        shape.join(lathe(
            OLD_GOLD,
            &[[0.56, -0.02], [0.62, 0.0], [0.6, 0.03], [0.54, 0.03]],
            32,
        ));
        shape.join(lathe(
            OLD_GOLD,
            &[[0.16, 0.13], [0.14, 0.2], [0.06, 0.25], [0.0, 0.3]],
            20,
        ));
        let facing = Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2);
        let mut upright = Shape::new();
        upright.add(&shape, facing);
        upright
    })
}

pub(super) fn rotunda(room: &mut Room) {
    let height = room.design.height - 0.64;
    let shaft = column::column(room.shop, height - PAVING, GREEN_MARBLE, WHITE_MARBLE);
    let walls = room.walls();
    let half = walls[0].length() * 0.5;
    for (number, wall) in walls.iter().enumerate() {
        let out = (wall.left - room.design.plan.center()).normalize();
        let at = wall.left - out * 0.75;
        room.put(
            "column",
            &shaft,
            spot(at.x, at.y, (out.x.atan2(out.y)).to_degrees()),
        );
        room.take(number, 0.0, 2.0 * half);
    }
    let hairs = [Hair::Curls, Hair::Wig, Hair::Beard, Hair::Knot];
    for (i, wall) in [1, 2, 4, 5, 7, 8, 10, 11].into_iter().enumerate() {
        let place = niche(room, wall, half, 0.7, [1.5, 2.7, 0.8], NIGHT_BLUE);
        if i % 2 == 0 {
            let statue = statue::figure(room.shop, Pose::ALL[i / 2], WHITE_MARBLE, GOLD);
            room.put("statue", &statue, place * shift(0.0, 0.0, 0.09) * scaled(1.2));
            let from = place.point([0.0, 4.6, 3.4]);
            room.lamps
                .push(Lamp::spot(from, place.point([0.0, 1.2, 0.0]), 14.0));
        } else {
            let base = column::pedestal(room.shop, 0.6, 1.2, RED_MARBLE, WHITE_MARBLE);
            room.put("pedestal", &base, place);
            let bust = statue::bust(room.shop, hairs[i / 2], WHITE_MARBLE, GOLD);
            room.put("bust", &bust, place * shift(0.0, 1.2, 0.0) * scaled(1.3));
        }
    }
    ceiling::coffer_dome(
        room,
        Coffering {
            rib: IVORY,
            step: GOLD,
            rosette: GOLD,
        },
    );
    // The columns carry the ring under the dome.
    let corners = inwards(&room.design.plan.corners(), 1.0);
    let outer = room.design.plan.corners();
    let [foot, top] = [height, room.design.height];
    let mut ring = Shape::new();
    for i in 0..12 {
        let next = (i + 1) % 12;
        let at = |corner: Vec2, up: f32| vec3(corner.x, up, corner.y);
        let [a, b] = [corners[i], corners[next]];
        ring.face(PALE_STONE, &[at(a, foot), at(b, foot), at(b, top), at(a, top)]);
        ring.face(
            PALE_STONE,
            &[
                at(a, foot),
                at(outer[i], foot),
                at(outer[next], foot),
                at(b, foot),
            ],
        );
        ring.face(
            PALE_STONE,
            &[at(a, top), at(b, top), at(outer[next], top), at(outer[i], top)],
        );
    }
    const LEDGE: [[f32; 2]; 7] = [
        [0.0, 0.0],
        [0.06, 0.04],
        [0.06, 0.12],
        [0.16, 0.2],
        [0.24, 0.24],
        [0.24, 0.34],
        [0.0, 0.36],
    ];
    ring.join(moulding(PALE_STONE, &corners, true, top - 0.36, &LEDGE));
    ring.join(moulding(
        GOLD,
        &corners,
        true,
        foot + 0.08,
        &[[0.0, 0.0], [0.05, 0.0], [0.05, 0.06], [0.0, 0.07]],
    ));
    room.make("entablature", &ring);
    light::chandelier(room, [0.0, -47.0], 5.4, 16, 2.2, GOLD);
    let sofa = seat::stool(room.shop, GOLD, GREEN_VELVET);
    for turn in 0..4 {
        let angle = f64::from(turn) * FRAC_PI_2 + FRAC_PI_2 / 2.0;
        let (sin, cos) = angle.sin_cos();
        let place = spot(
            4.6 * cos as f32,
            -47.0 - 4.6 * sin as f32,
            angle.to_degrees() as f32 - 90.0,
        );
        room.put("stool", &sofa, place);
    }
}

pub(super) fn antechamber(room: &mut Room) {
    windows::glaze(room, PANE, RED_CURTAIN);
    ceiling::coffer_flat(
        room,
        1.7,
        Coffering {
            rib: IVORY,
            step: GOLD,
            rosette: GOLD,
        },
    );
    mirror(room, Side::East, 3.55, 1.16, [1.7, 2.2], 0.5);
    painting(room, Side::West, 3.55, 1.7, [2.2, 1.7]);
    let wall = room.design.plan.wall(Side::West);
    room.take(wall, 3.55 - 1.4, 3.55 + 1.4);
    let console = table::console(room.shop, 1.9, RED_MARBLE, GOLD);
    let chair = seat::armchair(room.shop, GOLD, YELLOW_SILK);
    let clay = [TERRACOTTA, COBALT];
    for (side, turn) in [(-1.0, 90.0), (1.0, -90.0)] {
        room.put("console", &console, spot(6.52 * side, -107.0, turn));
        for (i, off) in [-0.6, 0.6].into_iter().enumerate() {
            let on_top = spot(6.25 * side, -107.0 + off, turn) * shift(0.0, 0.93, 0.0);
            if side > 0.0 {
                light::candelabrum(room, on_top, 0.6, GOLD);
            } else {
                let vase = ornament::vase(room.shop, 1, clay[i], GOLD);
                room.put("vase", &vase, on_top);
            }
        }
        for z in [-104.6, -105.5, -108.5, -109.4] {
            room.put("armchair", &chair, spot(5.9 * side, z, turn));
        }
    }
    let clock = case::long_clock(room.shop, WALNUT, GOLD);
    room.put("clock", &clock, spot(-4.0, -110.52, 0.0));
    let obelisk = ornament::obelisk(room.shop, GREEN_MARBLE, GOLD);
    let base = column::pedestal(room.shop, 0.6, 0.7, WHITE_MARBLE, RED_MARBLE);
    for (x, z) in [(3.9, -110.0), (3.9, -104.0), (-3.9, -104.0)] {
        room.put("pedestal", &base, spot(x, z, 0.0));
        room.put("obelisk", &obelisk, spot(x, z, 0.0) * shift(0.0, 0.7, 0.0));
    }
    light::chandelier(room, [0.0, -107.0], 3.9, 10, 1.4, GOLD);
    let carpet = drapery::carpet(room.shop, [4.4, 5.0], Rug::Yellow);
    room.put("carpet", &carpet, spot(0.0, -107.0, 0.0));
}
