//! Rasterizes batches of faces as occluders: sixteen faces at a time in SIMD lanes, with an f64 fallback.
//!
//! Vertices are projected to fixed point ([`project`]). Faces are back-face culled, classified and queued by kind
//! ([`sort`](super::sort)) and set up ([`setup`](super::setup)). Small faces are rasterized one per lane ([`small`]),
//! wide triangles one after the other with rows in the lanes ([`wide`]). Faces with a vertex that fixed point cannot
//! represent are clipped first ([`project::clip`]). All arithmetic is 32-bit with error bounds: where the error could
//! change a sample, the face is uncertain and goes to the f64 rasterizer of the exact covers. So this buffer covers the
//! same samples as they do, and faces that share an edge are watertight: each sample belongs to exactly one of them.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; filters as in Shewchuk,
//!     Adaptive Precision Floating-Point Arithmetic, 1997.
//! Cost: O(vertices + faces + tiles), and O(tiles it overlaps) for each uncertain face.
//! Conservative: covers exactly the samples that the exact covers do, and is nowhere nearer than they are.

use super::mesh::block;
use super::occluder::Slope;
use super::project::{Block, Corners, Frame, MAX_CORNERS};
use super::runs::RunQueue;
use super::small::Records;
use super::sort::{Group, Queues};
use super::tiles::Tiles;
use super::{LANES, project, small, wide};
use crate::faces::Faces;
use crate::raster::{BAND, Band, Clipper, Raster, Sink, Triangle};
use crate::simd::{apart, dispatch};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use fearless_simd::Level;
use fearless_simd::prelude::*;

/// Rasterizes batches of faces.
pub(super) struct Worker {
    batch: Batch,
    blocks: Vec<Block>,
    /// Quads and triangles of polygons with more corners.
    quads: Vec<[u32; 4]>,
    triangles: Vec<[u32; 3]>,
}

impl Worker {
    /// Creates a worker for a SIMD level. The level changes the speed only; the results have the same bits.
    pub(super) fn at(level: Level) -> Worker {
        Worker {
            batch: Batch::at(level),
            blocks: Vec::new(),
            quads: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Rasterizes a batch of faces as occluders.
    pub(super) fn hide_batch(
        &mut self,
        tiles: &mut Tiles,
        faces: &Faces,
        passage: &Passage,
        stats: &mut Stats,
    ) {
        let Worker {
            batch,
            blocks,
            quads,
            triangles,
        } = self;
        blocks.clear();
        blocks.extend(faces.positions.chunks(LANES).map(block));
        stats.batches += 1;
        let mut shapes = Shapes {
            quads: &[],
            triangles: faces.corners.as_chunks().0,
            first_position: faces.first_position,
        };
        if faces.starts.is_some() {
            quads.clear();
            triangles.clear();
            faces.for_each(|_, face| fan(face, quads, triangles));
            shapes.quads = quads;
            shapes.triangles = triangles;
        }
        let frame = Frame::new(faces, passage, tiles);
        stats.triangles += shapes.triangles();
        dispatch!(batch.level, simd => batch.queue(simd, &frame, blocks, shapes, 0, tiles));
        let uncertain = batch.finish(&frame, tiles);
        for &number in &uncertain {
            let corners = shapes.corners(number as usize);
            let face = UncertainFace {
                faces,
                blocks,
                corners,
                first_position: faces.first_position,
            };
            batch.hide_in_f64(&face, passage, tiles, stats);
        }
        batch.end(uncertain, tiles);
    }
}

/// Splits a convex polygon into quads and, if one remains, a triangle.
fn fan(face: &[u32], quads: &mut Vec<[u32; 4]>, triangles: &mut Vec<[u32; 3]>) {
    let Some((&first, mut others)) = face.split_first() else {
        return;
    };
    while let Some(&[a, b, c]) = others.first_chunk() {
        quads.push([first, a, b, c]);
        others = &others[2..];
    }
    if let &[a, b] = others {
        triangles.push([first, a, b]);
    }
}

/// The kernels with their buffers, and the f64 rasterizer.
pub(super) struct Batch {
    pub(super) level: Level,
    raster: Raster,
    corners: Corners,
    queues: Queues,
    records: Records,
    run_queue: RunQueue,
    clipper: Clipper,
}

/// Quads and triangles, with corners as indices into positions; the first index is `first_position`.
#[derive(Clone, Copy)]
pub(super) struct Shapes<'a> {
    /// Convex quads; they are numbered before the triangles.
    pub(super) quads: &'a [[u32; 4]],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) first_position: u32,
}

impl Shapes<'_> {
    /// Returns the number of triangles, counting a quad as two.
    pub(super) fn triangles(&self) -> u64 {
        (2 * self.quads.len() + self.triangles.len()) as u64
    }

    /// Returns the corners of the face `number`.
    pub(super) fn corners(&self, number: usize) -> &[u32] {
        match self.quads.get(number) {
            Some(quad) => quad,
            None => &self.triangles[number - self.quads.len()],
        }
    }
}

/// A face that goes to the f64 rasterizer.
pub(super) struct UncertainFace<'a> {
    /// The properties of the face; the corners are ignored.
    pub(super) faces: &'a Faces<'a>,
    pub(super) blocks: &'a [Block],
    /// Indices into the positions in `blocks`; the first position has the index `first_position`.
    pub(super) corners: &'a [u32],
    pub(super) first_position: u32,
}

impl Batch {
    pub(super) fn at(level: Level) -> Batch {
        Batch {
            level,
            raster: Raster::at(level),
            corners: Corners::default(),
            queues: Queues::default(),
            records: Records::default(),
            run_queue: RunQueue::default(),
            clipper: Clipper::default(),
        }
    }

    /// Queues faces, and rasterizes queued ones when there are enough. `first` is the number of the first face; faces
    /// queued before [`Batch::finish`] have different numbers.
    #[inline(always)]
    pub(super) fn queue<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        positions: &[Block],
        shapes: Shapes,
        first: u32,
        tiles: &mut Tiles,
    ) {
        let Shapes {
            quads,
            triangles,
            first_position,
        } = shapes;
        if positions.len() * LANES > MAX_CORNERS {
            let all = first..first + (quads.len() + triangles.len()) as u32;
            self.queues.uncertain.extend(all);
            return;
        }
        apart!(simd, project::project(simd, frame, positions, &mut self.corners));
        let mut last_quads = [[first_position; 4]; LANES];
        let mut last_triangles = [[first_position; 3]; LANES];
        let groups_of_quads = quads.len().div_ceil(LANES);
        let groups = groups_of_quads + triangles.len().div_ceil(LANES);
        let first_triangle = first as usize + quads.len();
        let mut next = 0;
        // Also while clipped faces are left: they are classified by the winding of these faces.
        while next < groups || self.queues.clipped.count > 0 {
            if next == groups || self.queues.clipped.count >= LANES {
                apart!(simd, self.queues.queue_clipped(simd, frame, tiles));
            } else if next < groups_of_quads {
                let group = Group::new(&shapes, quads, next, first as usize, &mut last_quads);
                let found = apart!(simd, group.project(simd, &self.corners));
                apart!(simd, self.queues.queue_quads(simd, frame, tiles, &found));
                self.queues
                    .clip(frame, positions, &group, found.to_clip, &mut self.clipper);
                next += 1;
            } else {
                let which = next - groups_of_quads;
                let group = Group::new(&shapes, triangles, which, first_triangle, &mut last_triangles);
                let found = apart!(simd, group.project(simd, &self.corners));
                apart!(simd, self.queues.queue_triangles(simd, frame, tiles, &found));
                self.queues
                    .clip(frame, positions, &group, found.to_clip, &mut self.clipper);
                next += 1;
            }
            if self.queues.are_full() {
                apart!(simd, self.flush(simd, frame, tiles, LANES));
            }
        }
    }

    /// Rasterizes all queued faces. Returns the numbers of those to give to [`Batch::hide_in_f64`]. Return the list to
    /// [`Batch::end`].
    pub(super) fn finish(&mut self, frame: &Frame, tiles: &mut Tiles) -> Vec<u32> {
        dispatch!(self.level, simd => self.flush(simd, frame, tiles, 1));
        std::mem::take(&mut self.queues.uncertain)
    }

    /// Rasterizes a face in f64.
    pub(super) fn hide_in_f64(
        &mut self,
        face: &UncertainFace,
        passage: &Passage,
        tiles: &mut Tiles,
        stats: &mut Stats,
    ) {
        let &UncertainFace {
            faces,
            blocks,
            corners,
            first_position,
        } = face;
        let mut sink = RunSink {
            level: self.level,
            tiles,
            run_queue: &mut self.run_queue,
        };
        // Separate counters, because the batch and its triangles are already counted.
        let mut alone = Stats::default();
        let at = |corner: u32| {
            let place = (corner - first_position) as usize;
            blocks[place / LANES].map(|axis| axis[place % LANES])
        };
        for last in 2..corners.len() {
            let three = [corners[0], corners[last - 1], corners[last]].map(at);
            if !three.as_flattened().iter().all(|value| value.is_finite()) {
                continue;
            }
            let one = Faces {
                positions: &three,
                first_position: 0,
                corners: &[0, 1, 2],
                starts: None,
                neighbours: &[],
                ..*faces
            };
            self.raster.run(&one, passage, &mut sink, &mut alone);
        }
        stats.triangles_hidden += alone.triangles_hidden;
        stats.samples += alone.samples;
    }

    /// Covers what the faces of the list rasterized in f64, and takes the list back for reuse.
    pub(super) fn end(&mut self, mut uncertain: Vec<u32>, tiles: &mut Tiles) {
        if !uncertain.is_empty() {
            dispatch!(self.level, simd => self.run_queue.cover(simd, tiles));
            uncertain.clear();
        }
        self.queues.uncertain = uncertain;
    }

    /// Rasterizes queued faces, wide ones first, as long as a queue has at least `least`.
    #[inline(always)]
    fn flush<S: Simd>(&mut self, simd: S, frame: &Frame, tiles: &mut Tiles, least: usize) {
        let Batch {
            queues:
                Queues {
                    small,
                    wide,
                    quads,
                    uncertain,
                    ..
                },
            records,
            run_queue,
            ..
        } = self;
        let mut from = 0;
        while wide.count >= from + least {
            let faces = wide.load(simd, from);
            apart!(simd, wide::draw(simd, frame, &faces, tiles, run_queue, uncertain));
            from += faces.lanes;
        }
        run_queue.cover(simd, tiles);
        wide.discard_before(from);
        apart!(
            simd,
            small::draw_queued::<S, 4, 2>(simd, frame, quads, least, records, tiles, uncertain)
        );
        apart!(
            simd,
            small::draw_queued::<S, 3, 1>(simd, frame, small, least, records, tiles, uncertain)
        );
    }
}

/// Rasterizer output that queues the runs of the faces.
struct RunSink<'a, 'b> {
    level: Level,
    tiles: &'a mut Tiles<'b>,
    run_queue: &'a mut RunQueue,
}

impl Sink for RunSink<'_, '_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        self.tiles.hides(rect, nearest)
    }

    fn band(&mut self, band: &Band, triangle: &Triangle) {
        let Rect { y0, y1, .. } = self.tiles.rect;
        if y0 < band.y + BAND as u16 && band.y < y1 {
            let slope = Slope::of(triangle, &self.tiles.rect);
            dispatch!(self.level, simd => self.run_queue.push_band(simd, self.tiles, band, &slope));
        }
    }
}
