//! Errors of reading tiles.

use thiserror::Error;

/// The rule that a tile of 3D Tiles (`.b3dm`, `.i3dm`) violates.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TileError {
    /// The tile is of an unknown version.
    #[error("is a tile of version {0}, but only version 1 exists; export it again")]
    Version(u32),
    /// The header does not say whether the model is embedded.
    #[error(
        "has gltfFormat {0}, but it is 0 for a model in another file and 1 for an embedded one; export the tile again"
    )]
    GltfFormat(u32),
    /// The tile ends before its model.
    #[error("has no model behind its tables; export the tile again")]
    NoModel,
    /// The feature table is not JSON, or a property has the wrong type.
    #[error("its feature table cannot be read: {0}; export the tile again")]
    Features(String),
    /// The feature table lacks a property.
    #[error("its feature table has no {0}; export the tile again")]
    Missing(&'static str),
    /// The feature table lacks a property that another needs.
    #[error("its feature table has {has}, but no {lacks}; export the tile again")]
    Half {
        /// The property that is there.
        has: &'static str,
        /// The missing property.
        lacks: &'static str,
    },
    /// A property has fewer numbers than the instances need.
    #[error(
        "its feature table needs {needs} bytes for {what} of {instances} instances, but has {has} bytes from there; export \
         the tile again"
    )]
    TooShort {
        /// The property.
        what: &'static str,
        /// Number of instances.
        instances: u64,
        /// Bytes that the property needs.
        needs: u128,
        /// Bytes from its start to the end of the table.
        has: u64,
    },
    /// A list in the JSON of the feature table has a wrong length.
    #[error("its feature table lists {has} numbers as {what}, but needs {needs}; export the tile again")]
    ListLength {
        /// The property.
        what: &'static str,
        /// Numbers needed.
        needs: u128,
        /// Numbers in the list.
        has: u64,
    },
    /// The transform of an instance is not finite.
    #[error("instance {0} has a transform that is not finite; correct it, and export the tile again")]
    NotFinite(u64),
    /// The directions of an instance are parallel, or have no length.
    #[error(
        "instance {0} has directions (NORMAL_UP, NORMAL_RIGHT) that are parallel or zero; correct them, and export the tile \
         again"
    )]
    NoRotation(u64),
}
