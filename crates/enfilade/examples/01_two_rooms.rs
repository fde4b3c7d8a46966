//! Two rooms and a doorway: what is seen through it, step by step along the wall before it.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    // The wall between the rooms is the plane z = 0, with a doorway one metre wide; in front of it is the hall.
    let doorway = ConvexPolygon::rectangle([-0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
    let pillars = [("vase", -0.9, 0.6), ("bust", 0.9, 0.6)];
    let hall = room(&pillars, doorway.clone())?;
    let pillars = [("globe", -2.0, -4.0), ("desk", 0.0, -4.0), ("clock", 2.0, -4.0)];
    let study = room(&pillars, doorway.flipped())?;

    let mut scene = SceneBuilder::new();
    let hall = scene.add("hall", hall, Method::HierarchicalZ);
    let study = scene.add("study", study, Method::HierarchicalZ);
    scene.door((hall, OpeningId(0)), (study, OpeningId(0)));
    let scene = scene.build()?;

    let mut viewer = Viewer::new();
    for x in [-2.0, -1.0, 0.0, 1.0, 2.0] {
        let set = viewer.look(&scene, &View::new([x, 1.0, 3.0], [x, 1.0, 0.0], [640, 360]));
        println!("from x = {x}:");
        for (id, passage) in (0..).map(PassageId).zip(set.passages()) {
            let geometry = scene.geometry(passage.sector).expect("built from geometry");
            let here = set.items().iter().filter(|seen| seen.passage == id);
            let names: Vec<&str> = here.map(|seen| geometry.name(seen.item)).collect();
            let sector = scene.sector_name(passage.sector);
            println!("  {} in the {sector}", names.join(", "));
        }
    }
    Ok(())
}

/// Pillars at places (x, z), and a doorway: the first opening of each room is `OpeningId(0)`.
fn room(pillars: &[(&str, f32, f32)], doorway: ConvexPolygon) -> Result<Geometry, Box<dyn Error>> {
    let mut stone = Material::opaque([0.6, 0.6, 0.5]);
    stone.double_sided = true;
    let mut room = GeometryBuilder::new([stone]);
    let corners = [[-0.2, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 1.5, 0.0]];
    let pillar = room.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0))?);
    for &(name, x, z) in pillars {
        room.item(name, pillar, Transform::translation([x, 0.0, z]));
    }
    room.opening("doorway", doorway);
    Ok(room.build()?)
}
