//! A sun for scenes without lights.

use enfilade::{Light, LightShape, Scene, SectorId};

/// Returns a scene without lights with a sun that casts shadows: in the sectors that are open above, or else in the largest
/// one. Returns other scenes as they are.
pub fn with_sun(scene: &Scene) -> Scene {
    const DOWN: [f32; 3] = [-0.424, -0.755, -0.5];
    const COLOR: [f32; 3] = [1.0, 0.95, 0.85];
    let mut scene = scene.clone();
    if !scene.lights().is_empty() {
        return scene;
    }
    let mut sunny: Vec<SectorId> = scene.sectors().filter(|&id| scene.is_open_above(id)).collect();
    if sunny.is_empty() {
        let size = |id: &SectorId| scene.bounds(*id).volume();
        sunny.extend(scene.sectors().max_by(|a, b| size(a).total_cmp(&size(b))));
    }
    for sector in sunny {
        let shape = LightShape::Sun { direction: DOWN };
        let sun = Light {
            shape,
            ..Light::point(sector, [0.0; 3], COLOR, f32::INFINITY)
        };
        // A sun is valid in every sector.
        let _ = scene.add_light(sun);
    }
    scene
}
