//! Decodes PNG and JPEG images into textures. An image that cannot be decoded becomes grey, with a warning that gives
//! the reason; it never makes a file unreadable.

use crate::budget::Budget;
use crate::spoken;
use crate::warning::{WarningKind, Warnings};
use enfilade::Texture;
use image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::Cursor;

/// Replaces an image that cannot be read.
const GREY: [u8; 4] = [128, 128, 128, 255];

/// An image of a file, still encoded.
pub(crate) struct Encoded<'b> {
    /// The encoded bytes, or the reason why they cannot be read.
    pub(crate) bytes: Result<Cow<'b, [u8]>, String>,
    /// Name of the texture.
    pub(crate) name: String,
    /// Name of the image in messages.
    pub(crate) place: String,
}

/// Decodes one image; returns a grey texture if the bytes are not a valid image, or one that would take too much
/// memory.
pub(crate) fn decode(
    bytes: &[u8],
    name: &str,
    place: &str,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Texture {
    let encoded = Encoded {
        bytes: Ok(Cow::Borrowed(bytes)),
        name: name.to_owned(),
        place: place.to_owned(),
    };
    let mut textures = decode_all(vec![encoded], budget, warnings);
    textures.pop().unwrap_or_else(|| grey(name))
}

/// Decodes images in parallel and returns their textures in the same order.
pub(crate) fn decode_all(images: Vec<Encoded>, budget: &mut Budget, warnings: &mut Warnings) -> Vec<Texture> {
    let mut batches = DecodeBatches::default();
    let admitted: Vec<Result<ImageHeader, String>> = images
        .iter()
        .map(|image| {
            let bytes = image.bytes.as_ref().map_err(String::clone)?;
            measure(bytes)
                .and_then(|measured| batches.admit(measured, budget))
                .map_err(|why| format!("{}: {why}", image.place))
        })
        .collect();
    let mut textures = Vec::with_capacity(images.len());
    let mut waiting = &images[..];
    let mut sizes = &admitted[..];
    while !waiting.is_empty() {
        let batch = batches.next(sizes);
        let (now, later) = waiting.split_at(batch);
        let (sizes_now, sizes_later) = sizes.split_at(batch);
        let decoded: Vec<Result<Texture, String>> = now.par_iter().zip(sizes_now).map(texture).collect();
        // In order, so that warnings name the same images whichever thread finishes first.
        for (decoded, image) in decoded.into_iter().zip(now) {
            textures.push(decoded.unwrap_or_else(|why| {
                warnings.name(WarningKind::BadImages, || why);
                grey(&image.name)
            }));
        }
        (waiting, sizes) = (later, sizes_later);
    }
    textures
}

/// Returns a texture of one grey texel.
pub(crate) fn grey(name: &str) -> Texture {
    Texture::new(name, [1, 1], vec![GREY]).expect("a 1x1 image is a valid texture")
}

/// Returns the same texture as a PNG file.
pub(crate) fn grey_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    image::RgbaImage::from_pixel(1, 1, image::Rgba(GREY))
        .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
        .expect("writing PNG to memory cannot fail");
    bytes
}

/// Decodes an image whose header was read and admitted.
fn texture((image, measured): (&Encoded, &Result<ImageHeader, String>)) -> Result<Texture, String> {
    let measured = measured.as_ref().map_err(String::clone)?;
    let bytes = image.bytes.as_ref().map_err(String::clone)?;
    texels(bytes, measured)
        .and_then(|texels| Texture::new(&image.name, measured.size, texels).map_err(|why| why.to_string()))
        .map_err(|why| format!("{}: {why}", image.place))
}

/// Size and memory needs of an image, from its header.
#[derive(Clone, Copy, Debug)]
struct ImageHeader {
    size: [u32; 2],
    /// Bytes of the decoded texture.
    kept: u64,
    /// Additional bytes while it is decoded.
    at_work: u64,
}

/// Maximum total memory for images that are decoded at the same time, unless a single image needs more. So memory use
/// does not grow with the number of threads.
const MAX_DECODE_BYTES: u64 = 128 << 20;

/// Reserves memory for images and groups them into batches that are decoded in parallel.
#[derive(Debug, Default)]
struct DecodeBatches {
    /// Bytes that all admitted images would need if they were decoded at the same time.
    all_at_work: u64,
    /// Bytes reserved for decoding.
    at_work: u64,
}

impl DecodeBatches {
    /// Reserves memory for an image, or returns why it is too large.
    fn admit(&mut self, image: ImageHeader, budget: &mut Budget) -> Result<ImageHeader, String> {
        let all_at_work = self.all_at_work.saturating_add(image.at_work);
        let at_work = all_at_work
            .min(MAX_DECODE_BYTES)
            .max(image.at_work)
            .max(self.at_work);
        let needs = image.kept.saturating_add(at_work - self.at_work);
        let [width, height] = image.size;
        budget.take(needs, String::new).map_err(|_| {
            format!(
                "{width}x{height} texels need {}, more than the memory limit allows",
                spoken::bytes(needs)
            )
        })?;
        (self.all_at_work, self.at_work) = (all_at_work, at_work);
        Ok(image)
    }

    /// Returns the size of the next batch, at least 1.
    fn next(&self, images: &[Result<ImageHeader, String>]) -> usize {
        let mut together = 0_u64;
        let too_many = images.iter().position(|image| {
            together += image.as_ref().map_or(0, |image| image.at_work);
            together > self.at_work
        });
        too_many.unwrap_or(images.len()).max(1)
    }
}

/// Reads an image's header.
fn measure(bytes: &[u8]) -> Result<ImageHeader, String> {
    /// Memory for what a header may contain, such as color profiles.
    const HEADER_BYTES: u64 = 16 << 20;
    let decoder = decoder(bytes, HEADER_BYTES)?;
    let (width, height) = decoder.dimensions();
    if width > Texture::MAX_TEXELS || height > Texture::MAX_TEXELS {
        return Err(format!(
            "{width}x{height} texels, more than {0}x{0}",
            Texture::MAX_TEXELS
        ));
    }
    // The decoders fill the missing part of a truncated JPEG without an error.
    if is_cut_jpeg(bytes) {
        return Err("it is truncated".to_owned());
    }
    let kept = 4 * u64::from(width) * u64::from(height);
    Ok(ImageHeader {
        size: [width, height],
        kept,
        // The encoded bytes, the decoder's output, the JPEG decoder's internal copies of it, and the RGBA texels.
        at_work: bytes.len() as u64 + 3 * decoder.total_bytes() + kept,
    })
}

/// Returns `true` if the bytes are a JPEG without an end marker.
///
/// Segments store their length, up to the start of scan. In the entropy-coded data after it, the end marker cannot
/// occur by coincidence.
/// Source: ITU-T T.81, section B.1.
fn is_cut_jpeg(bytes: &[u8]) -> bool {
    const START: u8 = 0xD8;
    const END: [u8; 2] = [0xFF, 0xD9];
    const TEXELS: u8 = 0xDA;
    if !bytes.starts_with(&[0xFF, START]) {
        return false;
    }
    let mut rest = &bytes[2..];
    while let [0xFF, mark, after @ ..] = rest {
        rest = match (*mark, after) {
            (TEXELS, _) => return !after.windows(2).any(|pair| pair == END),
            // Markers may be preceded by fill bytes 0xFF, and a few have no length field.
            (0xFF, _) => &rest[1..],
            (0x01 | 0xD0..=0xD7, _) => after,
            (_, [high, low, ..]) => {
                let length = usize::from(u16::from_be_bytes([*high, *low]));
                after.get(length..).unwrap_or(&[])
            }
            _ => &[],
        };
    }
    // The decoder reports all other errors.
    false
}

/// Decodes the texels, in rows from the top.
fn texels(bytes: &[u8], measured: &ImageHeader) -> Result<Vec<[u8; 4]>, String> {
    let decoder = decoder(bytes, measured.at_work + measured.kept)?;
    let image = image::DynamicImage::from_decoder(decoder).map_err(|why| why.to_string())?;
    let texels = image.into_rgba8();
    Ok(texels.pixels().map(|pixel| pixel.0).collect())
}

/// Returns a decoder for the bytes that allocates at most `most_bytes`.
fn decoder(bytes: &[u8], most_bytes: u64) -> Result<impl ImageDecoder + '_, String> {
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut reader = reader.map_err(|why| why.to_string())?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg)) {
        return Err("it is neither PNG nor JPEG".to_owned());
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(Texture::MAX_TEXELS);
    limits.max_image_height = Some(Texture::MAX_TEXELS);
    limits.max_alloc = Some(most_bytes);
    reader.limits(limits);
    reader.into_decoder().map_err(|why| why.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

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
            .expect("writing PNG to memory cannot fail");
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
        // The header's checksum must be correct, otherwise the decoder rejects the header.
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
