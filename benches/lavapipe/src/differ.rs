//! Compares pictures.

use crate::ours::Picture;
use anyhow::Result;
use enfilade_draw::RgbImage;
use std::path::Path;

/// Largest ignored difference of a channel, of 255: rounding error, because the two renderers share no arithmetic.
const TOLERANCE: u8 = 2;

/// Returns the part of all pixels that differ noticeably, 0 to 1.
pub(crate) fn differing(a: &Picture, b: &Picture) -> f64 {
    assert_eq!(a.len(), b.len(), "pictures of different sizes");
    let differs = |(a, b): &(&[u8], &[u8])| (0..3).any(|c| a[c].abs_diff(b[c]) > TOLERANCE);
    let count = a.chunks(3).zip(b.chunks(3)).filter(differs).count();
    count as f64 / (a.len() / 3) as f64
}

/// Writes a picture as PNG.
pub(crate) fn save(picture: &Picture, size: [u32; 2], file: &Path) -> Result<()> {
    let image = RgbImage::from_raw(size[0], size[1], picture.clone());
    let image = image.ok_or_else(|| anyhow::anyhow!("the picture has another size than the view"))?;
    Ok(image.save(file)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_rounding_does_is_no_difference_and_another_colour_is() {
        let picture = vec![100; 3 * 100];
        assert_eq!(differing(&picture, &vec![102; 300]), 0.0);
        let mut other = picture.clone();
        other[7] = 200;
        assert_eq!(differing(&picture, &other), 0.01);
    }
}
