//! The suite finds what custom sectors do wrong, and nothing where they do all right.

use crate::subject::{limits, subject};
use enfilade::laws::{Law, check_custom};
use enfilade::{
    Aabb, Canvas, Collector, Contract, Hit, ItemIndex, Memory, Method, Opening, OpeningId, Passage, Ray,
    SceneBuilder, Sector, SectorId, Surface, View, ViewerOptions,
};

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// What a custom sector does wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// Shows nothing.
    Blind,
    /// Answers the second look with nothing.
    Forgetful,
    /// Paints the picture twice.
    PaintsTwice,
    /// Shows nothing when drawing.
    BlindInPictures,
    /// Lists a thousand items that it does not have.
    ListsTooMuch,
    /// Paints glass where there is none.
    PaintsGlass,
    /// Needs a screen as narrow as that of the test.
    Narrow,
}

struct Faulty {
    sound: Arc<dyn Sector>,
    fault: Fault,
    looks: AtomicU32,
}

impl Faulty {
    fn is_blind(&self, passage: &Passage) -> bool {
        let looks = self.looks.fetch_add(1, Relaxed);
        match self.fault {
            Fault::Blind => true,
            Fault::Forgetful => looks % 2 == 1,
            Fault::Narrow => u32::from(passage.aperture.rect().x1) > WIDTH,
            _ => false,
        }
    }
}

impl Sector for Faulty {
    fn bounds(&self) -> Aabb {
        self.sound.bounds()
    }
    fn openings(&self) -> &[Opening] {
        self.sound.openings()
    }
    fn contract(&self, options: &ViewerOptions) -> Contract {
        self.sound.contract(options)
    }
    fn gather(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector) {
        if !self.is_blind(passage) {
            self.sound.gather(passage, memory, seen);
        }
        if self.fault == Fault::ListsTooMuch {
            (1000..2000).for_each(|number| seen.item(ItemIndex(number)));
        }
    }
    fn draw(&self, passage: &Passage, memory: &mut Memory, seen: &mut Collector, canvas: &mut dyn Canvas) {
        if self.is_blind(passage) || self.fault == Fault::BlindInPictures {
            return;
        }
        self.sound.draw(passage, memory, seen, canvas);
        if self.fault == Fault::PaintsGlass {
            seen.glass(60, 30, 1e6, ItemIndex(0), 0);
        }
        if self.fault == Fault::PaintsTwice {
            let mut again = Collector::default();
            self.sound.draw(passage, memory, &mut again, canvas);
        }
    }
    fn cast(&self, ray: &Ray) -> Option<Hit> {
        self.sound.cast(ray)
    }
    fn surface(&self, item: ItemIndex, face: u32) -> Surface {
        self.sound.surface(item, face)
    }
}

/// Width of the test's screen, in pixels.
const WIDTH: u32 = 128;

/// Returns the laws that two rooms break whose first one has a fault.
fn broken_by(fault: Fault) -> Vec<Law> {
    let built = &subject("two-rooms").built;
    let geometry = |room| Arc::clone(built.scene.geometry(SectorId(room)).expect("geometry"));
    let scene_with = |fault: Option<Fault>| {
        let mut scene = SceneBuilder::new();
        let hall = match fault {
            Some(fault) => {
                let sound = Method::ZBuffer.build(geometry(0), Method::DEFAULT_LIMIT);
                let sector = Faulty {
                    sound: sound.expect("a small room"),
                    fault,
                    looks: AtomicU32::new(0),
                };
                scene.add_custom("hall", Arc::new(sector))
            }
            None => scene.add("hall", geometry(0), Method::ZBuffer),
        };
        let study = scene.add("study", geometry(1), Method::ZBuffer);
        scene.door((hall, OpeningId(0)), (study, OpeningId(0)));
        scene.build().expect("two rooms and a door")
    };
    let view = View::new([-4.5, 1.6, 0.0], [5.0, 1.2, 0.0], [WIDTH, 72]);
    let report = check_custom(&scene_with(Some(fault)), &scene_with(None), &[view], limits());
    assert!(report.visible > 0);
    let mut laws: Vec<Law> = Vec::new();
    for broken in &report.broken {
        if !laws.contains(&broken.law) {
            laws.push(broken.law);
        }
    }
    laws
}

#[test]
fn a_sound_custom_sector_breaks_no_law() {
    assert_eq!(broken_by(Fault::None), []);
}

#[test]
fn each_fault_of_a_custom_sector_breaks_a_law() {
    for (fault, law) in [
        (Fault::Blind, Law::Contract),
        (Fault::Forgetful, Law::Coherence),
        (Fault::PaintsTwice, Law::PaintedOnce),
        (Fault::BlindInPictures, Law::DrawnAsLooked),
        (Fault::Narrow, Law::WiderSeesMore),
        (Fault::ListsTooMuch, Law::Tightness),
        (Fault::PaintsGlass, Law::Layers),
    ] {
        let broken = broken_by(fault);
        assert!(broken.contains(&law), "{fault:?} breaks {broken:?}, not {law:?}");
    }
}
