//! Images on faces: carried for who draws; nothing that decides what is seen looks at them.

use thiserror::Error;

/// A texture, by its place in [`Geometry::textures`](super::Geometry::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TextureId(pub u32);

/// An image, and how it is looked up.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// How people call it.
    pub name: String,
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
    /// What is beyond its sides: left and right, above and below.
    pub wrap: [Wrap; 2],
    /// Between texels, where a texel is larger than a sample.
    pub magnify: Filter,
    /// Where a sample is larger than a texel.
    pub minify: Minify,
}

/// What is beyond the sides of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored, then the image again.
    Mirror,
    /// The color of its border.
    Clamp,
}

/// What is between the middles of texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The color of the nearest.
    Nearest,
    /// Colors in between.
    #[default]
    Linear,
}

/// What is seen where a sample is larger than a texel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Minify {
    /// In one image.
    pub texels: Filter,
    /// Between the image and its halves, quarters, eighths …; `None`: the image itself, which then flickers.
    pub levels: Option<Filter>,
}

impl Default for Minify {
    fn default() -> Minify {
        Minify {
            texels: Filter::Linear,
            levels: Some(Filter::Linear),
        }
    }
}

/// Why texels make no texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a texture of {0}x{1} texels cannot have {2}; width and height must be from 1 to {most}", most = Texture::MAX_TEXELS)]
pub struct TextureError(u32, u32, usize);

impl Texture {
    /// The greatest width and height.
    pub const MAX_TEXELS: u32 = 1 << 16;

    /// A texture that repeats and is smooth. Texels are rows from the top, each from the left: red, green and blue as
    /// sRGB, and coverage.
    ///
    /// # Errors
    /// [`TextureError`] where there are too few or too many of them.
    pub fn new(name: &str, size: [u32; 2], texels: Vec<[u8; 4]>) -> Result<Texture, TextureError> {
        let [width, height] = size;
        let in_range = size.iter().all(|side| (1..=Texture::MAX_TEXELS).contains(side));
        if !in_range || texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(TextureError(width, height, texels.len()));
        }
        Ok(Texture {
            name: name.to_owned(),
            size,
            texels,
            wrap: [Wrap::default(); 2],
            magnify: Filter::default(),
            minify: Minify::default(),
        })
    }

    /// Columns and rows.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Rows from the top, each from the left: red, green and blue as sRGB, and coverage.
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// Memory in bytes.
    pub fn bytes(&self) -> u64 {
        size_of_val(&*self.texels) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_that_do_not_fill_an_image_are_refused() {
        for (size, count) in [([2, 3], 5), ([0, 0], 0), ([1 << 17, 1], 1 << 17)] {
            let error = Texture::new("odd", size, vec![[0; 4]; count]).expect_err("they do not fit");
            assert_eq!(error, TextureError(size[0], size[1], count));
        }
        let texture = Texture::new("tile", [2, 3], vec![[9; 4]; 6]).expect("six texels");
        assert_eq!((texture.size(), texture.bytes()), ([2, 3], 24));
    }
}
