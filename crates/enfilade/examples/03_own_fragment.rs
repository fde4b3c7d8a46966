//! A fragment of one's own: a grove that is a thousand trees from near, and one green sheet from afar.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;
use std::sync::Arc;

/// The trees, and the sheet, which looks as the first tree does.
struct Grove(Arc<dyn Fragment>, Arc<dyn Fragment>);

impl Grove {
    /// Chosen by how far off the eye is; in a mirror, by where it would stand behind the glass.
    fn seen_from(&self, [_, _, z]: [f64; 3]) -> &dyn Fragment {
        if z < 100.0 { &*self.0 } else { &*self.1 }
    }
}

impl Fragment for Grove {
    fn bounds(&self) -> Aabb {
        self.0.bounds().union(&self.1.bounds())
    }
    fn openings(&self) -> &[Opening] {
        &[]
    }
    fn contract(&self) -> Contract {
        Contract::Exact
    }
    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen) {
        self.seen_from(passage.eye()).gather(passage, memory, seen);
    }
    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Seen, canvas: &mut dyn Canvas) {
        self.seen_from(passage.eye()).draw(passage, memory, seen, canvas);
    }
    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.0.cast(ray)
    }
    fn surface(&self, item: ItemId, face: u32) -> Surface {
        self.0.surface(item, face)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = SceneBuilder::new();
    scene.add_own("grove", Arc::new(Grove(leaves(1000, 0.6)?, leaves(1, 40.0)?)));
    let (scene, mut viewer) = (scene.build()?, Viewer::new());
    for z in [10.0, 30.0, 90.0, 270.0] {
        let view = View::new([0.0, 2.0, z], [0.0; 3], [1280, 720]);
        println!("from {z} m: {} items", viewer.look(&scene, &view).items().len());
    }
    Ok(())
}

/// Leaves of a width, in rows of forty.
fn leaves(count: u16, width: f32) -> Result<Arc<dyn Fragment>, Box<dyn std::error::Error>> {
    let mut content = ContentBuilder::new([Material::opaque([0.1, 0.4, 0.1])]);
    let corners = [[0.0; 3], [width, 0.0, 0.0], [0.5 * width, 5.0, 0.0]];
    let leaf = content.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0))?);
    for n in 0..count {
        let place = [f32::from(n % 40) - 20.0, 0.0, -f32::from(n / 40)];
        content.item("leaf", leaf, Transform::translation(place));
    }
    Ok(Method::HierarchicalZ.build(Arc::new(content.build()?), Method::DEFAULT_LIMIT)?)
}
