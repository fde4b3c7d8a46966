//! The water of the palace's fountain, rebuilt for every moment.

use crate::shape::{Dress, ball, lathe, tube};
use enfilade::{Geometry, GeometryBuilder, ItemIndex, MaterialId, Transform};
use glam::{Vec3, vec3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Period of the animation of [`fountain`], in seconds.
pub const FOUNTAIN_SECONDS: f32 = 4.0;

/// The middle of the basin: x and z.
pub(crate) const MIDDLE: [f32; 2] = [-46.0, -51.5];
/// The surface of the water.
const LEVEL: f32 = 0.48;
pub(crate) const JETS: u32 = 12;
const DROPS: u32 = 7;
const SPLASHES: u32 = 4;

/// Materials of the palace.
const WATER: MaterialId = MaterialId(47);
const PORCELAIN: MaterialId = MaterialId(32);

/// Builds the geometry of the sector "Fountain" of the palace at a time in seconds; `still` is that of any time.
///
/// Item names and openings are always the same; only the water moves. The animation repeats after [`FOUNTAIN_SECONDS`].
pub fn fountain(still: &Geometry, seconds: f32) -> Geometry {
    let mut geometry = GeometryBuilder::new(still.materials());
    geometry.textures(still.textures());
    let meshes: Vec<_> = still
        .meshes()
        .iter()
        .map(|mesh| geometry.mesh(Arc::clone(mesh)))
        .collect();
    for (number, item) in (0..).zip(still.items()) {
        let name = still.name(ItemIndex(number));
        if !is_water(name) {
            geometry.item(name, meshes[item.mesh.0 as usize], item.transform());
        }
    }
    for opening in still.openings() {
        geometry.opening(&opening.name, opening.outline.clone());
    }
    water(
        &mut geometry,
        (f64::from(seconds) / f64::from(FOUNTAIN_SECONDS)).rem_euclid(1.0),
    );
    geometry.build().expect("water is made of sound things")
}

fn is_water(name: &str) -> bool {
    let name = name.strip_prefix("Fountain: ").unwrap_or_default();
    ["water", "jet ", "drop ", "splash "]
        .iter()
        .any(|kind| name.starts_with(kind))
}

/// Returns the origin of a jet.
pub(crate) fn rim(jet: u32) -> Vec3 {
    around(jet, 2.35, 0.74)
}

/// Returns a point around the basin's middle, in the direction of a jet.
fn around(jet: u32, out: f32, up: f32) -> Vec3 {
    let (sin, cos) = (TAU * (f64::from(jet) + 0.5) / f64::from(JETS)).sin_cos();
    vec3(MIDDLE[0] + out * cos as f32, up, MIDDLE[1] + out * sin as f32)
}

/// Builds the water at a phase of the loop, 0 to 1: its surface, the jets, drops along them, and splashes where they
/// fall. All rotations complete a whole number of turns.
pub(crate) fn water(geometry: &mut GeometryBuilder, part: f64) {
    let wave = |turns: f64| (TAU * turns).sin() as f32;
    let rings = (0..=14).map(|ring| {
        let out = 2.2 * (1.0 - ring as f32 / 14.0);
        let ripple = 0.018 * wave(f64::from(out) / 0.55 - 4.0 * part);
        [out, LEVEL + if ring == 0 { 0.0 } else { ripple }]
    });
    let surface = lathe(WATER, &rings.collect::<Vec<_>>(), 36).dressed(dress);
    let surface = geometry.mesh(surface);
    let [x, z] = MIDDLE;
    geometry.item("Fountain: water", surface, shift(x, 0.0, z));
    let drop = geometry.mesh(ball(PORCELAIN, 1.0, 4, 6).dressed(dress));
    for jet in 0..JETS {
        let high = 0.95 + 0.25 * wave(part * 2.0 + f64::from(jet) / 6.0);
        let [from, to] = [rim(jet), around(jet, 0.85, LEVEL)];
        let at = |along: f32| from.lerp(to, along) + Vec3::Y * (4.0 * high * along * (1.0 - along));
        let path: Vec<Vec3> = (0..=12).map(|i| at(i as f32 / 12.0)).collect();
        let stream = geometry.mesh(tube(WATER, &path, |along| 0.02 + 0.02 * along, 5).dressed(dress));
        geometry.item(&format!("Fountain: jet {}", jet + 1), stream, Transform::IDENTITY);
        for i in 0..DROPS {
            let along = (part * 3.0 + f64::from(i) / f64::from(DROPS) + 0.13 * f64::from(jet)).fract() as f32;
            let aside = vec3(wave(0.37 * f64::from(i)), 0.0, wave(0.61 * f64::from(i + jet)));
            let place = at(along) + aside * (0.01 + 0.05 * along);
            let name = format!("Fountain: drop {}", jet * DROPS + i + 1);
            geometry.item(
                &name,
                drop,
                shift(place.x, place.y, place.z) * scaled(0.014 + 0.004 * (i % 3) as f32),
            );
        }
        for i in 0..SPLASHES {
            let along =
                (part * 5.0 + f64::from(i) / f64::from(SPLASHES) + 0.29 * f64::from(jet)).fract() as f32;
            let away = vec3(wave(0.27 * f64::from(i)), 0.0, wave(0.27 * f64::from(i) + 0.25));
            let place = to + away * (0.3 * along) + Vec3::Y * (0.9 * along * (1.0 - along));
            let name = format!("Fountain: splash {}", jet * SPLASHES + i + 1);
            geometry.item(&name, drop, shift(place.x, place.y, place.z) * scaled(0.012));
        }
    }
}

fn shift(x: f32, y: f32, z: f32) -> Transform {
    Transform::translation([x, y, z])
}

fn scaled(factor: f32) -> Transform {
    Transform::scaling([factor; 3])
}

fn dress(material: MaterialId) -> Dress {
    if material == WATER {
        return Dress::Smooth;
    }
    Dress::Textured {
        per_metre: 1.0,
        grain: false,
        cloth: false,
    }
}
