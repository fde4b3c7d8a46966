//! Joins rooms by portals: finds the openings of marked meshes and the rooms on their two sides.
//!
//! Independent of file formats. The rooms on both sides of an opening are found by ray casts, because AABBs overlap:
//! the AABB of a garden contains the whole house. A point-in-volume test would not work either, because rooms are
//! seldom closed. Rays that hit nothing end in the sky, which belongs to rooms without a ceiling; otherwise a roof
//! window would lead nowhere.

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

use crate::{NonOccluders, SourceNodes};
use enfilade::{GeometryBuilder, Mesh, Method, Transform};
use std::sync::Arc;

/// A room before its openings are added.
pub(crate) struct Shell {
    pub(crate) name: String,
    /// Name of the room in messages.
    pub(crate) spoken: String,
    pub(crate) builder: GeometryBuilder,
    pub(crate) method: Option<Method>,
    pub(crate) nodes: SourceNodes,
    pub(crate) non_occluders: NonOccluders,
}

/// Transformed meshes that the author marked as an opening; together they are its polygon.
pub(crate) struct MarkedMesh {
    pub(crate) name: String,
    /// Name of the opening in messages.
    pub(crate) spoken: String,
    pub(crate) faces: Vec<(Arc<Mesh>, Transform)>,
    /// The room that contains its node.
    pub(crate) owner: Option<usize>,
    pub(crate) way: OpeningTarget,
}

/// The target of an opening. Rooms are indices.
pub(crate) enum OpeningTarget {
    /// To the room on the other side; `to` if the author names it.
    Door {
        to: Option<usize>,
        one_way: bool,
    },
    Teleport(Box<Teleport>),
    /// Back into the same room, reflected.
    Mirror,
}

/// Enters along −Z of `from`, leaves along −Z of `exit`.
pub(crate) struct Teleport {
    pub(crate) from: Frame,
    pub(crate) exit: Frame,
    /// Factor by which it enlarges what passes.
    pub(crate) scale: f64,
    /// Name of the exit in messages.
    pub(crate) exit_name: String,
    /// The target room, if the author names it or the exit is below it.
    pub(crate) to: Option<usize>,
}
