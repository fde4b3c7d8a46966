//! Projects eight AABBs of one space through a passage at a time.
//!
//! SIMD lanes are boxes, and corners are processed in sequence, so no operation crosses lanes.
//! Source: original.
//! Cost: O(1), the same for eight boxes as for one.
//! Conservative; bit-identical to [`Region::of`] at every SIMD level.

use super::{Clip, ROUND_UP, Region, Volume, limits_of, middle_and_half, nearest_in_parallel};
use crate::geom::Aabb;
use crate::simd::dispatch;
use crate::view::aperture::Rect;
use crate::view::screen_map::{ScreenMap, swapped};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, i32x16, mask64x8};
use glam::DVec3;

/// Number of boxes projected at a time.
pub(crate) const BOXES: usize = 8;

/// The projections of up to eight boxes.
#[derive(Default)]
pub(crate) struct EightBoxes {
    /// x, y and w of the origin, then of each side.
    volumes: [[[f64; BOXES]; 3]; 4],
    /// First columns, then first rows; `end` has the last columns and rows + 1.
    first: [i32; 2 * BOXES],
    end: [i32; 2 * BOXES],
    nearest: [f64; BOXES],
    /// Bit mask of the boxes that are out of view.
    outside: u64,
    is_parallel: bool,
}

impl EightBoxes {
    /// Projects boxes given in another space; boxes after the eighth are ignored.
    #[inline(always)]
    pub(crate) fn of(clip: impl Into<Clip>, screen_from_local: &ScreenMap, boxes: &[Aabb]) -> EightBoxes {
        let mut corners = [[f32::NAN; 2 * BOXES]; 3];
        for (lane, bounds) in boxes.iter().take(BOXES).enumerate() {
            for (axis, corner) in corners.iter_mut().enumerate() {
                corner[lane] = bounds.min[axis];
                corner[BOXES + lane] = bounds.max[axis];
            }
        }
        let (mut eight, clip) = (EightBoxes::default(), clip.into());
        eight.is_parallel = screen_from_local.is_parallel;
        dispatch!(clip.level, simd => eight.see(simd, &clip, screen_from_local, &corners));
        eight
    }

    /// Returns the samples that may show a box, and its nearest reversed depth.
    #[inline(always)]
    pub(crate) fn rect(&self, lane: usize) -> (Rect, f32) {
        let [x0, y0] = [self.first[lane] as u16, self.first[BOXES + lane] as u16];
        let [x1, y1] = [self.end[lane] as u16, self.end[BOXES + lane] as u16];
        let rect = if self.outside >> lane & 1 == 0 {
            Rect { x0, y0, x1, y1 }
        } else {
            Rect::default()
        };
        (rect, self.nearest[lane] as f32)
    }

    /// Returns the region of a box; `None` if no sample of the aperture's rectangle can show any part of it.
    #[inline(always)]
    pub(crate) fn region(&self, lane: usize) -> Option<Region> {
        let (rect, nearest) = self.rect(lane);
        if rect.is_empty() {
            return None;
        }
        let [origin, x, y, z] = &self.volumes;
        let vector = |kept: &[[f64; BOXES]; 3]| DVec3::new(kept[0][lane], kept[1][lane], kept[2][lane]);
        Some(Region {
            rect,
            nearest,
            volume: Volume {
                origin: vector(origin),
                sides: [vector(x), vector(y), vector(z)],
                is_parallel: self.is_parallel,
            },
        })
    }

    /// `corners`: by axis the minimum of each box, then the maximum.
    #[inline(always)]
    fn see<S: Simd>(
        &mut self,
        simd: S,
        clip: &Clip,
        screen_from_local: &ScreenMap,
        corners: &[[f32; 2 * BOXES]; 3],
    ) {
        let volumes = Volumes::new(simd, screen_from_local, corners);
        for (kept, vector) in self.volumes.iter_mut().zip(&volumes.vectors) {
            for (kept, axis) in kept.iter_mut().zip(vector) {
                axis.store_slice(kept);
            }
        }
        if self.is_parallel {
            return self.see_in_parallel(simd, clip, &volumes);
        }
        let (limits, near) = (clip.rect, clip.near);
        let [middle, half] = middle_and_half(&limits);
        let none: mask64x8<S> = mask64x8::splat(simd, false);
        let mut inside = [none; 6];
        let mut bounds = Bounds::new(simd);
        for corner in 0..8 {
            let [x, y, w] = [
                volumes.coordinate(simd, 0, corner),
                volumes.coordinate(simd, 1, corner),
                volumes.coordinate(simd, 2, corner),
            ];
            let from_middle = [x - w * middle[0], y - w * middle[1]];
            let [right, below] = [w * half[0], w * half[1]];
            // Negated, so that NaN counts as inside.
            inside[0] |= !from_middle[0].simd_lt(-right);
            inside[1] |= !from_middle[0].simd_gt(right);
            inside[2] |= !from_middle[1].simd_lt(-below);
            inside[3] |= !from_middle[1].simd_gt(below);
            inside[4] |= !w.simd_lt(near);
            if let Some((normal, d)) = clip.entry {
                let at = x * normal.x + y * normal.y + w * normal.z;
                inside[5] |= at.simd_ge(f64x8::splat(simd, d * (1.0 - 1e-6)));
            }
            let per_w = f64x8::splat(simd, 1.0) / w;
            bounds.add([from_middle[0], from_middle[1], w, x * per_w, y * per_w]);
        }
        let mut seen = volumes.there & inside[0] & inside[1] & inside[2] & inside[3] & inside[4];
        if clip.entry.is_some() {
            seen &= inside[5];
        }
        self.outside = !seen.to_bitmask();
        let nearest_w = bounds.nearest_w(simd, near, &half);
        let nearest = f64x8::splat(simd, ROUND_UP) / nearest_w;
        let beyond = nearest_w.simd_gt(f64x8::splat(simd, near));
        beyond
            .select(nearest, f64x8::splat(simd, f64::INFINITY))
            .store_slice(&mut self.nearest);
        let [min, max] = bounds.on_screen(simd, near, nearest_w, &middle);
        self.keep_samples(simd, min, max, clip);
    }

    /// As [`EightBoxes::see`] in a parallel view.
    #[inline(always)]
    fn see_in_parallel<S: Simd>(&mut self, simd: S, clip: &Clip, volumes: &Volumes<S>) {
        let [low, high] = limits_of(&clip.rect);
        let rev_near = 1.0 / clip.near;
        let none: mask64x8<S> = mask64x8::splat(simd, false);
        let mut inside = [none; 6];
        let mut bounds = Bounds::new(simd);
        for corner in 0..8 {
            let [x, y, rev_depth] = [
                volumes.coordinate(simd, 0, corner),
                volumes.coordinate(simd, 1, corner),
                volumes.coordinate(simd, 2, corner),
            ];
            // Negated, so that NaN counts as inside.
            inside[0] |= !x.simd_lt(low[0]);
            inside[1] |= !x.simd_gt(high[0]);
            inside[2] |= !y.simd_lt(low[1]);
            inside[3] |= !y.simd_gt(high[1]);
            inside[4] |= !rev_depth.simd_gt(rev_near);
            if let Some((normal, d)) = clip.entry {
                let (normal, d) = swapped(normal, d * (1.0 - 1e-6));
                let at = x * normal.x + y * normal.y + rev_depth * normal.z;
                inside[5] |= at.simd_ge(f64x8::splat(simd, d));
            }
            bounds.add([x, y, rev_depth, x, y]);
        }
        let mut seen = volumes.there & inside[0] & inside[1] & inside[2] & inside[3] & inside[4];
        if clip.entry.is_some() {
            seen &= inside[5];
        }
        self.outside = !seen.to_bitmask();
        bounds.greatest[2].store_slice(&mut self.nearest);
        for nearest in &mut self.nearest {
            *nearest = f64::from(nearest_in_parallel(*nearest, rev_near));
        }
        let [min, max] = [bounds.least, bounds.greatest].map(|of| [of[0], of[1]]);
        self.keep_samples(simd, min, max, clip);
    }

    /// Keeps the samples between the minimum and maximum screen positions.
    #[inline(always)]
    fn keep_samples<S: Simd>(
        &mut self,
        simd: S,
        mut min: [f64x8<S>; 2],
        mut max: [f64x8<S>; 2],
        clip: &Clip,
    ) {
        if clip.spread > 0.0 {
            min = [min[0] - clip.spread, min[1] - clip.spread];
            max = [max[0] + clip.spread, max[1] + clip.spread];
        }
        let [first, end] = samples(simd, min, max, &clip.rect);
        first.store_slice(&mut self.first);
        end.store_slice(&mut self.end);
    }
}

/// Returns the samples between the minimum and maximum screen positions, as [`Rect::around`] does: columns, then rows.
#[inline(always)]
fn samples<S: Simd>(simd: S, min: [f64x8<S>; 2], max: [f64x8<S>; 2], limits: &Rect) -> [i32x16<S>; 2] {
    let [low, high] = [
        [limits.x0, limits.y0].map(f64::from),
        [limits.x1, limits.y1].map(f64::from),
    ];
    let slack = 0.5 + Rect::SLACK;
    let [mut first, mut end] = [min, max];
    for axis in 0..2 {
        let [least, most] = [low[axis], high[axis]].map(|limit| f64x8::splat(simd, limit));
        first[axis] = ((min[axis] - slack).max(least - 1.0).min(most) + 1.0)
            .max(least)
            .floor();
        end[axis] = (max[axis] + slack).max(least).min(most).floor();
    }
    // Integers below 65,537: exact in f32.
    let [first, end]: [f32x16<S>; 2] = [first[0].narrow(first[1]), end[0].narrow(end[1])];
    [first.to_int(), end.to_int()]
}

/// Volumes, one in each lane.
struct Volumes<S: Simd> {
    vectors: [[f64x8<S>; 3]; 4],
    /// Whether the box is not empty.
    there: mask64x8<S>,
}

impl<S: Simd> Volumes<S> {
    /// As [`Volume::new`].
    #[inline(always)]
    fn new(simd: S, screen_from_local: &ScreenMap, corners: &[[f32; 2 * BOXES]; 3]) -> Volumes<S> {
        let (x, x_end) = f32x16::from_slice(simd, &corners[0]).widen();
        let (y, y_end) = f32x16::from_slice(simd, &corners[1]).widen();
        let (z, z_end) = f32x16::from_slice(simd, &corners[2]).widen();
        let there = x.simd_le(x_end) & y.simd_le(y_end) & z.simd_le(z_end);
        let [width, height, depth] = [x_end - x, y_end - y, z_end - z];
        let matrix = screen_from_local.linear.matrix3;
        let [to_x, to_y, to_z] = [
            matrix.x_axis.to_array(),
            matrix.y_axis.to_array(),
            matrix.z_axis.to_array(),
        ];
        let offset = screen_from_local.linear.translation.to_array();
        let mut vectors = [[x; 3]; 4];
        for axis in 0..3 {
            vectors[0][axis] = x * to_x[axis] + y * to_y[axis] + z * to_z[axis] + offset[axis];
            vectors[1][axis] = width * to_x[axis];
            vectors[2][axis] = height * to_y[axis];
            vectors[3][axis] = depth * to_z[axis];
        }
        Volumes { vectors, there }
    }

    /// Returns one coordinate of a corner of each volume, summed in the same order as for a single volume.
    #[inline(always)]
    fn coordinate(&self, simd: S, axis: usize, corner: usize) -> f64x8<S> {
        let [origin, x, y, z] = [
            self.vectors[0][axis],
            self.vectors[1][axis],
            self.vectors[2][axis],
            self.vectors[3][axis],
        ];
        let from = if corner & 4 == 0 { origin } else { origin + z };
        from + match corner & 3 {
            0 => f64x8::splat(simd, 0.0),
            1 => x,
            2 => y,
            _ => x + y,
        }
    }
}

/// Minimum and maximum of five values over the corners: x and y relative to the centre times w, w, and screen x and y.
struct Bounds<S: Simd> {
    least: [f64x8<S>; 5],
    greatest: [f64x8<S>; 5],
}

impl<S: Simd> Bounds<S> {
    #[inline(always)]
    fn new(simd: S) -> Bounds<S> {
        Bounds {
            least: [f64x8::splat(simd, f64::INFINITY); 5],
            greatest: [f64x8::splat(simd, f64::NEG_INFINITY); 5],
        }
    }

    #[inline(always)]
    fn add(&mut self, values: [f64x8<S>; 5]) {
        for ((least, greatest), value) in self.least.iter_mut().zip(&mut self.greatest).zip(values) {
            *least = value.simd_lt(*least).select(value, *least);
            *greatest = value.simd_gt(*greatest).select(value, *greatest);
        }
    }

    /// As [`super::nearest_w`].
    #[inline(always)]
    fn nearest_w(&self, simd: S, near: f64, half: &[f64; 2]) -> f64x8<S> {
        let mut nearest_w = greater(self.least[2], f64x8::splat(simd, near));
        for (axis, half) in half.iter().enumerate() {
            let beside = greater(self.least[axis], -self.greatest[axis]) / *half;
            nearest_w = greater(nearest_w, beside);
        }
        nearest_w
    }

    /// Returns the minimum and maximum screen positions.
    #[inline(always)]
    fn on_screen(&self, simd: S, near: f64, nearest_w: f64x8<S>, middle: &[f64; 2]) -> [[f64x8<S>; 2]; 2] {
        let mut min = [self.least[3], self.least[4]];
        let mut max = [self.greatest[3], self.greatest[4]];
        let beyond = self.least[2].simd_gt(f64x8::splat(simd, near));
        if beyond.all_true() {
            return [min, max];
        }
        let zero = f64x8::splat(simd, 0.0);
        for axis in 0..2 {
            // w is between these two for all x and y.
            let [close, far] = [nearest_w, self.greatest[2]];
            let [least, greatest] = [self.least[axis], self.greatest[axis]];
            let low = least / least.simd_lt(zero).select(close, far) + middle[axis];
            let high = greatest / greatest.simd_gt(zero).select(close, far) + middle[axis];
            min[axis] = beyond.select(min[axis], low);
            max[axis] = beyond.select(max[axis], high);
        }
        [min, max]
    }
}

/// Returns the larger of each pair.
#[inline(always)]
fn greater<S: Simd>(a: f64x8<S>, b: f64x8<S>) -> f64x8<S> {
    a.simd_gt(b).select(a, b)
}
