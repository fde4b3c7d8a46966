//! Degenerate faces: every method keeps its contract on them, in bounded memory.

use enfilade::laws::{OwnerPicture, Reference};
use enfilade::{
    Contract, Geometry, GeometryBuilder, Limits, Material, MaterialId, Mesh, Method, Scene, SceneBuilder,
    SectorId, Transform, View, Viewer,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A degenerate triangle, in a space of ±1.
#[derive(Clone, Debug)]
struct Awkward {
    corners: [[f32; 3]; 3],
    /// Number of copies, each a separate item.
    copies: u8,
}

fn point() -> impl Strategy<Value = [f32; 3]> {
    // Coarse coordinates, so that faces touch, are coplanar and cross in one line; and fine ones.
    let coarse = (-4_i8..=4).prop_map(|value| f32::from(value) * 0.25);
    let value = prop_oneof![3 => coarse, 1 => -1.0_f32..1.0];
    prop::array::uniform3(value)
}

fn awkward() -> impl Strategy<Value = Awkward> {
    let any = (point(), point(), point()).prop_map(|(a, b, c)| [a, b, c]);
    let sliver = (point(), point(), -1e-6_f32..1e-6).prop_map(|(a, b, off)| {
        let mut middle: [f32; 3] = std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]));
        middle[1] += off;
        [a, b, middle]
    });
    let needle = (point(), point()).prop_map(|(a, b)| [a, b, b.map(f32::next_up)]);
    let flat = (point(), point()).prop_map(|(a, b)| [a, b, a]);
    let in_one_plane =
        (point(), point(), point()).prop_map(|(a, b, c)| [a, b, c].map(|[x, y, _]| [x, y, 0.25]));
    let corners = prop_oneof![4 => any, 2 => sliver, 1 => needle, 1 => flat, 4 => in_one_plane];
    (corners, 1_u8..4).prop_map(|(corners, copies)| Awkward { corners, copies })
}

fn geometry(faces: &[Awkward], scale: f32) -> Geometry {
    let mut geometry = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    }]);
    for face in faces {
        let corners = face.corners.map(|corner| corner.map(|value| value * scale));
        let mesh =
            geometry.mesh(Mesh::triangles(&corners, &[0, 1, 2], MaterialId(0)).expect("finite corners"));
        for _ in 0..face.copies {
            geometry.item("face", mesh, Transform::IDENTITY);
        }
    }
    geometry.build().expect("sound items")
}

fn scene(geometry: Geometry) -> Scene {
    let mut scene = SceneBuilder::new();
    scene.add("world", geometry, Method::ZBuffer);
    scene.build().expect("one sector")
}

/// Tests every method against its contract. Returns the number of certainly visible items.
fn every_method_keeps_its_contract(scene: &Scene, view: &View) -> usize {
    let truth = Reference::new(scene).see(scene, view, &Limits::default());
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let seen = scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("few faces");
        let mut viewer = Viewer::new();
        let mut picture = OwnerPicture::new(view.size);
        viewer.draw(&seen, view, &mut picture);
        let verdict = truth.check(viewer.visible(), Some(&picture));
        if method.contract().never_misses() {
            let first = truth.different(&picture).next();
            let why =
                first.map(|at| format!("{at:?} is {:?}, not {}", picture.owner(at), truth.describe(at)));
            assert_eq!(verdict.pixels_different, 0, "{method}: {why:?}");
            assert_eq!(verdict.missed, [], "{method}");
        }
        // A tree may split n faces into at most n² pieces, if each one crosses all others.
        let faces = scene.build_stats().faces;
        assert!(
            seen.build_stats().faces <= faces * faces.max(2),
            "{method} made {:?} of {faces}",
            seen.build_stats()
        );
    }
    truth.visible().len()
}

/// The same scenes every time, unless `PROPTEST_CASES` requests more and other ones.
fn by_chance() -> ProptestConfig {
    let default = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => default,
        None => ProptestConfig {
            cases: 64,
            rng_seed: RngSeed::Fixed(3),
            ..default
        },
    }
}

proptest! {
    #![proptest_config(by_chance())]

    #[test]
    fn slivers_needles_and_copies_are_seen_as_they_are_however_large_or_small(
        faces in prop::collection::vec(awkward(), 1..24),
        power in prop::sample::select(vec![-5, 0, 7]),
        eye in point(),
    ) {
        let scale = 10_f32.powi(power);
        let scene = scene(geometry(&faces, scale));
        let mut view = View::new(eye.map(|value| 3.0 * scale * (value + 0.01)), [0.1 * scale; 3], [48, 36]);
        view.near = 0.01 * scale;
        every_method_keeps_its_contract(&scene, &view);
    }
}

#[test]
fn a_hundred_thousand_faces_in_one_plane_are_one_node_of_a_tree() {
    // Ten coplanar sheets of 100 × 50 squares each: whichever is drawn first, the lowest item owns the sample.
    let (columns, rows) = (100_u32, 50_u32);
    let positions: Vec<[f32; 3]> = (0..(columns + 1) * (rows + 1))
        .map(|i| {
            [
                (i % (columns + 1)) as f32 * 0.25,
                (i / (columns + 1)) as f32 * 0.25,
                0.0,
            ]
        })
        .collect();
    let mut corners = Vec::new();
    for y in 0..rows {
        for x in 0..columns {
            let [low, high] = [y * (columns + 1) + x, (y + 1) * (columns + 1) + x];
            corners.extend([low, low + 1, high + 1, low, high + 1, high]);
        }
    }
    let mut geometry = GeometryBuilder::new([Material::opaque([0.5; 3])]);
    let sheet = geometry.mesh(Mesh::triangles(&positions, &corners, MaterialId(0)).expect("a sheet"));
    for _ in 0..10 {
        geometry.item("sheet", sheet, Transform::IDENTITY);
    }
    let scene = scene(geometry.build().expect("ten sheets"));
    let view = View::new([12.5, 6.25, 12.0], [12.5, 6.25, 0.0], [96, 54]);
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let seen = scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("they fit");
        let built = seen.build_stats();
        assert_eq!((built.faces, built.splits), (100_000, 0), "{method}");
        assert!(built.depth <= 1, "{method}: {}", built.depth);
        let mut viewer = Viewer::new();
        let set = viewer.look(&seen, &view);
        assert_eq!(set.items()[0].item.index.0, 0, "{method}");
        if method.contract() == Contract::Exact {
            assert_eq!(set.items().len(), 1, "{method}: only the lowest of ten is seen");
        }
    }
}

#[test]
fn items_without_faces_or_extent_are_never_seen_and_hide_nothing() {
    let wall = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let build = |with_wall: bool| {
        let mut geometry = GeometryBuilder::new([Material {
            double_sided: true,
            ..Material::opaque([0.5; 3])
        }]);
        let nothing = geometry.mesh(Mesh::new(&[]).expect("no face breaks a rule"));
        let wall = geometry.mesh(Mesh::triangles(&wall, &[0, 1, 2], MaterialId(0)).expect("a triangle"));
        for at in [[0.0; 3], [0.0, 0.0, 1.0], [0.0, 0.0, 3.0]] {
            geometry.item("nothing", nothing, Transform::translation(at));
        }
        if with_wall {
            geometry.item("wall", wall, Transform::IDENTITY);
        }
        // In front of the wall: a point, a vertical line, and a sheet seen edge-on.
        for factors in [[0.0; 3], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0]] {
            let before = Transform::translation([0.0, 0.0, 1.0]);
            geometry.item("flattened", wall, before * Transform::scaling(factors));
        }
        geometry.item("nothing", nothing, Transform::scaling([0.0; 3]));
        scene(geometry.build().expect("sound items"))
    };
    let view = View::new([0.0, 0.0, 4.0], [0.0; 3], [64, 48]);
    for (scene, expected) in [(build(true), 1), (build(false), 0)] {
        assert_eq!(every_method_keeps_its_contract(&scene, &view), expected);
        for method in Method::ALL
            .into_iter()
            .filter(|method| method.requires().is_none())
        {
            let seen = scene
                .with_method(method, Method::DEFAULT_LIMIT)
                .expect("few faces");
            let mut viewer = Viewer::new();
            let set = viewer.look(&seen, &view);
            let geometry = scene.geometry(SectorId(0)).expect("a geometry");
            let names: Vec<&str> = set
                .items()
                .iter()
                .map(|seen| geometry.name(seen.item.index))
                .collect();
            assert!(!names.contains(&"nothing"), "{method}: {names:?}");
            if method.contract() == Contract::Exact {
                assert_eq!(names.len(), expected, "{method}: {names:?}");
            }
        }
    }
}

#[test]
fn a_thousand_copies_of_one_face_look_like_one() {
    let face = Awkward {
        corners: [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.3], [0.0, 1.0, -0.2]],
        copies: 250,
    };
    let scene = scene(geometry(&[face.clone(), face.clone(), face.clone(), face], 1.0));
    let view = View::new([0.2, 0.1, 3.0], [0.0; 3], [64, 48]);
    assert_eq!(
        every_method_keeps_its_contract(&scene, &view),
        0,
        "all is contested between copies"
    );
    for method in Method::ALL
        .into_iter()
        .filter(|method| method.requires().is_none())
    {
        let seen = scene
            .with_method(method, Method::DEFAULT_LIMIT)
            .expect("few faces");
        assert_eq!(seen.build_stats().faces, 1000, "{method} split coplanar faces");
        let items = Viewer::new().look(&seen, &view).items().len();
        let exact = method.contract() == Contract::Exact;
        assert!(items == 1 || (items > 1 && !exact), "{method}: {items}");
    }
}

#[test]
fn the_near_half_of_a_fold_hides_a_blade_that_passes_before_the_far_half() {
    // A sheet is folded at a vertical edge, with both halves to the left of it: the far half recedes to the left, the
    // near half comes back in front of it. A slanted blade is in front of the far half and behind the near half. At the
    // near half's end the far half continues beside it, though not at the fold.
    let [low, high] = [[3.2, -4.0, -8.0], [3.2, 4.0, -8.0]];
    let far = [-15.0, 0.0, -30.0];
    let near = [-1.0, 0.0, -5.0];
    let fold = Mesh::triangles(&[low, high, far, near], &[0, 1, 2, 1, 0, 3], MaterialId(0));
    let blade = [[-4.0, -0.5, -10.0], [0.9, -0.5, -10.0], [-1.5, 0.8, -10.0]];
    let blade = Mesh::triangles(&blade, &[0, 1, 2], MaterialId(0));
    let mut geometry = GeometryBuilder::new([Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    }]);
    for mesh in [fold, blade] {
        let mesh = geometry.mesh(mesh.expect("sound triangles"));
        geometry.item("part", mesh, Transform::IDENTITY);
    }
    let scene = scene(geometry.build().expect("two items"));
    let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [160, 90]);
    assert_eq!(every_method_keeps_its_contract(&scene, &view), 2);
}
