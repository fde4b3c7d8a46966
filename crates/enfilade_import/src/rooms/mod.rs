//! Rooms that portals join: from marked meshes and frames to openings, portals and their sides.
//!
//! Nothing here knows a file format. What stands at the two sides of an opening is found by rays, for boxes overlap:
//! a garden's box holds the whole house. Rays that meet nothing end in the sky, which belongs to rooms without a top.

mod around;
mod frame;
mod join;
mod outline;
mod overlap;
mod sides;
mod sky;

pub(crate) use around::{room_around, room_nearest};
pub(crate) use frame::Frame;
pub(crate) use join::join;

use crate::SourceNodes;
use enfilade::{GeometryBuilder, Mesh, Method, Transform};
use std::sync::Arc;

/// A room before it has openings.
pub(crate) struct Shell {
    pub(crate) name: String,
    /// What messages call it.
    pub(crate) spoken: String,
    pub(crate) builder: GeometryBuilder,
    pub(crate) method: Option<Method>,
    pub(crate) nodes: SourceNodes,
}

/// A placed mesh that someone marked as an opening.
pub(crate) struct Marked {
    pub(crate) name: String,
    /// What messages call it.
    pub(crate) spoken: String,
    pub(crate) mesh: Arc<Mesh>,
    pub(crate) world: Transform,
    /// The room that it belongs to.
    pub(crate) owner: Option<usize>,
    pub(crate) way: Way,
}

/// Where an opening leads. Rooms are given by their places in the list of all.
pub(crate) enum Way {
    /// To the other side; `to` where the author says which room that is.
    Door {
        to: Option<usize>,
        one_way: bool,
    },
    Teleport(Box<Teleport>),
    /// Back into the room.
    Mirror,
}

/// In along −Z of `from`, out along −Z of `exit`.
pub(crate) struct Teleport {
    pub(crate) from: Frame,
    pub(crate) exit: Frame,
    /// What the exit is called.
    pub(crate) exit_name: String,
    /// The room that it leads to, where the author or the exit's ancestors say so.
    pub(crate) to: Option<usize>,
}
