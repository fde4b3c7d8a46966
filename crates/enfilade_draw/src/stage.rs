//! The renderer's per-scene state: mip chains and light reach, shared by all pictures.

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

/// A scene prepared for rendering: mip chains of its textures, and the sectors that its lights reach.
///
/// Create a new one after lights, portals or textures have changed. Edits of items do not affect it.
#[doc(alias = "renderer")]
pub struct Stage {
    pub(crate) lamps: Lamps,
    /// Keyed by the texture's address, because geometries share textures.
    mips: HashMap<usize, Mips>,
}

/// Options of [`Stage::draw`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Settings {
    /// Kind of picture.
    pub show: Show,
    /// Exposure of lights.
    pub exposure: Exposure,
    /// Samples per pixel: 1, or 4 ([`View::FOUR_SAMPLES`]) for antialiased edges. With 4, each face is shaded once per
    /// pixel, at the first sample it covers (multisampling), or at each sample with shadows or ambient occlusion. Applies to
    /// [`Show::Image`] only.
    pub samples: Samples,
    /// Whether lights cast hard shadows. Applies to [`Show::Image`] only. Items of custom sectors cast none.
    pub shadows: bool,
    /// Rays per pixel that measure how open a surface is to ambient light, at least one per sample; 0 for none. Applies to
    /// [`Show::Image`] only.
    #[doc(alias = "ambient occlusion")]
    pub ambient_occlusion: u32,
}

/// Number of samples per pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Samples {
    /// One sample at the pixel centre.
    #[default]
    One,
    /// Four samples off the centre ([`View::FOUR_SAMPLES`]).
    Four,
}

/// Exposure of lights. A scene without lights has daylight, the same with either variant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Displayed value of one unit of light; brighter values are clipped to white. Ambient light is at evening level.
    Fixed(f32),
    /// Automatic exposure for the sector of the camera, plus this many stops (factors of two), with tone mapping that
    /// compresses highlights.
    Eye(f32),
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            show: Show::Image,
            exposure: Exposure::Fixed(1.0),
            samples: Samples::One,
            shadows: false,
            ambient_occlusion: 0,
        }
    }
}

/// A rendered picture with statistics.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Picture {
    /// The pixels, sRGB.
    pub image: RgbImage,
    /// Number of the scene's lights that may reach a visible passage; the others cost nothing. Nonzero only for
    /// [`Show::Image`].
    pub lights_shining: usize,
    /// Number of shaded samples of opaque faces. Equals the number of visible samples if the method resolves all owners
    /// before it emits spans; otherwise it includes overdraw.
    pub shaded: u64,
}

impl Stage {
    /// Builds the mip chains of a scene's textures on all cores, and computes where its lights reach.
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

    /// Renders one view.
    pub fn draw(&self, viewer: &mut Viewer, scene: &Scene, view: &View, settings: &Settings) -> Picture {
        if settings.samples == Samples::Four && settings.show == Show::Image {
            return samples::draw(self, viewer, scene, view, settings);
        }
        let mut painter = self.painter(viewer, scene, view, settings);
        viewer.draw(scene, view, &mut painter);
        painter.finish()
    }

    /// Returns an empty picture. Looks first, if lights are to cast shadows.
    pub(crate) fn painter<'a>(
        &'a self,
        viewer: &mut Viewer,
        scene: &'a Scene,
        view: &View,
        settings: &Settings,
    ) -> Painter<'a> {
        let painter = Painter::on(self, scene, view, settings);
        if settings.shadows {
            painter.with_shadows(viewer.look(scene, view))
        } else {
            painter
        }
    }

    /// Returns the mip chain of a texture.
    pub(crate) fn mips(&self, geometry: &Geometry, texture: Option<TextureId>) -> Option<&Mips> {
        self.mips_of(geometry.textures().get(texture?.0 as usize)?)
    }

    pub(crate) fn mips_of(&self, texture: &Texture) -> Option<&Mips> {
        self.mips.get(&address(texture))
    }
}

fn address(texture: &Texture) -> usize {
    std::ptr::from_ref(texture).addr()
}
