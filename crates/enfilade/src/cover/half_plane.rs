//! One side of a line on the screen.

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, mask64x8};
use glam::DVec3;

/// A side of a line on the screen: a·x + b·y + c above zero, or zero where `owns`.
#[derive(Clone, Copy)]
pub(super) struct HalfPlane {
    a: f64,
    b: f64,
    c: f64,
    /// −1 / a.
    root: f64,
    owns: bool,
}

impl HalfPlane {
    pub(super) const NONE: HalfPlane = HalfPlane {
        a: 0.0,
        b: 0.0,
        c: 0.0,
        root: 0.0,
        owns: false,
    };

    /// The side where `normal · (x, y, 1)` is positive. Left and top edges own: of two sides of one line, exactly
    /// one owns the line.
    #[inline(always)]
    pub(super) fn new(normal: DVec3) -> HalfPlane {
        let DVec3 { x: a, y: b, z: c } = normal;
        HalfPlane {
            a,
            b,
            c,
            root: -1.0 / a,
            owns: a > 0.0 || (a == 0.0 && b > 0.0),
        }
    }

    /// The side of an edge on which the third corner of a triangle lies, whose determinant has the sign `side`.
    ///
    /// The edge is computed from its lesser end, so that both faces that share it get the same bits.
    #[inline(always)]
    pub(super) fn edge(from: DVec3, to: DVec3, side: f64) -> HalfPlane {
        let first = from.x < to.x || (from.x == to.x && (from.y < to.y || (from.y == to.y && from.z < to.z)));
        let normal = if first {
            from.cross(to - from)
        } else {
            -to.cross(from - to)
        };
        HalfPlane::new(normal * side)
    }

    /// Does it hold a point?
    #[inline(always)]
    pub(super) fn holds(&self, x: f64, y: f64) -> bool {
        let value = x * self.a + (y * self.b + self.c);
        if self.owns { value >= 0.0 } else { value > 0.0 }
    }

    /// Is it the side of a line, or of none? Not so where its making overflowed.
    #[inline(always)]
    pub(super) fn is_finite(&self) -> bool {
        self.a.is_finite() && self.b.is_finite() && self.c.is_finite()
    }

    /// Are the samples of a row that it holds the first or the last of them, whatever the rounding? So where the
    /// crossing of a row can be computed.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        self.a == 0.0 || (self.root.is_finite() && self.root != 0.0)
    }

    /// What the columns of some samples add to its value, to be used for several rows.
    #[inline(always)]
    pub(super) fn across<S: Simd>(&self, columns: f64x8<S>) -> f64x8<S> {
        columns * self.a
    }

    /// Of samples whose columns add `across`, in the row whose centre is at `y`: those that it holds, by the same bits as
    /// [`HalfPlane::holds`].
    #[inline(always)]
    pub(super) fn holds_across<S: Simd>(&self, simd: S, across: f64x8<S>, y: f64) -> mask64x8<S> {
        let value = across + (y * self.b + self.c);
        value.simd_ge(f64x8::splat(simd, self.least()))
    }

    /// The least value that is held: above zero, or zero where the line is owned.
    #[inline(always)]
    fn least(&self) -> f64 {
        if self.owns { 0.0 } else { f64::from_bits(1) }
    }

    /// Narrows the columns `x0..x1` of eight rows to those held; `rows` are the y of their centres, and `limits` the
    /// first column of all and the one after the last: from these, not from what other planes leave, so that several are
    /// computed at once.
    #[inline(always)]
    pub(super) fn narrow<S: Simd>(
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
        let held = |column: f64x8<S>| {
            let value = (column + 0.5) * self.a + at_row;
            value.simd_ge(f64x8::splat(simd, least)).select(one, zero)
        };
        // Rounding may put the crossing on the wrong side of a sample's centre. So the column at or before it and
        // the next are asked, and the other side of the line asks them alike.
        let crossing = at_row * self.root - 0.5;
        let crossing = crossing.simd_gt(first).select(crossing, first);
        let column = crossing.simd_lt(end).select(crossing, end).floor();
        let count = held(column) + held(column + one);
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
    use fearless_simd::{Level, dispatch};

    /// The columns 0..8 of row 0 that are held, as a picture.
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
