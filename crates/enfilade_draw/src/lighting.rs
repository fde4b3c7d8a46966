//! Lights and ambient light of a passage as plain data, for custom renderers, such as one on a GPU.

use crate::light::{Daylight, Tone};
use crate::stage::{Exposure, Stage};
use enfilade::{LightId, Passage, Scene, Texture, Transform, View};

/// The light in a passage: ambient light, direct light, and tone mapping. From [`Stage::lighting`].
///
/// Positions are relative to the passage's eye ([`Passage::eye`]), positions and directions in the space of its sector.
/// Colours are linear red, green and blue.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PassageLighting {
    /// Ambient light.
    pub ambient: AmbientLight,
    /// Displayed value of one unit of a light.
    pub exposure: f32,
    /// Whether values above 0.6 are compressed to below 1 instead of clipped: v becomes
    /// 0.6 + 0.4 (1 − exp((0.6 − v) / 0.4)).
    pub compresses: bool,
    /// The lights that may reach what the passage shows; one that shines through several openings has an entry for each.
    pub lights: Vec<DirectLight>,
}

/// Ambient light of a sector, exposure applied: a sum of four parts, for a unit normal n that points towards the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct AmbientLight {
    /// Light from above, times ½ + ½ n.y.
    pub above: [f32; 3],
    /// Light from below, times ½ − ½ n.y.
    pub below: [f32; 3],
    /// Light of a sun without shadows, times n · `to_sun` where that is positive. Black in scenes with lights.
    pub sun: [f32; 3],
    /// Unit direction to that sun.
    pub to_sun: [f32; 3],
    /// Light from the camera, times |n · the direction towards it|.
    pub from_the_eye: f32,
}

impl AmbientLight {
    /// Returns the daylight of scenes without lights.
    pub fn day() -> AmbientLight {
        Daylight::day(1.0).plain()
    }
}

/// A light that may reach what a passage shows, without exposure.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct DirectLight {
    /// The light of the scene.
    pub light: LightId,
    /// Number among the entries of [`Scene::light_reach`] for this light.
    pub beam: usize,
    /// Maps the space of the passage's sector to that of the light's own.
    pub light_from_here: Transform,
    /// Whether it is a sun.
    pub is_sun: bool,
    /// Position of the lamp, or unit direction to the sun.
    pub at: [f32; 3],
    /// Light of a sun on a surface that faces it; of a lamp at distance 1.
    pub color: [f32; 3],
    /// Lengths in the light's own sector per length here, squared.
    pub per_square: f32,
    /// 1 / range², in the light's own sector; 0 for a sun.
    pub per_range_square: f32,
    /// Squared distance, in the light's own sector, below which the falloff is constant.
    pub nearest_square: f32,
    /// Of a spot: its unit direction, and a factor f and an offset o. With c the cosine of the angle off the direction,
    /// its light is multiplied by (c f + o)², with c f + o clamped to 0 to 1.
    pub cone: Option<([f32; 3], [f32; 2])>,
    /// Planes (n, d) of the openings that the light passes and of the edges of its beam: only points with n · p ≥ d are
    /// lit. First those that hold the light, whose shadow edges can be smoothed, then those of openings.
    pub planes: Vec<[f32; 4]>,
    /// Number of the planes that hold the light.
    pub edge_planes: usize,
    /// Of a sun behind openings, (n, d) of the last opening: n · p − d is the distance from it along the light.
    pub opening: Option<[f32; 4]>,
}

impl Stage {
    /// Returns the light in a passage of a look. `view` is that of the look.
    pub fn lighting(
        &self,
        scene: &Scene,
        view: &View,
        passage: &Passage,
        exposure: Exposure,
    ) -> PassageLighting {
        let tone = Tone::of(&self.lamps, scene.sector_of(view), exposure);
        let lights = self.lamps.near(passage).map(|(_, near)| near.plain());
        PassageLighting {
            ambient: Daylight::of(&self.lamps, passage.sector, exposure, &tone).plain(),
            exposure: tone.exposure,
            compresses: tone.soft,
            lights: lights.collect(),
        }
    }

    /// Returns the mip levels of a texture of the scene, from full size down, each as columns, rows and texels: red, green
    /// and blue in sRGB, and coverage. `None` if the scene did not have the texture when the stage was created. A texture
    /// without mipmaps has one level.
    pub fn mip_levels(&self, texture: &Texture) -> Option<impl Iterator<Item = ([u32; 2], &[[u8; 4]])>> {
        self.mips_of(texture).map(|mips| mips.levels())
    }
}
