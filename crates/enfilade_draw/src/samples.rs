//! Four samples a pixel: four pictures, each of them of other places in the pixels, and their mean. A face is shaded once
//! for each pixel.

use crate::painter::Painter;
use crate::pixels::{self, Pixel, UNPAINTED};
use crate::stage::{Picture, Settings, Stage};
use enfilade::{Scene, View, Viewer};
use rayon::prelude::*;

/// What the samples of each pixel that were painted before have shown.
#[derive(Default)]
pub(crate) struct Others {
    /// How many samples were painted.
    number: usize,
    pixels: Vec<Known>,
}

/// Of one pixel: the names of faces, and what was shown of them before anything was painted over it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Known {
    names: [u64; 3],
    shown: [Pixel; 3],
}

impl Known {
    /// What was shown of a face.
    #[inline]
    pub(crate) fn of(&self, name: u64) -> Option<Pixel> {
        let place = self.names.iter().position(|&known| known == name)?;
        Some(self.shown[place]).filter(|&shown| shown != UNPAINTED)
    }

    /// Keeps what a sample, by its number, has shown.
    #[inline]
    pub(crate) fn keep(&mut self, number: usize, name: u64, shown: Pixel) {
        if let Some(slot) = self.names.get_mut(number) {
            *slot = name;
            self.shown[number] = shown;
        }
    }
}

impl Others {
    /// The number of the sample at hand, and what the others have shown, so many pixels at a time.
    pub(crate) fn bands(&mut self, pixels: usize) -> (usize, rayon::slice::ChunksMut<'_, Known>) {
        (self.number, self.pixels.par_chunks_mut(pixels))
    }
}

/// Paints the mean of four samples in each pixel.
pub(crate) fn draw(
    stage: &Stage,
    viewer: &mut Viewer,
    scene: &Scene,
    view: &View,
    settings: &Settings,
) -> Picture {
    let count = view.size[0] as usize * view.size[1] as usize;
    let mut sums = vec![[0_u32; 3]; count];
    let mut others = Others {
        number: 0,
        pixels: vec![Known::default(); count],
    };
    let mut told: Option<Picture> = None;
    for sample in View::FOUR_SAMPLES {
        let mut view = *view;
        view.sample = sample;
        let mut painter = Painter::on(stage, scene, &view, settings).beside(others);
        viewer.draw(scene, &view, &mut painter);
        let (pixels, left, picture) = painter.finish_samples();
        for (sum, pixel) in sums.iter_mut().zip(&pixels) {
            (0..3).for_each(|channel| sum[channel] += u32::from(pixel[channel]));
        }
        others = left;
        others.number += 1;
        let before = told.as_ref();
        told = Some(Picture {
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
        image: pixels::image(&pixels, view.size),
        ..told.expect("there are four samples")
    }
}
