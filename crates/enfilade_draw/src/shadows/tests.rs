//! Pictures with the casters found equal those with all items as casters.
#![allow(clippy::print_stdout, reason = "a long test says how much it tested")]

use super::*;
use crate::painter::Painter;
use crate::stage::Settings;
use enfilade::{Light, LightShape, Method, View, Viewer, survey};
use enfilade_import::{ReadOptions, read};
use enfilade_scenes::{BuiltIn, Random, built_in, with_random_lights};
use image::RgbImage;
use std::path::Path;

const SIZE: [u32; 2] = [192, 108];

impl Shadows {
    /// Makes every item a caster, wherever light goes.
    fn of_everything(scene: &Scene) -> Shadows {
        let of_light = |light: LightId| {
            let reach = scene.light_reach(light, &limits());
            let mut chains: Vec<Vec<PortalId>> = Vec::new();
            let mut items = HashMap::new();
            for beam in &reach {
                let mut chain = beam
                    .parent
                    .map_or(Vec::new(), |parent| chains[parent as usize].clone());
                chain.extend(beam.portal);
                let count = scene
                    .geometry(beam.sector)
                    .map_or(0, |geometry| geometry.items().len());
                let all = (0..count as u32).map(|item| (ItemIndex(item), Vec::new()));
                items.insert(chain.clone(), all.collect());
                chains.push(chain);
            }
            CastersOfLight { reach, items }
        };
        let count = scene.lights().len() as u32;
        Shadows {
            lights: (0..count).map(|light| of_light(LightId(light))).collect(),
        }
    }

    fn count(&self) -> usize {
        let lights = self.lights.iter();
        lights
            .flat_map(|light| light.items.values())
            .map(BTreeMap::len)
            .sum()
    }
}

/// Draws views with both, and returns the numbers of casters.
fn compare(name: &str, scene: &Scene, views: &[View]) -> [usize; 2] {
    let stage = Stage::new(scene);
    let settings = Settings {
        shadows: true,
        ..Settings::default()
    };
    let mut counts = [0; 2];
    for view in views {
        let mut viewer = Viewer::new();
        viewer.look(scene, view);
        let found = Shadows::of(scene, viewer.visible());
        let all = Shadows::of_everything(scene);
        let here = [found.count(), all.count()];
        (0..2).for_each(|i| counts[i] += here[i]);
        let [found, all]: [RgbImage; 2] = [found, all].map(|shadows| {
            let mut painter = Painter::on(&stage, scene, view, &settings);
            painter.shadows = Some(shadows);
            viewer.draw(scene, view, &mut painter);
            painter.finish().image
        });
        assert!(found == all, "{name}: other shadows from {view:?}");
    }
    counts
}

/// Returns a scene with a sun, a spot light and a point light alone.
fn with_three_lights(scene: &Scene, at: [f32; 3], random: &mut Random) -> Scene {
    let mut scene = scene.clone();
    for number in 0..scene.lights().len() as u32 {
        let off = Light {
            color: [0.0; 3],
            range: 1e-3,
            ..scene.lights()[number as usize]
        };
        scene.set_light(LightId(number), off).expect("a valid light");
    }
    let size = |id: &SectorId| scene.bounds(*id).volume();
    let largest = scene
        .sectors()
        .max_by(|a, b| size(a).total_cmp(&size(b)))
        .expect("a sector");
    let here = scene
        .locate(at.map(f64::from), at.map(f64::from))
        .unwrap_or(largest);
    let direction = [random.between(-1.0, 1.0), -1.0, random.between(-1.0, 1.0)];
    let range = 0.5 * scene.bounds(here).longest_side();
    let lights = [
        (largest, LightShape::Sun { direction }),
        (
            here,
            LightShape::Spot {
                direction,
                inner: 0.4,
                outer: 0.9,
            },
        ),
        (here, LightShape::Point),
    ];
    for (sector, shape) in lights {
        let light = Light {
            shape,
            ..Light::point(sector, at, [8.0; 3], range)
        };
        scene.add_light(light).expect("a valid light");
    }
    scene
}

#[test]
fn shadows_of_the_casters_found_are_those_of_all_items() {
    let mut random = Random::new(5);
    let mut sum = [0; 2];
    for name in ["two-rooms", "mirror", "nested", "teleport"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        let scene = with_random_lights(&scene, &mut random);
        let views: Vec<View> = cameras
            .iter()
            .map(|camera| camera.view(SIZE).expect("a valid view"))
            .collect();
        let counts = compare(name, &scene, &views);
        (0..2).for_each(|i| sum[i] += counts[i]);
    }
    assert!(3 * sum[0] < 2 * sum[1], "{sum:?}");
}

#[test]
#[ignore = "needs ENFILADE_SCENES"]
fn shadows_of_the_casters_found_are_those_of_all_items_in_real_scenes() {
    let folder = std::env::var_os("ENFILADE_SCENES").expect("ENFILADE_SCENES names a folder");
    let mut scenes = vec![(
        "palace".to_owned(),
        built_in("enfilade").expect("the palace").scene,
    )];
    for name in ["ifc_office_a.glb", "city_san_francisco.glb"] {
        let import = read(&Path::new(&folder).join(name), &ReadOptions::default()).expect("a scene");
        let scene = import.scene(Method::Masked, Method::DEFAULT_LIMIT);
        scenes.push((name.to_owned(), scene.expect("a scene")));
    }
    let mut random = Random::new(6);
    for (name, scene) in scenes {
        let mut sum = [0; 2];
        for place in &survey(&scene, 50).views {
            let view = View::new(place.eye, place.toward, SIZE).expect("a valid view");
            let lit = with_three_lights(&scene, place.eye, &mut random);
            let counts = compare(&name, &lit, &[view.in_sector(place.sector)]);
            (0..2).for_each(|i| sum[i] += counts[i]);
        }
        println!(
            "{name}: {} of {} casters, by light and chain of portals",
            sum[0], sum[1]
        );
    }
}
