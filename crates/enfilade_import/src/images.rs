//! Images in files: PNG and JPEG to texels. A picture that cannot be had never keeps a scene from being opened: it is grey,
//! and a warning says why.

use crate::budget::Budget;
use crate::warning::{WarningKind, Warnings};
use enfilade::Texture;
use image::{ImageDecoder, ImageReader, Limits};
use std::io::Cursor;

/// What stands for an image that cannot be had.
const GREY: [u8; 4] = [128, 128, 128, 255];

/// The texture of an image's bytes; grey where they are no image or one that would take too much memory.
pub(crate) fn decode(
    bytes: &[u8],
    name: &str,
    place: &str,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Texture {
    match texels(bytes, place, budget) {
        Ok((size, texels)) => Texture::new(name, size, texels).unwrap_or_else(|_| grey(name)),
        Err(why) => {
            warnings.name(WarningKind::BadImages, || format!("{place}: {why}"));
            grey(name)
        }
    }
}

/// A texture of one grey texel.
pub(crate) fn grey(name: &str) -> Texture {
    Texture::new(name, [1, 1], vec![GREY]).expect("one texel")
}

/// Rows of texels from the top. Memory is set aside before anything is decoded.
fn texels(bytes: &[u8], place: &str, budget: &mut Budget) -> Result<([u32; 2], Vec<[u8; 4]>), String> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|why| why.to_string())?;
    if reader.format().is_none() {
        return Err("neither PNG nor JPEG".to_owned());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(Texture::MOST_TEXELS);
    limits.max_image_height = Some(Texture::MOST_TEXELS);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|why| why.to_string())?;
    let (width, height) = decoder.dimensions();
    if width > Texture::MOST_TEXELS || height > Texture::MOST_TEXELS {
        return Err(format!(
            "{width}x{height} texels, more than {0}x{0}",
            Texture::MOST_TEXELS
        ));
    }
    // Decoded as it stands, and as texels.
    let needs = decoder.total_bytes() + 4 * u64::from(width) * u64::from(height);
    budget
        .take(needs, || place.to_owned())
        .map_err(|_| format!("{width}x{height} texels need {needs} bytes, more than is allowed"))?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(2 * needs);
    decoder.set_limits(limits).map_err(|why| why.to_string())?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(|why| why.to_string())?;
    let texels = image.into_rgba8();
    Ok(([width, height], texels.pixels().map(|pixel| pixel.0).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::ImageFormat;

    fn decoded(bytes: &[u8]) -> (Texture, Vec<String>) {
        let mut warnings = Warnings::default();
        let texture = decode(bytes, "tile", "image 3", &mut Budget::new(1 << 20), &mut warnings);
        let texts = warnings.into_list().iter().map(ToString::to_string).collect();
        (texture, texts)
    }

    fn png(size: [u32; 2]) -> Vec<u8> {
        let mut bytes = Vec::new();
        image::RgbaImage::from_fn(size[0], size[1], |x, y| image::Rgba([x as u8, y as u8, 7, 200]))
            .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
            .expect("into memory");
        bytes
    }

    #[test]
    fn texels_come_in_rows_from_the_top() {
        let (texture, warnings) = decoded(&png([3, 2]));
        assert_eq!((texture.size(), warnings.len()), ([3, 2], 0));
        assert_eq!(texture.texels()[1], [1, 0, 7, 200]);
        assert_eq!(texture.texels()[3], [0, 1, 7, 200]);
    }

    #[test]
    fn what_is_no_image_or_is_cut_short_is_grey_and_named() {
        let whole = png([3, 2]);
        for bytes in [
            &b"this is no image"[..],
            &[],
            &whole[..whole.len() / 2],
            &whole[..20],
        ] {
            let (texture, warnings) = decoded(bytes);
            assert_eq!(texture.texels(), [GREY]);
            assert!(warnings[0].contains("image 3: "), "{warnings:?}");
        }
    }

    #[test]
    fn an_image_that_claims_ten_billion_texels_is_refused_before_memory_is_taken() {
        let mut bytes = png([3, 2]);
        for side in [16..20, 20..24] {
            bytes[side].copy_from_slice(&100_000_u32.to_be_bytes());
        }
        // The header's checksum must be right, or it is not even believed.
        let sum = crc(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&sum.to_be_bytes());
        let (texture, warnings) = decoded(&bytes);
        assert_eq!(texture.texels(), [GREY]);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        let (_, large) = decoded(&png([600, 600]));
        assert!(large[0].contains("600x600 texels need"), "{large:?}");
    }

    fn crc(bytes: &[u8]) -> u32 {
        let step = |sum: u32, byte: &u8| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
                (sum >> 1) ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
            })
        };
        !bytes.iter().fold(!0, step)
    }
}
