//! Two rooms joined by a doorway: which items are visible from five positions along the wall.
//!
//! Run with `cargo run --example 03_rooms -p enfilade`.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    // The wall between the rooms is the plane z = 0, with a doorway one metre wide. The hall is at z > 0, the study
    // at z < 0. Each room has its own opening polygon, which faces into that room.
    let doorway = ConvexPolygon::rectangle([-0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
    let hall = room(&[("vase", -0.9, 0.6), ("bust", 0.9, 0.6)], doorway.clone())?;
    let study = room(
        &[("globe", -2.0, -4.0), ("desk", 0.0, -4.0), ("clock", 2.0, -4.0)],
        doorway.flipped(),
    )?;

    // A scene is a set of sectors; a door is a pair of portals, one in each direction.
    let mut scene = SceneBuilder::new();
    let hall = scene.add("hall", hall, Method::HierarchicalZ);
    let study = scene.add("study", study, Method::HierarchicalZ);
    scene.door((hall, OpeningId(0)), (study, OpeningId(0)));
    let scene = scene.build()?;

    // Keep one viewer per camera: it reuses its buffers and the visible set of the last frame.
    let mut viewer = Viewer::new();
    for x in [-2.0, -1.0, 0.0, 1.0, 2.0] {
        let view = View::new([x, 1.0, 3.0], [x, 1.0, 0.0], [640, 360])?;
        let set = viewer.look(&scene, &view);
        println!("from x = {x}:");
        for (item, name) in set.items().iter().zip(set.names(&scene)) {
            let sector = set.passage(item.passage).sector;
            println!("  {name} in the {}", scene.sector_name(sector));
        }
    }
    Ok(())
}

/// A room with pillars at the given (x, z) and a doorway, which is its first opening: `OpeningId(0)`.
fn room(pillars: &[(&str, f32, f32)], doorway: ConvexPolygon) -> Result<Geometry, Box<dyn Error>> {
    let mut room = GeometryBuilder::new([Material::opaque([0.6, 0.6, 0.5])]);
    let pillar = room.mesh(Mesh::cuboid([-0.2, 0.0, -0.2], [0.2, 1.5, 0.2], MaterialId(0))?);
    for &(name, x, z) in pillars {
        room.item(name, pillar, Transform::translation([x, 0.0, z]));
    }
    room.opening("doorway", doorway);
    Ok(room.build()?)
}
