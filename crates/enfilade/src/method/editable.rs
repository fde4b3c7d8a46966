//! A sector that is geometry, seen by a method of ours: its items can be edited.

use super::{Method, TooLarge, Unsuited};
use crate::geometry::{Changes, Exchanged, Geometry};
use crate::order::Order;
use crate::sector::Sector;
use std::sync::Arc;

/// A sector that is geometry, seen by a method of ours: its items can be edited.
pub(crate) trait EditableSector: Sector {
    fn geometry(&self) -> &Arc<Geometry>;

    /// Exchanges items for those of `changes`, which then undo it; geometry that others share becomes a copy first. Where
    /// that needs more than `limit` bytes, or leaves what the method cannot see, nothing is changed.
    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited>;
}

/// What an edit came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct EditStats {
    /// Items that were added, removed, moved or otherwise changed.
    pub items: u64,
    /// Nodes of trees that were touched for it, where orders could follow in place.
    pub nodes: u64,
    /// Sectors whose order could not follow, and was built anew.
    pub rebuilt: u64,
}

impl EditStats {
    pub(crate) fn add(&mut self, other: &EditStats) {
        self.items += other.items;
        self.nodes += other.nodes;
        self.rebuilt += other.rebuilt;
    }
}

/// Edits a geometry and has an order over it follow, or builds it anew. Where that, and what `beside` says is needed besides,
/// is more than `limit` bytes, or the order cannot be built, all stays as it was.
pub(super) fn edit_order<O: Order>(
    method: Method,
    order: &mut O,
    geometry: &mut Arc<Geometry>,
    changes: &mut Changes,
    limit: u64,
    beside: impl Fn(&Geometry) -> u64,
) -> Result<(EditStats, Exchanged), Unsuited> {
    let edited = Arc::make_mut(geometry);
    let done = edited.exchange(changes);
    let needs = O::needs_bytes(edited) + beside(edited);
    let mut touched = Vec::new();
    let follows = needs <= limit && order.follow(edited, &done.moved, &mut touched);
    if !follows {
        let built = if needs <= limit {
            O::build(edited, limit).map_err(|refusal| Unsuited::of(method, edited, refusal, limit))
        } else {
            Err(TooLarge::new(method, needs, limit).into())
        };
        match built {
            Ok(built) => *order = built,
            Err(why) => {
                edited.exchange(changes);
                return Err(why);
            }
        }
    }
    let counts = EditStats {
        items: done.moved.len() as u64,
        nodes: done.nodes + touched.len() as u64,
        rebuilt: u64::from(!follows),
    };
    Ok((counts, done))
}
