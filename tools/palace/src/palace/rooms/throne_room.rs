//! The throne room, where the enfilade ends: columns, an apse under stars, the throne on its steps.

use super::state::entablature;
use super::*;

pub(super) fn throne_room(room: &mut Room) {
    let shaft = column::column(room.shop, 5.7 - PAVING, RED_MARBLE, GOLD);
    for side in [-1.0, 1.0] {
        for row in 0..4 {
            let z = -112.9 - 2.75 * row as f32;
            room.put("column", &shaft, spot(5.4 * side, z, 0.0));
            if row < 3 {
                light::candelabrum(room, spot(5.7 * side, z - 1.37, 45.0), 1.9, GOLD);
            }
        }
        entablature(room, side, 4.9, [-122.0, -111.45], 5.7, WHITE_MARBLE, GOLD);
    }
    ceiling::coffer_vault(
        room,
        3,
        Coffering {
            rib: IVORY,
            step: GOLD,
            rosette: GOLD,
        },
    );
    windows::glaze(room, PANE, RED_CURTAIN);
    dais(room);
    let flat = column::pilaster(room.shop, 5.7, WHITE_MARBLE, GOLD);
    let walls = room.walls();
    let bay = room.design.plan.wall(Side::North);
    for i in (1..11).step_by(3) {
        let wall = walls[bay + i];
        room.put("pilaster", &flat, wall.at(0.5 * wall.length(), 0.0));
        room.take(bay + i, 0.0, wall.length());
    }
    for i in [0, 2, 3, 5, 6, 8, 9, 11] {
        room.take(bay + i, 0.0, walls[bay + i].length());
    }
    let sun = room.shop.piece("sun".to_owned(), || {
        let mut shape = Shape::new();
        shape.add(
            &seat::sunburst(GOLD, 1.5),
            Transform::rotation([1.0, 0.0, 0.0], FRAC_PI_2),
        );
        shape
    });
    ceiling::lunette(room, Side::South, 0.2, NIGHT_BLUE, GOLD);
    ceiling::stars(room, 180, GOLD);
    room.put(
        "sun",
        &sun,
        shift(0.0, 8.4, -126.6) * Transform::rotation([1.0, 0.0, 0.0], 0.5),
    );
    light::chandelier(room, [0.0, -116.8], 5.6, 16, 2.1, GOLD);
    let runner = drapery::carpet(room.shop, [2.6, 9.6], Rug::Red);
    room.put("carpet", &runner, spot(0.0, -116.6, 0.0));
    let banner = banner(room);
    for side in [-1.0, 1.0] {
        for row in 0..3 {
            let z = -114.3 - 2.75 * row as f32;
            room.put("banner", &banner, shift(4.6 * side, 5.62, z));
        }
    }
}

/// A cloth that hangs from a beam, pointed below.
fn banner(room: &mut Room) -> Arc<Mesh> {
    room.shop.piece("banner".to_owned(), || {
        let edge = |x: f32| -> Vec<Vec3> {
            let long = 2.0 - 0.5 * x.abs() / 0.45;
            (0..=10)
                .rev()
                .map(|i| i as f32 / 10.0)
                .map(|t| vec3(x, -long * t, 0.05 * (5.0 * t + 4.0 * x).sin()))
                .collect()
        };
        let xs = [-0.45, -0.36, -0.18, 0.0, 0.18, 0.36, 0.45];
        let colors = [
            YELLOW_VELVET,
            BLUE_VELVET,
            BLUE_VELVET,
            BLUE_VELVET,
            BLUE_VELVET,
            YELLOW_VELVET,
        ];
        let mut shape = Shape::new();
        for (pair, color) in xs.windows(2).zip(colors) {
            shape.join(band(color, &edge(pair[0]), &edge(pair[1])));
        }
        let bar = lathe(
            GOLD,
            &[
                [0.0, 0.0],
                [0.04, 0.02],
                [0.02, 0.06],
                [0.02, 1.06],
                [0.04, 1.1],
                [0.0, 1.12],
            ],
            10,
        );
        shape.add(
            &bar,
            shift(-0.56, 0.02, 0.0) * Transform::rotation([0.0, 0.0, 1.0], -FRAC_PI_2),
        );
        shape
    })
}

/// Round steps, the throne on them, a canopy over it.
fn dais(room: &mut Room) {
    const SIDES: usize = 24;
    for step in 0..3 {
        let reach = 4.6 - 0.6 * step as f32;
        let [low, high] = [PAVING, 0.18].map(|up| up + 0.18 * step as f32);
        let outline: Vec<Vec3> = (0..=SIDES)
            .map(|i| {
                let (sin, cos) = (PI * i as f64 / SIDES as f64).sin_cos();
                vec3(-reach * cos as f32, low, -124.0 + reach * 0.8 * sin as f32)
            })
            .chain([vec3(reach, low, -126.4), vec3(-reach, low, -126.4)])
            .collect();
        let material = if step == 2 { RED_SILK } else { WHITE_MARBLE };
        room.make("step", &prism(material, &outline, vec3(0.0, high - low, 0.0)));
    }
    let throne = seat::throne(room.shop, GOLD, RED_VELVET);
    let top = shift(0.0, 0.54, -124.6);
    room.put("throne", &throne, top * scaled(1.15));
    for side in [-1.0, 1.0] {
        let post = column::plain_column(room.shop, 3.6, GOLD, OLD_GOLD);
        room.put("canopy post", &post, top * shift(1.5 * side, 0.0, -1.0));
        room.put("canopy post", &post, top * shift(1.5 * side, 0.0, 0.9));
        let fall = drapery::curtain(room.shop, 1.3, 3.6, RED_CURTAIN, GOLD);
        let place = top * shift(1.5 * side, 0.0, -1.26) * Transform::scaling([-side, 1.0, 1.0]);
        room.put("curtain", &fall, place);
        light::candelabrum(room, top * shift(2.5 * side, 0.0, 0.6), 1.7, GOLD);
    }
    let canopy = room.shop.piece("canopy".to_owned(), || {
        let mut shape = block(DARK_RED, [-1.8, 0.0, -1.3], [1.8, 0.1, 1.2]);
        shape.join(block(GOLD, [-1.86, 0.1, -1.36], [1.86, 0.28, 1.2]));
        let crown = [
            [0.0, 0.0],
            [1.5, 0.0],
            [1.4, 0.15],
            [0.7, 0.35],
            [0.25, 0.8],
            [0.1, 1.1],
            [0.2, 1.2],
            [0.0, 1.4],
        ];
        let crown = fluted(GOLD, &crown, 12, 3, 0.12);
        shape.add(
            &crown,
            shift(0.0, 0.28, 0.0) * Transform::scaling([1.0, 0.8, 0.75]),
        );
        shape
    });
    room.put("canopy", &canopy, top * shift(0.0, 3.6, 0.0));
    let valance = drapery::swags(room.shop, 3.5, 4, 0.06, RED_CURTAIN, GOLD);
    room.put("valance", &valance, top * shift(-1.75, 3.65, 1.26));
}
