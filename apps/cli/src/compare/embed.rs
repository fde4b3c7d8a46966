//! Embeds pictures in the page: downscaled, as data URIs.

use anyhow::{Context, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use enfilade_draw::RgbImage;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

/// Maximum number of pixels along the longer side.
const MAX_SIDE: u32 = 640;

/// Returns the number of samples along x, and along y, per pixel of the page.
pub(super) fn step(size: [u32; 2]) -> u32 {
    size[0].max(size[1]).div_ceil(MAX_SIDE).max(1)
}

/// Downscales a picture: each pixel is the mean of `step` × `step` samples, of fewer at the right and bottom edges.
pub(super) fn shrunk(image: &RgbImage, step: u32) -> RgbImage {
    let [width, height] = [image.width(), image.height()];
    RgbImage::from_fn(width.div_ceil(step), height.div_ceil(step), |x, y| {
        let across = x * step..((x + 1) * step).min(width);
        let down = y * step..((y + 1) * step).min(height);
        let count = (across.len() * down.len()) as u32;
        let mut sums = [0_u32; 3];
        for (x, y) in down.flat_map(|y| across.clone().map(move |x| (x, y))) {
            for (sum, &value) in sums.iter_mut().zip(&image.get_pixel(x, y).0) {
                *sum += u32::from(value);
            }
        }
        image::Rgb(sums.map(|sum| ((sum + count / 2) / count) as u8))
    })
}

/// Encodes a picture as `data:image/png;base64,…`.
pub(super) fn data_uri(image: &RgbImage) -> Result<String> {
    let mut png = Vec::new();
    // A page has dozens of pictures, so the best compression pays.
    image
        .write_with_encoder(PngEncoder::new_with_quality(
            &mut png,
            CompressionType::Best,
            FilterType::Adaptive,
        ))
        .context("cannot encode a picture as PNG")?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn a_picture_is_at_most_so_long_and_keeps_its_light() {
        assert_eq!(
            [[1, 1], [640, 360], [641, 2], [1280, 720], [720, 1281]].map(step),
            [1, 1, 2, 2, 3]
        );
        let image = RgbImage::from_fn(5, 3, |x, _| Rgb([40 * x as u8, 7, 0]));
        let small = shrunk(&image, 2);
        assert_eq!(small.dimensions(), (3, 2));
        assert_eq!(small.get_pixel(0, 0).0, [20, 7, 0]);
        assert_eq!(small.get_pixel(2, 1).0, [160, 7, 0], "the corner has one sample");
        assert_eq!(shrunk(&image, 1), image);
    }

    #[test]
    fn a_picture_is_a_png_in_the_page() {
        let uri = data_uri(&RgbImage::new(2, 2)).expect("it is encoded");
        assert!(uri.starts_with("data:image/png;base64,iVBORw0KGgo"), "{uri}");
    }
}
