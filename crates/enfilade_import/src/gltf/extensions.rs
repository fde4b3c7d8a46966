//! Extensions: those that are read, those that change nothing visible, and those that make a file unreadable if it requires them.

use super::document::{Document, short};
use crate::BrokenRule;
use crate::warning::{WarningKind, Warnings};

/// How an extension affects what is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    /// It is read, or makes what it concerns hide nothing.
    Read,
    /// It concerns textures, shading or metadata: without it, shapes and what they hide are the same.
    Harmless,
    /// Without it, shapes would be missing or wrong. Holds what is lost, and the remedy.
    Shape(&'static str),
}

use Effect::{Harmless, Read, Shape};

/// What an unknown extension may change.
const UNKNOWN: Effect = Shape("export it again without");

/// The extensions of the registry of Khronos, and some of engines, by name.
const EXTENSIONS: [(&str, Effect); 72] = [
    // Moves nodes.
    (
        "AGI_articulations",
        Shape("its parts are moved by it; export it again without"),
    ),
    ("AGI_stk_metadata", Harmless),
    ("CESIUM_primitive_outline", Harmless),
    ("CESIUM_RTC", Shape("its place is lost; export it again without")),
    ("EXT_feature_metadata", Harmless),
    (
        "EXT_implicit_cylinder_region",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    (
        "EXT_implicit_ellipsoid_region",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    ("EXT_instance_features", Harmless),
    ("EXT_lights_ies", Harmless),
    ("EXT_lights_image_based", Harmless),
    ("EXT_materials_bump", Harmless),
    ("EXT_mesh_features", Harmless),
    ("EXT_mesh_gpu_instancing", Read),
    ("EXT_mesh_manifold", Harmless),
    ("EXT_meshopt_compression", Read),
    (
        "EXT_primitive_voxels",
        Shape("its voxels are lost; export it again as triangles"),
    ),
    ("EXT_structural_metadata", Harmless),
    ("EXT_texture_astc", Harmless),
    ("EXT_texture_avif", Harmless),
    ("EXT_texture_procedurals", Harmless),
    ("EXT_texture_video", Harmless),
    ("EXT_texture_webp", Harmless),
    ("FB_geometry_metadata", Harmless),
    ("GODOT_single_root", Harmless),
    ("GOOGLE_backgrounds", Harmless),
    ("GRIFFEL_bim_data", Harmless),
    (
        "KHR_accessor_float64",
        Shape("positions of 64 bits are not read; export it again with 32 bits"),
    ),
    ("KHR_animation_pointer", Read),
    ("KHR_audio", Harmless),
    ("KHR_audio_emitter", Harmless),
    ("KHR_character", Harmless),
    (
        "KHR_draco_mesh_compression",
        Shape("export it again without compression"),
    ),
    (
        "KHR_gaussian_splatting",
        Shape("its splats are lost; export it again as triangles"),
    ),
    ("KHR_implicit_shapes", Harmless),
    (
        "KHR_interactivity",
        Shape("a program moves its nodes; export it again without"),
    ),
    ("KHR_lights_punctual", Read),
    ("KHR_materials_anisotropy", Harmless),
    ("KHR_materials_clearcoat", Harmless),
    ("KHR_materials_coat", Harmless),
    ("KHR_materials_diffuse_roughness", Harmless),
    ("KHR_materials_diffuse_transmission", Read),
    ("KHR_materials_dispersion", Read),
    ("KHR_materials_emissive_strength", Read),
    ("KHR_materials_fuzz", Harmless),
    ("KHR_materials_ior", Harmless),
    ("KHR_materials_iridescence", Harmless),
    ("KHR_materials_pbrSpecularGlossiness", Harmless),
    ("KHR_materials_sheen", Harmless),
    ("KHR_materials_specular", Harmless),
    ("KHR_materials_transmission", Read),
    ("KHR_materials_unlit", Read),
    ("KHR_materials_variants", Read),
    ("KHR_materials_volume", Read),
    ("KHR_materials_volume_scatter", Read),
    ("KHR_mesh_quantization", Read),
    ("KHR_meshopt_compression", Read),
    ("KHR_node_hoverability", Harmless),
    ("KHR_node_selectability", Harmless),
    ("KHR_node_visibility", Read),
    (
        "KHR_physics_rigid_bodies",
        Shape("bodies fall by it; export it again without"),
    ),
    (
        "KHR_techniques_webgl",
        Shape("its own shaders may move or discard anything; export it again without"),
    ),
    ("KHR_texture_basisu", Harmless),
    ("KHR_texture_transform", Read),
    ("KHR_xmp", Harmless),
    ("KHR_xmp_json_ld", Harmless),
    ("MPEG_texture_video", Harmless),
    ("MSFT_lod", Read),
    ("MSFT_packing_normalRoughnessMetallic", Harmless),
    ("MSFT_packing_occlusionRoughnessMetallic", Harmless),
    ("MSFT_texture_dds", Harmless),
    (
        "NV_materials_mdl",
        Shape("its own shaders may be transparent; export it again without"),
    ),
    (
        "VRMC_node_constraint",
        Shape("its nodes are moved by it; export it again without"),
    ),
];

fn effect(name: &str) -> Effect {
    let known = EXTENSIONS.iter().find(|(known, _)| *known == name);
    known.map_or(UNKNOWN, |&(_, effect)| effect)
}

/// Returns an error if the file requires an extension without which shapes would be wrong; adds a warning for each other one that
/// is not read.
pub(super) fn check(document: &Document, warnings: &mut Warnings) -> Result<(), BrokenRule> {
    let required = document.extensions_required.iter();
    let lost = required.filter_map(|name| match effect(name) {
        Shape(remedy) => Some((name, remedy)),
        Read | Harmless => None,
    });
    let lost: Vec<(&String, &'static str)> = lost.collect();
    if let Some(&(_, remedy)) = lost.first() {
        const FEW: usize = 4;
        let mut names: Vec<String> = lost.iter().take(FEW).map(|(name, _)| short(name)).collect();
        if lost.len() > FEW {
            names.push(format!("{} more", lost.len() - FEW));
        }
        return Err(BrokenRule::ExtensionRequired {
            extension: names.join(", "),
            remedy,
        });
    }
    let named = document.extensions_used.union(&document.extensions_required);
    for name in named.filter(|name| effect(name) != Read) {
        warnings.name(WarningKind::Extensions, || short(name));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_order_and_each_is_there_once() {
        assert!(
            EXTENSIONS
                .is_sorted_by(|(a, _), (b, _)| { (a.to_ascii_lowercase(), a) < (b.to_ascii_lowercase(), b) })
        );
        assert_eq!(effect("KHR_unheard_of"), UNKNOWN);
    }
}
