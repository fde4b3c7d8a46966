//! Scenes of extreme size: very large, very small, with very many items, and with one very large mesh.

use super::stage::{
    BLUE, BROWN, Doorway, GREEN, GREY, RED, RED_SHEET, Stage, WHITE, YELLOW, alone, finished, sheet,
};
use crate::BuiltIn;
use crate::camera::{camera, camera_with_fov};
use crate::envelope::{Side, envelope};
use crate::random::Random;
use crate::shape::{Shape, ball, block, cuboid, taper};
use enfilade::{Method, SceneBuilder, Transform};
use glam::{Vec3, vec3};

/// A scene scaled and translated: every corner is `offset` + `scale` × its original position.
#[derive(Clone, Copy)]
struct Resized {
    scale: f32,
    offset: Vec3,
}

impl Resized {
    fn at(self, point: Vec3) -> Vec3 {
        self.offset + self.scale * point
    }

    fn shape(self, shape: Shape) -> Shape {
        shape.bent(|corner| self.at(corner))
    }

    /// Builds two rooms with a door, boxes in both, and a tower visible through the door.
    fn world(self) -> BuiltIn {
        let door = Doorway {
            name: "door",
            side: Side::East,
            plane: 0.0,
            along: [-0.75, 0.75],
            up: [0.0, 2.0],
        };
        let mut scene = SceneBuilder::new();
        let mut ends = Vec::new();
        for (name, x, door) in [
            ("west", [-5.0, -0.125], door),
            ("east", [0.125, 5.0], door.other_side()),
        ] {
            let mut stage = Stage::new();
            let inside = envelope(x, [-2.5, 2.5], 3.0, &[door]);
            stage.thing("floor", &self.shape(inside.floor));
            for wall in inside.walls {
                stage.thing("wall", &self.shape(wall));
            }
            stage.thing("ceiling", &self.shape(inside.ceiling));
            let middle = 0.5 * (x[0] + x[1]);
            for (i, material) in [RED, BLUE, YELLOW].into_iter().enumerate() {
                let at = vec3(middle + 1.2 * (i as f32 - 1.0), 0.0, -1.5 + 1.4 * i as f32);
                let place =
                    Transform::translation(self.at(at).to_array()) * Transform::scaling([self.scale; 3]);
                stage.placed("box", &cuboid(material, [0.5, 0.75 + 0.5 * i as f32, 0.5]), place);
            }
            let at = self.at(vec3(middle, 2.4, 0.0)).to_array();
            let place = Transform::translation(at) * Transform::scaling([self.scale; 3]);
            stage.placed("lamp", &ball(GREEN, 0.25, 8, 12), place);
            let outline: Vec<Vec3> = door.outline().into_iter().map(|corner| self.at(corner)).collect();
            let opening = stage.opening(door.name, &outline);
            ends.push((scene.add(name, stage.build(), Method::HierarchicalZ), opening));
        }
        scene.door(ends[0], ends[1]);
        let camera = |name: &str, eye: Vec3, toward: Vec3| {
            camera(name, self.at(eye).to_array(), self.at(toward).to_array())
        };
        finished(
            scene,
            vec![
                camera("in line", vec3(-4.5, 1.5, 0.25), vec3(5.0, 1.0, 0.0)),
                camera("aslant", vec3(-4.0, 2.0, 2.0), vec3(0.5, 1.0, -0.5)),
                camera("at the door", vec3(-0.25, 1.5, 0.0), vec3(4.0, 1.0, 0.5)),
                camera("way back", vec3(4.5, 1.5, -1.0), vec3(-5.0, 1.0, 0.5)),
            ],
        )
    }
}

/// Two rooms a million units wide, millions of units from the origin.
pub(crate) fn huge() -> BuiltIn {
    Resized {
        scale: 2.0e5,
        offset: vec3(5.0e6, 1.0e6, -7.0e6),
    }
    .world()
}

/// Two rooms of some fifty units, a million units from the origin, where adjacent f32 values differ by an eighth of a
/// unit: a wall is ten such steps thick.
pub(crate) fn far_away() -> BuiltIn {
    Resized {
        scale: 10.0,
        offset: vec3(1.0e6, 0.0, -2.0e6),
    }
    .world()
}

/// The same two rooms, ten thousand times smaller than usual.
pub(crate) fn tiny() -> BuiltIn {
    Resized {
        scale: 1.0e-4,
        offset: Vec3::ZERO,
    }
    .world()
}

/// About three thousand copies of four meshes.
///
/// Most are in a field behind three walls with gaps, through which some are visible; some are in the open; far away
/// there are heaps of pebbles, each about a pixel large.
pub(crate) fn crowd() -> BuiltIn {
    let mut random = Random::new(11);
    let mut stage = Stage::new();
    stage.thing(
        "ground",
        &sheet(
            GREY,
            vec3(-60.0, 0.0, 10.0),
            vec3(120.0, 0.0, 0.0),
            vec3(0.0, 0.0, -130.0),
        ),
    );
    for (i, z) in [-2.0, -14.0, -30.0].into_iter().enumerate() {
        for part in -3..=3 {
            let [left, right] = [0.2, 9.6].map(|edge| 10.0 * part as f32 - 5.0 + edge);
            let high = 2.4 + i as f32;
            stage.thing("wall", &block(WHITE, [left, 0.0, z - 0.3], [right, high, z]));
        }
    }
    let kinds = [
        ("cone", taper(RED, [0.7, 0.7], 1.3, [0.0, 0.0])),
        ("box", cuboid(BLUE, [0.6, 0.9, 0.6])),
        ("ball", ball(YELLOW, 0.4, 6, 9)),
    ];
    for (name, shape) in kinds {
        let places: Vec<Transform> = (0..800)
            .map(|_| {
                let at = [random.between(-35.0, 35.0), 0.4, random.between(-45.0, 6.0)];
                let turn = Transform::rotation([0.0, 1.0, 0.0], f64::from(random.between(-3.0, 3.0)));
                Transform::translation(at) * turn * Transform::scaling([random.between(0.5, 1.2); 3])
            })
            .collect();
        stage.copies(name, &shape.mesh(), places);
    }
    let pebbles: Vec<Transform> = (0..600)
        .map(|_| {
            let at = [
                random.between(-30.0, 30.0),
                random.between(0.0, 9.0),
                random.between(-112.0, -90.0),
            ];
            Transform::translation(at) * Transform::scaling([random.between(0.3, 2.0); 3])
        })
        .collect();
    stage.copies("pebble", &ball(RED_SHEET, 0.12, 3, 5).mesh(), pebbles);
    alone(
        stage,
        vec![
            camera("over the field", [0.0, 7.0, 9.0], [0.0, 0.0, -25.0]),
            camera("before the wall", [2.0, 1.6, 3.0], [1.0, 1.4, -20.0]),
            camera("at a gap", [4.95, 1.6, 0.0], [5.3, 1.4, -20.0]),
            camera("among them", [0.3, 1.6, -8.0], [12.0, 1.2, -20.0]),
            camera_with_fov("pebbles", [0.0, 6.0, -44.0], [0.0, 4.0, -100.0], 40.0),
        ],
    )
}

/// One mesh of twenty thousand triangles: hills that occlude each other and the boxes between them.
pub(crate) fn big_mesh() -> BuiltIn {
    const CELLS: usize = 100;
    let height = |x: f32, z: f32| {
        let wave = |ax: f32, az: f32, phase: f32| (f64::from(ax * x + az * z + phase)).sin() as f32;
        1.6 * wave(0.31, 0.17, 0.4)
            + 1.1 * wave(-0.23, 0.41, 1.9)
            + 0.5 * wave(0.83, -0.6, 0.0)
            + 0.2 * wave(1.9, 1.3, 2.2)
    };
    let point = |i: usize, j: usize| {
        let [x, z] = [i, j].map(|step| 0.6 * step as f32 - 30.0);
        vec3(x, height(x, z), z)
    };
    let mut hills = Shape::new();
    for i in 0..CELLS {
        for j in 0..CELLS {
            let [a, b, c, d] = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
            let material = if a.y > 1.4 {
                WHITE
            } else if a.y > -0.6 {
                GREEN
            } else {
                BROWN
            };
            hills.triangle(material, [a, b, c]);
            hills.triangle(material, [a, c, d]);
        }
    }
    let mut stage = Stage::new();
    stage.thing("hills", &hills);
    for i in 0..60 {
        let [x, z] = [(i % 10) as f32 * 5.6 - 25.0, (i / 10) as f32 * 8.5 - 22.0];
        let place = Transform::translation([x, height(x, z), z]);
        stage.placed(
            "house",
            &cuboid([RED, BLUE, YELLOW][i % 3], [0.8, 0.9, 0.8]),
            place,
        );
    }
    let eye = |x: f32, z: f32, over: f32| [x, height(x, z) + over, z];
    alone(
        stage,
        vec![
            camera("valley", eye(2.0, 3.0, 1.2), eye(-20.0, -20.0, 0.5)),
            camera("hilltop", eye(-10.0, 14.0, 3.0), eye(10.0, -20.0, 0.0)),
            camera("from the edge", eye(29.0, 29.0, 1.0), [0.0, 0.0, 0.0]),
            camera("from above", [0.0, 40.0, 10.0], [0.0, 0.0, 0.0]),
        ],
    )
}
