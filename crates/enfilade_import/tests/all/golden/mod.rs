//! Compares every fixture, drawn by every method, with a reviewed golden picture.
//!
//! A change that is meant to change pictures writes new ones, to be looked at again:
//! `GOLDEN=write cargo test -p enfilade_import --test all golden`.

use enfilade::{Camera, Contract, Method, Scene, View, Viewer};
use enfilade_draw::{Exposure, RgbImage, Settings, Stage};
use enfilade_import::{Import, ReadOptions, read};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

const SIZE: [u32; 2] = [240, 135];
/// Tolerance for different math libraries, in steps of 1/255.
const NEAR: u8 = 2;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures")
}

/// The fixtures that must be read, by name.
fn fixtures() -> Vec<PathBuf> {
    let is_scene = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str());
        matches!(ending, Some("glb" | "gltf" | "obj"))
    };
    let entries = std::fs::read_dir(folder()).expect("the folder of fixtures");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(is_scene);
    files.sort();
    files
}

/// From where a scene is seen: its cameras, or before its middle, a little above and to the right.
fn views(import: &Import, scene: &Scene) -> Vec<(String, View)> {
    let by = |camera: &Camera| {
        let view = camera.view(SIZE).expect("a valid view");
        let name = if camera.name == "Camera" {
            String::new()
        } else {
            format!("@{}", camera.name)
        };
        (name, view)
    };
    if !import.cameras.is_empty() {
        return import.cameras.iter().map(by).collect();
    }
    let held = scene.sector(enfilade::SectorId(0)).bounds();
    let (middle, size) = (held.center(), held.size());
    let away = 1.3 * size.iter().map(|side| side * side).sum::<f32>().sqrt();
    let eye = [0, 1, 2].map(|axis| middle[axis] + away * [0.35, 0.45, 0.9][axis]);
    vec![(String::new(), View::new(eye, middle, SIZE).expect("a valid view"))]
}

fn drawn(scene: &Scene, view: &View) -> RgbImage {
    let mut settings = Settings::default();
    settings.exposure = Exposure::Eye(0.0);
    Stage::new(scene)
        .draw(&mut Viewer::new(), scene, view, &settings)
        .image
}

/// Returns the differences of a fixture's pictures.
fn faults(file: &Path) -> Vec<String> {
    let name = file.file_name().expect("a name").to_string_lossy().into_owned();
    let import = match read(file, &ReadOptions::default()) {
        Ok(import) => import,
        Err(error) => return vec![format!("{name}: {error}")],
    };
    let scene = import.scene(Method::ZBuffer, u64::MAX).expect("it is small");
    let mut faults = Vec::new();
    for (camera, view) in views(&import, &scene) {
        let golden = folder().join("golden").join(format!("{name}{camera}.png"));
        if std::env::var("GOLDEN").is_ok_and(|value| value == "write") {
            drawn(&scene, &view).save(&golden).expect("it can be written");
        }
        let expected = match image::open(&golden) {
            Ok(image) => image.into_rgb8(),
            Err(why) => {
                faults.push(format!("{}: {why}", golden.display()));
                continue;
            }
        };
        for method in Method::ALL
            .into_iter()
            .filter(|method| method.requires().is_none())
        {
            if method.contract() == Contract::Approximate {
                continue;
            }
            let scene = scene.with_method(method, u64::MAX).expect("it is small");
            let image = drawn(&scene, &view);
            let near = |(a, b): (&u8, &u8)| a.abs_diff(*b) <= NEAR;
            let off = image.pixels().zip(expected.pixels());
            let off = off.filter(|(a, b)| !a.0.iter().zip(&b.0).all(near)).count();
            if image.dimensions() != expected.dimensions() || off > 0 {
                faults.push(format!("{name}{camera} by {method}: {off} pixels are other"));
            }
        }
    }
    faults
}

#[test]
fn every_fixture_looks_as_it_did_when_it_was_looked_at() {
    let files = fixtures();
    assert!(files.len() >= 30, "only {} fixtures", files.len());
    let faults: Vec<String> = files.par_iter().flat_map(|file| faults(file)).collect();
    assert_eq!(faults, Vec::<String>::new());
}
