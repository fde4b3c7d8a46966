//! Results do not depend on the number of threads, neither of looks nor of builds.

use enfilade::{
    Camera, GeometryBuilder, Limits, Material, MaterialId, Mesh, Method, Scene, SceneBuilder, SectorId,
    Stats, Transform, View, Viewer,
};
use enfilade_scenes::built_in;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::collections::BTreeMap;

/// Large enough for many strips, and not divisible by their heights.
const SIZE: [u32; 2] = [1000, 562];

fn pools() -> Vec<ThreadPool> {
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build();
    [1, 2, 8]
        .map(|threads| pool(threads).expect("a few threads"))
        .into()
}

/// Returns the scene with each method that suits it.
fn by_each_method(scene: &Scene) -> impl Iterator<Item = (Method, Scene)> {
    let suited = Method::ALL.into_iter().filter(|&method| scene.suits(method));
    suited.map(|method| {
        let scene = scene.with_method(method, Method::DEFAULT_LIMIT);
        (method, scene.expect("it is small"))
    })
}

/// A camera at its position and one and two steps on, so that looks test the geometry seen last first (temporal
/// coherence).
fn steps(at: &Camera) -> [View; 3] {
    [0.0, 0.02, 0.04].map(|far| {
        let on = |[x, y, z]: [f64; 3]| [x + far, y, z + 0.5 * far];
        let camera = Camera {
            eye: on(at.eye),
            toward: on(at.toward),
            ..at.clone()
        };
        camera.view(SIZE).expect("a valid view")
    })
}

/// Returns all results and statistics of looks along the path of a camera.
fn seen_on_the_way(viewer: &mut Viewer, scene: &Scene, views: &[View]) -> (Vec<String>, Vec<Stats>) {
    let look = |view: &View| {
        let set = viewer.look(scene, view);
        // Passages hold the options of the look.
        let answer = format!("{set:?}").replace("parallel: false", "parallel: true");
        (answer, *viewer.stats())
    };
    views.iter().map(look).unzip()
}

fn viewer() -> Viewer {
    let mut viewer = Viewer::new();
    let mut limits = Limits::default();
    limits.max_crossings = 4;
    viewer.options.limits = limits;
    viewer
}

/// Checks that a camera has the same visible sets along its path in each pool. Returns the statistics in each pool.
fn same_in_each(pools: &[ThreadPool], scene: &Scene, views: &[View], place: &str) -> Vec<Vec<Stats>> {
    let in_pool = |pool: &ThreadPool| pool.install(|| seen_on_the_way(&mut viewer(), scene, views));
    let (seen, costs): (Vec<_>, Vec<_>) = pools.iter().map(in_pool).unzip();
    for (seen_now, pool) in seen.iter().zip(pools) {
        let threads = pool.current_num_threads();
        for (step, (first, now)) in seen[0].iter().zip(seen_now).enumerate() {
            assert!(
                first == now,
                "{place}, step {step}: {threads} threads see\n{now}\nand one\n{first}"
            );
        }
    }
    costs
}

/// A block of twelve triangles.
fn block() -> Mesh {
    let corner = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(|side| side as f32);
    let positions: Vec<[f32; 3]> = (0..8).map(corner).collect();
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let corners: Vec<u32> = sides
        .iter()
        .flat_map(|&[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    Mesh::triangles(&positions, &corners, MaterialId(0)).expect("a sound block")
}

/// Several thousand slightly rotated houses: enough for trees built in parts and for parallel traversal.
fn town() -> Scene {
    let mut builder = GeometryBuilder::new([Material::opaque([0.6; 3])]);
    let house = builder.mesh(block());
    for i in 0..1600_u32 {
        let at = [(i % 40) as f32 * 5.0, 0.0, (i / 40) as f32 * 5.0];
        let size = [1.0 + (i % 3) as f32, 1.0 + (i * 7 % 5) as f32, 2.0];
        let place = Transform::translation(at)
            * Transform::rotation([0.0, 1.0, 0.1], f64::from(i * 37 % 90).to_radians())
            * Transform::scaling(size);
        builder.item("house", house, place);
    }
    let mut scene = SceneBuilder::new();
    scene.add("town", builder.build().expect("sound houses"), Method::ZBuffer);
    scene.build().expect("one sector")
}

fn views_of_the_town() -> [View; 3] {
    cameras_in_the_town().map(|camera| camera.view(SIZE).expect("a valid view"))
}

/// In the middle of a street, above, and beside the town.
fn cameras_in_the_town() -> [Camera; 3] {
    let camera = |eye: [f32; 3], toward: [f32; 3]| Camera::new(eye, toward);
    [
        camera([97.5, 1.0, 97.5], [130.0, 1.0, 150.0]),
        camera([100.0, 60.0, -40.0], [100.0, 0.0, 80.0]),
        camera([-30.0, 8.0, -30.0], [60.0, 0.0, 60.0]),
    ]
}

#[test]
fn two_threads_and_eight_see_what_one_does() {
    see_what_one_does(&["mirror", "glass", "bottles", "house"], 300);
}

#[test]
#[ignore = "takes a minute without optimization"]
fn two_threads_and_eight_see_what_one_does_in_the_palace() {
    for (method, [one, eight]) in see_what_one_does(&["enfilade"], 150) {
        // These look on one thread: what the masked cover hides depends on the order of its faces, and baked cells need
        // no occlusion tests.
        let alone = ["masked", "pvs"].contains(&method);
        assert_eq!(
            alone,
            one == eight,
            "{method}: {one} boxes tested by one thread, {eight} by eight"
        );
    }
}

/// Looks at built-in scenes, and at the town; at least at `least` views in which something is rasterized. Returns the
/// boxes tested by one thread and by eight, per method.
fn see_what_one_does(names: &[&str], least: usize) -> BTreeMap<&'static str, [u64; 2]> {
    let pools = pools();
    let mut asked: BTreeMap<&'static str, [u64; 2]> = BTreeMap::new();
    let mut looked_at = 0;
    let mut look = |name: &str, scene: &Scene, cameras: &[Camera]| {
        for (method, scene) in by_each_method(scene) {
            for (number, camera) in cameras.iter().enumerate() {
                let place = format!("{method} in @{name} from camera {number}");
                let costs = same_in_each(&pools, &scene, &steps(camera), &place);
                let boxes = |costs: &Vec<Stats>| costs.iter().map(|stats| stats.boxes_tested).sum::<u64>();
                let asked = asked.entry(method.name()).or_default();
                asked[0] += boxes(&costs[0]);
                asked[1] += boxes(&costs[2]);
                looked_at += costs[0].iter().filter(|stats| stats.batches > 0).count();
            }
        }
    };
    for name in names {
        let built = built_in(name).expect("a built-in scene");
        look(name, &built.scene, &built.cameras[..built.cameras.len().min(3)]);
    }
    look("town", &town(), &cameras_in_the_town());
    assert!(looked_at > least, "hardly anything was looked at: {looked_at}");
    asked
}

#[test]
fn a_viewer_that_is_not_parallel_does_what_one_thread_does() {
    let pools = pools();
    let views = views_of_the_town();
    for (method, scene) in by_each_method(&town()) {
        let alone = pools[2].install(|| {
            let mut viewer = viewer();
            viewer.options.parallel = false;
            seen_on_the_way(&mut viewer, &scene, &views)
        });
        let one = pools[0].install(|| seen_on_the_way(&mut viewer(), &scene, &views));
        assert!(alone == one, "{method}");
    }
}

#[test]
fn sectors_of_one_geometry_are_built_side_by_side_without_waiting_for_each_other() {
    let geometry = town().geometry(SectorId(0)).expect("of ours").clone();
    let mut builder = SceneBuilder::new();
    for name in ["here", "there", "yonder"] {
        builder.add(name, geometry.clone(), Method::ZBuffer);
    }
    let scene = builder.build().expect("three sectors");
    for pool in pools() {
        for method in [Method::Bsp, Method::Svbsp] {
            let built = pool.install(|| scene.with_method(method, Method::DEFAULT_LIMIT));
            assert!(built.is_ok_and(|built| built.sectors().all(|id| built.builds(id) == 2)));
        }
    }
}

#[test]
fn two_threads_and_eight_build_what_one_does() {
    let pools = pools();
    let town = town();
    for method in Method::ALL.into_iter().filter(|&method| town.suits(method)) {
        let built = pools.iter().map(|pool| {
            pool.install(|| {
                // A separate geometry: shared acceleration data would be built only once.
                let scene = self::town().with_method(method, Method::DEFAULT_LIMIT);
                let scene = scene.expect("it is small");
                let mut viewer = viewer();
                viewer.options.parallel = false;
                let looks = seen_on_the_way(&mut viewer, &scene, &views_of_the_town());
                (scene.build_stats(), scene.bytes(), looks)
            })
        });
        let built: Vec<_> = built.collect();
        assert!(built.iter().all(|now| *now == built[0]), "{method}");
        if method == Method::Bsp {
            assert!(built[0].0.splits > 100, "nothing was cut");
        }
    }
}
