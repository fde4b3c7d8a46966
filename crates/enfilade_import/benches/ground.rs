//! Measures terrain from the ground: the heights of Jacksboro with each method that culls well, at 1280x720.
//!
//! A camera 1.7 m above the lowest point of each of nine parts of the terrain, in a valley, looks in the four cardinal
//! directions. All exact sets must be equal. The work is measured by the block clusters that a cover receives: a block
//! of 32x32 cells has about forty. A picture has light and sky; its time includes the look and the shading. All
//! contenders take turns view by view: one round to warm up, then five; the median of five for each view, then the
//! median over the views.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use common::{SIZE, folder, in_turn, median_of};
use enfilade::{ItemIndex, Method, Ray, Scene, View, Viewer};
use enfilade_draw::{Settings, Stage};
use enfilade_import::{ReadOptions, read};

const ROUNDS: usize = 5;
const METHODS: [Method; 5] = [
    Method::FloatingHorizon,
    Method::HierarchicalZ,
    Method::HierarchicalS,
    Method::Masked,
    Method::ZBuffer,
];
/// Height of an eye above the ground, in metres.
const EYE: f32 = 1.7;
/// Places across the field that are asked for their height, along each side of one of nine parts.
const PLACES: usize = 60;

fn main() {
    let Some(folder) = folder() else { return };
    let file = folder.join("terrain_jacksboro.json");
    let import = read(&file, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let scene = import
        .scene(Method::ZBuffer, Method::DEFAULT_LIMIT)
        .expect("one sector");
    let geometry = &import.rooms[0].geometry;
    let clusters: usize = (0..geometry.items().len() as u32)
        .map(|item| geometry.mesh_of(ItemIndex(item)).clusters().len())
        .sum();
    let views = valleys(&scene);
    let scenes = METHODS.map(|method| scene.with_method(method, Method::DEFAULT_LIMIT).expect("it fits"));

    let mut touched = vec![Vec::new(); METHODS.len()];
    let mut seen = vec![Vec::new(); METHODS.len()];
    let mut in_view = Vec::new();
    for view in &views {
        for (number, scene) in scenes.iter().enumerate() {
            let mut viewer = Viewer::new();
            let set = viewer.look(scene, view);
            seen[number].push(set.items().len());
            if number == 0 {
                in_view.push(set.in_frustum(scene).0);
            }
            touched[number].push(viewer.stats().batches as usize);
        }
        let [first, second] = [0, 1].map(|number| seen[number].last());
        assert_eq!(first, second, "{view:?}: two exact sets");
    }
    let looks = times(&scenes, &views, |viewer, scene, view| {
        viewer.look(scene, view);
    });
    let stage = Stage::new(&scene);
    let settings = Settings::default();
    let draws = times(&scenes, &views, |viewer, scene, view| {
        stage.draw(viewer, scene, view, &settings);
    });

    let blocks = geometry.items().len();
    println!(
        "{} views from valleys; {blocks} blocks of {clusters} clusters, {} in view",
        views.len(),
        mean(&in_view)
    );
    println!(
        "{:18}{:>8}{:>10}{:>8}{:>9}{:>9}",
        "method", "blocks", "clusters", "of all", "look ms", "draw ms"
    );
    for (number, method) in METHODS.iter().enumerate() {
        let taken = mean(&touched[number]);
        println!(
            "{:18}{:8.1}{taken:10.0}{:7.1}%{:9.2}{:9.2}",
            method.name(),
            mean(&seen[number]),
            100.0 * taken / clusters as f64,
            looks[number],
            draws[number]
        );
    }
}

/// From the lowest place of each of nine parts of the field, to the four winds.
fn valleys(scene: &Scene) -> Vec<View> {
    let only = scene.sectors().next().expect("one sector");
    let bounds = scene.bounds(only);
    let at = |share: f32, axis: usize| bounds.min[axis] + share * (bounds.max[axis] - bounds.min[axis]);
    let height = |x: f32, z: f32| {
        let top = bounds.max[1] + 1.0;
        let down = Ray {
            origin: [x, top, z],
            direction: [0.0, -1.0, 0.0],
        };
        let hit = scene.sector(only).cast(&down);
        hit.map_or(f32::INFINITY, |hit| top - hit.distance as f32)
    };
    let mut views = Vec::new();
    for part in 0..9 {
        let place = |number: usize, part: usize, axis: usize| {
            at((part as f32 + (number as f32 + 0.5) / PLACES as f32) / 3.0, axis)
        };
        let places = (0..PLACES * PLACES).map(|number| {
            let [x, z] = [
                place(number % PLACES, part % 3, 0),
                place(number / PLACES, part / 3, 2),
            ];
            [x, height(x, z), z]
        });
        let [x, y, z] = places
            .min_by(|a, b| a[1].total_cmp(&b[1]))
            .expect("there are places");
        let eye = [x, y + EYE, z];
        for [east, south] in [[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]] {
            views.push(View::new(eye, [x + east, y + EYE, z + south], SIZE));
        }
    }
    views
}

fn mean(numbers: &[usize]) -> f64 {
    numbers.iter().sum::<usize>() as f64 / numbers.len() as f64
}

/// The median over the views of what each scene takes.
fn times(scenes: &[Scene], views: &[View], run: impl Fn(&mut Viewer, &Scene, &View)) -> Vec<f64> {
    let run = &run;
    let contender = |scene| -> Box<dyn FnMut(usize) + '_> {
        let mut viewer = Viewer::new();
        Box::new(move |step| run(&mut viewer, scene, &views[step]))
    };
    let mut contenders: Vec<_> = scenes.iter().map(contender).collect();
    let times = in_turn(views.len(), ROUNDS, &mut contenders);
    times
        .iter()
        .map(|steps| median_of(steps.iter().copied()))
        .collect()
}
