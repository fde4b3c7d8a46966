//! The sectors that a light of the scene reaches.

use super::{LightReach, Location};
use crate::geom::Aabb;
use crate::ids::LightId;
use crate::scene::{Light, LightShape, Scene};
use crate::view::options::Limits;
use glam::DVec3;

/// Distance of a sun, in diagonals of the box of the sector that it lights: its rays deviate from parallel by at most a
/// tenth of an arc minute.
const SUN_AWAY: f64 = 3e4;

impl Scene {
    /// Returns the sectors that a light reaches, its own sector first ([`Scene::reach`]). [`LightReach::origin`] is the
    /// position of the light; for a sun, a point far outside of its sector. Ignores [`Light::range`] for a sun.
    #[doc(alias = "light propagation")]
    pub fn light_reach(&self, id: LightId, limits: &Limits) -> Vec<LightReach> {
        let light = &self.lights()[id.0 as usize];
        let held = self.sector(light.sector).bounds();
        let range = match light.shape {
            LightShape::Sun { .. } => f32::INFINITY,
            _ => light.range,
        };
        self.reach(source(light, &held), range, limits)
    }
}

/// Returns the origin of a light; for a sun, a point far outside of `held`, the bounds of its sector.
fn source(light: &Light, held: &Aabb) -> Location {
    let position = match light.shape {
        LightShape::Sun { direction } if !held.is_empty() => {
            let onwards = DVec3::from(direction.map(f64::from)).normalize_or(DVec3::NEG_Y);
            let [middle, size] = [held.center(), held.size()].map(|v| DVec3::from(v.map(f64::from)));
            (middle - onwards * SUN_AWAY * size.length().max(1.0))
                .as_vec3()
                .into()
        }
        _ => light.position,
    };
    Location {
        sector: light.sector,
        position,
    }
}
