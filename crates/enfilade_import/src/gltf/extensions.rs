//! Extensions: those that are supported, those that are ignored with a warning, and those that make a file unreadable.

use super::document::{Document, short};
use crate::BrokenRule;
use crate::warning::{WarningKind, Warnings};

/// The supported extensions.
const READ: [&str; 9] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
];

const REMEDIES: [(&str, &str); 1] = [(
    "KHR_draco_mesh_compression",
    "export it again without compression",
)];

fn is_read(name: &str) -> bool {
    READ.contains(&name)
}

/// Returns an error if the file requires an unsupported extension; adds a warning for each one that it only uses.
pub(super) fn check(document: &Document, warnings: &mut Warnings) -> Result<(), BrokenRule> {
    let required = document.extensions_required.iter();
    let unread: Vec<&String> = required.filter(|name| !is_read(name)).collect();
    if let Some(first) = unread.first() {
        const FEW: usize = 4;
        let mut names: Vec<String> = unread.iter().take(FEW).map(|name| short(name)).collect();
        if unread.len() > FEW {
            names.push(format!("{} more", unread.len() - FEW));
        }
        let known = REMEDIES.iter().find(|(extension, _)| extension == first);
        return Err(BrokenRule::ExtensionRequired {
            extension: names.join(", "),
            remedy: known.map_or("export it again without", |&(_, remedy)| remedy),
        });
    }
    for name in document.extensions_used.iter().filter(|name| !is_read(name)) {
        warnings.name(WarningKind::Extensions, || short(name));
    }
    Ok(())
}
