//! Pixels during rendering: linear, 16 bits per channel, so that stacked glass layers lose no precision.

use crate::palette::encoded;
use crate::shade::Shade;
use crate::sky::Sky;
use glam::Vec3;
use image::RgbImage;
use rayon::prelude::*;

/// Displayed linear RGB, and 1 if painted.
pub(crate) type Pixel = [u16; 4];

pub(crate) const UNPAINTED: Pixel = [0; 4];

/// Converts a linear colour to a pixel.
#[inline]
pub(crate) fn pixel(color: Vec3) -> Pixel {
    let step = |value: f32| (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
    [step(color.x), step(color.y), step(color.z), 1]
}

/// Converts a pixel to a linear colour.
#[inline]
pub(crate) fn color([r, g, b, _]: Pixel) -> Vec3 {
    Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * (1.0 / 65535.0)
}

/// Blends a sample over a pixel; `behind` returns the sky's colour.
#[inline]
pub(crate) fn put(at: &mut Pixel, shade: Shade, behind: impl FnOnce() -> Vec3) {
    if shade.coverage >= 1.0 {
        *at = pixel(shade.color);
    } else if shade.coverage > 0.0 {
        let below = if *at == UNPAINTED { behind() } else { color(*at) };
        let shown = shade.color.clamp(Vec3::ZERO, Vec3::ONE);
        *at = pixel(below.lerp(shown, shade.coverage));
    }
}

/// Fills the unpainted pixels with sky.
pub(crate) fn fill(pixels: &mut [Pixel], size: [u32; 2], sky: &Sky) {
    let rows = pixels.par_chunks_mut(size[0] as usize).enumerate();
    rows.for_each(|(y, row)| {
        let mut x = 0;
        for run in row.chunk_by_mut(|&one, &next| (one == UNPAINTED) == (next == UNPAINTED)) {
            let length = run.len();
            if run[0] == UNPAINTED {
                sky.paint([x, y], run);
            }
            x += length;
        }
    });
}

/// Encodes pixels as an sRGB image.
pub(crate) fn image(pixels: &[Pixel], size: [u32; 2]) -> RgbImage {
    let mut image = RgbImage::new(size[0], size[1]);
    let width = size[0] as usize;
    let rows = image.par_chunks_mut(3 * width).zip(pixels.par_chunks(width));
    let encoded = encoded();
    rows.for_each(|(bytes, row)| {
        for (bytes, &[r, g, b, _]) in bytes.chunks_exact_mut(3).zip(row) {
            bytes[0] = encoded[usize::from(r)];
            bytes[1] = encoded[usize::from(g)];
            bytes[2] = encoded[usize::from(b)];
        }
    });
    image
}
