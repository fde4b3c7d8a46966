//! The trait that receives the visible surface as rows of spans.

use crate::geometry::Owner;
use crate::ids::PassageId;
use crate::view::passage::Passage;

/// A render target that receives the visible surface one row of spans at a time: an image, an item list, an overdraw
/// map.
#[doc(alias = "render target")]
#[doc(alias = "framebuffer")]
pub trait Canvas {
    /// Announces the passage that the following rows belong to.
    ///
    /// Called again when drawing returns from behind an opening, to blend this passage's transparent faces over the
    /// rest.
    fn enter(&mut self, id: PassageId, passage: &Passage);

    /// Receives the spans of row `y`, left to right, without overlap. Transparent spans come after everything behind
    /// them.
    fn row(&mut self, y: u16, spans: &[Span]);

    /// Whether covers count their tests per sample and pass the counts to [`Canvas::work`]. Default `false`.
    fn wants_work(&self) -> bool {
        false
    }

    /// Receives the test counts of row `y` from column `x0` on: per sample the number of faces `tested`, and the number
    /// of the `batch` that brought its owner, counted from 1 within the passage (0: no owner).
    fn work(&mut self, y: u16, x0: u16, tested: &[u16], batch: &[u32]) {
        let _ = (y, x0, tested, batch);
    }

    /// Whether covers report their state to [`Canvas::cover`] once all occluders are in them. Default `false`.
    fn wants_cover(&self) -> bool {
        false
    }

    /// Receives the state of the current passage's cover for the samples of row `y` inside its aperture, left to right.
    ///
    /// A passage behind an opening comes later and reports the samples of that opening again; its state replaces that
    /// of its parent there.
    fn cover(&mut self, y: u16, spans: &[CoverSpan]) {
        let _ = (y, spans);
    }
}

/// Samples of one row that belong to the same cell of a cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoverSpan {
    /// First column.
    pub x0: u16,
    /// Last column + 1.
    pub x1: u16,
    /// Number of the cover's cell (the samples of a face, a Hi-Z cell, a sub-tile or a tree leaf). It is the same in
    /// all rows of the cell; other passages use the same numbers again.
    pub cell: u32,
    /// The occluder in this cell.
    pub by: HiddenBy,
    /// Reversed depth (1 / distance along the view direction) at the first and the last sample; anything farther is
    /// hidden. 0 if nothing is.
    pub rev_depth: [f32; 2],
}

/// What occludes a cell of a cover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HiddenBy {
    /// The cell has no occluder.
    Nothing,
    /// A single face or occluder, by a number that is the same in all cells.
    One(u32),
    /// Several faces, each at different samples.
    Several,
    /// The reference layer of a masked depth buffer, which applies to the whole sub-tile.
    Reference,
    /// The working layer of a masked depth buffer, which applies to the samples in the mask.
    Working,
}

/// How a cover divides the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CoverShape {
    /// Spans of rows, each with one face.
    Spans,
    /// A Hi-Z pyramid: cells of 8×8 samples, with a cell for each 2×2 of them above.
    Pyramid,
    /// Sub-tiles of 8×4 samples with two depth layers each.
    Tiles,
    /// A tree of convex polygons, split by planes through the eye.
    Tree,
}

/// Consecutive samples of one row with the same owner: a face or a closed opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First column.
    pub x0: u16,
    /// Last column + 1.
    pub x1: u16,
    /// The face or opening that is visible at these samples.
    pub owner: Owner,
    /// Whether the face is alpha-blended or alpha-tested, to be drawn over what is behind it.
    pub see_through: bool,
}
