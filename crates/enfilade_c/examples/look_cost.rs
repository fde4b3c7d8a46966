//! What a look costs by C and in Rust, in one process, in turn: 10,001 items, medians of many frames.
//!
//! Run with `cargo run --release -p enfilade_c --example look_cost`. Exits with 1 if both find different sets.
#![allow(unsafe_code, reason = "calls the functions as C does")]
#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "all pointers are to values of this program"
)]
#![allow(clippy::print_stdout, reason = "it prints what it measured")]

use enfilade::{
    ClipDepth, GeometryBuilder, Material, MaterialId, Mesh, Method, Scene, Transform, View, Viewer,
    ViewerOptions,
};
use enfilade_c::*;
use std::ptr::{null, null_mut};
use std::time::Instant;

/// Columns and rows of a city, and the ground.
const SIDE: usize = 100;
const ITEMS: usize = SIDE * SIDE + 1;
const FRAMES: usize = 4000;

/// The faces of a cube.
const TRIANGLES: [u16; 36] = [
    0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7,
    6,
];

/// Returns the corners of a cube of side 1.
fn corners() -> [[f32; 3]; 8] {
    std::array::from_fn(|number| [0, 1, 2].map(|axis| if number >> axis & 1 == 1 { 0.5 } else { -0.5 }))
}

/// Returns the transform of an item: the ground, then houses of different heights.
fn placed(number: usize) -> [f32; 16] {
    let at = |place: usize| place as f32 * 6.0 - 300.0;
    let ([x, z], size) = match number.checked_sub(1) {
        None => ([0.0, 0.0], [700.0, 0.1, 700.0]),
        Some(house) => {
            let height = 3.0 + (house * 7919 % 13) as f32;
            ([at(house % SIDE), at(house / SIDE)], [3.5, height, 3.5])
        }
    };
    let [w, h, d] = size;
    [
        w,
        0.0,
        0.0,
        0.0,
        0.0,
        h,
        0.0,
        0.0,
        0.0,
        0.0,
        d,
        0.0,
        x,
        0.5 * h,
        z,
        1.0,
    ]
}

/// Returns the view matrix of a frame: a walk along a street, looking around.
fn eye_from_world(frame: usize) -> [[f64; 4]; 4] {
    let (angle, x) = (frame as f64 * 0.002, frame as f64 * 0.05 - 100.0);
    let (sin, cos) = angle.sin_cos();
    let [ex, ey, ez] = [x, 1.7, 2.5];
    [
        [cos, 0.0, sin, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [-sin, 0.0, cos, 0.0],
        [-(cos * ex - sin * ez), -ey, -(sin * ex + cos * ez), 1.0],
    ]
}

const CLIP_FROM_EYE: [[f64; 4]; 4] = [
    [0.974, 0.0, 0.0, 0.0],
    [0.0, 1.732, 0.0, 0.0],
    [0.0, 0.0, 0.0, -1.0],
    [0.0, 0.0, 0.1, 0.0],
];

fn main() {
    // The same triangles: with other faces, a conservative method may find other sets.
    let indices = TRIANGLES.map(u32::from);
    let mesh = Mesh::triangles(&corners(), &indices, MaterialId(0)).expect("a cube");
    let mut city = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let cube = city.mesh(mesh);
    for number in 0..ITEMS {
        let [a, b, c, d, e, f, g, h, i, j, k, l, x, y, z, _] = placed(number);
        let _ = [d, h, l];
        let columns = [[a, b, c], [e, f, g], [i, j, k], [x, y, z]];
        city.item("", cube, Transform::from_columns(columns));
    }
    let rust_scene = Scene::single(city.build().expect("a city"), Method::Masked).expect("a scene");
    let mut rust_viewer = Viewer::with_options(ViewerOptions {
        parallel: false,
        ..ViewerOptions::default()
    });
    let (scene, viewer) = in_c();

    let words = ITEMS.div_ceil(64);
    let [mut rust_bits, mut c_bits] = [vec![0_u64; words], vec![0_u64; words]];
    let mut error: EnfiladeError = unsafe { std::mem::zeroed() };
    let [mut rust_times, mut c_times] = [Vec::new(), Vec::new()];
    let (mut visible, mut rust_first) = (0, true);
    for frame in 0..FRAMES {
        let mut in_rust = || {
            let start = Instant::now();
            let view = View::from_matrices(
                eye_from_world(frame),
                CLIP_FROM_EYE,
                ClipDepth::OneToZero,
                [1280, 720],
            )
            .expect("a view");
            let set = rust_viewer.look(&rust_scene, &view);
            rust_bits.fill(0);
            set.mark(&mut rust_bits);
            rust_times.push(start.elapsed().as_nanos());
            set.items().len()
        };
        let mut by_c = || unsafe {
            let start = Instant::now();
            let mut view: EnfiladeView = std::mem::zeroed();
            view.eye_from_sector = flat(&eye_from_world(frame));
            view.clip_from_eye = flat(&CLIP_FROM_EYE);
            view.clip_depth = EnfiladeClipDepth::OneToZero as u32;
            (view.width, view.height) = (1280, 720);
            let looked = enfilade_viewer_look(viewer, scene, &view, null_mut(), &mut error);
            let read = enfilade_viewer_bits(viewer, c_bits.as_mut_ptr(), words, &mut error);
            c_times.push(start.elapsed().as_nanos());
            assert_eq!([looked, read], [EnfiladeStatus::Ok; 2]);
        };
        // Each is first in half of the frames: the second finds the caches warm, or too full.
        if rust_first {
            visible += in_rust();
            by_c();
        } else {
            by_c();
            visible += in_rust();
        }
        rust_first = !rust_first;
        assert!(rust_bits == c_bits, "frame {frame}: the sets differ");
    }
    let [rust, c] = [rust_times, c_times].map(|mut times| {
        times.sort_unstable();
        times[times.len() / 2] as f64 / 1000.0
    });
    println!(
        "{ITEMS} items, {} visible on average; medians of {FRAMES} frames: {rust:.1} us in Rust, {c:.1} us by C, ratio {:.3}",
        visible / FRAMES,
        c / rust
    );
}

/// Builds the same scene by C, and a viewer.
fn in_c() -> (*mut EnfiladeScene, *mut EnfiladeViewer) {
    let corners = corners();
    let part = EnfiladeMeshPart {
        positions: corners.as_ptr().cast(),
        position_count: 8,
        position_stride: 0,
        indices: TRIANGLES.as_ptr().cast(),
        index_count: 36,
        index_size: 2,
        material: 0,
    };
    let material = EnfiladeMaterial {
        color: [0.5, 0.5, 0.5, 1.0],
        alpha: 0,
        double_sided: 0,
        detail: 0,
    };
    let (mut mesh, mut scene, mut viewer, mut sector) = (null_mut(), null_mut(), null_mut(), 0);
    let mut ids = vec![0_u64; ITEMS];
    unsafe {
        enfilade_mesh_create(ENFILADE_VERSION, &part, 1, &mut mesh, null_mut());
        enfilade_scene_create(ENFILADE_VERSION, &mut scene, null_mut());
        enfilade_scene_add_sector(scene, null(), 0, &material, 1, &mut sector, null_mut());
        let item = |number: usize| EnfiladeItem {
            mesh,
            key: number as u64,
            sector_from_item: placed(number),
            options: EnfiladeItemOptions {
                flags: 0,
                layers: 0,
                max_distance: 0.0,
                min_size_px: 0.0,
            },
            name: null(),
        };
        let items: Vec<EnfiladeItem> = (0..ITEMS).map(item).collect();
        let added =
            enfilade_scene_add_items(scene, sector, items.as_ptr(), ITEMS, ids.as_mut_ptr(), null_mut());
        assert_eq!(added, EnfiladeStatus::Ok);
        let created = enfilade_viewer_create(ENFILADE_VERSION, null(), &mut viewer, null_mut());
        assert_eq!(created, EnfiladeStatus::Ok);
    }
    (scene, viewer)
}

fn flat(columns: &[[f64; 4]; 4]) -> [f64; 16] {
    std::array::from_fn(|number| columns[number / 4][number % 4])
}
