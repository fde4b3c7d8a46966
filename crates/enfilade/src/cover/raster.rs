//! Turns triangles into runs of samples, exactly as rays through the samples would meet them.
//!
//! A corner is kept as (X, Y, W), never divided for a decision: an edge is the plane through the eye and its two
//! ends, reversed depth is the triangle's plane, and both are linear on the screen. So a triangle that crosses the near
//! plane, or has corners behind the eye, needs no clipping: "nearer than the near distance" is one more edge.
//! Source: Olano, Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates, Graphics Hardware 1997.
//! Cost: a triangle O(rows it touches) + O(samples it owns); one without a sample only its bounds.
//! Exact up to the rounding of f64: edges within 10⁻⁹ pixel, and a shared edge has the same bits on both sides, so
//! that each sample belongs to exactly one of them. The same bits at every SIMD level: the compiler only widens it.

pub(super) use super::band::{BAND, Band};
use super::batch::Triangles;
use super::corners::{Corner, Corners};
use super::half_plane::HalfPlane;
use super::part::{Part, greater, smaller};
use super::sieve::{self, Sieve};
use super::triangle::Triangle;
use crate::aperture::Rect;
use crate::faces::{Cut, FaceSource, Faces};
use crate::passage::{BEYOND, Passage};
use crate::simd::level;
use crate::stats::Stats;
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use std::hint::black_box;

/// Receives the samples of triangles.
pub(super) trait Sink {
    /// Is all that lies in `rect` and is no nearer than `nearest` hidden already? `false` when unsure.
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool;

    /// Does it know all that it wants to know of the batch at hand?
    #[inline(always)]
    fn is_done(&self) -> bool {
        false
    }

    /// A triangle that is not hidden comes next; its corners as (X, Y, W).
    #[inline(always)]
    fn begin(&mut self, _triangle: &Triangle, _corners: &[DVec3; 3]) {}

    /// The samples of some rows that the triangle owns.
    fn band(&mut self, band: &Band, triangle: &Triangle);
}

/// Corners of the batch at hand, on the screen.
pub(super) struct Raster {
    level: Level,
    buffers: Buffers,
}

#[derive(Default)]
struct Buffers {
    corners: Corners,
    planes: Vec<HalfPlane>,
    part: Part,
}

impl Default for Raster {
    fn default() -> Raster {
        Raster::at(level())
    }
}

impl Raster {
    /// At a SIMD level, which changes the time it takes and no bit of what it says.
    pub(super) fn at(level: Level) -> Raster {
        Raster {
            level,
            buffers: Buffers::default(),
        }
    }

    /// Hands the samples of a batch to `sink`, face after face.
    pub(super) fn run(&mut self, faces: &Faces, passage: &Passage, sink: &mut impl Sink, stats: &mut Stats) {
        stats.batches += 1;
        let buffers = &mut self.buffers;
        dispatch!(self.level, simd => run_batch(simd, buffers, faces, passage, sink, stats));
    }
}

#[inline(always)]
fn run_batch<S: Simd>(
    simd: S,
    buffers: &mut Buffers,
    faces: &Faces,
    passage: &Passage,
    sink: &mut impl Sink,
    stats: &mut Stats,
) {
    let Buffers {
        corners,
        planes,
        part,
    } = buffers;
    let batch = Batch {
        rect: passage.aperture.rect(),
        // An opening that the eye stands in is seen through, however near it is.
        near: if matches!(faces.source, FaceSource::Opening(_)) {
            0.0
        } else {
            f64::from(passage.near)
        },
        entry: passage.entry,
        front: faces.front(passage),
        // Only a face alone is ever cut.
        cuts: if faces.is_lone() { faces.cuts } else { &[] },
        // Openings that are edge-on are not handed out, and the square around an eye in one is as near as rounding.
        rounding: if matches!(faces.source, FaceSource::Opening(_)) {
            0.0
        } else {
            passage.corner_rounding() + ROUNDING * faces.screen_from_local.translation.length()
        },
    };
    if !faces.is_lone() {
        fetch(faces);
    }
    let first = faces.first_position as usize;
    let position = |place: usize| faces.positions[place];
    let mut triangles = Triangles::of(faces);
    let extent = if let Triangles::Lone { .. } = triangles {
        let used = |place: usize| position(faces.corners[place] as usize - first);
        corners.fill(
            simd,
            faces.corners.len(),
            used,
            faces.screen_from_local,
            batch.near,
        );
        None
    } else {
        let count = faces.positions.len();
        corners.fill(simd, count, position, faces.screen_from_local, batch.near)
    };
    let sieve = extent.map(|extent| Sieve::new(&extent, &batch.rect, batch.front));
    let mut group = [(0, [0; 3]); sieve::LANES];
    loop {
        let count = triangles.next_into(&mut group);
        if count == 0 || sink.is_done() {
            return;
        }
        let mut left = (1_u32 << count) - 1;
        if let Some(sieve) = &sieve {
            let mut at = [[[0.0; sieve::LANES]; 2]; 3];
            for (lane, (_, used)) in group[..count].iter().enumerate() {
                for corner in 0..3 {
                    [at[corner][0][lane], at[corner][1][lane]] = corners.rounded(used[corner]);
                }
            }
            let sifted = sieve.sift(simd, &at);
            stats.triangles += u64::from((sifted.between & left).count_ones());
            left &= sifted.left;
        }
        while left != 0 {
            let (owner, used) = group[left.trailing_zeros() as usize];
            left &= left - 1;
            let used = [corners.get(used[0]), corners.get(used[1]), corners.get(used[2])];
            batch.triangle(simd, owner, &used, part, planes, sink, stats);
        }
    }
}

/// Asks for all of a batch's memory at once, so that one waits for it once: of a large scene every batch lies somewhere
/// else, and a loop that computes on the way has only a few lines of a cache under way.
#[inline(always)]
fn fetch(faces: &Faces) {
    const LINE: usize = 64;
    for position in faces.positions.iter().step_by(LINE / size_of::<[f32; 3]>()) {
        black_box(position[0]);
    }
    for &corner in faces.corners.iter().step_by(LINE / size_of::<u32>()) {
        black_box(corner);
    }
}

/// Rounding of a corner on the screen, relative to the terms that it is the sum of.
const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;

/// A determinant above this part of the product of two edges and the line of sight to a corner is certainly not zero.
const THIN: f64 = 1e-6;

/// What holds for all triangles of a batch.
struct Batch<'a> {
    rect: Rect,
    near: f64,
    entry: Option<(DVec3, f64)>,
    front: f64,
    /// Planes that cut the face.
    cuts: &'a [Cut],
    /// How far rounding may have moved a corner, in the space of (X, Y, W).
    rounding: f64,
}

impl Batch<'_> {
    /// Returns `true` if the eye is in the plane of a triangle, as far as rounding lets one know: its determinant, which is
    /// zero then, is no larger than moving the corners by `rounding` makes it.
    #[cold]
    fn is_edge_on(&self, &[a, b, c]: &[DVec3; 3]) -> bool {
        let [ab, ac] = [b - a, c - a];
        let normal = ab.cross(ac);
        let moved = self.rounding + ROUNDING * a.length().max(b.length()).max(c.length());
        normal.dot(a).abs() <= moved * (normal.length() + 2.0 * a.length() * (ab.length() + ac.length()))
    }

    /// A triangle, or what is left of it behind cuts.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what one triangle needs, never kept")]
    fn triangle<S: Simd>(
        &self,
        simd: S,
        owner: u32,
        corners: &[Corner; 3],
        part: &mut Part,
        all_planes: &mut Vec<HalfPlane>,
        sink: &mut impl Sink,
        stats: &mut Stats,
    ) {
        let [a, b, c] = [corners[0].at, corners[1].at, corners[2].at];
        let crosses_near = a.z <= self.near || b.z <= self.near || c.z <= self.near;
        let [p, q, r] = [corners[0].rev_depth, corners[1].rev_depth, corners[2].rev_depth];
        let [mut least, mut greatest] = [smaller(p, smaller(q, r)), greater(p, greater(q, r))];
        if crosses_near {
            let farthest = greater(a.z, greater(b.z, c.z));
            if farthest <= self.near {
                return;
            }
            least = 1.0 / farthest;
            greatest = if self.near > 0.0 {
                1.0 / self.near
            } else {
                f64::from(f32::MAX)
            };
        }
        let rect = if crosses_near || !self.cuts.is_empty() {
            part.rect(&[a, b, c], self.near, self.cuts, &self.rect)
        } else {
            let [p, q, r] = [corners[0].pixel, corners[1].pixel, corners[2].pixel];
            let low = [
                smaller(p[0], smaller(q[0], r[0])),
                smaller(p[1], smaller(q[1], r[1])),
            ];
            let high = [
                greater(p[0], greater(q[0], r[0])),
                greater(p[1], greater(q[1], r[1])),
            ];
            Rect::around(low, high, &self.rect)
        };
        if rect.is_empty() {
            return;
        }
        let normal = (b - a).cross(c - a);
        let determinant = normal.dot(a);
        // Edge-on it owns nothing; seen from behind, a face with one side is not there.
        let sides = (b - a).length_squared() * (c - a).length_squared();
        let is_thin = determinant * determinant <= THIN * THIN * sides * a.length_squared();
        if (is_thin && self.is_edge_on(&[a, b, c])) || self.front * determinant < 0.0 {
            return;
        }
        stats.triangles += 1;
        if sink.hides(&rect, rounded_up(greatest)) {
            stats.triangles_hidden += 1;
            return;
        }
        let rev_depth = normal / determinant;
        let side = if determinant < 0.0 { -1.0 } else { 1.0 };
        let mut planes = [HalfPlane::NONE; 5];
        planes[0] = HalfPlane::edge(a, b, side);
        planes[1] = HalfPlane::edge(b, c, side);
        planes[2] = HalfPlane::edge(c, a, side);
        let mut count = 3;
        if crosses_near && self.near > 0.0 {
            planes[count] = HalfPlane::new(DVec3::new(0.0, 0.0, 1.0 / self.near) - rev_depth);
            count += 1;
        }
        if let Some((entry, distance)) = self.entry {
            planes[count] = HalfPlane::new(entry - rev_depth * (distance * BEYOND));
            count += 1;
        }
        let triangle = Triangle {
            owner,
            rev_depth,
            least,
            greatest,
        };
        sink.begin(&triangle, &[a, b, c]);
        if self.cuts.is_empty() {
            walk_rows(simd, &rect, &planes[..count], &triangle, sink, stats);
        } else {
            let cut = |cut: &Cut| HalfPlane::new(cut.normal - rev_depth * cut.distance);
            all_planes.clear();
            all_planes.extend_from_slice(&planes[..count]);
            all_planes.extend(self.cuts.iter().map(cut));
            walk_rows(simd, &rect, all_planes, &triangle, sink, stats);
        }
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
    let mut y = rect.y0 - rect.y0 % BAND as u16;
    while y < rect.y1 {
        if let Some((band, samples)) = Band::of(simd, y, rect, planes) {
            stats.samples += samples;
            sink.band(&band, triangle);
        }
        y += BAND as u16;
    }
}

/// A bound for queries: nearer than any sample of the triangle is stored.
#[inline(always)]
fn rounded_up(rev_depth: f64) -> f32 {
    (rev_depth * (1.0 + 1.0 / (1_u64 << 20) as f64)) as f32
}
