//! Small random scenes, to test properties that must hold for every scene.

use crate::BuiltIn;
use crate::camera::camera_with_fov;
use crate::envelope::Side;
use crate::laws::Stage;
use crate::laws::stage::{
    BLUE, BLUE_GLASS, BLUE_SHEET, BROWN, Doorway, GREEN, GREEN_SHEET, LEAF, RED, RED_GLASS, RED_SHEET, WHITE,
    YELLOW, finished, sheet,
};
use crate::random::Random;
use crate::shape::{Shape, around, ball, block, cuboid, prism};
use enfilade::{MaterialId, Method, SceneBuilder, Transform};
use glam::{Vec3, vec3};

const MATERIALS: [MaterialId; 14] = [
    RED,
    GREEN,
    BLUE,
    YELLOW,
    BROWN,
    WHITE,
    RED,
    RED_SHEET,
    GREEN_SHEET,
    BLUE_SHEET,
    BLUE_SHEET,
    LEAF,
    BLUE_GLASS,
    RED_GLASS,
];

/// Creates a random scene: three to eleven items in the open or in one or two rooms, and one or two cameras. The same
/// seed gives the same scene.
///
/// Items may intersect, touch, be coplanar, mirrored, flattened, alpha-blended, or seen from behind.
pub fn random_scene(seed: u64) -> BuiltIn {
    let mut random = Random::new(seed);
    let mut scene = SceneBuilder::new();
    let mut here = Stage::new();
    match random.below(4) {
        0 => {
            scatter(&mut here, &mut random, 0.0);
            scene.add("open", here.build(), Method::HierarchicalZ);
        }
        1 => {
            let glass = Doorway {
                name: "mirror",
                side: Side::North,
                plane: -3.02,
                along: stretch(&mut random),
                up: [0.3, 2.4],
            };
            let opening = here.room([-3.0, 3.0], [-3.0, 3.0], 3.0, &[glass])[0];
            scatter(&mut here, &mut random, 0.0);
            let room = scene.add("room", here.build(), Method::HierarchicalZ);
            scene.mirror(room, opening);
        }
        _ => {
            let door = Doorway {
                name: "door",
                side: Side::East,
                plane: 3.1,
                along: stretch(&mut random),
                up: [0.0, 2.1],
            };
            let mut there = Stage::new();
            let out = here.room([-3.0, 3.0], [-3.0, 3.0], 3.0, &[door])[0];
            let back = there.room([3.2, 9.0], [-3.0, 3.0], 3.0, &[door.other_side()])[0];
            scatter(&mut here, &mut random, 0.0);
            scatter(&mut there, &mut random, 6.1);
            let here = scene.add("here", here.build(), Method::HierarchicalZ);
            let there = scene.add("there", there.build(), Method::HierarchicalZ);
            scene.door((here, out), (there, back));
        }
    }
    let cameras = (0..1 + random.below(2))
        .map(|i| {
            let eye = [
                random.between(-2.9, 2.9),
                random.between(0.1, 2.9),
                random.between(-2.9, 2.9),
            ];
            let toward = [
                random.between(-3.0, 6.0),
                random.between(0.0, 3.0),
                random.between(-3.0, 3.0),
            ];
            camera_with_fov(&format!("camera {i}"), eye, toward, random.between(25.0, 110.0))
        })
        .collect();
    finished(scene, cameras)
}

/// Returns the extent of a hole along its wall.
fn stretch(random: &mut Random) -> [f32; 2] {
    let from = random.between(-2.5, 1.5);
    [from, from + random.between(0.2, 1.2)]
}

/// Adds three to eleven items in a box of 6 × 3 × 6 units centred at x = `middle`.
fn scatter(stage: &mut Stage, random: &mut Random, middle: f32) {
    for _ in 0..3 + random.below(9) {
        // Sometimes on a grid, so that faces become coplanar.
        let mut at = vec3(
            random.between(-2.6, 2.6),
            random.between(0.0, 2.4),
            random.between(-2.6, 2.6),
        );
        if random.once_in(3) {
            at = (2.0 * at).round() * 0.5;
        }
        at.x += middle;
        let turn = if random.once_in(3) {
            0.0
        } else {
            f64::from(random.between(-3.0, 3.0))
        };
        let axis = Vec3::from(random.point(1.0)).normalize_or(Vec3::Y).to_array();
        let size = match random.below(8) {
            0 => Transform::scaling([-1.0, 1.0, 1.0]),
            1 => Transform::scaling([1.0, 0.0, 1.0]),
            _ => Transform::scaling([
                random.between(0.2, 1.5),
                random.between(0.2, 1.5),
                random.between(0.2, 1.5),
            ]),
        };
        let place = Transform::translation(at.to_array()) * Transform::rotation(axis, turn) * size;
        stage.placed("thing", &thing(random), place);
    }
}

fn thing(random: &mut Random) -> Shape {
    let material = random.pick(&MATERIALS);
    match random.below(6) {
        0 => sheet(
            material,
            vec3(-0.6, 0.0, 0.0),
            vec3(1.2, 0.0, 0.0),
            vec3(0.0, 1.2, 0.0),
        ),
        1 => {
            let mut shape = Shape::new();
            shape.triangle(
                material,
                [random.point(0.8), random.point(0.8), random.point(0.8)].map(Vec3::from),
            );
            shape
        }
        2 => ball(material, 0.5, 5, 8),
        3 => {
            let outline: Vec<Vec3> = around(3 + random.below(6))
                .map(|at| vec3(0.5 * at.x, 0.0, 0.5 * at.y))
                .collect();
            prism(material, &outline, vec3(0.2, 0.7, 0.0))
        }
        4 => block(material, [-1.4, -0.08, -0.08], [1.4, 0.08, 0.08]),
        _ => cuboid(material, [0.8, 0.8, 0.8]),
    }
}
