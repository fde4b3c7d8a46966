//! Lamps and suns: where they shine, and how far.

use super::{Scene, SceneError, SectorId};
use crate::geom::{Aabb, is_in_range};
use crate::query::{LightReach, Location};
use crate::viewer::Limits;
use glam::DVec3;

/// A light of a scene, by its place in [`Scene::lights`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// A lamp or a sun. Its light falls through openings as far as they let it; things cast no shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The sector that it stands in. A sun stands outside, and lights all of this one.
    pub sector: SectorId,
    /// Where, in the sector's own space; of no account for a sun.
    pub position: [f32; 3],
    /// Red, green and blue, linear: what a white surface that faces it sends back at a distance of 1, or at any of a sun.
    pub color: [f32; 3],
    /// How far it shines, in units of that space: above 0, and infinite for light that only grows weak.
    pub range: f32,
    /// Where it shines to.
    pub shape: LightShape,
}

/// Where a light shines to. Directions are in the space of its sector, of any length but 0.
///
/// Source: The Khronos Group, KHR_lights_punctual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LightShape {
    /// In all directions from a point.
    #[default]
    Point,
    /// Into a cone from a point.
    Spot {
        /// The way its middle goes.
        direction: [f32; 3],
        /// Up to this angle from the middle it shines in full, in radians: at least 0.
        inner: f32,
        /// From this angle on not at all, in radians: above `inner`, at most a half π.
        outer: f32,
    },
    /// In parallel from infinitely far away.
    Sun {
        /// The way that its light goes.
        direction: [f32; 3],
    },
}

/// How far away a sun stands, in sizes of the sector that it lights: so far that its light is parallel to a tenth of a
/// minute of arc.
const SUN_AWAY: f64 = 3e4;

impl Light {
    /// A lamp that shines in all directions.
    pub const fn point(sector: SectorId, position: [f32; 3], color: [f32; 3], range: f32) -> Light {
        Light {
            sector,
            position,
            color,
            range,
            shape: LightShape::Point,
        }
    }

    /// What is left of its light at a distance in the space that it stands in: 1 at a distance of 1 were it not for the
    /// range, at which nothing is left. Very near it grows no more. Of a sun, 1 everywhere.
    ///
    /// Source: The Khronos Group, KHR_lights_punctual, range property.
    pub fn falloff(&self, distance: f64) -> f64 {
        const NEAREST: f64 = 0.01;
        if matches!(self.shape, LightShape::Sun { .. }) {
            return 1.0;
        }
        let range = f64::from(self.range);
        let window = 1.0 - (distance / range).powi(4);
        window.max(0.0) / distance.max(NEAREST * range.min(1.0)).powi(2)
    }

    /// What of its light goes into a direction whose angle to the middle of its cone has this cosine: 1 inside, 0
    /// outside, in between as the specification says. 1 for all but spots.
    ///
    /// Source: The Khronos Group, KHR_lights_punctual, inner and outer cone angles.
    pub fn cone(&self, cosine: f64) -> f64 {
        let LightShape::Spot { inner, outer, .. } = self.shape else {
            return 1.0;
        };
        let [inner, outer] = [inner, outer].map(|angle| f64::from(angle).cos());
        let part = ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0);
        part * part
    }

    /// The direction that the middle of its light goes, if it has one.
    pub fn direction(&self) -> Option<[f32; 3]> {
        match self.shape {
            LightShape::Point => None,
            LightShape::Spot { direction, .. } | LightShape::Sun { direction } => Some(direction),
        }
    }

    /// Is every number finite, but for the range, which is above 0, and are directions and angles as they must be?
    pub(super) fn is_sound(&self) -> bool {
        let numbers = self.position.iter().chain(&self.color);
        let directed = self.direction().is_none_or(|direction| {
            direction.iter().all(|value| value.is_finite()) && direction.iter().any(|&value| value != 0.0)
        });
        let cone = match self.shape {
            LightShape::Spot { inner, outer, .. } => {
                inner >= 0.0 && inner < outer && outer <= std::f32::consts::FRAC_PI_2
            }
            _ => true,
        };
        numbers.into_iter().all(|value| value.is_finite())
            && self.position.into_iter().all(is_in_range)
            && self.range > 0.0
            && directed
            && cone
    }

    /// Where its light comes from: of a sun a place far outside.
    fn source(&self, held: &Aabb) -> Location {
        let position = match self.shape {
            LightShape::Sun { direction } if !held.is_empty() => {
                let onwards = DVec3::from(direction.map(f64::from)).normalize_or(DVec3::NEG_Y);
                let [middle, size] = [held.center(), held.size()].map(|v| DVec3::from(v.map(f64::from)));
                (middle - onwards * SUN_AWAY * size.length().max(1.0))
                    .as_vec3()
                    .into()
            }
            _ => self.position,
        };
        Location {
            sector: self.sector,
            position,
        }
    }
}

impl Scene {
    /// The lights, by [`LightId`].
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Hangs up one lamp more.
    ///
    /// # Errors
    /// [`SceneError::BadLight`].
    pub fn add_light(&mut self, light: Light) -> Result<LightId, SceneError> {
        let id = LightId(self.lights.len() as u32);
        self.check_light(id, &light)?;
        self.lights.push(light);
        Ok(id)
    }

    /// Changes a light, in O(1).
    ///
    /// # Errors
    /// [`SceneError::BadLight`], and then it stays as it was.
    pub fn set_light(&mut self, id: LightId, light: Light) -> Result<(), SceneError> {
        self.check_light(id, &light)?;
        self.lights[id.0 as usize] = light;
        Ok(())
    }

    fn check_light(&self, id: LightId, light: &Light) -> Result<(), SceneError> {
        if light.is_sound() && (light.sector.0 as usize) < self.sectors.len() {
            Ok(())
        } else {
            Err(SceneError::BadLight(id.0 as usize))
        }
    }

    /// The sectors that a light shines into, its own first ([`Scene::reach`]). [`LightReach::origin`] is where its light
    /// comes from; of a sun, a place far outside.
    pub fn light_reach(&self, id: LightId, limits: &Limits) -> Vec<LightReach> {
        let light = &self.lights[id.0 as usize];
        let held = self.sector(light.sector).bounds();
        let range = match light.shape {
            LightShape::Sun { .. } => f32::INFINITY,
            _ => light.range,
        };
        self.reach(light.source(&held), range, limits)
    }
}
