//! Rasterizes wide triangles one after the other, with rows of tiles in the lanes, then rows of samples, then the
//! sub-tiles of a tile.
//!
//! Bounds of the columns in sixteen rows of tiles tell which tiles a triangle reaches and which it covers entirely.
//! Tiles nearer than the whole triangle are skipped before its edges are intersected with scanlines. Where an end of a
//! scanline is uncertain in f32, the row of tiles is computed again in f64.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, sections 3.1 to 3.3.
//! Cost: a triangle O(rows of tiles) + O(tiles it overlaps).
//! Exact: a triangle with an end that is uncertain in f64 too, because vertices are rounded to fixed point, goes to the
//!     f64 rasterizer of the exact covers.

use super::project::{Frame, ONE};
use super::runs::{RowDepth, RunQueue, SEGMENT};
use super::setup::{Edge, FaceSetup};
use super::sort::FaceLanes;
use super::tiles::{COLUMNS, ROWS, SUB_COLUMNS, SUB_ROWS, Tiles};
use super::{COUNT, LANES};
use crate::simd::apart;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, i32x16, mask32x16, u32x16};

/// Setup of sixteen triangles as arrays, indexed by lane.
struct SetupArrays {
    /// From the top left corner of the tiles.
    origin: [[i32; LANES]; 2],
    columns: [[i32; LANES]; 2],
    rows: [[i32; LANES]; 2],
    edges: [[[f32; LANES]; 3]; 4],
    /// Lower bound of the reversed depth in the first sub-tile, its change per column and row, and its range.
    plane: [[f32; LANES]; 5],
    /// Columns and rows of the corners, in units.
    corners: [[[i32; LANES]; 2]; 3],
    number: [u32; LANES],
}

/// Queues up to sixteen wide triangles; appends the numbers of uncertain ones to `uncertain`.
#[inline(always)]
pub(super) fn draw<S: Simd>(
    simd: S,
    frame: &Frame,
    triangles: &FaceLanes<S, 3>,
    tiles: &mut Tiles,
    run_queue: &mut RunQueue,
    uncertain: &mut Vec<u32>,
) {
    let align = [COLUMNS as i32, ROWS as i32];
    let lanes = apart!(simd, FaceSetup::<S, 1>::new(simd, frame, triangles, align));
    let edge = |edge: &Edge<S>| {
        [
            edge.slope.to_array(),
            edge.least.to_array(),
            edge.greatest.to_array(),
        ]
    };
    let unsure = lanes.unsure.to_bitmask();
    let stored = SetupArrays {
        origin: [
            (lanes.origin[0] + frame.middle_sample[0]).to_array(),
            (lanes.origin[1] + frame.middle_sample[1]).to_array(),
        ],
        columns: [lanes.columns[0].to_array(), lanes.columns[1].to_array()],
        rows: [lanes.rows[0].to_array(), lanes.rows[1].to_array()],
        edges: [
            edge(&lanes.edges.left),
            edge(&lanes.edges.right),
            edge(&lanes.edges.others[0][0]),
            edge(&lanes.edges.others[0][1]),
        ],
        plane: apart!(simd, first_depths(simd, &lanes)),
        corners: [0, 1, 2].map(|corner| [triangles.x[corner].to_array(), triangles.y[corner].to_array()]),
        number: triangles.number.to_array(),
    };
    for lane in 0..triangles.lanes.min(LANES) {
        if run_queue.are_many() {
            run_queue.cover(simd, tiles);
        }
        let of = Lane {
            frame,
            stored: &stored,
            lane,
        };
        let is_sure = unsure >> lane & 1 == 0 && apart!(simd, draw_one(simd, &of, tiles, run_queue));
        if !is_sure {
            uncertain.push(stored.number[lane]);
        }
    }
}

/// Returns the lower bound of the reversed depth in the first sub-tile of each face, its change per column and row, and
/// its range.
#[inline(always)]
fn first_depths<S: Simd>(simd: S, lanes: &FaceSetup<S, 1>) -> [[f32; LANES]; 5] {
    /// Values below this, times the columns of any screen, fit f32.
    const LARGE: f32 = 1e30;
    /// Bound on the rounding of f32, as a part of the terms that are added.
    const ROUNDING: f32 = 1.0 / (1_u32 << 21) as f32;
    let plane = &lanes.plane;
    let zero = f32x16::splat(simd, 0.0);
    let [by_column, by_row] = plane.slope;
    // The minimum over a sub-tile is at a corner: at its first or last column and row.
    let across = by_column.simd_lt(zero).select(
        f32x16::splat(simd, SUB_COLUMNS as f32 - 0.5),
        f32x16::splat(simd, 0.5),
    );
    let down = by_row.simd_lt(zero).select(
        f32x16::splat(simd, SUB_ROWS as f32 - 0.5),
        f32x16::splat(simd, 0.5),
    );
    // Sub-tiles are up to a tile away from the samples.
    let width = lanes.columns[1].to_float::<f32x16<S>>() + COLUMNS as f32;
    let height = lanes.rows[1].to_float::<f32x16<S>>() + ROWS as f32;
    let terms = by_column.abs() * width + by_row.abs() * height + plane.greatest;
    let at = (plane.at + by_column * across + by_row * down) - terms * ROUNDING;
    // If f32 could overflow or a value is NaN, only the minimum is known.
    let large = f32x16::splat(simd, LARGE);
    let known = at.abs().simd_lt(large) & terms.simd_lt(large);
    [
        known.select(at, zero).to_array(),
        known.select(by_column, zero).to_array(),
        known.select(by_row, zero).to_array(),
        plane.least.to_array(),
        plane.greatest.to_array(),
    ]
}

const CENTRES_IN_F64: [f64; LANES / 2] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
const CENTRES: [f32; LANES] = [
    0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 10.5, 11.5, 12.5, 13.5, 14.5, 15.5,
];

/// One of sixteen triangles.
struct Lane<'a> {
    frame: &'a Frame,
    stored: &'a SetupArrays,
    lane: usize,
}

/// Queues a triangle. Returns `false` if a part of it is uncertain and was left out.
#[inline(always)]
fn draw_one<S: Simd>(simd: S, of: &Lane, tiles: &mut Tiles, run_queue: &mut RunQueue) -> bool {
    let Lane { stored, lane, .. } = *of;
    let [at, by_column, by_row, least, greatest] = stored.plane.map(|field| field[lane]);
    let [left_of, above] = [stored.origin[0][lane], stored.origin[1][lane]];
    let end_row = (stored.rows[1][lane] + ROWS as i32 - 1) / ROWS as i32;
    let first = RowDepth::new(simd, at, [by_column, by_row], least);
    let mut tile = (above / ROWS as i32) as usize * tiles.columns + (left_of / COLUMNS as i32) as usize;
    let mut is_sure = true;
    let mut start = 0;
    while start < end_row {
        let reach = apart!(simd, Reach::new(simd, of, start));
        for row in start..end_row.min(start + LANES as i32) {
            let place = (row - start) as usize % LANES;
            let mut from = reach.any[0][place];
            while from < reach.any[1][place] {
                if run_queue.is_full() {
                    run_queue.cover(simd, tiles);
                }
                let to = reach.any[1][place].min(from + SEGMENT);
                let whole = reach.whole[0][place]..reach.whole[1][place];
                let listed = run_queue.list(simd, tiles, tile, [from..to, whole], greatest);
                from = to;
                if !listed.any {
                    continue;
                }
                let row = row * ROWS as i32;
                let depth = first.moved(by_row * row as f32);
                if !listed.some {
                    run_queue.push(tile, [i32x16::splat(simd, 0); 2], &depth);
                } else if let Some(runs) = runs_of(simd, of, row) {
                    run_queue.push(tile, runs, &depth);
                } else {
                    run_queue.unlist(&listed);
                    is_sure = false;
                }
            }
            tile += tiles.columns;
        }
        start += LANES as i32;
    }
    is_sure
}

/// Columns of tiles that a triangle reaches in sixteen rows of tiles, and those that it covers entirely: first column
/// and end column (exclusive), from its origin.
struct Reach {
    any: [[i32; LANES]; 2],
    whole: [[i32; LANES]; 2],
}

impl Reach {
    /// Computes it for the rows of tiles from `row` on.
    #[inline(always)]
    fn new<S: Simd>(simd: S, of: &Lane, row: i32) -> Reach {
        let Lane { stored, lane, .. } = *of;
        let edges = &stored.edges;
        let columns = stored.columns.map(|columns| columns[lane]);
        let rows = stored.rows.map(|rows| rows[lane]);
        let top = (f32x16::from_slice(simd, &CENTRES) - 0.5) * ROWS as f32 + (row as f32 * ROWS as f32 + 0.5);
        let first = top.max(f32x16::splat(simd, rows[0] as f32 + 0.5));
        let last = (top + (ROWS as f32 - 1.0)).min(f32x16::splat(simd, rows[1] as f32 - 0.5));
        let [left, right] = [
            extremes(edges, 0, lane, [first, last]),
            extremes(edges, 1, lane, [first, last]),
        ];
        let third = [
            extremes(edges, 2, lane, [first, last]),
            extremes(edges, 3, lane, [first, last]),
        ];
        let start = within(simd, left[0].max(third[0][0]), columns);
        let start_of_whole = within(simd, left[1].max(third[0][1]), columns);
        let end = within(simd, right[1].min(third[1][1]), columns);
        let end_of_whole = within(simd, right[0].min(third[1][0]), columns);
        let all_rows = (last - first).simd_eq(f32x16::splat(simd, ROWS as f32 - 1.0));
        const SHIFT: u32 = COLUMNS.trailing_zeros();
        Reach {
            any: [
                (start >> SHIFT).to_array(),
                ((end + (COLUMNS as i32 - 1)) >> SHIFT).to_array(),
            ],
            whole: [
                ((start_of_whole + (COLUMNS as i32 - 1)) >> SHIFT).to_array(),
                all_rows
                    .select(end_of_whole >> SHIFT, i32x16::splat(simd, 0))
                    .to_array(),
            ],
        }
    }
}

/// Returns a lower and an upper bound of the crossings of an edge with all rows between two. Crossings are linear, so the
/// extremes are in one of the two.
#[inline(always)]
fn extremes<S: Simd>(
    edges: &[[[f32; LANES]; 3]; 4],
    edge: usize,
    lane: usize,
    rows: [f32x16<S>; 2],
) -> [f32x16<S>; 2] {
    let [slope, least, greatest] = [edges[edge][0][lane], edges[edge][1][lane], edges[edge][2][lane]];
    let [first, last] = [rows[0] * slope, rows[1] * slope];
    [first.min(last) + least, first.max(last) + greatest]
}

/// Returns the first column whose centre is not left of a crossing, clamped to `columns`.
#[inline(always)]
fn within<S: Simd>(simd: S, crossing: f32x16<S>, columns: [i32; 2]) -> i32x16<S> {
    let [low, high] = columns.map(|column| f32x16::splat(simd, column as f32 - 0.5));
    crossing.max(low).min(high).ceil().to_int()
}

/// Returns the runs of samples of a triangle in sixteen rows from `row` on: first column and end column (exclusive), from
/// its origin. `None` if they are uncertain.
#[inline(always)]
fn runs_of<S: Simd>(simd: S, of: &Lane, row: i32) -> Option<[i32x16<S>; 2]> {
    let Lane { stored, lane, .. } = *of;
    let columns = [stored.columns[0][lane], stored.columns[1][lane]];
    let between = columns.map(|column| column as f32 - 0.5);
    let number = u32x16::from_slice(simd, &COUNT).bitcast::<i32x16<S>>() + row;
    let inside = number.simd_ge(stored.rows[0][lane]) & number.simd_lt(stored.rows[1][lane]);
    let mut ends = apart!(simd, ends(simd, &stored.edges, lane, row, between));
    if !are_sure(&ends, inside) {
        ends = FineEdges::of(of).ends(simd, row, between.map(f64::from));
        if !are_sure(&ends, inside) {
            return None;
        }
    }
    let none = i32x16::splat(simd, 0);
    Some([
        inside.select(ends[0][0].to_int(), none),
        inside.select(ends[1][0].to_int(), none),
    ])
}

/// Returns `true` if the lower and upper bounds of both ends agree in the rows `inside`.
#[inline(always)]
fn are_sure<S: Simd>([start, stop]: &[[f32x16<S>; 2]; 2], inside: mask32x16<S>) -> bool {
    let sure = start[0].simd_eq(start[1]) & stop[0].simd_eq(stop[1]);
    (sure | !inside).all_true()
}

/// Returns the first column and the end column (exclusive) of each of sixteen rows from `row` on, clamped to `between`;
/// each as a lower and an upper bound.
#[inline(always)]
fn ends<S: Simd>(
    simd: S,
    edges: &[[[f32; LANES]; 3]; 4],
    lane: usize,
    row: i32,
    between: [f32; 2],
) -> [[f32x16<S>; 2]; 2] {
    let y = f32x16::from_slice(simd, &CENTRES) + row as f32;
    let [first, end] = [f32x16::splat(simd, between[0]), f32x16::splat(simd, between[1])];
    let left = crossing(simd, &edges[0], lane, y);
    let right = crossing(simd, &edges[1], lane, y);
    let third_left = crossing(simd, &edges[2], lane, y);
    let third_right = crossing(simd, &edges[3], lane, y);
    [
        [
            left[0].max(third_left[0]).max(first).min(end).ceil(),
            left[1].max(third_left[1]).max(first).min(end).ceil(),
        ],
        [
            right[0].min(third_right[0]).min(end).max(first).ceil(),
            right[1].min(third_right[1]).min(end).max(first).ceil(),
        ],
    ]
}

/// Returns lower and upper bounds of the crossing with rows.
#[inline(always)]
fn crossing<S: Simd>(simd: S, edge: &[[f32; LANES]; 3], lane: usize, y: f32x16<S>) -> [f32x16<S>; 2] {
    let way = y * edge[0][lane];
    [
        f32x16::splat(simd, edge[1][lane]) + way,
        f32x16::splat(simd, edge[2][lane]) + way,
    ]
}

/// Edges of a triangle in f64: at most two bound its rows on each side.
struct FineEdges {
    left: [FineEdge; 2],
    right: [FineEdge; 2],
}

/// One edge, like a lane of [`Edge`].
#[derive(Clone, Copy)]
struct FineEdge {
    slope: f64,
    least: f64,
    greatest: f64,
}

impl FineEdges {
    /// Returns the edges of a triangle, relative to its origin. Not inlined: it is rarely needed.
    #[inline(never)]
    fn of(&Lane { frame, stored, lane }: &Lane) -> FineEdges {
        let corners = stored.corners.map(|[x, y]| [x[lane], y[lane]]);
        let origin = [0, 1].map(|axis| stored.origin[axis][lane] - frame.middle_sample[axis]);
        let at = |[x, y]: [i32; 2]| {
            let pixels = |place: i32, from: i32| f64::from(place) / f64::from(ONE) - f64::from(from);
            [pixels(x, origin[0]), pixels(y, origin[1])]
        };
        let [a, b, c] = corners.map(at);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let [b, c] = if area < 0.0 { [c, b] } else { [b, c] };
        let bounds_nothing = |column: f64| FineEdge {
            slope: 0.0,
            least: column,
            greatest: column,
        };
        let mut sides = FineEdges {
            left: [bounds_nothing(-FAR); 2],
            right: [bounds_nothing(FAR); 2],
        };
        let [mut lefts, mut rights] = [0, 0];
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            let slope = dx / dy;
            let at = from[0] - 0.5 - from[1] * slope;
            let error = (1.0 + slope.abs()) * UNITS;
            let side = FineEdge {
                slope,
                least: at - error,
                greatest: at + error,
            };
            // As in `setup`: y points down.
            if dy < 0.0 {
                sides.left[lefts % 2] = side;
                lefts += 1;
            } else if dy > 0.0 {
                sides.right[rights % 2] = side;
                rights += 1;
            }
        }
        sides
    }

    /// Returns the first column and the end column (exclusive) of each of sixteen rows from `row` on, clamped to
    /// `between`; each as a lower and an upper bound.
    #[inline(always)]
    fn ends<S: Simd>(&self, simd: S, row: i32, between: [f64; 2]) -> [[f32x16<S>; 2]; 2] {
        let below = self.eight(simd, row, between);
        let above = self.eight(simd, row + LANES as i32 / 2, between);
        [
            [below[0].narrow(above[0]), below[1].narrow(above[1])],
            [below[2].narrow(above[2]), below[3].narrow(above[3])],
        ]
    }

    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, row: i32, [first, end]: [f64; 2]) -> [f64x8<S>; 4] {
        let y = f64x8::from_slice(simd, &CENTRES_IN_F64) + f64::from(row);
        let [first, end] = [f64x8::splat(simd, first), f64x8::splat(simd, end)];
        let [mut start, mut start_at_most] = [first, first];
        let [mut stop, mut stop_at_most] = [end, end];
        for side in &self.left {
            let way = y * side.slope;
            start = start.max(way + side.least);
            start_at_most = start_at_most.max(way + side.greatest);
        }
        for side in &self.right {
            let way = y * side.slope;
            stop = stop.min(way + side.least);
            stop_at_most = stop_at_most.min(way + side.greatest);
        }
        [
            start.min(end).ceil(),
            start_at_most.min(end).ceil(),
            stop.max(first).ceil(),
            stop_at_most.max(first).ceil(),
        ]
    }
}

/// Outside all columns.
const FAR: f64 = 1e9;

/// Bound on the error of a coordinate, in pixels: rounding accounts for half a unit, and edges that are certain are a
/// few units high, so that they hardly turn.
const UNITS: f64 = 1.0 / ONE as f64;
