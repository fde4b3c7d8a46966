//! The court: an open garden beside the gallery.

use super::*;
use crate::palace::workshop::Workshop;

/// The middle of the court, at the fountain.
const MIDDLE: Vec2 = vec2(-28.0, -51.5);

pub(super) fn court(room: &mut Room) {
    gardens::under_the_sky(room);
    ground(room);
    facades(room);
    let fountain = garden::fountain(room.shop, PALE_STONE);
    room.put("fountain", &fountain, spot(MIDDLE.x, MIDDLE.y, 0.0));
    let mut trees = Vec::new();
    for (i, z) in [-30.5, -36.0, -41.5, -61.5, -67.0, -72.5].into_iter().enumerate() {
        trees.push((-38.0, z, i));
        trees.push((-18.6, z, i + 1));
    }
    for (x, z, i) in trees {
        let tree = garden::tree(room.shop, i as u64);
        let turn = room.random.between(0.0, 360.0);
        let size = room.random.between(1.05, 1.35);
        room.put("tree", &tree, spot(x, z, turn) * scaled(size));
    }
    let [cone, stack] = [false, true].map(|stacked| garden::topiary(room.shop, stacked));
    for a in [-1.0, 1.0] {
        for b in [-1.0, 1.0] {
            let at = |x: f32, z: f32| MIDDLE + vec2(a * x, b * z);
            for (x, z, tree) in [
                (2.4, 4.6, &stack),
                (7.6, 4.6, &cone),
                (2.4, 19.4, &cone),
                (7.6, 19.4, &stack),
                (5.0, 12.0, &stack),
            ] {
                let place = at(x, z);
                room.put("topiary", tree, spot(place.x, place.y, 0.0));
            }
            parterre(room, at(5.0, 12.0));
            let statue = statue::figure(
                room.shop,
                Pose::ALL[(2.0 + a + 0.5 * b) as usize % 5],
                WHITE_MARBLE,
                VERDIGRIS,
            );
            let base = column::pedestal(room.shop, 0.8, 1.1, PALE_STONE, STONE);
            let place = at(4.6, 3.4);
            let turn = if b > 0.0 { 180.0 } else { 0.0 } + 35.0 * a * b;
            room.put("pedestal", &base, spot(place.x, place.y, turn));
            room.put(
                "statue",
                &statue,
                spot(place.x, place.y, turn) * shift(0.0, 1.1, 0.0) * scaled(1.1),
            );
        }
    }
    let bench = garden::bench(room.shop, PALE_STONE);
    for (x, z, turn) in [(-28.0, -28.0, 180.0), (-28.0, -75.0, 0.0), (-33.5, -51.5, 90.0)] {
        room.put("bench", &bench, spot(x, z, turn));
    }
    let urn = ornament::urn(room.shop, TERRACOTTA, STONE);
    for z in [-54.0, -49.0] {
        room.put("urn", &urn, spot(-16.2, z, 0.0) * scaled(1.3));
    }
}

/// Gravel everywhere, lawns in the four quarters.
fn ground(room: &mut Room) {
    let mut shape = Shape::new();
    for a in [-1.0, 1.0] {
        for b in [-1.0, 1.0] {
            let [left, right] = [MIDDLE.x + a * 1.7, MIDDLE.x + a * 8.3];
            let [near, far] = [MIDDLE.y + b * 3.9, MIDDLE.y + b * 20.1];
            let [x0, x1, z0, z1] = [left.min(right), left.max(right), near.min(far), near.max(far)];
            shape.join(block(LAWN, [x0, 0.0, z0], [x1, 0.05, z1]));
        }
    }
    room.make("lawn", &shape);
}

/// Hedges round a bed of flowers.
fn parterre(room: &mut Room, at: Vec2) {
    let [long, short] = [
        garden::hedge(room.shop, 13.0, 0.55),
        garden::hedge(room.shop, 4.0, 0.55),
    ];
    for side in [-1.0, 1.0] {
        room.put("hedge", &long, spot(at.x + 2.2 * side, at.y, 90.0));
        room.put("hedge", &short, spot(at.x, at.y + 6.4 * side, 0.0));
    }
    let colors = [RED_SILK, YELLOW_SILK, ROSE, IVORY, PALE_BLUE];
    for row in 0..5 {
        let color = room.random.pick(&colors);
        let bed = flower_bed(room.shop, color);
        room.put("flowers", &bed, spot(at.x, at.y - 4.0 + 2.0 * row as f32, 0.0));
    }
}

/// A bed of small bright flowers on stalks, three metres by one and a half.
pub(crate) fn flower_bed(shop: &mut Workshop, color: MaterialId) -> Arc<Mesh> {
    shop.piece(format!("flowers {}", color.0), || flowers(color))
}

fn flowers(color: MaterialId) -> Shape {
    let mut random = enfilade_scenes::Random::new(u64::from(color.0));
    let mut shape = Shape::new();
    for _ in 0..70 {
        let at = vec3(random.between(-1.5, 1.5), 0.0, random.between(-0.7, 0.7));
        let high = random.between(0.25, 0.45);
        let lean = vec3(random.between(-0.06, 0.06), high, random.between(-0.06, 0.06));
        for (color, half) in [(PALE_LEAF, Vec3::X * 0.03), (LEAF, Vec3::Z * 0.03)] {
            // From the middle of a leaf to its tip.
            let places = [vec2(0.4, 0.7), vec2(0.4, 0.3), vec2(1.0, 0.5)];
            shape.placed(color, &[at - half, at + half, at + lean], &places);
        }
        let head = crate::shape::superquadric(color, [0.055, 0.035, 0.055], 1.2, 1.0, 4, 7);
        let top = at + lean;
        shape.add(&head, shift(top.x, top.y, top.z));
    }
    shape
}

/// Pilasters, blind windows and a balustrade on the walls round the court.
fn facades(room: &mut Room) {
    let height = room.design.height;
    let corners = room.design.plan.corners();
    let giant = column::pilaster(room.shop, 7.4, PALE_STONE, STONE);
    let [upper, lower] = [upper_window(room.shop), lower_window(room.shop)];
    for side in Side::ALL {
        let wall = room.wall(side);
        let bays = (wall.length() / 5.0).round();
        let step = wall.length() / bays;
        for bay in 0..bays as usize {
            // The eastern wall has the gallery's windows, five metres apart.
            let middle = if side == Side::East {
                wall.along(vec2(wall.left.x, -31.5 - 5.0 * bay as f32))
            } else {
                step * (bay as f32 + 0.5)
            };
            let beside_the_grotto = side == Side::West && (middle - 0.5 * wall.length()).abs() < 3.0;
            if middle < 1.5 || middle > wall.length() - 1.5 || beside_the_grotto {
                continue;
            }
            room.put("blind window", &upper, wall.at(middle, 5.5));
            if side != Side::East {
                room.put("blind door", &lower, wall.at(middle, 0.0));
            }
            for off in [-2.5, 2.5] {
                let at = middle + off;
                if (0.3..wall.length() - 0.3).contains(&at) && (off > 0.0 || bay == 0) {
                    room.put("pilaster", &giant, wall.at(at, 0.0));
                }
            }
        }
    }
    grotto_front(room, &giant, &upper);
    window_cases(room);
    cornice(room, &corners, 7.95, 0.55);
    balustrade(room, &corners, height - 1.0);
}

/// A dark window of the upper storey; its lower edge at the origin.
pub(crate) fn upper_window(shop: &mut Workshop) -> Arc<Mesh> {
    shop.piece("blind window".to_owned(), || {
        let mut shape = block(NIGHT_BLUE, [-0.55, 0.0, 0.0], [0.55, 1.5, 0.02]);
        let outline = arched(1.1, 0.0, 1.5, 0.0);
        shape.join(surround(
            PALE_STONE,
            &outline,
            true,
            &[[0.0, 0.0], [0.0, 0.06], [0.14, 0.08], [0.2, 0.05], [0.2, 0.0]],
        ));
        shape.join(block(IVORY, [-0.025, 0.0, 0.02], [0.025, 1.5, 0.04]));
        shape.join(block(IVORY, [-0.55, 0.72, 0.02], [0.55, 0.77, 0.04]));
        shape
    })
}

/// A dark arched window like those of the gallery.
pub(crate) fn lower_window(shop: &mut Workshop) -> Arc<Mesh> {
    shop.piece("blind door".to_owned(), || {
        let outline = arched(2.0, 0.9, 3.2, 1.0);
        let mut shape = Shape::new();
        let flat: Vec<Vec3> = outline.iter().map(|at| at.extend(0.02)).collect();
        shape.face(NIGHT_BLUE, &flat);
        shape.join(surround(
            PALE_STONE,
            &outline,
            true,
            &[[0.0, 0.0], [0.0, 0.06], [0.2, 0.09], [0.26, 0.05], [0.26, 0.0]],
        ));
        shape.join(block(IVORY, [-0.04, 0.9, 0.02], [0.04, 4.2, 0.05]));
        for up in [1.65, 2.4, 3.15] {
            shape.join(block(IVORY, [-0.97, up, 0.02], [0.97, up + 0.05, 0.045]));
        }
        shape
    })
}

/// Stone frames around the doors and windows of a garden.
pub(crate) fn window_cases(room: &mut Room) {
    for door in room.doorways.clone() {
        let case = room
            .shop
            .piece(format!("court case {} {}", door.sill, door.width), || {
                let outline = arched(door.width, door.sill, door.spring, door.rise);
                let path: Vec<Vec2> = outline[1..].iter().chain(&outline[..1]).copied().collect();
                surround(
                    PALE_STONE,
                    &path,
                    door.sill > 0.0,
                    &[[0.0, -0.01], [0.0, 0.06], [0.2, 0.09], [0.26, 0.05], [0.26, 0.0]],
                )
            });
        let place = room.walls()[door.wall].at(door.along, 0.0);
        room.put("window case", &case, place);
    }
}

/// Pilasters, windows and urns around the arch of the grotto, where two bays would meet.
fn grotto_front(room: &mut Room, pilaster: &Arc<Mesh>, window: &Arc<Mesh>) {
    let wall = room.wall(Side::West);
    let middle = 0.5 * wall.length();
    let urn = ornament::urn(room.shop, TERRACOTTA, STONE);
    let base = column::pedestal(room.shop, 0.7, 1.2, PALE_STONE, STONE);
    room.put("blind window", window, wall.at(middle, 5.5));
    for side in [-1.0, 1.0] {
        room.put("pilaster", pilaster, wall.at(middle + 2.2 * side, 0.0));
        room.put("blind window", window, wall.at(middle + 3.55 * side, 5.5));
        let place = wall.at(middle + 3.55 * side, PAVING) * shift(0.0, 0.0, 0.6);
        room.put("pedestal", &base, place);
        room.put("urn", &urn, place * shift(0.0, 1.2, 0.0) * scaled(1.4));
    }
}

/// Posts and a rail along the top of the walls.
fn balustrade(room: &mut Room, corners: &[Vec2], foot: f32) {
    const RAIL: [[f32; 2]; 5] = [[0.0, 0.0], [0.3, 0.0], [0.34, 0.06], [0.30, 0.16], [0.0, 0.16]];
    let mut shape = moulding(PALE_STONE, corners, true, foot + 0.78, &RAIL);
    shape.join(moulding(
        PALE_STONE,
        corners,
        true,
        foot,
        &[[0.0, 0.0], [0.3, 0.0], [0.3, 0.08], [0.0, 0.08]],
    ));
    room.make("balustrade", &shape);
    let post = garden::baluster(room.shop, IVORY);
    for wall in room.walls() {
        let count = (wall.length() / 0.42) as usize;
        for i in 0..count {
            let along = wall.length() * (i as f32 + 0.5) / count as f32;
            room.put(
                "baluster",
                &post,
                wall.at(along, foot + 0.08) * shift(0.0, 0.0, 0.15),
            );
        }
    }
}
