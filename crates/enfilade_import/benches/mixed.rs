//! Measures the gain of mixing methods: a house in a valley (`common/land.rs`), with one method for the land and one
//! for the house, compared with one method for both.
//!
//! Views are toward each window and outer door from outside, and out of each from inside, at 1280x720. Every set is
//! compared with the first, exact one: a wrong one is an error, not a time. All contenders look in turn, view by view:
//! one round to warm up, then five; the median of five for each view, then the mean of the views, because half of them
//! show only the house.
#![allow(clippy::print_stdout, reason = "a bench prints its tables")]

mod common;

use common::land::{INSIDE, OUTSIDE, house_in_a_valley};
use common::{Paint, SIZE, folder, in_turn};
use enfilade::{Contract, ItemIndex, Method, Scene, SectorId, View, Viewer, ViewerOptions};
use std::collections::BTreeSet;

const ROUNDS: usize = 5;

/// One method for both.
const ALONE: [Method; 7] = [
    Method::HierarchicalZ,
    Method::HierarchicalS,
    Method::SBuffer,
    Method::ZBuffer,
    Method::Masked,
    Method::Svbsp,
    Method::Mobsp,
];

/// The land, then the house.
const MIXED: [[Method; 2]; 6] = [
    [Method::FloatingHorizon, Method::HierarchicalZ],
    [Method::FloatingHorizon, Method::HierarchicalS],
    [Method::HierarchicalZ, Method::HierarchicalS],
    [Method::HierarchicalS, Method::HierarchicalZ],
    [Method::FloatingHorizon, Method::Masked],
    [Method::Masked, Method::HierarchicalS],
];

fn main() {
    let Some(folder) = folder() else { return };
    let (scene, views) = house_in_a_valley(&folder, [Method::HierarchicalZ; 2], SIZE);
    let contenders: Vec<[Method; 2]> = MIXED.into_iter().chain(ALONE.map(|method| [method; 2])).collect();
    let scenes: Vec<Scene> = contenders.iter().map(|&methods| by(&scene, methods)).collect();
    let seen: Vec<usize> = scenes
        .iter()
        .map(|scene| items(scene, &scenes[0], &views))
        .collect();
    let looks = times(&scenes, &views, |viewer, scene, view| {
        viewer.look(scene, view);
    });
    let mut paint = Paint::new();
    let draws = times(&scenes, &views, |viewer, scene, view| {
        viewer.draw(scene, view, &mut paint);
    });
    println!(
        "a house in a valley: {} views, ms; mean of the views",
        views.len()
    );
    println!("{:34} {:>9} {:>9} {:>7}", "land, house", "look", "draw", "items");
    for (place, [land, house]) in contenders.iter().enumerate() {
        println!(
            "{:34} {:9.3} {:9.3} {:7}",
            format!("{land}, {house}"),
            looks[place],
            draws[place],
            seen[place]
        );
    }
}

fn by(scene: &Scene, methods: [Method; 2]) -> Scene {
    let mut scene = scene.clone();
    for (sector, method) in [OUTSIDE, INSIDE].into_iter().zip(methods) {
        scene.set_method(sector, method).expect("it suits");
    }
    scene
}

/// Items seen over all views; those of the exact scene must be among them, and be all where this one is exact.
fn items(scene: &Scene, exact: &Scene, views: &[View]) -> usize {
    let [mut viewer, mut exact_viewer] = [(); 2].map(|()| Viewer::new());
    let is_exact = scene
        .sectors()
        .all(|id| scene.sector(id).contract(&ViewerOptions::default()) == Contract::Exact);
    let mut sum = 0;
    for view in views {
        let [found, must] = [
            distinct(&mut viewer, scene, view),
            distinct(&mut exact_viewer, exact, view),
        ];
        assert!(
            must.is_subset(&found),
            "{:?}: {:?} missed",
            view.eye,
            &must - &found
        );
        assert!(!is_exact || found == must, "{:?}: more than is seen", view.eye);
        sum += found.len();
    }
    sum
}

fn distinct(viewer: &mut Viewer, scene: &Scene, view: &View) -> BTreeSet<(SectorId, ItemIndex)> {
    let set = viewer.look(scene, view);
    let items = set.items().iter();
    items
        .map(|seen| (set.passage(seen.passage).sector, seen.item.index))
        .collect()
}

/// The mean over the views of what each scene takes.
fn times(scenes: &[Scene], views: &[View], run: impl FnMut(&mut Viewer, &Scene, &View)) -> Vec<f64> {
    let run = std::cell::RefCell::new(run);
    let mut contenders: Vec<Box<dyn FnMut(usize) + '_>> = Vec::new();
    for scene in scenes {
        let mut viewer = Viewer::new();
        let run = &run;
        contenders.push(Box::new(move |step| {
            run.borrow_mut()(&mut viewer, scene, &views[step])
        }));
    }
    let times = in_turn(views.len(), ROUNDS, &mut contenders);
    times
        .iter()
        .map(|steps| steps.iter().sum::<f64>() / steps.len() as f64)
        .collect()
}
