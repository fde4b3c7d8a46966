//! The doll's house in the study: a nested scene, eight times larger than it looks, and deeper than the wall behind it.

use super::doors::Gate;
use super::floor::Floor;
use super::open;
use super::palette::*;
use super::room::{Design, PAVING, Room, Style, arched, scaled, shift, spot};
use super::rooms::finish;
use super::statue::Pose;
use super::workshop::Workshop;
use super::{ceiling, column, drapery, light, seat, statue, table};
use crate::envelope::{Axis, Ceiling, Plan, Side};
use crate::shape::{Shape, block, fill, lathe, prism};
use enfilade::{NestedId, OpeningId, PortalEnd, Scene, SceneBuilder, SectorId, Transform};
use enfilade_scenes::Random;
use glam::{Vec3, vec3};

/// Scale from the study to the house.
const SCALE: f32 = 8.0;

/// The middle of the foot of its front, in the study and in the house's space, which overlaps nothing else.
const HERE: Vec3 = vec3(14.04, 0.75, -87.5);
const THERE: Vec3 = vec3(64.0, 0.0, -87.5);

const FRONT: Gate = Gate {
    looks: Side::East,
    at: [THERE.x, THERE.z],
    width: 10.4,
    sill: 0.0,
    spring: 5.4,
    rise: 2.4,
};

const STYLE: Style = Style {
    floor: Floor::Checker(1.0, [ROSE, IVORY]),
    trim: IVORY,
    gilt: GOLD,
    dado: PALE_BLUE,
    wall: PALE_BLUE,
    field: BLUE_SILK,
    ceiling: IVORY,
    reveal: GOLD,
};

const HALL: Design = Design {
    name: "Doll's Hall",
    plan: Plan::Rectangle([64.4, 76.0], [-93.5, -81.5]),
    height: 8.4,
    ceiling: Ceiling::Vault(Axis::WestEast, 3.2),
    style: STYLE,
};

const CHAMBER: Design = Design {
    name: "Doll's Chamber",
    plan: Plan::Rectangle([76.9, 84.0], [-92.0, -83.0]),
    height: 5.6,
    ceiling: Ceiling::Cove(1.0, 0.9),
    style: Style {
        floor: Floor::Herringbone(0.25, [OAK, PALE_OAK, OAK]),
        dado: DARK_RED,
        wall: YELLOW_SILK,
        field: RED_SILK,
        ..STYLE
    },
};

/// Returns the transform from the study into the house.
fn there_from_here() -> Transform {
    shift(THERE.x, THERE.y, THERE.z) * scaled(SCALE) * shift(-HERE.x, -HERE.y, -HERE.z)
}

fn here_from_there() -> Transform {
    shift(HERE.x, HERE.y, HERE.z) * scaled(1.0 / SCALE) * shift(-THERE.x, -THERE.y, -THERE.z)
}

/// Builds the nested scene; its exit is `front`.
pub(super) fn doll_house(shop: &mut Workshop, seed: u64) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = SceneBuilder::new();
    let inner = Gate {
        looks: Side::East,
        at: [76.45, -87.5],
        width: 2.6,
        sill: 0.0,
        spring: 3.8,
        rise: 0.0,
    };

    let mut hall = Room::new(HALL, shop, Random::new(random.bits()));
    let front = open(&mut hall, "front", &FRONT, false);
    let door = open(&mut hall, "chamber door", &inner, true);
    furnish_hall(&mut hall);
    finish(&mut hall, ROSE);
    let hall = hall.close().add_to(&mut scene, HALL.name);

    let mut chamber = Room::new(CHAMBER, shop, Random::new(random.bits()));
    let back = open(&mut chamber, "hall door", &inner, false);
    furnish_chamber(&mut chamber);
    finish(&mut chamber, WALNUT);
    let chamber = chamber.close().add_to(&mut scene, CHAMBER.name);

    scene.door((hall, door), (chamber, back));
    scene.exit("front", (hall, front));
    scene.build().expect("the doll's house stands")
}

fn furnish_hall(room: &mut Room) {
    ceiling::coffer_vault(
        room,
        4,
        ceiling::Coffering {
            rib: IVORY,
            step: GOLD,
            rosette: GOLD,
        },
    );
    let shaft = column::column(room.shop, 7.5, WHITE_MARBLE, GOLD);
    for z in [-92.6, -82.4] {
        for x in [66.2, 69.2, 72.2, 75.2] {
            room.put("column", &shaft, spot(x, z, 0.0));
        }
    }
    let dress = [RED_SILK, GREEN_SILK, ROSE, COBALT, YELLOW_SILK];
    for (i, (x, z)) in [
        (68.0, -90.6),
        (69.6, -84.4),
        (71.4, -89.8),
        (73.2, -85.3),
        (73.8, -90.3),
    ]
    .into_iter()
    .enumerate()
    {
        let doll = statue::figure(room.shop, Pose::ALL[i], dress[i], GOLD);
        room.put("doll", &doll, spot(x, z, -60.0 - 20.0 * i as f32));
    }
    let chair = seat::armchair(room.shop, GOLD, RED_SILK);
    let round = table::round_table(room.shop, 0.9, MAHOGANY, GOLD);
    for z in [-91.0, -84.0] {
        room.put("round table", &round, spot(66.8, z, 0.0));
        room.put("chair", &chair, spot(66.8, z - 1.4, 0.0));
        room.put("chair", &chair, spot(66.8, z + 1.4, 180.0));
    }
    let carpet = drapery::carpet(room.shop, [3.2, 10.0], drapery::Rug::Red);
    room.put("carpet", &carpet, spot(70.4, -87.5, 90.0));
    light::chandelier(room, [70.4, -87.5], 6.2, 16, 2.4, GOLD);
    dim(room);
}

fn furnish_chamber(room: &mut Room) {
    let sofa = seat::sofa(room.shop, GOLD, RED_VELVET);
    room.put("sofa", &sofa, spot(82.6, -87.5, -90.0));
    let statue = statue::figure(room.shop, Pose::Torch, WHITE_MARBLE, GOLD);
    for z in [-91.0, -84.0] {
        room.put("statue", &statue, spot(82.6, z, -90.0) * scaled(1.2));
        light::candelabrum(room, spot(78.4, z, 0.0), 1.8, GOLD);
    }
    light::chandelier(room, [80.4, -87.5], 3.6, 10, 1.4, GOLD);
    dim(room);
}

/// Dims the room's lights to the level of the study.
fn dim(room: &mut Room) {
    for lamp in room.lamps.iter_mut().chain(&mut room.candles) {
        *lamp = lamp.times(0.4);
    }
}

/// Adds the house's shell to the study; returns the opening in its front.
pub(super) fn stand(room: &mut Room) -> OpeningId {
    let inside: Vec<Vec3> = arched(FRONT.width, FRONT.sill, FRONT.spring, FRONT.rise)
        .into_iter()
        .map(|corner| {
            let there = [THERE.x, corner.y, THERE.z + corner.x];
            Vec3::from(here_from_there().point(there))
        })
        .collect();
    let opening = room.opening("doll's house", &inside);
    room.make("doll's house", &shell(&inside));
    let wall = room.design.plan.wall(Side::East);
    let middle = room.walls()[wall].along(glam::vec2(HERE.x, HERE.z));
    room.take(wall, middle - 1.2, middle + 1.2);
    let chair = seat::stool(room.shop, MAHOGANY, RED_SILK);
    room.put("stool", &chair, spot(HERE.x - 1.3, HERE.z - 1.0, 60.0));
    opening
}

/// A cabinet with a gabled roof and an arched hole in its front, on a low table.
fn shell(opening: &[Vec3]) -> Shape {
    let [front, back] = [14.0, 14.95];
    let [south, north] = [HERE.z + 0.85, HERE.z - 0.85];
    let [foot, top] = [HERE.y - 0.07, HERE.y + 1.1];
    let mut shape = Shape::new();
    let corner = |x: f32, y: f32, z: f32| vec3(x, y, z);
    let hole: Vec<Vec3> = opening.iter().map(|at| vec3(front, at.y, at.z)).collect();
    // As seen from the room, north is on the left.
    let face = [
        corner(front, foot, north),
        corner(front, foot, south),
        corner(front, top, south),
        corner(front, top, north),
    ];
    for part in fill(&face, std::slice::from_ref(&hole)) {
        shape.face(IVORY, &part);
    }
    for i in 0..hole.len() {
        let next = (i + 1) % hole.len();
        shape.face(GOLD, &[hole[i], hole[next], opening[next], opening[i]]);
    }
    let side = |z: f32| {
        [
            corner(front, foot, z),
            corner(back, foot, z),
            corner(back, top, z),
            corner(front, top, z),
        ]
    };
    let mut north_side = side(north);
    north_side.reverse();
    shape.face(PALE_BLUE, &side(south));
    shape.face(PALE_BLUE, &north_side);
    let gable = [
        corner(13.92, top, south + 0.1),
        corner(13.92, top, north - 0.1),
        corner(13.92, top + 0.5, HERE.z),
    ];
    let gable = [gable[2], gable[1], gable[0]];
    shape.join(prism(RED_SILK, &gable, vec3(back - 13.92, 0.0, 0.0)).flipped());
    shape.join(block(
        GOLD,
        [13.9, top, north - 0.14],
        [back, top + 0.05, south + 0.14],
    ));
    shape.join(block(
        MAHOGANY,
        [13.92, foot - 0.08, north - 0.08],
        [back, foot, south + 0.08],
    ));
    let leg = [
        [0.0, PAVING],
        [0.04, PAVING],
        [0.06, 0.1],
        [0.035, 0.2],
        [0.05, foot - 0.08],
    ];
    for z in [north, HERE.z, south] {
        for x in [14.05, 14.85] {
            shape.add(&lathe(MAHOGANY, &leg, 12), shift(x, 0.0, z));
        }
    }
    for z in [north + 0.1, south - 0.1] {
        let post = [
            [0.0, 0.0],
            [0.05, 0.0],
            [0.035, 0.05],
            [0.03, 1.02],
            [0.06, 1.1],
            [0.0, 1.1],
        ];
        shape.add(&lathe(GOLD, &post, 14), shift(front, foot + 0.07, z));
    }
    shape
}

/// Joins the study's opening and the house's exit, in both directions.
pub(super) fn join(scene: &mut SceneBuilder, here: (SectorId, OpeningId), house: &Scene) {
    let house: NestedId = scene.nest(house);
    let there = PortalEnd::from((house, "front"));
    scene.portal(here, there.clone(), there_from_here());
    scene.portal(there, here, here_from_there());
}
