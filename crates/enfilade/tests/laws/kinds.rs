//! Every law holds for items of every kind: only bounds, not drawn, no occluders, never culled, and in some layers.

use crate::subject::{SIZE, drawn, limits, subject, viewer};
use crate::the_laws_hold_in;
use enfilade::laws::Reference;
use enfilade::{
    Contract, Geometry, GeometryBuilder, ItemIndex, ItemOptions, Limits, Mesh, Method, Scene, View,
    VisibleSet,
};
use enfilade_scenes::{BuiltIn, Random, random_scene};
use std::sync::Arc;

/// Returns the same geometry with items of random kinds: some are replaced by their bounds.
fn with_kinds(geometry: &Geometry, random: &mut Random) -> Geometry {
    let mut builder = GeometryBuilder::new(geometry.materials());
    builder.textures(geometry.textures());
    for (index, item) in (0..).map(ItemIndex).zip(geometry.items()) {
        let bounds = geometry.mesh_of(index).bounds();
        let is_bounds = random.below(5) == 0;
        let only_bounds = Mesh::bounds_only(bounds.min, bounds.max)
            .ok()
            .filter(|_| is_bounds);
        let own = Arc::clone(&geometry.meshes()[item.mesh.0 as usize]);
        let mesh = builder.mesh(only_bounds.map_or(own, Arc::new));
        let built = builder.item(geometry.name(index), mesh, item.transform());
        let options = ItemOptions {
            is_occluder: random.below(4) > 0,
            is_drawn: random.below(5) > 0,
            never_cull: random.below(12) == 0,
            layers: [1, 2, 3, u32::MAX][random.below(4)],
            ..ItemOptions::default()
        };
        builder.set_options(built, options);
    }
    for opening in geometry.openings() {
        builder.opening(&opening.name, opening.outline.clone());
    }
    builder.build().expect("as sound as it was")
}

/// Returns a scene of the laws, or a random one, with items of random kinds, and views of it.
fn stage(name: Option<&str>, seed: u64) -> (Scene, Vec<View>) {
    let BuiltIn { mut scene, cameras } = match name {
        Some(name) => subject(name).built.clone(),
        None => random_scene(seed),
    };
    let mut random = Random::new(seed);
    for id in scene.sectors() {
        let geometry = with_kinds(scene.geometry(id).expect("ours"), &mut random);
        scene
            .set_method(id, Method::ZBuffer)
            .expect("it takes any geometry");
        scene.set_geometry(id, geometry).expect("the same openings");
    }
    let size = if name.is_some() { SIZE } else { [64, 48] };
    let views = cameras
        .iter()
        .take(6)
        .map(|camera| camera.view(size).expect("a valid view"));
    (scene, views.collect())
}

/// Calls `check` with scenes of all sorts.
fn on_all_stages(mut check: impl FnMut(&str, &Scene, &[View])) {
    for (seed, name) in (1..).zip(["crowd", "glass", "house", "mirror", "two-rooms", "impossible"]) {
        let (scene, views) = stage(Some(name), seed);
        check(name, &scene, &views);
    }
    for seed in 100..124 {
        let (scene, views) = stage(None, seed);
        check(&format!("random {seed}"), &scene, &views);
    }
}

/// Checks what a set holds whatever is visible: no item that is not drawn or in no layer looked at, and every item that
/// is never culled, once for each passage.
fn holds_what_it_must(scene: &Scene, set: &VisibleSet, layers: u32, what: &str) -> usize {
    let mut anyway = 0;
    for (number, passage) in set.passages().iter().enumerate() {
        let geometry = scene.geometry(passage.sector).expect("ours");
        let own = set
            .items()
            .iter()
            .filter(|seen| seen.passage.0 as usize == number);
        let listed: Vec<ItemIndex> = own.map(|seen| seen.item.index).collect();
        assert!(listed.is_sorted_by(|a, b| a < b), "{what}: {listed:?}");
        for (index, item) in (0..).map(ItemIndex).zip(geometry.items()) {
            let ItemOptions {
                is_drawn,
                never_cull,
                layers: own,
                ..
            } = item.options;
            let may = is_drawn && own & layers != 0;
            let is_listed = listed.contains(&index);
            assert!(may || !is_listed, "{what}: {index:?} is listed");
            assert!(!(may && never_cull) || is_listed, "{what}: {index:?} is culled");
            anyway += usize::from(may && never_cull);
        }
    }
    anyway
}

#[test]
fn the_laws_hold_for_items_of_every_kind() {
    let (mut visible, mut anyway) = (0, 0);
    on_all_stages(|name, scene, views| {
        visible += the_laws_hold_in(name, scene, views).visible;
        let mut viewer = viewer();
        for view in views {
            anyway += holds_what_it_must(scene, viewer.look(scene, view), u32::MAX, name);
        }
    });
    assert!(visible > 500 && anyway > 50, "{visible} {anyway}");
}

#[test]
fn what_is_in_other_layers_is_neither_seen_nor_hides() {
    let (mut visible, mut differ) = (0, 0);
    on_all_stages(|name, scene, views| {
        let whole = Reference::new(scene);
        for layers in [1, 2] {
            let reference = Reference::of_layers(scene, layers);
            for method in Method::ALL.into_iter().filter(|&method| scene.suits(method)) {
                let scene = scene.with_method(method, u64::MAX).expect("small");
                // It remembers what it saw in all layers.
                let mut viewer = viewer();
                for view in &views[..views.len().min(2)] {
                    let what = format!("{method} on @{name}, layers {layers}");
                    viewer.options.layers = u32::MAX;
                    viewer.look(&scene, view);
                    viewer.options.layers = layers;
                    let truth = reference.see(&scene, view, &limits());
                    let picture = drawn(&mut viewer, &scene, view);
                    holds_what_it_must(&scene, viewer.visible(), layers, &what);
                    let verdict = truth.check(viewer.visible(), Some(&picture));
                    visible += verdict.reference_visible;
                    let seen_at_all = whole.see(&scene, view, &Limits::default()).visible();
                    differ += usize::from(!truth.visible().is_subset(&seen_at_all));
                    if method.contract().never_misses() {
                        assert_eq!(verdict.missed, [], "{what}");
                        assert_eq!(verdict.pixels_different, 0, "{what}");
                    }
                    if method.contract() == Contract::Exact {
                        assert_eq!(verdict.extra, 0, "{what}");
                    }
                }
            }
        }
    });
    // Some are visible only because what hides them is in another layer.
    assert!(visible > 1000 && differ > 10, "{visible} {differ}");
}
