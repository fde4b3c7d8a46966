//! Every method on real scenes, over the 16 views of the survey at 1280x720: median times of a look, and by how much
//! each is faster than the z-buffer of the same run.
//!
//! A wrong number of visible items is an error, not a time. The timing rule is that of `enfilade look`: one walk over
//! all views to warm up, then three; the median of three for each view, then the median over the views.
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a bench prints its table"
)]

use enfilade::{Method, Scene, SceneBuilder, View, Viewer, survey};
use enfilade_import::{ReadOptions, read};
use std::path::Path;
use std::time::Instant;

/// Files, and how many items every exact method sees, over all views.
const SCENES: [(&str, usize); 4] = [
    ("sponza_crytek.glb", 974),
    ("ifc_office_a.glb", 414),
    ("city_san_francisco.glb", 1_502),
    ("country_kitchen.glb", 616),
];

const VIEWS: usize = 16;
const SIZE: [u32; 2] = [1280, 720];

fn main() {
    let Some(folder) = std::env::var_os("ENFILADE_SCENES") else {
        eprintln!("skipped: ENFILADE_SCENES names no folder of .glb files");
        return;
    };
    println!(
        "{:24}{:16}{:>10}{:>16}",
        "scene", "method", "look ms", "than z-buffer"
    );
    for (file, expected) in SCENES {
        let import = read(&Path::new(&folder).join(file), &ReadOptions::default());
        let mut scene = SceneBuilder::new();
        scene.add(
            file,
            import.unwrap_or_else(|error| panic!("{error}")).content,
            Method::ZBuffer,
        );
        let scene = scene.build().expect("one fragment");
        let places = survey(&scene, VIEWS);
        let views: Vec<View> = places
            .iter()
            .map(|at| View::new(at.eye, at.toward, SIZE))
            .collect();
        let baseline = look(&scene, Method::ZBuffer, &views, file, expected);
        for method in Method::ALL {
            let ms = match method {
                Method::ZBuffer => baseline,
                _ => look(&scene, method, &views, file, expected),
            };
            println!("{file:24}{:16}{ms:10.2}{:15.1}x", method.name(), baseline / ms);
        }
    }
}

/// The median look over all views, in milliseconds.
fn look(scene: &Scene, method: Method, views: &[View], file: &str, expected: usize) -> f64 {
    let scene = scene
        .with_method(method, Method::DEFAULT_LIMIT)
        .expect("they are not that large");
    let mut viewer = Viewer::new();
    let seen: usize = views
        .iter()
        .map(|view| viewer.look(&scene, view).items().len())
        .sum();
    assert_eq!(seen, expected, "{method} on {file}");
    let mut times = vec![[0.0; 3]; views.len()];
    for pass in 0..3 {
        for (view, times) in views.iter().zip(&mut times) {
            let start = Instant::now();
            viewer.look(&scene, view);
            times[pass] = start.elapsed().as_secs_f64() * 1e3;
        }
    }
    median(
        times
            .into_iter()
            .map(|mut times| median(&mut times))
            .collect::<Vec<f64>>()
            .as_mut_slice(),
    )
}

/// The value in the middle, or between the two in the middle.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}
