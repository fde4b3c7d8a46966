//! What all pictures of a scene share: its textures ready to be looked up, and where its lights shine.

use crate::lamps::Lamps;
use crate::mips::Mips;
use crate::painter::Painter;
use crate::samples;
use crate::show::Show;
use enfilade::{Geometry, Scene, Texture, TextureId, View, Viewer};
use image::RgbImage;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// What all pictures of a scene share: its textures ready to be looked up, and where its lights shine.
///
/// Of a scene as it is: make it anew after lights, portals or textures have changed. Edits of items change nothing in it.
pub struct Stage {
    pub(crate) lamps: Lamps,
    /// By the texture's address: geometries share them.
    mips: HashMap<usize, Mips>,
}

/// How a picture is painted.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// What it shows.
    pub show: Show,
    /// How bright lights are shown.
    pub exposure: Exposure,
    /// Samples of each pixel: 1, or 4 ([`View::FOUR_SAMPLES`]), which makes edges smooth; then each face is shaded once for
    /// each pixel, where the first of its samples is. Only of [`Show::Image`].
    pub samples: Samples,
}

/// How many samples a pixel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Samples {
    /// One, in its middle.
    #[default]
    One,
    /// Four, off its middle.
    Four,
}

/// How bright lights are shown. Without lights there is daylight, the same in either case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// What one unit of a light's color becomes; what is brighter than white is cut off. Where no light is it is evening.
    Fixed(f32),
    /// As an eye sees it that has got used to the sector it stands in, brighter by so many stops; what is very bright
    /// grows pale.
    Eye(f32),
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            show: Show::Image,
            exposure: Exposure::Fixed(1.0),
            samples: Samples::One,
        }
    }
}

/// A picture, and what it took.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Picture {
    /// Its pixels.
    pub image: RgbImage,
    /// How many of the scene's lights shine on something that is seen; the others cost nothing. Only [`Show::Image`] has
    /// light.
    pub lights_shining: usize,
    /// How many samples of opaque faces were shaded. As many as are seen, where the method knows the owners before it paints.
    pub shaded: u64,
}

impl Stage {
    /// Makes a scene's textures ready, on all cores, and follows its lights.
    pub fn new(scene: &Scene) -> Stage {
        let geometries = || scene.sectors().filter_map(|id| scene.geometry(id));
        let mut unique: HashMap<usize, &Arc<Texture>> = HashMap::new();
        for texture in geometries().flat_map(|geometry| geometry.textures()) {
            unique.insert(address(texture), texture);
        }
        let unique: Vec<_> = unique.into_iter().collect();
        Stage {
            lamps: Lamps::of(scene),
            mips: unique
                .into_par_iter()
                .map(|(address, texture)| (address, Mips::new(texture)))
                .collect(),
        }
    }

    /// Paints what a view shows.
    pub fn draw(&self, viewer: &mut Viewer, scene: &Scene, view: &View, settings: &Settings) -> Picture {
        if settings.samples == Samples::Four && settings.show == Show::Image {
            return samples::draw(self, viewer, scene, view, settings);
        }
        let mut painter = Painter::on(self, scene, view, settings);
        viewer.draw(scene, view, &mut painter);
        painter.finish()
    }

    /// A texture ready to be looked up.
    pub(crate) fn mips(&self, geometry: &Geometry, texture: Option<TextureId>) -> Option<&Mips> {
        let texture = geometry.textures().get(texture?.0 as usize)?;
        self.mips.get(&address(texture))
    }
}

fn address(texture: &Arc<Texture>) -> usize {
    Arc::as_ptr(texture).addr()
}
