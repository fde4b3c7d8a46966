//! Errors of compiled maps.

use enfilade_bake::CellsError;
use thiserror::Error;

/// The rule that a compiled map violates, or the reason why no visibility can be written into it.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BspError {
    /// The file is not a compiled map.
    #[error(
        "is not a compiled map of a known format (BSP29, BSP2 or IBSP46): it {begins}; name a .bsp of Quake or Quake 3"
    )]
    NotMap {
        /// First bytes of the file: "begins with `…`", or "is empty".
        begins: String,
    },
    /// A lump or header exceeds the file.
    #[error("is damaged: {part} ends after the end of the file at byte {has}; compile the map again")]
    CutShort {
        /// The lump or header.
        part: String,
        /// Length of the file, in bytes.
        has: usize,
    },
    /// The size of a lump is not a multiple of its record size.
    #[error(
        "is damaged: its lump {lump} has {bytes} bytes, not a multiple of its record size {of}; compile the map again"
    )]
    OddLump {
        /// Index of the lump, from 0.
        lump: usize,
        /// Size of the lump, in bytes.
        bytes: usize,
        /// Size of a record, in bytes.
        of: usize,
    },
    /// A lump that is to be changed shares bytes with another block.
    #[error("is damaged: its lump {lump} overlaps {other}; compile the map again")]
    Overlap {
        /// Index of the lump, from 0.
        lump: usize,
        /// The other block, such as "its lump 3" or "its BSPX block BRUSHLIST".
        other: String,
    },
    /// The map would be longer than its signed 32-bit offsets can say.
    #[error("would have {bytes} bytes with its PVS, but offsets of its format end at 2 GiB; split the map")]
    TooLong {
        /// Length of the file, in bytes.
        bytes: usize,
    },
    /// An index is out of range.
    #[error(
        "is damaged: {what} {at} names {names} {number}, but there are {count}, counted from 0; compile the map again"
    )]
    NoSuch {
        /// Kind of the record that holds the index.
        what: &'static str,
        /// Index of that record, from 0.
        at: usize,
        /// Kind of the referenced record.
        names: &'static str,
        /// The index that is out of range.
        number: i64,
        /// Number of records of that kind.
        count: usize,
    },
    /// A plane has no valid normal or distance.
    #[error("is damaged: plane {plane} has an invalid normal or distance; compile the map again")]
    NoPlane {
        /// Index of the plane, from 0.
        plane: usize,
    },
    /// The nodes form a cycle or share a child.
    #[error("is damaged: node {node} is reached twice from the root; compile the map again")]
    Loop {
        /// Index of the node, from 0.
        node: u32,
    },
    /// A leaf has two parents.
    #[error("is damaged: leaf {leaf} has two parent nodes; compile the map again")]
    LeafTwice {
        /// Index of the leaf, from 0.
        leaf: u32,
    },
    /// No valid portals can be generated from the planes.
    #[error("is damaged: its planes give no valid portals ({0}); compile the map again")]
    NoPortals(#[from] CellsError),
    /// The entity lump does not match `{ "key" "value" … }`.
    #[error(
        "is damaged: its entities have {found} where {wanted} is expected, in line {line}; compile the map again"
    )]
    BadEntities {
        /// Line of the entity text, from 1.
        line: usize,
        /// The text that was found.
        found: String,
        /// The text that is expected.
        wanted: &'static str,
    },
    /// A coordinate is NaN or infinite.
    #[error("is damaged: {what} {at} has a coordinate that is not finite; compile the map again")]
    NotFinite {
        /// Kind of the record.
        what: &'static str,
        /// Index of the record, from 0.
        at: usize,
    },
    /// The control-point grid of a patch has an invalid size.
    #[error(
        "is damaged: face {face} is a patch of {} by {} control points; both must be odd and at least 3; compile the map again",
        size[0], size[1]
    )]
    BadPatch {
        /// Index of the face, from 0.
        face: usize,
        /// Control points per row and per column.
        size: [i32; 2],
    },
    /// A PVS row exceeds the visibility lump.
    #[error(
        "is damaged: the PVS row of {from} {at} ends after its lump, which has {has} bytes; run vis again"
    )]
    RowCutShort {
        /// "leaf" or "cluster".
        from: &'static str,
        /// Its index, from 0.
        at: usize,
        /// Size of the lump, in bytes.
        has: usize,
    },
    /// The portals belong to another map, or to another run of the compiler.
    #[error(
        "has {map} {what}, but its portals have {portals}: they are of another map; compile the map again"
    )]
    OtherMap {
        /// The count in the map.
        map: i64,
        /// The count in the portal file.
        portals: usize,
        /// "leafs" or "clusters".
        what: &'static str,
    },
    /// The portals belong to another map that has the same number of leafs or clusters.
    #[error("matches only {fit} of its {portals} portals: they are of another map; compile the map again")]
    OtherPlaces {
        /// Portals that are between the leafs they name.
        fit: usize,
        /// Number of portals.
        portals: usize,
    },
    /// The visible pairs belong to other portals.
    #[error(
        "gets visible pairs of {pairs} cells, but its portals have {clusters} clusters; compute the pairs from these portals"
    )]
    OtherPairs {
        /// Number of cells of the pairs.
        pairs: u32,
        /// Number of clusters of the portals.
        clusters: u32,
    },
}
