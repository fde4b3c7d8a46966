//! Small scenes whose visible sets, sizes and owners are known by hand.

use enfilade::laws::OwnerPicture;
use enfilade::{
    Camera, Contract, GeometryBuilder, ItemIndex, Material, MaterialId, Mesh, Method, Owner, Scene,
    SceneBuilder, Transform, View, Viewer, ViewerOptions,
};

const SIZE: [u32; 2] = [100, 100];

/// Builds a scene of items with one material; each is a list of triangles.
fn scene(items: &[Vec<[[f32; 3]; 3]>], method: Method) -> Scene {
    let placed: Vec<_> = items
        .iter()
        .map(|item| (item.clone(), Transform::IDENTITY))
        .collect();
    placed_scene(&placed, method)
}

fn placed_scene(items: &[(Vec<[[f32; 3]; 3]>, Transform)], method: Method) -> Scene {
    let double_sided = Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    };
    let mut geometry = GeometryBuilder::new([double_sided]);
    for (triangles, place) in items {
        let positions: Vec<[f32; 3]> = triangles.iter().flatten().copied().collect();
        let corners: Vec<u32> = (0..positions.len() as u32).collect();
        let mesh = Mesh::triangles(&positions, &corners, MaterialId(0)).expect("sound triangles");
        let mesh = geometry.mesh(mesh);
        geometry.item("", mesh, *place);
    }
    let mut scene = SceneBuilder::new();
    scene.add("world", geometry.build().expect("sound items"), method);
    scene.build().expect("one sector")
}

/// A rectangle of two triangles, by its corners in order.
fn quad([a, b, c, d]: [[f32; 3]; 4]) -> Vec<[[f32; 3]; 3]> {
    vec![[a, b, c], [a, c, d]]
}

fn upright([x0, x1]: [f32; 2], [y0, y1]: [f32; 2], z: f32) -> Vec<[[f32; 3]; 3]> {
    quad([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
}

/// A view from the origin along −z with a field of view of 90 degrees: the screen is 2 wide at distance 1.
fn ahead() -> View {
    let camera = Camera {
        fov_y: 90.0_f32.to_radians(),
        ..Camera::new([0.0; 3], [0.0, 0.0, -1.0])
    };
    camera.view(SIZE).expect("a valid view")
}

/// All methods that take any geometry and keep the given contract.
fn methods(contract: Contract) -> impl Iterator<Item = Method> {
    let all = Method::ALL.into_iter();
    all.filter(move |method| method.requires().is_none() && method.contract() == contract)
}

#[test]
fn the_size_of_an_item_is_the_longer_side_of_its_rectangle() {
    // 40 × 10 pixels, and 10 × 40.
    for item in [
        upright([-4.0, 4.0], [-1.0, 1.0], -10.0),
        upright([-1.0, 1.0], [-4.0, 4.0], -10.0),
    ] {
        let scene = scene(&[item], Method::HierarchicalZ);
        let mut viewer = Viewer::new();
        let size_px = viewer.look(&scene, &ahead()).items()[0].size_px;
        assert!((40..=42).contains(&size_px), "{size_px}");
    }
}

#[test]
fn what_is_seen_in_a_mirror_is_mirrored_and_in_a_mirror_of_a_mirror_is_not() {
    let built = enfilade_scenes::built_in("mirrors").expect("a built-in scene");
    let mut viewer = Viewer::new();
    let set = viewer.look(&built.scene, &built.cameras[0].view(SIZE).expect("a valid view"));
    let mut most = 0;
    for passage in set.passages() {
        assert_eq!(passage.mirrored(), passage.crossings % 2 == 1);
        most = most.max(passage.crossings);
    }
    assert!(most > 3, "{most} mirrors in a row");
}

#[test]
fn where_faces_coincide_the_lower_item_is_seen_whatever_comes_first() {
    // Squares in one plane: of several sizes where they are parallel to the screen, so that their depths are the same
    // bit for bit.
    let sheet = |half: f32, slant: f32| {
        quad([
            [-half, -half, -8.0 + slant * half],
            [half, -half, -8.0 + slant * half],
            [half, half, -8.0 - slant * half],
            [-half, half, -8.0 - slant * half],
        ])
    };
    let parallel = [[2.0, 2.0, 2.0], [1.0, 2.0, 4.0], [4.0, 2.0, 1.0], [2.0, 4.0, 1.0]];
    for (slant, sizes) in [(0.0, &parallel[..]), (0.5, &parallel[..1])] {
        for &halves in sizes {
            let items = halves.map(|half| sheet(half, slant));
            for method in methods(Contract::Exact) {
                let scene = scene(&items, method);
                let mut picture = OwnerPicture::new(SIZE);
                Viewer::new().draw(&scene, &ahead(), &mut picture);
                let owner = picture.owner([50, 50]);
                assert!(
                    matches!(owner, Some(Owner::Face(ItemIndex(0), _))),
                    "{method} of {halves:?}, slanted by {slant}: {owner:?}"
                );
            }
            for method in methods(Contract::Conservative) {
                let scene = scene(&items, method);
                let mut viewer = Viewer::new();
                let found = viewer
                    .look(&scene, &ahead())
                    .items()
                    .iter()
                    .any(|seen| seen.item == ItemIndex(0).into());
                assert!(found, "{method} of {halves:?}, slanted by {slant}");
            }
        }
    }
}

#[test]
fn what_was_found_before_the_wall_that_hides_it_is_taken_back() {
    // A fence askew: it begins beside the eye, out of view, and enters the view behind the wall. Its box, which is askew
    // too, comes before the wall's.
    let fence = quad([
        [0.0, -0.1, 0.0],
        [30.0, -0.1, 0.0],
        [30.0, 0.1, 0.0],
        [0.0, 0.1, 0.0],
    ]);
    let askew = Transform::translation([-20.0, 0.0, -1.0])
        * Transform::rotation([0.0, 1.0, 0.0], 45.0_f64.to_radians());
    let wall = upright([-6.0, 6.0], [-6.0, 6.0], -5.0);
    for method in methods(Contract::Conservative).chain(methods(Contract::Exact)) {
        let scene = placed_scene(
            &[(fence.clone(), askew), (wall.clone(), Transform::IDENTITY)],
            method,
        );
        let mut viewer = Viewer::with_options(ViewerOptions {
            occluders: Some(0),
            ..ViewerOptions::default()
        });
        let items: Vec<ItemIndex> = viewer
            .look(&scene, &ahead())
            .items()
            .iter()
            .map(|seen| seen.item.index)
            .collect();
        assert_eq!(items, [ItemIndex(1)], "{method}");
    }
}
