//! The grotto west of the court with its fountain.

use super::doors::DOORS;
use super::floor::{Floor, paving};
use super::lamps::Lamp;
use super::palette::*;
use super::plan::Name;
use super::room::{Design, FinishedRoom, Room, Style, arched, scaled, shift, spot};
use super::statue::{self, Pose};
use super::trim::cornice;
use super::workshop::Workshop;
use super::{ceiling, light, open, ornament};
use crate::envelope::{Axis, Ceiling, Plan, Side};
use crate::shape::{lathe, superquadric, surround};
use crate::water::{JETS, MIDDLE, rim};
use enfilade::{Geometry, Transform};
use enfilade_scenes::Random;
use glam::{Vec3, vec3};
use std::f64::consts::TAU;
use std::sync::LazyLock;

pub(crate) const GROTTO: Design = Design {
    name: "Fountain",
    plan: Plan::Apse([-46.0, -41.9], [-54.9, -48.1], Side::West),
    // The cornice must pass above the arch to the court.
    height: 4.6,
    ceiling: Ceiling::Vault(Axis::WestEast, 3.4),
    style: Style {
        floor: Floor::Octagons(0.7, [PALE_STONE, STONE, COBALT]),
        trim: PALE_STONE,
        gilt: OLD_GOLD,
        dado: STONE,
        wall: PALE_GREEN,
        field: VERDIGRIS,
        ceiling: NIGHT_BLUE,
        reveal: STONE,
    },
};

/// Builds the geometry of the grotto with its water.
pub(super) fn fountain() -> Geometry {
    let still = &still().geometry;
    crate::water::fountain(still, 0.0)
}

/// Returns the lamps of the grotto.
pub(super) fn lamps() -> Vec<Lamp> {
    still().lamps.clone()
}

/// Everything except the water, built once, because only the water changes.
fn still() -> &'static FinishedRoom {
    static STILL: LazyLock<FinishedRoom> = LazyLock::new(grotto);
    &STILL
}

fn grotto() -> FinishedRoom {
    let mut shop = Workshop::default();
    let mut room = Room::new(GROTTO, &mut shop, Random::new(7));
    for door in DOORS.iter().filter(|door| door.to == Name::Fountain) {
        open(&mut room, door.name, &door.gate, false);
    }
    basin(&mut room);
    rocks(&mut room);
    ceiling::ribs(&mut room, PALE_STONE, 0.35, 0.16, &[0.2, 3.9]);
    ceiling::stars(&mut room, 70, GOLD);
    let corners = GROTTO.plan.corners();
    cornice(&mut room, &corners, GROTTO.height, 0.4);
    let urn = ornament::urn(room.shop, COBALT, GOLD);
    for side in [Side::North, Side::South] {
        let wall = GROTTO.plan.wall(side);
        let outline = arched(1.5, 0.7, 2.1, 0.75);
        room.cut(wall, 2.05, &outline, 0.35, Some(COBALT), STONE);
        let border = [[0.0, 0.0], [0.0, 0.05], [0.06, 0.08], [0.16, 0.04], [0.16, 0.0]];
        let border = room.shop.piece("grotto niche".to_owned(), || {
            surround(PALE_STONE, &outline, true, &border)
        });
        let place = room.walls()[wall].at(2.05, 0.0);
        room.put("niche border", &border, place);
        room.put("urn", &urn, place * shift(0.0, 0.7, -0.02) * scaled(1.1));
    }
    for z in [-49.0, -54.0] {
        light::candelabrum(&mut room, spot(-42.4, z, 0.0), 1.5, OLD_GOLD);
    }
    room.make("paving", &paving(GROTTO.plan, GROTTO.style.floor, STONE, 0.3));
    room.close()
}

/// A round basin with nozzles on its rim, and a figure on rocks in its middle.
fn basin(room: &mut Room) {
    let [x, z] = MIDDLE;
    let profile = [
        [0.0, 0.0],
        [2.5, 0.0],
        [2.5, 0.1],
        [2.36, 0.16],
        [2.36, 0.46],
        [2.5, 0.52],
        [2.5, 0.62],
        [2.2, 0.62],
        [2.2, 0.1],
        [0.0, 0.1],
    ];
    let stone = lathe(PALE_STONE, &profile, 48).dressed(dress);
    room.put("basin", &stone, spot(x, z, 0.0));
    let nozzle = [[0.0, 0.0], [0.07, 0.0], [0.04, 0.05], [0.03, 0.1], [0.0, 0.1]];
    let nozzle = lathe(GOLD, &nozzle, 8).dressed(dress);
    for jet in 0..JETS {
        let foot = rim(jet) - Vec3::Y * 0.1;
        room.put("nozzle", &nozzle, shift(foot.x, foot.y, foot.z));
    }
    let figure = statue::figure(room.shop, Pose::Jug, WHITE_MARBLE, GOLD);
    room.put(
        "statue",
        &figure,
        spot(x, z, 90.0) * shift(0.0, 0.92, 0.0) * scaled(1.2),
    );
}

/// Rocks under the figure and along the wall of the apse.
fn rocks(room: &mut Room) {
    let mut random = Random::new(11);
    let kinds = [STONE, DARK_STONE, VERDIGRIS]
        .map(|stone| superquadric(stone, [1.0; 3], 0.7, 0.8, 6, 9).dressed(dress));
    let mut put = |room: &mut Room, at: Vec3, size: f32| {
        let turn = Transform::rotation(random.point(1.0), 6.0 * f64::from(random.unit()));
        let sides = [0; 3].map(|_| size * random.between(0.7, 1.15));
        let rock = random.pick(&[0, 0, 1, 2]);
        let place = shift(at.x, at.y, at.z) * turn * Transform::scaling(sides);
        room.put("rock", &kinds[rock], place);
    };
    let [x, z] = MIDDLE;
    put(room, vec3(x, 0.4, z), 0.62);
    for i in 0..7 {
        let (sin, cos) = (TAU * f64::from(i) / 7.0).sin_cos();
        put(
            room,
            vec3(x + 0.45 * cos as f32, 0.45, z + 0.45 * sin as f32),
            0.3,
        );
    }
    let reach = 3.4 - 0.22;
    for i in 0..17 {
        let (sin, cos) = (0.5 * TAU * (f64::from(i) + 0.5) / 17.0).sin_cos();
        let at = vec3(x - reach * sin as f32, 0.12, z + reach * cos as f32);
        put(room, at, 0.26);
        if i % 3 != 1 {
            put(room, at + vec3(-0.04 * sin as f32, 0.3, 0.04 * cos as f32), 0.2);
        }
    }
}
