//! Draws a baked scene twice: with coarser meshes alone, as before its pages are loaded, and with its own.
//!
//! `cargo run --release -p enfilade_stream --example levels -- SCENE.enf X,Y,Z X,Y,Z`: the eye, and what it looks at. Writes
//! `levels.png` and `whole.png`.
#![allow(clippy::print_stdout, reason = "the answer")]

use enfilade::{ItemIndex, Method, Scene, SectorId, View, Viewer};
use enfilade_draw::{Settings, Stage};
use enfilade_import::{Pages, ReadOptions};
use std::collections::HashMap;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [file, eye, toward] = &args[..] else {
        return Err("usage: levels SCENE.enf X,Y,Z X,Y,Z".into());
    };
    let view = View::new(point(eye)?, point(toward)?, [1280, 720])?;
    let options = ReadOptions {
        limit_bytes: u64::MAX,
        ..ReadOptions::default()
    };
    let (import, pages) = Pages::open(Path::new(file), &options)?;
    let mut levels = HashMap::new();
    for page in 0..pages.count() {
        levels.extend(pages.load_levels(page)?);
    }
    let mut scene = import.scene(Method::ZBuffer, u64::MAX)?;
    let mut edit = scene.edit();
    for (room, sector) in import.rooms.iter().zip((0..).map(SectorId)) {
        for (item, index) in room.geometry.items().iter().zip((0..).map(ItemIndex)) {
            if let Some(level) = levels.get(&pages.mesh_of(sector.0 as usize, item.mesh)) {
                edit.set_mesh(sector, index.into(), level.clone())?;
            }
        }
    }
    edit.finish()?;
    draw(&scene, &view, "levels.png")?;
    let whole = enfilade_import::read(Path::new(file), &options)?;
    draw(&whole.scene(Method::ZBuffer, u64::MAX)?, &view, "whole.png")
}

fn point(text: &str) -> Result<[f64; 3], Box<dyn Error>> {
    let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let numbers: Result<[f64; 3], _> = numbers.try_into();
    numbers.map_err(|_| format!("{text}: expected X,Y,Z").into())
}

fn draw(scene: &Scene, view: &View, file: &str) -> Result<(), Box<dyn Error>> {
    let picture = Stage::new(scene).draw(&mut Viewer::new(), scene, view, &Settings::default());
    picture.image.save(file)?;
    println!("{file}: {} triangles", scene.triangle_count());
    Ok(())
}
