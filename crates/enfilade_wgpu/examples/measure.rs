//! Times looks and the encoding of draw calls on a scene, and counts what culling saves: `measure SCENE [VIEWS]`.
#![allow(clippy::print_stdout)]

use enfilade::{Camera, Method, View, Viewer, survey};
use enfilade_draw::Stage;
use enfilade_import::ReadOptions;
use enfilade_wgpu::{Frame, Headless};
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    const SIZE: [u32; 2] = [1280, 720];
    const FRAMES: u32 = 5;
    let mut words = std::env::args().skip(1);
    let name = words.next().ok_or("usage: measure SCENE [VIEWS]")?;
    let count: usize = words.next().map_or(Ok(16), |count| count.parse())?;
    let (scene, cameras) = match name.strip_prefix('@') {
        Some(built_in) => {
            let found = enfilade_scenes::built_in(built_in).ok_or("no such built-in scene")?;
            (found.scene, found.cameras)
        }
        None => {
            let options = ReadOptions {
                limit_bytes: 8_000_000_000,
                ..ReadOptions::default()
            };
            let import = enfilade_import::read(Path::new(&name), &options)?;
            (import.scene(Method::Masked, options.limit_bytes)?, import.cameras)
        }
    };
    let surveyed = survey(&scene, count).views;
    let from_survey = surveyed.iter().map(|view| Camera {
        sector: Some(view.sector),
        ..Camera::new(view.eye, view.toward)
    });
    let cameras: Vec<Camera> = match cameras.is_empty() {
        true => from_survey.collect(),
        false => cameras.into_iter().take(count).collect(),
    };
    let stage = Stage::new(&scene);
    let mut gpu = Headless::new(1)?;
    println!(
        "{name}, {} views of {}x{}, {}",
        cameras.len(),
        SIZE[0],
        SIZE[1],
        gpu.gpu.adapter.get_info().name
    );
    // Culled, and by the frustum and portals alone.
    let mut totals = [[0.0; 5]; 2];
    for camera in &cameras {
        let view: View = camera.view(SIZE)?;
        for (occlusion, total) in [true, false].into_iter().zip(&mut totals) {
            let mut viewer = Viewer::new();
            viewer.options.occlusion = occlusion;
            let (mut look, mut encode) = (f64::INFINITY, f64::INFINITY);
            // The first frame uploads meshes and textures.
            for _ in 0..=FRAMES {
                let start = Instant::now();
                let visible = viewer.look(&scene, &view);
                look = look.min(start.elapsed().as_secs_f64() * 1e3);
                let frame = Frame::new(&scene, &stage, &view, visible);
                let start = Instant::now();
                let stats = gpu.encode(&frame);
                encode = encode.min(start.elapsed().as_secs_f64() * 1e3);
                total[3] += f64::from(stats.draw_calls) / f64::from(FRAMES + 1);
            }
            let start = Instant::now();
            let (_, drawn) = gpu.draw(&Frame::new(&scene, &stage, &view, viewer.visible()))?;
            total[2] += start.elapsed().as_secs_f64() * 1e3;
            total[4] += drawn.triangles as f64;
            total[0] += look;
            total[1] += encode;
        }
    }
    let views = cameras.len() as f64;
    for (kind, total) in ["culled", "frustum and portals"].iter().zip(totals) {
        let [look, encode, whole, calls, triangles] = total.map(|sum| sum / views);
        println!(
            "{kind}: look {look:.2} ms, encode {encode:.2} ms, frame drawn and read back {whole:.0} ms, \
             {calls:.0} draw calls, {triangles:.0} triangles"
        );
    }
    let ratio = |what: usize| totals[0][what] / totals[1][what].max(1.0);
    println!(
        "draw calls {:.3}, triangles {:.3} of those without occlusion culling",
        ratio(3),
        ratio(4)
    );
    Ok(())
}
