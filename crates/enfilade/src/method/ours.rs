//! A fragment that is content, seen by a method of ours: its items can be edited.

use super::TooLarge;
use crate::content::{Changes, Content, Exchanged};
use crate::fragment::Fragment;
use crate::order::Order;
use std::sync::Arc;

/// A fragment that is content, seen by a method of ours: its items can be edited.
pub(crate) trait Ours: Fragment {
    fn content(&self) -> &Arc<Content>;

    /// Exchanges items for those of `changes`, which then undo it; content that others share becomes a copy first. Where
    /// that needs more than `limit` bytes, nothing is changed.
    fn edit(&mut self, changes: &mut Changes, limit: u64) -> Result<Edited, TooLarge>;
}

/// What an edit came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Edited {
    /// Items that were added, removed, moved or otherwise changed.
    pub items: u64,
    /// Nodes of trees that were touched for it, where orders could follow in place.
    pub nodes: u64,
    /// Fragments whose order could not follow, and was built anew.
    pub rebuilt: u64,
}

impl Edited {
    pub(crate) fn add(&mut self, other: &Edited) {
        self.items += other.items;
        self.nodes += other.nodes;
        self.rebuilt += other.rebuilt;
    }
}

/// Edits a content and has an order over it follow, or builds it anew. Where that, and what `beside` says is needed besides,
/// is more than `limit` bytes, all stays as it was, and the error is how many.
pub(super) fn edit_order<O: Order>(
    order: &mut O,
    content: &mut Arc<Content>,
    changes: &mut Changes,
    limit: u64,
    beside: impl Fn(&Content) -> u64,
) -> Result<(Edited, Exchanged), u64> {
    let edited = Arc::make_mut(content);
    let done = edited.exchange(changes);
    let mut needs = O::needs_bytes(edited) + beside(edited);
    let mut touched = Vec::new();
    let follows = needs <= limit && order.follow(edited, &done.moved, &mut touched);
    if !follows {
        match (needs <= limit).then(|| O::build(edited, limit)).flatten() {
            Some(built) => *order = built,
            None => {
                // What turns out to be more than estimated is twice the limit, as far as is known.
                needs = needs.max(limit.saturating_mul(2));
                edited.exchange(changes);
                return Err(needs);
            }
        }
    }
    let counts = Edited {
        items: done.moved.len() as u64,
        nodes: done.nodes + touched.len() as u64,
        rebuilt: u64::from(!follows),
    };
    Ok((counts, done))
}
