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
    /// It stores numbers in a way that is not read: only primitives without a plain copy of theirs are lost.
    Storage(&'static str),
}

use Effect::{Harmless, Read, Shape, Storage};

/// What an unknown extension may change.
const UNKNOWN: Effect = Shape("export it again without");

/// The extensions of the registry of Khronos, with drafts and archived ones, and some of engines, by name.
const EXTENSIONS: &[(&str, Effect)] = &[
    ("ADOBE_materials_clearcoat_specular", Harmless), // Shading of an opaque surface.
    ("ADOBE_materials_clearcoat_tint", Harmless),     // Shading of an opaque surface.
    (
        "ADOBE_materials_thin_transparency",
        Shape("its materials are transparent by it; export it again without"),
    ),
    (
        "ADOBE_render_order",
        Shape("it changes what is drawn over what; export it again without"),
    ),
    (
        "AGI_articulations",
        Shape("its parts are moved by it; export it again without"),
    ),
    ("AGI_metadata", Harmless),     // Metadata.
    ("AGI_stk_metadata", Harmless), // Metadata.
    (
        "BENTLEY_materials_planar_fill",
        Shape("it changes what is drawn over what; export it again without"),
    ),
    ("BENTLEY_materials_point_style", Harmless), // Points are not drawn.
    (
        "BENTLEY_primitive_restart",
        Shape("where its triangle strips end is lost; export it again as triangle lists"),
    ),
    (
        "CESIUM_binary_glTF",
        Shape("it belongs to glTF 1.0; convert the file to glTF 2.0"),
    ),
    (
        "CESIUM_geopose",
        Shape("its place is lost; export it again without"),
    ),
    ("CESIUM_primitive_outline", Harmless), // Lines over the triangles.
    ("CESIUM_RTC", Shape("its place is lost; export it again without")),
    ("CESIUM_tile_edges", Harmless), // Lines over the triangles.
    (
        "CESIUM_z_up",
        Shape("its direction is lost; export it again without"),
    ),
    ("CVTOOLS_unity_metadata", Harmless), // Metadata.
    (
        "DRACO_animation_compression",
        Shape("what it moves is not known; export it again without"),
    ),
    ("EXT_3d_metadata", Harmless), // Metadata.
    (
        "EXT_accessor_additional_types",
        Storage("its numbers are of types that are not read; export it again with floats of 32 bits"),
    ),
    ("EXT_animation_quantization", Harmless), // Values of animations; their targets are read.
    ("EXT_animation_sqlerp", Harmless),       // Values of animations; their targets are read.
    (
        "EXT_blend",
        Shape("its materials are blended by it; export it again without"),
    ),
    ("EXT_camera_physical", Harmless),  // Cameras.
    ("EXT_feature_metadata", Harmless), // Metadata.
    ("EXT_geopose", Shape("its place is lost; export it again without")),
    ("EXT_image_webp", Harmless), // Pixels of textures.
    (
        "EXT_implicit_cylinder_region",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    (
        "EXT_implicit_ellipsoid_region",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    ("EXT_instance_features", Harmless),             // Metadata.
    ("EXT_lights_area", Harmless),                   // Lights and backgrounds.
    ("EXT_lights_environment", Harmless),            // Lights and backgrounds.
    ("EXT_lights_ies", Harmless),                    // Lights and backgrounds.
    ("EXT_lights_image_based", Harmless),            // Lights and backgrounds.
    ("EXT_manifold", Harmless),                      // Says that a mesh is closed.
    ("EXT_materials_anisotropy_openpbr", Harmless),  // Shading of an opaque surface.
    ("EXT_materials_bump", Harmless),                // Shading of an opaque surface.
    ("EXT_materials_clearcoat_color", Harmless),     // Shading of an opaque surface.
    ("EXT_materials_clearcoat_darkening", Harmless), // Shading of an opaque surface.
    ("EXT_materials_diffuse_roughness", Harmless),   // Shading of an opaque surface.
    ("EXT_materials_dispersion", Harmless),          // Has an effect only with transmission, which is read.
    ("EXT_materials_specular_edge_color", Harmless), // Shading of an opaque surface.
    ("EXT_materials_specular_openpbr", Harmless),    // Shading of an opaque surface.
    ("EXT_mesh_features", Harmless),                 // Metadata.
    ("EXT_mesh_gpu_instancing", Read),               // Each instance is an item.
    (
        "EXT_mesh_lod",
        Shape("which of its levels is drawn is not known; export it again without"),
    ),
    ("EXT_mesh_manifold", Harmless), // Says that a mesh is closed.
    (
        "EXT_mesh_opacity_micromap",
        Shape("its triangles may have holes; export it again without"),
    ),
    ("EXT_mesh_polygon", Harmless), // Says which triangles are a polygon.
    ("EXT_mesh_primitive_edge_visibility", Harmless), // Lines over the triangles.
    (
        "EXT_mesh_primitive_restart",
        Shape("where its triangle strips end is lost; export it again as triangle lists"),
    ),
    ("EXT_meshopt_compression", Read), // Decoded.
    (
        "EXT_node_lod",
        Shape("which of its levels is drawn is not known; export it again without"),
    ),
    ("EXT_pbr_attributes", Harmless), // Shading by vertex.
    (
        "EXT_primitive_voxels",
        Shape("its voxels are lost; export it again as triangles"),
    ),
    (
        "EXT_property_animation",
        Shape("a program moves its nodes; export it again without"),
    ),
    ("EXT_structural_metadata", Harmless),         // Metadata.
    ("EXT_texture_astc", Harmless),                // Pixels of textures.
    ("EXT_texture_astc_hdr", Harmless),            // Pixels of textures.
    ("EXT_texture_avif", Harmless),                // Pixels of textures.
    ("EXT_texture_bc6h", Harmless),                // Pixels of textures.
    ("EXT_texture_procedurals", Harmless),         // Pixels of textures.
    ("EXT_texture_procedurals_mx_1_39", Harmless), // Pixels of textures.
    ("EXT_texture_qoi", Harmless),                 // Pixels of textures.
    ("EXT_texture_svg", Harmless),                 // Pixels of textures.
    ("EXT_texture_video", Harmless),               // Pixels of textures.
    ("EXT_texture_webp", Harmless),                // Pixels of textures.
    (
        "EXT_volumetricvideo",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    (
        "FB_asset_variants",
        Shape("which of its variants is drawn is not known; export it again without"),
    ),
    ("FB_geometry_metadata", Harmless), // Metadata.
    (
        "FB_material_variants",
        Shape("its other materials may be transparent; export it again without"),
    ),
    ("FB_materials_lightmap", Harmless), // Light that was computed ahead.
    ("FB_materials_modmap", Harmless),   // Light that was computed ahead.
    ("FB_ngon_encoding", Harmless),      // Says which triangles are a polygon.
    (
        "FRAUNHOFER_external_model",
        Shape("its other files are not read; join them into one"),
    ),
    ("GODOT_single_root", Harmless),   // Says that the scene has one root.
    ("GOOGLE_backgrounds", Harmless),  // Lights and backgrounds.
    ("GRIFFEL_bim_data", Harmless),    // Metadata.
    ("INTEL_lights_sunsky", Harmless), // Lights and backgrounds.
    (
        "KHR_accessor_float16",
        Storage("its numbers are of types that are not read; export it again with floats of 32 bits"),
    ),
    (
        "KHR_accessor_float64",
        Storage("its numbers are of types that are not read; export it again with floats of 32 bits"),
    ),
    ("KHR_animation_pointer", Read), // What it changes hides nothing.
    ("KHR_audio", Harmless),         // Sound.
    ("KHR_audio_emitter", Harmless), // Sound.
    ("KHR_audio_graph", Harmless),   // Sound.
    (
        "KHR_behavior",
        Shape("a program moves its nodes; export it again without"),
    ),
    (
        "KHR_billboard",
        Shape("its nodes turn to the camera; export it again without"),
    ),
    (
        "KHR_binary_glTF",
        Shape("it belongs to glTF 1.0; convert the file to glTF 2.0"),
    ),
    (
        "KHR_blend",
        Shape("its materials are blended by it; export it again without"),
    ),
    ("KHR_character", Harmless),        // Says what the parts of a body are.
    ("KHR_collision_shapes", Harmless), // Shapes of bodies for physics, which are not drawn.
    (
        "KHR_draco_mesh_compression",
        Storage("export it again without compression"),
    ),
    (
        "KHR_gaussian_splatting",
        Shape("its splats are lost; export it again as triangles"),
    ),
    (
        "KHR_gaussian_splatting_compression_spz",
        Shape("its splats are lost; export it again as triangles"),
    ),
    (
        "KHR_gaussian_splatting_compression_spz_2",
        Shape("its splats are lost; export it again as triangles"),
    ),
    ("KHR_image_ktx2", Harmless),      // Pixels of textures.
    ("KHR_implicit_shapes", Harmless), // Shapes of bodies for physics, which are not drawn.
    (
        "KHR_interactivity",
        Shape("a program moves its nodes; export it again without"),
    ),
    ("KHR_lights_area", Harmless),          // Lights and backgrounds.
    ("KHR_lights_environment", Harmless),   // Lights and backgrounds.
    ("KHR_lights_image_based", Harmless),   // Lights and backgrounds.
    ("KHR_lights_punctual", Read),          // Read as lights.
    ("KHR_materials_anisotropy", Harmless), // Shading of an opaque surface.
    ("KHR_materials_clearcoat", Harmless),  // Shading of an opaque surface.
    ("KHR_materials_coat", Harmless),       // Shading of an opaque surface.
    (
        "KHR_materials_common",
        Shape("it belongs to glTF 1.0; convert the file to glTF 2.0"),
    ),
    ("KHR_materials_diffuse_roughness", Harmless), // Shading of an opaque surface.
    ("KHR_materials_diffuse_transmission", Read),  // Such materials hide nothing.
    ("KHR_materials_dispersion", Read),            // Such materials hide nothing.
    ("KHR_materials_emissive_strength", Read),     // Applied.
    ("KHR_materials_fuzz", Harmless),              // Shading of an opaque surface.
    ("KHR_materials_ior", Harmless),               // Shading of an opaque surface.
    ("KHR_materials_iridescence", Harmless),       // Shading of an opaque surface.
    ("KHR_materials_parallax_mapping", Harmless),  // Displaces texture coordinates, not the surface.
    ("KHR_materials_pbrSpecularGlossiness", Harmless), // Another shading model; the alpha mode is that of the material.
    ("KHR_materials_sheen", Harmless),                 // Shading of an opaque surface.
    ("KHR_materials_specular", Harmless),              // Shading of an opaque surface.
    ("KHR_materials_subsurface", Read),                // Such materials hide nothing.
    ("KHR_materials_transmission", Read),              // Blended.
    ("KHR_materials_unlit", Read),                     // Applied.
    ("KHR_materials_variants", Read),                  // Hides only if all variants are opaque.
    ("KHR_materials_volume", Read),                    // Such materials hide nothing.
    ("KHR_materials_volume_scatter", Read),            // Such materials hide nothing.
    ("KHR_mesh_quantization", Read),                   // Decoded.
    ("KHR_meshopt_compression", Read),                 // Decoded.
    ("KHR_node_hoverability", Harmless),               // What a pointer may select.
    ("KHR_node_selectability", Harmless),              // What a pointer may select.
    ("KHR_node_visibility", Read),                     // Invisible nodes are not drawn.
    (
        "KHR_physics_rigid_bodies",
        Shape("bodies fall by it; export it again without"),
    ),
    (
        "KHR_techniques_webgl",
        Shape("its own shaders may move or discard anything; export it again without"),
    ),
    ("KHR_texture_basisu", Harmless),      // Pixels of textures.
    ("KHR_texture_procedurals", Harmless), // Pixels of textures.
    ("KHR_texture_transform", Read),       // Applied.
    ("KHR_texture_video", Harmless),       // Pixels of textures.
    ("KHR_xmp", Harmless),                 // Metadata.
    ("KHR_xmp_json_ld", Harmless),         // Metadata.
    (
        "KITTYCAD_boundary_representation",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    (
        "MANYFOLD_mesh_progressive",
        Shape("its shapes are lost; export it again as triangles"),
    ),
    (
        "MAXAR_mesh_variants",
        Shape("which of its variants is drawn is not known; export it again without"),
    ),
    (
        "MESHOPT_compression",
        Shape(
            "it is compressed by a draft; export it again with EXT_meshopt_compression, or without compression",
        ),
    ),
    (
        "MOZ_alt_materials",
        Shape("its other materials may be transparent; export it again without"),
    ),
    ("MOZ_lightmap", Harmless), // Light that was computed ahead.
    (
        "MPEG_accessor_timed",
        Shape("its shapes change over time; export it again without"),
    ),
    (
        "MPEG_anchor",
        Shape("its nodes are placed in the real world; export it again without"),
    ),
    (
        "MPEG_animation_timing",
        Shape("its shapes change over time; export it again without"),
    ),
    ("MPEG_audio_spatial", Harmless), // Sound.
    (
        "MPEG_buffer_circular",
        Shape("its shapes change over time; export it again without"),
    ),
    ("MPEG_haptic", Harmless),          // Touch, media and views.
    ("MPEG_haptic_material", Harmless), // Touch, media and views.
    ("MPEG_media", Harmless),           // Touch, media and views.
    (
        "MPEG_mesh_linking",
        Shape("its shapes change over time; export it again without"),
    ),
    (
        "MPEG_scene_dynamic",
        Shape("its shapes change over time; export it again without"),
    ),
    ("MPEG_texture_video", Harmless),                   // Pixels of textures.
    ("MPEG_viewport_recommended", Harmless),            // Touch, media and views.
    ("MSFT_audio_emitter", Harmless),                   // Sound.
    ("MSFT_lod", Read),                                 // The finest level is drawn, and hides nothing.
    ("MSFT_packing_normalRoughnessMetallic", Harmless), // Textures of other maps.
    ("MSFT_packing_occlusionRoughnessMetallic", Harmless), // Textures of other maps.
    ("MSFT_texture_dds", Harmless),                     // Pixels of textures.
    ("NEEDLE_lightmaps", Harmless),                     // Light that was computed ahead.
    (
        "NEEDLE_techniques_webgl",
        Shape("its own shaders may move or discard anything; export it again without"),
    ),
    (
        "NV_materials_mdl",
        Shape("its own shaders may be transparent; export it again without"),
    ),
    ("OMI_audio_emitter", Harmless),    // Sound.
    ("OMI_audio_ogg_vorbis", Harmless), // Sound.
    ("OMI_collider", Harmless),         // For collisions.
    ("OMI_environment_sky", Harmless),  // Lights and backgrounds.
    ("OMI_link", Harmless),             // Where to go from here.
    ("OMI_personality", Harmless),      // What a person says.
    (
        "OMI_physics_body",
        Shape("bodies fall by it; export it again without"),
    ),
    ("OMI_physics_gravity", Harmless),  // Of bodies.
    ("OMI_physics_shape", Harmless),    // For collisions.
    ("OMI_seat", Harmless),             // Where to sit.
    ("OMI_spawn_point", Harmless),      // Where to begin.
    ("VRMC_materials_mtoon", Harmless), // Shading; the alpha mode is that of the material.
    (
        "VRMC_node_constraint",
        Shape("its nodes are moved by it; export it again without"),
    ),
    (
        "VRMC_springBone",
        Shape("its nodes are moved by it; export it again without"),
    ),
    ("VRMC_vrm", Harmless), // Says what the parts of a body are.
    (
        "WEB3D_quantized_attributes",
        Shape("it belongs to glTF 1.0; convert the file to glTF 2.0"),
    ),
];

fn effect(name: &str) -> Effect {
    let known = EXTENSIONS.iter().find(|(known, _)| *known == name);
    known.map_or(UNKNOWN, |&(_, effect)| effect)
}

/// Returns `true` if shapes, or what is drawn, may be others by an extension than in the file without it.
pub(super) fn changes_shapes(name: &str) -> bool {
    matches!(effect(name), Shape(_))
}

/// Returns an error if the file requires an extension without which shapes would be wrong, unless `lenient`; adds a warning for
/// each other one that is not read.
pub(super) fn check(document: &Document, lenient: bool, warnings: &mut Warnings) -> Result<(), BrokenRule> {
    let required = document.extensions_required.iter();
    let lost = required.filter_map(|name| match effect(name) {
        Shape(remedy) | Storage(remedy) => Some((name, remedy)),
        Read | Harmless => None,
    });
    let lost: Vec<(&String, &'static str)> = lost.collect();
    if let Some(&(_, remedy)) = lost.first().filter(|_| !lenient) {
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
