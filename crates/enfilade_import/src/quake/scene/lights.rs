//! Lights of a map: the light entities from which compilers compute lightmaps and vertex colors.
//!
//! A light of 300 at its full intensity gives a white surface a radiance of 1. Quake's lights fall off linearly and end
//! at a distance of as many units as their value; here, they match at half that distance, and end at the same distance.
//! Quake 3's lights fall off with the square of the distance. Nothing casts shadows here, so light passes through
//! walls.
//! Source: the light compilers of both games and their successors (ericw-tools, q3map2).

use super::axes::{direction, turned};
use super::entities::Entity;
use enfilade::{Light, LightShape, SectorId};
use std::collections::HashMap;

/// Default value of a light.
const USUAL: f32 = 300.0;
/// Distance at which a light with linear or inverse-square falloff has its nominal intensity, in units.
const AS_IT_SAYS: f32 = 128.0;
/// Intensity of a Quake 3 light of value 1 at distance 1.
const PHOTONS: f32 = 7500.0;
/// Default full angle of a spotlight, in degrees.
const CONE: f32 = 40.0;

/// Returns the valid lights and suns of a map.
pub(super) fn lights(entities: &[Entity], is_quake3: bool) -> Vec<Light> {
    let mut named: HashMap<&str, &Entity> = HashMap::new();
    for entity in entities.iter().rev() {
        named.insert(entity.get("targetname"), entity);
    }
    named.remove("");
    let lamps = entities
        .iter()
        .filter(|entity| entity.class().starts_with("light"));
    let lamps = lamps.filter_map(|entity| lamp(entity, &named, is_quake3));
    let suns = entities.first().into_iter().flat_map(suns);
    lamps.chain(suns).filter(is_light).collect()
}

/// Returns `true` if the numbers of a light are finite and it emits anything.
fn is_light(light: &Light) -> bool {
    let numbers = light.color.iter().chain(&light.position);
    let mut numbers = numbers.chain([&light.range]);
    numbers.all(|value| value.is_finite()) && light.range > 0.0 && light.color.iter().any(|&part| part > 0.0)
}

fn lamp(entity: &Entity, named: &HashMap<&str, &Entity>, is_quake3: bool) -> Option<Light> {
    let strength = entity.number_of_any(&["light", "_light"]).unwrap_or(USUAL);
    // Some maps use negative lights, which subtract; they are not supported.
    let strength = Some(strength).filter(|&strength| strength > 0.0)?;
    let origin = entity.three("origin")?;
    let [bright, range] = if is_quake3 {
        [PHOTONS * strength, (PHOTONS * strength).sqrt()]
    } else {
        let sooner = entity.number("wait").filter(|&wait| wait > 0.0).unwrap_or(1.0);
        let square = AS_IT_SAYS * AS_IT_SAYS * strength;
        let [bright, range] = match entity.number("delay").unwrap_or(0.0) as i32 {
            0 => [strength.powi(3) / 7.5, strength],
            _ => [square, square.sqrt()],
        };
        [bright / (sooner * sooner), range / sooner]
    };
    let color = color(entity, "_color")
        .or(color(entity, "color"))
        .unwrap_or([1.0; 3]);
    let target = named
        .get(entity.get("target"))
        .and_then(|target| target.three("origin"));
    let shape = spot(entity, origin, target, is_quake3).unwrap_or(LightShape::Point);
    Some(Light {
        sector: SectorId(0),
        position: turned(origin),
        color: color.map(|part| part * bright / USUAL),
        range,
        shape,
    })
}

/// Returns the shape of a spotlight: a light with a target or an angle.
fn spot(entity: &Entity, origin: [f32; 3], target: Option<[f32; 3]>, is_quake3: bool) -> Option<LightShape> {
    let (direction, outer) = match (target, entity.three("mangle")) {
        (Some(target), _) => {
            let way = [0, 1, 2].map(|axis| target[axis] - origin[axis]);
            let length = way.iter().map(|part| part * part).sum::<f32>().sqrt();
            // In Quake 3, the target is the centre of the lit circle.
            let radius = entity
                .number("radius")
                .filter(|&radius| radius > 0.0)
                .unwrap_or(64.0);
            let outer = is_quake3.then(|| (radius / length).atan());
            (turned(way), outer)
        }
        (None, Some([around, up, _])) if !is_quake3 => (direction(around, up), None),
        _ => return None,
    };
    let half = |degrees: f32| degrees.clamp(1.0, 179.0).to_radians() / 2.0;
    let cone = || {
        half(
            entity
                .number("angle")
                .filter(|&angle| angle > 0.0)
                .unwrap_or(CONE),
        )
    };
    let outer = outer.unwrap_or_else(cone);
    let soft = entity.number("_softangle").filter(|&angle| angle > 0.0);
    let inner = soft.map_or(0.85 * outer, half).min(0.95 * outer);
    let is_sound = direction.iter().all(|part| part.is_finite()) && direction != [0.0; 3] && inner > 0.0;
    is_sound.then_some(LightShape::Spot {
        direction,
        inner,
        outer,
    })
}

/// Returns the suns of the world entity. The sky light becomes two suns, straight down and straight up.
fn suns<'e>(world: &'e Entity) -> impl Iterator<Item = Light> + 'e {
    let sun = |strength: &[&str], tint: &str, direction: [f32; 3]| {
        let strength = world.number_of_any(strength).filter(|&strength| strength > 0.0)?;
        let color = color(world, tint).unwrap_or([1.0; 3]);
        Some(Light {
            sector: SectorId(0),
            position: [0.0; 3],
            color: color.map(|part| part * strength / USUAL),
            range: f32::MAX,
            shape: LightShape::Sun { direction },
        })
    };
    let aimed = world.three("_sun_mangle").or(world.three("_sunlight_mangle"));
    let onwards = aimed.map_or([0.0, -1.0, 0.0], |[around, up, _]| direction(around, up));
    [
        sun(&["_sunlight", "sunlight"], "_sunlight_color", onwards),
        sun(&["_sunlight2"], "_sunlight2_color", [0.0, -1.0, 0.0]),
        sun(&["_sunlight3"], "_sunlight3_color", [0.0, 1.0, 0.0]),
    ]
    .into_iter()
    .flatten()
}

/// Parses a color from 0 to 1, or from 0 to 255 if any component is above 1.
fn color(entity: &Entity, key: &str) -> Option<[f32; 3]> {
    let color = entity.three(key)?;
    let scale = if color.iter().any(|&part| part > 1.0) {
        255.0
    } else {
        1.0
    };
    Some(color.map(|part| (part / scale).max(0.0)))
}
