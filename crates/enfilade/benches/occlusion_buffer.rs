//! The occlusion buffer without a scene, beside a whole look of the same town: 10,000 houses, of which 1,000 are drawn as
//! occluders, with five quads each.
//!
//! A wrong number of visible houses is an error. Rows take turns in each round, and the shortest round of each counts.
//! With `cargo test` nothing is timed.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

use enfilade::{
    Aabb, GeometryBuilder, Material, MaterialId, Mesh, Method, OccluderMesh, OcclusionBuffer, Scene,
    Transform, View, Viewer,
};
use std::hint::black_box;
use std::time::Instant;

const SIZE: [u32; 2] = [1280, 720];
const SIDE: usize = 100;
const OCCLUDERS: usize = 1000;
const ROUNDS: usize = 200;

/// Houses that may be visible: by the buffer, and in the visible set of `masked`.
const VISIBLE: [usize; 2] = [85, 42];

/// The walls and the roof of a unit cube on the ground, counter-clockwise seen from outside.
const QUADS: [[u32; 4]; 5] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [2, 6, 7, 3],
];

struct Town {
    scene: Scene,
    view: View,
    /// Bounds of all houses, nearest first.
    houses: Vec<Aabb>,
    /// One quad for each wall and roof of the nearest houses.
    quads: OccluderMesh,
    /// The walls and the roof of a unit cube, and where it is placed.
    house: OccluderMesh,
    placed: Vec<Transform>,
}

fn triangles(first: u32) -> impl Iterator<Item = u32> {
    QUADS
        .into_iter()
        .flat_map(move |[a, b, c, d]| [a, b, c, a, c, d].map(|corner| first + corner))
}

impl Town {
    fn new() -> Town {
        let middle = 14.0 * 0.5 * SIDE as f32;
        let view = View::new(
            [middle, 1.7, middle + 3.0],
            [middle + 4.0, 2.0, middle + 90.0],
            SIZE,
        )
        .expect("a valid view");
        let mut houses: Vec<Aabb> = (0..SIDE * SIDE)
            .map(|number| {
                let kind = (number * 7 + number / SIDE) % 8;
                let [wide, high] = [8.0 + (kind % 3) as f32, 6.0 + 2.0 * kind as f32];
                let [x, z] = [number % SIDE, number / SIDE].map(|step| (step as f32 + 0.5) * 14.0);
                Aabb {
                    min: [x - 0.5 * wide, 0.0, z - 4.75],
                    max: [x + 0.5 * wide, high, z + 4.75],
                }
            })
            .collect();
        let eye = view.eye().map(|value| value as f32);
        let distance = |bounds: &Aabb| {
            let at = bounds.center();
            (at[0] - eye[0]).powi(2) + (at[2] - eye[2]).powi(2)
        };
        houses.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let placed: Vec<Transform> = houses
            .iter()
            .map(|house| Transform::translation(house.min) * Transform::scaling(house.size()))
            .collect();
        let ahead = |bounds: &&Aabb| bounds.max[2] > eye[2];
        let drawn: Vec<Aabb> = houses.iter().filter(ahead).take(OCCLUDERS).copied().collect();
        let positions: Vec<[f32; 3]> = drawn.iter().flat_map(Aabb::corners).collect();
        let indices: Vec<u32> = (0..OCCLUDERS as u32)
            .flat_map(|house| triangles(8 * house))
            .collect();
        let unit = Aabb {
            min: [0.0; 3],
            max: [1.0; 3],
        }
        .corners();
        let mut town = GeometryBuilder::new([Material::opaque([0.6; 3])]);
        let cuboid = Mesh::cuboid([0.0; 3], [1.0; 3], MaterialId(0)).expect("a cube");
        let cuboid = town.mesh(cuboid);
        for &at in &placed {
            town.item("house", cuboid, at);
        }
        Town {
            scene: Scene::single(town.build().expect("a town"), Method::Masked).expect("a town"),
            view,
            quads: OccluderMesh::triangles(&positions, &indices).expect("quads"),
            house: OccluderMesh::triangles(&unit, &triangles(0).collect::<Vec<_>>()).expect("a house"),
            placed: drawn
                .iter()
                .map(|house| Transform::translation(house.min) * Transform::scaling(house.size()))
                .collect(),
            houses,
        }
    }
}

fn seconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn main() {
    let times = std::env::args().any(|argument| argument == "--bench");
    let rounds = if times { ROUNDS } else { 1 };
    let town = Town::new();
    let mut buffer = OcclusionBuffer::new();
    buffer.parallel = false;
    let mut viewer = Viewer::new();
    viewer.options.parallel = false;
    let mut visible = vec![0_u64; town.houses.len().div_ceil(64)];
    let mut least = [f64::INFINITY; 5];
    for _ in 0..rounds {
        let times = [
            seconds(|| buffer.begin(&town.view)),
            seconds(|| buffer.draw_all([(&town.quads, Transform::IDENTITY)])),
            seconds(|| buffer.test_boxes(&town.houses, &mut visible)),
            {
                buffer.begin(&town.view);
                seconds(|| buffer.draw_all(town.placed.iter().map(|&at| (&town.house, at))))
            },
            seconds(|| {
                black_box(viewer.look(&town.scene, &town.view));
            }),
        ];
        for (least, time) in least.iter_mut().zip(times) {
            *least = least.min(time);
        }
    }
    let shown = visible.iter().map(|word| word.count_ones() as usize).sum();
    let found = [shown, viewer.visible().items().len()];
    if times {
        let look = least[4];
        let names = [
            "begin",
            "draw 5,000 quads of one mesh",
            "test 10,000 boxes",
            "draw 1,000 instances of five quads",
            "masked: whole look",
        ];
        for (name, least) in names.iter().zip(least) {
            println!("{name:36}{:8.3} ms {:6.2} of the look", least * 1e3, least / look);
        }
        println!("visible: {} by the buffer, {} by masked", found[0], found[1]);
    }
    assert_eq!(found, VISIBLE, "visible houses: by the buffer, by masked");
}
