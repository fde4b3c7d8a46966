//! Receives what is seen.

use crate::geometry::Owner;
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

    /// Should covers show what they know when all that hides is in them? Then [`Canvas::cover`] gets it.
    fn wants_cover(&self) -> bool {
        false
    }

    /// What the cover of the passage at hand knows of the samples of row `y` that are in its aperture, left to right. A
    /// passage farther on comes later, within the samples through which it is seen: what it knows takes the place of
    /// what its parent knew there.
    fn cover(&mut self, y: u16, spans: &[CoverSpan]) {
        let _ = (y, spans);
    }
}

/// Samples of one row of which a cover knows one thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverSpan {
    /// The first column.
    pub x0: u16,
    /// The column after the last.
    pub x1: u16,
    /// The number of the cover's cell that knows it (a face's samples, a cell of a pyramid, a sub-tile, a leaf of a
    /// tree), the same in all its rows; other passages use the same numbers.
    pub cell: u32,
    /// What hides here.
    pub by: HiddenBy,
    /// 1 / distance along the line of sight, at the first and the last sample: what is farther is hidden. 0 where
    /// nothing is.
    pub rev_depth: [f32; 2],
}

/// What hides in a cell of a cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HiddenBy {
    /// Nothing.
    Nothing,
    /// A face, or an occluder, alone; by a number that is the same wherever it hides.
    One(u32),
    /// Several faces, each at samples of its own.
    Several,
    /// Layers of a masked buffer: the reference, which holds for a whole sub-tile.
    Reference,
    /// The working layer, which holds for the samples of the mask.
    Working,
}

/// What a cover divides the screen into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoverShape {
    /// Spans of rows, one face each.
    Spans,
    /// Cells of 8×8 samples, and those of 2×2 cells above.
    Pyramid,
    /// Sub-tiles of 8×4 samples in two layers.
    Tiles,
    /// Convex polygons, parted by planes through the eye.
    Tree,
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
