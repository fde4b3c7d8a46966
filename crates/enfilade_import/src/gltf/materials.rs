//! Materials: base color, coverage and sides.

use super::document::{Document, Material as Source, short};
use crate::BrokenRule;
use enfilade::{Alpha, Material, MaterialId};
use serde::Deserialize;
use serde_json::value::RawValue;

/// The document's materials by their numbers, then the one of primitives that name none.
pub(super) fn read(document: &Document) -> Result<Vec<Material>, BrokenRule> {
    let mut materials = Vec::with_capacity(document.materials.len() + 1);
    for (number, source) in document.materials.iter().enumerate() {
        materials.push(material(number, source)?);
    }
    materials.push(Material::opaque([1.0; 3]));
    Ok(materials)
}

/// What a primitive that names no material is made of.
pub(super) fn default_material(document: &Document) -> MaterialId {
    MaterialId(document.materials.len() as u32)
}

fn material(number: usize, source: &Source) -> Result<Material, BrokenRule> {
    let alpha = match &*source.alpha_mode {
        // Light goes through, and so does sight: it must not hide what is behind it, whatever its coverage.
        "OPAQUE" | "MASK" if source.extensions.transmission.transmission_factor > 0.0 => Alpha::Blend,
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
    let a = if alpha == Alpha::Opaque { 1.0 } else { a };
    Ok(Material {
        base_color: [r, g, b, a],
        alpha,
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
