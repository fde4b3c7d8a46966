//! What faces are made of.

use super::TextureId;

/// A material, by its place in [`Geometry::materials`](super::Geometry::materials).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub u32);

/// What a face is made of. Only `alpha`, `double_sided` and `detail` have a say in what is seen; the rest is for who draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Red, green, blue and coverage, linear, 0 to 1.
    pub base_color: [f32; 4],
    /// An image that the base color is multiplied by.
    pub texture: Option<TextureId>,
    /// Red, green and blue of the light that it sends out by itself, linear, 0 or more.
    pub emission: [f32; 3],
    /// An image that the emission is multiplied by, at the same places as the texture.
    pub emission_texture: Option<TextureId>,
    /// Has it its colors whatever light falls on it?
    pub unlit: bool,
    /// What light does with it.
    pub alpha: Alpha,
    /// Of [`Alpha::Mask`]: where coverage is less than this there is a hole.
    pub cutoff: f32,
    /// Is it seen from both sides? If not, it is neither seen nor hides from behind.
    pub double_sided: bool,
    /// Is it of small things: plants, crockery, railings? Exact methods see no difference; those that choose what hides
    /// never choose this, nor let it in.
    pub detail: bool,
}

/// Whether a face hides what is behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alpha {
    /// It does.
    Opaque,
    /// A cut-out: it may have holes, so it never hides; it is judged by its geometry.
    Mask,
    /// Glass: it never hides, and is painted over what is behind it.
    Blend,
}

impl Material {
    /// Opaque, seen from one side, of a linear color.
    pub const fn opaque(color: [f32; 3]) -> Material {
        let [r, g, b] = color;
        Material {
            base_color: [r, g, b, 1.0],
            texture: None,
            emission: [0.0; 3],
            emission_texture: None,
            unlit: false,
            alpha: Alpha::Opaque,
            cutoff: 0.5,
            double_sided: false,
            detail: false,
        }
    }

    /// The textures that it names.
    pub fn textures(&self) -> impl Iterator<Item = TextureId> {
        self.texture.into_iter().chain(self.emission_texture)
    }

    /// May a method that chooses what hides choose it?
    pub(crate) fn can_occlude(&self) -> bool {
        self.alpha == Alpha::Opaque && !self.detail
    }
}
