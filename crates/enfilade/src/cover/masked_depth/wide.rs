//! Rasterizes wide triangles one after the other, sixteen rows at a time.
//!
//! Rows are in the lanes, later the sub-tiles of a tile. Tiles nearer than the whole triangle are skipped before
//! anything is computed for them. Scanline crossings of a triangle that is too large for f32 are computed in f64.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, sections 3.1 to 3.3.
//! Cost: a triangle O(rows / 16) + O(tiles it overlaps).
//! Exact: a triangle with an uncertain end of a row goes to f64.

use super::project::{Frame, ONE};
use super::runs::{RunQueue, Slopes};
use super::setup::{Edge, FaceSetup};
use super::sort::FaceLanes;
use super::tiles::{COLUMNS, ROWS, Tiles};
use super::{COUNT, LANES};
use crate::simd::apart;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, i32x16, u32x16};

/// Setup of sixteen triangles as arrays, indexed by lane.
struct SetupArrays {
    origin: [[i32; LANES]; 2],
    columns: [[i32; LANES]; 2],
    rows: [[i32; LANES]; 2],
    edges: [[[f32; LANES]; 3]; 4],
    plane: [[f32; LANES]; 5],
    /// Columns and rows of the corners, in units.
    corners: [[[i32; LANES]; 2]; 3],
    number: [u32; LANES],
}

/// Queues the runs of up to sixteen wide triangles; appends the numbers of uncertain ones to `uncertain`.
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
    let lanes = apart!(FaceSetup::<S, 1>::new(simd, frame, triangles, align));
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
        plane: [
            lanes.plane.at.to_array(),
            lanes.plane.slope[0].to_array(),
            lanes.plane.slope[1].to_array(),
            lanes.plane.least.to_array(),
            lanes.plane.greatest.to_array(),
        ],
        corners: [0, 1, 2].map(|corner| [triangles.x[corner].to_array(), triangles.y[corner].to_array()]),
        number: triangles.number.to_array(),
    };
    for lane in 0..triangles.lanes.min(LANES) {
        if unsure >> lane & 1 != 0 {
            uncertain.push(stored.number[lane]);
        } else {
            apart!(draw_one(simd, frame, &stored, lane, tiles, run_queue, uncertain));
        }
    }
}

/// Width or height, in units, from which on scanline crossings are computed in f64.
const HUGE: i32 = 512 * ONE;

impl SetupArrays {
    /// Returns the edges of a triangle that is too large for f32; `None` if it is not.
    fn huge_edges(&self, lane: usize, frame: &Frame) -> Option<HugeEdges> {
        let corners = self.corners.map(|[x, y]| [x[lane], y[lane]]);
        let is_huge = [0, 1].into_iter().any(|axis| {
            let [a, b, c] = corners.map(|corner| corner[axis]);
            a.max(b).max(c) - a.min(b).min(c) >= HUGE
        });
        let origin = [0, 1].map(|axis| self.origin[axis][lane] - frame.middle_sample[axis]);
        is_huge.then(|| HugeEdges::new(corners, origin))
    }
}

const CENTRES_IN_F64: [f64; LANES / 2] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
const CENTRES: [f32; LANES] = [
    0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5, 8.5, 9.5, 10.5, 11.5, 12.5, 13.5, 14.5, 15.5,
];

#[inline(always)]
fn draw_one<S: Simd>(
    simd: S,
    frame: &Frame,
    stored: &SetupArrays,
    lane: usize,
    tiles: &mut Tiles,
    run_queue: &mut RunQueue,
    uncertain: &mut Vec<u32>,
) {
    let [at, by_column, by_row, least, greatest] = [
        stored.plane[0][lane],
        stored.plane[1][lane],
        stored.plane[2][lane],
        stored.plane[3][lane],
        stored.plane[4][lane],
    ];
    let [first, end] = [stored.columns[0][lane], stored.columns[1][lane]];
    let [first_row, end_row] = [stored.rows[0][lane], stored.rows[1][lane]];
    let between = [f64::from(first) - 0.5, f64::from(end) - 0.5];
    let huge = stored.huge_edges(lane, frame);
    // From the top left corner of the screen, as all runs are.
    let [left_of, above] = [stored.origin[0][lane], stored.origin[1][lane]];
    let [by_column, by_row] = [f64::from(by_column), f64::from(by_row)];
    let at = f64::from(at) - by_column * f64::from(left_of) - by_row * f64::from(above);
    let slopes = Slopes::new(at, [by_column, by_row], [least, greatest]);
    if run_queue.are_many() {
        run_queue.cover(simd, tiles);
    }
    run_queue.begin(&slopes);
    let mut row = 0;
    while row < end_row {
        let [start, stop] = match &huge {
            Some(sides) => sides.ends(simd, row, between),
            None => apart!(ends(simd, &stored.edges, lane, row, between)),
        };
        let number = u32x16::from_slice(simd, &COUNT).bitcast::<i32x16<S>>() + row;
        let inside = number.simd_ge(first_row) & number.simd_lt(end_row);
        let sure = start[0].simd_eq(start[1]) & stop[0].simd_eq(stop[1]);
        if (inside & !sure).any_true() {
            // The whole triangle goes to f64, not only its remaining rows: the rows queued so far would be separated
            // from them.
            uncertain.push(stored.number[lane]);
            return;
        }
        let [start, stop] = [start[0].to_int::<i32x16<S>>(), stop[0].to_int::<i32x16<S>>()];
        let there = inside & start.simd_lt(stop);
        let none = i32x16::splat(simd, 0);
        let starts = there.select(start + left_of, none);
        let stops = there.select(stop + left_of, none);
        let (starts, stops) = (starts.to_array(), stops.to_array());
        // Edges of a convex face are straight or bend outwards, so the innermost ends are in the first or the last row.
        let whole = if there.all_true() {
            [starts[0].max(starts[LANES - 1]), stops[0].min(stops[LANES - 1])]
        } else {
            [0; 2]
        };
        run_queue.push(((above + row) / ROWS as i32) as usize, [starts, stops], whole);
        row += LANES as i32;
    }
}

/// Returns the first column and the end column (exclusive) of each of sixteen rows from `row` on, clamped to `between`;
/// each as a lower and an upper bound.
#[inline(always)]
fn ends<S: Simd>(
    simd: S,
    edges: &[[[f32; LANES]; 3]; 4],
    lane: usize,
    row: i32,
    between: [f64; 2],
) -> [[f32x16<S>; 2]; 2] {
    let y = f32x16::from_slice(simd, &CENTRES) + row as f32;
    let [first, end] = [
        f32x16::splat(simd, between[0] as f32),
        f32x16::splat(simd, between[1] as f32),
    ];
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

/// Edges of a triangle: at most two bound its rows on each side.
struct HugeEdges {
    left: [HugeEdge; 2],
    right: [HugeEdge; 2],
}

/// One edge, like a lane of [`Edge`].
#[derive(Clone, Copy)]
struct HugeEdge {
    slope: f64,
    least: f64,
    greatest: f64,
}

impl HugeEdges {
    /// Creates the edges from vertices in units; crossings are relative to `origin`, in samples.
    fn new(corners: [[i32; 2]; 3], origin: [i32; 2]) -> HugeEdges {
        let at = |[x, y]: [i32; 2]| {
            let pixels = |place: i32, from: i32| f64::from(place) / f64::from(ONE) - f64::from(from);
            [pixels(x, origin[0]), pixels(y, origin[1])]
        };
        let [a, b, c] = corners.map(at);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let [b, c] = if area < 0.0 { [c, b] } else { [b, c] };
        let bounds_nothing = |column: f64| HugeEdge {
            slope: 0.0,
            least: column,
            greatest: column,
        };
        let mut sides = HugeEdges {
            left: [bounds_nothing(-FAR); 2],
            right: [bounds_nothing(FAR); 2],
        };
        let [mut lefts, mut rights] = [0, 0];
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
            let slope = dx / dy;
            let at = from[0] - 0.5 - from[1] * slope;
            let error = (1.0 + slope.abs()) * UNITS;
            let side = HugeEdge {
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

/// Generous bound on the error of a coordinate, in pixels; rounding to units accounts for half a unit.
const UNITS: f64 = 2.0 / ONE as f64;
