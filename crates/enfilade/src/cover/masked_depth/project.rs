//! Projects vertices to the screen in fixed point, sixteen at a time, and clips triangles that fixed point cannot
//! represent.
//!
//! Coordinates are in units of 2⁻¹⁷ pixel from the frame's origin, so differences are exact integers. A vertex is odd
//! if it has no such coordinates: it is in front of the near plane or the entry plane, too far off screen or not
//! finite. A face with an odd vertex is clipped or left to f64, unless all its vertices are outside one clip plane.
//!
//! Clips at the near plane, at the entry plane and at a guard band around the screen. New edges are the clip planes
//! that the exact covers use, or off screen; the remaining parts of old edges keep their lines. The error of a new
//! vertex is far below a unit of fixed point, the error that setup assumes for all vertices.
//! Source: fixed point as in graphics hardware, but 512 times as fine, and never trusted beyond its unit. Sutherland,
//!     Hodgman, Reentrant Polygon Clipping, CACM 1974.
//! Cost: O(vertices); O(planes · corners) for each clipped triangle, one at a time: few cross a plane.
//! Exact within a unit: coordinates are computed in f64, as in the exact covers, and rounded once. A triangle whose new
//!     vertices could have a larger error is left to f64.

use super::LANES;
use super::sort::Queue;
use super::tiles::{COLUMNS, ROWS, Tiles};
use crate::faces::Faces;
use crate::raster::Clipper;
use crate::view::aperture::Rect;
use crate::view::passage::{BEYOND, Passage};
use crate::view::screen_map::{ScreenMap, eight_homogeneous, homogeneous};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, mask64x8, u32x16};
use glam::DVec3;

/// Maximum columns and rows of a screen for clipping: beyond, the guard band would be inside the screen.
const MAX_SAMPLES: u16 = 12_000;

/// One pixel in units of fixed point.
pub(super) const ONE_SHIFT: u32 = 17;
pub(super) const ONE: i32 = 1 << ONE_SHIFT;
pub(super) const HALF: i32 = ONE / 2;

/// Parameters shared by all faces of a batch.
pub(super) struct Frame {
    /// Rows of [`ScreenMap::linear`].
    matrix: [[f64; 4]; 3],
    is_parallel: bool,
    near: f64,
    /// A vertex with W below this is certainly in front of the near plane.
    behind: f64,
    /// Entry plane n · (X, Y, W) > d, moved back so that a vertex that passes is certainly behind it.
    entry: Option<([f64; 3], f64)>,
    /// Sign of the area of front-facing triangles, −1 or 1; 0 for double-sided faces.
    pub(super) front: f32,
    /// Origin of fixed point, in pixels.
    middle: [f64; 2],
    /// The same in samples, from the top left corner of the tiles.
    pub(super) middle_sample: [i32; 2],
    /// First column and end column (exclusive) of the rectangle, then its rows, in pixels of the screen.
    limits: [[f64; 2]; 2],
    /// Columns and rows of the rectangle relative to `middle`.
    pub(super) columns: [i32; 2],
    pub(super) rows: [i32; 2],
    pub(super) tile_columns: u32,
    /// Near-plane distance and entry plane for clipping; `None` if faces cannot be clipped here.
    clips: Option<(f64, Option<(DVec3, f64)>)>,
}

impl Frame {
    /// Prepares a batch of faces seen through a passage, rasterized into `tiles`.
    pub(super) fn new(faces: &Faces, passage: &Passage, tiles: &Tiles) -> Frame {
        /// Generous bound on the rounding of f64.
        const SURELY: f64 = 1.0 + 1.0 / (1_u64 << 30) as f64;
        let Rect { x0, y0, x1, y1 } = tiles.rect;
        let near = f64::from(passage.z_near);
        let entry = passage
            .entry
            .map(|(normal, distance)| (normal, distance * BEYOND));
        let ScreenMap { linear, is_parallel } = *faces.screen_from_local;
        let rows = linear.matrix3.transpose();
        let offset = linear.translation;
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
            is_parallel,
            near: (near * SURELY).max(1.0 / DEEPEST),
            behind: near / SURELY,
            entry: entry.map(|(normal, distance)| (normal.into(), distance * SURELY)),
            front: faces.front(passage) as f32,
            middle: middle_sample.map(f64::from),
            limits: [[x0, x1], [y0, y1]].map(|limits| limits.map(f64::from)),
            columns: [i32::from(x0) - middle_sample[0], i32::from(x1) - middle_sample[0]],
            rows: [i32::from(y0) - middle_sample[1], i32::from(y1) - middle_sample[1]],
            middle_sample: [
                middle_sample[0],
                middle_sample[1] - (tiles.first_row * ROWS) as i32,
            ],
            tile_columns: tiles.columns as u32,
            clips: (is_small && near > 1.0 / DEEPEST).then_some((near, entry)),
        }
    }

    /// Returns (X, Y, W) of a position, by the same operations as the SIMD version.
    fn transform(&self, position: [f32; 3]) -> DVec3 {
        let [x, y, z] = position.map(f64::from);
        let at = self.matrix.map(|to| x * to[0] + y * to[1] + z * to[2] + to[3]);
        homogeneous(at.into(), self.is_parallel)
    }
}

/// Column and row (in units from the frame's origin), bits of the reversed depth (positive; 0 if odd), and an outcode:
/// a bit for each clip plane that an odd vertex is certainly outside.
type Corner = [u32; 4];

/// Maximum number of vertices in a batch.
pub(super) const MAX_CORNERS: usize = 1024;

/// Projected vertices of a batch.
pub(super) struct Corners(pub(super) Box<[Corner; MAX_CORNERS]>);

impl Default for Corners {
    fn default() -> Corners {
        Corners(Box::new([[0; 4]; MAX_CORNERS]))
    }
}

/// A vertex farther from the origin is odd, in units: the limit lets sums and differences of two coordinates fit 32
/// bits.
const FARTHEST: f64 = (1_u32 << 30) as f64;

/// A vertex with W above this, or below its inverse, is odd: the limits keep results in f32 finite.
const DEEPEST: f64 = 1e18;

/// Rounds an f64 to the nearest integer when added, and leaves the integer in the lower half of the bits.
const TO_INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;

/// Sixteen positions: x of each, y of each, z of each.
pub(in crate::cover::masked_depth) type Block = [[f32; LANES]; 3];

/// Projects positions, up to the capacity of `corners`.
#[inline(always)]
pub(super) fn project<S: Simd>(simd: S, frame: &Frame, positions: &[Block], corners: &mut Corners) {
    for (block, placed) in positions.iter().zip(corners.0.as_chunks_mut().0) {
        project_lanes(simd, frame, block, placed);
    }
}

#[inline(always)]
fn project_lanes<S: Simd>(simd: S, frame: &Frame, at: &Block, placed: &mut [Corner; LANES]) {
    let (xs, xs_above) = f32x16::from_slice(simd, &at[0]).widen();
    let (ys, ys_above) = f32x16::from_slice(simd, &at[1]).widen();
    let (zs, zs_above) = f32x16::from_slice(simd, &at[2]).widen();
    let eight = [
        ScreenCorners::new(simd, frame, [xs, ys, zs]),
        ScreenCorners::new(simd, frame, [xs_above, ys_above, zs_above]),
    ];
    let [below, above] = [
        eight[0].fixed_point(simd, frame),
        eight[1].fixed_point(simd, frame),
    ];
    // Take the lower half of each.
    let columns = below[0]
        .bitcast::<u32x16<S>>()
        .unzip_low(above[0].bitcast::<u32x16<S>>());
    let rows = below[1]
        .bitcast::<u32x16<S>>()
        .unzip_low(above[1].bitcast::<u32x16<S>>());
    let rev_depth = below[2].narrow(above[2]).bitcast::<u32x16<S>>();
    let zero = u32x16::splat(simd, 0);
    let outside = if rev_depth.simd_eq(zero).any_true() {
        let [below, above] = [eight[0].outside(simd, frame), eight[1].outside(simd, frame)];
        below.unzip_low(above)
    } else {
        zero
    };
    let (first, second) = (columns.interleave(rev_depth), rows.interleave(outside));
    let all = [first.0.interleave(second.0), first.1.interleave(second.1)];
    let placed = placed.as_flattened_mut();
    all[0].0.store_slice(&mut placed[..16]);
    all[0].1.store_slice(&mut placed[16..32]);
    all[1].0.store_slice(&mut placed[32..48]);
    all[1].1.store_slice(&mut placed[48..64]);
}

/// (X, Y, W) of eight vertices.
struct ScreenCorners<S: Simd> {
    x: f64x8<S>,
    y: f64x8<S>,
    w: f64x8<S>,
}

impl<S: Simd> ScreenCorners<S> {
    #[inline(always)]
    fn new(simd: S, frame: &Frame, [x, y, z]: [f64x8<S>; 3]) -> ScreenCorners<S> {
        let [to_x, to_y, to_w] = &frame.matrix;
        let at = [
            x * to_x[0] + y * to_x[1] + z * to_x[2] + to_x[3],
            x * to_y[0] + y * to_y[1] + z * to_y[2] + to_y[3],
            x * to_w[0] + y * to_w[1] + z * to_w[2] + to_w[3],
        ];
        let [x, y, w] = eight_homogeneous(simd, at, frame.is_parallel);
        ScreenCorners { x, y, w }
    }

    /// Returns column and row with [`TO_INTEGER`] added, and reversed depth; 0 if odd.
    #[inline(always)]
    fn fixed_point(&self, simd: S, frame: &Frame) -> [f64x8<S>; 3] {
        let ScreenCorners { x, y, w } = *self;
        let zero = f64x8::splat(simd, 0.0);
        let rev_depth = f64x8::splat(simd, 1.0) / w;
        let column = (x * rev_depth - frame.middle[0]) * ONE as f64;
        let row = (y * rev_depth - frame.middle[1]) * ONE as f64;
        let farthest = f64x8::splat(simd, FARTHEST);
        let mut valid: mask64x8<S> = w.simd_gt(f64x8::splat(simd, frame.near))
            & column.abs().simd_lt(farthest)
            & row.abs().simd_lt(farthest)
            & w.simd_lt(f64x8::splat(simd, DEEPEST));
        if let Some(([a, b, c], distance)) = frame.entry {
            valid &= (x * a + y * b + w * c).simd_gt(f64x8::splat(simd, distance));
        }
        [
            column + TO_INTEGER,
            row + TO_INTEGER,
            valid.select(rev_depth, zero),
        ]
    }

    /// Returns outcodes, in the lower half of the bits: a bit for each clip plane that a vertex is certainly outside. A
    /// face with all vertices outside the same plane is not visible; this also holds for vertices behind the eye.
    #[inline(always)]
    fn outside(&self, simd: S, frame: &Frame) -> u32x16<S> {
        /// Generous bound on the rounding of f64; samples are half a pixel inside the limits.
        const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;
        let ScreenCorners { x, y, w } = *self;
        let mut sides = f64x8::splat(simd, TO_INTEGER);
        for (axis, at) in [x, y].into_iter().enumerate() {
            let [low, high] = [w * frame.limits[axis][0], w * frame.limits[axis][1]];
            let slack = (at.abs() + low.abs() + high.abs()) * ROUNDING;
            sides += bit(simd, (at + slack).simd_lt(low), 1 << (2 * axis));
            sides += bit(simd, (at - slack).simd_gt(high), 2 << (2 * axis));
        }
        sides += bit(simd, w.simd_lt(f64x8::splat(simd, frame.behind)), 16);
        if let Some(([a, b, c], distance)) = frame.entry {
            let at = [x * a, y * b, w * c];
            let slack = (at[0].abs() + at[1].abs() + at[2].abs()) * ROUNDING;
            let before = (at[0] + at[1] + at[2] + slack).simd_lt(f64x8::splat(simd, distance * BEFORE));
            sides += bit(simd, before, 32);
        }
        sides.bitcast()
    }
}

/// Returns the number `bit` in lanes where `so` is true, otherwise 0.
#[inline(always)]
fn bit<S: Simd>(simd: S, so: mask64x8<S>, bit: u32) -> f64x8<S> {
    so.select(f64x8::splat(simd, f64::from(bit)), f64x8::splat(simd, 0.0))
}

/// Factor by which a vertex in front of the entry plane is certainly in front of it.
const BEFORE: f64 = 1.0 - 1.0 / (1_u64 << 20) as f64;

/// Guard band: distance from the origin of fixed point at which triangles are clipped, in pixels; slightly less than
/// the largest representable coordinate.
const GUARD: f64 = FARTHEST / ONE as f64 - 64.0;

/// Maximum extent of a triangle relative to a clipped vertex's distance; below it the vertex's error is a small part of
/// a unit.
const SPREAD: f64 = (1_u64 << 28) as f64;

/// Clips a triangle and appends the result to `clipped`. Returns `false` if the result would be inaccurate or there is
/// no room. The result is empty if a vertex is not finite.
pub(super) fn clip(
    frame: &Frame,
    positions: [[f32; 3]; 3],
    number: u32,
    clipper: &mut Clipper,
    clipped: &mut Queue<3>,
) -> bool {
    if !positions.as_flattened().iter().all(|value| value.is_finite()) {
        return true;
    }
    let corners = positions.map(|position| frame.transform(position));
    let Some((near, entry)) = frame.clips else {
        return false;
    };
    // A face that ends at the near plane or at the entry plane is not drawn, so it must not occlude either.
    let ends_at = |(normal, distance): (DVec3, f64)| corners.iter().all(|at| normal.dot(*at) <= distance);
    if ends_at((DVec3::Z, near)) || entry.is_some_and(ends_at) {
        return true;
    }
    let reach = corners.iter().fold(0.0_f64, |reach, corner| {
        reach.max(corner.x.abs() + corner.y.abs() + corner.z.abs())
    });
    let [x, y] = frame.middle;
    let guards = [
        DVec3::new(1.0, 0.0, GUARD - x),
        DVec3::new(-1.0, 0.0, GUARD + x),
        DVec3::new(0.0, 1.0, GUARD - y),
        DVec3::new(0.0, -1.0, GUARD + y),
    ];
    let planes = [(DVec3::Z, near)]
        .into_iter()
        .chain(entry)
        .chain(guards.map(|guard| (guard, 0.0)));
    let left = clipper.clipped(&corners, planes);
    // Written so that NaN fails too.
    let is_good = |corner: &DVec3| corner.z < DEEPEST && reach < SPREAD * corner.z;
    if !left.iter().all(is_good) || clipped.room() + 2 < left.len() {
        return false;
    }
    let fields = |corner: &DVec3| {
        let rev_depth = 1.0 / corner.z;
        let place = |at: f64, middle: f64| {
            let units = (at * rev_depth - middle) * f64::from(ONE);
            (units + TO_INTEGER).to_bits() as u32
        };
        [
            place(corner.x, x),
            place(corner.y, y),
            (rev_depth as f32).to_bits(),
        ]
    };
    for last in 2..left.len() {
        clipped.push_one([0, last - 1, last].map(|corner| fields(&left[corner])), number);
    }
    true
}
