//! Compares rendered lamplight with light traced along every chain of portals separately.

use enfilade::laws::{Lamplight, SurfacePoint};
use enfilade::{Camera, Light, LightId, Scene, SectorId, View, Viewer};
use enfilade_draw::{RgbImage, Settings, Stage};
use enfilade_scenes::{BuiltIn, Random, built_in, random_scene, with_random_lights};
use glam::DVec3;

const SIZE: [u32; 2] = [96, 64];

fn drawn(scene: &Scene, view: &View, shadows: bool) -> (RgbImage, usize) {
    let mut settings = Settings::default();
    settings.shadows = shadows;
    let picture = Stage::new(scene).draw(&mut Viewer::new(), scene, view, &settings);
    (picture.image, picture.lights_shining)
}

/// Returns the same scene with its lamps turned off.
fn in_the_dark(scene: &Scene) -> Scene {
    let mut dark = scene.clone();
    for (number, &light) in scene.lights().iter().enumerate() {
        let off = Light {
            color: [0.0; 3],
            ..light
        };
        dark.set_light(LightId(number as u32), off)
            .expect("a valid light");
    }
    dark
}

fn decode(byte: u8) -> f64 {
    let srgb = f64::from(byte) / 255.0;
    if srgb <= 0.040_45 {
        srgb / 12.92
    } else {
        ((srgb + 0.055) / 1.055).powf(2.4)
    }
}

fn encode(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    255.0
        * if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * linear.powf(1.0 / 2.4) - 0.055
        }
}

/// Lamplight, surface colour, and the sector, item and face.
type Lit = (DVec3, [f32; 4], (u32, u32, u32));

/// Traces a ray; returns the lamplight and the surface colour it meets, or `None` if the result is ambiguous.
fn lamplight_along(scene: &Scene, lamplight: &Lamplight, view: &View, direction: DVec3) -> Option<Lit> {
    let sector = scene.sector_of(view).expect("a camera inside a sector");
    let onto = SurfacePoint::first_along(scene, sector, [view.eye(), direction.into()])?;
    let (item, face) = onto.face;
    let surface = scene.sector(onto.sector).surface(item, face);
    let light = lamplight.at(&onto)?;
    Some((light.into(), surface.color, (onto.sector.0, item.0, face)))
}

/// Returns the ray direction at an offset from a pixel's centre, in pixels.
fn direction(view: &View, [x, y]: [u32; 2], [dx, dy]: [f64; 2]) -> DVec3 {
    let [eye, toward, up] = [view.eye(), view.toward(), view.up()].map(DVec3::from);
    let forward = (toward - eye).normalize();
    let right = forward.cross(up).normalize();
    let up = right.cross(forward);
    let step = 2.0 * (0.5 * f64::from(view.fov_y())).tan() / f64::from(view.size()[1]);
    let [dx, dy] = [dx + View::GENERIC_OFFSET[0], dy + View::GENERIC_OFFSET[1]];
    let [right_of, above] = [
        f64::from(x) + 0.5 + dx - 0.5 * f64::from(view.size()[0]),
        0.5 * f64::from(view.size()[1]) - (f64::from(y) + 0.5 + dy),
    ];
    forward + right * (right_of * step) + up * (above * step)
}

/// Returns ray directions at a pixel's centre and beyond its sides and corners.
fn directions(view: &View, pixel: [u32; 2]) -> [DVec3; 9] {
    const FAR: f64 = 0.7;
    let offs = [
        [0.0, 0.0],
        [-FAR, 0.0],
        [FAR, 0.0],
        [0.0, -FAR],
        [0.0, FAR],
        [-FAR, -FAR],
        [FAR, -FAR],
        [-FAR, FAR],
        [FAR, FAR],
    ];
    offs.map(|off| direction(view, pixel, off))
}

/// Compares the pictures of a scene with traced light, within 2/255, where no edge is near. Returns the numbers of pixels
/// compared, lit, and lit in rooms without a lamp.
fn compare(name: &str, scene: &Scene, cameras: &[Camera], most: usize, shadows: bool) -> [usize; 3] {
    let dark = in_the_dark(scene);
    let mut lamplight = Lamplight::new(scene, most);
    if shadows {
        lamplight = lamplight.with_shadows();
    }
    let [mut compared, mut lit, mut through] = [0; 3];
    for camera in cameras {
        let view = camera.view(SIZE).expect("a valid view");
        let [picture, unlit] = [scene, &dark].map(|scene| drawn(scene, &view, shadows).0);
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let mut seen = directions(&view, [x, y])
                    .into_iter()
                    .map(|direction| lamplight_along(scene, &lamplight, &view, direction));
                let Some((light, color, face)) = seen.next().flatten() else {
                    continue;
                };
                // Skip pixels on which another face is seen, or other light at an edge of light, which is soft.
                let agrees = |other: Option<Lit>| {
                    other.is_some_and(|(near, _, at)| at == face && near.distance(light) < 0.02)
                };
                if !seen.all(agrees) {
                    continue;
                }
                compared += 1;
                lit += usize::from(light.length() > 0.01);
                let home = scene.lights().iter().all(|lamp| lamp.sector.0 != face.0);
                through += usize::from(home && light.length() > 0.01);
                let [shown, before] = [&picture, &unlit].map(|image| image.get_pixel(x, y).0);
                for channel in 0..3 {
                    let expected =
                        encode(decode(before[channel]) + light[channel] * f64::from(color[channel]));
                    let off = (f64::from(shown[channel]) - expected).abs();
                    assert!(
                        off <= 2.0,
                        "@{name} from `{}` at ({x}, {y}): {shown:?}, {expected} in channel {channel}; {face:?}",
                        camera.name
                    );
                }
            }
        }
    }
    [compared, lit, through]
}

#[test]
fn lamplight_falls_through_doors_mirrors_and_teleports_as_far_as_they_let_it() {
    let mut sum = [[0; 3]; 2];
    for name in ["mirror", "mirrors", "nested", "teleport"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        for (shadows, sum) in [false, true].into_iter().zip(&mut sum) {
            let most = if name == "mirrors" { 5 } else { 4 };
            // Every face is tested for each shadow.
            let cameras = if shadows {
                &cameras[..2.min(cameras.len())]
            } else {
                &cameras[..]
            };
            let counts = compare(name, &scene, cameras, most, shadows);
            (0..3).for_each(|i| sum[i] += counts[i]);
        }
    }
    let [[compared, lit, through], [_, in_sight, _]] = sum;
    assert!(compared > 50_000 && lit > 20_000, "{compared}, {lit} lit");
    assert!(through > 500, "{through} in rooms without a lamp");
    assert!(
        in_sight > 10_000 && in_sight + 1000 < lit,
        "{in_sight} of {lit} in sight of a lamp"
    );
}

fn has_flat_items(scene: &Scene, sector: SectorId) -> bool {
    let geometry = scene.geometry(sector).expect("a geometry");
    let mut items = geometry.items().iter();
    items.any(|item| item.transform().inverse().is_none())
}

#[test]
fn suns_and_lamps_cast_the_shadows_that_are_traced() {
    let mut random = Random::new(64);
    let mut sum = [0; 3];
    for seed in 0..40 {
        let BuiltIn { scene, cameras } = random_scene(seed);
        let scene = with_random_lights(&scene, &mut random);
        // Rays go through items that a scale of 0 flattens.
        if scene.sectors().any(|id| has_flat_items(&scene, id)) {
            continue;
        }
        compare(&format!("{seed} plain"), &scene, &cameras[..1], 4, false);
        let counts = compare(&format!("{seed}"), &scene, &cameras[..1], 4, true);
        (0..3).for_each(|i| sum[i] += counts[i]);
    }
    assert!(sum[0] > 20_000 && sum[1] > 3000, "{sum:?}");
}

#[test]
fn an_edge_of_light_is_as_bright_as_the_part_of_each_pixel_within_it() {
    const ACROSS: u32 = 6;
    let (mut pixels, mut off) = (0, 0.0);
    for name in ["mirror", "nested", "teleport"] {
        let BuiltIn { scene, cameras } = built_in(name).expect("a built-in scene");
        let dark = in_the_dark(&scene);
        let lamplight = Lamplight::new(&scene, 4);
        for camera in &cameras {
            let view = camera.view(SIZE).expect("a valid view");
            let [picture, unlit] = [&scene, &dark].map(|scene| drawn(scene, &view, false).0);
            for y in 0..SIZE[1] {
                for x in 0..SIZE[0] {
                    let light = |direction| lamplight_along(&scene, &lamplight, &view, direction);
                    let near = directions(&view, [x, y])
                        .map(|direction| light(direction).map_or(0.0, |lit| lit.0.y));
                    if near[1..].iter().all(|other| (other - near[0]).abs() < 0.02) {
                        continue;
                    }
                    let within = |i: u32| (f64::from(i) + 0.5) / f64::from(ACROSS) - 0.5;
                    let seen: Option<Vec<Lit>> = (0..ACROSS * ACROSS)
                        .map(|i| light(direction(&view, [x, y], [within(i % ACROSS), within(i / ACROSS)])))
                        .collect();
                    // Pixels of one face that are partly lit, and not overexposed.
                    let Some(seen) = seen.filter(|seen| seen.iter().all(|other| other.2 == seen[0].2)) else {
                        continue;
                    };
                    let sum = |lit: &Lit| lit.0.element_sum();
                    let [darkest, brightest] = [f64::min, f64::max]
                        .map(|most| seen.iter().map(sum).reduce(most).expect("many samples"));
                    if darkest > 0.5 * brightest || !(0.1..=1.5).contains(&brightest) {
                        continue;
                    }
                    let mean = seen.iter().map(|lit| lit.0).sum::<DVec3>() / f64::from(ACROSS * ACROSS);
                    let [shown, before] = [&picture, &unlit].map(|image| decode(image.get_pixel(x, y).0[1]));
                    let color = f64::from(seen[0].1[1]);
                    pixels += 1;
                    off += (shown - before - mean.y * color).abs() / ((brightest - darkest) / 3.0 * color);
                }
            }
        }
    }
    assert!(pixels > 300, "{pixels} pixels at edges of light");
    // A sharp edge is off by a quarter on average.
    let off = off / f64::from(pixels);
    assert!(off < 0.08, "light at edges is off by {off:.3} of its step");
}

#[test]
fn a_lamp_that_shines_on_nothing_seen_is_left_out() {
    let BuiltIn { scene, cameras } = built_in("teleport").expect("a built-in scene");
    let shining = |camera: &Camera| drawn(&scene, &camera.view(SIZE).expect("a valid view"), false).1;
    let named = |name: &str| {
        cameras
            .iter()
            .find(|camera| camera.name == name)
            .expect("a camera")
    };
    assert_eq!(shining(named("before the gate")), 1);
    let mut far = scene.clone();
    let lamp = scene.lights()[0];
    let moved = Light {
        position: [3.0, 0.5, 3.0],
        range: 0.2,
        ..lamp
    };
    far.set_light(LightId(0), moved).expect("a valid light");
    let view = named("in the yard").view(SIZE).expect("a valid view");
    assert_eq!(drawn(&far, &view, false).1, 0);
}
