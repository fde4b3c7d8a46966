//! A mirror is a portal that leads back: the same things once more, and nothing of what is behind its glass.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;

/// A picture in letters: the first of each item's name, as a capital where it is seen in the mirror.
struct Letters<'a>(&'a Geometry, bool, Vec<Vec<u8>>);

impl Canvas for Letters<'_> {
    fn enter(&mut self, _id: PassageId, passage: &Passage) {
        self.1 = passage.mirrored();
    }
    fn row(&mut self, y: u16, spans: &[Span]) {
        for span in spans {
            let name = span.owner.item().map_or("#", |item| self.0.name(item));
            let first = name.as_bytes()[0];
            let letter = if self.1 { first.to_ascii_uppercase() } else { first };
            self.2[usize::from(y)][span.x0.into()..span.x1.into()].fill(letter);
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut paper = Material::opaque([0.9; 3]);
    paper.double_sided = true;
    let mut room = GeometryBuilder::new([paper]);
    let corners = [[-0.7, 0.0, 0.0], [0.7, 0.0, 0.0], [0.0, 1.4, 0.0]];
    let kite = room.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0))?);
    room.item("armchair", kite, Transform::translation([-0.8, 0.0, -2.0]));
    room.item(
        "bookcase behind you",
        kite,
        Transform::translation([0.8, 0.5, 2.0]),
    );
    room.item(
        "cat behind the glass",
        kite,
        Transform::translation([0.2, 0.8, -4.0]),
    );
    // The glass is the plane z = -3, two metres wide; its front faces the eye.
    let glass = ConvexPolygon::rectangle([-1.0, 0.0, -3.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])?;
    let mirror = room.opening("mirror", glass);

    let mut scene = SceneBuilder::new();
    let room = scene.add("room", room.build()?, Method::HierarchicalZ);
    scene.mirror(room, mirror);
    let scene = scene.build()?;

    let geometry = scene.geometry(room).expect("built from geometry");
    let mut letters = Letters(geometry, false, vec![vec![b'.'; 72]; 24]);
    let view = View::new([0.0, 1.0, 0.0], [0.0, 1.0, -3.0], [72, 24]);
    for seen in Viewer::new().draw(&scene, &view, &mut letters).items() {
        println!("{} through passage {}", geometry.name(seen.item), seen.passage.0);
    }
    for row in letters.2 {
        println!("{}", String::from_utf8(row)?);
    }
    Ok(())
}
