//! Difference pictures: wrong samples in red over the reference in grey.

use enfilade_draw::RgbImage;
use image::Rgb;

const WRONG: [u8; 3] = [255, 36, 48];
const CONTESTED: [u8; 3] = [236, 178, 72];

/// Returns a picture in dark greys, on which marks stand out.
pub(super) fn dimmed(image: &RgbImage) -> RgbImage {
    let mut grey = image.clone();
    for Rgb(pixel) in grey.pixels_mut() {
        let [r, g, b] = pixel.map(u32::from);
        // Weights of ITU-R BT.709, in 256ths.
        let luma = (54 * r + 183 * g + 19 * b) / 256;
        *pixel = [(24 + luma * 45 / 100) as u8; 3];
    }
    grey
}

/// Marks contested samples faintly and wrong ones in red. Each pixel of the dimmed picture covers `step` × `step`
/// samples.
pub(super) fn marked(
    dimmed: &RgbImage,
    step: u32,
    contested: &[[u32; 2]],
    wrong: impl Iterator<Item = [u32; 2]>,
) -> RgbImage {
    let mut picture = dimmed.clone();
    for [x, y] in contested.iter().map(|sample| sample.map(|at| at / step)) {
        let grey = dimmed.get_pixel(x, y).0;
        picture.put_pixel(x, y, Rgb([0, 1, 2].map(|c| mixed(grey[c], CONTESTED[c]))));
    }
    // Enlarge the marks: one wrong sample among a million must be visible.
    let reach = u32::from(dimmed.width() >= 240);
    for [x, y] in wrong.map(|sample| sample.map(|at| at / step)) {
        for y in y.saturating_sub(reach)..=(y + reach).min(dimmed.height() - 1) {
            for x in x.saturating_sub(reach)..=(x + reach).min(dimmed.width() - 1) {
                picture.put_pixel(x, y, Rgb(WRONG));
            }
        }
    }
    picture
}

fn mixed(grey: u8, mark: u8) -> u8 {
    ((4 * u32::from(grey) + 6 * u32::from(mark)) / 10) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_wrong_sample_can_be_seen_and_covers_what_is_only_contested() {
        let grey = dimmed(&RgbImage::from_pixel(320, 180, Rgb([255; 3])));
        let picture = marked(&grey, 2, &[[100, 100], [11, 10]], [[10, 10]].into_iter());
        let red = picture.pixels().filter(|pixel| pixel.0 == WRONG).count();
        assert_eq!(red, 9);
        assert_eq!(picture.get_pixel(5, 5).0, WRONG);
        let [r, g, b] = picture.get_pixel(50, 50).0;
        assert!(r > g && g > b, "a tint of amber");
        assert_eq!(picture.get_pixel(0, 0), grey.get_pixel(0, 0));
    }
}
