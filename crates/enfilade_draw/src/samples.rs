//! Four samples per pixel: renders four pictures with different sample positions and averages them. Each face is shaded
//! once per pixel; with shadows or ambient occlusion at each sample, so that these are as smooth as edges.
//!
//! Each sample is a separate look with [`View::sample`] set, so no order, cover or method supports multisampling, and
//! every contract holds for each sample. The visible set for four samples is the union of those of four looks.

use crate::pixels::{self, Pixel, UNPAINTED};
use crate::stage::{Picture, Settings, Stage};
use enfilade::{Scene, View, Viewer};
use rayon::prelude::*;

/// Colours shaded for the previous samples of each pixel.
#[derive(Default)]
pub(crate) struct SampleCache {
    /// Number of samples rendered so far.
    number: usize,
    pixels: Vec<PixelCache>,
}

/// For each previous sample of one pixel: the hash of its face, and the colour before any blending.
#[derive(Clone, Copy, Default)]
pub(crate) struct PixelCache {
    names: [u64; 3],
    shown: [Pixel; 3],
}

impl PixelCache {
    /// Returns the colour of a face, if a previous sample has shaded it.
    #[inline]
    pub(crate) fn of(&self, name: u64) -> Option<Pixel> {
        let index = self.names.iter().position(|&cached| cached == name)?;
        Some(self.shown[index]).filter(|&shown| shown != UNPAINTED)
    }

    /// Stores the colour of sample `number`.
    #[inline]
    pub(crate) fn keep(&mut self, number: usize, name: u64, shown: Pixel) {
        if let Some(slot) = self.names.get_mut(number) {
            *slot = name;
            self.shown[number] = shown;
        }
    }
}

impl SampleCache {
    /// Returns the index of the current sample, and the cached pixels in chunks of `pixels`.
    pub(crate) fn bands(&mut self, pixels: usize) -> (usize, rayon::slice::ChunksMut<'_, PixelCache>) {
        (self.number, self.pixels.par_chunks_mut(pixels))
    }
}

/// Renders the mean of four samples per pixel.
pub(crate) fn draw(
    stage: &Stage,
    viewer: &mut Viewer,
    scene: &Scene,
    view: &View,
    settings: &Settings,
) -> Picture {
    let count = view.size()[0] as usize * view.size()[1] as usize;
    let mut sums = vec![[0_u32; 3]; count];
    let mut others = SampleCache {
        number: 0,
        pixels: vec![PixelCache::default(); count],
    };
    let mut total: Option<Picture> = None;
    for (number, sample) in View::FOUR_SAMPLES.into_iter().enumerate() {
        let view = view.at_sample(sample).expect("a position in the pixel");
        let mut painter = stage.painter(viewer, scene, &view, settings);
        if settings.shadows || settings.ambient_occlusion > 0 {
            painter = painter.with_part_of_rays(number, View::FOUR_SAMPLES.len());
        } else {
            painter = painter.beside(others);
        }
        viewer.draw(scene, &view, &mut painter);
        let (pixels, left, picture) = painter.finish_samples();
        for (sum, pixel) in sums.iter_mut().zip(&pixels) {
            (0..3).for_each(|channel| sum[channel] += u32::from(pixel[channel]));
        }
        others = left;
        others.number += 1;
        let before = total.as_ref();
        total = Some(Picture {
            shaded: picture.shaded + before.map_or(0, |before| before.shaded),
            lights_shining: picture
                .lights_shining
                .max(before.map_or(0, |before| before.lights_shining)),
            ..picture
        });
    }
    let mean = |sum: &[u32; 3]| {
        let [r, g, b] = sum.map(|sum| ((sum + 2) / 4) as u16);
        [r, g, b, 1]
    };
    let pixels: Vec<Pixel> = sums.iter().map(mean).collect();
    Picture {
        image: pixels::image(&pixels, view.size()),
        ..total.expect("four samples were rendered")
    }
}
