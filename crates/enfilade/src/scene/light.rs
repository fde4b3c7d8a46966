//! Lights: point, spot and directional lights, and the sectors that they reach.

use super::{Scene, SceneError};
use crate::geom::is_in_range;
use crate::ids::{LightId, SectorId};

/// Point, spot or directional light in a sector. Its light passes open portals.
/// [`ShadowCasters`](crate::ShadowCasters) finds what casts shadows.
#[doc(alias = "lamp")]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Light {
    /// The sector of the light. A sun is outside it and lights all of it.
    pub sector: SectorId,
    /// Position in the space of the sector; ignored for a sun.
    pub position: [f32; 3],
    /// Linear RGB color. For a point or spot light, the radiance of a white surface that faces it at a distance of 1;
    /// for a sun, at any distance.
    pub color: [f32; 3],
    /// Range in units of the sector's space, above 0. Infinite for a light that is never cut off.
    pub range: f32,
    /// Type of the light, with its direction and angles.
    pub shape: LightShape,
}

/// Type of a [`Light`]. Directions are in the space of its sector, of any length but 0.
///
/// Source: The Khronos Group, KHR_lights_punctual.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LightShape {
    /// Point light: shines in all directions.
    #[default]
    Point,
    /// Spot light: shines into a cone.
    Spot {
        /// Axis of the cone, away from the light.
        direction: [f32; 3],
        /// Angle from the axis up to which the intensity is full, in radians, at least 0.
        inner: f32,
        /// Angle from the axis at which the intensity becomes 0, in radians, above `inner` and at most π/2.
        outer: f32,
    },
    /// Directional light: parallel rays from infinitely far away.
    Sun {
        /// Direction in which the light travels.
        direction: [f32; 3],
    },
}

impl Light {
    /// Returns a point light.
    pub const fn point(sector: SectorId, position: [f32; 3], color: [f32; 3], range: f32) -> Light {
        Light {
            sector,
            position,
            color,
            range,
            shape: LightShape::Point,
        }
    }

    /// Returns the attenuation at a distance, in units of the light's sector: 1 / distance², windowed so that it falls
    /// to 0 at the range. Constant very near the light. 1 for a sun.
    ///
    /// Source: The Khronos Group, KHR_lights_punctual, range property.
    #[doc(alias = "attenuation")]
    pub fn falloff(&self, distance: f64) -> f64 {
        const NEAREST: f64 = 0.01;
        if matches!(self.shape, LightShape::Sun { .. }) {
            return 1.0;
        }
        let range = f64::from(self.range);
        let window = 1.0 - (distance / range).powi(4);
        window.max(0.0) / distance.max(NEAREST * range.min(1.0)).powi(2)
    }

    /// Returns the angular attenuation for a direction, given the cosine of its angle to the axis of the cone: 1 inside
    /// the inner cone, 0 outside the outer cone, in between as in the specification. 1 for point lights and suns.
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

    /// Returns the direction of a spot light or sun; `None` for a point light.
    pub fn direction(&self) -> Option<[f32; 3]> {
        match self.shape {
            LightShape::Point => None,
            LightShape::Spot { direction, .. } | LightShape::Sun { direction } => Some(direction),
        }
    }

    /// Returns `true` if all numbers are finite (the range may be infinite), the range is above 0, the direction is
    /// nonzero and the angles are in range.
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
}

impl Scene {
    /// Returns all lights, indexed by [`LightId`].
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// Adds a light and returns its id.
    ///
    /// # Errors
    /// Returns [`SceneError::BadLight`] and adds nothing.
    pub fn add_light(&mut self, light: Light) -> Result<LightId, SceneError> {
        let id = LightId(self.lights.len() as u32);
        self.check_light(id, &light)?;
        self.lights.push(light);
        Ok(id)
    }

    /// Replaces a light, in O(1).
    ///
    /// # Errors
    /// Returns [`SceneError::BadLight`] and leaves the light unchanged.
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
}
