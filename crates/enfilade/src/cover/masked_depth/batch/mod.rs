//! Batches of triangles and quads, let into the tiles as fast as the machine can.
//!
//! Corners are put on the screen in fixed point ([`corners`]), sixteen faces at a time are looked at ([`sort`]), wait
//! ([`queue`]) and are set up ([`lanes`]), and small ones are covered side by side ([`small`]), wide ones row by row
//! ([`wide`]). All of it is in numbers of 32 bits, which may be off: wherever that could change a sample, the face is named
//! in [`Batch::uncertain`] and left to the rasteriser of the exact covers, of which no bit differs then. What has a corner
//! that is nowhere on the screen is cut first ([`clip`]).
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016; filters as in Shewchuk,
//!     Adaptive Precision Floating-Point Arithmetic, 1997.
//! Cost: O(corners + faces + tiles).
//! Conservative: covers the very samples that the exact covers do, and is nowhere nearer than they.

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
use super::rows::Waiting;
use super::tile::{COLUMNS, ROWS};
use crate::aperture::Rect;
use crate::cover::part::Part;
use crate::faces::Faces;
use crate::passage::{BEYOND, Passage};
pub(super) use corners::Block;
use corners::{Corners, DEEPEST, MAX_CORNERS};
use fearless_simd::prelude::*;
use glam::DVec3;
use records::Records;
use sort::{Group, Queues};

/// Lanes of a kernel, at every level, and their numbers.
pub(super) const LANES: usize = 16;
pub(super) const COUNT: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// A screen of more columns or rows reaches to where corners are odd.
const MAX_SAMPLES: u16 = 12_000;

/// A pixel in units of fixed point.
const ONE_SHIFT: u32 = 17;
const ONE: i32 = 1 << ONE_SHIFT;
const HALF: i32 = ONE / 2;

/// What holds for a batch.
pub(super) struct Frame {
    /// Rows of the map from positions to (X, Y, W).
    matrix: [[f64; 4]; 3],
    near: f64,
    /// What is nearer is surely before the near distance.
    behind: f64,
    /// What lies surely beyond the last portal.
    entry: Option<([f64; 3], f64)>,
    /// −1 or 1: the sign of a triangle's area where it is seen from its front; 0 where both sides are seen.
    front: f32,
    /// Where fixed point is counted from, in pixels.
    middle: [f64; 2],
    middle_sample: [i32; 2],
    /// The first column of the rectangle and the one after the last, and its rows, on the screen.
    limits: [[f64; 2]; 2],
    /// Samples of the rectangle, from the middle.
    columns: [i32; 2],
    rows: [i32; 2],
    tile_columns: u32,
    /// Rows of tiles above those that are covered.
    first_row: i32,
    /// The near distance and the plane of the last portal, where triangles are cut; `None` where they cannot be.
    clips: Option<(f64, Option<(DVec3, f64)>)>,
}

impl Frame {
    /// Of faces that are seen through a passage, and go into some tiles.
    pub(super) fn new(faces: &Faces, passage: &Passage, tiles: &Tiles) -> Frame {
        /// What f64 rounds, and ample.
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
        // What is cut off far from the middle must be off the screen.
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

    /// (X, Y, W) of a position, by the same operations as those of sixteen.
    fn on_screen(&self, position: [f32; 3]) -> DVec3 {
        let [x, y, z] = position.map(f64::from);
        DVec3::from(self.matrix.map(|to| x * to[0] + y * to[1] + z * to[2] + to[3]))
    }
}

/// Room to work in.
#[derive(Default)]
pub(super) struct Batch {
    corners: Corners,
    queues: Queues,
    records: Records,
    waiting: Waiting,
    part: Part,
}

/// Faces of which each corner is a place among some positions, counted from `first_position`.
#[derive(Clone, Copy)]
pub(super) struct Shapes<'a> {
    /// Convex, and the first of all that are numbered.
    pub(super) quads: &'a [[u32; 4]],
    pub(super) triangles: &'a [[u32; 3]],
    pub(super) first_position: u32,
}

impl Shapes<'_> {
    /// How many triangles they come to.
    pub(super) fn triangles(&self) -> u64 {
        (2 * self.quads.len() + self.triangles.len()) as u64
    }

    /// The corners of a face.
    pub(super) fn corners(&self, number: usize) -> &[u32] {
        match self.quads.get(number) {
            Some(quad) => quad,
            None => &self.triangles[number - self.quads.len()],
        }
    }
}

impl Batch {
    /// Lets faces hide what is behind them. What is not certain is left in [`Batch::uncertain`].
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
        corners::place(simd, frame, positions, &mut self.corners);
        let mut last_quads = [[first_position; 4]; LANES];
        let mut last_triangles = [[first_position; 3]; LANES];
        let groups_of_quads = quads.len().div_ceil(LANES);
        let groups = groups_of_quads + triangles.len().div_ceil(LANES);
        let mut next = 0;
        loop {
            if next == groups || self.queues.clipped.count >= LANES {
                self.queues.let_in_clipped(simd, frame);
            } else if next < groups_of_quads {
                let group = Group::new(&shapes, quads, next, 0, &mut last_quads);
                let found = group.find(simd, &self.corners);
                self.queues.let_in_quads(simd, frame, &found);
                self.queues
                    .clip(frame, positions, &group, found.odd, &mut self.part);
                next += 1;
            } else {
                let which = next - groups_of_quads;
                let group = Group::new(&shapes, triangles, which, quads.len(), &mut last_triangles);
                let found = group.find(simd, &self.corners);
                self.queues.let_in_triangles(simd, frame, &found);
                self.queues
                    .clip(frame, positions, &group, found.odd, &mut self.part);
                next += 1;
            }
            let done = next == groups && self.queues.clipped.count == 0;
            if done || self.queues.are_full() {
                let least = if done { 1 } else { LANES };
                self.work_off(simd, frame, tiles, least);
            }
            if done {
                return;
            }
        }
    }

    /// Numbers of the faces that were left out because they are not certain, and where their runs may wait.
    pub(super) fn uncertain(&mut self) -> (&[u32], &mut Waiting) {
        (&self.queues.uncertain, &mut self.waiting)
    }

    /// Covers what those that wait cover, wide ones first, where there are at least `least` in a group.
    #[inline(always)]
    fn work_off<S: Simd>(&mut self, simd: S, frame: &Frame, tiles: &mut Tiles, least: usize) {
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
            waiting,
            ..
        } = self;
        let mut from = 0;
        while wide.count >= from + least {
            let faces = wide.sixteen(simd, from);
            wide::draw(simd, frame, &faces, tiles, waiting, uncertain);
            from += faces.lanes;
        }
        waiting.cover(simd, tiles);
        wide.forget_before(from);
        from = 0;
        while quads.count >= from + least {
            let faces = quads.sixteen(simd, from);
            small::draw::<S, 4, 2>(simd, frame, &faces, records, uncertain);
            records.merge(tiles);
            from += faces.lanes;
        }
        quads.forget_before(from);
        from = 0;
        while small.count >= from + least {
            let faces = small.sixteen(simd, from);
            small::draw::<S, 3, 1>(simd, frame, &faces, records, uncertain);
            records.merge(tiles);
            from += faces.lanes;
        }
        small.forget_before(from);
    }
}
