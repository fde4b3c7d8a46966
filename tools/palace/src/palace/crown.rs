//! Trees: a crown of rounded masses, boughs on cards that break its outline, and a branched trunk.

use super::palette::{BARK, dress};
use super::sculpt::{Carved, carve, egg, joined, slope};
use super::statue::bezier;
use super::workshop::Workshop;
use crate::shape::{Shape, tube};
use enfilade::{Attributes, Indices, MaterialId, Mesh, Part, Vertices};
use enfilade_scenes::Random;
use glam::{Vec3, vec3};
use std::sync::Arc;

/// Shape of a tree; lengths in metres, or in parts of its height if it is scaled where it stands.
pub(crate) struct Habit {
    pub(crate) kind: &'static str,
    /// The boughs on cards, and the masses of leaves behind them.
    pub(crate) boughs: MaterialId,
    pub(crate) leaves: MaterialId,
    /// Half width and half height of the crown, and the height of its middle.
    pub(crate) crown: [f32; 2],
    pub(crate) middle: f32,
    /// Number of masses, and their mean radius.
    pub(crate) masses: usize,
    pub(crate) mass: f32,
    /// Number of cards, and half their mean size.
    pub(crate) cards: usize,
    pub(crate) card: f32,
    /// Radius of the trunk at its foot, and number of branches.
    pub(crate) trunk: f32,
    pub(crate) branches: usize,
    /// Maximum number of triangles of the masses.
    pub(crate) faces: usize,
    /// Repetitions of the texture of leaves.
    pub(crate) per_length: f32,
}

/// A ball of leaves.
struct Mass {
    at: Vec3,
    radius: f32,
}

/// A tree of this habit at the origin.
pub(crate) fn grown(shop: &mut Workshop, habit: &Habit, seed: u64) -> Arc<Mesh> {
    shop.mesh(format!("{} {seed}", habit.kind), || {
        let mut random = Random::new(seed);
        let masses = masses(habit, &mut random);
        let field = |at: Vec3| leaves(habit, &masses, at);
        let [wide, high] = habit.crown;
        let reach = vec3(wide, high, wide) + 1.2 * habit.mass;
        let middle = Vec3::Y * habit.middle;
        let crown = carve(
            [middle - reach, middle + reach],
            habit.mass / 5.0,
            habit.faces,
            field,
        );
        let mut boughs = Boughs::default();
        for number in 0..habit.cards {
            let out = toward(number, habit.cards, &mut random);
            let at = surface(middle, out * vec3(wide, high, wide), field);
            let normal = slope(at, 0.1 * habit.mass, &field).normalize_or(Vec3::Y);
            // Half of them cover the masses; the others are steeper, so that leaves stick out of the outline.
            let aside = normal.cross(Vec3::from(random.point(1.0))).normalize_or(Vec3::X);
            let tilt = if number % 2 == 0 { 0.45 } else { 1.6 };
            let facing = (normal + tilt * aside).normalize();
            let half = habit.card * random.between(0.75, 1.25);
            boughs.add(at + normal * 0.15 * half, facing, normal, half);
        }
        mesh(habit, &crown, &boughs, &trunk(habit, &masses))
    })
}

/// Returns directions spread evenly by the golden angle, a little disturbed.
fn toward(number: usize, count: usize, random: &mut Random) -> Vec3 {
    let up = 1.0 - 2.0 * (number as f32 + 0.5) / count as f32;
    let (sin, cos) = (2.399_963_f64 * number as f64).sin_cos();
    let level = (1.0 - up * up).sqrt();
    let out = vec3(level * cos as f32, up, level * sin as f32);
    (out + 0.12 * Vec3::from(random.point(1.0))).normalize_or(Vec3::Y)
}

fn masses(habit: &Habit, random: &mut Random) -> Vec<Mass> {
    let [wide, high] = habit.crown;
    (0..habit.masses)
        .map(|number| {
            let out = toward(number, habit.masses, random);
            // Lower masses are farther in, where there is less light.
            let deep = 0.72 + 0.10 * out.y + random.between(-0.08, 0.08);
            Mass {
                at: Vec3::Y * habit.middle + out * vec3(wide, high, wide) * deep,
                radius: habit.mass * random.between(0.8, 1.2),
            }
        })
        .collect()
}

/// The field of the crown.
fn leaves(habit: &Habit, masses: &[Mass], at: Vec3) -> f32 {
    let [wide, high] = habit.crown;
    let core = egg(at, Vec3::Y * habit.middle, 0.66 * vec3(wide, high, wide));
    let crown = (masses.iter())
        .map(|mass| at.distance(mass.at) - mass.radius)
        .fold(core, |crown, mass| joined(crown, mass, 0.30 * habit.mass));
    let p = at * (5.0 / habit.mass);
    let lumps = (p.x + p.y.sin()).sin() * (p.y + p.z.sin()).sin() * (p.z + p.x.sin()).sin();
    0.8 * (crown - 0.10 * habit.mass * lumps)
}

/// Returns the point where a ray from inside leaves the crown.
fn surface(from: Vec3, along: Vec3, field: impl Fn(Vec3) -> f32) -> Vec3 {
    let [mut inside, mut outside] = [0.0_f32, 2.0];
    for _ in 0..16 {
        let middle = 0.5 * (inside + outside);
        if field(from + along * middle) < 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    from + along * inside
}

/// A trunk that reaches into the crown, with branches to some of its lower masses.
fn trunk(habit: &Habit, masses: &[Mass]) -> Shape {
    // Trees of the woods are many and far.
    let is_near = habit.branches > 2;
    let thick = habit.trunk;
    let bend = 0.35 * thick;
    let path = bezier(
        [
            Vec3::Y * (-0.5 * thick),
            vec3(bend, 0.3 * habit.middle, 0.6 * bend),
            vec3(-bend, 0.7 * habit.middle, bend),
            Vec3::Y * habit.middle,
        ],
        if is_near { 6 } else { 3 },
    );
    // The foot spreads into the roots.
    let mut shape = tube(
        BARK,
        &path,
        |t| thick * (0.78 - 0.38 * t + 0.35 * (1.0 - 5.0 * t).max(0.0)),
        if is_near { 9 } else { 6 },
    );
    let fork = habit.middle - 0.72 * habit.crown[1];
    let mut low: Vec<&Mass> = masses.iter().collect();
    low.sort_by(|a, b| a.at.y.total_cmp(&b.at.y));
    for mass in low.into_iter().step_by(2).take(habit.branches) {
        let from = Vec3::Y * fork.max(0.3 * habit.middle);
        let bow = from.lerp(mass.at, 0.35) + Vec3::Y * 0.05 * habit.crown[1];
        let branch = bezier([from, bow, bow, mass.at], if is_near { 4 } else { 2 });
        shape.join(tube(
            BARK,
            &branch,
            |t| thick * (0.42 - 0.26 * t),
            if is_near { 6 } else { 4 },
        ));
    }
    shape
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
            let round = out + Vec3::Y * 0.35;
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
}

/// Returns texture coordinates by longitude and latitude, mirrored from front to back, so that there is no seam.
fn places(habit: &Habit, crown: &Carved) -> Vec<[f32; 2]> {
    let [wide, high] = habit.crown.map(|half| half * habit.per_length);
    (crown.positions.iter())
        .map(|&[x, y, z]| {
            let level = x.hypot(z) / habit.crown[0];
            let up = (y - habit.middle) / habit.crown[1];
            [wide * z.abs().atan2(x), -high * up.atan2(level)]
        })
        .collect()
}

fn mesh(habit: &Habit, crown: &Carved, boughs: &Boughs, wood: &Shape) -> Arc<Mesh> {
    let sides = vec![4; boughs.corners.len() / 4];
    let cards = Part {
        positions: Vertices::Packed(&boughs.positions),
        corners: Indices::U32(&boughs.corners),
        sides: Some(&sides),
        material: habit.boughs,
        attributes: Attributes {
            normals: Vertices::Packed(&boughs.normals),
            texture: Vertices::Packed(&boughs.texture),
            ..Attributes::default()
        },
    };
    let texture = places(habit, crown);
    let mass = Part {
        positions: Vertices::Packed(&crown.positions),
        corners: Indices::U32(&crown.corners),
        sides: None,
        material: habit.leaves,
        attributes: Attributes {
            normals: Vertices::Packed(&crown.normals),
            texture: Vertices::Packed(&texture),
            ..Attributes::default()
        },
    };
    let wood = wood.dressed(dress);
    let faces = (0..wood.face_count()).flat_map(|face| wood.face(face));
    let corners: Vec<u32> = faces.copied().collect();
    let trunk = Part {
        positions: Vertices::Packed(wood.positions()),
        corners: Indices::U32(&corners),
        sides: None,
        material: BARK,
        attributes: Attributes {
            texture: Vertices::Packed(wood.texture()),
            normals: Vertices::Packed(wood.normals()),
            ..Attributes::default()
        },
    };
    Arc::new(Mesh::new(&[trunk, mass, cards]).expect("cards are flat"))
}
