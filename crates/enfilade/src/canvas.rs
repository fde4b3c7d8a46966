//! Receives what is seen.

use crate::content::Owner;
use crate::passage::{Passage, PassageId};

/// Receives what is seen, a row of spans at a time: an image, a list of items, a picture of the overdraw.
pub trait Canvas {
    /// The rows that follow are seen through this passage.
    ///
    /// Called again when painting comes back from behind an opening, to put glass over what was seen there.
    fn enter(&mut self, id: PassageId, passage: &Passage);

    /// Spans of row `y`, none of which overlap, left to right. Glass comes after all that is behind it.
    fn row(&mut self, y: u16, spans: &[Span]);

    /// Should covers count how they came to their answer? Then [`Canvas::work`] gets it.
    fn wants_work(&self) -> bool {
        false
    }

    /// Row `y` from column `x0` on: how many faces were tested at each sample, and the number of the batch that its
    /// owner came with, counted from 1 through the passage (0: nothing is seen there).
    fn work(&mut self, y: u16, x0: u16, tested: &[u16], batch: &[u32]) {
        let _ = (y, x0, tested, batch);
    }
}

/// Samples of one row that one face, or a closed opening, owns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first column.
    pub x0: u16,
    /// The column after the last.
    pub x1: u16,
    /// What is seen.
    pub owner: Owner,
    /// Is it glass, or a cut-out, painted over what is behind it?
    pub see_through: bool,
}
