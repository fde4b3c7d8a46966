//! Turns triangles into runs of samples, exactly as rays through the samples would meet them.
//!
//! A corner is kept as (X, Y, W), never divided for a decision: an edge is the plane through the eye and its two
//! ends, nearness is the triangle's plane, and both are linear on the screen. So a triangle that crosses the near
//! plane, or has corners behind the eye, needs no clipping: "nearer than the near distance" is one more edge.
//! Source: Olano, Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates, Graphics Hardware 1997.
//! Cost: a triangle O(rows it touches) + O(samples it owns); one without a sample about 20 ns.
//! Exact up to the rounding of f64: edges within 10⁻⁹ pixel, and a shared edge has the same bits on both sides, so
//! that each sample belongs to exactly one of them.

use crate::aperture::Rect;
use crate::faces::{Faces, Of};
use crate::passage::Passage;
use crate::stats::Stats;
use glam::DVec3;

/// Receives the samples of triangles.
pub(super) trait Sink {
    /// Is all that lies in `rect` and is no nearer than `nearest` hidden already? `false` when unsure.
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool;

    /// A run of samples of row `y` that the triangle owns. Never empty.
    fn run(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle);
}

/// A triangle whose samples are being handed out.
pub(super) struct Triangle {
    /// The number of its face.
    pub(super) owner: u32,
    /// Nearness at a sample is `nearness · (x + ½, y + ½, 1)`, kept within `least` and `greatest`.
    nearness: DVec3,
    least: f64,
    greatest: f64,
}

/// Nearness along one row.
pub(super) struct Row {
    base: f64,
    step: f64,
    least: f64,
    greatest: f64,
}

impl Triangle {
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
#[derive(Default)]
pub(super) struct Raster {
    corners: Vec<Corner>,
}

#[derive(Clone, Copy)]
struct Corner {
    /// X, Y, W.
    at: DVec3,
    /// X / W, Y / W and 1 / W; of no meaning where W is not above zero.
    pixel: [f64; 2],
    nearness: f64,
}

/// A side of a line on the screen: a·x + b·y + c above zero, or zero where `owns`.
#[derive(Clone, Copy)]
struct HalfPlane {
    a: f64,
    b: f64,
    c: f64,
    /// −1 / a.
    root: f64,
    owns: bool,
}

impl HalfPlane {
    /// The side where `normal · (x, y, 1)` is positive; of two sides of one line, exactly one owns the line.
    #[inline(always)]
    fn new(normal: DVec3) -> HalfPlane {
        let DVec3 { x: a, y: b, z: c } = normal;
        HalfPlane {
            a,
            b,
            c,
            root: -1.0 / a,
            owns: a > 0.0 || (a == 0.0 && b > 0.0),
        }
    }

    #[inline(always)]
    fn holds(&self, x: i32, at_row: f64) -> bool {
        let value = self.a * (f64::from(x) + 0.5) + at_row;
        value > 0.0 || (value == 0.0 && self.owns)
    }

    /// Narrows the columns `x0..x1` of a row, whose centre is at `y`, to those held.
    #[inline(always)]
    fn narrow(&self, y: f64, x0: &mut i32, x1: &mut i32) {
        let at_row = self.b * y + self.c;
        if self.a == 0.0 {
            if !(at_row > 0.0 || (at_row == 0.0 && self.owns)) {
                *x1 = *x0;
            }
            return;
        }
        // Where the line crosses the row; rounding may put it one column off, so the columns about it are asked.
        let crossing = at_row * self.root - 0.5;
        let crossing = if crossing > f64::from(*x0) {
            crossing
        } else {
            f64::from(*x0)
        };
        let mut column = (if crossing < f64::from(*x1) {
            crossing
        } else {
            f64::from(*x1)
        }) as i32;
        if self.a > 0.0 {
            while column > *x0 && self.holds(column - 1, at_row) {
                column -= 1;
            }
            while column < *x1 && !self.holds(column, at_row) {
                column += 1;
            }
            *x0 = column;
        } else {
            while column < *x1 && self.holds(column, at_row) {
                column += 1;
            }
            while column > *x0 && !self.holds(column - 1, at_row) {
                column -= 1;
            }
            *x1 = column;
        }
    }
}

impl Raster {
    /// Hands the samples of a batch to `sink`, face after face.
    pub(super) fn run(&mut self, faces: &Faces, passage: &Passage, sink: &mut impl Sink, stats: &mut Stats) {
        let matrix = faces.screen_from_local;
        self.corners.clear();
        self.corners.extend(faces.positions.iter().map(|position| {
            let at = matrix.transform_point3(DVec3::from(position.map(f64::from)));
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
            // A face is seen from its front where the determinant of its corners has this sign.
            front: if faces.double_sided {
                0.0
            } else {
                -matrix.matrix3.determinant()
            },
        };
        stats.batches += 1;
        let corners = &self.corners;
        faces.for_each(|owner, face| {
            let corner = |i: usize| &corners[(face[i] - faces.first_position) as usize];
            for last in 2..face.len() {
                batch.triangle(owner, [corner(0), corner(last - 1), corner(last)], sink, stats);
            }
        });
    }
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
    fn triangle(&self, owner: u32, corners: [&Corner; 3], sink: &mut impl Sink, stats: &mut Stats) {
        let [a, b, c] = corners.map(|corner| corner.at);
        let crosses_near = a.z <= self.near || b.z <= self.near || c.z <= self.near;
        let (rect, least, greatest) = if crosses_near {
            match self.part_beyond_near([a, b, c]) {
                Some(part) => part,
                None => return,
            }
        } else {
            let [p, q, r] = corners.map(|corner| corner.pixel);
            let low = |axis: usize| smaller(p[axis], smaller(q[axis], r[axis]));
            let high = |axis: usize| greater(p[axis], greater(q[axis], r[axis]));
            let rect = Rect::around([low(0), low(1)], [high(0), high(1)], &self.rect);
            let [p, q, r] = corners.map(|corner| corner.nearness);
            (rect, smaller(p, smaller(q, r)), greater(p, greater(q, r)))
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
        let side = determinant.signum();
        let mut planes = [HalfPlane::new(DVec3::ZERO); 5];
        planes[0] = HalfPlane::new(edge(a, b) * side);
        planes[1] = HalfPlane::new(edge(b, c) * side);
        planes[2] = HalfPlane::new(edge(c, a) * side);
        let mut count = 3;
        if crosses_near && self.near > 0.0 {
            planes[count] = HalfPlane::new(DVec3::new(0.0, 0.0, 1.0 / self.near) - nearness);
            count += 1;
        }
        if let Some((entry, distance)) = self.entry {
            planes[count] = HalfPlane::new(entry - nearness * (distance * BEYOND));
            count += 1;
        }
        let planes = &planes[..count];
        let triangle = Triangle {
            owner,
            nearness,
            least,
            greatest,
        };
        for y in rect.y0..rect.y1 {
            let [mut x0, mut x1] = [i32::from(rect.x0), i32::from(rect.x1)];
            for plane in planes {
                plane.narrow(f64::from(y) + 0.5, &mut x0, &mut x1);
            }
            if x0 < x1 {
                stats.samples_tested += (x1 - x0) as u64;
                sink.run(y, x0 as u16, x1 as u16, &triangle);
            }
        }
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

/// The plane through the eye and two corners, turned to the left of `from` → `to`.
///
/// Computed from the lesser corner, so that both faces that share the edge get the same bits.
#[inline(always)]
fn edge(from: DVec3, to: DVec3) -> DVec3 {
    let first = from.x < to.x || (from.x == to.x && (from.y < to.y || (from.y == to.y && from.z < to.z)));
    if first {
        from.cross(to - from)
    } else {
        -to.cross(from - to)
    }
}

/// A bound for queries: nearer than any sample of the triangle is stored.
#[inline(always)]
pub(super) fn rounded_up(nearness: f64) -> f32 {
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
