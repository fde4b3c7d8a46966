//! Measures culling over the 16 survey views at 1280x720, in three tables.
//!
//! The first compares each culling method with frustum culling alone (svbsp without occluders), and with the s-buffer
//! that traverses no tree: the time of a look, the ratio of reported to actually visible items, and the time of look
//! and picture together (sets that are not exact are drawn by a z-buffer). The second gives occlusion trees budgets of
//! 8 to 256 occluders. The third gives covers fewer cells than the viewport has samples.
//! Exact sets are counted first, and conservative ones must contain them: a wrong number is an error, not a time. All
//! contenders of a table look in turn, view by view: one round to warm up, then five; the median of five for each view,
//! then the median over the views.
#![allow(clippy::print_stdout, reason = "a bench prints its tables")]

mod common;

use common::{BenchScene, Paint, folder, in_turn, median_of, open};
use enfilade::{Method, Scene, Viewer};

const ROUNDS: usize = 5;

/// Scenes, and the number of items visible by every exact method, over all views.
const SCENES: [(&str, usize); 4] = [
    ("ifc_office_a.glb", 373),
    ("city_san_francisco.glb", 243),
    ("country_kitchen.glb", 545),
    ("san_miguel.glb", 28_395),
];

/// A method and its viewer options.
#[derive(Clone, Copy)]
struct Contender {
    method: Method,
    occluders: Option<u32>,
    cover_size: Option<[u32; 2]>,
}

impl Contender {
    fn of(method: Method) -> Contender {
        Contender {
            method,
            occluders: None,
            cover_size: None,
        }
    }

    fn viewer(&self) -> Viewer {
        let mut viewer = Viewer::new();
        viewer.options.occluders = self.occluders;
        viewer.options.cover_size = self.cover_size;
        viewer
    }
}

/// Visible items of a contender, and its time.
struct Outcome {
    items: usize,
    triangles: u64,
    look_ms: f64,
    draw_ms: f64,
}

fn main() {
    let Some(folder) = folder() else { return };
    for (file, expected) in SCENES {
        let place = open(&folder, file);
        methods(file, &place, expected);
        if file == "ifc_office_a.glb" {
            budgets(file, &place, expected);
        }
        resolutions(file, &place, expected);
    }
}

fn methods(file: &str, place: &BenchScene, expected: usize) {
    let frustum = Contender {
        occluders: Some(0),
        ..Contender::of(Method::Svbsp)
    };
    let all = [
        Method::SBuffer,
        Method::HierarchicalS,
        Method::HierarchicalZ,
        Method::Masked,
        Method::Svbsp,
        Method::Mobsp,
    ];
    let contenders: Vec<Contender> = [frustum].into_iter().chain(all.map(Contender::of)).collect();
    let results = run(place, &contenders);
    println!(
        "\n{file:24}{:>10}{:>14}{:>10}{:>10}{:>12}",
        "items", "per visible", "triangles", "look ms", "and picture"
    );
    for (number, (contender, result)) in contenders.iter().zip(&results).enumerate() {
        let name = if number == 0 {
            "frustum alone"
        } else {
            contender.method.name()
        };
        check(
            name,
            contender.method.contract() == enfilade::Contract::Exact,
            result,
            expected,
        );
        println!(
            "{name:24}{:10.1}{:14.2}{:10}{:10.2}{:12.2}",
            result.items as f64 / place.views.len() as f64,
            result.items as f64 / expected as f64,
            result.triangles / place.views.len() as u64,
            result.look_ms,
            result.draw_ms
        );
    }
    let [plain, tree] = [1, 2].map(|number| results[number].look_ms);
    println!(
        "s-buffer takes {:.1} times as long as hierarchical-s",
        plain / tree
    );
}

fn budgets(file: &str, place: &BenchScene, expected: usize) {
    const BUDGETS: [u32; 6] = [8, 16, 32, 64, 128, 256];
    let contenders: Vec<Contender> = BUDGETS
        .into_iter()
        .flat_map(|budget| {
            [Method::Svbsp, Method::Mobsp].map(|method| Contender {
                occluders: Some(budget),
                ..Contender::of(method)
            })
        })
        .collect();
    let results = run(place, &contenders);
    println!(
        "\n{file:24}{:>16}{:>10}{:>16}{:>10}",
        "svbsp/visible", "ms", "mobsp/visible", "ms"
    );
    for (budget, pair) in BUDGETS.iter().zip(results.chunks(2)) {
        let [by_faces, by_box] = [&pair[0], &pair[1]];
        check("svbsp", false, by_faces, expected);
        assert!(by_faces.items <= by_box.items, "mobsp shows all that svbsp does");
        let per_visible = |result: &Outcome| result.items as f64 / expected as f64;
        println!(
            "{budget:>9} occluders     {:16.2}{:10.2}{:16.2}{:10.2}",
            per_visible(by_faces),
            by_faces.look_ms,
            per_visible(by_box),
            by_box.look_ms
        );
    }
}

fn resolutions(file: &str, place: &BenchScene, expected: usize) {
    const COVERS: [[u32; 2]; 4] = [[1280, 720], [640, 360], [320, 180], [160, 90]];
    const METHODS: [Method; 3] = [Method::HierarchicalZ, Method::HierarchicalS, Method::Masked];
    let contenders: Vec<Contender> = COVERS
        .into_iter()
        .flat_map(|cover| {
            METHODS.map(|method| Contender {
                cover_size: Some(cover),
                ..Contender::of(method)
            })
        })
        .collect();
    let results = run(place, &contenders);
    let name = |method: Method| format!("{method}/visible");
    println!(
        "\n{file:24}{:>24}{:>9}{:>24}{:>9}{:>16}{:>9}",
        name(METHODS[0]),
        "ms",
        name(METHODS[1]),
        "ms",
        name(METHODS[2]),
        "ms"
    );
    for (cover, row) in COVERS.iter().zip(results.chunks(METHODS.len())) {
        print!("{:24}", format!("{}x{}", cover[0], cover[1]));
        for (result, width) in row.iter().zip([24, 24, 16]) {
            check("a cover of cells", false, result, expected);
            let per_visible = result.items as f64 / expected as f64;
            print!("{per_visible:width$.2}{:9.2}", result.look_ms);
        }
        println!();
    }
}

/// Definitely visible items must be in the set; an exact set contains nothing else.
fn check(name: &str, exact: bool, result: &Outcome, expected: usize) {
    assert!(
        result.items >= expected,
        "{name}: {} of {expected} items",
        result.items
    );
    assert!(
        !exact || result.items == expected,
        "{name}: {} items, not {expected}",
        result.items
    );
}

fn run(place: &BenchScene, contenders: &[Contender]) -> Vec<Outcome> {
    let views = &place.views;
    let scenes: Vec<Scene> = contenders
        .iter()
        .map(|contender| place.seen_by(contender.method).expect("they are not that large"))
        .collect();
    let mut counts = Vec::new();
    for (contender, scene) in contenders.iter().zip(&scenes) {
        let mut viewer = contender.viewer();
        let (mut items, mut triangles) = (0, 0);
        for view in views {
            items += viewer.look(scene, view).items().len();
            triangles += viewer.visible().triangle_count(scene);
        }
        counts.push((items, triangles));
    }
    let mut looks: Vec<Box<dyn FnMut(usize)>> = Vec::new();
    let mut draws: Vec<Box<dyn FnMut(usize)>> = Vec::new();
    for (contender, scene) in contenders.iter().zip(&scenes) {
        let mut viewer = contender.viewer();
        looks.push(Box::new(move |view| _ = viewer.look(scene, &views[view])));
        let (mut viewer, mut paint) = (contender.viewer(), Paint::new());
        draws.push(Box::new(move |view| {
            _ = viewer.draw(scene, &views[view], &mut paint)
        }));
    }
    let middle = |times: &[f64]| median_of(times.iter().copied());
    let looks = in_turn(views.len(), ROUNDS, &mut looks);
    let draws = in_turn(views.len(), ROUNDS, &mut draws);
    counts
        .iter()
        .zip(looks.iter().zip(&draws))
        .map(|(&(items, triangles), (looks, draws))| Outcome {
            items,
            triangles,
            look_ms: middle(looks),
            draw_ms: middle(draws),
        })
        .collect()
}
