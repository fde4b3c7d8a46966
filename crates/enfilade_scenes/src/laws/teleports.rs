//! Portals that rotate and scale.

use super::stage::{
    BLUE, BROWN, Doorway, GREEN, GREY, RED, RED_SHEET, Stage, WHITE, YELLOW, YELLOW_SHEET, both_ways,
    finished, lamp, sheet,
};
use crate::BuiltIn;
use crate::camera::camera;
use crate::envelope::Side;
use crate::shape::{Shape, ball, block, cuboid, knot};
use enfilade::{Method, SceneBuilder, Transform};
use glam::{Vec3, vec3};

/// A hall with four openings, none of which leads to the space behind it.
///
/// A free-standing gate in the middle leads one way into a yard, rotated about an oblique axis; the yard has no
/// opening. The door in the east is one of a pair: it leads into a cell and back, and leans there. The window in the
/// west shows a garden three times larger than it looks, the one in the north a model forty times smaller; neither has
/// a way back.
pub(crate) fn teleport() -> BuiltIn {
    let mut hall = Stage::new();
    let openings = hall.room([-4.0, 4.0], [-4.0, 4.0], 3.2, &[DOOR, TO_GARDEN, TO_MODEL]);
    let gate: Vec<Vec3> = [(-0.6, 0.0), (0.6, 0.0), (0.6, 2.0), (-0.6, 2.0)]
        .map(|(x, y)| vec3(x, y, 0.0))
        .to_vec();
    hall.thing("frame", &frame());
    for (name, material, x, z) in [
        ("behind the gate", RED, -0.3, -2.0),
        ("left of it", BLUE, -2.2, -1.8),
        ("right of it", YELLOW, 1.6, -1.8),
        ("before it", GREEN, 0.5, 2.4),
    ] {
        let place = Transform::translation([x, 0.0, z]);
        hall.placed(name, &cuboid(material, [0.6, 1.1, 0.6]), place);
    }
    let gate = hall.opening("gate", &gate);

    let cell_from_hall = about(DOOR, [0.4, 1.0, 0.3], 1.1, 1.0, [100.0, 2.0, 0.0]);
    let arrival: Vec<Vec3> = DOOR
        .outline()
        .into_iter()
        .rev()
        .map(|corner| cell_from_hall.point(corner.to_array()).into())
        .collect();
    let mut cell = cell(&arrival);
    let back = cell.opening("back", &arrival);

    let mut scene = SceneBuilder::new();
    let hall = scene.add("hall", hall.build(), Method::HierarchicalZ);
    let yard = scene.add("yard", yard().build(), Method::HierarchicalZ);
    let cell = scene.add("cell", cell.build(), Method::HierarchicalZ);
    let garden = scene.add("garden", garden().build(), Method::HierarchicalZ);
    let model = scene.add("model", model().build(), Method::HierarchicalZ);
    let yard_from_hall = Transform::translation([50.0, 1.4, 0.0])
        * Transform::rotation([1.0, 2.0, 0.5], 0.8)
        * Transform::translation([0.0, -1.0, 0.0]);
    scene.portal((hall, gate), yard, yard_from_hall);
    both_ways(&mut scene, (hall, openings[0]), (cell, back), cell_from_hall);
    let garden_from_hall = about(TO_GARDEN, [0.1, 1.0, -0.1], 0.7, 3.0, [157.0, 4.0, 3.0]);
    scene.portal((hall, openings[1]), garden, garden_from_hall);
    let model_from_hall = about(TO_MODEL, [-0.2, 1.0, 0.1], 0.3, 1.0 / 40.0, [10.0, 0.06, 0.15]);
    scene.portal((hall, openings[2]), model, model_from_hall);
    lamp(&mut scene, hall, [1.5, 2.6, 1.0], 9.0);
    finished(
        scene,
        vec![
            camera("before the gate", [0.2, 1.6, 3.4], [0.0, 1.1, 0.0]),
            camera("aside of it", [2.6, 1.6, 2.6], [-0.4, 1.1, -0.6]),
            camera("at the gate", [0.1, 1.3, 0.04], [0.2, 1.2, -3.0]),
            camera("behind the gate", [0.3, 1.6, -3.2], [0.0, 1.1, 0.0]),
            camera("in the yard", [53.8, 2.6, 1.9], [49.6, 1.2, -0.2]),
            camera("to the cell", [1.2, 1.6, 1.2], [4.0, 1.1, -0.2]),
            camera("at the cell's door", [4.05, 1.2, 0.1], [6.0, 1.1, 0.0]),
            camera("back from the cell", [102.6, 3.0, -1.8], [100.0, 2.0, 0.0]),
            camera("behind the cell's door", [98.8, 2.4, 2.0], [100.0, 2.0, 0.0]),
            camera("to the garden", [-1.4, 1.5, 0.6], [-4.1, 1.4, 0.0]),
            camera("at the garden", [-4.0, 1.4, 0.2], [-6.0, 1.4, -0.4]),
            camera("to the model", [0.9, 1.6, -2.2], [1.6, 1.4, -4.1]),
        ],
    )
}

const DOOR: Doorway = Doorway {
    name: "door",
    side: Side::East,
    plane: 4.1,
    along: [-0.6, 0.6],
    up: [0.0, 2.0],
};
const TO_GARDEN: Doorway = Doorway {
    name: "to the garden",
    side: Side::West,
    plane: -4.1,
    along: [-0.8, 0.8],
    up: [0.7, 2.1],
};
const TO_MODEL: Doorway = Doorway {
    name: "to the model",
    side: Side::North,
    plane: -4.1,
    along: [0.8, 2.4],
    up: [0.7, 2.1],
};

/// Rotates about `axis` and scales, so that the middle of a doorway moves to `there`.
fn about(door: Doorway, axis: [f32; 3], radians: f64, factor: f32, there: [f32; 3]) -> Transform {
    let outline = door.outline();
    let middle = 0.5 * (outline[0] + outline[2]);
    Transform::translation(there)
        * Transform::scaling([factor; 3])
        * Transform::rotation(axis, radians)
        * Transform::translation((-middle).to_array())
}

/// The frame of the gate, open below.
fn frame() -> Shape {
    let mut frame = block(BROWN, [-0.75, 0.0, -0.08], [-0.6, 2.15, 0.08]);
    frame.join(block(BROWN, [0.6, 0.0, -0.08], [0.75, 2.15, 0.08]));
    frame.join(block(BROWN, [-0.6, 2.0, -0.08], [0.6, 2.15, 0.08]));
    frame
}

/// Items on all sides, because the gate shows the yard from its middle.
fn yard() -> Stage {
    let mut yard = Stage::new();
    yard.room([44.0, 56.0], [-6.0, 6.0], 4.5, &[]);
    let colors = [RED, GREEN, BLUE, YELLOW, BROWN, WHITE];
    for (i, at) in crate::shape::around(12).enumerate() {
        let reach = if i % 2 == 0 { 3.0 } else { 4.6 };
        let place = Transform::translation([50.0 + reach * at.x, 0.0, reach * at.y]);
        yard.placed(
            "post",
            &cuboid(colors[i % 6], [0.5, 1.0 + 0.2 * i as f32, 0.5]),
            place,
        );
    }
    let place = Transform::translation([49.7, 1.9, 0.2]);
    yard.placed("in the gate", &ball(RED_SHEET, 0.35, 8, 12), place);
    yard
}

/// A room with a free-standing, leaning door.
fn cell(arrival: &[Vec3]) -> Stage {
    let mut cell = Stage::new();
    cell.room([96.0, 104.0], [-4.0, 4.0], 5.0, &[]);
    let out = (arrival[1] - arrival[0])
        .cross(arrival[2] - arrival[1])
        .normalize();
    let middle = 0.5 * (arrival[0] + arrival[2]);
    for i in 0..4 {
        let [from, to] = [arrival[i], arrival[(i + 1) % 4]];
        let aside = 0.15 * (0.5 * (from + to) - middle).normalize();
        let mut bar = sheet(YELLOW_SHEET, from - 0.1 * out, to - from, 0.2 * out);
        bar.join(sheet(BLUE, from, to - from, aside));
        cell.thing("frame", &bar);
    }
    for (name, material, at) in [
        ("ball", RED, [102.2, 1.0, 1.6]),
        ("green ball", GREEN, [97.6, 1.2, -1.0]),
        ("blue ball", BLUE, [101.0, 4.0, -2.4]),
    ] {
        cell.placed(name, &ball(material, 0.6, 10, 14), Transform::translation(at));
    }
    cell
}

/// A garden thirty units wide.
fn garden() -> Stage {
    let mut garden = Stage::new();
    garden.room([135.0, 165.0], [-15.0, 15.0], 12.0, &[]);
    for i in 0..9 {
        let place = Transform::translation([141.0 + 8.0 * (i % 3) as f32, 0.0, -9.0 + 8.0 * (i / 3) as f32]);
        garden.placed("trunk", &cuboid(GREY, [0.8, 4.0, 0.8]), place);
        let crown = Transform::translation([0.0, 5.0, 0.0]) * place;
        let color = if i == 4 { RED } else { GREEN };
        garden.placed("crown", &ball(color, 1.8, 8, 12), crown);
    }
    garden
}

/// A model a fifth of a unit wide.
fn model() -> Stage {
    let mut model = Stage::new();
    model.room([9.8, 10.2], [-0.2, 0.2], 0.16, &[]);
    let place = Transform::translation([10.0, 0.05, 0.02]);
    model.placed("knot", &knot(RED, 2, 3, 0.03, 0.012, 0.006, 48, 7), place);
    for (i, material) in [GREEN, BLUE, YELLOW, BROWN].into_iter().enumerate() {
        let [x, z] = [9.88 + 0.07 * i as f32, 0.1 - 0.05 * i as f32];
        let place = Transform::translation([x, 0.0, z]);
        model.placed(
            "house",
            &cuboid(material, [0.03, 0.04 + 0.01 * i as f32, 0.03]),
            place,
        );
    }
    model
}
