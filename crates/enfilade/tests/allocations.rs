//! A look allocates nothing once its buffers have grown.

use allocation_counter::measure;
use enfilade::{Method, Viewer};
use enfilade_scenes::built_in;

#[test]
fn a_look_allocates_nothing_once_it_has_looked_from_everywhere() {
    for name in ["two-rooms", "mirror", "crowd", "glass", "enfilade"] {
        let built = built_in(name).expect("a built-in scene");
        for method in Method::ALL {
            let scene = built.scene.with_method(method, Method::DEFAULT_LIMIT);
            let scene = scene.expect("they are not that large");
            let mut viewer = Viewer::new();
            let views: Vec<_> = built
                .cameras
                .iter()
                .take(4)
                .map(|camera| camera.view([96, 54]))
                .collect();
            let mut seen = 0;
            let mut round = || {
                for view in &views {
                    seen += viewer.look(&scene, view).items().len();
                }
            };
            // Buffers go from hand to hand, and each must have been in the hands that need most.
            (0..16).for_each(|_| round());
            let allocated = measure(&mut round).count_total;
            assert!(seen > 0, "nothing is seen in @{name}");
            assert_eq!(allocated, 0, "{method} in @{name}");
        }
    }
}
