//! Projection of an AABB through a passage: screen rectangle and nearest depth.

mod eight;
mod sphere;

pub(crate) use eight::{BOXES, EightBoxes};
pub(crate) use sphere::sphere_on_screen;

use crate::geom::Aabb;
use crate::simd::dispatch;
use crate::view::aperture::Rect;
use crate::view::screen_map::{ScreenMap, homogeneous, swapped};
use fearless_simd::prelude::*;
use fearless_simd::{Level, f64x8};
use glam::DVec3;

/// How much of a region is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// No part is visible.
    Hidden,
    /// Some part may be visible, or the cover cannot decide.
    Partial,
    /// All of it is visible, and so is everything inside it.
    Full,
}

/// The projection of an AABB through a passage: the samples it may touch, and its nearest depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Samples inside the aperture's rectangle that any part of the box may own.
    pub rect: Rect,
    /// Reversed depth (1 / distance along the view direction) of the nearest corner, rounded up; infinite if the box
    /// crosses the near plane.
    pub nearest: f32,
    /// The box itself.
    pub(crate) volume: Volume,
}

/// A parallelepiped on the screen: a corner, and the three edges from it. In (X, Y, W) space, with the eye at the origin;
/// in a parallel view in the space of (column, row, reversed depth).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    pub(crate) origin: DVec3,
    pub(crate) sides: [DVec3; 3],
    pub(crate) is_parallel: bool,
}

/// What of a passage a projection needs: the space that boxes are clipped to, and how to compute.
#[derive(Clone, Copy)]
pub(crate) struct Clip {
    /// Samples that may show the box.
    pub(crate) rect: Rect,
    /// Near-plane distance along the view direction.
    pub(crate) near: f64,
    /// Entry plane: what is in front of it, n · (X, Y, W) < d, is not visible.
    pub(crate) entry: Option<(DVec3, f64)>,
    /// How far a sample may be from the centre of its pixel, in pixels along each axis.
    pub(crate) spread: f64,
    pub(crate) level: Level,
}

/// Relative factor by which queries round reversed depth up: larger than the rounding of covers (2⁻²⁴), smaller than
/// the tolerance of the reference (2⁻¹⁶).
pub(crate) const ROUND_UP: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

impl Region {
    /// Projects an AABB, given in another space, through a passage; `None` if no sample of the aperture's rectangle can
    /// show any part of it.
    pub(crate) fn of(clip: impl Into<Clip>, screen_from_local: &ScreenMap, bounds: &Aabb) -> Option<Region> {
        Region::within(&clip.into(), screen_from_local, bounds).filter(|region| !region.rect.is_empty())
    }

    /// As [`Region::of`], but also returns regions with an empty rectangle.
    pub(crate) fn within(clip: &Clip, screen_from_local: &ScreenMap, bounds: &Aabb) -> Option<Region> {
        if bounds.is_empty() {
            return None;
        }
        let volume = Volume::new(screen_from_local, bounds);
        let ScreenBounds { min, max, nearest } = dispatch!(clip.level, simd => volume.touched(simd, clip))?;
        let rect = Rect::near(min, max, clip.spread, &clip.rect);
        Some(Region {
            rect,
            nearest,
            volume,
        })
    }
}

impl Volume {
    pub(crate) fn new(screen_from_local: &ScreenMap, bounds: &Aabb) -> Volume {
        let [min, max] = [bounds.min, bounds.max].map(|corner| DVec3::from(corner.map(f64::from)));
        let DVec3 { x, y, z } = max - min;
        let ScreenMap { linear, is_parallel } = *screen_from_local;
        let axes = linear.matrix3;
        Volume {
            origin: linear.transform_point3(min),
            sides: [axes.x_axis * x, axes.y_axis * y, axes.z_axis * z],
            is_parallel,
        }
    }

    /// Returns the screen bounds and the nearest depth; `None` if the box is outside `clip`. Computes all eight
    /// corners at once; the specification is `touched_one_by_one`, in the tests.
    #[inline(always)]
    fn touched<S: Simd>(&self, simd: S, clip: &Clip) -> Option<ScreenBounds> {
        let near = clip.near;
        let [x, y, w] = self.coordinates(simd);
        if self.is_parallel {
            return touched_in_parallel([x, y, w], clip);
        }
        let zero = f64x8::splat(simd, 0.0);
        // Relative to the centre of the rectangle, so that its sides are at ±half.
        let [middle, half] = middle_and_half(&clip.rect);
        let from_middle = [x - w * middle[0], y - w * middle[1]];
        let [right, below] = [w * half[0], w * half[1]];
        if from_middle[0].simd_lt(-right).all_true()
            || from_middle[0].simd_gt(right).all_true()
            || from_middle[1].simd_lt(-below).all_true()
            || from_middle[1].simd_gt(below).all_true()
            || w.simd_lt(near).all_true()
        {
            return None;
        }
        if let Some((normal, d)) = clip.entry {
            let at = x * normal.x + y * normal.y + w * normal.z;
            if at.simd_ge(zero + d * (1.0 - 1e-6)).all_false() {
                return None;
            }
        }
        let least = [least_of(from_middle[0]), least_of(from_middle[1]), least_of(w)];
        let greatest = [
            greatest_of(from_middle[0]),
            greatest_of(from_middle[1]),
            greatest_of(w),
        ];
        let nearest_w = nearest_w(&least, &greatest, near, &half);
        let [mut min, mut max] = [[0.0; 2], [0.0; 2]];
        if least[2] > near {
            let per_w = f64x8::splat(simd, 1.0) / w;
            let (x, y) = (x * per_w, y * per_w);
            (min, max) = ([least_of(x), least_of(y)], [greatest_of(x), greatest_of(y)]);
        } else {
            for axis in 0..2 {
                // w is between these two for all x and y.
                let [close, far] = [nearest_w, greatest[2]];
                min[axis] = middle[axis] + least[axis] / if least[axis] < 0.0 { close } else { far };
                max[axis] = middle[axis] + greatest[axis] / if greatest[axis] > 0.0 { close } else { far };
            }
        }
        Some(ScreenBounds {
            min,
            max,
            nearest: nearest(nearest_w, near),
        })
    }

    /// Returns the coordinates of the eight corners, in the order of [`Volume::corners`], in the space of the volume.
    #[inline(always)]
    fn coordinates<S: Simd>(&self, simd: S) -> [f64x8<S>; 3] {
        let [a, b, c] = self.sides;
        [
            along(simd, self.origin.x, a.x, b.x, c.x),
            along(simd, self.origin.y, a.y, b.y, c.y),
            along(simd, self.origin.z, a.z, b.z, c.z),
        ]
    }

    /// Returns column, row and reversed depth of the eight corners, in the order of [`Volume::corners`]; `None` if any of
    /// them is not beyond the near plane.
    #[inline(always)]
    pub(crate) fn corners_on_screen<S: Simd>(&self, simd: S, near: f64) -> Option<[f64x8<S>; 3]> {
        let [x, y, z] = self.coordinates(simd);
        if self.is_parallel {
            let rev_near = f64x8::splat(simd, 1.0 / near);
            let beyond = z.simd_gt(f64x8::splat(simd, 0.0)) & z.simd_lt(rev_near);
            return beyond.all_true().then_some([x, y, z]);
        }
        if !z.simd_gt(f64x8::splat(simd, near)).all_true() {
            return None;
        }
        let rev_depth = f64x8::splat(simd, 1.0) / z;
        Some([x * rev_depth, y * rev_depth, rev_depth])
    }

    /// Whether all of a parallel view's volume is within its depth range, so that (X, Y, W) are defined. Always in
    /// perspective.
    pub(crate) fn is_in_depth_range(&self) -> bool {
        let least = self.origin.z + self.sides.iter().map(|side| side.z.min(0.0)).sum::<f64>();
        !self.is_parallel || least > 0.0
    }

    /// Returns the column, row and reversed depth of a point in the space of the volume.
    #[inline(always)]
    pub(crate) fn on_screen(&self, at: DVec3) -> DVec3 {
        if self.is_parallel {
            return at;
        }
        let rev_depth = 1.0 / at.z;
        DVec3::new(at.x * rev_depth, at.y * rev_depth, rev_depth)
    }

    /// Returns the eight corners as (X, Y, W); bit k of a corner's index is set if side k is added.
    pub(crate) fn corners(&self) -> [DVec3; 8] {
        self.corners_in_space()
            .map(|corner| homogeneous(corner, self.is_parallel))
    }

    /// As [`Volume::corners`], in the space of the volume.
    #[inline(always)]
    fn corners_in_space(&self) -> [DVec3; 8] {
        let Volume {
            origin,
            sides: [x, y, z],
            ..
        } = *self;
        let (xy, far) = (x + y, origin + z);
        [
            origin,
            origin + x,
            origin + y,
            origin + xy,
            far,
            far + x,
            far + y,
            far + xy,
        ]
    }
}

/// As [`Volume::touched`] in a parallel view, by column, row and reversed depth of the corners. These may be anywhere, also
/// beyond the depth range of the passage.
#[inline(always)]
fn touched_in_parallel<S: Simd>([x, y, rev_depth]: [f64x8<S>; 3], clip: &Clip) -> Option<ScreenBounds> {
    let [low, high] = limits_of(&clip.rect);
    let rev_near = 1.0 / clip.near;
    if x.simd_lt(low[0]).all_true()
        || x.simd_gt(high[0]).all_true()
        || y.simd_lt(low[1]).all_true()
        || y.simd_gt(high[1]).all_true()
        || rev_depth.simd_gt(rev_near).all_true()
    {
        return None;
    }
    if let Some((normal, d)) = clip.entry {
        let (normal, d) = swapped(normal, d * (1.0 - 1e-6));
        let at = x * normal.x + y * normal.y + rev_depth * normal.z;
        if at.simd_ge(d).all_false() {
            return None;
        }
    }
    Some(ScreenBounds {
        min: [least_of(x), least_of(y)],
        max: [greatest_of(x), greatest_of(y)],
        nearest: nearest_in_parallel(greatest_of(rev_depth), rev_near),
    })
}

/// Returns the first and the last position of a rectangle along each axis, in pixels.
#[inline(always)]
fn limits_of(rect: &Rect) -> [[f64; 2]; 2] {
    [
        [rect.x0, rect.y0].map(f64::from),
        [rect.x1, rect.y1].map(f64::from),
    ]
}

/// Returns the nearest reversed depth, rounded up. What is beyond the depth range is nearer than nothing.
#[inline(always)]
fn nearest_in_parallel(greatest: f64, rev_near: f64) -> f32 {
    if greatest < rev_near {
        greater(greatest * ROUND_UP, f64::from(f32::MIN_POSITIVE)) as f32
    } else {
        f32::INFINITY
    }
}

/// Screen bounds, in pixels, and nearest reversed depth.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ScreenBounds {
    min: [f64; 2],
    max: [f64; 2],
    nearest: f32,
}

/// Returns the centre and the half extent of a rectangle.
#[inline(always)]
fn middle_and_half(limits: &Rect) -> [[f64; 2]; 2] {
    let Rect { x0, y0, x1, y1 } = *limits;
    [
        [0.5 * f64::from(x0 + x1), 0.5 * f64::from(y0 + y1)],
        [0.5 * f64::from(x1 - x0), 0.5 * f64::from(y1 - y0)],
    ]
}

/// Returns a lower bound of w inside the rectangle. There |x| ≤ half · w, so w ≥ |x| / half: a ceiling overhead comes
/// no nearer than where it enters the picture, however far behind the eye its box reaches.
#[inline(always)]
fn nearest_w(least: &[f64; 3], greatest: &[f64; 3], near: f64, half: &[f64; 2]) -> f64 {
    let mut nearest_w = greater(least[2], near);
    for axis in 0..2 {
        nearest_w = greater(nearest_w, greater(least[axis], -greatest[axis]) / half[axis]);
    }
    nearest_w
}

#[inline(always)]
fn nearest(nearest_w: f64, near: f64) -> f32 {
    if nearest_w > near {
        (ROUND_UP / nearest_w) as f32
    } else {
        f32::INFINITY
    }
}

/// Returns one coordinate of a box's eight corners, in the order of [`Volume::corners`].
#[inline(always)]
fn along<S: Simd>(simd: S, origin: f64, x: f64, y: f64, z: f64) -> f64x8<S> {
    let (xy, far) = (x + y, origin + z);
    let from = [origin, origin, origin, origin, far, far, far, far];
    f64x8::from_slice(simd, &from) + f64x8::from_slice(simd, &[0.0, x, y, xy, 0.0, x, y, xy])
}

/// Returns the minimum of eight numbers, ignoring NaN.
#[inline(always)]
pub(crate) fn least_of<S: Simd>(values: f64x8<S>) -> f64 {
    let mut least: [f64; 8] = values.into();
    for value in &mut least {
        *value = smaller(*value, f64::INFINITY);
    }
    for width in [4, 2, 1] {
        for i in 0..width {
            least[i] = smaller(least[i], least[i + width]);
        }
    }
    least[0]
}

/// Returns the maximum of eight numbers, ignoring NaN.
#[inline(always)]
pub(crate) fn greatest_of<S: Simd>(values: f64x8<S>) -> f64 {
    let mut greatest: [f64; 8] = values.into();
    for value in &mut greatest {
        *value = greater(*value, f64::NEG_INFINITY);
    }
    for width in [4, 2, 1] {
        for i in 0..width {
            greatest[i] = greater(greatest[i], greatest[i + width]);
        }
    }
    greatest[0]
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests;
