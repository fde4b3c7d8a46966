//! Batch rasterizer: triangles and quads, sixteen at a time in SIMD lanes.
//!
//! Vertices are projected to fixed point ([`corners`]). Faces are back-face culled and classified sixteen at a time
//! ([`sort`]), queued by kind ([`queue`]) and set up ([`lanes`]). Small faces are rasterized one per lane ([`small`]),
//! wide triangles one after the other with rows in the lanes ([`wide`]). Faces with a vertex that fixed point cannot
//! represent are clipped first ([`clip`]). All arithmetic is 32-bit with error bounds: where the error could change a
//! sample, the face is listed in [`Batch::uncertain`] and rasterized by the f64 rasterizer of the exact covers, so
//! coverage has the same bits as theirs.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; filters as in Shewchuk,
//!     Adaptive Precision Floating-Point Arithmetic, 1997.
//! Cost: O(vertices + faces + tiles).
//! Conservative: covers exactly the samples that the exact covers do, and is nowhere nearer than they are.

mod clip;
mod corners;
mod huge;
mod lanes;
mod queue;
mod records;
mod small;
mod sort;
mod wide;

use super::grid::Tiles;
use super::rows::RunQueue;
use super::tile::{COLUMNS, ROWS};
use crate::aperture::Rect;
use crate::faces::Faces;
use crate::passage::{BEYOND, Passage};
use crate::raster::Clipper;
pub(super) use corners::Block;
use corners::{Corners, DEEPEST, MAX_CORNERS};
use fearless_simd::prelude::*;
use glam::DVec3;
use records::Records;
use sort::{Group, Queues};

/// SIMD lanes of a kernel, at every level, and their indices.
pub(super) const LANES: usize = 16;
pub(super) const COUNT: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// Maximum columns and rows of a screen for clipping: beyond, the guard band would be inside the screen.
const MAX_SAMPLES: u16 = 12_000;

/// One pixel in units of fixed point.
const ONE_SHIFT: u32 = 17;
const ONE: i32 = 1 << ONE_SHIFT;
const HALF: i32 = ONE / 2;

/// Parameters shared by all faces of a batch.
pub(super) struct Frame {
    /// Rows of the matrix from positions to (X, Y, W).
    matrix: [[f64; 4]; 3],
    near: f64,
    /// A vertex with W below this is certainly in front of the near plane.
    behind: f64,
    /// Entry plane n · (X, Y, W) > d, moved back so that a vertex that passes is certainly behind it.
    entry: Option<([f64; 3], f64)>,
    /// Sign of the area of front-facing triangles, −1 or 1; 0 for double-sided faces.
    front: f32,
    /// Origin of fixed point, in pixels.
    middle: [f64; 2],
    middle_sample: [i32; 2],
    /// First column and end column (exclusive) of the rectangle, then its rows, in pixels of the screen.
    limits: [[f64; 2]; 2],
    /// Columns and rows of the rectangle relative to `middle`.
    columns: [i32; 2],
    rows: [i32; 2],
    tile_columns: u32,
    /// Number of rows of tiles above those rasterized into.
    first_row: i32,
    /// Near-plane distance and entry plane for clipping; `None` if faces cannot be clipped here.
    clips: Option<(f64, Option<(DVec3, f64)>)>,
}

impl Frame {
    /// Prepares a batch of faces seen through a passage, rasterized into `tiles`.
    pub(super) fn new(faces: &Faces, passage: &Passage, tiles: &Tiles) -> Frame {
        /// Generous bound on the rounding of f64.
        const SURELY: f64 = 1.0 + 1.0 / (1_u64 << 30) as f64;
        let Rect { x0, y0, x1, y1 } = tiles.rect;
        let near = f64::from(passage.near);
        let entry = passage
            .entry
            .map(|(normal, distance)| (normal, distance * BEYOND));
        let rows = faces.screen_from_local.matrix3.transpose();
        let offset = faces.screen_from_local.translation;
        let row = |row: DVec3, offset| [row.x, row.y, row.z, offset];
        let middle = |start: u16, end: u16, align: usize| {
            let middle = (usize::from(start) + usize::from(end)) / 2;
            (middle - middle % align) as i32
        };
        let middle_sample = [middle(x0, x1, COLUMNS), middle(y0, y1, ROWS)];
        // Geometry cut off at the guard band must be off screen.
        let is_small = (x1 - x0).max(y1 - y0) < MAX_SAMPLES;
        Frame {
            matrix: [
                row(rows.x_axis, offset.x),
                row(rows.y_axis, offset.y),
                row(rows.z_axis, offset.z),
            ],
            near: (near * SURELY).max(1.0 / DEEPEST),
            behind: near / SURELY,
            entry: entry.map(|(normal, distance)| (normal.into(), distance * SURELY)),
            front: faces.front(passage) as f32,
            middle: middle_sample.map(f64::from),
            limits: [[x0, x1], [y0, y1]].map(|limits| limits.map(f64::from)),
            columns: [i32::from(x0) - middle_sample[0], i32::from(x1) - middle_sample[0]],
            rows: [i32::from(y0) - middle_sample[1], i32::from(y1) - middle_sample[1]],
            middle_sample,
            tile_columns: tiles.columns as u32,
            first_row: tiles.first_row as i32,
            clips: (is_small && near > 1.0 / DEEPEST).then_some((near, entry)),
        }
    }

    /// Returns (X, Y, W) of a position, by the same operations as the SIMD version.
    fn transform(&self, position: [f32; 3]) -> DVec3 {
        let [x, y, z] = position.map(f64::from);
        DVec3::from(self.matrix.map(|to| x * to[0] + y * to[1] + z * to[2] + to[3]))
    }
}

/// Buffers of the batch rasterizer.
#[derive(Default)]
pub(super) struct Batch {
    corners: Corners,
    queues: Queues,
    records: Records,
    run_queue: RunQueue,
    part: Clipper,
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

impl Batch {
    /// Rasterizes faces as occluders, except those that it lists in [`Batch::uncertain`].
    #[inline(always)]
    pub(super) fn hide<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        positions: &[Block],
        shapes: Shapes,
        tiles: &mut Tiles,
    ) {
        self.queues.uncertain.clear();
        let Shapes {
            quads,
            triangles,
            first_position,
        } = shapes;
        if positions.len() * LANES > MAX_CORNERS {
            let all = 0..(quads.len() + triangles.len()) as u32;
            self.queues.uncertain.extend(all);
            return;
        }
        corners::project(simd, frame, positions, &mut self.corners);
        let mut last_quads = [[first_position; 4]; LANES];
        let mut last_triangles = [[first_position; 3]; LANES];
        let groups_of_quads = quads.len().div_ceil(LANES);
        let groups = groups_of_quads + triangles.len().div_ceil(LANES);
        let mut next = 0;
        loop {
            if next == groups || self.queues.clipped.count >= LANES {
                self.queues.queue_clipped(simd, frame);
            } else if next < groups_of_quads {
                let group = Group::new(&shapes, quads, next, 0, &mut last_quads);
                let found = group.project(simd, &self.corners);
                self.queues.queue_quads(simd, frame, &found);
                self.queues
                    .clip(frame, positions, &group, found.to_clip, &mut self.part);
                next += 1;
            } else {
                let which = next - groups_of_quads;
                let group = Group::new(&shapes, triangles, which, quads.len(), &mut last_triangles);
                let found = group.project(simd, &self.corners);
                self.queues.queue_triangles(simd, frame, &found);
                self.queues
                    .clip(frame, positions, &group, found.to_clip, &mut self.part);
                next += 1;
            }
            let done = next == groups && self.queues.clipped.count == 0;
            if done || self.queues.are_full() {
                let least = if done { 1 } else { LANES };
                self.flush(simd, frame, tiles, least);
            }
            if done {
                return;
            }
        }
    }

    /// Returns the numbers of the faces skipped as uncertain, and the queue for their runs.
    pub(super) fn uncertain(&mut self) -> (&[u32], &mut RunQueue) {
        (&self.queues.uncertain, &mut self.run_queue)
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
            wide::draw(simd, frame, &faces, tiles, run_queue, uncertain);
            from += faces.lanes;
        }
        run_queue.cover(simd, tiles);
        wide.discard_before(from);
        from = 0;
        while quads.count >= from + least {
            let faces = quads.load(simd, from);
            small::draw::<S, 4, 2>(simd, frame, &faces, records, uncertain);
            records.merge(tiles);
            from += faces.lanes;
        }
        quads.discard_before(from);
        from = 0;
        while small.count >= from + least {
            let faces = small.load(simd, from);
            small::draw::<S, 3, 1>(simd, frame, &faces, records, uncertain);
            records.merge(tiles);
            from += faces.lanes;
        }
        small.discard_before(from);
    }
}
