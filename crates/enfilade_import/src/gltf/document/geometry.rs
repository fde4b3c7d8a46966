//! JSON of meshes, accessors, buffer views and buffers.

use super::Attributes;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::borrow::Cow;

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Mesh {
    #[serde(default)]
    pub(in crate::gltf) primitives: Vec<Primitive>,
    /// Weights of the morph targets, for nodes without weights of their own.
    pub(in crate::gltf) weights: Option<Box<[f64]>>,
}

#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Primitive {
    pub(in crate::gltf) attributes: Attributes,
    pub(in crate::gltf) indices: Option<u32>,
    pub(in crate::gltf) material: Option<u32>,
    pub(in crate::gltf) mode: Option<u32>,
    #[serde(default)]
    pub(in crate::gltf) targets: Vec<Attributes>,
    #[serde(default)]
    pub(in crate::gltf) extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub(in crate::gltf) struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub(in crate::gltf) draco: Option<IgnoredAny>,
    #[serde(rename = "KHR_materials_variants")]
    variants: Option<Box<Variants>>,
}

#[derive(Debug, Deserialize)]
struct Variants {
    #[serde(default)]
    mappings: Vec<VariantMaterial>,
}

#[derive(Debug, Deserialize)]
struct VariantMaterial {
    material: u32,
}

impl Primitive {
    /// Returns the materials that the primitive may have instead of its own (`KHR_materials_variants`).
    pub(in crate::gltf) fn variants(&self) -> impl Iterator<Item = u32> {
        let variants = self.extensions.variants.iter();
        variants
            .flat_map(|variants| &variants.mappings)
            .map(|mapping| mapping.material)
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Accessor<'a> {
    pub(in crate::gltf) buffer_view: Option<u32>,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: u64,
    pub(in crate::gltf) component_type: u32,
    #[serde(default)]
    pub(in crate::gltf) normalized: bool,
    pub(in crate::gltf) count: u64,
    #[serde(rename = "type", borrow)]
    pub(in crate::gltf) shape: Cow<'a, str>,
    pub(in crate::gltf) sparse: Option<Box<Sparse>>,
}

/// Replacement values of an accessor.
#[derive(Debug, Deserialize)]
pub(in crate::gltf) struct Sparse {
    pub(in crate::gltf) count: u64,
    pub(in crate::gltf) indices: SparseIndices,
    pub(in crate::gltf) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct SparseIndices {
    pub(in crate::gltf) buffer_view: u32,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: u64,
    pub(in crate::gltf) component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct SparseValues {
    pub(in crate::gltf) buffer_view: u32,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: u64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct BufferView<'a> {
    pub(in crate::gltf) buffer: u32,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: u64,
    pub(in crate::gltf) byte_length: u64,
    pub(in crate::gltf) byte_stride: Option<u64>,
    #[serde(borrow, default)]
    pub(in crate::gltf) extensions: ViewExtensions<'a>,
}

#[derive(Debug, Default, Deserialize)]
pub(in crate::gltf) struct ViewExtensions<'a> {
    #[serde(rename = "EXT_meshopt_compression", borrow)]
    pub(in crate::gltf) meshopt: Option<Box<Compression<'a>>>,
    /// The same under its later name.
    #[serde(rename = "KHR_meshopt_compression", borrow)]
    pub(in crate::gltf) meshopt_khr: Option<Box<Compression<'a>>>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Compression<'a> {
    pub(in crate::gltf) buffer: u32,
    #[serde(default)]
    pub(in crate::gltf) byte_offset: u64,
    pub(in crate::gltf) byte_length: u64,
    pub(in crate::gltf) byte_stride: u64,
    pub(in crate::gltf) count: u64,
    #[serde(borrow)]
    pub(in crate::gltf) mode: Cow<'a, str>,
    #[serde(borrow, default)]
    pub(in crate::gltf) filter: Cow<'a, str>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::gltf) struct Buffer<'a> {
    #[serde(borrow, default)]
    pub(in crate::gltf) uri: Cow<'a, str>,
    pub(in crate::gltf) byte_length: u64,
}
