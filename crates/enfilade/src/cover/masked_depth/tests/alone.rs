//! The buffer without a scene, compared sample by sample with the same triangles in f64.

use super::*;
use crate::chance::levels;
use crate::geom::MAX_COORDINATE;

/// A world of instances, and what it is viewed with.
struct World {
    view: View,
    passage: Passage,
    meshes: Vec<OccluderMesh>,
    /// Instances: index of the mesh and transform.
    instances: Vec<(usize, Transform)>,
    oracle: Oracle,
}

/// A random transform: rotated, scaled unevenly, sometimes mirrored or flattened.
fn random_transform(dice: &mut Dice, at: DVec3, size: f64) -> Transform {
    let turn = Transform::rotation(dice.direction().as_vec3().into(), dice.between(0.0, 6.0));
    let mut scale = [(); 3].map(|()| (size * dice.by_ratio(0.3, 3.0)) as f32);
    if dice.roll() < 0.3 {
        scale[dice.below(3)] *= -1.0;
    }
    if dice.roll() < 0.05 {
        scale[dice.below(3)] = 0.0;
    }
    Transform::translation(at.as_vec3().into()) * turn * Transform::scaling(scale)
}

impl World {
    /// Meshes of a few random triangles, all around the eye; some cross the near plane.
    fn random(seed: u64, size: [u32; 2]) -> World {
        let mut dice = Dice::new(seed + 9000);
        let eye = dice.point(20.0).as_vec3();
        let mut view = View::new(eye.into(), (eye + dice.direction().as_vec3()).into(), size);
        view.near = dice.by_ratio(0.01, 0.5) as f32;
        view.fov_y = dice.between(0.3, 2.2) as f32;
        let passage = Passage::at_the_eye(&view, SectorId(0), true);
        let mut oracle = Oracle::new(&passage);
        let (mut meshes, mut triangles) = (Vec::new(), Vec::new());
        for number in 0..4 {
            let count = 1 + dice.below(8);
            let positions: Vec<[f32; 3]> = (0..3 * count).map(|_| dice.point(1.0).as_vec3().into()).collect();
            let indices: Vec<u32> = (0..3 * count as u32).collect();
            let mut mesh = OccluderMesh::triangles(&positions, &indices).expect("sound triangles");
            mesh.double_sided = number == 0;
            meshes.push(mesh);
            triangles.push(positions);
        }
        let ahead = DVec3::from(view.toward.map(f64::from)) - DVec3::from(view.eye.map(f64::from));
        let mut instances = Vec::new();
        for _ in 0..12 {
            let distance = dice.by_ratio(0.05, 40.0);
            let at = eye.as_dvec3() + (ahead + 0.6 * dice.direction()) * distance;
            let reach = distance * dice.by_ratio(0.05, 1.5);
            let transform = random_transform(&mut dice, at, reach);
            let mesh = dice.below(meshes.len());
            instances.push((mesh, transform));
            for corners in triangles[mesh].as_chunks::<3>().0 {
                oracle.add_instance(corners, &transform, meshes[mesh].double_sided, &passage);
            }
        }
        World {
            view,
            passage,
            meshes,
            instances,
            oracle,
        }
    }

    /// Whether any sample's ray goes through something between two distances, and whether any sample shows it.
    fn shows(&self, through: impl Fn(u16, u16) -> Option<[f64; 2]>) -> [bool; 2] {
        let mut shows = [false; 2];
        for (x, y) in samples(self.oracle.all()) {
            if let Some(at) = through(x, y) {
                shows[0] |= at[1] > self.oracle.near;
                shows[1] |= self.oracle.sees_between(x, y, at);
            }
        }
        shows
    }

    fn drawn(&self, level: Level) -> OcclusionBuffer {
        let mut buffer = OcclusionBuffer::at(level);
        buffer.begin(&self.view);
        buffer.draw_all(self.instances.iter().map(|&(mesh, at)| (&self.meshes[mesh], at)));
        buffer
    }

    /// Returns a point somewhere around what is in view.
    fn point(&self, dice: &mut Dice) -> DVec3 {
        let [eye, toward] = [self.view.eye, self.view.toward].map(|at| DVec3::from(at.map(f64::from)));
        eye + (toward - eye + 0.5 * dice.direction()) * dice.by_ratio(0.02, 80.0)
    }
}

impl Oracle {
    /// Adds a triangle of an instance unless the eye sees its back.
    fn add_instance(&mut self, corners: &[[f32; 3]; 3], at: &Transform, both: bool, passage: &Passage) {
        let local = corners.map(|corner| DVec3::from(corner.map(f64::from)));
        let placed = local.map(|corner| at.0.transform_point3(corner));
        let [a, b, c] = placed;
        let normal = (b - a).cross(c - a);
        let side = normal.dot(DVec3::from(passage.eye()) - a);
        let is_front = if at.mirrors() { side < 0.0 } else { side > 0.0 };
        if both || is_front {
            self.add(&Polygon::new(&placed, passage));
        }
    }

    /// Whether a sample may show something between two distances along its ray, in units of W.
    fn sees_between(&self, x: u16, y: u16, [enter, leave]: [f64; 2]) -> bool {
        let enter = enter.max(self.near);
        enter <= leave && 1.0 / enter >= self.rev_depth[self.at(x, y)]
    }
}

/// Returns where the ray of a sample enters and leaves a box, in units of W.
fn through_box(passage: &Passage, bounds: &Aabb, x: u16, y: u16) -> Option<[f64; 2]> {
    let [eye, ray] = passage.ray([f64::from(x) + 0.5, f64::from(y) + 0.5]);
    let [mut enter, mut leave] = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..3 {
        let [low, high] = [bounds.min, bounds.max].map(|corner| f64::from(corner[axis]) - eye[axis]);
        let [a, b] = [low / ray[axis], high / ray[axis]];
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter <= leave).then_some([enter, leave])
}

/// Returns where the ray of a sample enters and leaves a sphere, in units of W.
fn through_sphere(passage: &Passage, (center, radius): &([f32; 3], f32), x: u16, y: u16) -> Option<[f64; 2]> {
    let [eye, ray] = passage
        .ray([f64::from(x) + 0.5, f64::from(y) + 0.5])
        .map(DVec3::from);
    let to = DVec3::from(center.map(f64::from)) - eye;
    let middle = to.dot(ray) / ray.length_squared();
    let off = (to - ray * middle).length_squared();
    let half = (f64::from(*radius).powi(2) - off).max(-1.0);
    (half >= 0.0).then(|| {
        let half = (half / ray.length_squared()).sqrt();
        [middle - half, middle + half]
    })
}

fn bits(visible: &[u64], count: usize) -> Vec<bool> {
    (0..count)
        .map(|bit| visible[bit / 64] >> (bit % 64) & 1 == 1)
        .collect()
}

fn boxes(buffer: &OcclusionBuffer, boxes: &[Aabb]) -> Vec<bool> {
    let mut visible = vec![u64::MAX; boxes.len().div_ceil(64)];
    buffer.test_boxes(boxes, &mut visible);
    bits(&visible, boxes.len())
}

fn spheres(buffer: &OcclusionBuffer, spheres: &[([f32; 3], f32)]) -> Vec<bool> {
    let mut visible = vec![u64::MAX; spheres.len().div_ceil(64)];
    buffer.test_spheres(spheres, &mut visible);
    bits(&visible, spheres.len())
}

fn random_boxes(world: &World, dice: &mut Dice, count: usize) -> Vec<Aabb> {
    let eye = DVec3::from(world.view.eye.map(f64::from));
    (0..count)
        .map(|_| {
            let at = world.point(dice);
            let mut size = (at - eye).length() * dice.by_ratio(0.003, 0.5) * dice.direction();
            match dice.below(10) {
                0 => size.x = 0.0,
                1 => size = DVec3::ZERO,
                _ => {}
            }
            Aabb::of([at, at + size].map(|corner| corner.as_vec3().into()))
        })
        .collect()
}

const SIZES: [[u32; 2]; 9] = [
    [160, 90],
    [1, 1],
    [33, 17],
    [7, 211],
    [96, 97],
    [128, 64],
    [4096, 3],
    [2, 4096],
    [65, 193],
];

#[test]
fn a_box_or_a_sphere_is_hidden_only_if_no_sample_shows_it() {
    // Of those that a ray reaches if nothing is in the way.
    let [mut hidden, mut known, mut shown] = [[0_u32; 2]; 3];
    for seed in 0..72 {
        let world = World::random(seed, SIZES[seed as usize % SIZES.len()]);
        let mut dice = Dice::new(seed);
        let buffer = world.drawn(Level::new());
        let asked = random_boxes(&world, &mut dice, 150);
        let round: Vec<([f32; 3], f32)> = asked
            .iter()
            .map(|bounds| (bounds.center(), 0.5 * bounds.longest_side()))
            .collect();
        let answers = boxes(&buffer, &asked).into_iter().zip(spheres(&buffer, &round));
        for ((bounds, sphere), (sees_box, sees_sphere)) in asked.iter().zip(&round).zip(answers) {
            let truth = [
                world.shows(|x, y| through_box(&world.passage, bounds, x, y)),
                world.shows(|x, y| through_sphere(&world.passage, sphere, x, y)),
            ];
            for (kind, (seen, [in_view, truth])) in [sees_box, sees_sphere].into_iter().zip(truth).enumerate()
            {
                assert!(seen || !truth, "{bounds:?} or {sphere:?} of scene {seed}");
                hidden[kind] += u32::from(in_view && !seen);
                known[kind] += u32::from(in_view && !truth);
                shown[kind] += u32::from(truth);
            }
        }
    }
    let all = format!("{hidden:?} of {known:?} are hidden, {shown:?} are visible");
    for kind in 0..2 {
        assert!(hidden[kind] > 300 && shown[kind] > 1000, "{all}");
        assert!(hidden[kind] * 100 > known[kind] * 60, "{all}");
    }
}

#[test]
fn nothing_drawn_is_nearer_than_its_triangles_at_any_size() {
    let mut covered = 0_u64;
    for seed in 0..54 {
        let world = World::random(seed + 100, SIZES[seed as usize % SIZES.len()]);
        let depth = world.drawn(Level::new()).depth();
        assert_eq!(depth.len(), world.oracle.rev_depth.len());
        for (place, (&stored, &truth)) in depth.iter().zip(&world.oracle.rev_depth).enumerate() {
            assert!(
                f64::from(stored) <= truth,
                "sample {place} of scene {seed}: {stored} for {truth}"
            );
            covered += u64::from(stored > 0.0);
        }
    }
    assert!(covered > 100_000, "{covered}");
}

#[test]
fn draws_and_tests_have_the_same_bits_by_any_threads_and_simd_level() {
    let mut hidden = 0;
    for seed in 0..12 {
        let world = World::random(seed + 200, [331, 407]);
        let mut dice = Dice::new(seed);
        let asked = random_boxes(&world, &mut dice, 1500);
        let round: Vec<([f32; 3], f32)> = asked.iter().map(|b| (b.center(), b.longest_side())).collect();
        let all = |level: Level, parallel: bool| {
            let mut buffer = world.drawn(level);
            buffer.parallel = parallel;
            let depth: Vec<u32> = buffer.depth().iter().map(|depth| depth.to_bits()).collect();
            (depth, boxes(&buffer, &asked), spheres(&buffer, &round))
        };
        let expected = all(Level::new(), false);
        hidden += expected.1.iter().filter(|&&seen| !seen).count();
        for threads in [1, 2, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().expect("threads");
            assert!(
                pool.install(|| all(Level::new(), true)) == expected,
                "scene {seed}"
            );
        }
        for level in levels() {
            assert!(all(level, true) == expected, "scene {seed} by {level:?}");
        }
    }
    assert!(hidden > 2000, "{hidden}");
}

/// A wall across the view of an eye at the origin that looks along −z, at z = −5, seen from its front.
fn wall() -> OccluderMesh {
    let corners = [
        [-9.0, -9.0, -5.0],
        [9.0, -9.0, -5.0],
        [9.0, 9.0, -5.0],
        [-9.0, 9.0, -5.0],
    ];
    OccluderMesh::triangles(&corners, &[0, 1, 2, 0, 2, 3]).expect("a wall")
}

fn ahead() -> View {
    View::new([0.0; 3], [0.0, 0.0, -1.0], [320, 180])
}

fn cube(center: [f32; 3], half: f32) -> Aabb {
    Aabb {
        min: center.map(|at| at - half),
        max: center.map(|at| at + half),
    }
}

/// Whether a cube behind the wall is visible once `mesh` is drawn with a transform.
fn shows_behind(mesh: &OccluderMesh, at: Transform) -> bool {
    let mut buffer = OcclusionBuffer::new();
    buffer.begin(&ahead());
    buffer.draw(mesh, &at);
    boxes(&buffer, &[cube([0.0, 0.0, -50.0], 1.0)])[0]
}

#[test]
fn a_wall_hides_from_its_front_or_if_double_sided_from_both() {
    let flipped = Transform::rotation([0.0, 1.0, 0.0], std::f64::consts::PI);
    let [from_behind, mirrored] = [
        Transform::translation([0.0, 0.0, -10.0]) * flipped,
        Transform::scaling([-1.0, 1.0, 1.0]),
    ];
    let mut wall = wall();
    assert!(!shows_behind(&wall, Transform::IDENTITY));
    assert!(shows_behind(&wall, from_behind));
    assert!(
        !shows_behind(&wall, mirrored),
        "a mirrored wall still has its front to the eye"
    );
    wall.double_sided = true;
    assert!(!shows_behind(&wall, from_behind));
}

#[test]
fn a_box_around_the_eye_or_through_the_near_plane_is_visible_and_one_before_it_or_behind_is_not() {
    let mut view = ahead();
    view.near = 1.0;
    let mut buffer = OcclusionBuffer::new();
    buffer.begin(&view);
    buffer.draw(&wall(), &Transform::translation([0.0, 0.0, 3.9]));
    let asked = [
        cube([0.0; 3], 2.0),
        cube([0.0, 0.0, -1.0], 0.05),
        cube([0.0, 0.0, -0.5], 0.1),
        cube([0.0, 0.0, 5.0], 1.0),
        cube([0.0, 0.0, -1.3], 0.1),
        Aabb {
            min: [-0.1, -0.1, -1.1],
            max: [0.1, 0.1, -1.1],
        },
    ];
    assert_eq!(boxes(&buffer, &asked), [true, true, false, false, false, true]);
    let round = asked.map(|bounds| (bounds.center(), 0.5 * bounds.longest_side()));
    assert_eq!(spheres(&buffer, &round), [true, true, false, false, false, true]);
}

#[test]
fn input_that_is_not_finite_hides_nothing_and_is_visible() {
    for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(shows_behind(&wall(), Transform::translation([odd, 0.0, 0.0])));
        let mut buffer = OcclusionBuffer::new();
        buffer.begin(&ahead());
        buffer.draw(&wall(), &Transform::IDENTITY);
        for axis in 0..3 {
            let mut bounds = cube([0.0, 0.0, -50.0], 1.0);
            let mut sphere = ([0.0, 0.0, -50.0], 1.0);
            assert_eq!(
                (boxes(&buffer, &[bounds]), spheres(&buffer, &[sphere])),
                (vec![false], vec![false])
            );
            bounds.max[axis] = if odd == f32::NEG_INFINITY {
                f32::INFINITY
            } else {
                odd
            };
            sphere.0[axis] = odd;
            assert_eq!(
                (boxes(&buffer, &[bounds]), spheres(&buffer, &[sphere])),
                (vec![true], vec![true])
            );
            assert_eq!(spheres(&buffer, &[([0.0, 0.0, -50.0], odd)]), [true]);
        }
    }
    let huge = Transform::scaling([f32::MAX; 3]) * Transform::scaling([f32::MAX; 3]);
    for at in [
        huge,
        huge * huge * huge * huge * huge,
        Transform::scaling([1e-38; 3]),
        Transform::scaling([0.0; 3]),
    ] {
        shows_behind(&wall(), at);
    }
    let far = cube([0.0, 0.0, -2.0 * MAX_COORDINATE], MAX_COORDINATE);
    let mut buffer = OcclusionBuffer::new();
    assert_eq!(
        boxes(&buffer, &[far, Aabb::EMPTY]),
        [true, true],
        "before the first view"
    );
    let mut view = ahead();
    view.fov_y = f32::NAN;
    buffer.begin(&view);
    buffer.draw(&wall(), &Transform::IDENTITY);
    assert_eq!(boxes(&buffer, &[far]), [true]);
    assert_eq!(buffer.depth(), []);
    buffer.begin(&ahead());
    assert_eq!(boxes(&buffer, &[far, Aabb::EMPTY]), [true, false]);
}

#[test]
fn rectangles_are_tested_at_their_depth_and_bits_without_an_occludee_are_cleared() {
    let mut buffer = OcclusionBuffer::new();
    buffer.begin(&ahead());
    let left = Transform::translation([-9.0, 0.0, 0.0]);
    buffer.draw(&wall(), &left);
    let rect = |x0, x1| Rect {
        x0,
        y0: 10,
        x1,
        y1: 20,
    };
    let asked = [
        (rect(10, 100), 0.1),
        (rect(10, 100), 0.3),
        (rect(10, 200), 0.1),
        (rect(10, 100), -1.0),
        (rect(10, 100), f32::NAN),
        (rect(400, 500), 1.0),
        (rect(20, 20), 1.0),
        (rect(10, 1000), 0.0),
        (rect(0, 150), 0.0),
    ];
    let mut visible = [u64::MAX; 3];
    buffer.test_rects(&asked, &mut visible);
    assert_eq!(visible, [0b0_1001_1110, 0, 0]);
    // As many boxes as there are bits; the first is behind the wall.
    let asked: Vec<Aabb> = (0..130)
        .map(|x| cube([x as f32 - 3.0, 0.0, -50.0], 1.0))
        .collect();
    let mut visible = [0; 1];
    buffer.test_boxes(&asked, &mut visible);
    assert_eq!(visible[0] & 1, 0);
    assert_ne!(visible[0], 0);
    buffer.test_boxes(&[], &mut visible);
    assert_eq!(visible, [0]);
}
