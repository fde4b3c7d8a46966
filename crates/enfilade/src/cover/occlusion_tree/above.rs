//! The ancestor lines that bound a leaf, and clipping of edges by them.
//!
//! Most edges of an occluder do not cross a leaf that only a part of it reaches, and then need no node there. All lines
//! are tested in groups of eight, since a piece has about twenty lines above it.
//! Source: original to this library; the kernels are specified by the functions in the tests, and give the same bits at
//!     every SIMD level.
//! Cost: O(lines / 8) for an edge.
//! A NaN bounds nothing: it leaves an edge unclipped.

use super::Edge;
use super::line::{Line, SLIT};
use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::DVec3;

/// Lines in groups of eight, stored as one coordinate of their normals after the other. The last group is padded with a
/// line that it already has.
#[derive(Clone, Debug, Default)]
pub(super) struct LinesAbove {
    eights: Vec<[[f64; 8]; 3]>,
    count: usize,
}

impl LinesAbove {
    pub(super) fn clear(&mut self) {
        self.eights.clear();
        self.count = 0;
    }

    pub(super) fn push(&mut self, line: Line) {
        let lane = self.count % 8;
        let normal = line.normal.to_array();
        match self.eights.last_mut() {
            Some(last) if lane > 0 => (0..3).for_each(|axis| last[axis][lane] = normal[axis]),
            _ => self.eights.push(normal.map(|coordinate| [coordinate; 8])),
        }
        self.count += 1;
    }

    /// Returns `true` if the line equals one of these, bit for bit.
    #[inline(always)]
    pub(super) fn contains<S: Simd>(&self, simd: S, line: &Line) -> bool {
        let normal = line.normal;
        for [x, y, z] in &self.eights {
            let same = f64x8::simd_from(simd, *x).simd_eq(f64x8::splat(simd, normal.x))
                & f64x8::simd_from(simd, *y).simd_eq(f64x8::splat(simd, normal.y))
                & f64x8::simd_from(simd, *z).simd_eq(f64x8::splat(simd, normal.z));
            if same.any_true() {
                return true;
            }
        }
        false
    }

    /// Returns `true` if a point has a height of at least `least` above all lines.
    #[inline(always)]
    pub(super) fn contain_point<S: Simd>(&self, simd: S, point: DVec3, least: f64) -> bool {
        for eight in &self.eights {
            let held = heights(simd, eight, point).simd_ge(f64x8::splat(simd, least));
            if !held.all_true() {
                return false;
            }
        }
        true
    }

    /// Returns `true` if every point of an edge is outside one of the lines, or within `SLIT` of it.
    #[inline(always)]
    pub(super) fn clip_away<S: Simd>(&self, simd: S, edge: &Edge) -> bool {
        let Edge { from, to, .. } = *edge;
        let zero = f64x8::splat(simd, 0.0);
        // The remaining interval of the edge, as parameters from 0 to 1; the part behind the eye is not visible.
        let [mut start, mut end] = [zero, f64x8::splat(simd, 1.0)];
        match [from.z > 0.0, to.z > 0.0] {
            [true, true] => {}
            [true, false] => end = f64x8::splat(simd, (from.z / (from.z - to.z)).min(1.0)),
            [false, true] => start = f64x8::splat(simd, (from.z / (from.z - to.z)).max(0.0)),
            [false, false] => return true,
        }
        for eight in &self.eights {
            let [a, b] = [
                heights(simd, eight, from) - SLIT * from.z,
                heights(simd, eight, to) - SLIT * to.z,
            ];
            let [a_inside, b_inside] = [a.simd_gt(zero), b.simd_gt(zero)];
            if !(a_inside | b_inside).all_true() {
                return true;
            }
            let crossing = a / (a - b);
            let sooner = !b_inside & crossing.simd_lt(end);
            let later = !a_inside & crossing.simd_gt(start);
            end = sooner.select(crossing, end);
            start = later.select(crossing, start);
        }
        let [starts, ends]: [[f64; 8]; 2] = [start.into(), end.into()];
        let [mut last, mut first] = [starts[0], ends[0]];
        for lane in 1..8 {
            last = if starts[lane] > last { starts[lane] } else { last };
            first = if ends[lane] < first { ends[lane] } else { first };
        }
        last >= first
    }
}

/// Returns the heights of a point above eight lines.
#[inline(always)]
fn heights<S: Simd>(simd: S, [x, y, z]: &[[f64; 8]; 3], point: DVec3) -> f64x8<S> {
    f64x8::simd_from(simd, *x) * point.x
        + f64x8::simd_from(simd, *y) * point.y
        + f64x8::simd_from(simd, *z) * point.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::occlusion_tree::tests::{levels, odd_numbers};
    use crate::simd::dispatch;

    /// Scalar specification of [`LinesAbove::clip_away`].
    fn clip_away_one_by_one(above: &[Line], edge: &Edge) -> bool {
        let mut left = [0.0, 1.0_f64];
        let mut keep = |from: f64, to: f64| {
            match [from > 0.0, to > 0.0] {
                [true, true] => return false,
                [true, false] => left[1] = (from / (from - to)).min(left[1]),
                [false, true] => left[0] = (from / (from - to)).max(left[0]),
                [false, false] => return true,
            }
            left[0] >= left[1]
        };
        let Edge { from, to, .. } = edge;
        keep(from.z, to.z)
            || above
                .iter()
                .any(|line| keep(line.height(*from) - SLIT * from.z, line.height(*to) - SLIT * to.z))
    }

    #[test]
    fn every_simd_level_says_what_one_line_after_the_other_says() {
        let mut number = odd_numbers(0x9E37_79B9_7F4A_7C15);
        let mut point = || DVec3::new(number(), number(), number());
        let mut tally = [[0; 2]; 3];
        for round in 0..20_000 {
            let lines: Vec<Line> = (0..round % 20 + 1).map(|_| Line { normal: point() }).collect();
            let edge = Edge {
                from: point(),
                to: point(),
                line: if round % 3 == 0 {
                    lines[round % lines.len()]
                } else {
                    Line { normal: point() }
                },
            };
            let (middle, least) = (point(), point().x);
            let expected = [
                clip_away_one_by_one(&lines, &edge),
                lines.contains(&edge.line),
                lines.iter().all(|line| line.height(middle) >= least),
            ];
            for (tally, &yes) in tally.iter_mut().zip(&expected) {
                tally[usize::from(yes)] += 1;
            }
            let mut above = LinesAbove::default();
            lines.iter().for_each(|&line| above.push(line));
            for level in levels() {
                let said = dispatch!(level, simd => [
                    above.clip_away(simd, &edge),
                    above.contains(simd, &edge.line),
                    above.contain_point(simd, middle, least),
                ]);
                assert_eq!(said, expected, "{lines:?} {edge:?} {middle} {least} {level:?}");
            }
        }
        assert!(tally.iter().flatten().all(|&often| often > 500), "{tally:?}");
    }
}
