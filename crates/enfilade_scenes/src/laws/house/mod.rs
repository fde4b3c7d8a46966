//! Houses with baked PVS cells.

mod plan;

use super::stage::{
    BLUE, BLUE_GLASS, BROWN, GREEN, LEAF, RED, Stage, YELLOW, both_ways, finished, lamp, sheet,
};
use crate::BuiltIn;
use crate::camera::camera;
use crate::random::Random;
use crate::shape::{ball, block, cuboid};
use enfilade::{Method, SceneBuilder, Transform};
use glam::{Vec3, vec3};
use plan::{OpenRect, Plan};

const HOUSE: [&str; 11] = [
    "##################",
    "#aaaa#bbbbb#ccccc#",
    "#aaaa1bbbbb2ccccc#",
    "#aaaa#bbbbb#ccccc#",
    "#aaaa#bbbbb#ccccc#",
    "##3#####4######5##",
    "#ddd#eeeeee#fffff#",
    "#ddd#eeeeee6fffff#",
    "#ddd7eeeeee#fffffX",
    "#ddd#eeeeee#fffff#",
    "##################",
];

const ANNEX: [&str; 6] = [
    "#########",
    "#gggg#hh#",
    "#gggg8hh#",
    "Ygggg#hh#",
    "#gggg#hh#",
    "#########",
];

/// Position of the annex: its door `Y` coincides with the house's door `X`.
const ANNEX_FROM: [f32; 2] = [18.0, 5.0];

/// A house of six rooms and an annex of two, each with baked PVS cells.
///
/// Every room contains a box, a ball and a pillar. A carpet extends through one door, a pane of glass is in another, a
/// bush in a third, and an invisible block in the rock between two rooms. A door leads from the house into the annex
/// and back; a mirror hangs in room `c`; a one-way gate in room `h` leads into room `d`, rotated.
pub(crate) fn house() -> BuiltIn {
    let [mut house, mut annex] = [Stage::new(), Stage::new()];
    for (stage, plan) in [
        (&mut house, Plan::drawn([0.0; 2], &HOUSE)),
        (&mut annex, Plan::drawn(ANNEX_FROM, &ANNEX)),
    ] {
        plan.build(stage);
        furnish(stage, &plan);
        stage.cells(plan.bake());
    }
    house.thing("carpet", &block(RED, [2.0, 0.0, 2.25], [8.5, 0.02, 2.75]));
    house.thing(
        "pane",
        &sheet(BLUE_GLASS, vec3(8.0, 0.0, 5.5), Vec3::X, 2.0 * Vec3::Y),
    );
    house.thing("bush", &sheet(LEAF, vec3(2.0, 0.0, 5.25), Vec3::X, 1.2 * Vec3::Y));
    house.thing(
        "in the rock",
        &block(YELLOW, [11.25, 0.5, 3.25], [11.75, 1.5, 3.75]),
    );
    let door: Vec<Vec3> = [(8.0, 0.0), (9.0, 0.0), (9.0, 2.0), (8.0, 2.0)]
        .map(|(z, y)| vec3(18.0, y, z))
        .to_vec();
    let back_door: Vec<Vec3> = door.iter().rev().copied().collect();
    let [out, back] = [house.opening("door", &door), annex.opening("door", &back_door)];
    let mirror = [(13.0, 0.5), (15.5, 0.5), (15.5, 2.5), (13.0, 2.5)].map(|(x, y)| vec3(x, y, 1.0625));
    let mirror = house.opening("mirror", &mirror);
    let gate: Vec<Vec3> = [(24.25, 0.0), (25.75, 0.0), (25.75, 2.0), (24.25, 2.0)]
        .map(|(x, y)| vec3(x, y, 7.0))
        .to_vec();
    let gate = annex.opening("gate", &gate);

    let mut scene = SceneBuilder::new();
    let house = scene.add("house", house.build(), Method::HierarchicalZ);
    let annex = scene.add("annex", annex.build(), Method::HierarchicalZ);
    both_ways(&mut scene, (house, out), (annex, back), Transform::IDENTITY);
    scene.mirror(house, mirror);
    let house_from_annex = Transform::translation([2.5, 0.0, 9.0])
        * Transform::rotation([0.0, 1.0, 0.0], 0.3)
        * Transform::translation([-25.0, 0.0, -7.0]);
    scene.portal((annex, gate), house, house_from_annex);
    lamp(&mut scene, house, [8.0, 2.6, 7.5], 12.0);
    finished(
        scene,
        vec![
            camera("in a, to b", [1.5, 1.5, 2.0], [9.0, 1.2, 2.6]),
            camera("in b, to e", [8.2, 1.6, 1.5], [8.6, 1.0, 8.0]),
            camera("in c, to the mirror", [14.0, 1.6, 4.5], [14.4, 1.4, 1.0]),
            camera("in f, to the annex", [12.5, 1.6, 8.2], [20.0, 1.2, 8.5]),
            camera("in f, past the door", [15.0, 1.6, 7.0], [13.0, 1.4, 8.0]),
            camera("at the edge of a doorway", [5.0, 1.5, 2.5], [9.0, 1.2, 3.0]),
            camera("in a doorway", [5.5, 1.5, 2.5], [2.0, 1.2, 2.0]),
            camera("on the door to the annex", [18.0, 1.5, 8.5], [21.0, 1.3, 8.0]),
            camera("just before it", [17.999_999, 1.5, 8.5], [21.0, 1.3, 8.0]),
            camera("in the annex, to the house", [21.5, 1.6, 8.6], [12.0, 1.2, 8.2]),
            camera("before the gate", [24.8, 1.6, 9.5], [25.0, 1.2, 6.0]),
            camera("at the gate", [25.0, 1.5, 7.005], [25.1, 1.2, 5.0]),
            camera("nose to the wall", [1.004, 1.5, 3.0], [0.0, 1.5, 3.0]),
            camera("through the wall", [1.0005, 1.5, 3.0], [0.0, 1.5, 3.0]),
            camera("in the wall", [5.5, 1.5, 3.5], [12.0, 1.2, 4.0]),
            camera("above all", [9.0, 14.0, 16.0], [9.0, 0.0, 5.0]),
        ],
    )
}

/// Adds a box, a ball and a pillar to every room.
fn furnish(stage: &mut Stage, plan: &Plan) {
    for room in plan.open.iter().filter(|open| !open.is_doorway) {
        let [low, high] = plan.bounds(room);
        let at = |along: f32, across: f32| {
            let place = [0, 1].map(|axis| {
                let part = [along, across][axis];
                low[axis] + (high[axis] - low[axis]) * part
            });
            Transform::translation([place[0], 0.0, place[1]])
        };
        let name = |what: &str| format!("{} {what}", room.name);
        stage.placed(&name("box"), &cuboid(GREEN, [0.5, 0.8, 0.4]), at(0.25, 0.3));
        let lifted = Transform::translation([0.0, 1.2, 0.0]);
        stage.placed(&name("ball"), &ball(BLUE, 0.3, 6, 9), lifted * at(0.7, 0.75));
        stage.placed(&name("pillar"), &cuboid(BROWN, [0.2, 2.9, 0.2]), at(0.6, 0.35));
    }
}

/// Creates a random house: rooms in rows and columns with doors between neighbours, all in one sector with baked cells.
/// The same seed gives the same house. Items whose names end in `box`, `ball` or `pillar` are free-standing; all others
/// are walls, floors and ceilings.
pub fn random_house(seed: u64) -> BuiltIn {
    let mut random = Random::new(seed);
    let mut ends = || -> Vec<usize> {
        let rooms = 2 + random.below(3);
        let mut ends = vec![0];
        for _ in 0..rooms {
            let last = ends[ends.len() - 1];
            ends.push(last + 3 + random.below(3));
        }
        ends
    };
    // A wall, then a room up to the next wall.
    let [columns, rows] = [ends(), ends()];
    let mut open = Vec::new();
    for row in rows.windows(2) {
        for column in columns.windows(2) {
            open.push(OpenRect {
                name: format!("room {}", open.len()),
                is_doorway: false,
                x: column[0] + 1..column[1],
                z: row[0] + 1..row[1],
            });
        }
    }
    let rooms = open.clone();
    let across = columns.len() - 1;
    for (number, room) in rooms.iter().enumerate() {
        let mut add = |x: usize, z: usize| {
            open.push(OpenRect {
                name: format!("door {}", open.len()),
                is_doorway: true,
                x: x..x + 1,
                z: z..z + 1,
            });
        };
        if (number + 1) % across > 0 && random.below(4) > 0 {
            add(room.x.end, room.z.start + random.below(room.z.len()));
        }
        if number + across < rooms.len() && random.below(4) > 0 {
            add(room.x.start + random.below(room.x.len()), room.z.end);
        }
    }
    let size = [columns, rows].map(|ends| ends[ends.len() - 1] + 1);
    let from = [random.unit() * 8.0 - 4.0, random.unit() * 1000.0].map(f32::floor);
    let plan = Plan::new(from, size, open);
    let mut stage = Stage::new();
    plan.build(&mut stage);
    furnish(&mut stage, &plan);
    stage.cells(plan.bake());
    let cameras = (0..8).map(|number| {
        let place = &plan.open[random.below(plan.open.len())];
        let [low, high] = plan.bounds(place);
        let [eye, toward] = [0.0, 1.0].map(|down: f32| {
            let [x, z] = [0, 1].map(|axis| low[axis] + (high[axis] - low[axis]) * random.unit());
            [x, 1.6 - down * random.unit(), z]
        });
        camera(&format!("camera {number}"), eye, toward)
    });
    let cameras = cameras.collect();
    super::stage::alone(stage, cameras)
}
