//! A custom sector behind a door: a room that stays dark until the camera comes near.
#![expect(clippy::print_stdout, reason = "examples print")]

use enfilade::*;
use std::sync::Arc;

/// Wraps a built-in sector and hides its items while the light is off.
struct Lit(Arc<dyn Sector>);

impl Sector for Lit {
    fn bounds(&self) -> Aabb {
        self.0.bounds()
    }
    fn openings(&self) -> &[Opening] {
        self.0.openings()
    }
    fn contract(&self, options: &ViewerOptions) -> Contract {
        self.0.contract(options)
    }
    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        // The eye is in this room's space, through any chain of portals; the door is at x = 0.
        if passage.eye()[0] > -3.0 {
            self.0.gather(passage, memory, seen);
        }
    }
    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        if passage.eye()[0] > -3.0 {
            self.0.draw(passage, memory, seen, canvas);
        }
    }
    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.0.cast(ray)
    }
    fn surface(&self, item: ItemIndex, face: u32) -> Surface {
        self.0.surface(item, face)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Take the geometry of two rooms, and wrap the sector of the second one.
    let built = enfilade_scenes::built_in("two-rooms").ok_or("no such scene")?;
    let geometry = |room| Arc::clone(built.scene.geometry(SectorId(room)).expect("geometry"));
    let lit = Lit(Method::HierarchicalZ.build(geometry(1), Method::DEFAULT_LIMIT)?);

    let mut scene = SceneBuilder::new();
    let hall = scene.add("hall", geometry(0), Method::SBuffer);
    let study = scene.add_custom("study", Arc::new(lit));
    scene.door((hall, OpeningId(0)), (study, OpeningId(0)));
    let (scene, mut viewer) = (scene.build()?, Viewer::new());
    for x in [-4.5, -3.5, -2.5, -1.5] {
        let view = View::new([x, 1.6, 0.0], [5.0, 1.2, 0.0], [640, 360]).expect("a valid view");
        let mut picture = laws::OwnerPicture::new(view.size());
        let set = viewer.draw(&scene, &view, &mut picture);
        let through = set.items().iter().filter(|seen| seen.passage != PassageId(0));
        let (through, painted) = (through.count(), picture.painted());
        println!("from {x}: {through} items visible through the door, {painted} samples painted");
    }
    Ok(())
}
