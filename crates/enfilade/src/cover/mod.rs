//! Covers: occlusion buffers that store what the geometry processed so far hides.
//!
//! A cover answers occlusion queries for bounding boxes. Covers that implement [`Paints`] also hold the picture (an
//! owner per sample); covers that implement [`Hides`] only hold selected occluders. These are separate traits so that a
//! cover without a picture need not implement drawing. Covers do not depend on traversal orders; `method` combines the
//! two.

mod cells;
mod depth_buffer;
mod depth_pyramid;
#[cfg(feature = "terrain")]
mod horizon;
#[cfg(feature = "classic")]
mod mask;
mod masked_depth;
mod occlusion_tree;
#[cfg(feature = "classic")]
mod painters_buffer;
mod report;
mod samples;
mod show;
mod span_buffer;
mod trace;

pub use cells::CoarseCoverage;
pub use depth_buffer::DepthBuffer;
pub use depth_pyramid::DepthPyramid;
#[cfg(feature = "terrain")]
pub use horizon::Horizon;
#[cfg(feature = "classic")]
pub use mask::Mask;
pub use masked_depth::{ItemTest, MaskedDepth, OccluderMesh, OccluderMeshError, OcclusionBuffer};
pub use occlusion_tree::{BoxTest, ByBox, ByFaces, OcclusionTree};
#[cfg(feature = "classic")]
pub use painters_buffer::PaintersBuffer;
pub use span_buffer::SpanBuffer;

use crate::contract::Contract;
use crate::faces::Faces;
use crate::geom::Aabb;
use crate::geometry::Owners;
use crate::ids::ItemIndex;
use crate::occluders::{Occluder, OccluderMeasure};
use crate::raster::{Band, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;

/// Keeps [`Cover`] and its parameters from being implemented elsewhere.
mod sealed {
    use super::*;

    pub trait Sealed {}
    impl Sealed for DepthBuffer {}
    impl Sealed for DepthPyramid {}
    #[cfg(feature = "terrain")]
    impl Sealed for Horizon {}
    #[cfg(feature = "classic")]
    impl Sealed for Mask {}
    impl Sealed for MaskedDepth {}
    impl<A> Sealed for OcclusionTree<A> {}
    #[cfg(feature = "classic")]
    impl Sealed for PaintersBuffer {}
    impl Sealed for SpanBuffer {}
    impl Sealed for ByBox {}
    impl Sealed for ByFaces {}
}

/// An occlusion buffer: stores what is already hidden and tests bounding boxes against it.
///
/// All screen coordinates are in pixels, with y pointing down and sample centres at .5. Depths are reversed depths:
/// larger is nearer.
///
/// Sealed, and so are [`Paints`] and [`Hides`]: an answer that is wrong in one sample culls a visible item, which the
/// compiler cannot check, only the laws. So the traits may also gain methods in any version. To compute visibility in
/// another way, implement [`Sector`](crate::Sector).
#[doc(alias = "occlusion buffer")]
pub trait Cover: sealed::Sealed + Default + Send + 'static {
    /// Guarantee that a traversal order must give, so that occlusion queries cause no false cull and the picture, if the
    /// cover holds one, is correct.
    type Needs;

    /// Name of the type, for tables and reports.
    const NAME: &'static str;

    /// Returns how much of a box may still be visible.
    ///
    /// `Hidden` only if no part of it can be visible. `Partial` when unsure. `Full` only if nothing that the same
    /// traversal adds later can hide any part of it.
    ///
    /// Takes `&mut self` because a cover may bring its cells up to date only when they are tested ([`DepthPyramid`]).
    fn test(&mut self, region: &Region) -> Visibility;

    /// Tests an AABB given in another space, as [`Cover::test`] does; `None` if the box is outside the view.
    ///
    /// `screen_from_local` maps the space of `bounds` to (X, Y, W). Override it in covers that need neither the samples
    /// nor the reversed depth of the box, to skip computing them.
    fn test_local(
        &mut self,
        passage: &Passage,
        screen_from_local: &ScreenMap,
        bounds: &Aabb,
    ) -> Option<Visibility> {
        Region::of(passage, screen_from_local, bounds).map(|region| self.test(&region))
    }

    /// Announces that all boxes tested from now on are inside the box tested last, so that the cover may reuse that
    /// result.
    fn go_within(&mut self) {}

    /// Ends [`Cover::go_within`]: boxes tested from now on may be anywhere.
    fn go_back(&mut self) {}

    /// Returns the memory in bytes that a cover needs for a screen of `size` (width, height) pixels.
    fn needs_bytes(size: [u32; 2]) -> u64;

    /// Shape of the cells that [`Cover::show`] emits; `None` if the cover has no cells worth drawing.
    const SHAPE: Option<CoverShape> = None;

    /// Emits the contents of the cover to [`Canvas::cover`], after all occluders were rasterized into it.
    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        let _ = (passage, canvas);
    }
}

/// A cover that holds the picture: it stores an owner for each sample and takes faces in traversal order, without
/// occluder selection.
pub trait Paints: Cover {
    /// Whether temporal coherence helps: processing first what was visible in the last frame. Only a cover that accepts
    /// faces in any order can benefit.
    const PRIMES: bool;
    /// Whether [`Cover::test`] still tests boxes against depth after all opaque faces were added. A cover that only
    /// tracks unpainted samples would report every transparent object as hidden.
    const KEEPS_DEPTHS: bool = true;

    /// Clears the cover and opens the samples of the passage's aperture; all other samples count as covered. If `trace`
    /// is `true`, counts the work per sample for [`Canvas::work`].
    fn clear(&mut self, passage: &Passage, trace: bool);

    /// Rasterizes a batch of opaque faces, which hide the geometry behind them. A cover that defers nothing also draws
    /// them to `canvas`.
    ///
    /// The canvas is optional so that culling and drawing share one implementation, and a trait object because it is
    /// called only once per row.
    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, canvas: Option<&mut dyn Canvas>);

    /// Reports the samples at which the given transparent faces are in front of all opaque faces. Call it after the
    /// last [`Paints::add`]: tested against the finished cover, transparent faces need not be stored in it.
    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector);

    /// Reports the visible faces and draws the spans that could not be resolved earlier.
    fn finish(
        &mut self,
        owners: &dyn Owners,
        passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    );
}

/// The clusters of an item in a node of its mesh, and their number of triangles.
pub struct FineNode<'a> {
    pub(crate) item: ItemIndex,
    pub(crate) clusters: &'a [u32],
    pub(crate) triangles: u64,
}

/// A cover that holds no picture: selected occluders are inserted first, then boxes are tested against them.
pub trait Hides: Cover + Sync {
    /// Guarantee of the visible set of a traversal that this cover culls.
    const CONTRACT: Contract;
    /// Measure by which occluders are selected for this cover.
    const MEASURE: OccluderMeasure;
    /// Default number of occluders to insert.
    const OCCLUDERS: u32;

    /// Clears the cover and opens the passage's aperture; everything outside it is hidden.
    fn clear(&mut self, passage: &Passage);

    /// Returns `true` if a box, given in another space, is entirely hidden or outside the view; `false` when unsure.
    ///
    /// Called for many boxes before each occluder is inserted, so implementations should use a cheap test.
    /// `screen_from_local` maps the space of `bounds` to (X, Y, W).
    fn hides(&mut self, passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb) -> bool {
        let visibility = self.test_local(passage, screen_from_local, bounds);
        visibility.is_none_or(|visibility| visibility == Visibility::Hidden)
    }

    /// Inserts a selected occluder, which hides the geometry behind it.
    fn hide(&mut self, occluder: &Occluder, passage: &Passage, stats: &mut Stats);

    /// Whether visible faces found during the traversal are rasterized as occluders too. If so, everything found is
    /// tested once more at the end.
    const TAKES_FACES: bool = false;

    /// Rasterizes a batch of opaque faces within `region` as occluders, if that is worth the cost. Called only if
    /// [`Hides::TAKES_FACES`] is `true`.
    fn hide_faces(&mut self, _faces: &Faces, _region: &Region, _passage: &Passage, _stats: &mut Stats) {}

    /// Takes note of a mesh node within `region` that is not rasterized, because it is too fine. Called only if
    /// [`Hides::TAKES_FACES`] is `true`.
    fn note_fine(&mut self, _node: &FineNode, _region: &Region, _passage: &Passage) {}

    /// Returns the test of items by their faces against the finished cover, if there is one.
    fn item_test(&mut self) -> Option<ItemTest<'_>> {
        None
    }

    /// Makes this cover answer all queries as `from` does. Called only if queries do not change the answers, that is,
    /// if [`Hides::TAKES_FACES`] is `false`.
    fn copy(&mut self, _from: &Self) {}

    /// Returns `true` if this number of triangles within `region` is too fine to be worth rasterizing as occluders at
    /// once, so that the caller should visit them in parts.
    fn are_too_fine(_triangles: u64, _region: &Region) -> bool {
        false
    }
}

/// A cover that can work with cells larger than samples: it then holds no picture, but can still test visibility.
pub(crate) trait Coarse: Cover {
    /// Clears the cover and opens only the cells that the passage's aperture reaches into.
    fn clear_cells(&mut self, passage: &Passage);

    /// Returns `true` if anything with reversed depth up to `nearest` may be visible in the cells of `rect`.
    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool;

    /// Returns `true` if a face may be visible in these cells that is no nearer than the triangle's plane at their
    /// centres.
    fn sees_plane(&mut self, cells: &Band, rev_depth: &Triangle) -> bool;

    /// Marks these cells as fully covered by a surface at least as near as the triangle's plane at their centres.
    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle);
}
