//! Extensions: which can be left out with a warning, and which make a file unreadable.

use super::document::{Document, short};
use crate::BrokenRule;
use crate::warning::{WarningKind, Warnings};

/// Without these, and without any that begins with `KHR_materials_`, shapes stay where they are: only their look or
/// what is known about them changes.
const ONLY_LOOK: [&str; 11] = [
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_texture_dds",
];

const REMEDIES: [(&str, &str); 5] = [
    (
        "EXT_mesh_gpu_instancing",
        "export it again with one node for each copy",
    ),
    ("EXT_meshopt_compression", "export it again without compression"),
    (
        "KHR_draco_mesh_compression",
        "export it again without compression",
    ),
    (
        "KHR_mesh_quantization",
        "export it again with positions as 32-bit floats",
    ),
    ("KHR_meshopt_compression", "export it again without compression"),
];

/// Refuses a file that cannot be shown without what it requires; warns of everything else.
pub(super) fn check(document: &Document, warnings: &mut Warnings) -> Result<(), BrokenRule> {
    for name in &document.extensions_required {
        if !(name.starts_with("KHR_materials_") || ONLY_LOOK.contains(&&**name)) {
            let known = REMEDIES.iter().find(|(extension, _)| extension == name);
            let remedy = known.map_or("export it again without it", |&(_, remedy)| remedy);
            return Err(BrokenRule::ExtensionRequired {
                extension: short(name),
                remedy,
            });
        }
    }
    for name in document.extensions_used.union(&document.extensions_required) {
        warnings.name(WarningKind::Extensions, || short(name));
    }
    Ok(())
}
