//! Cost of a look as the scene grows: copies of the palace in a grid, as one sector without portals, from 3·10⁵ to 10⁹
//! triangles.
//!
//! All copies share the same meshes. The eye is in rooms of the middle copy, whose doors are plain holes, and the same
//! items are visible for any number of copies: a count that differs from the table is an error. Twelve views end at the
//! walls of four rooms. The views along the enfilade, over the court and into a mirror (without its portal a hole in
//! the wall) are reported separately, as more is visible in larger scenes.
//!
//! With `cargo test` it stops at 10⁷ triangles and only counts.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

use enfilade::{
    Contract, Geometry, GeometryBuilder, Mesh, MeshId, Method, Scene, SceneBuilder, SectorId, Transform,
    View, Viewer,
};
use enfilade_scenes::BuiltIn;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use std::time::Instant;

const SIZE: [u32; 2] = [1280, 720];

/// The rooms of the smallest scene, in which the views end.
const FOUR_ROOMS: [&str; 4] = ["Treasury", "Porcelain Cabinet", "Red Salon", "Green Salon"];

/// Copies along x, y and z; the first grid consists of the four rooms alone.
const GRIDS: [[i32; 3]; 5] = [[1; 3], [1; 3], [3; 3], [5; 3], [8; 3]];

/// Distance between copies in metres: a gap of 9 m horizontally or 4 m vertically.
const STEP: [f32; 3] = [216.5, 30.0, 191.0];

/// Camera, quarter turns to the right, number of visible items.
const INSIDE: [(&str, u8, usize); 12] = [
    ("porcelain cabinet", 0, 162),
    ("porcelain cabinet", 1, 65),
    ("porcelain cabinet", 2, 6),
    ("porcelain cabinet", 3, 20),
    ("treasury", 0, 168),
    ("treasury", 1, 34),
    ("green salon", 1, 24),
    ("green salon", 2, 5),
    ("green salon", 3, 8),
    ("red salon", 1, 10),
    ("red salon", 2, 6),
    ("red salon", 3, 37),
];

/// Views through many doors, or out of the building.
const OUTWARD: [(&str, u8); 3] = [("enfilade", 0), ("mirror room", 0), ("court", 0)];

/// Maximum growth of the number of boxes tested by a look from inside, smallest to largest scene, median over the
/// views: trees are deeper, and around doorways methods without an occlusion buffer test some geometry that the wall
/// hides.
const MAX_GROWTH: f64 = 2.0;

/// Maximum bytes of a geometry per added item.
const BYTES_AN_ITEM: u64 = 120;

/// Maximum bytes built by a method per added item.
const BYTES_BUILT: u64 = 200;

const METHODS: [Method; 5] = [
    Method::HierarchicalZ,
    Method::HierarchicalS,
    Method::Masked,
    Method::Svbsp,
    Method::Mobsp,
];

const ROUNDS: usize = 9;

/// Counts of a look from inside, over all views.
struct Counted {
    items: usize,
    /// Boxes tested, per view.
    boxes: Vec<f64>,
}

/// A scene of one sector, and its build time.
struct Grown {
    scene: Scene,
    build_ms: f64,
}

/// Returns the palace's rooms, which are reached through doors. The doll's house behind a scaling portal is not
/// included.
fn rooms(palace: &Scene) -> Vec<SectorId> {
    let is_door = |there: &Transform| there.columns() == Transform::IDENTITY.columns();
    let mut found = vec![SectorId(0)];
    let mut at = 0;
    while at < found.len() {
        for portal in palace.portals() {
            let leads_on = portal.from == found[at] && is_door(&portal.there_from_here);
            if leads_on && !found.contains(&portal.to) {
                found.push(portal.to);
            }
        }
        at += 1;
    }
    found
}

/// Builds copies of rooms in a grid; the middle copy is at the original position.
fn copies(palace: &Scene, rooms: &[SectorId], grid: [i32; 3]) -> Geometry {
    let geometries: Vec<&Geometry> = rooms
        .iter()
        .map(|&room| &**palace.geometry(room).expect("a room of ours"))
        .collect();
    let materials = geometries[0].materials();
    let mut builder = GeometryBuilder::new(materials);
    builder.textures(geometries[0].textures());
    let mut meshes: HashMap<*const Mesh, MeshId> = HashMap::new();
    let mut placed = Vec::new();
    for geometry in geometries {
        assert_eq!(geometry.materials(), materials, "one table for all");
        for item in geometry.items() {
            let mesh = &geometry.meshes()[item.mesh.0 as usize];
            let mesh = *meshes
                .entry(Arc::as_ptr(mesh))
                .or_insert_with(|| builder.mesh(Arc::clone(mesh)));
            placed.push((mesh, item.transform()));
        }
    }
    let along = |axis: usize| (0..grid[axis]).map(move |i| (i - grid[axis] / 2) as f32 * STEP[axis]);
    for x in along(0) {
        for y in along(1) {
            for z in along(2) {
                let copy = Transform::translation([x, y, z]);
                for &(mesh, place) in &placed {
                    builder.item("", mesh, copy * place);
                }
            }
        }
    }
    builder.build().expect("a palace beside a palace")
}

/// Returns a camera of the palace, rotated.
fn view(palace: &BuiltIn, name: &str, turns: u8) -> View {
    let camera = palace.cameras.iter().find(|camera| camera.name == name);
    let camera = camera.expect("a camera of the palace");
    let (sine, cosine) = (f64::from(turns) * FRAC_PI_2).sin_cos();
    let [eye, toward] = [camera.eye, camera.toward];
    let [x, z] = [toward[0] - eye[0], toward[2] - eye[2]];
    let toward = [
        eye[0] + x * cosine - z * sine,
        toward[1],
        eye[2] + x * sine + z * cosine,
    ];
    // In f32, as the numbers of visible items were counted.
    View::new(eye, toward.map(|value| f64::from(value as f32)), SIZE).expect("a valid view")
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

/// Creates a single-threaded viewer: with several threads the number of tests would depend on scheduling.
fn viewer() -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.parallel = false;
    viewer
}

/// Compares the visible items inside with the table, and counts tests.
fn count(scene: &Scene, method: Method, views: &[View], viewer: &mut Viewer) -> Counted {
    let mut counted = Counted {
        items: 0,
        boxes: Vec::new(),
    };
    for (view, (camera, turns, expected)) in views.iter().zip(INSIDE) {
        let seen = viewer.look(scene, view).items().len();
        counted.items += seen;
        counted.boxes.push(viewer.stats().boxes_tested as f64);
        let right = match method.contract() {
            Contract::Exact => seen == expected,
            _ => seen >= expected,
        };
        let triangles = scene.triangle_count();
        assert!(
            right,
            "{method}, {triangles} triangles, {camera} turned {turns} times: {seen} visible items, expected {expected}"
        );
    }
    counted
}

/// Returns, for each size, the milliseconds of each view's look: the median of several rounds, alternating between
/// sizes.
fn times(grown: &[Grown], views: &[View], viewers: &mut [Viewer]) -> Vec<Vec<f64>> {
    let mut times = vec![vec![Vec::with_capacity(ROUNDS); views.len()]; grown.len()];
    for _ in 0..ROUNDS {
        for ((grown, viewer), times) in grown.iter().zip(&mut *viewers).zip(&mut times) {
            for (view, times) in views.iter().zip(times) {
                let start = Instant::now();
                viewer.look(&grown.scene, view);
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    let medians = |views: Vec<Vec<f64>>| views.into_iter().map(median).collect();
    times.into_iter().map(medians).collect()
}

fn main() {
    let all = std::env::args().any(|argument| argument == "--bench");
    let palace = enfilade_scenes::built_in("enfilade").expect("it is built in");
    let rooms = rooms(&palace.scene);
    let is_of_four = |room: &SectorId| FOUR_ROOMS.contains(&palace.scene.sector_name(*room));
    let four: Vec<SectorId> = rooms.iter().copied().filter(is_of_four).collect();
    let grids = if all {
        &GRIDS[..]
    } else {
        &[[1; 3], [1; 3], [2; 3]]
    };

    println!(
        "{:>14}{:>11}{:>22}{:>10}",
        "triangles", "items", "bytes/added item", "build ms"
    );
    let mut plain: Vec<Grown> = Vec::new();
    for (number, &grid) in grids.iter().enumerate() {
        let start = Instant::now();
        let geometry = copies(&palace.scene, if number == 0 { &four } else { &rooms }, grid);
        let build_ms = start.elapsed().as_secs_f64() * 1e3;
        let mut builder = SceneBuilder::new();
        builder.add("palaces", geometry, Method::ZBuffer);
        let scene = builder.build().expect("one sector");
        plain.push(Grown { scene, build_ms });
        say_size(&plain, BYTES_AN_ITEM);
    }

    let inside: Vec<View> = INSIDE
        .iter()
        .map(|&(camera, turns, _)| view(&palace, camera, turns))
        .collect();
    let outward: Vec<View> = OUTWARD
        .iter()
        .map(|&(camera, turns)| view(&palace, camera, turns))
        .collect();
    for method in METHODS {
        println!("\n{method}");
        let mut grown: Vec<Grown> = Vec::new();
        for Grown { scene, .. } in &plain {
            let start = Instant::now();
            let scene = scene.with_method(method, u64::MAX).expect("no limit");
            let build_ms = start.elapsed().as_secs_f64() * 1e3;
            grown.push(Grown { scene, build_ms });
            say_size(&grown, BYTES_AN_ITEM + BYTES_BUILT);
        }
        let mut viewers: Vec<Viewer> = grown.iter().map(|_| viewer()).collect();
        let counted: Vec<Counted> = grown
            .iter()
            .zip(&mut viewers)
            .map(|(grown, viewer)| count(&grown.scene, method, &inside, viewer))
            .collect();
        let items: Vec<usize> = counted.iter().map(|counted| counted.items).collect();
        let [first, last] = [&counted[0].boxes, &counted[counted.len() - 1].boxes];
        let growth = median(growth(first, last));
        println!("  items inside {items:?}; boxes tested grow {growth:.2} times");
        assert!(
            growth < MAX_GROWTH,
            "{method}: boxes tested grow {growth:.2} times"
        );
        if all {
            say_times("inside", &times(&grown, &inside, &mut viewers));
            say_times("outward", &times(&grown[1..], &outward, &mut viewers[1..]));
        }
    }
}

/// Returns the ratio last / first, per view.
fn growth(first: &[f64], last: &[f64]) -> Vec<f64> {
    last.iter().zip(first).map(|(last, first)| last / first).collect()
}

/// Prints the last of several sizes, and checks that memory grows with the items alone. Compares with the first whole
/// palace, which has all meshes.
fn say_size(grown: &[Grown], max_bytes: u64) {
    let last = &grown[grown.len() - 1];
    let (scene, build_ms) = (&last.scene, last.build_ms);
    print!("{:14}{:11}", scene.triangle_count(), scene.item_count());
    if grown.len() > 2 {
        let first = &grown[1].scene;
        let more = (scene.item_count() - first.item_count()) as u64;
        let bytes = (scene.bytes() - first.bytes()) / more;
        println!("{bytes:22}{build_ms:10.0}");
        assert!(bytes <= max_bytes, "{bytes} bytes per added item");
    } else {
        println!("{:>22}{build_ms:10.0}", format!("({} total)", scene.bytes()));
    }
}

/// Prints the median look of each size, and the ratio of last to first.
fn say_times(what: &str, times: &[Vec<f64>]) {
    print!("  look {what:8}");
    for views in times {
        print!("{:9.2}", median(views.clone()));
    }
    let ratios = growth(&times[0], &times[times.len() - 1]);
    let most = ratios.iter().copied().fold(0.0, f64::max);
    println!(
        " ms; growth per view: median {:.2}, maximum {most:.2}",
        median(ratios)
    );
}
