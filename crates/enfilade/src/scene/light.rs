//! Lamps: points that shine, and how far.

use super::{FragmentId, Scene, SceneError};
use crate::query::{Place, Reached};
use crate::viewer::Limits;

/// A light of a scene, by its place in [`Scene::lights`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LightId(pub u32);

/// A point that shines in all directions. It falls through openings as far as they let it; things cast no shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The fragment that it stands in.
    pub fragment: FragmentId,
    /// Where, in the fragment's own space.
    pub position: [f32; 3],
    /// Red, green and blue, linear: what a white surface that faces it sends back at a distance of 1.
    pub color: [f32; 3],
    /// How far it shines, in units of that space: above 0.
    pub range: f32,
}

impl Light {
    /// What is left of its light at a distance in the space that it stands in: 1 at a distance of 1 were it not for the
    /// range, at which nothing is left. Nearer than a hundredth of the range it grows no more.
    ///
    /// Source: The Khronos Group, KHR_lights_punctual, range property.
    pub fn falloff(&self, distance: f64) -> f64 {
        let range = f64::from(self.range);
        let window = 1.0 - (distance / range).powi(4);
        window.max(0.0) / distance.max(0.01 * range).powi(2)
    }

    /// Is every number finite, and the range above 0?
    pub(super) fn is_sound(&self) -> bool {
        let numbers = self.position.iter().chain(&self.color);
        numbers.chain([&self.range]).all(|value| value.is_finite()) && self.range > 0.0
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
        if light.is_sound() && (light.fragment.0 as usize) < self.fragments.len() {
            Ok(())
        } else {
            Err(SceneError::BadLight(id.0 as usize))
        }
    }

    /// The fragments that a light shines into, its own first ([`Scene::reach`]).
    pub fn light_reach(&self, id: LightId, limits: &Limits) -> Vec<Reached> {
        let light = &self.lights[id.0 as usize];
        let place = Place {
            fragment: light.fragment,
            position: light.position,
        };
        self.reach(place, light.range, limits)
    }
}
