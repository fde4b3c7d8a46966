//! Looks allocate nothing once their buffers have grown.

use allocation_counter::measure;
use enfilade::{Aabb, Method, OccluderMesh, OcclusionBuffer, PortalId, Scene, Transform, View, Viewer};
use enfilade_scenes::{Camera, built_in};
use rayon::ThreadPoolBuilder;

const SMALL: [u32; 2] = [96, 54];

/// Checks with every method that looks from up to four cameras stop allocating after a few rounds.
fn allocates_nothing(name: &str, scene: &Scene, cameras: &[Camera], size: [u32; 2]) {
    for method in Method::ALL.into_iter().filter(|&method| scene.suits(method)) {
        let scene = scene.with_method(method, Method::DEFAULT_LIMIT);
        let scene = scene.expect("they are not that large");
        let mut viewer = Viewer::new();
        let views: Vec<_> = cameras.iter().take(4).map(|camera| camera.view(size)).collect();
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

#[test]
fn nor_does_an_occlusion_buffer_without_a_scene() {
    let corners = Aabb {
        min: [-1.0; 3],
        max: [1.0; 3],
    };
    let sides = [0, 1, 3, 0, 3, 2, 4, 7, 5, 4, 6, 7, 0, 4, 5, 0, 5, 1];
    let mesh = OccluderMesh::triangles(&corners.corners(), &sides).expect("three sides of a cube");
    let boxes = [corners; 5000];
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| {
            let mut buffer = OcclusionBuffer::new();
            let mut visible = [0; 5000 / 64 + 1];
            let mut round = || {
                for turn in 0..8_u8 {
                    let (sin, cos) = f32::from(turn).sin_cos();
                    buffer.begin(&View::new([0.0; 3], [sin, 0.1, cos], [640, 360]));
                    let at = |number| {
                        Transform::translation([(number % 9) as f32 - 4.0, 0.0, number as f32 - 50.0])
                    };
                    buffer.draw_all((0..100).map(|number| (&mesh, at(number))));
                    buffer.test_boxes(&boxes, &mut visible);
                }
            };
            (0..16).for_each(|_| round());
            assert_eq!(measure(&mut round).count_total, 0, "by {threads} threads");
        });
    }
}
