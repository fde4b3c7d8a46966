//! Materials: color, alpha mode, emission, double-sidedness, and texture references.

use super::attributes::Coordinates;
use super::document::{Document, Material as Source, short};
use super::plan::Plan;
use crate::{BrokenRule, NonOccluder};
use enfilade::{Alpha, Material, MaterialId};
use serde::Deserialize;
use serde_json::value::RawValue;

/// A material and the document's textures that it uses.
#[derive(Debug)]
pub(super) struct Surface {
    /// Without textures; their ids are assigned once it is known which textures are used.
    pub(super) material: Material,
    /// Why it hides nothing, if its alpha mode does not tell.
    pub(super) non_occluder: Option<NonOccluder>,
    pub(super) texture: Option<u32>,
    pub(super) emission_texture: Option<u32>,
    /// Texture coordinates of both textures.
    pub(super) coordinates: Option<Coordinates>,
    /// Whether emission was dropped, because the emissive texture uses other coordinates than the color texture.
    pub(super) lost_emission: bool,
    /// Number of textures that are not drawn.
    pub(super) other_maps: usize,
}

/// Returns the document's materials by index, followed by the default material. Without `textures`, no texture is
/// referenced.
pub(super) fn read(document: &Document, plan: &Plan, textures: bool) -> Result<Vec<Surface>, BrokenRule> {
    let mut surfaces = Vec::with_capacity(document.materials.len() + 1);
    for (number, source) in document.materials.iter().enumerate() {
        let index = number as u32;
        let is_affected = plan.affected().has_material(index);
        let why = why_no_occluder(source, plan.animates_material(index), is_affected);
        let plain = material(number, source, why)?;
        let surface = if textures {
            textured(plain, source)
        } else {
            untextured(plain)
        };
        surfaces.push(Surface {
            non_occluder: why,
            ..surface
        });
    }
    surfaces.push(untextured(Material::opaque([1.0; 3])));
    Ok(surfaces)
}

/// Returns the material of primitives without a material.
pub(super) fn default_material(document: &Document) -> MaterialId {
    MaterialId(document.materials.len() as u32)
}

fn untextured(material: Material) -> Surface {
    Surface {
        material,
        non_occluder: None,
        texture: None,
        emission_texture: None,
        coordinates: None,
        lost_emission: false,
        other_maps: 0,
    }
}

fn textured(mut material: Material, source: &Source) -> Surface {
    let pbr = &source.pbr_metallic_roughness;
    let base = pbr.base_color_texture.as_deref();
    let mut emissive = source.emissive_texture.as_deref();
    let coordinates = base.or(emissive).map(Coordinates::of);
    // A vertex has only one set of texture coordinates. Emitting without the texture would light up whole objects that
    // are mostly dark.
    let lost_emission = emissive.is_some_and(|info| Some(Coordinates::of(info)) != coordinates)
        && material.emission != [0.0; 3];
    if lost_emission {
        material.emission = [0.0; 3];
    }
    if material.emission == [0.0; 3] {
        emissive = None;
    }
    let maps = [
        pbr.metallic_roughness_texture.is_some(),
        source.normal_texture.is_some(),
        source.occlusion_texture.is_some(),
        (source.extensions.transmission.as_ref())
            .is_some_and(|transmission| transmission.transmission_texture.is_some()),
    ];
    Surface {
        material,
        non_occluder: None,
        texture: base.map(|info| info.index),
        emission_texture: emissive.map(|info| info.index),
        coordinates: coordinates.filter(|_| base.is_some() || emissive.is_some()),
        lost_emission,
        other_maps: maps.into_iter().filter(|&map| map).count(),
    }
}

/// Returns the factor of `KHR_materials_transmission`.
fn transmission(source: &Source) -> f32 {
    let transmission = source.extensions.transmission.as_ref();
    transmission.map_or(0.0, |of| of.transmission_factor.clamp(0.0, 1.0))
}

/// Returns why a material hides nothing, whatever its alpha mode.
fn why_no_occluder(source: &Source, is_animated: bool, is_affected: bool) -> Option<NonOccluder> {
    let reasons = [
        (source.extensions.lets_light_through(), NonOccluder::Transmissive),
        (source.extensions.levels.is_some(), NonOccluder::LevelOfDetail),
        (is_animated, NonOccluder::Animated),
        (is_affected, NonOccluder::ExtensionUnread),
    ];
    reasons.iter().find(|(holds, _)| *holds).map(|&(_, why)| why)
}

/// Returns a material without its textures; no occluder if it has a reason to be none.
fn material(number: usize, source: &Source, why: Option<NonOccluder>) -> Result<Material, BrokenRule> {
    let transmission = transmission(source);
    let mut cutoff = source.alpha_cutoff.clamp(0.0, f32::MAX);
    let alpha = match &*source.alpha_mode {
        // A transmissive material is transparent, so it must not occlude what is behind it, whatever its alpha mode.
        "OPAQUE" | "MASK" if transmission > 0.0 => Alpha::Blend,
        // Without holes, but no occluder.
        "OPAQUE" if why.is_some() => {
            cutoff = 0.0;
            Alpha::Mask
        }
        "OPAQUE" => Alpha::Opaque,
        "MASK" => Alpha::Mask,
        "BLEND" => Alpha::Blend,
        mode => {
            return Err(BrokenRule::BadAlphaMode {
                place: format!("material {number}"),
                mode: short(mode),
            });
        }
    };
    let [r, g, b, a] = source
        .pbr_metallic_roughness
        .base_color_factor
        .map(|value| value.clamp(0.0, 1.0));
    let a = if source.alpha_mode == "OPAQUE" { 1.0 } else { a };
    // Never fully transparent: even the clearest glass is visible by its reflections.
    const OF_CLEAR_GLASS: f32 = 0.1;
    let a = a * (1.0 - (1.0 - OF_CLEAR_GLASS) * transmission);
    let strength = source.extensions.emissive.emissive_strength.clamp(0.0, f32::MAX);
    Ok(Material {
        base_color: [r, g, b, a],
        emission: source
            .emissive_factor
            .map(|value| value.clamp(0.0, 1.0) * strength),
        unlit: source.extensions.unlit.is_some(),
        alpha,
        cutoff,
        double_sided: source.double_sided,
        detail: is_detail(source.extras),
        ..Material::opaque([r, g, b])
    })
}

/// Returns `true` if `extras` is `{"enfilade": {"detail": true}}`. Other values belong to other programs and are
/// ignored.
fn is_detail(extras: Option<&RawValue>) -> bool {
    #[derive(Deserialize)]
    struct Extras {
        enfilade: EnfiladeExtras,
    }
    #[derive(Deserialize)]
    struct EnfiladeExtras {
        detail: Mark,
    }
    /// Exporters write 1 for `true`.
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Mark {
        Bool(bool),
        Number(f64),
    }
    let read = extras.and_then(|extras| serde_json::from_str::<Extras>(extras.get()).ok());
    read.is_some_and(|extras| match extras.enfilade.detail {
        Mark::Bool(marked) => marked,
        Mark::Number(number) => number != 0.0,
    })
}
