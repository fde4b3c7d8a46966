//! Cost of motion: a town of 10,000 items, 1,000 of which move, edited and looked at in every frame; the quality of the
//! trees after 100,000 edits; and a city of 10,000 boxes, 500 or all of which move in every frame, on one thread.
//!
//! Touched nodes and tested boxes are counted; exceeding the limit is an error. With `cargo test` the town is a tenth
//! as large, and nothing is timed.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

use enfilade::{
    GeometryBuilder, ItemId, ItemIndex, Material, MaterialId, Mesh, Method, Scene, SceneBuilder, SectorId,
    Transform, View, Viewer,
};
use std::hint::black_box;
use std::time::Instant;

const TOWN: SectorId = SectorId(0);
const SIZE: [u32; 2] = [1280, 720];

/// Methods whose trees are updated in place.
const METHODS: [Method; 7] = [
    Method::ZBuffer,
    Method::SBuffer,
    Method::HierarchicalZ,
    Method::HierarchicalS,
    Method::Masked,
    Method::Svbsp,
    Method::Mobsp,
];

/// Maximum number of tree nodes per move: the path down an octree twice, and the same again for methods with more
/// trees.
const MAX_NODES: u64 = 64;

/// Maximum ratio of boxes tested by a look after many edits to those at a scene built from scratch.
const MAX_WORSE: f64 = 1.3;

/// Distance between houses.
const BLOCK: f32 = 14.0;

fn cuboid([width, height, depth]: [f32; 3]) -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { 0.0 };
        [width * (side(0) - 0.5), height * side(1), depth * (side(2) - 0.5)]
    };
    let corners: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let triangles: Vec<u32> = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    Mesh::triangles(&corners, &triangles, MaterialId(0)).expect("a box")
}

/// Streets with houses between them, and people on the streets; the people have the first ids.
struct Town {
    scene: Scene,
    people: u32,
    /// Houses along each side.
    side: usize,
}

impl Town {
    fn new(things: u32, method: Method) -> Town {
        let people = things / 10;
        let side = (f64::from(things - people)).sqrt() as usize;
        let mut town = GeometryBuilder::new([Material {
            double_sided: true,
            ..Material::opaque([0.6; 3])
        }]);
        let person = town.mesh(cuboid([0.5, 1.8, 0.4]));
        for number in 0..people {
            town.item("person", person, walker(number, 0, side));
        }
        let houses: Vec<_> = (0..8_u8)
            .map(|kind| {
                let [wide, high] = [8.0 + f32::from(kind % 3), 6.0 + 2.0 * f32::from(kind)];
                town.mesh(cuboid([wide, high, 9.5]))
            })
            .collect();
        for number in 0..side * side {
            let at = [number % side, number / side].map(|step| (step as f32 + 0.5) * BLOCK);
            let place = Transform::translation([at[0], 0.0, at[1]]);
            town.item("house", houses[(number * 7 + number / side) % 8], place);
        }
        let mut scene = SceneBuilder::new();
        scene.add("town", town.build().expect("a town"), method);
        Town {
            scene: scene.build().expect("a town"),
            people,
            side,
        }
    }

    /// Moves everybody by a step. Returns the number of nodes touched.
    fn step(&mut self, moment: u32) -> u64 {
        let mut edit = self.scene.edit();
        for number in 0..self.people {
            let there = walker(number, moment, self.side);
            edit.set_transform(TOWN, ItemIndex(number).into(), there)
                .expect("a place in the town");
        }
        let edited = edit.finish().expect("a small town");
        assert_eq!((edited.items, edited.rebuilt), (u64::from(self.people), 0));
        edited.nodes
    }

    /// A view along a street from its middle.
    fn view(&self) -> View {
        let middle = (self.side / 2) as f32 * BLOCK;
        View::new(
            [middle, 1.7, middle + 3.0],
            [middle + 4.0, 2.0, middle + 90.0],
            SIZE,
        )
        .expect("a valid view")
    }
}

/// Returns the transform of a person at a time: up and down a street, at about a tenth of a metre per frame.
fn walker(number: u32, moment: u32, side: usize) -> Transform {
    let along = BLOCK * side as f32;
    let street = (number.wrapping_mul(2_654_435_761) >> 8) as usize % (side + 1);
    let way =
        (number as f32 * 7.31 + moment as f32 * 0.1 * (1.0 + (number % 3) as f32 * 0.2)) % (2.0 * along);
    let way = if way > along { 2.0 * along - way } else { way };
    let aside = street as f32 * BLOCK + (number % 5) as f32 - 2.0;
    let at = if number.is_multiple_of(2) {
        [way, 0.0, aside]
    } else {
        [aside, 0.0, way]
    };
    Transform::translation(at)
}

/// Creates a single-threaded viewer: with several threads the number of tests would depend on scheduling.
fn viewer() -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.parallel = false;
    viewer
}

fn ms(mut work: impl FnMut()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Measures frames: everybody moves, and one camera looks.
fn moving(things: u32, times: bool) {
    const FRAMES: u32 = 61;
    println!("{things} items, a tenth of them moving, {SIZE:?}");
    println!("method             edit ms   look ms  together       p99  nodes/move   seen");
    for method in METHODS {
        let mut town = Town::new(things, method);
        let (view, mut viewer) = (town.view(), viewer());
        let (mut edits, mut looks, mut nodes) = (Vec::new(), Vec::new(), 0);
        for moment in 1..=FRAMES {
            edits.push(ms(|| nodes += town.step(moment)));
            looks.push(ms(|| {
                black_box(viewer.look(&town.scene, &view));
            }));
        }
        let per_move = nodes / u64::from(FRAMES * town.people);
        assert!(per_move <= MAX_NODES, "{method}: {per_move} nodes per move");
        let seen = viewer.visible().items().len();
        assert!(seen > 10, "{method}: only {seen} visible items");
        if times {
            let mut both: Vec<f64> = edits.iter().zip(&looks).map(|(edit, look)| edit + look).collect();
            both.sort_by(f64::total_cmp);
            let (together, worst) = (median(both.clone()), both[both.len() * 99 / 100]);
            println!(
                "{:16}{:10.3}{:10.3}{together:10.3}{worst:10.3}{per_move:12}{seen:7}",
                method.name(),
                median(edits),
                median(looks)
            );
        }
    }
}

/// Measures boxes tested by looks after edits, relative to a scene built from scratch.
fn quality(things: u32, edits: u32) {
    println!("\nboxes tested after {edits} edits / in a new scene");
    for method in METHODS {
        let mut town = Town::new(things, method);
        let steps = edits / town.people;
        for moment in 1..=steps {
            town.step(moment * 10);
        }
        let fresh = town.scene.with_method(method, u64::MAX).expect("a small town");
        let mut asked = [0; 2];
        let base = town.view();
        for turn in 0..16_u8 {
            let (sin, cos) = (f64::from(turn) * 0.39).sin_cos();
            let toward = [base.eye()[0] + 50.0 * cos, 2.0, base.eye()[2] + 50.0 * sin];
            let view = View::new(base.eye(), toward, SIZE).expect("a valid view");
            for (scene, asked) in [&town.scene, &fresh].into_iter().zip(&mut asked) {
                let mut viewer = viewer();
                viewer.look(scene, &view);
                *asked += viewer.stats().boxes_tested;
            }
        }
        let worse = asked[0] as f64 / asked[1].max(1) as f64;
        println!("{:16}{worse:10.3}", method.name());
        assert!(
            worse <= MAX_WORSE,
            "{method}: {worse} times the boxes of a new scene"
        );
    }
}

/// Maximum ratio of the time of a look after many edits to that at a scene built from scratch.
const MAX_SLOWER: f64 = 1.3;

/// Returns the transform of a box of a city with `side` boxes along each side: it goes to and fro between its
/// neighbours, 0.3 per frame.
fn box_of_city(number: u32, moment: u32, side: u32) -> Transform {
    let at = [number % side, number / side].map(|step| step as f32 * BLOCK);
    let phase = number.wrapping_mul(2_654_435_761) >> 8;
    let way = ((moment * 3 + phase) % 100) as f32 * 0.1;
    let way = if way > 5.0 { 10.0 - way } else { way };
    let along = if phase.is_multiple_of(2) {
        [way, 0.0]
    } else {
        [0.0, way]
    };
    Transform::translation([at[0] + along[0], 0.0, at[1] + along[1]])
}

/// Measures frames in which `moving` of the boxes of a city move, and a look after them against one at a new scene.
fn city(side: u32, moving: u32, times: bool) {
    const FRAMES: u32 = 200;
    let method = Method::Masked;
    let boxes = side * side;
    let mut city = GeometryBuilder::new([Material::opaque([0.6; 3])]);
    let kinds = [0, 1, 2, 3].map(|kind| {
        let [wide, high] = [5.0 + kind as f32, 6.0 + 4.0 * kind as f32];
        city.mesh(cuboid([wide, high, 6.5]))
    });
    let ids: Vec<ItemId> = (0..boxes)
        .map(|number| city.item("box", kinds[number as usize % 4], box_of_city(number, 0, side)))
        .collect();
    let mut scene = Scene::single(city.build().expect("a city"), method).expect("a city");
    let mut viewer = viewer();
    let view = {
        let middle = (side / 2) as f32 * BLOCK + 0.5 * BLOCK;
        View::new([middle, 12.0, middle], [middle + 40.0, 6.0, middle + 90.0], SIZE).expect("a valid view")
    };
    let mut refused = Vec::new();
    let (mut requests, mut finishes, mut looks) = (Vec::new(), Vec::new(), Vec::new());
    for moment in 1..=FRAMES {
        let mut edit = scene.edit();
        requests.push(ms(|| {
            let numbers = (0..moving).map(|number| number * (boxes / moving));
            let moves = numbers.map(|number| (ids[number as usize], box_of_city(number, moment, side)));
            edit.set_transforms(TOWN, moves, &mut refused)
                .expect("it is no custom sector");
        }));
        assert!(refused.is_empty(), "{refused:?}");
        let start = Instant::now();
        let edited = edit.finish().expect("a small city");
        finishes.push(start.elapsed().as_secs_f64() * 1e3);
        assert_eq!((edited.items, edited.rebuilt), (u64::from(moving), 0));
        looks.push(ms(|| {
            black_box(viewer.look(&scene, &view));
        }));
    }
    // Alternately, so that both have the same share of disturbances.
    let fresh = scene.with_method(method, u64::MAX).expect("a small city");
    let mut least = [f64::INFINITY; 2];
    for _ in 0..if times { 200 } else { 1 } {
        for (scene, least) in [&scene, &fresh].into_iter().zip(&mut least) {
            *least = least.min(ms(|| {
                black_box(viewer.look(scene, &view));
            }));
        }
    }
    let seen = [&scene, &fresh].map(|scene| viewer.look(scene, &view).items().len());
    assert!(
        seen[0] > 5 && seen[0].abs_diff(seen[1]) <= seen[1] / 5,
        "{seen:?} seen"
    );
    if times {
        let least_of = |times: &[f64]| times[20..].iter().copied().fold(f64::INFINITY, f64::min);
        println!(
            "{boxes:8}{moving:8}{:12.3}{:12.3}{:12.3}{:12.2}{:7}",
            least_of(&requests),
            least_of(&finishes),
            least_of(&looks),
            least[0] / least[1],
            seen[0]
        );
        assert!(least[0] <= MAX_SLOWER * least[1], "a look takes {least:?} ms");
    }
}

fn cities(side: u32, times: bool) {
    println!("\nmasked, one thread, minimum of 180 frames; a look after them against one at a new scene");
    println!("   boxes  moving  request ms   finish ms     look ms     / fresh   seen");
    for moving in [side * side / 20, side * side] {
        city(side, moving, times);
    }
}

fn main() {
    let times = std::env::args().any(|argument| argument == "--bench");
    if times {
        moving(10_000, true);
        quality(10_000, 100_000);
        cities(100, true);
    } else {
        moving(1000, false);
        quality(1000, 10_000);
        cities(20, false);
    }
}
