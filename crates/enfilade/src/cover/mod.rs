//! Covers: what is already hidden. A cover knows nothing of orders; `method` joins the two.

mod band;
mod depth_buffer;
mod depth_pyramid;
mod half_plane;
mod mask;
mod masked_depth;
mod nothing;
mod part;
mod raster;
mod report;
mod samples;
mod span_buffer;
mod tiles;
mod trace;
mod triangle;

pub use depth_buffer::DepthBuffer;
pub use depth_pyramid::DepthPyramid;
pub use mask::Mask;
pub use masked_depth::MaskedDepth;
pub use nothing::Nothing;
pub use span_buffer::SpanBuffer;

use crate::canvas::Canvas;
use crate::content::Content;
use crate::faces::Faces;
use crate::passage::Passage;
use crate::region::Region;
use crate::seen::Seen;
use crate::stats::Stats;

/// How much of something can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// Nothing of it.
    Hidden,
    /// Some of it, or one cannot say.
    Partly,
    /// All of it.
    Fully,
}

/// Remembers what is already hidden.
pub trait Cover: Default + Send + 'static {
    /// What an order must give so that nothing seen is called hidden.
    type CullNeeds;
    /// What an order must give so that the picture is right.
    type DrawNeeds;
    /// Does it gain by seeing first what the last look saw? Only a cover that needs no order can.
    const PRIMES: bool;
    /// Does [`Cover::sees`] still hold boxes against what hides when all of that is in? A cover that only knows what is
    /// left to paint would call all glass hidden.
    const KEEPS_DEPTHS: bool = true;

    /// Starts over: only the passage's aperture is open, everything else counts as covered. `trace`: count the work
    /// for [`Canvas::work`].
    fn clear(&mut self, passage: &Passage, trace: bool);

    /// How much of a box can still be seen. `Partly` when unsure.
    fn sees(&mut self, region: &Region) -> Sight;

    /// Lets a batch of opaque faces hide what is behind them; a cover that defers nothing paints them.
    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, canvas: Option<&mut dyn Canvas>);

    /// Reports the samples at which faces that do not hide are in front of all that does. Comes after the last
    /// [`Cover::add`].
    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Seen);

    /// Reports and paints what could not be decided earlier.
    fn finish(
        &mut self,
        content: &Content,
        passage: &Passage,
        seen: &mut Seen,
        canvas: Option<&mut dyn Canvas>,
    );

    /// Memory in bytes for a screen of this size.
    fn needs_bytes(size: [u32; 2]) -> u64;
}
