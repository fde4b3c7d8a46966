//! Bakes potentially visible sets (PVS): from-region visibility between convex cells joined by convex portals.
//!
//! ```
//! use enfilade_bake::{Cells, PairsOptions, Portal, VisiblePairs};
//!
//! // Three rooms in a row, with a 2 × 2 door between neighbours.
//! let door = |x: f64, cells| Portal {
//!     corners: vec![[x, -1.0, 0.0], [x, 1.0, 0.0], [x, 1.0, 2.0], [x, -1.0, 2.0]],
//!     cells,
//! };
//! let rooms = Cells::new(3, vec![door(10.0, [0, 1]), door(20.0, [1, 2])])?;
//! let pairs = VisiblePairs::compute(&rooms, &PairsOptions::default())?;
//! assert!(pairs.may_see(0, 2));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Cells`] holds convex cells and their portals. [`VisiblePairs`] is the PVS: for each pair of cells, whether any
//! point of one may see any point of the other. It is an upper bound: a pair that can see each other is never left out.
//! [`PairsWork`] computes it in steps, can be stopped, saved and resumed, and can share the longest stage with other
//! machines ([`FlowPart`]). [`find_missing`] tests a PVS with random
//! rays. It shares no code with the computation and returns a [`Witness`] for a missing pair.
//!
//! [`find_rooms`] finds the rooms, doors and windows of a building in its triangles, and [`RoomGraph`] answers what games
//! ask: which room a point is in, ways, sound, and which rooms may see each other.
#![cfg_attr(docsrs, feature(doc_cfg))]
#![forbid(unsafe_code)]

mod aim;
mod between;
mod bits;
mod cells;
mod first_bound;
mod flow;
mod known;
mod line;
mod pairs;
mod passages;
mod random;
mod rooms;
mod saved;
mod separators;
mod shards;
mod ways;
mod winding;
mod work;

pub use cells::{Cells, CellsError, Portal};

pub use line::{Witness, find_missing};
pub use pairs::{PairsOptions, VisiblePairs};
pub use rooms::{
    AuthoredDoor, AuthoredRooms, Door, DoorId, DoorKind, DoorSuggestion, FaceAreas, FoundRooms, Room,
    RoomChange, RoomFileError, RoomGraph, RoomId, RoomItem, RoomMesh, RoomOptions, RoomPath, RoomTracker,
    RoomVoxels, RoomsError, RoomsInput, SoundLoss, Up, detect_metres_per_unit, detect_up, find_rooms,
    find_rooms_among, is_door_name, metres_per_unit_of,
};
pub use saved::ResumeError;
pub use shards::{FlowPart, PartError, Shard};
pub use work::{PairsWork, Stage, TooLarge};
