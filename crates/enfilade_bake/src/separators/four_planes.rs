//! Four separating planes at a time: each is rotated about an edge of one winding until it touches the other winding.
//!
//! Each SIMD lane holds one edge. The kernel loops over the other winding's corners, and each lane keeps the lowest so
//! far.
//! Source: one turn of gift wrapping (Chand, Kapur. An Algorithm for Convex Polytopes. Journal of the ACM 17, 1970).
//! Cost: O(corners of both) for four edges, without branches.
//! Exact: the operations and their order are the same at every SIMD level, so the bits equal those of the scalar
//! version.

use super::{NEEDLE, ROUNDING};
use crate::winding::{Plane, above_exactly};
use fearless_simd::prelude::*;
use fearless_simd::{f64x4, mask64x4};
use glam::DVec3;

/// Four planes, one per lane. A lane without a plane has everything above it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FourPlanes {
    normal: [[f64; 4]; 3],
    offset: [f64; 4],
    slack: [f64; 4],
    /// The three corners that define each plane: the ends of an edge of one winding, and a corner of the other.
    ends: [[usize; 2]; 4],
    touched: [usize; 4],
    /// Whether the winding with the edges is the upper one.
    edges_above: bool,
    /// One bit for each lane that has a plane.
    parts: u64,
}

/// Position of a winding relative to the four planes; one bit per lane.
pub(super) struct Heights {
    /// All of it is below, regardless of rounding.
    pub(super) below: u64,
    /// None of it is above, or so little that rounding could decide.
    pub(super) touching: u64,
    /// Some of it is below, regardless of rounding.
    pub(super) cut: u64,
}

/// Four edges, one per lane.
#[derive(Clone, Copy)]
struct Edges<S: Simd> {
    from: [f64x4<S>; 3],
    along: [f64x4<S>; 3],
    length_squared: f64x4<S>,
}

impl FourPlanes {
    /// Computes the planes through four edges of `edged` that touch `other` and separate the two.
    ///
    /// `ends` holds the indices of each edge's first and last corner; lanes may repeat an edge. `size` is the largest
    /// distance between two corners of the world. With `edges_above` the planes are flipped so that `edged` is above.
    #[inline(always)]
    pub(super) fn find<S: Simd>(
        simd: S,
        ends: [[usize; 2]; 4],
        [edged, other]: [&[DVec3]; 2],
        edges_above: bool,
        size: f64,
    ) -> FourPlanes {
        let splat = |value: f64| f64x4::splat(simd, value);
        let edges = Edges::of(simd, ends, edged);
        let mut cross = [splat(0.0); 3];
        let mut lengths_squared = splat(0.0);
        let mut touching = splat(-1.0);
        for (at, &corner) in other.iter().enumerate() {
            let reach = edges.reach(simd, corner);
            let lower = dot(cross, reach).simd_lt(0.0) | touching.simd_lt(0.0);
            let turned = crossed(edges.along, reach);
            let lengths = edges.length_squared * dot(reach, reach);
            let taken = lower & dot(turned, turned).simd_gt(lengths * NEEDLE);
            for axis in 0..3 {
                cross[axis] = taken.select(turned[axis], cross[axis]);
            }
            lengths_squared = taken.select(lengths, lengths_squared);
            touching = taken.select(splat(at as f64), touching);
        }
        let found = touching.simd_ge(0.0);
        let squared = dot(cross, cross);
        let length = squared.sqrt();
        let normal = [cross[0] / length, cross[1] / length, cross[2] / length];
        let (parts, sine_squared) = edges.part(simd, [edged, other], normal, squared / lengths_squared);
        let parts = parts & found;
        let up = splat(if edges_above { -1.0 } else { 1.0 });
        let [zero, nowhere] = [splat(0.0), splat(f64::NEG_INFINITY)];
        let touching: [f64; 4] = touching.into();
        FourPlanes {
            normal: [
                parts.select(normal[0] * up, zero).into(),
                parts.select(normal[1] * up, zero).into(),
                parts.select(normal[2] * up, zero).into(),
            ],
            offset: parts.select(dot(normal, edges.from) * up, nowhere).into(),
            slack: ((splat(1.0) / sine_squared.sqrt() + 1.0) * (8.0 * ROUNDING * size)).into(),
            ends,
            touched: [
                touching[0] as usize,
                touching[1] as usize,
                touching[2] as usize,
                touching[3] as usize,
            ],
            edges_above,
            parts: parts.to_bitmask(),
        }
    }

    /// Keeps the first `lanes` lanes; returns `None` if none of them has a plane.
    pub(super) fn first(mut self, lanes: usize) -> Option<FourPlanes> {
        for lane in lanes..4 {
            self.parts &= !(1 << lane);
            self.normal.iter_mut().for_each(|axis| axis[lane] = 0.0);
            self.offset[lane] = f64::NEG_INFINITY;
        }
        (self.parts != 0).then_some(self)
    }

    /// Returns the plane of a lane.
    pub(super) fn plane(&self, lane: usize) -> Plane {
        Plane {
            normal: DVec3::new(self.normal[0][lane], self.normal[1][lane], self.normal[2][lane]),
            offset: self.offset[lane],
            slack: self.slack[lane],
        }
    }

    /// As [`Plane::above`], for all four lanes.
    #[inline(always)]
    fn above<S: Simd>(&self, simd: S, point: DVec3) -> f64x4<S> {
        let lanes = |of: [f64; 4]| f64x4::simd_from(simd, of);
        let splat = |value: f64| f64x4::splat(simd, value);
        let [x, y, z] = &self.normal;
        lanes(*x) * splat(point.x) + lanes(*y) * splat(point.y) + lanes(*z) * splat(point.z)
            - lanes(self.offset)
    }

    #[inline(always)]
    pub(super) fn heights<S: Simd>(&self, simd: S, winding: &[DVec3]) -> Heights {
        let mut least = f64x4::splat(simd, f64::INFINITY);
        let mut most = f64x4::splat(simd, f64::NEG_INFINITY);
        for &corner in winding {
            let above = self.above(simd, corner);
            least = least.min(above);
            most = most.max(above);
        }
        let slack = f64x4::simd_from(simd, self.slack);
        Heights {
            below: most.simd_lt(-slack).to_bitmask(),
            touching: most.simd_le(slack).to_bitmask(),
            cut: least.simd_lt(-slack).to_bitmask(),
        }
    }

    /// Returns `true` if a way is below one of the planes between `windings`. A bounding sphere test decides most ways.
    #[inline(always)]
    pub(super) fn culls_way<S: Simd>(
        &self,
        simd: S,
        windings: [&[DVec3]; 2],
        (centre, radius): (DVec3, f64),
        corners: &[DVec3],
    ) -> bool {
        let middle = self.above(simd, centre);
        let reach = f64x4::simd_from(simd, self.slack) + radius;
        let near = middle.simd_le(reach);
        if !near.any_true() {
            return false;
        }
        if middle.simd_lt(-reach).any_true() {
            return true;
        }
        let heights = self.heights(simd, corners);
        let touching = heights.touching & near.to_bitmask();
        heights.below != 0
            || (0..4).any(|lane| touching >> lane & 1 != 0 && self.culls_exactly(lane, windings, corners))
    }

    /// Returns `true` if exact arithmetic shows that no corner of `winding` is above the plane of a lane, and that the
    /// plane separates `windings`. For windings so close to the plane that rounding could decide.
    ///
    /// Corners on the plane are not above it.
    pub(super) fn culls_exactly(&self, lane: usize, windings: [&[DVec3]; 2], winding: &[DVec3]) -> bool {
        let [below, above] = windings;
        let (edged, other) = if self.edges_above {
            (above, below)
        } else {
            (below, above)
        };
        let [from, to] = self.ends[lane];
        let through = [edged[from], edged[to], other[self.touched[lane]]];
        let up = if self.edges_above { -1.0 } else { 1.0 };
        let plane = self.plane(lane);
        let none_above = |corners: &[DVec3], side: f64| {
            corners.iter().all(|&corner| {
                plane.above(corner) * side < -plane.slack
                    || above_exactly(&through, corner) * up * side <= 0.0
            })
        };
        none_above(winding, 1.0) && none_above(below, 1.0) && none_above(above, -1.0)
    }
}

impl<S: Simd> Edges<S> {
    #[inline(always)]
    fn of(simd: S, ends: [[usize; 2]; 4], edged: &[DVec3]) -> Edges<S> {
        let [mut from, mut along] = [[[0.0; 4]; 3]; 2];
        for (lane, [start, end]) in ends.into_iter().enumerate() {
            let [start, end] = [edged[start], edged[end]];
            for axis in 0..3 {
                from[axis][lane] = start[axis];
                along[axis][lane] = end[axis] - start[axis];
            }
        }
        let lanes = |of: [f64; 4]| f64x4::simd_from(simd, of);
        let from = [lanes(from[0]), lanes(from[1]), lanes(from[2])];
        let along = [lanes(along[0]), lanes(along[1]), lanes(along[2])];
        Edges {
            from,
            along,
            length_squared: dot(along, along),
        }
    }

    /// Returns the vectors from the start of each edge to a corner.
    #[inline(always)]
    fn reach(&self, simd: S, corner: DVec3) -> [f64x4<S>; 3] {
        let splat = |value: f64| f64x4::splat(simd, value);
        [
            splat(corner.x) - self.from[0],
            splat(corner.y) - self.from[1],
            splat(corner.z) - self.from[2],
        ]
    }

    /// Returns the lanes whose plane separates the two windings up to rounding, and per lane the smallest squared sine
    /// between the edge and a corner that may touch the plane.
    #[inline(always)]
    fn part(
        &self,
        simd: S,
        [edged, other]: [&[DVec3]; 2],
        normal: [f64x4<S>; 3],
        mut sine_squared: f64x4<S>,
    ) -> (mask64x4<S>, f64x4<S>) {
        let zero = f64x4::splat(simd, 0.0);
        let mut parts = zero.simd_eq(zero);
        for (winding, side) in [(edged, -1.0), (other, 1.0)] {
            for &corner in winding {
                let reach = self.reach(simd, corner);
                let above = dot(normal, reach) * side;
                let reach_squared = dot(reach, reach);
                let clear = (above * above * sine_squared).simd_gt(reach_squared * (ROUNDING * ROUNDING));
                parts &= !(clear & above.simd_lt(0.0));
                let turned = crossed(self.along, reach);
                let off_edge = dot(turned, turned);
                let lengths = self.length_squared * reach_squared;
                // Corners on the edge are on neither side. Corners almost collinear with the edge make the plane
                // unreliable.
                let rests = !clear & off_edge.simd_gt(0.0);
                parts &= !(rests & off_edge.simd_le(lengths * NEEDLE));
                sine_squared = rests.select(sine_squared.min(off_edge / lengths), sine_squared);
            }
        }
        (parts, sine_squared)
    }
}

#[inline(always)]
fn dot<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> f64x4<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn crossed<S: Simd>(a: [f64x4<S>; 3], b: [f64x4<S>; 3]) -> [f64x4<S>; 3] {
    [
        a[1] * b[2] - b[1] * a[2],
        a[2] * b[0] - b[2] * a[0],
        a[0] * b[1] - b[0] * a[1],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use fearless_simd::{Level, dispatch};

    /// Scalar reference: returns normal, offset, slack, and the index of the corner that the plane touches.
    fn through(
        [from, to]: [DVec3; 2],
        edged: &[DVec3],
        other: &[DVec3],
        size: f64,
    ) -> Option<(DVec3, f64, f64, usize)> {
        let along = to - from;
        let mut cross = DVec3::ZERO;
        let mut found = None;
        for (at, &corner) in other.iter().enumerate() {
            let reach = corner - from;
            let turned = along.cross(reach);
            let lengths = along.length_squared() * reach.length_squared();
            let lower = found.is_none() || cross.dot(reach) < 0.0;
            if lower && turned.length_squared() > NEEDLE * lengths {
                (cross, found) = (turned, Some((at, lengths)));
            }
        }
        let (touching, lengths) = found?;
        let normal = cross / cross.length_squared().sqrt();
        let mut sine_squared = cross.length_squared() / lengths;
        let sides = edged.iter().map(|&corner| (corner, -1.0));
        for (corner, side) in sides.chain(other.iter().map(|&corner| (corner, 1.0))) {
            let reach = corner - from;
            let above = normal.dot(reach) * side;
            if above * above * sine_squared > ROUNDING * ROUNDING * reach.length_squared() {
                if above < 0.0 {
                    return None;
                }
                continue;
            }
            let off_edge = along.cross(reach).length_squared();
            if off_edge == 0.0 {
                continue;
            }
            let lengths = along.length_squared() * reach.length_squared();
            if off_edge <= NEEDLE * lengths {
                return None;
            }
            sine_squared = sine_squared.min(off_edge / lengths);
        }
        let slack = (1.0 / sine_squared.sqrt() + 1.0) * (8.0 * ROUNDING * size);
        Some((normal, normal.dot(from), slack, touching))
    }

    /// Returns a random quadrilateral at height z, with corners snapped to integers if `snapped`.
    fn winding(random: &mut Random, z: f64, snapped: bool) -> Vec<DVec3> {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let middle = [random.unit(), random.unit()].map(|at| 6.0 * at);
        let corners = corners.map(|(x, y)| {
            let [dx, dy] = [random.unit(), random.unit()].map(|by| 1.0 + 2.0 * by);
            DVec3::new(middle[0] + x * dx, middle[1] + y * dy, z)
        });
        corners
            .map(|corner| if snapped { corner.round() } else { corner })
            .to_vec()
    }

    #[test]
    fn four_edges_at_a_time_equal_four_edges_one_by_one() {
        let mut parts = 0;
        for seed in 0..2000 {
            let random = &mut Random::new(seed);
            let edged = winding(random, 0.0, seed % 2 == 0);
            let other = winding(random, 3.0, seed % 2 == 0);
            let ends = [[3, 0], [0, 1], [1, 2], [2, 3]]
                .map(|[from, to]| if seed % 3 == 0 { [to, from] } else { [from, to] });
            for level in [Level::new(), Level::baseline()] {
                let windings = [edged.as_slice(), &other];
                let rest =
                    |above| dispatch!(level, simd => FourPlanes::find(simd, ends, windings, above, 100.0));
                let [four, flipped] = [false, true].map(rest);
                for (lane, ends) in ends.into_iter().enumerate() {
                    let one = through(ends.map(|end| edged[end]), &edged, &other, 100.0);
                    let (plane, turned) = (four.plane(lane), flipped.plane(lane).flipped());
                    let found = (four.parts >> lane & 1 != 0).then_some((
                        plane.normal,
                        plane.offset,
                        plane.slack,
                        four.touched[lane],
                    ));
                    assert_eq!(found, one, "seed {seed}, lane {lane}");
                    if found.is_some() {
                        assert_eq!((plane.normal, plane.offset), (turned.normal, turned.offset));
                    } else {
                        assert_eq!(plane.above(other[0]), f64::INFINITY, "seed {seed}, lane {lane}");
                    }
                    parts += u32::from(found.is_some());
                }
            }
        }
        assert!(parts > 1000, "{parts} planes");
    }
}
