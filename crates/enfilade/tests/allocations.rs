//! Looks allocate nothing once their buffers have grown.

use allocation_counter::measure;
use enfilade::{Camera, Method, PortalId, Scene, Viewer};
use enfilade_scenes::built_in;
use rayon::ThreadPoolBuilder;

const SMALL: [u32; 2] = [96, 54];

/// Checks with every method that looks from up to four cameras stop allocating after a few rounds.
fn allocates_nothing(name: &str, scene: &Scene, cameras: &[Camera], size: [u32; 2]) {
    for method in Method::ALL.into_iter().filter(|&method| scene.suits(method)) {
        let scene = scene.with_method(method, Method::DEFAULT_LIMIT);
        let scene = scene.expect("they are not that large");
        let mut viewer = Viewer::new();
        let views: Vec<_> = cameras
            .iter()
            .take(4)
            .map(|camera| camera.view(size).expect("a valid view"))
            .collect();
        let mut seen = 0;
        let mut round = || {
            for view in &views {
                seen += viewer.look(&scene, view).items().len();
            }
        };
        // Buffers are passed between threads; each must have been where the most memory is needed.
        (0..16).for_each(|_| round());
        let allocated = measure(&mut round).count_total;
        assert!(seen > 0, "nothing is seen in @{name}");
        assert_eq!(allocated, 0, "{method} in @{name}");
    }
}

#[test]
fn a_look_allocates_nothing_once_it_has_looked_from_everywhere() {
    for name in ["two-rooms", "mirror", "crowd", "glass", "house"] {
        let built = built_in(name).expect("a built-in scene");
        allocates_nothing(name, &built.scene, &built.cameras, SMALL);
    }
}

#[test]
#[ignore = "takes a minute without optimization"]
fn nor_does_one_in_the_palace() {
    let built = built_in("enfilade").expect("a built-in scene");
    allocates_nothing("enfilade", &built.scene, &built.cameras, SMALL);
}

#[test]
fn nor_does_one_at_closed_doors() {
    for name in ["two-rooms", "mirror", "impossible"] {
        let mut built = built_in(name).expect("a built-in scene");
        for portal in (0..built.scene.portals().len() as u32).map(PortalId) {
            built.scene.set_open(portal, false);
        }
        allocates_nothing(name, &built.scene, &built.cameras, SMALL);
    }
}

#[test]
fn nor_does_a_thread_that_shares_looks_with_another() {
    let pool = ThreadPoolBuilder::new().num_threads(2).build();
    let pool = pool.expect("two threads");
    // Only allocations of this pool's single thread are counted; which strips it renders varies between looks.
    for name in ["two-rooms", "mirror", "glass"] {
        let built = built_in(name).expect("a built-in scene");
        pool.install(|| allocates_nothing(name, &built.scene, &built.cameras, [640, 360]));
    }
}
