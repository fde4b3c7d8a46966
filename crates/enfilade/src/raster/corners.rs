//! Transforms the vertices of a batch to the screen, eight at a time.
//!
//! Results are stored in structure-of-arrays blocks of eight, so that SIMD handles all eight at once. Beside them are
//! rounded pixel positions for the sieve, and the extent of the whole batch.
//! Source: original to this library; the map to (X, Y, W) is that of the rasterizer.
//! Cost: O(vertices); no allocation once the lists have grown.
//! The same bits at every SIMD level: no sum is fused or reordered. [`Corner::of`] is the specification.

#[cfg(test)]
use crate::view::screen_map::homogeneous;
use crate::view::screen_map::{ScreenMap, eight_homogeneous};
use fearless_simd::f64x8;
use fearless_simd::prelude::*;
use glam::DVec3;

/// Vertices that are transformed together.
const LANES: usize = 8;

/// A vertex in screen space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// X, Y, W: homogeneous pixel coordinates, W the distance along the view direction.
    pub(crate) at: DVec3,
    /// X / W and Y / W, in pixels; meaningless unless W > 0. `rev_depth` is 1 / W.
    pub(crate) pixel: [f64; 2],
    pub(crate) rev_depth: f64,
}

impl Corner {
    /// Projects a point given as (X, Y, W).
    #[inline(always)]
    pub(super) fn at(at: DVec3) -> Corner {
        let rev_depth = 1.0 / at.z;
        Corner {
            at,
            pixel: [at.x * rev_depth, at.y * rev_depth],
            rev_depth,
        }
    }

    /// Transforms a single vertex.
    #[cfg(test)]
    fn of(position: [f32; 3], matrix: &ScreenMap) -> Corner {
        let [x, y, z] = position.map(f64::from);
        let linear = matrix.linear;
        let at = linear.matrix3.x_axis * x
            + linear.matrix3.y_axis * y
            + linear.matrix3.z_axis * z
            + linear.translation;
        Corner::at(homogeneous(at, matrix.is_parallel))
    }
}

/// X, Y, W, X / W, Y / W and 1 / W of eight vertices.
#[derive(Clone, Copy)]
struct Eight([[f64; LANES]; 6]);

/// Transformed vertices of a batch.
#[derive(Default)]
pub(super) struct Corners {
    eights: Vec<Eight>,
    /// X / W and Y / W of each vertex, rounded to f32.
    rounded: Vec<[f32; 2]>,
}

/// Bounds over all vertices of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    /// Minimum and maximum W; both are beyond the near plane.
    pub(super) w: [f64; 2],
    /// Maximum of |X / W| and |Y / W|, in pixels.
    pub(super) pixel: f64,
}

/// Largest pixel coordinate for which f32 is precise enough for the sieve.
const FAR_OFF: f64 = 16384.0;

impl Corners {
    /// Transforms `count` positions; returns `None` if any of them is not beyond `near`, is farther than [`FAR_OFF`]
    /// from the screen origin, or is NaN.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(
        &mut self,
        simd: S,
        count: usize,
        position: impl Fn(usize) -> [f32; 3],
        matrix: &ScreenMap,
        near: f64,
    ) -> Option<Extent> {
        self.eights.clear();
        self.rounded.clear();
        // Arrays of SIMD vectors are unpacked by hand: `map` over one is not inlined, and the closure it calls is
        // compiled without SIMD features.
        let rows = matrix.linear.matrix3.transpose();
        let [x_row, y_row, z_row] = [rows.x_axis, rows.y_axis, rows.z_axis];
        let origin = matrix.linear.translation;
        let (mut least, mut greatest) = (f64x8::splat(simd, f64::INFINITY), f64x8::splat(simd, 0.0));
        let mut pixel = greatest;
        let mut tame = true;
        let mut first = 0;
        while first < count {
            let [mut x, mut y, mut z] = [[0.0; LANES]; 3];
            for (lane, ((x, y), z)) in x.iter_mut().zip(&mut y).zip(&mut z).enumerate() {
                // The last group is padded with the last vertex, which does not change the bounds.
                [*x, *y, *z] = position((first + lane).min(count - 1)).map(f64::from);
            }
            let x = f64x8::from_slice(simd, &x);
            let y = f64x8::from_slice(simd, &y);
            let z = f64x8::from_slice(simd, &z);
            let (x, y, w) = (
                x * x_row.x + y * x_row.y + z * x_row.z + origin.x,
                x * y_row.x + y * y_row.y + z * y_row.z + origin.y,
                x * z_row.x + y * z_row.y + z * z_row.z + origin.z,
            );
            let [x, y, w] = eight_homogeneous(simd, [x, y, w], matrix.is_parallel);
            let rev_depth = f64x8::splat(simd, 1.0) / w;
            let (px, py) = (x * rev_depth, y * rev_depth);
            let (ax, ay) = (px.abs(), py.abs());
            let ok = w.simd_gt(near) & ax.simd_le(FAR_OFF) & ay.simd_le(FAR_OFF);
            tame &= ok.all_true();
            let most = ax.simd_gt(ay).select(ax, ay);
            pixel = most.simd_gt(pixel).select(most, pixel);
            least = w.simd_lt(least).select(w, least);
            greatest = w.simd_gt(greatest).select(w, greatest);
            let eight = Eight([
                x.into(),
                y.into(),
                w.into(),
                px.into(),
                py.into(),
                rev_depth.into(),
            ]);
            let mut rounded = [[0.0; 2]; LANES];
            for (lane, rounded) in rounded.iter_mut().enumerate() {
                *rounded = [eight.0[3][lane] as f32, eight.0[4][lane] as f32];
            }
            self.eights.push(eight);
            self.rounded.extend_from_slice(&rounded);
            first += LANES;
        }
        let [least, greatest, pixel]: [[f64; LANES]; 3] = [least.into(), greatest.into(), pixel.into()];
        tame.then(|| Extent {
            w: [
                least.into_iter().fold(f64::INFINITY, f64::min),
                greatest.into_iter().fold(0.0, f64::max),
            ],
            pixel: pixel.into_iter().fold(0.0, f64::max),
        })
    }

    /// Returns vertex `number`.
    #[inline(always)]
    pub(super) fn get(&self, number: u32) -> Corner {
        let (Eight([x, y, w, px, py, rev_depth]), lane) =
            (&self.eights[number as usize / LANES], number as usize % LANES);
        Corner {
            at: DVec3::new(x[lane], y[lane], w[lane]),
            pixel: [px[lane], py[lane]],
            rev_depth: rev_depth[lane],
        }
    }

    /// Returns the screen position of vertex `number` in pixels, rounded to f32.
    #[inline(always)]
    pub(super) fn rounded(&self, number: u32) -> [f32; 2] {
        self.rounded[number as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::{Dice, levels};
    use crate::simd::dispatch;
    use glam::DAffine3;

    #[test]
    fn eight_corners_are_the_bits_of_one_at_every_level() {
        let mut dice = Dice::new(7);
        for round in 0..200 {
            let matrix = ScreenMap {
                linear: DAffine3::from_cols_array(&std::array::from_fn(|_| dice.within(50.0))),
                is_parallel: round % 2 == 1,
            };
            let positions: Vec<[f32; 3]> = (0..1 + round % 21)
                .map(|_| std::array::from_fn(|_| dice.odd(9.0) as f32))
                .collect();
            let mut extents = Vec::new();
            for level in levels() {
                let mut corners = Corners::default();
                extents.push(dispatch!(level, simd => corners.fill(simd, positions.len(), |i| positions[i], &matrix, 0.1)));
                for (number, &position) in positions.iter().enumerate() {
                    let [one, ours] =
                        [Corner::of(position, &matrix), corners.get(number as u32)].map(|corner| {
                            [
                                corner.at.x,
                                corner.at.y,
                                corner.at.z,
                                corner.pixel[0],
                                corner.pixel[1],
                                corner.rev_depth,
                            ]
                        });
                    for (one, ours) in one.into_iter().zip(ours) {
                        assert!(
                            one.to_bits() == ours.to_bits() || (one.is_nan() && ours.is_nan()),
                            "{one} is not {ours}"
                        );
                    }
                }
            }
            assert!(extents.windows(2).all(|pair| pair[0] == pair[1]), "{extents:?}");
            let tame = positions.iter().all(|&position| {
                let corner = Corner::of(position, &matrix);
                corner.at.z > 0.1 && corner.pixel.iter().all(|at| at.abs() <= FAR_OFF)
            });
            assert_eq!(extents[0].is_some(), tame);
        }
    }
}
