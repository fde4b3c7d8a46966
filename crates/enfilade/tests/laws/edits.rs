//! Every law holds for scenes that are edited between looks, with viewers that remember removed items.

use crate::subject::{SIZE, Subject, drawn, limits, names, subject, subjects, viewer};
use enfilade::laws::{Reference, Truth};
use enfilade::{
    Contract, Geometry, GeometryBuilder, ItemIndex, Material, MaterialId, Mesh, Method, Scene, SceneBuilder,
    SectorId, Transform, View, Viewer,
};
use enfilade_scenes::{Random, random_edits};
use std::collections::BTreeSet;
use std::sync::{Arc, LazyLock};

/// Returns the same geometry, built from scratch without the removed items.
pub(crate) fn afresh(geometry: &Geometry) -> Geometry {
    let mut builder = GeometryBuilder::new(geometry.materials());
    builder.textures(geometry.textures());
    for number in (0..geometry.items().len() as u32).map(ItemIndex) {
        if geometry.holds(number) {
            let item = geometry.item(number);
            let mesh = builder.mesh(Arc::clone(&geometry.meshes()[item.mesh.0 as usize]));
            let built = builder.item(geometry.name(number), mesh, item.transform());
            builder.set_options(built, item.options);
        }
    }
    for opening in geometry.openings() {
        builder.opening(&opening.name, opening.outline.clone());
    }
    builder.build().expect("as sound as it was")
}

/// The methods without requirements, which suit any edited geometry. Baked data is valid only while walls stay (see
/// `tests/all/baked_cells/`), and convex cells only while they are convex (see `tests/laws/convex/`).
pub(crate) static FOLLOWING: LazyLock<Vec<Method>> = LazyLock::new(|| {
    let all = Method::ALL.into_iter();
    all.filter(|method| method.requires().is_none()).collect()
});

/// Looks and draws, and compares both with the reference at the samples and anywhere in the pixels, and with a viewer
/// without memory. Returns the set.
pub(crate) fn keeps_its_contract(
    method: Method,
    scene: &Scene,
    view: &View,
    [viewer, forgetful]: [&mut Viewer; 2],
    [truth, anywhere]: [&Truth; 2],
    place: &str,
) -> BTreeSet<String> {
    let contract = method.contract();
    viewer.look(scene, view);
    let looked = names(scene, viewer.visible());
    forgetful.look(scene, view);
    assert_eq!(
        looked,
        names(scene, forgetful.visible()),
        "{place}: without memory"
    );
    let picture = drawn(viewer, scene, view);
    assert_eq!(looked, names(scene, viewer.visible()), "{place}: drawn");
    let verdict = truth.check(viewer.visible(), Some(&picture));
    let first = truth.different(&picture).next();
    let why = first.map(|at| format!("{at:?} is {:?}, not {}", picture.owner(at), truth.describe(at)));
    if contract.never_misses() {
        assert_eq!(verdict.pixels_different, 0, "{place}: {why:?}");
        assert_eq!(verdict.missed, [], "{place}");
    }
    if contract == Contract::Strict {
        let verdict = anywhere.check(viewer.visible(), None);
        assert_eq!(verdict.missed, [], "{place}, anywhere in a pixel");
    }
    if contract == Contract::Exact {
        assert_eq!(verdict.extra, 0, "{place}");
    }
    looked
}

/// Edits a scene round after round with each method. Tests every look against the method's contract and against the
/// same scene built from scratch. Returns the number of edited items and of certainly visible ones.
fn laws_hold_under_edits(subject: &Subject, methods: &[Method], rounds: u64, count: usize) -> [usize; 2] {
    let mut scenes: Vec<(Method, Scene, Viewer)> = methods
        .iter()
        .map(|&method| (method, subject.seen_by(method).clone(), viewer()))
        .collect();
    let at_first: Vec<usize> = (subject.built.scene.sectors())
        .map(|id| {
            subject
                .built
                .scene
                .geometry(id)
                .map_or(0, |geometry| geometry.item_count())
        })
        .collect();
    let (mut edits, mut looked_at) = (0, 0);
    for round in 0..rounds {
        for (method, scene, _) in &mut scenes {
            let done = random_edits(scene, count, &at_first, &mut Random::new(1000 * round + 17));
            let done = done.expect("the scenes of the laws are small");
            edits += done.items as usize;
            let rebuilds = method.order() == "Bsp";
            assert!(rebuilds || done.rebuilt == 0, "{method} follows in place");
        }
        let edited = &scenes[0].1;
        let mut fresh = edited.clone();
        for id in edited.sectors() {
            let geometry = afresh(edited.geometry(id).expect("ours"));
            fresh.set_geometry(id, geometry).expect("the same openings");
        }
        let camera = &subject.built.cameras[round as usize % subject.built.cameras.len()];
        let mut view = camera.view(SIZE).expect("a valid view");
        view.sector = edited.sector_of(&subject.built.cameras[0].view(SIZE).expect("a valid view"));
        let truth = Reference::new(edited).see(edited, &view, &limits());
        let anywhere = Reference::new(edited).see_anywhere(edited, &view, &limits(), 2, round);
        looked_at += truth.visible().len();
        for (method, scene, viewer) in &mut scenes {
            let place = format!("{method} on @{} in round {round}", subject.name);
            let mut forgetful = crate::subject::viewer();
            let looked = keeps_its_contract(
                *method,
                scene,
                &view,
                [viewer, &mut forgetful],
                [&truth, &anywhere],
                &place,
            );
            for budget in [0, 1, 100_000] {
                forgetful.options.occluders = Some(budget);
                let verdict = truth.check(forgetful.look(scene, &view), None);
                if method.contract().never_misses() {
                    assert_eq!(verdict.missed, [], "{place} with {budget} occluders");
                }
            }
            if method.contract() == Contract::Exact {
                let fresh = fresh.with_method(*method, u64::MAX).expect("small");
                let mut viewer = crate::subject::viewer();
                viewer.look(&fresh, &view);
                assert_eq!(looked, names(&fresh, viewer.visible()), "{place}: built afresh");
                // The same focal length: all samples of this screen are among those of the wide one.
                let mut wide = camera.view([3 * SIZE[0], SIZE[1]]).expect("a valid view");
                wide.sector = view.sector;
                viewer.look(scene, &wide);
                let wide = names(scene, viewer.visible());
                assert!(looked.is_subset(&wide), "{place}: less in a wider aperture");
            }
        }
    }
    [edits, looked_at]
}

#[test]
fn every_law_holds_after_a_thousand_edits_between_looks() {
    let small = |subject: &&Subject| subject.name != "enfilade";
    for subject in subjects().iter().filter(small) {
        let [edits, looked_at] = laws_hold_under_edits(subject, &FOLLOWING, 3, 1000);
        // A thousand edits touch about as many items, or most of the items if there are fewer.
        let each = subject.built.scene.item_count().min(500) / 2;
        assert!(
            edits > 3 * FOLLOWING.len() * each,
            "@{}: only {edits} items",
            subject.name
        );
        assert!(looked_at > 0, "@{}: nothing is seen", subject.name);
    }
}

#[test]
fn a_few_edits_between_looks_do_no_harm_either() {
    for name in ["mirrors", "teleport", "glass"] {
        let subject = subject(name);
        let [_, looked_at] = laws_hold_under_edits(subject, &FOLLOWING, 30, 3);
        assert!(looked_at > 30, "@{name}");
    }
}

#[test]
fn the_palace_may_be_turned_upside_down() {
    let methods = [
        Method::ZBuffer,
        Method::HierarchicalZ,
        Method::HierarchicalS,
        Method::Masked,
        Method::Svbsp,
        Method::Mobsp,
    ];
    let [_, looked_at] = laws_hold_under_edits(subject("enfilade"), &methods, 3, 1000);
    assert!(looked_at > 100);
}

/// A wall with a gap at its top, from x = 0.3 to 0.7 and down to height 1; behind it a leaning sheet whose box has
/// equal sides.
fn a_wall_and_a_thing() -> Scene {
    let material = Material {
        double_sided: true,
        ..Material::opaque([0.5; 3])
    };
    let mut builder = GeometryBuilder::new([material]);
    let mut add = |name: &str, corners: [[f32; 3]; 4]| {
        let mesh = Mesh::triangles(&corners, &[0, 1, 2, 0, 2, 3], MaterialId(0)).expect("flat");
        let mesh = builder.mesh(mesh);
        builder.item(name, mesh, Transform::IDENTITY);
    };
    let leaning = [[0.0; 3], [1.0, 0.0, 0.0], [0.8, 1.0, 1.0], [0.2, 1.0, 1.0]];
    add("thing", leaning);
    for (name, [x0, x1], top) in [
        ("wall", [-3.0, 3.0], 1.0),
        ("left", [-3.0, 0.3], 4.0),
        ("right", [0.7, 3.0], 4.0),
    ] {
        let corners = [[x0, -3.0], [x1, -3.0], [x1, top], [x0, top]];
        add(name, corners.map(|[x, y]| [x, y, 0.0]));
    }
    let mut scene = SceneBuilder::new();
    scene.add("room", builder.build().expect("sound"), Method::ZBuffer);
    scene.build().expect("one room")
}

#[test]
fn a_thing_that_was_turned_and_flattened_is_seen_where_it_looks_over_a_wall() {
    let scene = a_wall_and_a_thing();
    let view = View::new([0.4, 1.0, 4.0], [0.4, 1.0, 0.0], SIZE).expect("a valid view");
    for degrees in [10.0_f64, 40.0, 45.0, 60.0] {
        // Rotated backwards, then flattened along z: its height and its depth both point up, or one of them down.
        let turn = Transform::rotation([1.0, 0.0, 0.0], -degrees.to_radians());
        let flattened = Transform::scaling([1.0, 1.0, 0.0]) * turn;
        let tip = flattened.point([0.5, 1.0, 1.0])[1];
        for (height, is_seen) in [(1.25, true), (0.9, false)] {
            let there = Transform::translation([0.0, height - tip, -1.0]) * flattened;
            for method in Method::ALL
                .into_iter()
                .filter(|method| method.requires().is_none())
            {
                let mut scene = scene.with_method(method, u64::MAX).expect("small");
                let mut edit = scene.edit();
                let placed = edit.set_transform(SectorId(0), ItemIndex(0).into(), there);
                placed.expect("it is there");
                edit.finish().expect("no more than before");
                let truth = Reference::new(&scene).see(&scene, &view, &limits());
                let place = format!("{method}, {degrees} degrees, {height} high");
                assert_eq!(truth.visible().len(), 3 + usize::from(is_seen), "{place}");
                let verdict = truth.check(viewer().look(&scene, &view), None);
                if method.contract().never_misses() {
                    assert_eq!(verdict.missed, [], "{place}");
                }
                if method.contract() == Contract::Exact {
                    assert_eq!(verdict.extra, 0, "{place}");
                }
            }
        }
    }
}
