//! Early rejection of triangles that own no sample, sixteen at a time in f32.
//!
//! Most triangles of a detailed mesh are back faces, are outside the rectangle, or fall between sample centres. Each of
//! the three tests uses a margin larger than any rounding error. Triangles that it cannot reject are set up in f64 as
//! usual, so the picture is the same with and without the sieve.
//! Source: original to this library; the margins follow Higham, Accuracy and Stability of Numerical Algorithms, 2nd
//!     edition, chapter 3.
//! Cost: about a hundred operations for sixteen triangles, plus fetching their vertices.
//! Exact: a rejected triangle owns no sample. The same answer at every SIMD level; [`Sieve::drops`] is the
//! specification.

use super::corners::Extent;
use crate::view::aperture::Rect;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16};

/// Triangles tested together.
pub(super) const LANES: usize = 16;

/// Vertices of sixteen triangles in rounded pixel coordinates: for each vertex the columns, then the rows.
pub(super) type Sixteen = [[[f32; LANES]; 2]; 3];

/// Parameters shared by all triangles of a batch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sieve {
    /// The first column and row; `end` has the end column and row (exclusive).
    first: [f32; 2],
    end: [f32; 2],
    /// Error bound of a bounding-box coordinate, in pixels.
    bound_margin: f32,
    /// Error bound of twice the signed area: per pixel of the triangle's width plus height; `area_floor` is its
    /// constant part.
    area_margin: f32,
    area_floor: f32,
    /// Sign of the area of front faces; 0 for double-sided faces.
    front: f32,
}

/// Result of the sieve, one bit per triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SieveResult {
    /// Triangles that may own a sample.
    pub(super) left: u32,
    /// Front faces inside the rectangle that fall between sample centres.
    pub(super) between: u32,
}

impl Sieve {
    /// Creates a sieve for triangles whose vertices are within `extent`. `front` is the sign of a front face's
    /// determinant, 0 for double-sided faces.
    #[inline(always)]
    pub(super) fn new(extent: &Extent, rect: &Rect, front: f64) -> Sieve {
        // The error of a rounded coordinate, and of a sum of two, is at most `rounding`.
        let most = extent.pixel.max(1.0);
        let rounding = most / f64::from(1 << 23);
        // Determinants are computed from (X, Y, W) in f64, to within 168 · 2⁻⁵³ of the cube of the largest W and
        // coordinate; divided by the W of all vertices they give twice the area. The slack of `Rect::around` is 10⁻⁶.
        let per_w = extent.w[1] / extent.w[0];
        let floor = (most * per_w).powi(3) / (1_u64 << 44) as f64;
        Sieve {
            first: [rect.x0, rect.y0].map(f32::from),
            end: [rect.x1, rect.y1].map(f32::from),
            bound_margin: (4.0 * rounding + 2e-6) as f32,
            area_margin: (16.0 * rounding) as f32,
            area_floor: (floor + 16.0 * rounding * (2.0 + rounding)) as f32,
            front: front as f32,
        }
    }

    /// Tests sixteen triangles.
    // Arrays of SIMD vectors are unpacked by hand: `map` over one is not inlined, and the closure it calls is compiled
    // without SIMD features.
    #[inline(always)]
    pub(super) fn sift<S: Simd>(&self, simd: S, corners: &Sixteen) -> SieveResult {
        let [[ax, ay], [bx, by], [cx, cy]] = corners;
        let [ax, ay] = [f32x16::from_slice(simd, ax), f32x16::from_slice(simd, ay)];
        let [bx, by] = [f32x16::from_slice(simd, bx), f32x16::from_slice(simd, by)];
        let [cx, cy] = [f32x16::from_slice(simd, cx), f32x16::from_slice(simd, cy)];
        let x = Side::around(simd, [ax, bx, cx], self.bound_margin, self.first[0], self.end[0]);
        let y = Side::around(simd, [ay, by, cy], self.bound_margin, self.first[1], self.end[1]);
        let beside = x.first.simd_ge(x.end) | y.first.simd_ge(y.end);
        let (abx, aby, bcx, bcy) = (bx - ax, by - ay, cx - bx, cy - by);
        let (cax, cay) = (ax - cx, ay - cy);
        let area = cax * aby - cay * abx;
        let margin = (x.size + y.size) * self.area_margin + self.area_floor;
        let outside = -margin;
        let behind = (area * self.front).simd_lt(outside);
        let gone = (beside | behind).to_bitmask() as u32;

        // Centres of up to two samples per axis; with only one, it is used twice. A sample is inside if all three edge
        // functions have the sign of the area.
        let few = (x.end - x.first).simd_le(2.0) & (y.end - y.first).simd_le(2.0);
        let ([x0, x1], [y0, y1]) = (x.centres(), y.centres());
        let turn = area.simd_lt(0.0);
        let ab = Edge::new(turn, [ax, ay], [abx, aby]);
        let bc = Edge::new(turn, [bx, by], [bcx, bcy]);
        let ca = Edge::new(turn, [cx, cy], [cax, cay]);
        let all_out = few
            & area.abs().simd_gt(margin)
            & ab.least(&bc, &ca, x0, y0).simd_lt(outside)
            & ab.least(&bc, &ca, x1, y0).simd_lt(outside)
            & ab.least(&bc, &ca, x0, y1).simd_lt(outside)
            & ab.least(&bc, &ca, x1, y1).simd_lt(outside);
        let between = all_out.to_bitmask() as u32 & !gone;
        SieveResult {
            left: !gone & !between & 0xFFFF,
            between,
        }
    }
}

#[inline(always)]
fn smaller<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    a.simd_lt(b).select(a, b)
}

#[inline(always)]
fn greater<S: Simd>(a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    a.simd_gt(b).select(a, b)
}

/// One axis of a triangle's bounding rectangle: its length, and its first and end sample (exclusive).
struct Side<S: Simd> {
    size: f32x16<S>,
    first: f32x16<S>,
    end: f32x16<S>,
}

impl<S: Simd> Side<S> {
    #[inline(always)]
    fn around(simd: S, [a, b, c]: [f32x16<S>; 3], margin: f32, first: f32, end: f32) -> Side<S> {
        let low = smaller(a, smaller(b, c));
        let high = greater(a, greater(b, c));
        let before = 0.5 + margin;
        Side {
            size: high - low,
            first: greater((low - before).floor() + 1.0, f32x16::splat(simd, first)),
            end: smaller((high + before).floor(), f32x16::splat(simd, end)),
        }
    }

    #[inline(always)]
    fn centres(&self) -> [f32x16<S>; 2] {
        [self.first + 0.5, smaller(self.first + 1.0, self.end - 1.0) + 0.5]
    }
}

/// An edge function, with its sign chosen so that the inside is positive.
struct Edge<S: Simd> {
    turn: mask32x16<S>,
    from: [f32x16<S>; 2],
    along: [f32x16<S>; 2],
}

impl<S: Simd> Edge<S> {
    #[inline(always)]
    fn new(turn: mask32x16<S>, from: [f32x16<S>; 2], along: [f32x16<S>; 2]) -> Edge<S> {
        Edge { turn, from, along }
    }

    #[inline(always)]
    fn side(&self, x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
        let side = self.along[0] * (y - self.from[1]) - self.along[1] * (x - self.from[0]);
        self.turn.select(-side, side)
    }

    /// Returns the minimum of three edge functions at a point: positive inside the triangle, negative outside.
    #[inline(always)]
    fn least(&self, b: &Edge<S>, c: &Edge<S>, x: f32x16<S>, y: f32x16<S>) -> f32x16<S> {
        smaller(self.side(x, y), smaller(b.side(x, y), c.side(x, y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Dice, levels};
    use crate::raster::HalfPlane;
    use crate::raster::corners::Corners;
    use crate::simd::dispatch;
    use crate::view::screen_map::ScreenMap;
    use fearless_simd::Level;
    use glam::DVec3;

    impl Sieve {
        /// Returns whether a triangle is rejected, and whether the reason is that it falls between samples. Evaluates
        /// the same operations in the same order for one triangle.
        fn drops(&self, [a, b, c]: [[f32; 2]; 3]) -> [bool; 2] {
            let smaller = |a: f32, b: f32| if a < b { a } else { b };
            let greater = |a: f32, b: f32| if a > b { a } else { b };
            let before = 0.5 + self.bound_margin;
            let [x, y] = [0, 1].map(|axis| {
                let low = smaller(a[axis], smaller(b[axis], c[axis]));
                let high = greater(a[axis], greater(b[axis], c[axis]));
                let first = greater((low - before).floor() + 1.0, self.first[axis]);
                [
                    high - low,
                    first,
                    smaller((high + before).floor(), self.end[axis]),
                ]
            });
            let beside = x[1] >= x[2] || y[1] >= y[2];
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| [to[0] - from[0], to[1] - from[1]]);
            let area = ca[0] * ab[1] - ca[1] * ab[0];
            let margin = (x[0] + y[0]) * self.area_margin + self.area_floor;
            let behind = area * self.front < -margin;
            let few = x[2] - x[1] <= 2.0 && y[2] - y[1] <= 2.0;
            let centres = |[_, first, end]: [f32; 3]| [first + 0.5, smaller(first + 1.0, end - 1.0) + 0.5];
            let out = centres(y).into_iter().all(|y| {
                centres(x).into_iter().all(|x| {
                    let sides = [(a, ab), (b, bc), (c, ca)].map(|(from, along)| {
                        let side = along[0] * (y - from[1]) - along[1] * (x - from[0]);
                        if area < 0.0 { -side } else { side }
                    });
                    smaller(sides[0], smaller(sides[1], sides[2])) < -margin
                })
            });
            let gone = beside || behind;
            let between = !gone && few && area.abs() > margin && out;
            [gone || between, between]
        }
    }

    #[test]
    fn sixteen_triangles_are_sifted_as_one_by_one_at_every_level() {
        let mut dice = Dice::new(3);
        let mut counts = [0; 3];
        for round in 0..3000 {
            let extent = Extent {
                w: [1.0, 1.0 + f64::from(round % 3)],
                pixel: 100.0,
            };
            let rect = Rect {
                x0: 3,
                y0: 0,
                x1: 60,
                y1: 41,
            };
            let sieve = Sieve::new(&extent, &rect, f64::from(round % 3 - 1));
            let mut at = [[[0.0; LANES]; 2]; 3];
            for lane in 0..LANES {
                let middle = [dice.within(100.0), dice.within(100.0)];
                for corner in &mut at {
                    for axis in 0..2 {
                        corner[axis][lane] = (middle[axis] + dice.odd(1.5)) as f32;
                    }
                }
            }
            let sifted = levels()
                .into_iter()
                .map(|level| dispatch!(level, simd => sieve.sift(simd, &at)));
            let one_by_one: Vec<[bool; 2]> = (0..LANES)
                .map(|lane| sieve.drops(at.map(|corner| corner.map(|lanes| lanes[lane]))))
                .collect();
            for sifted in sifted {
                for (lane, &[gone, between]) in one_by_one.iter().enumerate() {
                    assert_eq!(sifted.left >> lane & 1 == 0, gone, "{at:?} {lane}");
                    assert_eq!(sifted.between >> lane & 1 == 1, between);
                }
            }
            for [gone, between] in one_by_one {
                counts[usize::from(gone) + usize::from(between)] += 1;
            }
        }
        assert!(counts.into_iter().all(|count| count > 300), "{counts:?}");
    }

    #[test]
    fn what_is_dropped_owns_no_sample_or_shows_its_back() {
        let mut dice = Dice::new(11);
        let rect = Rect {
            x0: 0,
            y0: 0,
            x1: 1280,
            y1: 720,
        };
        let mut dropped = 0;
        for round in 0..4000 {
            let front = [-1.0, 0.0, 1.0][round % 3];
            let size = 10.0_f64.powf(dice.within(3.0));
            let deep = if round % 2 == 0 { 0.01 } else { 0.9 };
            let middle = [640.0 + dice.within(700.0), 360.0 + dice.within(400.0)];
            let positions: Vec<[f32; 3]> = (0..48)
                .map(|_| {
                    let w = 3.0 + dice.within(3.0 * deep);
                    // Sometimes exactly on a sample centre.
                    let [x, y] = middle.map(|at| {
                        let at = at + dice.within(size);
                        if dice.within(1.0) > 0.8 {
                            at.floor() + 0.5
                        } else {
                            at
                        }
                    });
                    [(x * w) as f32, (y * w) as f32, w as f32]
                })
                .collect();
            let mut corners = Corners::default();
            let extent = dispatch!(Level::new(), simd => {
                corners.fill(simd, positions.len(), |i| positions[i], &ScreenMap::IDENTITY, 0.01)
            });
            let Some(extent) = extent else { continue };
            let sieve = Sieve::new(&extent, &rect, front);
            for triangle in 0..16_u32 {
                let used = [0, 1, 2].map(|i| 3 * triangle + i);
                let [gone, _] = sieve.drops(used.map(|corner| corners.rounded(corner)));
                if !gone {
                    continue;
                }
                dropped += 1;
                let [a, b, c]: [DVec3; 3] = used.map(|corner| corners.get(corner).at);
                let determinant = (b - a).cross(c - a).dot(a);
                if determinant == 0.0 || front * determinant < 0.0 {
                    continue;
                }
                let side = determinant.signum();
                let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| HalfPlane::edge(from, to, side));
                let pixels = used.map(|corner| corners.get(corner).pixel);
                let bound = |axis: usize| {
                    let at = pixels.map(|pixel| pixel[axis]);
                    let low = at.into_iter().fold(f64::INFINITY, f64::min).max(0.0) as u16;
                    let high = at.into_iter().fold(0.0, f64::max).min(1279.0) as u16;
                    low.saturating_sub(1)..=high + 1
                };
                for y in bound(1).filter(|&y| y < rect.y1) {
                    for x in bound(0).filter(|&x| x < rect.x1) {
                        let [x, y] = [x, y].map(|at| f64::from(at) + 0.5);
                        assert!(
                            !edges.iter().all(|edge| edge.holds(x, y)),
                            "{a} {b} {c} at {x} {y}"
                        );
                    }
                }
            }
        }
        assert!(dropped > 10_000, "{dropped}");
    }
}
