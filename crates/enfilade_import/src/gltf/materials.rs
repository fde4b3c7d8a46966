//! Materials: colors, coverage, light that they send out, sides, and which textures they name.

use super::attributes::Coordinates;
use super::document::{Document, Material as Source, short};
use crate::BrokenRule;
use enfilade::{Alpha, Material, MaterialId};
use serde::Deserialize;
use serde_json::value::RawValue;

/// A material, and the textures of the document that it names.
#[derive(Debug)]
pub(super) struct Surface {
    /// Without textures, which get their numbers when it is known which of them are used.
    pub(super) material: Material,
    pub(super) texture: Option<u32>,
    pub(super) emission_texture: Option<u32>,
    /// Where on them faces are.
    pub(super) coordinates: Option<Coordinates>,
    /// Had it a texture of what it sends out, which lies otherwise than that of its color? Then it sends out nothing.
    pub(super) lost_emission: bool,
    /// Maps of it that are not drawn.
    pub(super) other_maps: usize,
}

/// The document's materials by their numbers, then the one of primitives that name none. Without `textures` none is
/// named.
pub(super) fn read(document: &Document, textures: bool) -> Result<Vec<Surface>, BrokenRule> {
    let mut surfaces = Vec::with_capacity(document.materials.len() + 1);
    for (number, source) in document.materials.iter().enumerate() {
        let plain = material(number, source)?;
        surfaces.push(if textures {
            textured(plain, source)
        } else {
            untextured(plain)
        });
    }
    surfaces.push(untextured(Material::opaque([1.0; 3])));
    Ok(surfaces)
}

/// What a primitive that names no material is made of.
pub(super) fn default_material(document: &Document) -> MaterialId {
    MaterialId(document.materials.len() as u32)
}

fn untextured(material: Material) -> Surface {
    Surface {
        material,
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
    // There is one place in both for each corner. Without its texture all of a thing would shine that is mostly dark.
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
        source.extensions.transmission.transmission_texture.is_some(),
    ];
    Surface {
        material,
        texture: base.map(|info| info.index),
        emission_texture: emissive.map(|info| info.index),
        coordinates: coordinates.filter(|_| base.is_some() || emissive.is_some()),
        lost_emission,
        other_maps: maps.into_iter().filter(|&map| map).count(),
    }
}

fn material(number: usize, source: &Source) -> Result<Material, BrokenRule> {
    let transmission = source.extensions.transmission.transmission_factor.clamp(0.0, 1.0);
    let alpha = match &*source.alpha_mode {
        // Light goes through, and so does sight: it must not hide what is behind it, whatever its coverage.
        "OPAQUE" | "MASK" if transmission > 0.0 => Alpha::Blend,
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
    // Never quite nothing: the clearest glass is still seen, by its reflections.
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
        cutoff: source.alpha_cutoff.clamp(0.0, f32::MAX),
        double_sided: source.double_sided,
        detail: is_detail(source.extras),
        ..Material::opaque([r, g, b])
    })
}

/// Is it marked by `{"enfilade": {"detail": true}}`? What is not of that form is someone else's.
fn is_detail(extras: Option<&RawValue>) -> bool {
    #[derive(Deserialize)]
    struct Extras {
        enfilade: Ours,
    }
    #[derive(Deserialize)]
    struct Ours {
        detail: Mark,
    }
    /// Exporters write 1 for true.
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
