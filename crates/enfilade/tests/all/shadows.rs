//! Shadow casters: what is found holds everything that blocks light on its way to a point that is seen.

use enfilade::laws::{Lamplight, SurfacePoint};
use enfilade::{
    Light, LightId, LightShape, LightView, Scene, ShadowCasters, View, Viewer, ViewerOptions, VisibleItem,
    VisibleSet,
};
use enfilade_scenes::{BuiltIn, Random, built_in, parallel_view, random_scene, with_random_lights};
use std::collections::HashSet;

const SIZE: [u32; 2] = [32, 20];

/// Returns the points that are seen at the pixels of a view, with their faces.
fn seen_points(scene: &Scene, view: &View) -> Vec<SurfacePoint> {
    let sector = scene.sector_of(view).expect("an eye in a sector");
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    let along = |pixel: [u32; 2]| {
        let at = [0, 1].map(|axis| f64::from(pixel[axis]) + 0.5 + View::GENERIC_OFFSET[axis]);
        SurfacePoint::first_along(scene, sector, view.ray(at))
    };
    pixels.filter_map(along).collect()
}

/// Returns the items that cast shadows, by light and sector.
fn casters(scene: &Scene, set: &VisibleSet, shadows: &mut ShadowCasters) -> HashSet<(u32, u32, u32)> {
    let mut found = HashSet::new();
    for light in (0..scene.lights().len() as u32).map(LightId) {
        let items = |maps: &[LightView]| {
            let each = |map: &LightView| {
                let items = map.casters.items().iter();
                let of = |seen: &VisibleItem| {
                    (
                        light.0,
                        map.casters.passage(seen.passage).sector.0,
                        seen.item.index.0,
                    )
                };
                items.map(of).collect::<Vec<_>>()
            };
            maps.iter().map(each).collect::<Vec<_>>()
        };
        let maps = shadows.find(scene, light, set);
        let (here, views) = (items(maps), maps.iter().map(|map| map.view).collect::<Vec<_>>());
        if shadows.cascades.is_empty() {
            // The views found, handed in, have the same casters.
            assert_eq!(here, items(shadows.find_in(scene, light, &views, set)));
        } else if matches!(scene.lights()[light.0 as usize].shape, LightShape::Sun { .. }) {
            assert!(here.len() <= shadows.cascades.len());
        }
        found.extend(here.into_iter().flatten());
    }
    found
}

/// Checks the casters of a view against the faces that block light. Returns the number of faces, of casters, and of items
/// that are none.
fn check(name: &str, scene: &Scene, view: &View) -> [usize; 3] {
    const CROSSINGS: u16 = 3;
    let mut shadows = ShadowCasters::new();
    shadows.options.limits.max_crossings = CROSSINGS;
    let mut viewer = Viewer::with_options(ViewerOptions {
        limits: shadows.options.limits,
        ..ViewerOptions::default()
    });
    let set = viewer.look(scene, view);
    let found = casters(scene, set, &mut shadows);
    // All distances of these scenes are in some cascade.
    shadows.cascades = vec![2.0, 5.0, 1e6];
    let in_cascades = casters(scene, set, &mut shadows);
    let lamplight = Lamplight::new(scene, usize::from(CROSSINGS)).with_shadows();
    let mut blocked = 0;
    let is_listed = |point: &SurfacePoint| {
        let geometry = scene.geometry(point.sector).expect("a geometry");
        // Rays go through items that a scale of 0 flattens, and so may reach what is hidden.
        set.sees(point.sector, geometry.id_of(point.face.0))
    };
    for point in seen_points(scene, view).into_iter().filter(is_listed) {
        for (light, sector, face) in lamplight.blockers(&point).unwrap_or_default() {
            let Some((item, face)) = face else { continue };
            let caster = (light.0, sector.0, item.0);
            assert!(
                found.contains(&caster) && in_cascades.contains(&caster),
                "@{name}: face {face} of item {} in sector {} casts a shadow of light {} on {point:?}, from {view:?}",
                item.0,
                sector.0,
                light.0
            );
            blocked += 1;
        }
    }
    let items = scene.sectors().filter_map(|id| scene.geometry(id));
    let items: usize = items.map(|geometry| geometry.items().len()).sum();
    let others = (items * scene.lights().len()).saturating_sub(found.len());
    [blocked, found.len(), others]
}

#[test]
fn all_that_blocks_light_on_its_way_to_what_is_seen_casts_shadows() {
    let mut random = Random::new(91);
    let mut sum = [0; 3];
    let mut add = |counts: [usize; 3]| (0..3).for_each(|i| sum[i] += counts[i]);
    for name in ["two-rooms", "mirror", "nested", "teleport"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        for camera in &cameras {
            let scene = with_random_lights(&scene, &mut random);
            add(check(name, &scene, &camera.view(SIZE).expect("a valid view")));
            add(check(name, &scene, &parallel_view(camera, SIZE, &mut random)));
        }
    }
    for seed in 0..200 {
        let BuiltIn { scene, cameras } = random_scene(seed);
        for camera in cameras.iter().take(2) {
            let scene = with_random_lights(&scene, &mut random);
            add(check(
                &format!("{seed}"),
                &scene,
                &camera.view(SIZE).expect("a valid view"),
            ));
        }
    }
    let [blocked, found, others] = sum;
    assert!(blocked > 10_000 && found > 5000 && others > 10_000, "{sum:?}");
}

#[test]
fn a_light_behind_more_doors_than_its_look_may_follow_says_that_casters_may_be_missing() {
    let BuiltIn { mut scene, cameras } = built_in("two-rooms").expect("a built-in scene");
    let near = scene.sectors().next().expect("two rooms");
    let middle = scene.bounds(near).center();
    let lamp = Light::point(near, middle, [1.0; 3], 100.0);
    let lamp = scene.add_light(lamp).expect("a valid light");
    let view = cameras[0].view(SIZE).expect("a valid view");
    let mut viewer = Viewer::new();
    let set = viewer.look(&scene, &view);
    let mut shadows = ShadowCasters::new();
    let followed = shadows.find(&scene, lamp, set);
    assert!(followed.iter().all(|map| map.casters.complete()));
    let through_door = |map: &&LightView| map.casters.passages().len() > 1;
    let behind: Vec<u32> = followed
        .iter()
        .filter(through_door)
        .map(|map| map.number)
        .collect();
    assert!(!behind.is_empty());
    shadows.options.limits.max_crossings = 0;
    let cut = shadows.find(&scene, lamp, set).iter();
    let incomplete: Vec<u32> = cut
        .filter(|map| !map.casters.complete())
        .map(|map| map.number)
        .collect();
    assert_eq!(incomplete, behind);
}
