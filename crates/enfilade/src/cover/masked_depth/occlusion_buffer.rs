//! The masked depth buffer on its own, for engines without a scene.

use super::draw::{DrawList, Workers};
use super::mesh::OccluderMesh;
use super::tiles::Grid;
use crate::geom::{Aabb, Transform};
use crate::ids::SectorId;
use crate::simd::{dispatch, level};
use crate::stats::Stats;
use crate::threads;
use crate::view::View;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use crate::view::region::{BOXES, Clip, EightBoxes, sphere_on_screen};
use fearless_simd::Level;
use fearless_simd::prelude::*;

/// A software occlusion buffer: draw occluders, then test which boxes, spheres and rectangles they hide.
///
/// This is the depth buffer of [`Method::Masked`](crate::Method::Masked) without a scene. For each view: [`begin`],
/// [`draw`] occluders, nearest first if that costs nothing, then test everything else. Tests and draws may alternate.
///
/// ```
/// use enfilade::{Aabb, OccluderMesh, OcclusionBuffer, Transform, View};
///
/// let wall = OccluderMesh::triangles(
///     &[[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]],
///     &[0, 1, 2, 0, 2, 3],
/// )?;
/// let mut buffer = OcclusionBuffer::new();
/// buffer.begin(&View::new([0.0; 3], [0.0, 0.0, -1.0], [1280, 720])?);
/// buffer.draw(&wall, &Transform::translation([0.0, 0.0, -4.0]));
/// let behind = Aabb { min: [-1.0, -1.0, -9.0], max: [1.0, 1.0, -8.0] };
/// let beside = Aabb { min: [5.0, -1.0, -9.0], max: [6.0, 1.0, -8.0] };
/// let mut visible = [0];
/// buffer.test_boxes(&[behind, beside], &mut visible);
/// assert_eq!(visible, [0b10]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # What is guaranteed
/// Nothing that a sample of the view can show is reported hidden, if all occluders are opaque on the screen. Samples
/// are the pixel centres of [`View::size`]. At a lower resolution than the screen's, the guarantee holds for the fewer
/// samples: something that shows through a gap or past an edge by less than the distance of two samples may be reported
/// hidden. The buffer is fast enough for the resolution of the screen; half of it on each side halves the time of draws,
/// not of tests.
///
/// The other direction is not guaranteed: a hidden box may be reported visible, because the buffer keeps two depths for
/// each 8×4 samples, and a box or a sphere is more than what is in it. Equal depths count as visible.
///
/// # Conventions
/// Space is that of the view: right-handed, in scene units. Depth is reversed, 1 / distance along the view direction:
/// larger is nearer, 0 is infinitely far; there is no far plane. What is nearer than [`View::z_near`] is clipped: it
/// neither hides nor is visible. A box that crosses the near plane counts as near as it can be inside the view; around
/// the eye it is visible. Faces are counter-clockwise seen from their front, and single-sided unless
/// [`OccluderMesh::double_sided`] is set.
///
/// # Threads
/// With the feature `rayon`, draws and tests use the current rayon pool, unless [`OcclusionBuffer::parallel`] is
/// `false`. Results have the same bits for any number of threads and at any SIMD level. Tests take `&self`, so threads
/// of your own may also test at the same time. Nothing is allocated once the buffers have grown, except by
/// [`OcclusionBuffer::depth`].
///
/// [`begin`]: OcclusionBuffer::begin
/// [`draw`]: OcclusionBuffer::draw
#[doc(alias = "masked occlusion culling")]
#[doc(alias = "MaskedOcclusionCulling")]
#[doc(alias = "software rasterizer")]
#[doc(alias = "depth buffer")]
pub struct OcclusionBuffer {
    /// Whether draws and tests may use all threads of the current rayon pool. Default `true`; affects speed only.
    pub parallel: bool,
    level: Level,
    pub(super) grid: Grid,
    workers: Workers,
    list: DrawList<'static>,
    /// The view, as the passage of the eye; `None` before the first view and for an invalid one.
    passage: Option<Passage>,
}

impl Default for OcclusionBuffer {
    fn default() -> OcclusionBuffer {
        OcclusionBuffer::new()
    }
}

/// Words of results that one thread computes at a time: 512 boxes.
const WORDS: usize = 8;

impl OcclusionBuffer {
    /// Creates a buffer. Until [`OcclusionBuffer::begin`], everything is visible.
    pub fn new() -> OcclusionBuffer {
        OcclusionBuffer::at(level())
    }

    /// Creates a buffer for a SIMD level. The level changes the speed only; the results have the same bits.
    pub(super) fn at(level: Level) -> OcclusionBuffer {
        OcclusionBuffer {
            parallel: true,
            level,
            grid: Grid::default(),
            workers: Workers::at(level),
            list: DrawList::default(),
            passage: None,
        }
    }

    /// Clears the buffer and sets the view for the draws and tests to come. The buffer has one sample for each pixel of
    /// [`View::size`], and needs half a byte for each.
    ///
    /// [`View::sector`] is ignored. In a parallel view, parts of meshes that reach twice as far as the far plane hide nothing.
    #[doc(alias = "ClearBuffer")]
    #[doc(alias = "SetResolution")]
    #[doc(alias = "SetNearClipPlane")]
    pub fn begin(&mut self, view: &View) {
        self.begin_passage(Passage::at_the_eye(view, SectorId(0), true));
    }

    pub(super) fn begin_passage(&mut self, passage: Passage) {
        self.grid.clear(&passage);
        self.passage = Some(passage);
    }

    /// Draws an instance of an occluder: what is behind it is hidden from now on.
    ///
    /// `world_from_mesh` may mirror and scale. An instance with a transform that is not finite hides nothing.
    #[doc(alias = "RenderTriangles")]
    pub fn draw(&mut self, mesh: &OccluderMesh, world_from_mesh: &Transform) {
        self.draw_all([(mesh, *world_from_mesh)]);
    }

    /// Draws a batch of instances, each as [`OcclusionBuffer::draw`] does.
    ///
    /// One batch of many instances is faster than one call for each, and only a batch is split between threads. The
    /// order does not matter for what is guaranteed; nearest first is fastest and hides most.
    #[doc(alias = "RenderTriangles")]
    #[doc(alias = "BinTriangles")]
    pub fn draw_all<'a>(&mut self, instances: impl IntoIterator<Item = (&'a OccluderMesh, Transform)>) {
        self.rasterize(instances);
    }

    /// As [`OcclusionBuffer::draw_all`]; returns the work done.
    pub(super) fn rasterize<'a>(
        &mut self,
        instances: impl IntoIterator<Item = (&'a OccluderMesh, Transform)>,
    ) -> Stats {
        let Some(passage) = &self.passage else {
            return Stats::default();
        };
        let mut list: DrawList = std::mem::take(&mut self.list).emptied();
        for (mesh, world_from_mesh) in instances {
            list.add(passage, mesh, &world_from_mesh);
        }
        let stats = list.draw(&mut self.grid, passage, &mut self.workers, self.parallel);
        self.list = list.emptied();
        stats
    }

    /// Tests boxes: sets bit `i % 64` of `visible[i / 64]` if any part of `boxes[i]` may be visible, and clears it if
    /// occluders hide all of it or it is out of view. Empty boxes are hidden; boxes that are not finite are visible.
    ///
    /// Give one word for each 64 boxes: boxes without a bit are not tested, bits without a box are cleared.
    ///
    /// A box is tested by its screen rectangle first; if that is not hidden, by its outline and front faces.
    #[doc(alias = "TestRect")]
    #[doc(alias = "TestTriangles")]
    pub fn test_boxes(&self, boxes: &[Aabb], visible: &mut [u64]) {
        self.test(boxes, visible, |passage, boxes| {
            let screen_from_world = &passage.screen_from_sector;
            let near = f64::from(passage.z_near);
            let mut bits = 0;
            for (boxes, first) in boxes.chunks(BOXES).zip((0..).step_by(BOXES)) {
                let eight = EightBoxes::of(passage, screen_from_world, boxes);
                let seen = dispatch!(self.level, simd => self.see_eight(simd, &eight, boxes, near));
                bits |= seen << first;
            }
            bits
        });
    }

    #[inline(always)]
    fn see_eight<S: Simd>(&self, simd: S, eight: &EightBoxes, boxes: &[Aabb], near: f64) -> u64 {
        let mut bits = 0;
        for (lane, bounds) in boxes.iter().enumerate() {
            let seen = if is_finite(bounds) {
                let (rect, nearest) = eight.rect(lane);
                self.grid.shows(&rect, nearest)
                    && eight
                        .region(lane)
                        .is_some_and(|region| self.grid.sees(simd, &region, near, 0.0))
            } else {
                !bounds.is_empty()
            };
            bits |= u64::from(seen) << lane;
        }
        bits
    }

    /// Tests spheres, given by centre and radius, as [`OcclusionBuffer::test_boxes`] tests boxes: each by the rectangle
    /// around its outline, at the depth of its nearest point. Spheres that are not finite are visible.
    pub fn test_spheres(&self, spheres: &[([f32; 3], f32)], visible: &mut [u64]) {
        self.test(spheres, visible, |passage, spheres| {
            let clip = Clip::from(passage);
            self.collect(spheres, |sphere| {
                let (center, radius) = sphere;
                let is_sphere =
                    center.iter().all(|value| value.is_finite()) && (0.0..f32::INFINITY).contains(radius);
                !is_sphere || {
                    let (rect, nearest) = sphere_on_screen(&clip, &passage.screen_from_sector, *sphere);
                    self.grid.shows(&rect, nearest)
                }
            })
        });
    }

    /// Tests rectangles of samples, each at one reversed depth, as [`OcclusionBuffer::test_boxes`] tests boxes.
    ///
    /// The reversed depth is 1 / distance along the view direction: that of the nearest point of what the rectangle
    /// stands for, rounded up. Where it is negative or NaN, the rectangle counts as at the eye. Parts of rectangles
    /// outside the screen are ignored; x points right and y down, from the top left corner.
    #[doc(alias = "TestRect")]
    pub fn test_rects(&self, rects: &[(Rect, f32)], visible: &mut [u64]) {
        self.test(rects, visible, |_, rects| {
            self.collect(rects, |&(rect, rev_depth)| {
                let nearest = if rev_depth >= 0.0 {
                    rev_depth
                } else {
                    f32::INFINITY
                };
                self.grid.shows(&rect, nearest)
            })
        });
    }

    /// Returns a picture of the buffer, for debugging: the reversed depth at each sample, row by row from the top left
    /// corner. What is farther, with a smaller reversed depth, is hidden there; 0 where nothing is. Empty before the
    /// first view.
    #[doc(alias = "ComputePixelDepthBuffer")]
    pub fn depth(&self) -> Vec<f32> {
        let Some(passage) = &self.passage else {
            return Vec::new();
        };
        let [width, height] = passage.size.map(|side| side as usize);
        (0..width * height)
            .map(|place| self.grid.rev_depth_at(place % width, place / width))
            .collect()
    }

    /// Calls `one_word` for each 64 occludees, on all threads.
    fn test<T: Sync>(
        &self,
        occludees: &[T],
        visible: &mut [u64],
        one_word: impl Fn(&Passage, &[T]) -> u64 + Sync + Send,
    ) {
        threads::for_each_run(self.parallel, visible, WORDS, |first, words| {
            for (number, word) in (first..).zip(words) {
                let start = (number * 64).min(occludees.len());
                let end = (start + 64).min(occludees.len());
                *word = match &self.passage {
                    Some(passage) => one_word(passage, &occludees[start..end]),
                    None => (1_u64.checked_shl((end - start) as u32).unwrap_or(0)).wrapping_sub(1),
                };
            }
        });
    }

    /// Returns a bit for each of up to 64 occludees.
    #[inline(always)]
    fn collect<T>(&self, occludees: &[T], seen: impl Fn(&T) -> bool) -> u64 {
        let bits = occludees.iter().enumerate();
        bits.fold(0, |bits, (place, occludee)| {
            bits | u64::from(seen(occludee)) << place
        })
    }
}

fn is_finite(bounds: &Aabb) -> bool {
    bounds
        .min
        .iter()
        .chain(&bounds.max)
        .all(|value| value.is_finite())
}
