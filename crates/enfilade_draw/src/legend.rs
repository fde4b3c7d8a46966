//! Legends below diagnostic pictures: which colour means what.

use crate::palette::{distinct, dusk, encode, heat, rainbow};
use crate::show::Show;
use enfilade::{CoverShape, Scene, SectorId, VisibleSet};
use font8x8::UnicodeFonts;
use image::{Rgb, RgbImage};
use std::collections::BTreeSet;

/// The entries of a legend, each a swatch of colour and its meaning.
#[derive(Clone, Debug)]
pub struct Legend {
    entries: Vec<(Swatch, String)>,
}

#[derive(Clone, Copy, Debug)]
enum Swatch {
    Plain([f32; 3]),
    Ramp(fn(f32) -> [f32; 3]),
}

/// Pictures narrower than this have no room for a legend, in pixels.
const MIN_WIDTH: u32 = 320;
/// Sectors listed by name; the others are only counted.
const MAX_SECTORS: usize = 24;
/// Side of a glyph of the font, in pixels.
const GLYPH: u32 = 8;

impl Legend {
    /// Returns the legend of a picture of `set`; `None` for [`Show::Image`], which needs none.
    pub fn new(show: Show, scene: &Scene, set: &VisibleSet) -> Option<Legend> {
        let entry = |swatch, meaning: &str| (swatch, meaning.to_owned());
        let entries = match show {
            Show::Image => return None,
            Show::Overdraw => vec![entry(
                Swatch::Ramp(heat),
                "faces tested per sample: 0 to 16 or more",
            )],
            Show::Order => vec![entry(
                Swatch::Ramp(rainbow),
                "when a face was drawn: first to last",
            )],
            Show::Items => vec![entry(
                Swatch::Ramp(|part| distinct((part * 8.0) as u64)),
                "a colour per item",
            )],
            Show::Sectors => sectors(scene, set),
            Show::Cover => {
                let sectors = set.passages().iter().map(|passage| passage.sector);
                let shapes = sectors.filter_map(|id| scene.method(id)?.cover_shape());
                covers(&shapes.collect::<Vec<_>>())
            }
        };
        Some(Legend { entries })
    }

    /// Returns `picture` with the legend below it; as it is if it is less than 320 pixels wide.
    pub fn below(&self, picture: RgbImage) -> RgbImage {
        let width = picture.width();
        if width < MIN_WIDTH || self.entries.is_empty() {
            return picture;
        }
        let scale = (width / 960).max(1);
        let [line, gap] = [2 * GLYPH * scale, GLYPH * scale];
        let swatch = 5 * GLYPH * scale;
        let text = |meaning: &str| meaning.chars().count() as u32 * GLYPH * scale;
        let mut at = [gap, gap];
        let mut placed = Vec::new();
        for (color, meaning) in &self.entries {
            let needed = swatch + gap + text(meaning);
            if at[0] > gap && at[0] + needed + gap > width {
                at = [gap, at[1] + line];
            }
            placed.push((at, color, meaning));
            at[0] += needed + 2 * gap;
        }
        let height = picture.height();
        let mut image = RgbImage::from_pixel(width, height + at[1] + line, Rgb([24, 26, 30]));
        image::imageops::replace(&mut image, &picture, 0, 0);
        for ([x, y], color, meaning) in placed {
            let y = height + y;
            for column in 0..swatch {
                let color = match *color {
                    Swatch::Plain(color) => color,
                    Swatch::Ramp(ramp) => ramp(column as f32 / swatch as f32),
                };
                for row in 0..GLYPH * scale {
                    set_pixel(&mut image, [x + column, y + row], encode(color));
                }
            }
            write(&mut image, [x + swatch + gap, y], scale, meaning);
        }
        image
    }
}

/// One entry per visible sector, in the colour that [`Show::Sectors`] gives it.
fn sectors(scene: &Scene, set: &VisibleSet) -> Vec<(Swatch, String)> {
    let visible: BTreeSet<SectorId> = set.passages().iter().map(|passage| passage.sector).collect();
    let mut entries: Vec<_> = (visible.iter().take(MAX_SECTORS))
        .map(|&id| {
            let color = distinct(u64::from(id.0));
            (Swatch::Plain(color), scene.sector_name(id).to_owned())
        })
        .collect();
    if visible.len() > MAX_SECTORS {
        let more = format!("{} more sectors", visible.len() - MAX_SECTORS);
        entries.push((Swatch::Plain([0.0; 3]), more));
    }
    entries
}

/// The meanings of the colours of [`Show::Cover`], for the shapes that occur.
fn covers(shapes: &[CoverShape]) -> Vec<(Swatch, String)> {
    use crate::cover::{OPEN, REFERENCE, WORKING};
    let mut entries = Vec::new();
    let mut add = |shape, swatch, meaning: &str| {
        if shapes.contains(&shape) {
            entries.push((swatch, meaning.to_owned()));
        }
    };
    let each = Swatch::Ramp(|part| distinct((part * 8.0) as u64));
    add(
        CoverShape::Spans,
        each,
        "spans: a colour per face, dark at the start of a span",
    );
    add(CoverShape::Pyramid, each, "tiles that one face owns");
    add(CoverShape::Pyramid, Swatch::Ramp(dusk), "Hi-Z cells: far to near");
    add(CoverShape::Tiles, Swatch::Plain(REFERENCE), "reference layer");
    add(CoverShape::Tiles, Swatch::Plain(WORKING), "working layer");
    add(
        CoverShape::Tree,
        each,
        "leaves of the tree: a colour per occluder",
    );
    entries.push((Swatch::Plain(OPEN), "nothing occludes".to_owned()));
    entries
}

fn set_pixel(image: &mut RgbImage, [x, y]: [u32; 2], color: [u8; 3]) {
    if let Some(pixel) = image.get_pixel_mut_checked(x, y) {
        pixel.0 = color;
    }
}

/// Writes one line of text; glyphs that the font lacks become `?`.
fn write(image: &mut RgbImage, [left, top]: [u32; 2], scale: u32, text: &str) {
    for (number, letter) in (0..).zip(text.chars()) {
        let basic = font8x8::BASIC_FONTS
            .get(letter)
            .or_else(|| font8x8::LATIN_FONTS.get(letter));
        let Some(rows) = basic.or_else(|| font8x8::BASIC_FONTS.get('?')) else {
            continue;
        };
        for (y, row) in (0..GLYPH * scale).map(|y| (y, rows[(y / scale) as usize])) {
            for x in (0..GLYPH * scale).filter(|x| row >> (x / scale) & 1 == 1) {
                set_pixel(
                    image,
                    [left + number * GLYPH * scale + x, top + y],
                    [222, 224, 228],
                );
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_is_below_the_picture_and_wraps() {
        let entries = (0..40).map(|number| (Swatch::Plain([0.5; 3]), format!("sector {number}")));
        let legend = Legend {
            entries: entries.collect(),
        };
        let picture = RgbImage::from_pixel(400, 100, Rgb([1, 2, 3]));
        let with_legend = legend.below(picture.clone());
        assert_eq!(with_legend.width(), 400);
        assert!(with_legend.height() > 100 + 10 * 16, "{}", with_legend.height());
        assert!((0..100).all(|y| (0..400).all(|x| with_legend.get_pixel(x, y) == picture.get_pixel(x, y))));
        assert!((100..with_legend.height()).any(|y| with_legend.get_pixel(9, y).0 == encode([0.5; 3])));
        let small = RgbImage::new(80, 45);
        assert_eq!(legend.below(small.clone()), small);
    }
}
