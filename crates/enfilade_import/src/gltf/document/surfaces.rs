//! JSON of materials, textures, images and samplers.

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::value::RawValue;
use std::borrow::Cow;

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Material<'a> {
    #[serde(default)]
    pub(in crate::gltf) pbr_metallic_roughness: PbrMetallicRoughness,
    #[serde(default)]
    pub(in crate::gltf) emissive_factor: [f32; 3],
    pub(in crate::gltf) emissive_texture: Option<Box<TextureInfo>>,
    pub(in crate::gltf) normal_texture: Option<IgnoredAny>,
    pub(in crate::gltf) occlusion_texture: Option<IgnoredAny>,
    #[serde(borrow, default = "opaque")]
    pub(in crate::gltf) alpha_mode: Cow<'a, str>,
    #[serde(default = "half")]
    pub(in crate::gltf) alpha_cutoff: f32,
    #[serde(default)]
    pub(in crate::gltf) double_sided: bool,
    #[serde(default)]
    pub(in crate::gltf) extensions: MaterialExtensions,
    /// Any JSON value.
    #[serde(borrow)]
    pub(in crate::gltf) extras: Option<&'a RawValue>,
}

fn opaque() -> Cow<'static, str> {
    Cow::Borrowed("OPAQUE")
}

fn half() -> f32 {
    0.5
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::gltf) struct PbrMetallicRoughness {
    pub(in crate::gltf) base_color_factor: [f32; 4],
    pub(in crate::gltf) base_color_texture: Option<Box<TextureInfo>>,
    pub(in crate::gltf) metallic_roughness_texture: Option<IgnoredAny>,
}

impl Default for PbrMetallicRoughness {
    fn default() -> PbrMetallicRoughness {
        PbrMetallicRoughness {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_roughness_texture: None,
        }
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(in crate::gltf) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_transmission")]
    pub(in crate::gltf) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_diffuse_transmission")]
    pub(in crate::gltf) diffuse_transmission: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_dispersion")]
    pub(in crate::gltf) dispersion: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_volume")]
    pub(in crate::gltf) volume: Option<IgnoredAny>,
    #[serde(rename = "MSFT_lod")]
    pub(in crate::gltf) levels: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_subsurface")]
    pub(in crate::gltf) subsurface: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_volume_scatter")]
    pub(in crate::gltf) volume_scatter: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_unlit")]
    pub(in crate::gltf) unlit: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_emissive_strength")]
    pub(in crate::gltf) emissive: EmissiveStrength,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::gltf) struct Transmission {
    pub(in crate::gltf) transmission_factor: f32,
    pub(in crate::gltf) transmission_texture: Option<IgnoredAny>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::gltf) struct EmissiveStrength {
    pub(in crate::gltf) emissive_strength: f32,
}

impl MaterialExtensions {
    /// Returns `true` if light may pass through the surface.
    pub(in crate::gltf) fn lets_light_through(&self) -> bool {
        let transmission = self.transmission.as_ref();
        transmission.is_some_and(|transmission| transmission.transmission_factor > 0.0)
            || self.diffuse_transmission.is_some()
            || self.dispersion.is_some()
            || self.subsurface.is_some()
            || self.volume.is_some()
            || self.volume_scatter.is_some()
    }
}

impl Default for EmissiveStrength {
    fn default() -> EmissiveStrength {
        EmissiveStrength {
            emissive_strength: 1.0,
        }
    }
}

/// A texture and its coordinates.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct TextureInfo {
    pub(in crate::gltf) index: u32,
    #[serde(default)]
    pub(in crate::gltf) tex_coord: u32,
    #[serde(default)]
    pub(in crate::gltf) extensions: TextureInfoExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(in crate::gltf) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(in crate::gltf) transform: Option<TextureTransform>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub(in crate::gltf) struct TextureTransform {
    pub(in crate::gltf) offset: [f64; 2],
    pub(in crate::gltf) rotation: f64,
    pub(in crate::gltf) scale: [f64; 2],
    pub(in crate::gltf) tex_coord: Option<u32>,
}

impl Default for TextureTransform {
    fn default() -> TextureTransform {
        TextureTransform {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            tex_coord: None,
        }
    }
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Texture<'a> {
    #[serde(borrow, default)]
    pub(in crate::gltf) name: Cow<'a, str>,
    pub(in crate::gltf) sampler: Option<u32>,
    pub(in crate::gltf) source: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Image<'a> {
    #[serde(borrow, default)]
    pub(in crate::gltf) name: Cow<'a, str>,
    #[serde(borrow, default)]
    pub(in crate::gltf) uri: Cow<'a, str>,
    pub(in crate::gltf) buffer_view: Option<u32>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Sampler {
    pub(in crate::gltf) mag_filter: Option<u32>,
    pub(in crate::gltf) min_filter: Option<u32>,
    pub(in crate::gltf) wrap_s: Option<u32>,
    pub(in crate::gltf) wrap_t: Option<u32>,
}
