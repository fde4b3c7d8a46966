//! Why a compiled map is not read, or gets no visibility.

use enfilade_bake::CellsError;
use thiserror::Error;

/// Why a compiled map is not read, or gets no visibility.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BspError {
    /// Another kind of file.
    #[error(
        "is no compiled map of a known kind (BSP29, BSP2 or IBSP46): it {begins}; name a .bsp of Quake or Quake 3"
    )]
    NotMap {
        /// What it begins with: "begins with `…`", or "is empty".
        begins: String,
    },
    /// A part that should be there ends past the file's end.
    #[error("is damaged: {part} ends after the file's end, which is at byte {has}; compile the map again")]
    CutShort {
        /// Which part.
        part: String,
        /// Bytes that are there.
        has: usize,
    },
    /// A lump that is not made of whole things.
    #[error(
        "is damaged: its lump {lump} has {bytes} bytes, where each thing in it takes {of}; compile the map again"
    )]
    OddLump {
        /// Which lump, from 0.
        lump: usize,
        /// Its bytes.
        bytes: usize,
        /// Those of a thing.
        of: usize,
    },
    /// A number that names nothing.
    #[error(
        "is damaged: {what} {at} names {names} {number}, but there are {count}, counted from 0; compile the map again"
    )]
    NoSuch {
        /// What names it.
        what: &'static str,
        /// Which of those, from 0.
        at: usize,
        /// What is named.
        names: &'static str,
        /// Which.
        number: i64,
        /// How many there are.
        count: usize,
    },
    /// A plane that is none.
    #[error("is damaged: plane {plane} has no direction, or is nowhere; compile the map again")]
    NoPlane {
        /// Which plane, from 0.
        plane: usize,
    },
    /// Nodes that lead back.
    #[error("is damaged: node {node} is met twice on the way down; compile the map again")]
    Loop {
        /// Which node, from 0.
        node: u32,
    },
    /// A leaf in two parts of the world.
    #[error("is damaged: leaf {leaf} stands in two places; compile the map again")]
    LeafTwice {
        /// Which leaf, from 0.
        leaf: u32,
    },
    /// Planes that no portal between them can be made of.
    #[error("is damaged: no portals can be made of its planes ({0}); compile the map again")]
    NoPortals(#[from] CellsError),
    /// Entities that are no `{ "key" "value" … }`.
    #[error(
        "is damaged: its entities have {found} where {wanted} is wanted, in line {line}; compile the map again"
    )]
    BadEntities {
        /// Which line of their text, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What should.
        wanted: &'static str,
    },
    /// A number that is NaN or infinite.
    #[error("is damaged: {what} {at} is not at a finite place; compile the map again")]
    NotFinite {
        /// What it is of.
        what: &'static str,
        /// Which of those, from 0.
        at: usize,
    },
    /// A patch that is no grid of patches with three corners a side.
    #[error(
        "is damaged: face {face} is a patch of {} by {} corners, which must be odd numbers from 3; compile the map again",
        size[0], size[1]
    )]
    BadPatch {
        /// Which face, from 0.
        face: usize,
        /// Corners in a row, and in a column.
        size: [i32; 2],
    },
    /// A row of what is visible that ends after the lump.
    #[error(
        "is damaged: what is visible from {from} {at} ends after its lump, which has {has} bytes; run vis again"
    )]
    RowCutShort {
        /// A leaf or a cluster.
        from: &'static str,
        /// Which of those, from 0.
        at: usize,
        /// Bytes of the lump.
        has: usize,
    },
    /// The portals are of another map, or of another run of the compiler.
    #[error("has {map} {what}, its portals are of {portals}: they are of another map; compile the map again")]
    OtherMap {
        /// How many the map has.
        map: i64,
        /// How many the portals say.
        portals: usize,
        /// Leafs or clusters.
        what: &'static str,
    },
    /// The portals are of another map, though of as many leafs or clusters.
    #[error(
        "has {fit} of its {portals} portals in their places: they are of another map; compile the map again"
    )]
    OtherPlaces {
        /// Portals between the leafs that they say.
        fit: usize,
        /// How many there are.
        portals: usize,
    },
    /// The pairs are of other portals.
    #[error(
        "gets pairs of {pairs} cells, but its portals are of {clusters} clusters; compute the pairs of these portals"
    )]
    OtherPairs {
        /// Cells of the pairs.
        pairs: u32,
        /// Clusters of the portals.
        clusters: u32,
    },
}
