//! Covers with a lower resolution than the screen: conservative, so larger visible sets and no false culls.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{Limits, Method, Scene, View, Viewer};
use enfilade_scenes::{BuiltIn, SCENES, built_in, random_scene};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const SIZE: [u32; 2] = [96, 54];

/// Half the size, sizes that do not divide the screen's, a single row, a single cell.
const COVERS: [[u32; 2]; 5] = [[48, 27], [37, 50], [96, 1], [7, 5], [1, 1]];

fn methods() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().filter(|method| method.takes_cover_size())
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_crossings = 4;
    limits
}

fn viewer(cover_size: [u32; 2]) -> Viewer {
    let mut viewer = Viewer::new();
    viewer.options.limits = limits();
    viewer.options.cover_size = Some(cover_size);
    viewer
}

fn seen_by(method: Method, scene: &Scene) -> Scene {
    let built = scene.with_method(method, Method::DEFAULT_LIMIT);
    built.expect("the scenes of the laws are small")
}

/// Compares every such method with the reference. Returns the number of certainly visible items.
fn nothing_is_missed(name: &str, built: &BuiltIn, cameras: usize) -> usize {
    let reference = Reference::new(&built.scene);
    let seen: Vec<_> = methods()
        .map(|method| (method, seen_by(method, &built.scene)))
        .collect();
    let mut looked_at = 0;
    for camera in built.cameras.iter().take(cameras) {
        let view = camera.view(SIZE).expect("a valid view");
        let truth = reference.see(&built.scene, &view, &limits());
        looked_at += truth.visible().len();
        for (method, scene) in &seen {
            for cover in COVERS {
                let mut viewer = viewer(cover);
                let mut picture = OwnerPicture::new(SIZE);
                viewer.draw(scene, &view, &mut picture);
                let verdict = truth.check(viewer.visible(), Some(&picture));
                let place = format!("{method} in {cover:?} cells on @{name} from `{}`", camera.name);
                assert_eq!(verdict.missed, [], "{place}");
                assert_eq!(verdict.pixels_different, 0, "{place}");
            }
        }
    }
    looked_at
}

#[test]
fn a_cover_of_lower_resolution_misses_nothing() {
    let mut looked_at = 0;
    for named in SCENES.iter().filter(|named| named.name != "enfilade") {
        looked_at += nothing_is_missed(named.name, &named.build(), 3);
    }
    assert!(looked_at > 100, "almost nothing is seen: {looked_at}");
    let palace = built_in("enfilade").expect("the palace");
    assert!(nothing_is_missed("enfilade", &palace, 2) > 20);
}

fn visible(viewer: &mut Viewer, scene: &Scene, view: &View) -> usize {
    viewer.look(scene, view).items().len()
}

#[test]
fn coarser_cells_hide_less_but_do_hide() {
    let palace = built_in("enfilade").expect("the palace");
    let view = palace.cameras[0].view([320, 180]).expect("a valid view");
    for method in methods() {
        let scene = seen_by(method, &palace.scene);
        let count = |cover| visible(&mut viewer(cover), &scene, &view);
        let [whole, half, few, one] = [[320, 180], [160, 90], [32, 18], [1, 1]].map(count);
        assert!(
            whole <= half && half <= few && few <= one,
            "{method}: {whole} {half} {few} {one}"
        );
        assert!(half < one * 2 / 3, "{method}: {half} of {one}");
    }
}

#[test]
fn a_cover_of_no_size_or_larger_than_the_screen_is_one_that_makes_sense() {
    let built = built_in("two-rooms").expect("a built-in scene");
    let view = built.cameras[0].view(SIZE).expect("a valid view");
    for method in methods() {
        let scene = seen_by(method, &built.scene);
        let count = |cover| visible(&mut viewer(cover), &scene, &view);
        let as_it_is = visible(&mut Viewer::new(), &scene, &view);
        assert_eq!(count([0, 0]), count([1, 1]), "{method}");
        assert_eq!(count([10_000, u32::MAX]), as_it_is, "{method}");
    }
}

#[test]
fn a_look_in_cells_allocates_nothing_once_it_has_looked_from_everywhere() {
    let built = built_in("enfilade").expect("the palace");
    for method in methods() {
        let scene = seen_by(method, &built.scene);
        let mut viewer = viewer([48, 27]);
        let views: Vec<_> = built
            .cameras
            .iter()
            .take(4)
            .map(|camera| camera.view(SIZE).expect("a valid view"))
            .collect();
        let mut round = || views.iter().for_each(|view| _ = viewer.look(&scene, view));
        (0..16).for_each(|_| round());
        let allocated = allocation_counter::measure(&mut round).count_total;
        assert_eq!(allocated, 0, "{method}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 48,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn scenes_made_by_chance_lose_nothing(seed in any::<u64>()) {
        nothing_is_missed("random", &random_scene(seed), 2);
    }
}
