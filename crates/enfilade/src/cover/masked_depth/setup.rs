//! Triangle and quad setup for sixteen faces: edges for scanline crossings, and the depth plane.
//!
//! One edge bounds the rows on the left, one on the right, and each other edge on either side. Crossings of scanlines
//! are computed in f32 relative to an origin near the face, with bounds on their error. If a sample is within the
//! error, the face is uncertain and left to f64. The depth of a quad is that of the plane through three of its
//! vertices, moved back by the distance of the fourth.
//! Source: filtered predicates as in Shewchuk, Adaptive Precision Floating-Point Arithmetic, 1997; depth plane as in
//!     Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, section 3.3.
//! Cost: O(1) for sixteen faces.
//! Conservative: reversed depth is lowered by its rounding error.

use super::project::{Frame, ONE, ONE_SHIFT};
use super::sort::{EXACTNESS, FaceLanes, Samples};
use crate::simd::apart;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16};

/// Setup of sixteen faces, in pixels from an origin per face.
pub(super) struct FaceSetup<S: Simd, const OTHERS: usize> {
    /// Origin of each face, in samples from the frame's origin.
    pub(super) origin: [i32x16<S>; 2],
    /// First and end columns and rows of the samples that the face may cover, from its origin.
    pub(super) columns: [i32x16<S>; 2],
    pub(super) rows: [i32x16<S>; 2],
    pub(super) edges: Edges<S, OTHERS>,
    pub(super) plane: Plane<S>,
    /// Faces whose rows are uncertain in f32.
    pub(super) unsure: mask32x16<S>,
}

/// Edges of sixteen faces. `OTHERS`, the number of edges after the first two, is 1 for triangles and 2 for quads.
pub(super) struct Edges<S: Simd, const OTHERS: usize> {
    /// An edge that bounds rows on the left, and one that bounds them on the right.
    pub(super) left: Edge<S>,
    pub(super) right: Edge<S>,
    /// Each other edge, as a left and as a right bound; one of the two bounds nothing.
    pub(super) others: [[Edge<S>; 2]; OTHERS],
}

/// Crossing of an edge with the row whose centre is at y: `at + slope · y`, minus half a pixel, with `at` between two
/// bounds.
#[derive(Clone, Copy)]
pub(super) struct Edge<S: Simd> {
    pub(super) slope: f32x16<S>,
    /// Lower and upper bound of `at`.
    pub(super) least: f32x16<S>,
    pub(super) greatest: f32x16<S>,
}

/// Depth planes of sixteen faces.
pub(super) struct Plane<S: Simd> {
    /// Reversed depth at the origin, lowered by the rounding error anywhere in the face.
    pub(super) at: f32x16<S>,
    /// Change per column and per row.
    pub(super) slope: [f32x16<S>; 2],
    pub(super) least: f32x16<S>,
    pub(super) greatest: f32x16<S>,
}

/// Outside all columns.
const FAR: f32 = 1e9;

const PER_UNIT: f32 = 1.0 / ONE as f32;

impl<S: Simd, const OTHERS: usize> FaceSetup<S, OTHERS> {
    /// Computes the setup. The origin is at multiples of `align` columns and rows.
    #[inline(always)]
    pub(super) fn new<const SIDES: usize>(
        simd: S,
        frame: &Frame,
        faces: &FaceLanes<S, SIDES>,
        align: [i32; 2],
    ) -> FaceSetup<S, OTHERS> {
        const { assert!(SIDES == OTHERS + 2) };
        let columns = Samples::between(simd, &faces.x, frame.columns);
        let rows = Samples::between(simd, &faces.y, frame.rows);
        let origin = [columns.first & -align[0], rows.first & -align[1]];

        let FaceLanes {
            mut x,
            mut y,
            mut rev_depth,
            ..
        } = *faces;
        let last = SIDES - 1;
        let area = in_pixels(x[1] - x[0]) * in_pixels(y[last] - y[0])
            - in_pixels(x[last] - x[0]) * in_pixels(y[1] - y[0]);
        // Give all faces the same winding.
        let turned = area.simd_lt(f32x16::splat(simd, 0.0));
        (x[1], x[last]) = (turned.select(x[last], x[1]), turned.select(x[1], x[last]));
        (y[1], y[last]) = (turned.select(y[last], y[1]), turned.select(y[1], y[last]));
        let ends = (rev_depth[1], rev_depth[last]);
        rev_depth[1] = turned.select(ends.1, ends.0);
        rev_depth[last] = turned.select(ends.0, ends.1);

        let [left_of, above] = [origin[0] << ONE_SHIFT, origin[1] << ONE_SHIFT];
        let zero = f32x16::splat(simd, 0.0);
        let [mut px, mut py, mut dx, mut dy] = [[zero; SIDES]; 4];
        let [mut width, mut height] = [zero; 2];
        for corner in 0..SIDES {
            let next = (corner + 1) % SIDES;
            px[corner] = in_pixels(x[corner] - left_of);
            py[corner] = in_pixels(y[corner] - above);
            dx[corner] = in_pixels(x[next] - x[corner]);
            dy[corner] = in_pixels(y[next] - y[corner]);
            width = width.max(px[corner].abs());
            height = height.max(py[corner].abs());
        }
        let size = width + height;
        let unit = size * EXACTNESS + PER_UNIT * 2.0;
        let first = apart!(simd, Edge::new(simd, [px[0], py[0]], [dx[0], dy[0]], unit));
        let mut edges = [first; SIDES];
        for corner in 1..SIDES {
            let at = [px[corner], py[corner]];
            edges[corner] = apart!(simd, Edge::new(simd, at, [dx[corner], dy[corner]], unit));
        }
        FaceSetup {
            columns: [columns.first - origin[0], columns.end - origin[0]],
            rows: [rows.first - origin[1], rows.end - origin[1]],
            origin,
            edges: apart!(simd, Edges::sorted(simd, &edges, &dy)),
            plane: apart!(
                simd,
                Plane::new(simd, [px[0], py[0]], [&dx, &dy], &rev_depth, area.abs(), size)
            ),
            unsure: !rows.sure,
        }
    }
}

#[inline(always)]
fn in_pixels<S: Simd>(place: i32x16<S>) -> f32x16<S> {
    place.to_float::<f32x16<S>>() * PER_UNIT
}

impl<S: Simd> Edge<S> {
    /// Creates an edge through a vertex in a direction. `unit` bounds the error of coordinates and of everything
    /// computed from them.
    #[inline(always)]
    fn new(simd: S, [x, y]: [f32x16<S>; 2], [dx, dy]: [f32x16<S>; 2], unit: f32x16<S>) -> Edge<S> {
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

    /// Returns the edge in the lanes `which`, and in the others a vertical edge at `column`.
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

impl<S: Simd, const OTHERS: usize> Edges<S, OTHERS> {
    /// Sorts edges by the side that they bound. With y pointing down, an edge that goes up has the inside on its right.
    /// A horizontal edge bounds nothing.
    #[inline(always)]
    fn sorted<const SIDES: usize>(
        simd: S,
        edges: &[Edge<S>; SIDES],
        dy: &[f32x16<S>; SIDES],
    ) -> Edges<S, OTHERS> {
        let zero = f32x16::splat(simd, 0.0);
        let none = mask32x16::splat(simd, false);
        let [mut left, mut right] = [edges[SIDES - 1]; 2];
        let [mut has_left, mut has_right] = [none; 2];
        let mut others = [edges[SIDES - 1]; OTHERS];
        let [mut is_taken, mut is_left, mut is_right] = [[none; OTHERS]; 3];
        for (edge, &dy) in edges.iter().zip(dy) {
            let [up, down] = [dy.simd_lt(zero), dy.simd_gt(zero)];
            let [first_up, first_down] = [up & !has_left, down & !has_right];
            left = Edge::select(first_up, edge, &left);
            right = Edge::select(first_down, edge, &right);
            has_left |= up;
            has_right |= down;
            let mut waits = !(first_up | first_down);
            for other in 0..OTHERS {
                let here = waits & !is_taken[other];
                others[other] = Edge::select(here, edge, &others[other]);
                is_left[other] |= here & up;
                is_right[other] |= here & down;
                is_taken[other] |= here;
                waits &= !here;
            }
        }
        let mut both = [[left; 2]; OTHERS];
        for other in 0..OTHERS {
            both[other] = [
                others[other].or_at(simd, is_left[other], -FAR),
                others[other].or_at(simd, is_right[other], FAR),
            ];
        }
        Edges {
            left,
            right,
            others: both,
        }
    }
}

impl<S: Simd> Plane<S> {
    /// Computes the plane through the first, the second and the last vertex, from the differences of successive
    /// vertices. `area` is twice the area of their triangle.
    #[inline(always)]
    fn new<const SIDES: usize>(
        simd: S,
        [x, y]: [f32x16<S>; 2],
        [dx, dy]: [&[f32x16<S>; SIDES]; 2],
        rev_depth: &[f32x16<S>; SIDES],
        area: f32x16<S>,
        size: f32x16<S>,
    ) -> Plane<S> {
        let last = SIDES - 1;
        let [dx1, dy1, dx2, dy2] = [dx[0], dy[0], -dx[last], -dy[last]];
        let dn1 = rev_depth[1] - rev_depth[0];
        let dn2 = rev_depth[last] - rev_depth[0];
        let per_area = f32x16::splat(simd, 1.0) / area;
        let [a, b, c, d] = [dn1 * dy2, dn2 * dy1, dn2 * dx1, dn1 * dx2];
        let slope = [(a - b) * per_area, (c - d) * per_area];
        let [mut least, mut greatest] = [rev_depth[0]; 2];
        for &rev_depth in &rev_depth[1..] {
            least = least.min(rev_depth);
            greatest = greatest.max(rev_depth);
        }
        // Bounds the error of the slopes over the distance from a vertex to the samples, and the effect of rounded
        // vertices.
        let spread = (size + 32.0) * 2.0;
        let area_off = ((dx1 * dy2).abs() + (dx2 * dy1).abs()) * per_area * (2.0 * EXACTNESS) + EXACTNESS;
        let sum = slope[0].abs() + slope[1].abs();
        let error = (a.abs() + b.abs() + c.abs() + d.abs()) * per_area * spread * (2.0 * EXACTNESS)
            + sum * (spread * area_off + PER_UNIT)
            + greatest * (2.0 * EXACTNESS);
        let mut at = rev_depth[0] - slope[0] * x - slope[1] * y - error;
        // The halves of a quad are between this plane and a parallel one through the third vertex, if that is behind.
        for corner in 2..last {
            let plane = rev_depth[0] + slope[0] * (dx[0] + dx[1]) + slope[1] * (dy[0] + dy[1]);
            let beyond = (rev_depth[corner] - plane).min(f32x16::splat(simd, 0.0));
            // The error of the plane counts twice more: at that vertex, and in its distance from the plane.
            at += beyond - error * 2.0;
        }
        Plane {
            at,
            slope,
            least: least * (1.0 - EXACTNESS),
            greatest: greatest * (1.0 + EXACTNESS),
        }
    }
}
