//! Materials: color, transparency and back-face culling of faces.

use crate::ids::TextureId;

/// The material of a face. Only `alpha`, `double_sided` and `detail` affect visibility; the rest is for the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Material {
    /// Base color: red, green, blue and coverage, linear, 0 to 1.
    pub base_color: [f32; 4],
    /// Texture that is multiplied by the base color.
    pub texture: Option<TextureId>,
    /// Emitted light: red, green and blue, linear, 0 or more.
    pub emission: [f32; 3],
    /// Texture that is multiplied by the emission; it has the same texture coordinates as `texture`.
    pub emission_texture: Option<TextureId>,
    /// Whether the color is independent of lighting.
    pub unlit: bool,
    /// Alpha mode: opaque, alpha-tested or alpha-blended.
    pub alpha: Alpha,
    /// Alpha-test threshold, for [`Alpha::Mask`]: texels with less coverage are holes.
    pub cutoff: f32,
    /// Whether the face is visible from both sides. If not, it is back-face culled: from behind it is neither visible
    /// nor an occluder.
    pub double_sided: bool,
    /// Whether the faces belong to small objects, such as plants, crockery or railings. Methods that select occluders
    /// never select them, nor rasterize them as occluders. Has no effect on exact methods.
    pub detail: bool,
}

/// Alpha mode of a material; decides whether its faces are occluders.
#[doc(alias = "transparency")]
#[doc(alias = "blend mode")]
#[doc(alias = "alpha test")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Alpha {
    /// Opaque: an occluder.
    Opaque,
    /// Alpha-tested (cut-out): may have holes, so it is never an occluder. It counts as visible by its geometry,
    /// without evaluating the texture.
    Mask,
    /// Alpha-blended (glass): never an occluder; drawn over what is behind it.
    Blend,
}

impl Material {
    /// The material of a cluster without faces, which stands for what is within its bounds: it hides nothing.
    pub(crate) const OF_BOUNDS: Material = Material {
        alpha: Alpha::Mask,
        double_sided: true,
        ..Material::opaque([1.0; 3])
    };

    /// Creates an opaque, one-sided material; `color` is red, green and blue, linear, 0 to 1.
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

    /// Returns the textures that the material refers to.
    pub fn textures(&self) -> impl Iterator<Item = TextureId> {
        self.texture.into_iter().chain(self.emission_texture)
    }

    /// Whether methods may select faces of this material as occluders.
    pub(crate) fn can_occlude(&self) -> bool {
        self.alpha == Alpha::Opaque && !self.detail
    }
}
