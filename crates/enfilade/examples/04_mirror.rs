//! A mirror is a portal that leads back into the same room. Prints a picture in letters: the reflection shows items in
//! front of the glass, also those behind the camera, and none behind the glass.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;

/// A render target of letters: the initial of the visible item, upper case if it is seen in the mirror.
struct Letters<'a> {
    geometry: &'a Geometry,
    mirrored: bool,
    rows: Vec<Vec<u8>>,
}

impl Canvas for Letters<'_> {
    // Called before the spans of each passage: seen directly, or in the mirror.
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.mirrored = passage.mirrored();
    }
    // The spans of a row come from left to right, without overlap.
    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            let name = span.owner.item().map_or("#", |item| self.geometry.name(item));
            let first = name.as_bytes()[0];
            let letter = [first, first.to_ascii_uppercase()][usize::from(self.mirrored)];
            self.rows[usize::from(y)][span.x0.into()..span.x1.into()].fill(letter);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut room = GeometryBuilder::new([Material::opaque([0.9; 3])]);
    let block = room.mesh(Mesh::cuboid([-0.7, 0.0, -0.2], [0.7, 1.4, 0.2], MaterialId(0))?);
    let at = Transform::translation;
    room.item("armchair", block, at([-1.2, 0.0, -2.0]));
    room.item("bookcase behind the camera", block, at([0.8, 0.5, 2.0]));
    room.item("cat behind the glass", block, at([0.2, 0.8, -4.0]));
    // The glass is in the plane z = -3, two metres wide; its front faces the camera.
    let glass = ConvexPolygon::rectangle([-1.0, 0.0, -3.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
    let mirror = room.opening("mirror", glass);
    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build()?, Method::HierarchicalZ);
    scene.mirror(room, mirror);
    let scene = scene.build()?;
    let mut letters = Letters {
        geometry: scene.geometry(room).expect("the room was built from geometry"),
        mirrored: false,
        rows: vec![vec![b'.'; 72]; 24],
    };
    let view = View::new([0.0, 1.0, 0.0], [0.0, 1.0, -3.0], [72, 24])?;
    let mut viewer = Viewer::new();
    let set = viewer.draw(&scene, &view, &mut letters);
    for (item, name) in set.items().iter().zip(set.names(&scene)) {
        println!("{name} through passage {}", item.passage.0);
    }
    for row in letters.rows {
        println!("{}", String::from_utf8(row)?);
    }
    Ok(())
}
