//! Compiled maps: BSP29 and BSP2 of Quake, IBSP46 of Quake 3.
//!
//! `lumps` locates the lumps and their records, `tree` reads the BSP tree, `belongs` tests whether portals belong to a
//! map, `visibility` encodes the visibility lump, and `rewrite` puts it into the file.
//! Source: the source code of both engines, published by id Software, and the files themselves.

mod belongs;
mod error;
mod lumps;
mod rewrite;
mod tree;
mod visibility;

pub(super) use belongs::clusters_of_leafs;
pub use belongs::{PlacedPortals, place_portals};
pub use error::BspError;
pub(super) use lumps::{Map, word};
pub(super) use tree::{Child, Node, SplitPlane, Tree, in_range, int, number, short};
pub(super) use visibility::check_pairs;
pub use visibility::{visibility_bytes, with_visibility};
