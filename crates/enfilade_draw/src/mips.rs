//! Mip chains and texture filtering.
//!
//! Source: Williams, Pyramidal parametrics, 1983. Cost: O(texels) to build; a lookup reads at most 8 texels.

use crate::palette::{decoded, encode};
use enfilade::{Filter, Texture, Wrap};
use glam::Vec4;
use std::sync::Arc;

/// A texture with its mip levels.
pub(crate) struct Mips {
    texture: Arc<Texture>,
    /// Mip levels 1 and up.
    smaller: Vec<Level>,
    /// Linear value of each sRGB byte.
    decoded: &'static [f32; 256],
}

struct Level {
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
}

/// A view of one mip level.
#[derive(Clone, Copy)]
struct Image<'a> {
    size: [u32; 2],
    texels: &'a [[u8; 4]],
}

impl Mips {
    pub(crate) fn new(texture: &Arc<Texture>) -> Mips {
        let mut smaller: Vec<Level> = Vec::new();
        let first = Image {
            size: texture.size(),
            texels: texture.texels(),
        };
        // Only textures with mipmapped minification need the levels.
        if texture.minify.levels.is_some() {
            while let Some(next) = half(smaller.last().map_or(first, Level::image)) {
                smaller.push(next);
            }
        }
        Mips {
            texture: Arc::clone(texture),
            smaller,
            decoded: decoded(),
        }
    }

    /// Returns the columns and rows of mip level 0.
    pub(crate) fn size(&self) -> [f32; 2] {
        self.texture.size().map(|side| side as f32)
    }

    /// Returns linear RGB and alpha at texture coordinates (u, v), for a sample whose footprint is the square root of
    /// `square` texels wide.
    pub(crate) fn at(&self, [u, v]: [f32; 2], square: f32) -> Vec4 {
        let [wrap_u, wrap_v] = self.texture.wrap;
        let uv = [into_range(u, wrap_u), into_range(v, wrap_v)];
        if square.is_nan() || square <= 1.0 {
            return self.sample(0, uv, self.texture.magnify);
        }
        let minify = self.texture.minify;
        let level = (0.5 * log2(square)).min(self.smaller.len() as f32);
        match minify.levels {
            None => self.sample(0, uv, minify.texels),
            Some(Filter::Nearest) => self.sample((level + 0.5) as usize, uv, minify.texels),
            Some(Filter::Linear) => {
                let larger = level as usize;
                let part = level - larger as f32;
                if part == 0.0 {
                    return self.sample(larger, uv, minify.texels);
                }
                let smaller = self.sample(larger + 1, uv, minify.texels);
                self.sample(larger, uv, minify.texels).lerp(smaller, part)
            }
        }
    }

    /// Returns the levels from full size down.
    pub(crate) fn levels(&self) -> impl Iterator<Item = ([u32; 2], &[[u8; 4]])> {
        (0..=self.smaller.len()).map(|level| {
            let image = self.image(level);
            (image.size, image.texels)
        })
    }

    fn image(&self, level: usize) -> Image<'_> {
        match level.checked_sub(1).and_then(|level| self.smaller.get(level)) {
            Some(level) => level.image(),
            None => Image {
                size: self.texture.size(),
                texels: self.texture.texels(),
            },
        }
    }

    /// Samples one level at coordinates from [`into_range`].
    #[inline]
    fn sample(&self, level: usize, [u, v]: [f32; 2], filter: Filter) -> Vec4 {
        let image = self.image(level.min(self.smaller.len()));
        let [wrap_u, wrap_v] = self.texture.wrap;
        let [width, height] = image.size.map(|side| side as i32);
        let texel = |column: usize, row: usize| linear(self.decoded, image.texel(column, row));
        let (x, y) = (u * width as f32, v * height as f32);
        if filter == Filter::Nearest {
            let column = wrapped(floor(x), width, wrap_u);
            return texel(column, wrapped(floor(y), height, wrap_v));
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (floor(x), floor(y));
        let (part_x, part_y) = (x - left as f32, y - top as f32);
        let (column, next_column) = (wrapped(left, width, wrap_u), wrapped(left + 1, width, wrap_u));
        let (row, next_row) = (wrapped(top, height, wrap_v), wrapped(top + 1, height, wrap_v));
        let above = texel(column, row).lerp(texel(next_column, row), part_x);
        let below = texel(column, next_row).lerp(texel(next_column, next_row), part_x);
        above.lerp(below, part_y)
    }
}

impl Level {
    fn image(&self) -> Image<'_> {
        Image {
            size: self.size,
            texels: &self.texels,
        }
    }
}

impl Image<'_> {
    #[inline]
    fn texel(&self, column: usize, row: usize) -> [u8; 4] {
        self.texels[row * self.size[0] as usize + column]
    }
}

/// Returns the floor of a number with magnitude below 2²²; for integers, the integer or the one below. Branchless and
/// without the saturation checks of a cast: after adding a large constant, the low bits of the sum hold the integer
/// part.
#[inline]
fn floor(value: f32) -> i32 {
    const LARGE: f32 = 12_582_912.0;
    (value - 0.5 + LARGE).to_bits() as i32 - LARGE.to_bits() as i32
}

/// Returns log₂ of a positive number with an error below 0.01, which shifts the mip level imperceptibly.
#[inline]
fn log2(value: f32) -> f32 {
    let bits = value.to_bits();
    let exponent = (bits >> 23) as f32 - 127.0;
    let mantissa = f32::from_bits(bits & 0x007F_FFFF | 0x3F80_0000);
    exponent + (mantissa - 1.0) * (1.0 + (2.0 - mantissa) * 0.346)
}

/// Reduces a texture coordinate to a range near 0, so that distant coordinates keep their precision when multiplied by
/// the size. Returns 0 for NaN and for coordinates too large to resolve texels.
#[inline]
fn into_range(coordinate: f32, wrap: Wrap) -> f32 {
    const FAR: f32 = 4e6;
    // Also false for NaN.
    let near = if coordinate.abs() < FAR { coordinate } else { 0.0 };
    match wrap {
        Wrap::Repeat => near - floor(near) as f32,
        Wrap::Mirror => near - 2.0 * floor(0.5 * near) as f32,
        Wrap::Clamp => near.clamp(-1.0, 2.0),
    }
}

/// Returns the texel index under the wrap mode. `texel` may be one beyond either side with [`Wrap::Repeat`], and one
/// image beyond with [`Wrap::Mirror`].
#[inline]
fn wrapped(texel: i32, size: i32, wrap: Wrap) -> usize {
    let texel = match wrap {
        Wrap::Repeat if texel < 0 => texel + size,
        Wrap::Repeat if texel >= size => texel - size,
        Wrap::Mirror if texel >= size => 2 * size - 1 - texel,
        _ => texel,
    };
    texel.clamp(0, size - 1) as usize
}

#[inline]
fn linear(decoded: &[f32; 256], [r, g, b, a]: [u8; 4]) -> Vec4 {
    Vec4::new(
        decoded[usize::from(r)],
        decoded[usize::from(g)],
        decoded[usize::from(b)],
        f32::from(a) * (1.0 / 255.0),
    )
}

/// Returns the next mip level: half the width and height, rounded down, or `None` after 1×1. Colours are weighted by
/// alpha.
fn half(image: Image) -> Option<Level> {
    if image.size == [1, 1] {
        return None;
    }
    let size = image.size.map(|side| (side / 2).max(1));
    let mut texels = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for y in 0..size[1] {
        let rows = covered(y, size[1], image.size[1]);
        for x in 0..size[0] {
            let columns = covered(x, size[0], image.size[0]);
            let mut color = [0.0; 3];
            let [mut coverage, mut count] = [0.0, 0.0];
            for row in rows.clone() {
                for column in columns.clone() {
                    let [r, g, b, a] = linear(decoded(), image.texel(column, row)).to_array();
                    // The small bias keeps the average colour where all texels are transparent.
                    let weight = a + 1e-4;
                    color = [
                        color[0] + r * weight,
                        color[1] + g * weight,
                        color[2] + b * weight,
                    ];
                    coverage += a;
                    count += 1.0;
                }
            }
            let [r, g, b] = encode(color.map(|sum| sum / (coverage + 1e-4 * count)));
            texels.push([r, g, b, (255.0 * coverage / count + 0.5) as u8]);
        }
    }
    Some(Level { size, texels })
}

/// Returns the texels of a larger row that `texel` of a smaller row averages; together they cover the row.
fn covered(texel: u32, of: u32, larger: u32) -> std::ops::Range<usize> {
    let at = |texel: u32| (u64::from(texel) * u64::from(larger) / u64::from(of)) as usize;
    at(texel)..at(texel + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::Minify;

    fn texture(size: [u32; 2], texel: impl Fn(u32, u32) -> [u8; 4]) -> Texture {
        let texels = (0..size[0] * size[1]).map(|i| texel(i % size[0], i / size[0]));
        Texture::new("tile", size, texels.collect()).expect("one texel per pixel")
    }

    /// Creates a texture whose red encodes the column and whose green the row.
    fn numbered(change: impl FnOnce(&mut Texture)) -> Mips {
        let mut texture = texture([4, 2], |x, y| [x as u8 * 10, y as u8 * 10, 0, 255]);
        change(&mut texture);
        Mips::new(&Arc::new(texture))
    }

    fn texel_at(mips: &Mips, uv: [f32; 2]) -> [u8; 2] {
        let [r, g, b, _] = mips.at(uv, 0.5).to_array();
        let [r, g, _] = encode([r, g, b]);
        [r / 10, g / 10]
    }

    #[test]
    fn what_is_beyond_the_sides_repeats_mirrors_or_stays() {
        for (wrap, columns) in [
            (Wrap::Repeat, [2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1]),
            (Wrap::Mirror, [1, 0, 0, 1, 2, 3, 3, 2, 1, 0, 0, 1]),
            (Wrap::Clamp, [0, 0, 0, 1, 2, 3, 3, 3, 3, 3, 3, 3]),
        ] {
            for filter in [Filter::Nearest, Filter::Linear] {
                let mips = numbered(|texture| {
                    texture.wrap = [wrap; 2];
                    texture.magnify = filter;
                });
                for (step, column) in (-2..10).zip(columns) {
                    // At the centre of a texel both filters return its colour.
                    let uv = [(step as f32 + 0.5) / 4.0, 0.25];
                    assert_eq!(texel_at(&mips, uv), [column, 0], "{wrap:?} {filter:?} {step}");
                }
            }
        }
    }

    #[test]
    fn between_the_middles_of_texels_colors_blend_or_not() {
        let black_and_white = |magnify| {
            let mut texture = texture([2, 1], |x, _| [255 * x as u8, 0, 0, 255]);
            texture.wrap = [Wrap::Clamp; 2];
            texture.magnify = magnify;
            Mips::new(&Arc::new(texture)).at([0.45, 0.5], 1.0)[0]
        };
        assert_eq!(black_and_white(Filter::Nearest), 0.0);
        assert!((black_and_white(Filter::Linear) - 0.4).abs() < 1e-5);
    }

    #[test]
    fn smaller_levels_are_means_of_light_and_what_is_seen_through_has_no_say() {
        let mut checks = texture([64, 64], |x, y| {
            if (x + y) % 2 == 0 {
                [255, 255, 255, 255]
            } else {
                [0, 0, 0, 255]
            }
        });
        let mean = Mips::new(&Arc::new(checks.clone())).at([0.3, 0.7], 4096.0);
        assert!((mean[0] - 0.5).abs() < 0.01, "{mean:?}");
        checks.minify = Minify {
            texels: Filter::Nearest,
            levels: None,
        };
        let sharp = Mips::new(&Arc::new(checks)).at([0.3, 0.7], 4096.0);
        assert!(sharp[0] == 0.0 || sharp[0] == 1.0);
        let leaf = texture([4, 4], |x, _| {
            if x % 2 == 0 {
                [0, 200, 0, 255]
            } else {
                [255, 0, 255, 0]
            }
        });
        let [r, _, _, a] = Mips::new(&Arc::new(leaf)).at([0.5; 2], 16.0).to_array();
        assert!(r < 0.01 && (a - 0.5).abs() < 0.01, "{r} {a}");
    }

    #[test]
    fn a_sample_between_two_levels_blends_them_and_odd_sizes_lose_no_texel() {
        let halves = texture([2, 2], |x, _| [255 * x as u8, 0, 0, 255]);
        let mips = Mips::new(&Arc::new(halves));
        let [sharp, mixed, flat] = [1.0, 2.0, 4.0].map(|texels| mips.at([0.75, 0.5], texels)[0]);
        assert!(sharp > mixed && mixed > flat, "{sharp} {mixed} {flat}");
        let odd = texture([3, 5], |x, y| {
            if (x, y) == (2, 4) {
                [255; 4]
            } else {
                [0, 0, 0, 255]
            }
        });
        let dot = Mips::new(&Arc::new(odd)).at([0.5; 2], 64.0)[0];
        assert!(dot > 0.01, "the last texel contributes to the average: {dot}");
    }

    #[test]
    fn floor_and_log2_are_accurate_enough() {
        for step in 1..4000 {
            let value = 1.003_f32.powi(step);
            assert!((log2(value) - value.log2()).abs() < 0.01, "{value}");
        }
        for value in [-3.1, -2.5, -0.1, 0.1, 0.9, 1.5, 7.25, 1_000_000.5, -70_000.25] {
            assert_eq!(floor(value) as f32, value.floor());
        }
        assert!((0..9).all(|whole| [whole, whole - 1].contains(&floor(whole as f32))));
    }

    #[test]
    fn places_that_are_no_numbers_or_far_out_do_no_harm() {
        let mips = numbered(|_| {});
        for uv in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e30, -1e30] {
            let color = mips.at([uv, uv], 3.0);
            let values = color.to_array();
            assert!(
                values.iter().all(|value| (0.0..=1.0).contains(value)),
                "{color:?}"
            );
        }
        assert!(mips.at([0.5; 2], f32::NAN).w == 1.0);
    }
}
