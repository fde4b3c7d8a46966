//! Cost of portals: a row of up to 10,000 rooms, 10,000 closed doors in one room, two facing mirrors, and the memory of
//! a look through a hundred mirrors.
//!
//! The visible set does not depend on the length of the row: a count that differs from the table is an error, and so
//! are additional box tests. With `cargo test` it stops at 100 rooms and only counts.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

#[path = "../tests/memory/mirrors.rs"]
mod mirrors;

use allocation_counter::measure;
use enfilade::{
    Canvas, ConvexPolygon, Geometry, GeometryBuilder, Material, MaterialId, Mesh, Method, OpeningId, Passage,
    PassageId, PortalId, Scene, SceneBuilder, SectorId, Span, Transform, View, Viewer,
};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const SIZE: [u32; 2] = [1280, 720];

/// Numbers of rooms in a row.
const ROOMS: [usize; 4] = [10, 100, 1_000, 10_000];

const METHODS: [Method; 5] = [
    Method::ZBuffer,
    Method::HierarchicalZ,
    Method::HierarchicalS,
    Method::Masked,
    Method::Mobsp,
];

/// Numbers of rooms and items visible from the first room; the same from a middle one.
const SEEN: [usize; 2] = [3, 10];

/// Passages of two facing mirrors, and the maximum milliseconds of a look into them.
const MIRRORS: (usize, f64) = (65, 50.0);

const ROUNDS: usize = 21;

/// Length of a room, and the x at which its doors begin, alternating.
const LENGTH: f32 = 6.0;
const DOORS: [f32; 2] = [-1.3, 0.1];
const WIDTH: f32 = 1.2;
const HEIGHT: f32 = 2.0;

fn stone() -> Material {
    Material {
        double_sided: true,
        ..Material::opaque([0.6; 3])
    }
}

/// Builds rectangles, each from a corner and two sides.
fn sheets(sheets: &[[[f32; 3]; 3]]) -> Mesh {
    let (mut positions, mut corners) = (Vec::new(), Vec::new());
    for [corner, a, b] in sheets {
        let first = positions.len() as u32;
        for (s, t) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            positions.push([0, 1, 2].map(|axis| corner[axis] + s * a[axis] + t * b[axis]));
        }
        corners.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    Mesh::triangles(&positions, &corners, MaterialId(0)).expect("sound rectangles")
}

/// Builds a room from z = 0 to -LENGTH whose back and front doors begin at the given x.
fn shell([back, front]: [f32; 2]) -> Mesh {
    let [across, up, along] = [[6.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, -LENGTH]];
    let mut walls = vec![
        [[-3.0, 0.0, 0.0], across, along],
        [[-3.0, 3.0, 0.0], across, along],
        [[-3.0, 0.0, 0.0], up, along],
        [[3.0, 0.0, 0.0], up, along],
    ];
    for (door, z) in [(back, 0.0), (front, -LENGTH)] {
        let beyond = door + WIDTH;
        walls.push([[-3.0, 0.0, z], [door + 3.0, 0.0, 0.0], up]);
        walls.push([[beyond, 0.0, z], [3.0 - beyond, 0.0, 0.0], up]);
        walls.push([[door, HEIGHT, z], [WIDTH, 0.0, 0.0], [0.0, 3.0 - HEIGHT, 0.0]]);
    }
    sheets(&walls)
}

/// Builds a row of rooms with four items each, joined by doors alternately on the left and on the right.
fn row(rooms: usize) -> Scene {
    let shells = [[1, 0], [0, 1]].map(|[back, front]| Arc::new(shell([DOORS[back], DOORS[front]])));
    let thing = sheets(&[
        [[-0.2, 0.0, -0.2], [0.4, 0.0, 0.4], [0.0, 1.0, 0.0]],
        [[-0.2, 0.0, 0.2], [0.4, 0.0, -0.4], [0.0, 1.0, 0.0]],
    ]);
    let (thing, materials): (_, Arc<[Material]>) = (Arc::new(thing), [stone()].into());
    let door = |turn: usize, z: f32| {
        let corner = [DOORS[turn % 2], 0.0, z];
        ConvexPolygon::rectangle(corner, [WIDTH, 0.0, 0.0], [0.0, HEIGHT, 0.0]).expect("a door")
    };
    let mut builder = SceneBuilder::new();
    for number in 0..rooms {
        let z = -LENGTH * number as f32;
        let mut room = GeometryBuilder::new(Arc::clone(&materials));
        let [shell, thing] = [&shells[number % 2], &thing].map(|mesh| room.mesh(Arc::clone(mesh)));
        room.item("shell", shell, Transform::translation([0.0, 0.0, z]));
        for x in [-2.5, -1.0, 1.0, 2.5] {
            room.item("thing", thing, Transform::translation([x, 0.0, z - 4.5]));
        }
        room.opening("on", door(number, z - LENGTH));
        if number > 0 {
            room.opening("back", door(number - 1, z).flipped());
        }
        let room = room.build().expect("a room");
        let here = builder.add("room", room, Method::ZBuffer);
        if number > 0 {
            builder.door((SectorId(here.0 - 1), OpeningId(0)), (here, OpeningId(1)));
        }
    }
    builder.build().expect("rooms in a row")
}

/// A view from a corner of an even room towards the next door.
fn view_from(room: usize) -> View {
    let z = -LENGTH * room as f32;
    View::new(
        [-2.2, 1.5, z - 0.5],
        [DOORS[0] + 0.5 * WIDTH, 1.3, z - LENGTH],
        SIZE,
    )
    .expect("a valid view")
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Returns milliseconds, the median of several rounds.
fn ms(mut work: impl FnMut()) -> f64 {
    let round = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64() * 1e3
    };
    median((0..ROUNDS).map(round).collect())
}

/// Creates a single-threaded viewer: with several threads the number of tests would depend on scheduling.
fn viewer() -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.parallel = false;
    viewer
}

fn look(viewer: &mut Viewer, scene: &Scene, view: &View) {
    black_box(viewer.look(scene, view));
}

fn rooms_in_a_row(times: bool) {
    println!(
        "a row of rooms{:>20}{:>10}{:>10}{:>12}{:>12}{:>12}",
        "look", "named", "locate", "boxes", "passages", "items"
    );
    let sizes = if times { &ROOMS[..] } else { &ROOMS[..2] };
    let rows: Vec<Scene> = sizes.iter().map(|&rooms| row(rooms)).collect();
    for (method, from) in METHODS.into_iter().flat_map(|method| [(method, 0), (method, 1)]) {
        let mut first_boxes = None;
        for (&rooms, row) in sizes.iter().zip(&rows) {
            let scene = row
                .with_method(method, Method::DEFAULT_LIMIT)
                .expect("small rooms");
            let room = [0, (rooms / 2) & !1][from];
            let view = view_from(room);
            let mut viewer = viewer();
            let set = viewer.look(&scene, &view);
            let seen = [set.passages().len(), set.items().len()];
            assert_eq!(set.passages()[0].sector, SectorId(room as u32));
            assert!(set.complete());
            let place = format!("{method}, room {room} of {rooms}");
            if method.contract() == enfilade::Contract::Exact {
                assert_eq!(seen, SEEN, "{place}");
            } else {
                assert!(seen[0] >= SEEN[0] && seen[1] >= SEEN[1], "{place}: {seen:?}");
            }
            let boxes = viewer.stats().boxes_tested;
            let few = *first_boxes.get_or_insert(boxes);
            assert!(
                boxes <= few,
                "{place}: {boxes} boxes tested, expected at most {few}"
            );
            if times {
                let looked = ms(|| look(&mut viewer, &scene, &view));
                let mut named = view;
                named.sector = Some(SectorId(room as u32));
                let named = ms(|| look(&mut viewer, &scene, &named));
                let locate = ms(|| {
                    black_box(scene.locate(view.eye(), view.toward()));
                });
                println!(
                    "{place:34}{looked:8.3}{named:10.3}{locate:10.5}{boxes:12}{:12}{:12}",
                    seen[0], seen[1]
                );
            }
        }
    }
}

/// Objects in front of a wall a hundred metres wide.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Before {
    Nothing,
    Panels,
    ClosedDoors,
}

/// Number of doors or panels, in a hundred rows and columns.
const DOORS_IN_A_WALL: u16 = 10_000;

/// Builds a hall with 10,000 of them in front of its far wall, and some items.
fn hall(before: Before) -> Scene {
    let mut hall = GeometryBuilder::new([stone()]);
    let wall = sheets(&[[[-50.0, 0.0, -30.0], [100.0, 0.0, 0.0], [0.0, 40.0, 0.0]]]);
    let [wall, panel] =
        [wall, sheets(&[[[0.0; 3], [0.8, 0.0, 0.0], [0.0, 0.3, 0.0]]])].map(|mesh| hall.mesh(mesh));
    hall.item("wall", wall, Transform::IDENTITY);
    for x in 0..40_u8 {
        let place = Transform::translation([f32::from(x) - 20.0, 1.0, 10.0]);
        hall.item("thing", panel, place);
    }
    for i in 0..DOORS_IN_A_WALL {
        let corner = [f32::from(i % 100) - 49.9, 0.4 * f32::from(i / 100), -29.9];
        let outline = || ConvexPolygon::rectangle(corner, [0.8, 0.0, 0.0], [0.0, 0.3, 0.0]).expect("a door");
        match before {
            Before::Nothing => {}
            Before::Panels => drop(hall.item("panel", panel, Transform::translation(corner))),
            Before::ClosedDoors => drop(hall.opening("door", outline())),
        }
    }
    let mut builder = SceneBuilder::new();
    let openings = if before == Before::ClosedDoors {
        DOORS_IN_A_WALL
    } else {
        0
    };
    let hall = builder.add("hall", hall.build().expect("a hall"), Method::ZBuffer);
    let beyond: Geometry = GeometryBuilder::new([]).build().expect("nothing");
    let beyond = builder.add("beyond", beyond, Method::ZBuffer);
    for opening in (0..openings).map(OpeningId) {
        builder.portal((hall, opening), beyond, Transform::IDENTITY);
    }
    let mut scene = builder.build().expect("a hall of doors");
    for portal in (0..u32::from(openings)).map(PortalId) {
        scene.set_open(portal, false);
    }
    scene
}

fn closed_doors(times: bool) {
    println!(
        "\n10,000 closed doors, ms/look  {:>12}{:>12}{:>12}",
        "none", "panels", "doors"
    );
    let halls = [Before::Nothing, Before::Panels, Before::ClosedDoors].map(|before| (before, hall(before)));
    let views = [
        (
            "all in view",
            View::new([0.0, 20.0, 20.0], [0.0, 20.0, -30.0], SIZE).expect("a valid view"),
        ),
        (
            "a few in view",
            View::new([0.0, 10.0, -27.0], [0.0, 10.0, -30.0], SIZE).expect("a valid view"),
        ),
        (
            "none in view",
            View::new([0.0, 2.0, 0.0], [0.0, 1.0, 10.0], SIZE).expect("a valid view"),
        ),
    ];
    for (method, (name, view)) in METHODS
        .into_iter()
        .flat_map(|method| views.map(|view| (method, view)))
    {
        let mut counted = Vec::new();
        let mut row = Vec::new();
        for (before, hall) in &halls {
            let scene = hall.with_method(method, Method::DEFAULT_LIMIT);
            let scene = scene.expect("a small hall");
            let mut viewer = viewer();
            let set = viewer.look(&scene, &view);
            let place = format!("{method}, {before:?}, {name}");
            assert!(set.complete() && set.passages().len() == 1, "{place}");
            let items = set.items().len();
            assert!(items > 0, "{place}");
            counted.push((items, viewer.stats().triangles));
            if times {
                row.push(ms(|| look(&mut viewer, &scene, &view)));
            }
        }
        let [without, panels, doors] = [counted[0], counted[1], counted[2]];
        if name == "none in view" {
            assert!(
                without == doors && without == panels,
                "{method}, {name}: {counted:?}"
            );
        } else {
            // A closed door is two triangles, as a panel is, but no item.
            assert!(doors.1 <= panels.1 + 2, "{method}, {name}: {counted:?}");
            assert!(panels.0 > doors.0, "{method}, {name}: {counted:?}");
        }
        if times {
            println!(
                "{:30}{:12.3}{:12.3}{:12.3}",
                format!("{method}, {name}"),
                row[0],
                row[1],
                row[2]
            );
        }
    }
}

fn mirrors_face_to_face(times: bool) {
    println!(
        "\n@mirrors{:>28}{:>12}{:>10}",
        "ms per look", "passages", "complete"
    );
    let (passages, most_ms) = MIRRORS;
    let mirrors = enfilade_scenes::built_in("mirrors").expect("it is built in");
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let scene = mirrors
            .scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("small");
        let view = mirrors.cameras[0].view(SIZE).expect("a valid view");
        let mut viewer = viewer();
        let set = viewer.look(&scene, &view);
        let (seen, complete) = (set.passages().len(), set.complete());
        assert!(
            seen == passages && !complete,
            "{method}: {seen} passages, complete: {complete}"
        );
        if times {
            let took = ms(|| look(&mut viewer, &scene, &view));
            println!("{:24}{took:12.3}{seen:12}{complete:>10}", method.name());
            assert!(took < most_ms, "{method}: {took} ms");
        }
    }
}

/// Prints the peak memory of a viewer, beyond the scene, to look and to draw at 1080p.
fn memory_of_mirrors() {
    println!("\nMB at 1080p{:>27}{:>20}", "100 side by side", "120 nested");
    let within = enfilade_scenes::built_in("mirrors").expect("it is built in");
    let scenes = [
        (
            mirrors::hundred_mirrors(),
            View::new([0.0, 0.0, 1.0], [0.0, 0.0, -4.0], [1920, 1080]).expect("a valid view"),
        ),
        (
            within.scene,
            within.cameras[0].view([1920, 1080]).expect("a valid view"),
        ),
    ];
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let taken = [0, 1].map(|which| {
            let (scene, view) = &scenes[which];
            let scene = scene.with_method(method, Method::DEFAULT_LIMIT).expect("small");
            let mut passages = 0;
            let taken = measure(|| {
                let mut viewer = Viewer::new();
                viewer.options.limits.max_crossings = 120;
                passages = viewer.look(&scene, view).passages().len();
                viewer.draw(&scene, view, &mut Nothing);
            });
            assert_eq!(passages, [101, 121][which], "{method}");
            taken.bytes_max as f64 / 1e6
        });
        println!("{:24}{:14.1}{:20.1}", method.name(), taken[0], taken[1]);
    }
}

/// A canvas that ignores all spans.
struct Nothing;

impl Canvas for Nothing {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}
    fn row(&mut self, _y: u16, _spans: &[Span]) {}
}

fn main() {
    let times = std::env::args().any(|argument| argument == "--bench");
    rooms_in_a_row(times);
    closed_doors(times);
    mirrors_face_to_face(times);
    memory_of_mirrors();
}
