//! Compiled maps: BSP29 and BSP2 of Quake, IBSP46 of Quake 3.
//!
//! *lumps* knows where in the file things stand, *tree* reads the planes that cut space into leafs, *belongs* finds out whether
//! portals are of this map, and *visibility* writes the lump in which engines look up what is visible.
//! Source: the sources of both engines, as published by id Software, and the files themselves.

mod belongs;
mod error;
mod lumps;
mod tree;
mod visibility;

pub(super) use belongs::clusters_of_leafs;
pub use belongs::{PlacedPortals, place_portals};
pub use error::BspError;
pub(super) use lumps::{Map, word};
pub(super) use tree::{Child, Node, SplitPlane, Tree, in_range, int, number, short};
pub(super) use visibility::check_pairs;
pub use visibility::{visibility_bytes, with_visibility};
