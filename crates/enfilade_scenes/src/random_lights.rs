//! Lights at random places of a scene.

use crate::Random;
use enfilade::{Light, LightShape, Scene, SectorId};

/// Returns the scene with a sun, a spot light and a point light more, in sectors that are not empty.
///
/// # Panics
/// Never: the lights are valid.
pub fn with_random_lights(scene: &Scene, random: &mut Random) -> Scene {
    let mut scene = scene.clone();
    let sectors: Vec<SectorId> = scene.sectors().collect();
    for number in 0..3 {
        let sector = sectors[random.below(sectors.len())];
        let bounds = scene.bounds(sector);
        if bounds.is_empty() {
            continue;
        }
        let direction = random.point(1.0);
        let shape = match number {
            0 => LightShape::Sun { direction },
            1 => LightShape::Spot {
                direction,
                inner: 0.2,
                outer: random.between(0.3, 1.3),
            },
            _ => LightShape::Point,
        };
        let position = random.point_in(&bounds);
        let color = if number == 0 { [0.4; 3] } else { [1.0; 3] };
        let range = bounds.longest_side().max(1.0) * random.between(0.5, 1.5);
        let light = Light {
            shape,
            ..Light::point(sector, position, color, range)
        };
        scene.add_light(light).expect("a valid light");
    }
    scene
}
