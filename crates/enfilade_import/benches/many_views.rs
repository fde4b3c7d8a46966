//! Cost of many views at once: a city of 10,000 boxes from a camera and four shadow cascades; that city and an office from
//! 64 players of a server.
//!
//! Sets are compared with those of single looks. The players look at 256x144, by a strict method; from 100 places of each, none
//! may miss an item that a z-buffer shows at 1280x720. With `cargo test` the city is a tenth as large, with a few places,
//! and nothing is timed.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use enfilade::{
    GeometryBuilder, Light, LightShape, Material, MaterialId, Mesh, Method, Scene, SectorId, ShadowCasters,
    Transform, View, Viewer, ViewerOptions, Viewers, VisibleSet, survey,
};
use std::hint::black_box;
use std::time::Instant;

/// Distance between houses.
const BLOCK: f64 = 14.0;

fn main() {
    let times = std::env::args().any(|argument| argument == "--bench");
    let side = if times { 100 } else { 32 };
    let city = city(side);
    println!("{} boxes, {}", side * side, Method::Masked);
    let views = with_cascades(side);
    let plain = ViewerOptions {
        occlusion: false,
        ..ViewerOptions::default()
    };
    let usual = ViewerOptions::default();
    compare("camera and 4 cascades", &city, &views, &usual, times);
    compare("camera", &city, &views[..1], &usual, times);
    compare("4 cascades without occlusion", &city, &views[1..], &plain, times);
    casters(&city, &views[0], times);
    let rounds = if times { PLACES } else { 1 };
    serve("city", &city, &players(side, PLAYERS * rounds), times);
    let Some(folder) = common::folder() else { return };
    let office = common::open(&folder, "ifc_office_a.glb").scene;
    let places = survey(&office, PLAYERS * rounds).views;
    let views: Vec<View> = places
        .iter()
        .map(|at| View::new(at.eye, at.toward, PLAYERS_SIZE).expect("a valid view"))
        .collect();
    serve("office", &office, &views, times);
}

/// Players, and how often they change their places.
const PLAYERS: usize = 64;
const PLACES: usize = 100;
/// Resolution of the looks of players, and of their screens.
const PLAYERS_SIZE: [u32; 2] = [256, 144];
const SCREEN: [u32; 2] = [1280, 720];

/// Looks of 64 players, and a check of all places.
fn serve(what: &str, scene: &Scene, views: &[View], times: bool) {
    for (method, occluders) in [(Method::Mobsp, 16), (Method::Svbsp, 32)] {
        let seen_by = |method: Method| scene.with_method(method, u64::MAX).expect("a small scene");
        let scene = seen_by(method);
        let options = ViewerOptions {
            occluders: Some(occluders),
            ..ViewerOptions::default()
        };
        println!("{what}, {method} with {occluders} occluders");
        compare("64 players", &scene, &views[..PLAYERS], &options, times);
        let exact = seen_by(Method::ZBuffer);
        let (mut players, mut screens) = (Viewers::with_options(options), Viewers::new());
        let (mut found, mut shown) = (0, 0);
        for views in views.chunks(PLAYERS) {
            let on_screen: Vec<View> = views.iter().map(at_screen).collect();
            let sets = players.look_many(&scene, views);
            let exact = screens.look_many(&exact, &on_screen);
            for (set, exact) in sets.iter().zip(exact) {
                let missed = exact.items().iter().find(|seen| {
                    let sector = exact.passage(seen.passage).sector;
                    !set.sees(sector, seen.item)
                });
                assert_eq!(missed, None, "{what}, {method}: a player misses an item");
                found += set.items().len();
                shown += exact.items().len();
            }
        }
        let views = views.len() as f64;
        println!(
            "  {views} views: {:.1} items each, of which a z-buffer shows {:.1}",
            found as f64 / views,
            shown as f64 / views
        );
        assert!(shown > 0 && found < 20 * shown, "{what}: {found} of {shown}");
    }
}

/// Returns the view of a player at the resolution of the screen.
fn at_screen(view: &View) -> View {
    View::new(view.eye(), view.toward(), SCREEN).expect("a valid view")
}

/// A look and the casters of a sun in four cascades.
fn casters(city: &Scene, view: &View, times: bool) {
    let mut city = city.clone();
    let shape = LightShape::Sun {
        direction: [0.4, -0.8, 0.45],
    };
    let sun = Light {
        shape,
        ..Light::point(SectorId(0), [0.0; 3], [1.0; 3], f32::INFINITY)
    };
    let sun = city.add_light(sun).expect("a valid light");
    let (mut viewer, mut shadows) = (Viewer::new(), ShadowCasters::new());
    viewer.options.parallel = false;
    shadows.options.parallel = false;
    shadows.cascades = vec![10.0, 30.0, 80.0, 200.0];
    let mut least = [f64::INFINITY; 2];
    let mut counts = Vec::new();
    for _ in 0..if times { 100 } else { 2 } {
        let start = Instant::now();
        let set = viewer.look(&city, view);
        least[0] = least[0].min(start.elapsed().as_secs_f64() * 1e3);
        let maps = shadows.find(&city, sun, set);
        least[1] = least[1].min(start.elapsed().as_secs_f64() * 1e3);
        counts = maps.iter().map(|map| map.casters.items().len()).collect();
    }
    println!("casters of a sun in 4 cascades: {counts:?}");
    if times {
        println!(
            "  look {:.3} ms, with casters {:.3} ms, on one thread",
            least[0], least[1]
        );
    }
}

/// A city of `side`² boxes on a plain.
fn city(side: u32) -> Scene {
    let mut city = GeometryBuilder::new([Material::opaque([0.6; 3])]);
    let kinds = [0, 1, 2, 3].map(|kind| {
        let [wide, high] = [5.0 + kind as f32, 6.0 + 4.0 * kind as f32];
        let low = [-0.5 * wide, 0.0, -3.25];
        city.mesh(Mesh::cuboid(low, [0.5 * wide, high, 3.25], MaterialId(0)).expect("a box"))
    });
    for number in 0..side * side {
        let at = [number % side, number / side].map(|step| step as f32 * BLOCK as f32);
        let kind = (number.wrapping_mul(2_654_435_761) >> 8) as usize % 4;
        city.item("box", kinds[kind], Transform::translation([at[0], 0.0, at[1]]));
    }
    Scene::single(city.build().expect("a city"), Method::Masked).expect("a city")
}

/// A camera over the roofs, and the cascades of a sun, each around a slice of what the camera may see.
fn with_cascades(side: u32) -> Vec<View> {
    const SUN: [f64; 3] = [0.4, -0.8, 0.45];
    const SLICES: [f64; 5] = [0.1, 10.0, 30.0, 80.0, 200.0];
    let middle = (f64::from(side / 2) + 0.5) * BLOCK;
    let (eye, ahead) = ([middle, 12.0, middle], [0.4, -0.06, 0.9]);
    let toward = [0, 1, 2].map(|axis| eye[axis] + ahead[axis]);
    let camera = View::new(eye, toward, [1280, 720]).expect("a valid view");
    let mut views = vec![camera];
    for slice in SLICES.windows(2) {
        let corner = |number: u32| {
            let at = [1280, 720].map(f64::from);
            let pixel = [0, 1].map(|axis| if number >> axis & 1 == 1 { at[axis] } else { 0.0 });
            let [origin, direction] = camera.ray(pixel);
            let along = slice[(number >> 2) as usize];
            [0, 1, 2].map(|axis| origin[axis] + direction[axis] * along)
        };
        let corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
        let centre = [0, 1, 2].map(|axis| corners.iter().map(|at| at[axis]).sum::<f64>() / 8.0);
        let distance = |at: &[f64; 3]| {
            (0..3)
                .map(|axis| (at[axis] - centre[axis]).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let radius = corners.iter().map(distance).fold(0.0, f64::max);
        let from = [0, 1, 2].map(|axis| centre[axis] - SUN[axis] * (radius + 50.0));
        views.push(
            View::parallel(from, centre, [0.0, 1.0, 0.0], 2.0 * radius, [1024, 1024]).expect("a valid view"),
        );
    }
    views
}

/// Players in the streets, who look along them.
fn players(side: u32, count: usize) -> Vec<View> {
    let of = |number: u32| {
        let place = |salt: u32| {
            let hash = (number + 1)
                .wrapping_mul(2_654_435_761)
                .wrapping_add(salt)
                .wrapping_mul(2_246_822_519);
            f64::from(hash >> 8) / f64::from(1 << 24)
        };
        let across = (place(1) * f64::from(side - 2)).floor() + 0.5;
        let along = place(2) * f64::from(side - 1);
        let eye = [across * BLOCK, 1.7, along * BLOCK];
        let (sin, cos) = (place(3) * std::f64::consts::TAU).sin_cos();
        View::new(eye, [eye[0] + sin, 1.7, eye[2] + cos], PLAYERS_SIZE).expect("a valid view")
    };
    (0..count as u32).map(of).collect()
}

/// Looks of all views at once, by one thread and by all of the pool, beside single looks.
fn compare(what: &str, scene: &Scene, views: &[View], options: &ViewerOptions, times: bool) {
    let alone = ViewerOptions {
        parallel: false,
        ..*options
    };
    let mut viewers: Vec<Viewer> = views.iter().map(|_| Viewer::with_options(alone)).collect();
    let [mut one, mut all] = [&alone, options].map(|options| Viewers::with_options(*options));
    let mut least = [f64::INFINITY; 3];
    for _ in 0..if times { 100 } else { 2 } {
        let mut time = |number: usize, work: &mut dyn FnMut()| {
            let start = Instant::now();
            work();
            least[number] = least[number].min(start.elapsed().as_secs_f64() * 1e3);
        };
        time(0, &mut || {
            for (viewer, view) in viewers.iter_mut().zip(views) {
                black_box(viewer.look(scene, view));
            }
        });
        time(1, &mut || {
            black_box(one.look_many(scene, views));
        });
        time(2, &mut || {
            black_box(all.look_many(scene, views));
        });
    }
    let keys = |set: &VisibleSet| set.items().iter().map(|item| item.key).collect::<Vec<_>>();
    for (number, viewer) in viewers.iter().enumerate() {
        let single = keys(viewer.visible());
        assert_eq!(single, keys(&one.visible()[number]), "{what}, view {number}");
        assert_eq!(single, keys(&all.visible()[number]), "{what}, view {number}");
    }
    let seen: usize = viewers.iter().map(|viewer| viewer.visible().items().len()).sum();
    let counts: Vec<_> = viewers
        .iter()
        .take(5)
        .map(|viewer| viewer.visible().items().len())
        .collect();
    assert!(seen > 4 * views.len(), "{what}: {seen} items seen");
    println!(
        "{what}: {seen} items in {} views, the first {counts:?}",
        views.len()
    );
    if times {
        let [single, one, all] = least;
        println!("  single looks {single:.3} ms, at once {one:.3} ms on one thread, {all:.3} ms on all");
    }
}
