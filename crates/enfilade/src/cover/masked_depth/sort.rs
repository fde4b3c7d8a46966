//! Culls, classifies and queues faces before setup, sixteen at a time; a culled face costs a few cycles.
//!
//! Culls back-faces and faces that contain no sample centre. Small quads that are certainly convex on the screen are
//! queued as quads, all others as two triangles. The queues let the kernels work on sixteen faces of a kind.
//! Source: back-face and small-face culling as in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion
//!     Culling, HPG 2016, section 4. Culling only what is certainly outside, and quads, are additions.
//! Cost: O(faces).
//! Exact: faces that are uncertain within a unit of fixed point go to f64.

use super::batch::Shapes;
use super::project::{Block, Corners, Frame, HALF, MAX_CORNERS, ONE, ONE_SHIFT, clip};
use super::tiles::{COLUMNS, ROWS, Tiles};
use super::{COUNT, LANES};
use crate::raster::Clipper;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x4, u32x16};

/// Up to sixteen faces that are processed together.
pub(super) struct Group<'a, const SIDES: usize> {
    /// Corners, as indices that start at `first_position`.
    pub(super) corners: &'a [[u32; SIDES]; LANES],
    pub(super) first_position: u32,
    /// Number of the first face.
    pub(super) first: u32,
    /// Number of faces.
    pub(super) lanes: usize,
}

/// Sixteen faces in screen space.
pub(super) struct ScreenFaces<S: Simd, const SIDES: usize> {
    faces: FaceLanes<S, SIDES>,
    /// Faces whose corners are all representable in fixed point.
    valid: mask32x16<S>,
    /// Bit mask of the faces with an odd corner that may be visible.
    pub(super) to_clip: u64,
}

impl<'a, const SIDES: usize> Group<'a, SIDES> {
    /// Returns group `group` of a list of faces, of which the first has the number `first`. A partial last group is
    /// copied to `last`.
    #[inline(always)]
    pub(super) fn new(
        shapes: &Shapes,
        faces: &'a [[u32; SIDES]],
        group: usize,
        first: usize,
        last: &'a mut [[u32; SIDES]; LANES],
    ) -> Group<'a, SIDES> {
        let faces = &faces[group * LANES..];
        let corners = if let Some(corners) = faces.first_chunk() {
            corners
        } else {
            last[..faces.len()].copy_from_slice(faces);
            last
        };
        Group {
            corners,
            first_position: shapes.first_position,
            first: (first + group * LANES) as u32,
            lanes: faces.len().min(LANES),
        }
    }

    /// Gathers the projected corners of the faces.
    #[inline(always)]
    pub(super) fn project<S: Simd>(&self, simd: S, corners: &Corners) -> ScreenFaces<S, SIDES> {
        let mut faces = FaceLanes::none(simd);
        let mut beyond = u32x16::splat(simd, u32::MAX);
        let mut least = f32x16::splat(simd, f32::INFINITY);
        for corner in 0..SIDES {
            let [x, y, rev_depth, outside] = self.gather(simd, corners, corner);
            faces.x[corner] = x.bitcast();
            faces.y[corner] = y.bitcast();
            faces.rev_depth[corner] = rev_depth.bitcast();
            least = least.min(faces.rev_depth[corner]);
            beyond &= outside;
        }
        faces.number = u32x16::from_slice(simd, &COUNT) + self.first;
        faces.lanes = self.lanes;
        let there: mask32x16<S> = mask32x16::from_bitmask(simd, (1_u64 << self.lanes) - 1);
        let within = there & beyond.simd_eq(u32x16::splat(simd, 0));
        let valid = within & least.simd_gt(f32x16::splat(simd, 0.0));
        ScreenFaces {
            faces,
            valid,
            to_clip: (within & !valid).to_bitmask(),
        }
    }

    /// Gathers one corner of each face.
    #[inline(always)]
    fn gather<S: Simd>(&self, simd: S, corners: &Corners, which: usize) -> [u32x16<S>; 4] {
        let mut quarters = [u32x16::splat(simd, 0); 4];
        for (quarter, four) in quarters.iter_mut().zip(self.corners.as_chunks::<4>().0) {
            // A remainder, because the compiler would not move bounds checks out of the loads.
            let at = |corner: u32| (corner - self.first_position) as usize % MAX_CORNERS;
            let a = u32x4::simd_from(simd, corners.0[at(four[0][which])]);
            let b = u32x4::simd_from(simd, corners.0[at(four[1][which])]);
            let c = u32x4::simd_from(simd, corners.0[at(four[2][which])]);
            let d = u32x4::simd_from(simd, corners.0[at(four[3][which])]);
            *quarter = a.combine(b).combine(c.combine(d));
        }
        let [a, b, c, d] = quarters;
        let [even, odd] = [a.unzip_low(b), a.unzip_high(b)];
        let [even_above, odd_above] = [c.unzip_low(d), c.unzip_high(d)];
        [
            even.unzip_low(even_above),
            odd.unzip_low(odd_above),
            even.unzip_high(even_above),
            odd.unzip_high(odd_above),
        ]
    }
}

/// Queues of classified faces, and the faces that go to f64.
#[derive(Default)]
pub(super) struct Queues {
    /// Triangles of up to 31 columns and rows, from the sub-tile in which they begin.
    pub(super) small: Queue<3>,
    pub(super) wide: Queue<3>,
    /// Quads of the same size that are convex on the screen.
    pub(super) quads: Queue<4>,
    /// Triangles that result from clipping, not yet classified.
    pub(super) clipped: Queue<3>,
    /// Numbers of the faces that go to f64.
    pub(super) uncertain: Vec<u32>,
}

/// Maximum columns and rows of a small face.
const SMALL: i32 = 31;

impl Queues {
    /// Returns `true` if the queues must be flushed before another group is queued.
    #[inline(always)]
    pub(super) fn are_full(&self) -> bool {
        self.small.is_full() || self.wide.is_full() || self.quads.is_full()
    }

    /// Clips the faces of a group that have an odd corner.
    pub(super) fn clip<const SIDES: usize>(
        &mut self,
        frame: &Frame,
        positions: &[Block],
        group: &Group<SIDES>,
        mut to_clip: u64,
        clipper: &mut Clipper,
    ) {
        while to_clip != 0 {
            let lane = to_clip.trailing_zeros();
            to_clip &= to_clip - 1;
            let at = group.corners[lane as usize].map(|corner| {
                let corner = (corner - group.first_position) as usize;
                positions[corner / LANES].map(|axis| axis[corner % LANES])
            });
            let number = group.first + lane;
            for last in 2..SIDES {
                let three = [at[0], at[last - 1], at[last]];
                if !clip(frame, three, number, clipper, &mut self.clipped) {
                    self.uncertain.push(number);
                    break;
                }
            }
        }
    }

    /// Classifies and queues up to sixteen clipped triangles.
    #[inline(always)]
    pub(super) fn queue_clipped<S: Simd>(&mut self, simd: S, frame: &Frame, tiles: &Tiles) {
        let from = self.clipped.count - self.clipped.count.min(LANES);
        let faces = self.clipped.load(simd, from);
        let valid = mask32x16::from_bitmask(simd, (1_u64 << faces.lanes) - 1);
        self.sort_triangles(simd, frame, tiles, &faces, valid);
        self.clipped.count = from;
    }

    #[inline(always)]
    pub(super) fn queue_triangles<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        tiles: &Tiles,
        found: &ScreenFaces<S, 3>,
    ) {
        self.sort_triangles(simd, frame, tiles, &found.faces, found.valid);
    }

    /// Queues the quads that are not culled.
    #[inline(always)]
    pub(super) fn queue_quads<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        tiles: &Tiles,
        found: &ScreenFaces<S, 4>,
    ) {
        let quads = &found.faces;
        let extent = Extent::new(simd, frame, &quads.x, &quads.y);
        let [mut dx, mut dy] = [[f32x16::splat(simd, 0.0); 4]; 2];
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            dx[corner] = (quads.x[next] - quads.x[corner]).to_float();
            dy[corner] = (quads.y[next] - quads.y[corner]).to_float();
        }
        // Winding of the triangle of each corner and its neighbours.
        let [mut all_left, mut all_right] = [mask32x16::splat(simd, true); 2];
        let mut behind = all_left;
        for corner in 0..4 {
            let next = (corner + 1) % 4;
            let winding = Winding::new(simd, [dx[corner], dx[next]], [dy[corner], dy[next]]);
            all_left &= winding.left;
            all_right &= winding.right;
            // These two triangles are the halves of the quad.
            if corner % 2 == 0 {
                behind &= winding.is_behind(simd, frame);
            }
        }
        let seen = found.valid & extent.any & !behind;
        let small = seen & extent.small & (all_left | all_right);
        self.quads.push(small, quads);
        let others = seen & !small;
        if others.any_true() {
            self.sort_triangles(simd, frame, tiles, &quads.half([1, 2]), others);
            self.sort_triangles(simd, frame, tiles, &quads.half([2, 3]), others);
        }
    }

    /// Queues the triangles that are not culled.
    #[inline(always)]
    fn sort_triangles<S: Simd>(
        &mut self,
        simd: S,
        frame: &Frame,
        tiles: &Tiles,
        faces: &FaceLanes<S, 3>,
        valid: mask32x16<S>,
    ) {
        let FaceLanes { x, y, number, .. } = faces;
        let extent = Extent::new(simd, frame, x, y);
        let dx = [(x[1] - x[0]).to_float(), (x[2] - x[0]).to_float()];
        let dy = [(y[1] - y[0]).to_float(), (y[2] - y[0]).to_float()];
        let winding = Winding::new(simd, dx, dy);
        let seen = valid & extent.any & !winding.is_behind(simd, frame);
        let sure = seen & (winding.left | winding.right);
        self.small.push(sure & extent.small, faces);
        let wide = extent.shown(simd, frame, tiles, sure & !extent.small, &faces.rev_depth);
        self.wide.push(wide, faces);
        let mut left = (seen & !sure).to_bitmask();
        if left != 0 {
            let numbers = number.to_array();
            while left != 0 {
                self.uncertain
                    .push(numbers[left.trailing_zeros() as usize % LANES]);
                left &= left - 1;
            }
        }
    }
}

/// Faces that may cover any sample, and faces that are small.
struct Extent<S: Simd> {
    any: mask32x16<S>,
    small: mask32x16<S>,
    columns: Samples<S>,
    rows: Samples<S>,
}

impl<S: Simd> Extent<S> {
    #[inline(always)]
    fn new<const SIDES: usize>(
        simd: S,
        frame: &Frame,
        x: &[i32x16<S>; SIDES],
        y: &[i32x16<S>; SIDES],
    ) -> Extent<S> {
        let columns = Samples::between(simd, x, frame.columns);
        let rows = Samples::between(simd, y, frame.rows);
        Extent {
            any: columns.end.simd_gt(columns.first) & rows.end.simd_gt(rows.first),
            small: (columns.end - (columns.first & !7)).simd_le(SMALL)
                & (rows.end - (rows.first & !3)).simd_le(SMALL),
            columns,
            rows,
        }
    }

    /// Returns those of the faces `which` that are not hidden, by [`Tiles::farthest`] alone.
    #[inline(always)]
    fn shown<const SIDES: usize>(
        &self,
        simd: S,
        frame: &Frame,
        tiles: &Tiles,
        which: mask32x16<S>,
        rev_depth: &[f32x16<S>; SIDES],
    ) -> mask32x16<S> {
        let mut left = which.to_bitmask();
        if left == 0 {
            return which;
        }
        let mut nearest = rev_depth[0];
        for &rev_depth in &rev_depth[1..] {
            nearest = nearest.max(rev_depth);
        }
        let nearest = (nearest * (1.0 + EXACTNESS)).to_array();
        const ACROSS: u32 = COLUMNS.trailing_zeros();
        const DOWN: u32 = ROWS.trailing_zeros();
        let [column, row] = frame.middle_sample;
        let columns = [
            ((self.columns.first + column) >> ACROSS).to_array(),
            ((self.columns.end + (column + COLUMNS as i32 - 1)) >> ACROSS).to_array(),
        ];
        let rows = [
            ((self.rows.first + row) >> DOWN).to_array(),
            ((self.rows.end + (row + ROWS as i32 - 1)) >> DOWN).to_array(),
        ];
        let mut shown = 0;
        while left != 0 {
            let lane = left.trailing_zeros() as usize % LANES;
            left &= left - 1;
            let [columns, rows] =
                [&columns, &rows].map(|ends| ends[0][lane] as usize..ends[1][lane] as usize);
            let is_hidden = tiles.are_nearer(columns, rows, nearest[lane]);
            shown |= u64::from(!is_hidden) << lane;
        }
        mask32x16::from_bitmask(simd, shown)
    }
}

/// Faces whose winding is certain.
struct Winding<S: Simd> {
    left: mask32x16<S>,
    right: mask32x16<S>,
}

impl<S: Simd> Winding<S> {
    /// Computes the winding from two sides of each triangle.
    #[inline(always)]
    fn new(simd: S, dx: [f32x16<S>; 2], dy: [f32x16<S>; 2]) -> Winding<S> {
        let [one, other] = [dx[0] * dy[1], dx[1] * dy[0]];
        let area = one - other;
        // Bounds the rounding of f32 and the effect of moving vertices by a unit.
        let slack = (one.abs() + other.abs()) * EXACTNESS
            + (dx[0].abs() + dx[1].abs() + dy[0].abs() + dy[1].abs()) * 4.0
            + f32x16::splat(simd, 16.0);
        Winding {
            left: area.simd_gt(slack),
            right: area.simd_lt(-slack),
        }
    }

    /// Returns the faces that are certainly back-facing.
    #[inline(always)]
    fn is_behind(&self, simd: S, frame: &Frame) -> mask32x16<S> {
        if frame.front > 0.0 {
            self.right
        } else if frame.front < 0.0 {
            self.left
        } else {
            mask32x16::splat(simd, false)
        }
    }
}

/// Generous bound on the relative error of two products and their difference in f32.
pub(super) const EXACTNESS: f32 = 1.0 / (1_u32 << 21) as f32;

/// Units between a sample and the first or last corner for the sample to be certain.
const SURE_UNITS: i32 = 8;

/// Samples between the minimum and the maximum of coordinates on one axis.
pub(super) struct Samples<S: Simd> {
    /// First sample that may be inside and the end (exclusive), from the frame's origin, clamped to the limits.
    pub(super) first: i32x16<S>,
    pub(super) end: i32x16<S>,
    /// Whether they are certain, apart from the limits.
    pub(super) sure: mask32x16<S>,
}

impl<S: Simd> Samples<S> {
    #[inline(always)]
    pub(super) fn between<const SIDES: usize>(
        simd: S,
        places: &[i32x16<S>; SIDES],
        limits: [i32; 2],
    ) -> Samples<S> {
        let [mut least, mut greatest] = [places[0]; 2];
        for &place in &places[1..] {
            least = least.min(place);
            greatest = greatest.max(place);
        }
        // One unit of margin on each side, because coordinates are rounded.
        let first = (least + (ONE - 1 - HALF - 1)) >> ONE_SHIFT;
        let last = (greatest + (1 - HALF)) >> ONE_SHIFT;
        // The same range with a few units less: edges that are less than a few units high have no accurate slope.
        let sure = first.simd_eq((least + (ONE - 1 - HALF + SURE_UNITS)) >> ONE_SHIFT)
            & last.simd_eq((greatest + (-SURE_UNITS - HALF)) >> ONE_SHIFT);
        Samples {
            first: first.max(i32x16::splat(simd, limits[0])),
            end: (last + 1).min(i32x16::splat(simd, limits[1])),
            sure,
        }
    }
}

/// Maximum number of queued faces; two more groups fit while they are being queued.
const MAX_QUEUED: usize = 128;
const ROOM: usize = MAX_QUEUED + 2 * LANES;

/// Faces waiting for setup: columns, rows and reversed depths of their corners, and their numbers.
pub(super) struct Queue<const SIDES: usize> {
    pub(super) count: usize,
    x: [[u32; ROOM]; SIDES],
    y: [[u32; ROOM]; SIDES],
    rev_depth: [[u32; ROOM]; SIDES],
    number: [u32; ROOM],
}

impl<const SIDES: usize> Default for Queue<SIDES> {
    fn default() -> Queue<SIDES> {
        Queue {
            count: 0,
            x: [[0; ROOM]; SIDES],
            y: [[0; ROOM]; SIDES],
            rev_depth: [[0; ROOM]; SIDES],
            number: [0; ROOM],
        }
    }
}

/// Up to sixteen faces, one per lane, with corners in units of fixed point.
pub(super) struct FaceLanes<S: Simd, const SIDES: usize> {
    pub(super) x: [i32x16<S>; SIDES],
    pub(super) y: [i32x16<S>; SIDES],
    pub(super) rev_depth: [f32x16<S>; SIDES],
    pub(super) number: u32x16<S>,
    /// Number of faces; the other lanes are undefined.
    pub(super) lanes: usize,
}

impl<const SIDES: usize> Queue<SIDES> {
    /// Returns `true` if the queue must be flushed before another group is queued.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.count + LANES > MAX_QUEUED
    }

    /// Returns the number of faces that still fit.
    pub(super) fn room(&self) -> usize {
        ROOM - self.count
    }

    /// Queues one face: column, row and reversed depth of each corner.
    pub(super) fn push_one(&mut self, corners: [[u32; 3]; SIDES], number: u32) {
        for (corner, [x, y, rev_depth]) in corners.into_iter().enumerate() {
            self.x[corner][self.count] = x;
            self.y[corner][self.count] = y;
            self.rev_depth[corner][self.count] = rev_depth;
        }
        self.number[self.count] = number;
        self.count += 1;
    }

    /// Queues the faces in the lanes `which`.
    #[inline(always)]
    pub(super) fn push<S: Simd>(&mut self, which: mask32x16<S>, faces: &FaceLanes<S, SIDES>) {
        let found = which.to_bitmask().count_ones() as usize;
        if found == 0 {
            return;
        }
        let start = self.count.min(ROOM - LANES);
        for corner in 0..SIDES {
            keep(which, faces.x[corner].bitcast(), &mut self.x[corner], start);
            keep(which, faces.y[corner].bitcast(), &mut self.y[corner], start);
            let kept = &mut self.rev_depth[corner];
            keep(which, faces.rev_depth[corner].bitcast(), kept, start);
        }
        keep(which, faces.number, &mut self.number, start);
        self.count = start + found;
    }

    /// Loads up to sixteen faces, starting at index `from`.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, from: usize) -> FaceLanes<S, SIDES> {
        let start = from.min(ROOM - LANES);
        let mut faces = FaceLanes::none(simd);
        for corner in 0..SIDES {
            faces.x[corner] = get(simd, &self.x[corner], start).bitcast();
            faces.y[corner] = get(simd, &self.y[corner], start).bitcast();
            faces.rev_depth[corner] = get(simd, &self.rev_depth[corner], start).bitcast();
        }
        faces.number = get(simd, &self.number, start);
        faces.lanes = (self.count - from).min(LANES);
        faces
    }

    /// Removes the faces before index `place`; fewer than sixteen must remain.
    #[inline(always)]
    pub(super) fn discard_before(&mut self, place: usize) {
        self.count -= place;
        if place == 0 || self.count == 0 {
            return;
        }
        let corners = self.x.iter_mut().chain(&mut self.y).chain(&mut self.rev_depth);
        for kept in corners.chain([&mut self.number]) {
            kept.copy_within(place..place + LANES, 0);
        }
    }
}

#[inline(always)]
fn keep<S: Simd>(which: mask32x16<S>, field: u32x16<S>, kept: &mut [u32; ROOM], start: usize) {
    field.compress(which).store_slice(&mut kept[start..start + LANES]);
}

#[inline(always)]
fn get<S: Simd>(simd: S, kept: &[u32; ROOM], start: usize) -> u32x16<S> {
    u32x16::from_slice(simd, &kept[start..start + LANES])
}

impl<S: Simd, const SIDES: usize> FaceLanes<S, SIDES> {
    #[inline(always)]
    pub(super) fn none(simd: S) -> FaceLanes<S, SIDES> {
        FaceLanes {
            x: [i32x16::splat(simd, 0); SIDES],
            y: [i32x16::splat(simd, 0); SIDES],
            rev_depth: [f32x16::splat(simd, 0.0); SIDES],
            number: u32x16::splat(simd, 0),
            lanes: 0,
        }
    }
}

impl<S: Simd> FaceLanes<S, 4> {
    /// Returns one triangle of each quad: its first corner and two adjacent ones.
    #[inline(always)]
    pub(super) fn half(&self, [a, b]: [usize; 2]) -> FaceLanes<S, 3> {
        FaceLanes {
            x: [self.x[0], self.x[a], self.x[b]],
            y: [self.y[0], self.y[a], self.y[b]],
            rev_depth: [self.rev_depth[0], self.rev_depth[a], self.rev_depth[b]],
            number: self.number,
            lanes: self.lanes,
        }
    }
}
