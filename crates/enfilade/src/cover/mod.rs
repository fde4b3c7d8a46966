//! Covers: what is already hidden. A cover knows nothing of orders; `method` joins the two.

mod band;
mod batch;
mod block;
mod cells;
mod corners;
mod depth_buffer;
mod depth_pyramid;
mod half_plane;
mod horizon;
mod mask;
mod masked_depth;
mod occlusion_tree;
mod painters_buffer;
mod part;
mod raster;
mod report;
mod samples;
mod show;
mod sieve;
mod span_buffer;
mod tiles;
mod trace;
mod triangle;

pub use cells::CoarseCoverage;
pub use depth_buffer::DepthBuffer;
pub use depth_pyramid::DepthPyramid;
pub use horizon::Horizon;
pub use mask::Mask;
pub use masked_depth::MaskedDepth;
pub use masked_depth::OccluderMesh;
pub use occlusion_tree::{Asks, ByBox, ByFaces, OcclusionTree};
pub use painters_buffer::PaintersBuffer;
pub use span_buffer::SpanBuffer;

use crate::aperture::Rect;
use crate::canvas::{Canvas, CoverShape};
use crate::collector::Collector;
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::Owners;
use crate::occluders::{Occluder, OccluderMeasure};
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::stats::Stats;
use band::Band;
use glam::DAffine3;
use triangle::Triangle;

/// Remembers what is already hidden.
pub trait Cover: Default + Send + 'static {
    /// What an order must give so that nothing seen is called hidden.
    type CullNeeds;

    /// How much of a box can still be seen. `Partial` when unsure; `Full` only where nothing that comes later in the
    /// same walk can change it.
    fn sees(&mut self, region: &Region) -> Visibility;

    /// As [`Cover::sees`], of a box given in another space; `None` where it is out of view. A cover that needs neither its
    /// samples nor its reversed depth can say so sooner.
    fn sight_of(
        &mut self,
        passage: &Passage,
        screen_from_local: &DAffine3,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        Region::of(passage, screen_from_local, bounds).map(|region| self.sees(&region))
    }

    /// From now on all boxes lie in the one that was asked about last. What it said of that may save asking the same again.
    fn go_within(&mut self) {}

    /// From now on boxes lie anywhere again.
    fn go_back(&mut self) {}

    /// Memory in bytes for a screen of this size.
    fn needs_bytes(size: [u32; 2]) -> u64;

    /// What it divides the screen into; `None` where that is nothing worth a picture.
    const SHAPE: Option<CoverShape> = None;

    /// Shows what it knows, when all that hides is in it ([`Canvas::cover`]).
    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        let _ = (passage, canvas);
    }
}

/// A cover that holds the picture: faces go in as they come.
pub trait Paints: Cover {
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

    /// Lets a batch of opaque faces hide what is behind them; a cover that defers nothing paints them.
    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, canvas: Option<&mut dyn Canvas>);

    /// Reports the samples at which faces that do not hide are in front of all that does. Comes after the last
    /// [`Paints::add`].
    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector);

    /// Reports and paints what could not be decided earlier.
    fn finish(
        &mut self,
        owners: &dyn Owners,
        passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    );
}

/// A cover that holds no picture: chosen occluders go in first, and then it says what they hide.
pub trait Hides: Cover + Sync {
    /// Which occluders are worth most to it.
    const MEASURE: OccluderMeasure;
    /// How many occluders go in unless told otherwise.
    const OCCLUDERS: u32;

    /// Starts over: only the passage's aperture is open, everything else is hidden.
    fn clear(&mut self, passage: &Passage);

    /// Is all of a box, given in another space, hidden already, or out of view? Asked of many a box before each occluder,
    /// so by a cheap question: no when unsure.
    fn hides(&mut self, passage: &Passage, screen_from_local: &DAffine3, bounds: &Aabb) -> bool {
        let sight = self.sight_of(passage, screen_from_local, bounds);
        sight.is_none_or(|sight| sight == Visibility::Hidden)
    }

    /// Lets an occluder hide what is behind it.
    fn hide(&mut self, occluder: &Occluder, passage: &Passage, stats: &mut Stats);

    /// Do faces that a walk finds hide what it finds later? Then all that was found is asked about once more at the end.
    const TAKES_FACES: bool = false;

    /// Lets a batch of opaque faces within `region` hide what is behind them, where that is worth it. Only asked where
    /// [`Hides::TAKES_FACES`].
    fn hide_faces(&mut self, _faces: &Faces, _region: &Region, _passage: &Passage, _stats: &mut Stats) {}

    /// Becomes a cover that says of everything what another one does. Only asked where a walk changes nothing that is said: not
    /// where [`Hides::TAKES_FACES`].
    fn copy(&mut self, _from: &Self) {}

    /// Are so many triangles within `region` too fine to hide what is worth it, and to be looked at in parts?
    fn are_too_fine(_triangles: u64, _region: &Region) -> bool {
        false
    }
}

/// A cover that can do with cells larger than samples: it holds no picture then, but says what is hidden.
pub(crate) trait Coarse: Cover {
    /// Starts over, for a passage in cells: only those that the aperture reaches into are open.
    fn clear_cells(&mut self, passage: &Passage);

    /// May anything as near as `nearest` be seen in these cells?
    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool;

    /// May a face be seen in these cells that is no nearer than a triangle's plane at their centres?
    fn sees_plane(&mut self, cells: &Band, rev_depth: &Triangle) -> bool;

    /// These cells are covered whole by something that is at least as near as the triangle's plane at their centres.
    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle);
}
