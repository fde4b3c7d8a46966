//! Sectors whose items and openings can be edited.

use crate::geometry::{Changes, Geometry};
use crate::order::Order;
use crate::sector::Sector;
use crate::unsuited::Unsuited;
use std::sync::Arc;

/// A sector with geometry and a built-in method, whose items and openings can be edited.
pub(crate) trait EditableSector: Sector {
    fn geometry(&self) -> &Arc<Geometry>;

    /// Swaps items and openings of the geometry with those of `changes`, so that another call undoes the edit. A shared
    /// geometry is copied first. If the result needs more than `limit` bytes or violates the requirement of the method,
    /// nothing changes.
    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<EditStats, Unsuited>;
}

/// Statistics of an edit: items changed, tree nodes touched, sectors rebuilt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct EditStats {
    /// Number of items added, removed, moved or otherwise changed.
    pub items: u64,
    /// Number of tree nodes touched, in sectors whose order was updated in place.
    pub nodes: u64,
    /// Number of sectors whose order was rebuilt.
    pub rebuilt: u64,
}

impl EditStats {
    pub(crate) fn add(&mut self, other: &EditStats) {
        self.items += other.items;
        self.nodes += other.nodes;
        self.rebuilt += other.rebuilt;
    }
}

/// Applies changes to a geometry and updates its order in place, or rebuilds the order where it cannot be updated. If
/// that and the bytes returned by `beside` exceed `limit`, or the order cannot be built, nothing changes.
pub(super) fn edit_order<O: Order>(
    order: &mut O,
    geometry: &mut Arc<Geometry>,
    changes: &mut Changes,
    limit: u64,
    beside: impl Fn(&Geometry) -> u64,
) -> Result<EditStats, Unsuited> {
    let edited = Arc::make_mut(geometry);
    edited.exchange(changes);
    let needs = O::needs_bytes(edited) + beside(edited);
    let is_outdated = O::INCLUDES_OPENINGS && changes.openings().is_some();
    let done = &mut changes.exchanged;
    done.touched.clear();
    let follows = needs <= limit && !is_outdated && order.follow(edited, &done.moved, &mut done.touched);
    if !follows {
        let built = if needs <= limit {
            O::build(edited, limit)
        } else {
            Err(Unsuited::TooLarge {
                needs_bytes: needs,
                limit,
            })
        };
        match built {
            Ok(built) => *order = built,
            Err(why) => {
                edited.exchange(changes);
                return Err(why);
            }
        }
    }
    let done = &changes.exchanged;
    Ok(EditStats {
        items: done.moved.len() as u64,
        nodes: done.nodes + done.touched.len() as u64,
        rebuilt: u64::from(!follows),
    })
}
