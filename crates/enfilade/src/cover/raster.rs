//! Turns triangles into runs of samples, exactly as rays through the samples would meet them.
//!
//! A corner is kept as (X, Y, W), never divided for a decision: an edge is the plane through the eye and its two
//! ends, nearness is the triangle's plane, and both are linear on the screen. So a triangle that crosses the near
//! plane, or has corners behind the eye, needs no clipping: "nearer than the near distance" is one more edge.
//! Source: Olano, Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates, Graphics Hardware 1997.
//! Cost: a triangle O(rows it touches) + O(samples it owns); one without a sample only its bounds.
//! Exact up to the rounding of f64: edges within 10⁻⁹ pixel, and a shared edge has the same bits on both sides, so
//! that each sample belongs to exactly one of them. The same bits at every SIMD level: the compiler only widens it.

use super::half_plane::HalfPlane;
use crate::aperture::Rect;
use crate::faces::{Faces, Of};
use crate::passage::Passage;
use crate::stats::Stats;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x8};
use glam::DVec3;
use std::cmp::Ordering;

/// Rows are handed out by eights, from a multiple of eight.
pub(super) const BAND: usize = 8;

/// Receives the samples of triangles.
pub(super) trait Sink {
    /// Is all that lies in `rect` and is no nearer than `nearest` hidden already? `false` when unsure.
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool;

    /// The samples of some rows that the triangle owns.
    fn band(&mut self, band: &Band, triangle: &Triangle);
}

/// Runs of samples in up to eight rows, from row `y`, a multiple of eight.
pub(super) struct Band {
    pub(super) y: u16,
    /// The first column and the one after the last, of each row; equal where it holds no sample.
    pub(super) runs: [[u16; 2]; BAND],
}

impl Band {
    /// The rows that hold a sample.
    #[inline(always)]
    pub(super) fn rows(&self) -> impl Iterator<Item = (u16, [u16; 2])> + '_ {
        (self.y..).zip(self.runs).filter(|(_, [x0, x1])| x0 < x1)
    }
}

/// A triangle whose samples are being handed out.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    /// The number of its face.
    pub(super) owner: u32,
    /// Nearness at a sample is `nearness · (x + ½, y + ½, 1)`, kept within `least` and `greatest`.
    pub(super) nearness: DVec3,
    least: f64,
    greatest: f64,
}

/// Nearness along one row.
#[derive(Clone, Copy)]
pub(super) struct Row {
    base: f64,
    step: f64,
    least: f64,
    greatest: f64,
}

impl Triangle {
    /// Bits of the greatest nearness of any sample.
    #[inline(always)]
    pub(super) fn nearest(&self) -> u32 {
        (self.greatest as f32).to_bits()
    }

    /// Nearness along row `y`.
    #[inline(always)]
    pub(super) fn row(&self, y: u16) -> Row {
        Row {
            base: self.nearness.y * (f64::from(y) + 0.5) + (self.nearness.x * 0.5 + self.nearness.z),
            step: self.nearness.x,
            least: self.least,
            greatest: self.greatest,
        }
    }
}

impl Triangle {
    /// Is it nearer (`Greater`) or farther (`Less`) than another at every sample of `rect`, where both are there, by
    /// more than samples are rounded by? `None` where neither is certain.
    #[inline(always)]
    pub(super) fn beside(&self, other: &Triangle, rect: &Rect) -> Option<Ordering> {
        const ROUNDING: f64 = 1.0 / (1_u64 << 20) as f64;
        let [mut nearer, mut farther] = [true, true];
        // Both are linear, and so is their difference: what holds at the corners holds between them.
        for y in [rect.y0, rect.y1 - 1] {
            let [mine, theirs] = [self.row(y), other.row(y)];
            for x in [rect.x0, rect.x1 - 1] {
                let x = f64::from(x);
                let [mine, theirs] = [mine.base + mine.step * x, theirs.base + theirs.step * x];
                nearer &= mine > theirs * (1.0 + ROUNDING);
                farther &= mine < theirs * (1.0 - ROUNDING);
            }
        }
        match (nearer, farther) {
            (true, false) => Some(Ordering::Greater),
            (false, true) => Some(Ordering::Less),
            _ => None,
        }
    }
}

impl Row {
    /// Nearness at column `x`, as bits: those of a positive f32 sort as it does.
    #[inline(always)]
    pub(super) fn bits(&self, x: i32) -> u32 {
        let z = self.base + self.step * f64::from(x);
        let z = if z < self.least { self.least } else { z };
        let z = if z > self.greatest { self.greatest } else { z };
        (z as f32).to_bits()
    }
}

/// Corners of the batch at hand, on the screen.
pub(super) struct Raster {
    level: Level,
    corners: Vec<Corner>,
}

impl Default for Raster {
    fn default() -> Raster {
        Raster {
            level: Level::new(),
            corners: Vec::new(),
        }
    }
}

#[derive(Clone, Copy)]
struct Corner {
    /// X, Y, W.
    at: DVec3,
    /// X / W, Y / W and 1 / W; of no meaning where W is not above zero.
    pixel: [f64; 2],
    nearness: f64,
}

impl Raster {
    /// Hands the samples of a batch to `sink`, face after face.
    pub(super) fn run(&mut self, faces: &Faces, passage: &Passage, sink: &mut impl Sink, stats: &mut Stats) {
        stats.batches += 1;
        let corners = &mut self.corners;
        dispatch!(self.level, simd => run_batch(simd, corners, faces, passage, sink, stats));
    }
}

#[inline(always)]
fn run_batch<S: Simd>(
    simd: S,
    corners: &mut Vec<Corner>,
    faces: &Faces,
    passage: &Passage,
    sink: &mut impl Sink,
    stats: &mut Stats,
) {
    let matrix = faces.screen_from_local;
    corners.clear();
    corners.extend(faces.positions.iter().map(|&[x, y, z]| {
        let (x, y, z) = (f64::from(x), f64::from(y), f64::from(z));
        let at = matrix.matrix3.x_axis * x
            + matrix.matrix3.y_axis * y
            + matrix.matrix3.z_axis * z
            + matrix.translation;
        let nearness = 1.0 / at.z;
        Corner {
            at,
            pixel: [at.x * nearness, at.y * nearness],
            nearness,
        }
    }));
    let batch = Batch {
        rect: passage.aperture.rect(),
        // An opening that the eye stands in is seen through, however near it is.
        near: if matches!(faces.of, Of::Opening(_)) {
            0.0
        } else {
            f64::from(passage.near)
        },
        entry: passage.entry,
        // A face is seen from its front where the determinant of its corners has this sign. Told from the two maps
        // apart, for the product of a flattening one has none but by rounding.
        front: match (
            faces.double_sided,
            faces.mirrored != (passage.screen_from_fragment.matrix3.determinant() < 0.0),
        ) {
            (true, _) => 0.0,
            (false, true) => 1.0,
            (false, false) => -1.0,
        },
    };
    let first = faces.first_position;
    faces.for_each(
        #[inline(always)]
        |owner, face| {
            for last in 2..face.len() {
                let used =
                    [face[0], face[last - 1], face[last]].map(|index| &corners[(index - first) as usize]);
                batch.triangle(simd, owner, used, sink, stats);
            }
        },
    );
}

/// What holds for all triangles of a batch.
struct Batch {
    rect: Rect,
    near: f64,
    entry: Option<(DVec3, f64)>,
    front: f64,
}

/// How much nearer than the entry plane a face may not be, relatively: what lies in the plane is not beyond it.
const BEYOND: f64 = 1.0 + 1.0 / (1_u64 << 18) as f64;

impl Batch {
    #[inline(always)]
    fn triangle<S: Simd>(
        &self,
        simd: S,
        owner: u32,
        corners: [&Corner; 3],
        sink: &mut impl Sink,
        stats: &mut Stats,
    ) {
        let [a, b, c] = corners.map(|corner| corner.at);
        let crosses_near = a.z <= self.near || b.z <= self.near || c.z <= self.near;
        let (rect, least, greatest) = if crosses_near {
            match self.part_beyond_near([a, b, c]) {
                Some(part) => part,
                None => return,
            }
        } else {
            let [p, q, r] = corners.map(|corner| corner.pixel);
            let low = [
                smaller(p[0], smaller(q[0], r[0])),
                smaller(p[1], smaller(q[1], r[1])),
            ];
            let high = [
                greater(p[0], greater(q[0], r[0])),
                greater(p[1], greater(q[1], r[1])),
            ];
            let [p, q, r] = corners.map(|corner| corner.nearness);
            (
                Rect::around(low, high, &self.rect),
                smaller(p, smaller(q, r)),
                greater(p, greater(q, r)),
            )
        };
        if rect.is_empty() {
            return;
        }
        let normal = (b - a).cross(c - a);
        let determinant = normal.dot(a);
        // Edge-on it owns nothing; seen from behind, a face with one side is not there.
        if determinant == 0.0 || self.front * determinant < 0.0 {
            return;
        }
        stats.triangles += 1;
        if sink.hides(&rect, rounded_up(greatest)) {
            stats.triangles_hidden += 1;
            return;
        }
        let nearness = normal / determinant;
        let side = if determinant < 0.0 { -1.0 } else { 1.0 };
        let mut planes = [HalfPlane::NONE; 5];
        planes[0] = HalfPlane::edge(a, b, side);
        planes[1] = HalfPlane::edge(b, c, side);
        planes[2] = HalfPlane::edge(c, a, side);
        let mut count = 3;
        if crosses_near && self.near > 0.0 {
            planes[count] = HalfPlane::new(DVec3::new(0.0, 0.0, 1.0 / self.near) - nearness);
            count += 1;
        }
        if let Some((entry, distance)) = self.entry {
            planes[count] = HalfPlane::new(entry - nearness * (distance * BEYOND));
            count += 1;
        }
        let triangle = Triangle {
            owner,
            nearness,
            least,
            greatest,
        };
        walk_rows(simd, &rect, &planes[..count], &triangle, sink, stats);
    }

    /// Where on the screen the part beyond the near plane can be, with its least and greatest nearness.
    #[cold]
    fn part_beyond_near(&self, corners: [DVec3; 3]) -> Option<(Rect, f64, f64)> {
        let greatest_w = corners.iter().map(|corner| corner.z).fold(0.0, f64::max);
        if greatest_w <= self.near {
            return None;
        }
        if self.near == 0.0 {
            return Some((self.rect, 1.0 / greatest_w, f64::from(f32::MAX)));
        }
        let [mut min, mut max] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let mut add = |at: DVec3| {
            for (axis, value) in [at.x / at.z, at.y / at.z].into_iter().enumerate() {
                min[axis] = smaller(value, min[axis]);
                max[axis] = greater(value, max[axis]);
            }
        };
        for (i, &here) in corners.iter().enumerate() {
            let there = corners[(i + 1) % 3];
            if here.z >= self.near {
                add(here);
            }
            if (here.z < self.near) != (there.z < self.near) {
                let at = here + (there - here) * ((self.near - here.z) / (there.z - here.z));
                add(DVec3::new(at.x, at.y, self.near));
            }
        }
        // The cut is rounded where corners are far behind the eye: a pixel more does no harm.
        let rect = Rect::around(
            [min[0] - 1.0, min[1] - 1.0],
            [max[0] + 1.0, max[1] + 1.0],
            &self.rect,
        );
        Some((rect, 1.0 / greatest_w, 1.0 / self.near))
    }
}

/// Hands out the samples of `rect` that all planes hold.
#[inline(always)]
fn walk_rows<S: Simd>(
    simd: S,
    rect: &Rect,
    planes: &[HalfPlane],
    triangle: &Triangle,
    sink: &mut impl Sink,
    stats: &mut Stats,
) {
    const ROWS: [f64; BAND] = [0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5];
    let rows = f64x8::from_slice(simd, &ROWS);
    let mut y = rect.y0 - rect.y0 % BAND as u16;
    while y < rect.y1 {
        let [mut x0, mut x1] = [rect.x0, rect.x1].map(|x| f64x8::splat(simd, f64::from(x)));
        for plane in planes {
            plane.narrow(simd, rows + f64::from(y), &mut x0, &mut x1);
        }
        let [x0, x1]: [[f64; BAND]; 2] = [x0.into(), x1.into()];
        let mut band = Band {
            y,
            runs: [[0; 2]; BAND],
        };
        let mut samples = 0;
        for row in usize::from(rect.y0.saturating_sub(y))..usize::from(rect.y1 - y).min(BAND) {
            if x0[row] < x1[row] {
                samples += u64::from(x1[row] as u16 - x0[row] as u16);
                band.runs[row] = [x0[row] as u16, x1[row] as u16];
            }
        }
        if samples > 0 {
            stats.samples += samples;
            sink.band(&band, triangle);
        }
        y += BAND as u16;
    }
}

/// A bound for queries: nearer than any sample of the triangle is stored.
#[inline(always)]
fn rounded_up(nearness: f64) -> f32 {
    (nearness * (1.0 + 1.0 / (1_u64 << 20) as f64)) as f32
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
