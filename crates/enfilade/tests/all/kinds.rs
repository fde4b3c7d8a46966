//! Kinds of items: only bounds, occluder proxies, not drawn, never culled, and limits of distance and size.

use enfilade::laws::OwnerPicture;
use enfilade::{
    ClipDepth, GeometryBuilder, ItemId, ItemOptions, Material, MaterialId, Mesh, Method, Scene, SectorId,
    Transform, View, Viewer,
};

const HALL: SectorId = SectorId(0);
const PLAIN: ItemOptions = ItemOptions {
    is_occluder: true,
    is_drawn: true,
    never_cull: false,
    layers: u32::MAX,
    max_distance: f32::INFINITY,
    min_size_px: 0.0,
};

/// Methods that take any geometry and never miss anything.
fn methods() -> impl Iterator<Item = Method> {
    let all = Method::ALL.into_iter();
    all.filter(|method| method.requires().is_none() && method.contract().never_misses())
}

/// Returns a square of the given half side in the plane at `z`, with its front to the eye.
fn square(half: f32, z: f32) -> Mesh {
    let corners = [
        [-half, -half, z],
        [half, -half, z],
        [half, half, z],
        [-half, half, z],
    ];
    Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("a square")
}

fn cube(half: f32, z: f32) -> Mesh {
    Mesh::cuboid([-half, -half, z - half], [half, half, z + half], MaterialId(0)).expect("a cube")
}

fn hall(items: &[(&str, &Mesh, ItemOptions)], method: Method) -> Scene {
    let mut hall = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    for (name, mesh, options) in items {
        let mesh = hall.mesh((*mesh).clone());
        let item = hall.item(name, mesh, Transform::IDENTITY);
        hall.set_options(item, *options);
    }
    Scene::single(hall.build().expect("sound"), method).expect("a hall")
}

/// A view from the origin towards −z.
fn view() -> View {
    View::new([0.0; 3], [0.0, 0.0, -1.0], [96, 96]).expect("a valid view")
}

fn seen(items: &[(&str, &Mesh, ItemOptions)], method: Method) -> Vec<String> {
    let scene = hall(items, method);
    let mut viewer = Viewer::new();
    let set = viewer.look(&scene, &view());
    set.names(&scene).map(str::to_owned).collect()
}

#[test]
fn a_proxy_hides_in_the_place_of_what_is_drawn() {
    let [shell, core, far] = [cube(1.0, -5.0), cube(0.9, -5.0), cube(0.2, -9.0)];
    let drawn = ItemOptions {
        is_occluder: false,
        ..PLAIN
    };
    let proxy = ItemOptions {
        is_drawn: false,
        ..PLAIN
    };
    for method in methods() {
        let without = [("far", &far, PLAIN), ("shell", &shell, drawn)];
        assert_eq!(seen(&without, method), ["far", "shell"], "{method}");
        let with = [
            ("far", &far, PLAIN),
            ("shell", &shell, drawn),
            ("core", &core, proxy),
        ];
        assert_eq!(seen(&with, method), ["shell"], "{method}");
    }
}

#[test]
fn an_occluder_that_is_not_drawn_hides_and_leaves_the_background() {
    let [wall, far] = [square(1.0, -3.0), square(0.5, -6.0)];
    let scenery = [
        (
            "wall",
            &wall,
            ItemOptions {
                is_drawn: false,
                ..PLAIN
            },
        ),
        ("far", &far, PLAIN),
    ];
    for method in methods() {
        assert_eq!(seen(&scenery, method), [""; 0], "{method}");
        let scene = hall(&scenery, method);
        let mut picture = OwnerPicture::new([96, 96]);
        let mut viewer = Viewer::new();
        assert_eq!(
            viewer.draw(&scene, &view(), &mut picture).items().len(),
            0,
            "{method}"
        );
        assert_eq!(picture.painted(), 0, "{method}");
    }
}

#[test]
fn what_is_only_bounds_is_seen_where_they_may_be_and_hides_nothing() {
    let cloud = Mesh::bounds_only([-0.5, -0.5, -4.5], [0.5, 0.5, -3.5]).expect("a box");
    let around = Mesh::bounds_only([-0.5, -0.5, -4.5], [0.5, 0.5, 0.5]).expect("a box");
    let beside = Mesh::bounds_only([8.0, -0.5, -4.5], [9.0, 0.5, -3.5]).expect("a box");
    let [wall, far] = [square(3.0, -2.0), square(0.1, -6.0)];
    for method in methods() {
        let open = [
            ("cloud", &cloud, PLAIN),
            ("beside", &beside, PLAIN),
            ("far", &far, PLAIN),
        ];
        assert_eq!(seen(&open, method), ["cloud", "far"], "{method}");
        let closed = [
            ("wall", &wall, PLAIN),
            ("cloud", &cloud, PLAIN),
            ("around", &around, PLAIN),
        ];
        assert_eq!(seen(&closed, method), ["wall", "around"], "{method}");
    }
    for [min, max] in [
        [[0.0; 3], [1.0, 0.0, 1.0]],
        [[0.0; 3], [f32::NAN; 3]],
        [[0.0; 3], [1e30; 3]],
    ] {
        assert!(Mesh::bounds_only(min, max).is_err(), "{min:?} {max:?}");
    }
}

#[test]
fn what_is_only_bounds_needs_no_material_and_can_be_edited() {
    let cloud = || Mesh::bounds_only([-0.5; 3], [0.5; 3]).expect("a box");
    for method in methods() {
        let mut hall = GeometryBuilder::new([]);
        let mesh = hall.mesh(cloud());
        let first = hall.item("first", mesh, Transform::translation([0.0, 0.0, -4.0]));
        let mut scene = Scene::single(hall.build().expect("sound"), method).expect("small");
        let mut edit = scene.edit();
        let second = edit.add(HALL, "second", cloud(), Transform::translation([0.0, 0.0, -8.0]));
        let second = second.expect("it fits");
        edit.set_transform(HALL, first, Transform::translation([50.0, 0.0, -4.0]))
            .expect("it may");
        edit.finish().expect("little");
        let mut viewer = Viewer::new();
        let set = viewer.look(&scene, &view());
        let ids: Vec<ItemId> = set.items().iter().map(|seen| seen.item).collect();
        assert_eq!(ids, [second], "{method}");
        assert!(set.items()[0].size_px > 0 && !set.items()[0].blends);
    }
}

#[test]
fn what_is_never_culled_is_listed_also_behind_the_eye_and_behind_a_wall() {
    let [wall, far, behind] = [square(9.0, -2.0), square(0.1, -6.0), square(0.1, 6.0)];
    let always = ItemOptions {
        never_cull: true,
        max_distance: 1.0,
        ..PLAIN
    };
    for method in methods() {
        let items = [
            ("behind", &behind, always),
            ("wall", &wall, PLAIN),
            ("far", &far, always),
        ];
        assert_eq!(seen(&items, method), ["behind", "wall", "far"], "{method}");
    }
}

#[test]
fn size_on_the_screen_is_the_same_whichever_axis_of_eye_space_is_up_and_in_parallel() {
    // 0.04 x 0.04 at a distance of 4: a diagonal of about a pixel.
    let small = square(0.02, -4.0);
    let pixels = 48.0 * 3.0_f32.sqrt() * 0.04 * 2.0_f32.sqrt() / 4.0;
    let [x, y, z, w] = view().clip_from_eye();
    // Eye spaces with y up and z back, with z up and y ahead, and one of half the size.
    let up_z = [
        [1., 0., 0., 0.],
        [0., 0., 1., 0.],
        [0., -1., 0., 0.],
        [0., 0., 0., 1.],
    ];
    let half = [
        [0.5, 0., 0., 0.],
        [0., 0.5, 0., 0.],
        [0., 0., 0.5, 0.],
        [0., 0., 0., 1.],
    ];
    let same = view().eye_from_sector().columns_f64();
    let same = std::array::from_fn(|column| {
        let [x, y, z] = same[column];
        [x, y, z, if column == 3 { 1.0 } else { 0.0 }]
    });
    let back = |column: [f64; 4]| column.map(|value| -value);
    let reversed = ClipDepth::OneToZero;
    let views = [
        View::from_matrices(same, [x, y, z, w], reversed, [96, 96]),
        View::from_matrices(up_z, [x, back(z), y, w], reversed, [96, 96]),
        View::from_matrices(half, [x, y, z, w], reversed, [96, 96]),
        // As large as at a distance of 4.
        View::parallel(
            [0.0; 3],
            [0.0, 0.0, -1.0],
            [0.0, 1.0, 0.0],
            8.0 / 3.0_f64.sqrt(),
            [96, 96],
        ),
    ];
    for view in views {
        let view = view.expect("a valid view");
        let listed = [0.98, 1.02].map(|part| {
            let min_size_px = part * pixels;
            let scene = hall(
                &[("small", &small, ItemOptions { min_size_px, ..PLAIN })],
                Method::Svbsp,
            );
            let mut viewer = Viewer::new();
            viewer.look(&scene, &view);
            viewer.stats().items_ignored
        });
        assert_eq!(listed, [0, 1], "{view:?}");
    }
}

#[test]
fn what_is_too_far_or_too_small_is_ignored_and_counted() {
    // Squares one behind the other, the nearer ones smaller.
    let squares: Vec<Mesh> = (1..=8_u8)
        .map(|step| square(0.02 * f32::from(step * step), -f32::from(step)))
        .collect();
    let count = |options: ItemOptions, method: Method| {
        let items: Vec<_> = squares.iter().map(|mesh| ("", mesh, options)).collect();
        let scene = hall(&items, method);
        let mut viewer = Viewer::new();
        // Each thread would count on its own.
        viewer.options.parallel = false;
        (
            viewer.look(&scene, &view()).items().len(),
            viewer.stats().items_ignored,
        )
    };
    // Focal length in pixels, for a vertical field of view of 60°.
    let focal = 48.0 * 3.0_f32.sqrt();
    for method in methods() {
        assert_eq!(count(PLAIN, method), (8, 0), "{method}");
        for reach in 0..=8_u8 {
            let max_distance = f32::from(reach) + 0.5;
            let options = ItemOptions {
                max_distance,
                ..PLAIN
            };
            assert_eq!(
                count(options, method),
                (reach.into(), u64::from(8 - reach)),
                "{method}, {reach}"
            );
            // The diameter of square `step` is 2 √2 · 0.02 · step² seen from a distance of `step`.
            let min_size_px = focal * 8.0_f32.sqrt() * 0.02 * (f32::from(reach) + 0.5);
            let options = ItemOptions { min_size_px, ..PLAIN };
            let large = usize::from(8 - reach);
            assert_eq!(count(options, method), (large, reach.into()), "{method}, {reach}");
        }
    }
    // What is ignored hides nothing either.
    let [wall, far] = [square(9.0, -5.0), square(0.5, -6.0)];
    let ignored = ItemOptions {
        max_distance: 4.0,
        ..PLAIN
    };
    for method in methods() {
        assert_eq!(
            seen(&[("wall", &wall, ignored), ("far", &far, PLAIN)], method),
            ["far"],
            "{method}"
        );
    }
}
