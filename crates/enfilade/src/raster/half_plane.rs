//! Half-planes on the screen: edge functions with a fill rule.

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;

/// A half-plane in screen space: the points at which the edge function a·x + b·y + c is positive, or zero if `owns` is
/// `true`.
#[derive(Clone, Copy)]
pub(crate) struct HalfPlane {
    a: f64,
    b: f64,
    c: f64,
    /// −1 / a, to compute where the line crosses a scanline.
    root: f64,
    owns: bool,
}

impl HalfPlane {
    pub(crate) const NONE: HalfPlane = HalfPlane {
        a: 0.0,
        b: 0.0,
        c: 0.0,
        root: 0.0,
        owns: false,
    };

    /// Returns the half-plane in which `normal · (x, y, 1)` is positive.
    ///
    /// Implements the top-left fill rule: left and top edges own the samples on their line, so exactly one of the two
    /// half-planes of a line owns it.
    #[inline(always)]
    pub(crate) fn new(normal: DVec3) -> HalfPlane {
        let DVec3 { x: a, y: b, z: c } = normal;
        HalfPlane {
            a,
            b,
            c,
            root: -1.0 / a,
            owns: a > 0.0 || (a == 0.0 && b > 0.0),
        }
    }

    /// Returns the half-plane of a triangle's edge that contains the third corner; `side` is the sign of the triangle's
    /// determinant.
    ///
    /// The edge is computed from its lexicographically smaller end, so that both faces that share the edge get the same
    /// bits.
    #[inline(always)]
    pub(crate) fn edge(from: DVec3, to: DVec3, side: f64) -> HalfPlane {
        let first = from.x < to.x || (from.x == to.x && (from.y < to.y || (from.y == to.y && from.z < to.z)));
        let normal = if first {
            from.cross(to - from)
        } else {
            -to.cross(from - to)
        };
        HalfPlane::new(normal * side)
    }

    /// Returns `true` if the point is inside.
    #[inline(always)]
    pub(crate) fn holds(&self, x: f64, y: f64) -> bool {
        let value = x * self.a + (y * self.b + self.c);
        if self.owns { value >= 0.0 } else { value > 0.0 }
    }

    /// Returns `true` if all coefficients are finite, that is, if computing them did not overflow.
    #[inline(always)]
    pub(crate) fn is_finite(&self) -> bool {
        self.a.is_finite() && self.b.is_finite() && self.c.is_finite()
    }

    /// Returns `true` if the samples inside are always the first or the last ones of a scanline, regardless of
    /// rounding. That holds wherever the crossing with a scanline can be computed.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        self.a == 0.0 || (self.root.is_finite() && self.root != 0.0)
    }

    /// Returns the part of the edge function that depends on the columns, for reuse across several rows.
    #[inline(always)]
    pub(crate) fn across<S: Simd>(&self, columns: f64x8<S>) -> f64x8<S> {
        columns * self.a
    }

    /// Tests samples in the row whose centre is at `y`, given the result of [`HalfPlane::across`]. Gives the same bits
    /// as [`HalfPlane::holds`].
    #[inline(always)]
    pub(super) fn holds_across<S: Simd>(&self, simd: S, across: f64x8<S>, y: f64) -> mask64x8<S> {
        let value = across + (y * self.b + self.c);
        value.simd_ge(f64x8::splat(simd, self.least()))
    }

    /// Returns the smallest value of the edge function that counts as inside: the smallest positive f64, or zero if the
    /// line is owned.
    #[inline(always)]
    fn least(&self) -> f64 {
        if self.owns { 0.0 } else { f64::from_bits(1) }
    }

    /// Narrows the runs `x0..x1` of eight rows to the columns inside this half-plane.
    ///
    /// `rows` are the y coordinates of the row centres. `limits` are the first and the end column of all runs: the
    /// crossings are clamped to these rather than to the runs that other half-planes left, so that several half-planes
    /// are evaluated in parallel.
    #[inline(always)]
    pub(crate) fn narrow<S: Simd>(
        &self,
        simd: S,
        rows: f64x8<S>,
        limits: [f64x8<S>; 2],
        x0: &mut f64x8<S>,
        x1: &mut f64x8<S>,
    ) {
        let at_row = rows * self.b + self.c;
        let [first, end] = limits;
        let [zero, one] = [f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0)];
        let least = self.least();
        if self.a == 0.0 || self.a.is_nan() {
            *x1 = at_row.simd_ge(f64x8::splat(simd, least)).select(*x1, first);
            return;
        }
        // Rounding may put the crossing on the wrong side of a sample's centre. So the edge function is evaluated at
        // the column at or before it and at the next one; the opposite half-plane evaluates the same two, so no sample
        // is lost or drawn twice.
        let crossing = at_row * self.root - 0.5;
        let crossing = crossing.simd_gt(first).select(crossing, first);
        let column = crossing.simd_lt(end).select(crossing, end).floor();
        let least = f64x8::splat(simd, least);
        // No closure: its code is not compiled for the SIMD level.
        let [here, next] = [
            (column + 0.5) * self.a + at_row,
            ((column + one) + 0.5) * self.a + at_row,
        ];
        let count = here.simd_ge(least).select(one, zero) + next.simd_ge(least).select(one, zero);
        let column = column + if self.a > 0.0 { one + one - count } else { count };
        if self.a > 0.0 {
            *x0 = column.simd_gt(*x0).select(column, *x0);
        } else {
            *x1 = column.simd_lt(*x1).select(column, *x1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::dispatch;
    use fearless_simd::Level;

    /// Draws which of the columns 0..8 of row 0 are inside.
    fn held(normal: [f64; 3]) -> String {
        let plane = HalfPlane::new(DVec3::from(normal));
        dispatch!(Level::new(), simd => {
            let [mut x0, mut x1] = [0.0, 8.0].map(|column| f64x8::splat(simd, column));
            plane.narrow(simd, f64x8::splat(simd, 0.5), [x0, x1], &mut x0, &mut x1);
            let [x0, x1]: [[f64; 8]; 2] = [x0.into(), x1.into()];
            (0..8).map(|x| if (x0[0]..x1[0]).contains(&f64::from(x)) { '#' } else { '.' }).collect()
        })
    }

    #[test]
    fn a_row_is_cut_where_the_line_crosses_it() {
        let cases = [
            ([1.0, 0.0, -3.0], "...#####"),
            ([-1.0, 0.0, 3.0], "###....."),
            ([1.0, 0.0, -3.5], "...#####"),
            ([-1.0, 0.0, 3.5], "###....."),
            ([1.0, 0.0, 9.0], "########"),
            ([1.0, 0.0, -9.0], "........"),
            ([-1.0, 0.0, -9.0], "........"),
            ([0.0, 1.0, 0.0], "########"),
            ([0.0, 1.0, -0.5], "########"),
            ([0.0, -1.0, 0.5], "........"),
            ([1e-300, 0.0, -1e300], "........"),
            ([-1e-300, 0.0, 1e300], "########"),
            ([f64::NAN, 0.0, 0.0], "........"),
        ];
        for (normal, expected) in cases {
            assert_eq!(held(normal), expected, "{normal:?}");
        }
    }

    #[test]
    fn the_two_sides_of_a_line_share_no_sample_and_leave_none() {
        for i in 0..1000 {
            let angle = f64::from(i) * 0.37;
            let normal = [angle.cos(), angle.sin(), -4.0 * angle.cos() - 0.5 * angle.sin()];
            let both: Vec<String> = vec![held(normal), held(normal.map(|v| -v))];
            let held_once =
                (0..8).all(|x| (both[0].as_bytes()[x] == b'#') != (both[1].as_bytes()[x] == b'#'));
            assert!(held_once, "{both:?} at {normal:?}");
        }
    }
}
