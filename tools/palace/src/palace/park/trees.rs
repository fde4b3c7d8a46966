//! Alpha-tested trees: boughs on cards around a trunk.

use super::ground::{Ground, to_the_basin, to_the_edge};
use super::{AXIS, KNOLL};
use crate::palace::palette::{
    BARK, DARK_BOUGHS, IVORY, LONG_GRASS, PALE_BOUGHS, RED_SILK, YELLOW_SILK, dress,
};
use crate::palace::room::{Room, scaled};
use crate::palace::rooms::court::flower_bed;
use crate::palace::workshop::Workshop;
use crate::shape::{Shape, tube};
use enfilade::{Attributes, MaterialId, Mesh, Part, Transform};
use enfilade_scenes::Random;
use glam::{Vec2, Vec3, vec2, vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Shape of a tree one metre tall: half width and half height of its crown, height of the crown's middle, size of its
/// boughs, and their number.
struct Habit {
    kind: &'static str,
    leaves: MaterialId,
    crown: [f32; 2],
    middle: f32,
    bough: f32,
    count: usize,
}

/// The kinds of trees; the last one is slim.
const HABITS: [Habit; 4] = [
    Habit {
        kind: "lime",
        leaves: PALE_BOUGHS,
        crown: [0.30, 0.32],
        middle: 0.62,
        bough: 0.225,
        count: 32,
    },
    Habit {
        kind: "oak",
        leaves: PALE_BOUGHS,
        crown: [0.40, 0.28],
        middle: 0.66,
        bough: 0.245,
        count: 34,
    },
    Habit {
        kind: "beech",
        leaves: DARK_BOUGHS,
        crown: [0.33, 0.33],
        middle: 0.62,
        bough: 0.235,
        count: 32,
    },
    Habit {
        kind: "poplar",
        leaves: DARK_BOUGHS,
        crown: [0.11, 0.42],
        middle: 0.55,
        bough: 0.15,
        count: 30,
    },
];

/// A tree one metre tall. Normals follow the crown's ellipsoid.
fn grown(shop: &mut Workshop, habit: &Habit) -> Arc<Mesh> {
    shop.mesh(habit.kind.to_owned(), || {
        let mut random = Random::new(habit.count as u64 + u64::from(habit.leaves.0));
        let mut boughs = Boughs::default();
        let [wide, high] = habit.crown;
        for number in 0..habit.count {
            // Evenly distributed over the crown by the golden angle.
            let up = 1.0 - 2.0 * (number as f32 + 0.5) / habit.count as f32;
            let (sin, cos) = (2.399_963_f64 * number as f64).sin_cos();
            let level = (1.0 - up * up).sqrt();
            let out = vec3(level * cos as f32, up, level * sin as f32);
            let deep = if number % 3 == 0 { 0.45 } else { 0.80 };
            let at = vec3(0.0, habit.middle, 0.0) + out * vec3(wide, high, wide) * deep;
            let facing = (out + Vec3::from(random.point(0.75))).normalize_or(Vec3::Y);
            boughs.add(at, facing, out, habit.bough * random.between(0.85, 1.25));
        }
        boughs.mesh(habit)
    })
}

/// Cards, each of two faces back to back.
#[derive(Default)]
struct Boughs {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    corners: Vec<u32>,
}

impl Boughs {
    fn add(&mut self, at: Vec3, facing: Vec3, out: Vec3, half: f32) {
        let right = Vec3::Y.cross(facing).normalize_or(Vec3::X);
        let up = facing.cross(right);
        // Shading flips a normal that points away from the eye, so each side has its normal on its own side.
        for front in [facing, -facing] {
            let first = self.positions.len() as u32;
            let round = out + Vec3::Y * 0.55;
            let away = round.dot(front).min(0.0);
            let normal = (round - front * (1.05 * away)).normalize_or(front);
            for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                self.positions.push((at + (right * x + up * y) * half).to_array());
                self.normals.push(normal.to_array());
                self.texture.push([0.5 + 0.5 * x, 0.5 - 0.5 * y]);
            }
            let mut quad = [0, 1, 2, 3].map(|corner| first + corner);
            if front != facing {
                quad.reverse();
            }
            self.corners.extend(quad);
        }
    }

    /// Adds a trunk that reaches into the crown.
    fn mesh(&self, habit: &Habit) -> Arc<Mesh> {
        let sides = vec![4; self.corners.len() / 4];
        let part = Part {
            positions: &self.positions,
            corners: &self.corners,
            sides: Some(&sides),
            material: habit.leaves,
            attributes: Attributes {
                normals: &self.normals,
                texture: &self.texture,
                ..Attributes::default()
            },
        };
        let thick = 0.014 + 0.02 * habit.crown[0];
        let path = [
            Vec3::Y * -0.03,
            vec3(0.006, 0.5 * habit.middle, 0.004),
            Vec3::Y * habit.middle,
        ];
        let trunk = tube(BARK, &path, |t| thick * (1.25 - 0.7 * t), 7).dressed(dress);
        let faces = (0..trunk.face_count()).flat_map(|face| trunk.face(face));
        let wood = Part {
            positions: trunk.positions(),
            corners: &faces.copied().collect::<Vec<u32>>(),
            sides: None,
            material: BARK,
            attributes: Attributes {
                texture: trunk.texture(),
                normals: trunk.normals(),
                ..Attributes::default()
            },
        };
        Arc::new(Mesh::new(&[wood, part]).expect("cards are flat"))
    }
}

/// Woods on the hills at the edges, rows of trees beside the lawn, single ones in between.
pub(super) fn plant(room: &mut Room, ground: &Ground) {
    let kinds = HABITS.map(|habit| grown(room.shop, &habit));
    let mut random = Random::new(177);
    let mut trees: Vec<Vec2> = Vec::new();
    for _ in 0..2600 {
        let at = vec2(random.between(-118.0, -9.0), random.between(-175.0, -94.0));
        let edge = to_the_edge(at);
        let in_the_wood = edge > 1.2 && edge < 15.0 + 4.0 * (0.2 * (at.x + at.y)).sin();
        let apart = if edge < 9.0 { 3.6 } else { 5.0 };
        if !in_the_wood || is_cleared(at) || trees.iter().any(|tree| tree.distance(at) < apart) {
            continue;
        }
        trees.push(at);
    }
    for at in SINGLE.map(Vec2::from) {
        trees.push(at);
    }
    for (number, at) in trees.into_iter().enumerate() {
        let kind = [0, 1, 2, 1, 3, 0, 2][number % 7];
        let tall = random.between(6.5, 9.5) + if kind == 3 { 2.5 } else { 0.0 };
        let turn = random.between(0.0, 360.0);
        stand(room, "tree of the wood", &kinds[kind], ground.on(at), turn, tall);
    }
    for side in [-1.0, 1.0] {
        for i in 0..6 {
            let at = vec2(-31.0 - 8.5 * i as f32, AXIS + 13.5 * side);
            let (turn, tall) = (random.between(0.0, 360.0), random.between(5.6, 6.4));
            stand(room, "tree of the walk", &kinds[0], ground.on(at), turn, tall);
        }
    }
    long_grass(room, ground);
    wild_flowers(room, ground);
}

/// Solitary trees in the meadows: x and z.
const SINGLE: [[f32; 2]; 14] = [
    [-36.0, -140.0],
    [-44.5, -136.5],
    [-58.0, -139.0],
    [-66.0, -152.0],
    [-72.0, -136.0],
    [-84.0, -140.5],
    [-95.0, -135.0],
    [-100.0, -124.5],
    [-101.5, -109.0],
    [-90.0, -99.5],
    [-80.5, -101.0],
    [-68.0, -104.0],
    [-33.0, -154.0],
    [-48.0, -157.0],
];

/// Returns `true` for positions kept clear of trees: the views along the axis and from the hill, and the strip along
/// the walls.
fn is_cleared(at: Vec2) -> bool {
    let view = HILL_VIEW[1] - HILL_VIEW[0];
    let off = at - HILL_VIEW[0];
    let part = off.dot(view) / view.length_squared();
    let beside = off.perp_dot(view).abs() / view.length();
    let in_view = part > -0.05 && beside < 3.0 + 14.0 * part.max(0.0);
    // Crowns must not extend beyond the walls.
    let at_the_walls = at.x > -14.5 || at.y > -98.5;
    in_view || at_the_walls || at.distance(KNOLL) < 10.0
}

/// A viewpoint above the garden, and its target.
const HILL_VIEW: [Vec2; 2] = [vec2(-104.0, -158.0), vec2(-60.0, -122.0)];

fn stand(room: &mut Room, thing: &str, mesh: &Arc<Mesh>, at: Vec3, degrees: f32, size: f32) {
    let turned = Transform::rotation([0.0, 1.0, 0.0], f64::from(degrees).to_radians());
    room.put(
        thing,
        mesh,
        Transform::translation(at.into()) * turned * scaled(size),
    );
}

/// Tufts of long grass in the meadows, grouped by squares.
fn long_grass(room: &mut Room, ground: &Ground) {
    const SQUARE: f32 = 14.0;
    let mut random = Random::new(523);
    for row in 0..4 {
        for column in 0..6 {
            let corner = vec2(-112.0 + SQUARE * column as f32, -166.0 + SQUARE * row as f32);
            let mut shape = Shape::new();
            let mut tufts = 0;
            for _ in 0..150 {
                let at = corner + SQUARE * vec2(random.unit(), random.unit());
                let [turn, high] = [random.unit(), random.between(0.28, 0.6)];
                let mown = (at.y - AXIS).abs() < 17.0 || at.x > -30.0 || at.distance(KNOLL) < 14.0;
                if mown || to_the_basin(at) < 1.3 {
                    continue;
                }
                tuft(&mut shape, ground.on(at), turn, high);
                tufts += 1;
            }
            if tufts > 0 {
                room.make("long grass", &shape);
            }
        }
    }
}

/// Flowers in the valley.
fn wild_flowers(room: &mut Room, ground: &Ground) {
    let mut random = Random::new(811);
    let colors = [RED_SILK, YELLOW_SILK, IVORY];
    for number in 0..14 {
        let at = vec2(random.between(-84.0, -52.0), AXIS - random.between(22.0, 33.0));
        let color = colors[number % 3];
        let patch = flower_bed(room.shop, color);
        stand(
            room,
            "wild flowers",
            &patch,
            ground.on(at) - Vec3::Y * 0.08,
            random.between(0.0, 360.0),
            1.1,
        );
    }
}

/// Two intersecting cards.
fn tuft(shape: &mut Shape, at: Vec3, turn: f32, high: f32) {
    for quarter in [0.0, 0.25] {
        let (sin, cos) = (TAU * f64::from(turn + quarter)).sin_cos();
        let along = vec3(cos as f32, 0.0, sin as f32) * high;
        let [foot, top] = [at - Vec3::Y * 0.04, at + Vec3::Y * high];
        shape.placed(
            LONG_GRASS,
            &[foot - along, foot + along, top + along, top - along],
            &[vec2(0.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 0.0), vec2(0.0, 0.0)],
        );
    }
}
