//! Looks without occlusion: culled by the frustum and by portals alone.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{Contract, Limits, Method, View, Viewer, ViewerOptions};
use enfilade_scenes::{BuiltIn, Random, built_in, parallel_view};

const SIZE: [u32; 2] = [96, 54];

#[test]
fn nothing_is_missed_and_the_picture_is_the_same_where_nothing_hides_anything() {
    let mut random = Random::new(77);
    let (mut plain, mut culled) = (0, 0);
    for name in ["two-rooms", "mirrors", "mirror", "teleport"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        let reference = Reference::new(&scene);
        let views: Vec<View> = cameras
            .iter()
            .take(2)
            .flat_map(|camera| {
                let parallel = parallel_view(camera, SIZE, &mut random);
                [camera.view(SIZE).expect("a valid view"), parallel]
            })
            .collect();
        let mut limits = Limits::default();
        limits.max_crossings = 4;
        for view in &views {
            let truth = reference.see(&scene, view, &limits);
            for method in Method::ALL
                .into_iter()
                .filter(|method| method.requires().is_none())
            {
                let scene = scene.with_method(method, u64::MAX).expect("a small scene");
                let mut viewer = Viewer::with_options(ViewerOptions {
                    limits,
                    occlusion: false,
                    ..ViewerOptions::default()
                });
                let set = viewer.look(&scene, view);
                assert!(
                    set.passages()
                        .iter()
                        .all(|passage| passage.contract == Contract::Strict)
                );
                plain += set.items().len();
                let mut picture = OwnerPicture::new(SIZE);
                viewer.draw(&scene, view, &mut picture);
                let verdict = truth.check(viewer.visible(), Some(&picture));
                assert_eq!(verdict.missed, [], "{method} on @{name}, {view:?}");
                assert_eq!(verdict.pixels_different, 0, "{method} on @{name}, {view:?}");
                viewer.options.occlusion = true;
                culled += viewer.look(&scene, view).items().len();
            }
        }
    }
    assert!(
        plain * 2 > culled * 3,
        "{plain} items without occlusion, {culled} with"
    );
}
