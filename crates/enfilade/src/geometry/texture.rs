//! Textures of materials. A geometry only carries them for renderers: nothing in this crate reads texels, so they do
//! not affect visibility.

use thiserror::Error;

/// An RGBA image with its sampler settings. It is for the renderer and does not affect visibility.
#[doc(alias = "image")]
#[doc(alias = "sampler")]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Name for display.
    pub name: String,
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
    /// Wrap mode of the horizontal and the vertical texture coordinate. Default [`Wrap::Repeat`].
    pub wrap: [Wrap; 2],
    /// Filter for magnification, where a texel is larger than a sample. Default [`Filter::Linear`].
    pub magnify: Filter,
    /// Filter for minification, where a sample is larger than a texel. Default: trilinear.
    pub minify: Minify,
}

/// Wrap mode: the color for texture coordinates outside 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Wrap {
    /// Repeats the image.
    #[default]
    Repeat,
    /// Repeats the image, mirroring every second copy.
    Mirror,
    /// Repeats the texels at the border.
    Clamp,
}

/// Texture filter: how texels are interpolated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Filter {
    /// Takes the nearest texel.
    Nearest,
    /// Interpolates linearly between texels.
    #[default]
    Linear,
}

/// Minification filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Minify {
    /// Filter within one mipmap level.
    pub texels: Filter,
    /// Filter between mipmap levels; `None`: no mipmaps, so minified textures flicker.
    #[doc(alias = "mipmap")]
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

/// Why texels do not form a texture: holds width, height and number of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a texture of {0}x{1} texels cannot have {2}; width and height must be from 1 to {max}", max = Texture::MAX_TEXELS)]
pub struct TextureError(u32, u32, usize);

impl Texture {
    /// Maximum width and height, in texels.
    pub const MAX_TEXELS: u32 = 1 << 16;

    /// Creates a texture with default sampler settings: repeating and trilinear.
    ///
    /// `size` is width and height in texels. Texels are in rows from the top, each from the left: red, green and blue
    /// in sRGB, and linear coverage.
    ///
    /// # Errors
    /// Returns a [`TextureError`] if width or height is not 1 to [`Texture::MAX_TEXELS`], or the number of texels is
    /// not width × height.
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

    /// Returns width and height, in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the texels, in rows from the top, each from the left: red, green and blue in sRGB, and linear coverage.
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }

    /// Returns the memory used, in bytes.
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
            let error = Texture::new("odd", size, vec![[0; 4]; count]).expect_err("wrong number of texels");
            assert_eq!(error, TextureError(size[0], size[1], count));
        }
        let texture = Texture::new("tile", [2, 3], vec![[9; 4]; 6]).expect("six texels");
        assert_eq!((texture.size(), texture.bytes()), ([2, 3], 24));
    }
}
