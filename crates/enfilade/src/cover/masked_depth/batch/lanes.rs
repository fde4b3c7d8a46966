//! Sets sixteen triangles up at once: where each row of samples crosses their edges, and how near they are.
//!
//! Of the three edges one has the inside to its right, one to its left, and the third either way. Where a row crosses an
//! edge is computed in f32 from the triangle's own corner of the screen, and with it how far off that may be: what lies
//! within is not certain, and goes to f64.
//! Source: filtered predicates as in Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997; the plane of nearness as
//!     in Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.3.
//! Cost: O(1) for sixteen.
//! Conservative: nearness is lowered by what rounding may add to it.

use super::queue::{EXACTNESS, Samples, Sixteen};
use super::{Frame, HALF, ONE, ONE_SHIFT};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16};

/// Sixteen triangles, in pixels from a corner of their own.
pub(super) struct Lanes<S: Simd> {
    /// The corner, in samples from the middle.
    pub(super) origin: [i32x16<S>; 2],
    /// The samples that may be in them, from that corner.
    pub(super) columns: [i32x16<S>; 2],
    pub(super) rows: [i32x16<S>; 2],
    /// The edge that bounds a row on the left, and that on the right.
    pub(super) left: Edge<S>,
    pub(super) right: Edge<S>,
    /// The third edge, as one that bounds on the left, and on the right: one of them bounds nothing.
    pub(super) third: [Edge<S>; 2],
    pub(super) plane: Plane<S>,
    /// Cannot be told here.
    pub(super) unsure: mask32x16<S>,
}

/// Where a row whose centre is at y crosses an edge: at `at + slope · y`, less half a pixel, between two bounds.
#[derive(Clone, Copy)]
pub(super) struct Edge<S: Simd> {
    pub(super) slope: f32x16<S>,
    /// The least and the greatest that `at` may be.
    pub(super) least: f32x16<S>,
    pub(super) greatest: f32x16<S>,
}

/// How near triangles are.
pub(super) struct Plane<S: Simd> {
    /// At the corner, lowered by what rounding may add anywhere.
    pub(super) at: f32x16<S>,
    /// By column and by row.
    pub(super) slope: [f32x16<S>; 2],
    pub(super) least: f32x16<S>,
    pub(super) greatest: f32x16<S>,
}

/// Beyond every column.
const FAR: f32 = 1e9;

const PER_UNIT: f32 = 1.0 / ONE as f32;

impl<S: Simd> Lanes<S> {
    /// `align`: the corner is put at multiples of so many columns and rows.
    #[inline(always)]
    pub(super) fn new(simd: S, frame: &Frame, triangles: &Sixteen<S>, align: [i32; 2]) -> Lanes<S> {
        let columns = Samples::between(simd, &triangles.x, frame.columns);
        let rows = Samples::between(simd, &triangles.y, frame.rows);
        let origin = [columns.first & -align[0], rows.first & -align[1]];
        // Is the first or the last row less than a unit from a corner's?
        let [least, greatest] = [
            triangles.y[0].min(triangles.y[1]).min(triangles.y[2]),
            triangles.y[0].max(triangles.y[1]).max(triangles.y[2]),
        ];
        let unsure = (((least + (ONE - 1 - HALF - 1)) >> ONE_SHIFT)
            .simd_eq((least + (ONE - 1 - HALF + 1)) >> ONE_SHIFT)
            & ((greatest + (1 - HALF)) >> ONE_SHIFT).simd_eq((greatest + (-1 - HALF)) >> ONE_SHIFT))
            ^ mask32x16::splat(simd, true);

        let (x0, x1, x2) = (triangles.x[0], triangles.x[1], triangles.x[2]);
        let (y0, y1, y2) = (triangles.y[0], triangles.y[1], triangles.y[2]);
        let area = in_pixels(x1 - x0) * in_pixels(y2 - y0) - in_pixels(x2 - x0) * in_pixels(y1 - y0);
        // The same way round for all.
        let turned = area.simd_lt(f32x16::splat(simd, 0.0));
        let (x1, x2) = (turned.select(x2, x1), turned.select(x1, x2));
        let (y1, y2) = (turned.select(y2, y1), turned.select(y1, y2));
        let [n0, n1, n2] = triangles.nearness;
        let (n1, n2) = (turned.select(n2, n1), turned.select(n1, n2));

        let [left_of, above] = [origin[0] << ONE_SHIFT, origin[1] << ONE_SHIFT];
        let px = [
            in_pixels(x0 - left_of),
            in_pixels(x1 - left_of),
            in_pixels(x2 - left_of),
        ];
        let py = [
            in_pixels(y0 - above),
            in_pixels(y1 - above),
            in_pixels(y2 - above),
        ];
        let dx = [in_pixels(x1 - x0), in_pixels(x2 - x1), in_pixels(x0 - x2)];
        let dy = [in_pixels(y1 - y0), in_pixels(y2 - y1), in_pixels(y0 - y2)];
        let size =
            px[0].abs().max(px[1].abs()).max(px[2].abs()) + py[0].abs().max(py[1].abs()).max(py[2].abs());
        let unit = size * EXACTNESS + PER_UNIT * 2.0;
        let edges = [
            Edge::new(simd, px[0], py[0], dx[0], dy[0], unit),
            Edge::new(simd, px[1], py[1], dx[1], dy[1], unit),
            Edge::new(simd, px[2], py[2], dx[2], dy[2], unit),
        ];
        let (left, right, third) = sort(simd, &edges, &dy);
        Lanes {
            columns: [columns.first - origin[0], columns.end - origin[0]],
            rows: [rows.first - origin[1], rows.end - origin[1]],
            origin,
            left,
            right,
            third,
            plane: Plane::new(
                simd,
                [px[0], py[0]],
                [dx[0], dx[2], dy[0], dy[2]],
                [n0, n1, n2],
                area.abs(),
                size,
            ),
            unsure,
        }
    }
}

#[inline(always)]
fn in_pixels<S: Simd>(place: i32x16<S>) -> f32x16<S> {
    place.to_float::<f32x16<S>>() * PER_UNIT
}

impl<S: Simd> Edge<S> {
    /// Through a corner, in a direction. `unit`: what places may be off by, with all that is computed from them.
    #[inline(always)]
    fn new(simd: S, x: f32x16<S>, y: f32x16<S>, dx: f32x16<S>, dy: f32x16<S>, unit: f32x16<S>) -> Edge<S> {
        let flat = dy.simd_eq(f32x16::splat(simd, 0.0));
        let one = f32x16::splat(simd, 1.0);
        let slope = flat.select(f32x16::splat(simd, 0.0), dx / flat.select(one, dy));
        let at = (x - 0.5) - y * slope;
        let error = unit * (slope.abs() + 1.0);
        Edge {
            slope,
            least: at - error,
            greatest: at + error,
        }
    }

    #[inline(always)]
    fn select(which: mask32x16<S>, yes: &Edge<S>, no: &Edge<S>) -> Edge<S> {
        Edge {
            slope: which.select(yes.slope, no.slope),
            least: which.select(yes.least, no.least),
            greatest: which.select(yes.greatest, no.greatest),
        }
    }

    /// The same where `which`, else one that lies at a column, whatever the row.
    #[inline(always)]
    fn or_at(self, simd: S, which: mask32x16<S>, column: f32) -> Edge<S> {
        let column = f32x16::splat(simd, column);
        Edge {
            slope: which.select(self.slope, f32x16::splat(simd, 0.0)),
            least: which.select(self.least, column),
            greatest: which.select(self.greatest, column),
        }
    }
}

/// One edge that bounds rows on the left, one on the right, and the third as either. An edge that goes up has the inside
/// to its right, as rows are counted downwards.
#[inline(always)]
fn sort<S: Simd>(simd: S, edges: &[Edge<S>; 3], dy: &[f32x16<S>; 3]) -> (Edge<S>, Edge<S>, [Edge<S>; 2]) {
    let zero = f32x16::splat(simd, 0.0);
    let up = [dy[0].simd_lt(zero), dy[1].simd_lt(zero), dy[2].simd_lt(zero)];
    let down = [dy[0].simd_gt(zero), dy[1].simd_gt(zero), dy[2].simd_gt(zero)];
    let left = Edge::select(up[0], &edges[0], &Edge::select(up[1], &edges[1], &edges[2]));
    let right = Edge::select(down[0], &edges[0], &Edge::select(down[1], &edges[1], &edges[2]));
    // The first is one of these unless it is flat; then the second is, unless it goes the same way or is flat.
    let first = !(up[0] | down[0]);
    let second = !((up[0] & down[1]) | (down[0] & up[1]));
    let third = Edge::select(first, &edges[0], &Edge::select(second, &edges[1], &edges[2]));
    let third_up = (first & up[0]) | (!first & ((second & up[1]) | (!second & up[2])));
    let third_down = (first & down[0]) | (!first & ((second & down[1]) | (!second & down[2])));
    (
        left,
        right,
        [
            third.or_at(simd, third_up, -FAR),
            third.or_at(simd, third_down, FAR),
        ],
    )
}

impl<S: Simd> Plane<S> {
    /// Through three corners: the first, and the differences of the second and the third from it.
    #[inline(always)]
    fn new(
        simd: S,
        [x, y]: [f32x16<S>; 2],
        [dx1, back_dx2, dy1, back_dy2]: [f32x16<S>; 4],
        [n0, n1, n2]: [f32x16<S>; 3],
        area: f32x16<S>,
        size: f32x16<S>,
    ) -> Plane<S> {
        let (dx2, dy2) = (-back_dx2, -back_dy2);
        let [dn1, dn2] = [n1 - n0, n2 - n0];
        let per_area = f32x16::splat(simd, 1.0) / area;
        let [a, b, c, d] = [dn1 * dy2, dn2 * dy1, dn2 * dx1, dn1 * dx2];
        let slope = [(a - b) * per_area, (c - d) * per_area];
        let least = n0.min(n1).min(n2);
        let greatest = n0.max(n1).max(n2);
        // What the slopes may be off by, over the way from a corner to where they are used; and what moves with corners.
        let spread = (size + 32.0) * 2.0;
        let area_off = ((dx1 * dy2).abs() + (dx2 * dy1).abs()) * per_area * (2.0 * EXACTNESS) + EXACTNESS;
        let sum = slope[0].abs() + slope[1].abs();
        let error = (a.abs() + b.abs() + c.abs() + d.abs()) * per_area * spread * (2.0 * EXACTNESS)
            + sum * (spread * area_off + PER_UNIT)
            + greatest * (2.0 * EXACTNESS);
        Plane {
            at: n0 - slope[0] * x - slope[1] * y - error,
            slope,
            least: least * (1.0 - EXACTNESS),
            greatest: greatest * (1.0 + EXACTNESS),
        }
    }
}
