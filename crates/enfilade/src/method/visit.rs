//! Runs a traversal, recorded if its steps are wanted.

use crate::geometry::Geometry;
use crate::order::Order;
#[cfg(feature = "steps")]
use crate::traversal::Recorder;
use crate::traversal::Visit;
use crate::view::passage::Passage;
#[cfg(feature = "steps")]
use crate::view::step_log::StepLog;

/// Emits all faces of the items and openings that may be visible through `passage` to `walk`, and the steps to `log`.
pub(super) fn visit<O: Order>(
    order: &O,
    geometry: &Geometry,
    passage: &Passage,
    scratch: &mut O::Scratch,
    walk: &mut impl Visit,
    #[cfg(feature = "steps")] log: Option<&mut StepLog>,
) {
    #[cfg(feature = "steps")]
    if let Some(log) = log {
        return order.visit(geometry, passage, scratch, &mut Recorder::new(walk, log));
    }
    order.visit(geometry, passage, scratch, walk);
}
