//! Reads a file and says what is in it: `cargo run --release -p enfilade_import --example read_a_file -- FILE`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use enfilade_import::{ReadOptions, read};
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("name a .glb, .gltf or .obj file")?;
    let start = Instant::now();
    let import = read(Path::new(&file), &ReadOptions::default())?;
    let took = start.elapsed();

    println!("read in {took:.1?}");
    for room in &import.rooms {
        let geometry = &room.geometry;
        println!(
            "{}: {} items, {} triangles, {} openings, {} bytes in memory",
            room.name,
            geometry.items().len(),
            geometry.triangle_count(),
            geometry.openings().len(),
            geometry.bytes()
        );
    }
    for camera in &import.cameras {
        println!("camera {:?} at {:?}", camera.name, camera.eye);
    }
    for warning in &import.warnings {
        println!("warning: {warning}");
    }
    Ok(())
}
