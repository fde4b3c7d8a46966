//! Looks, and edits that move items, allocate nothing once their buffers have grown.

use allocation_counter::measure;
use enfilade::{
    Aabb, Camera, GeometryBuilder, ItemId, Material, MaterialId, Mesh, Method, OccluderMesh, OcclusionBuffer,
    PortalId, Scene, SectorId, Transform, View, Viewer,
};
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
                    buffer.begin(&View::new([0.0; 3], [sin, 0.1, cos], [640, 360]).expect("a valid view"));
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

#[test]
fn nor_does_a_frame_in_which_everything_moves() {
    const SIDE: u16 = 24;
    let place = |number: u16, moment: u16| {
        let [x, z] = [number % SIDE, number / SIDE].map(|step| 3.0 * f32::from(step));
        let phase = f32::from(moment % 40 + 7 * number % 40) * std::f32::consts::TAU / 40.0;
        Transform::translation([x + 2.0 * phase.cos(), 0.0, z + 2.0 * phase.sin()])
    };
    for method in [Method::ZBuffer, Method::SBuffer, Method::Masked] {
        let mut crowd = GeometryBuilder::new([Material::opaque([0.5; 3])]);
        let body = Mesh::cuboid([-0.4, 0.0, -0.4], [0.4, 1.8, 0.4], MaterialId(0)).expect("a box");
        let body = crowd.mesh(body);
        let ids: Vec<ItemId> = (0..SIDE * SIDE)
            .map(|number| crowd.item("", body, place(number, 0)))
            .collect();
        let mut scene = Scene::single(crowd.build().expect("sound"), method).expect("small");
        let mut viewer = Viewer::new();
        viewer.options.parallel = false;
        let view = View::new([-5.0, 6.0, -5.0], [30.0, 0.0, 30.0], SMALL).expect("a valid view");
        let mut refused = Vec::new();
        let mut frame = |moment: u16| {
            let mut edit = scene.edit();
            let moves = ids
                .iter()
                .zip(0..)
                .map(|(&id, number)| (id, place(number, moment)));
            edit.set_transforms(SectorId(0), moves, &mut refused)
                .expect("a sector");
            assert!(refused.is_empty());
            let edited = edit.finish().expect("small");
            assert_eq!((edited.items, edited.rebuilt), (u64::from(SIDE * SIDE), 0));
            viewer.look(&scene, &view).items().len()
        };
        assert!((0..400).map(&mut frame).all(|seen| seen > 50));
        let allocated = measure(|| {
            (400..440).for_each(|moment| {
                frame(moment);
            })
        })
        .count_total;
        assert_eq!(allocated, 0, "{method}");
    }
}
