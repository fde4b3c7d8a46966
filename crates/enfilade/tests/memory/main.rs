//! What a viewer takes beyond the scene does not grow with the passages of a look.

mod mirrors;

use allocation_counter::measure;
use enfilade::{Canvas, Method, Passage, PassageId, Scene, Span, View, Viewer};
use enfilade_scenes::built_in;
use mirrors::hundred_mirrors;

const SIZE: [u32; 2] = [1920, 1080];

/// At most, in bytes, at any moment.
const MOST: u64 = 64_000_000;

/// A canvas that does nothing with what it gets.
struct Nothing;

impl Canvas for Nothing {
    fn enter(&mut self, _id: PassageId, _passage: &Passage) {}
    fn row(&mut self, _y: u16, _spans: &[Span]) {}
}

/// By every method, looking and drawing through a hundred passages takes no more than that.
fn stays_small(scene: &Scene, view: &View) {
    for method in Method::ALL {
        let scene = scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("it is small");
        let mut passages = 0;
        let taken = measure(|| {
            let mut viewer = Viewer::new();
            let mut limits = viewer.limits();
            limits.max_crossings = 120;
            viewer.set_limits(limits);
            // What was seen last is remembered by the next look.
            for _ in 0..2 {
                passages = viewer.look(&scene, view).passages().len();
                viewer.draw(&scene, view, &mut Nothing);
            }
        });
        assert!(passages > 100, "{method}: only {passages} passages");
        assert!(
            taken.bytes_max < MOST,
            "{method}: {} bytes for {passages} passages",
            taken.bytes_max
        );
    }
}

#[test]
fn a_hundred_mirrors_side_by_side_share_their_buffers() {
    stays_small(
        &hundred_mirrors(),
        &View::new([0.0, 0.0, 1.0], [0.0, 0.0, -4.0], SIZE),
    );
}

#[test]
fn a_hundred_mirrors_within_each_other_share_their_buffers() {
    let mirrors = built_in("mirrors").expect("a built-in scene");
    stays_small(&mirrors.scene, &mirrors.cameras[0].view(SIZE));
}
