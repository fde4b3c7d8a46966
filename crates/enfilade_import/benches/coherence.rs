//! Measures what an s-buffer saves by temporal coherence: walks of 100 frames at 1280x720 from each of the 16 survey
//! views.
//!
//! Each frame moves 3 cm along the view direction and turns 0.4 degrees to the left; walls do not stop the walk. With
//! and without coherence, the visible items and clusters must be equal in every frame, and their total must match the
//! table; on the office, a third of the comparisons must be saved, over all walks. Times: both variants take turns at
//! each frame; mean of all.
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

mod common;

use common::{BenchScene, folder, median_of, open};
use enfilade::{Method, Scene, Transform, View, Viewer, VisibleItem};
use std::time::Instant;

const FRAMES: usize = 100;
const STEP_M: f32 = 0.03;
const TURN_DEGREES: f64 = 0.4;

/// Files, and the items seen over all frames of all walks.
const WALKED: [(&str, usize); 3] = [
    ("ifc_office_a.glb", 35_829),
    ("sponza_crytek.glb", 65_591),
    ("classroom.glb", 28_516),
];

/// On the office at least this part of the comparisons must be saved.
const LEAST_SAVED: f64 = 1.0 / 3.0;

/// Costs of looks.
#[derive(Clone, Copy, Default)]
struct Cost {
    compared: u64,
    triangles: u64,
    ms: f64,
}

fn main() {
    let Some(folder) = folder() else { return };
    println!(
        "per frame: spans compared, triangles set up, and the time of a look; without memory, with it, and what it \
         saves;\nthe last: comparisons saved on the worst walk, the one in the middle, and the best\n\
         {:20}{:>9}{:>9}{:>7}{:>11}{:>9}{:>7}{:>9}{:>8}{:>7}{:>18}",
        "scene",
        "compared",
        "with",
        "saved",
        "triangles",
        "with",
        "saved",
        "look ms",
        "with",
        "saved",
        "worst to best"
    );
    for (file, expected) in WALKED {
        let place = open(&folder, file);
        let scene = place.seen_by(Method::SBuffer).expect("it builds nothing");
        let (mut sum, mut items, mut saved) = ([Cost::default(); 2], 0, Vec::new());
        for start in &place.views {
            let (costs, seen) = walk(&scene, start);
            items += seen;
            let [without, with] = costs.map(|cost| cost.compared as f64);
            if without > 0.0 {
                saved.push(1.0 - with / without);
            }
            for (sum, cost) in sum.iter_mut().zip(costs) {
                sum.compared += cost.compared;
                sum.triangles += cost.triangles;
                sum.ms += cost.ms;
            }
        }
        assert_eq!(items, expected, "{file}: items over all frames");
        print_row(file, &place, sum, saved);
        let [without, with] = sum.map(|cost| cost.compared as f64);
        assert!(
            file != "ifc_office_a.glb" || 1.0 - with / without >= LEAST_SAVED,
            "{file}: memory saves less than a third of the comparisons"
        );
    }
}

fn print_row(file: &str, place: &BenchScene, costs: [Cost; 2], mut saved: Vec<f64>) {
    let frames = (place.views.len() * FRAMES) as f64;
    let pair = |widths: [usize; 2], digits: usize, of: &dyn Fn(&Cost) -> f64| {
        let [without, with] = [of(&costs[0]) / frames, of(&costs[1]) / frames];
        let ([first, second], part) = (widths, 100.0 * (1.0 - with / without));
        format!("{without:first$.digits$}{with:second$.digits$}{part:5.0} %")
    };
    let middle = median_of(saved.iter().copied());
    saved.sort_by(f64::total_cmp);
    println!(
        "{file:20}{}{}{}{:6.0}{:6.0}{:4.0} %",
        pair([9, 9], 0, &|cost| cost.compared as f64),
        pair([11, 9], 0, &|cost| cost.triangles as f64),
        pair([9, 8], 2, &|cost| cost.ms),
        100.0 * saved[0],
        100.0 * middle,
        100.0 * saved[saved.len() - 1],
    );
}

/// Walks once, without memory and with it. Gives what each cost, and the items seen over all frames.
fn walk(scene: &Scene, start: &View) -> ([Cost; 2], usize) {
    let mut viewers = [Viewer::new(), Viewer::new()];
    viewers[0].options.coherence = false;
    viewers
        .iter_mut()
        .for_each(|viewer| viewer.options.parallel = false);
    let (mut costs, mut items) = ([Cost::default(); 2], 0);
    for view in path(start) {
        let seen = [0, 1].map(|number| {
            let viewer = &mut viewers[number];
            let start = Instant::now();
            viewer.look(scene, &view);
            let cost = &mut costs[number];
            cost.ms += start.elapsed().as_secs_f64() * 1e3;
            cost.compared += viewer.stats().spans.compared;
            cost.triangles += viewer.stats().triangles;
            let set = viewer.visible();
            let clusters = |item: &VisibleItem| (item.item, set.clusters(item).to_vec());
            set.items().iter().map(clusters).collect::<Vec<_>>()
        });
        assert!(seen[0] == seen[1], "what is remembered changes the answer");
        items += seen[0].len();
    }
    (costs, items)
}

/// The frames of a walk.
fn path(start: &View) -> impl Iterator<Item = View> {
    let turn = Transform::rotation([0.0, 1.0, 0.0], TURN_DEGREES.to_radians());
    let (mut eye, size) = (start.eye().map(|value| value as f32), start.size());
    let mut ahead: [f32; 3] = std::array::from_fn(|axis| (start.toward()[axis] - start.eye()[axis]) as f32);
    let reach = ahead.iter().map(|side| side * side).sum::<f32>().sqrt();
    (0..FRAMES).map(move |_| {
        let view =
            View::new(eye, std::array::from_fn(|axis| eye[axis] + ahead[axis]), size).expect("a valid view");
        eye = std::array::from_fn(|axis| eye[axis] + ahead[axis] / reach * STEP_M);
        ahead = turn.direction(ahead);
        view
    })
}
