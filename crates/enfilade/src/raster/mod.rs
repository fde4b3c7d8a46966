//! Rasterizer: converts triangles to runs of samples, with the same result as casting a ray through each sample.
//!
//! Triangle setup works on homogeneous corners (X, Y, W) and decides nothing after a perspective divide. An edge
//! function is the plane through the eye and the edge's two ends; the reversed depth is the triangle's plane; both are
//! linear on the screen. So a triangle that crosses the near plane or has corners behind the eye needs no clipping: the
//! near-plane test is one more edge function.
//! Source: Olano, Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates, Graphics Hardware 1997.
//! Cost: a triangle O(rows it touches) + O(samples it owns); a triangle without a sample only its bounds.
//! Exact up to the rounding of f64: edges within 10⁻⁹ pixel. A shared edge has the same bits on both sides, so each
//! sample belongs to exactly one of its faces (top-left fill rule). The same bits at every SIMD level: the compiler
//! only widens the code.

mod band;
mod clip;
mod corners;
mod half_plane;
mod sieve;
mod triangle;
mod triangles;

pub(crate) use band::{BAND, Band};
pub(crate) use clip::{Clipper, greater, smaller};
pub(crate) use corners::Corner;
pub(crate) use half_plane::HalfPlane;
pub(crate) use triangle::{Row, Triangle};

use crate::faces::{Cut, FaceSource, Faces};
use crate::simd::{apart, dispatch, level};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::passage::{BEYOND, Passage};
use corners::Corners;
use fearless_simd::Level;
use fearless_simd::prelude::*;
use glam::DVec3;
use sieve::Sieve;
use std::hint::black_box;
use triangles::Triangles;

/// Receives the rasterized samples of triangles.
pub(crate) trait Sink {
    /// Returns `true` if everything in `rect` no nearer than `nearest` is already hidden; `false` when unsure.
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool;

    /// Returns `true` to skip the rest of the current batch.
    #[inline(always)]
    fn is_done(&self) -> bool {
        false
    }

    /// Receives the triangles of a batch that may own a sample, before any of them is rasterized. Not called for a batch
    /// with corners that are not beyond the near plane, or far off screen.
    #[inline(always)]
    fn begin_batch(&mut self, _triangles: impl Iterator<Item = [Corner; 3]>) {}

    /// Returns `false` to skip a triangle, before it is bounded and set up. Not called for the same batches.
    #[inline(always)]
    fn wants(&mut self, _corners: &[Corner; 3]) -> bool {
        true
    }

    /// Returns `false` to skip the samples of triangles in the band of rows that starts at row `y`.
    #[inline(always)]
    fn wants_band(&self, _y: u16) -> bool {
        true
    }

    /// Announces the next triangle that passed the occlusion test; its corners as (X, Y, W).
    #[inline(always)]
    fn begin(&mut self, _triangle: &Triangle, _corners: &[DVec3; 3]) {}

    /// Receives the samples of the triangle in one band of rows.
    fn band(&mut self, band: &Band, triangle: &Triangle);
}

/// The rasterizer, with its buffers.
pub(crate) struct Raster {
    level: Level,
    buffers: Buffers,
}

/// Transformed vertices of the current batch and its triangles that may own a sample, and buffers for edge functions
/// and clipping.
#[derive(Default)]
struct Buffers {
    corners: Corners,
    /// Face number and indices of the three corners.
    triangles: Vec<(u32, [u32; 3])>,
    /// Whether all vertices are beyond the near plane and not far off screen.
    tame: bool,
    planes: Vec<HalfPlane>,
    clipper: Clipper,
}

impl Default for Raster {
    fn default() -> Raster {
        Raster::at(level())
    }
}

impl Raster {
    /// Creates a rasterizer for a SIMD level. The level changes the speed only; the results have the same bits.
    pub(crate) fn at(level: Level) -> Raster {
        Raster {
            level,
            buffers: Buffers::default(),
        }
    }

    /// Rasterizes a batch face by face into `sink`.
    pub(crate) fn run(&mut self, faces: &Faces, passage: &Passage, sink: &mut impl Sink, stats: &mut Stats) {
        stats.batches += 1;
        let batch = Batch::new(faces, passage);
        let buffers = &mut self.buffers;
        // Of these two, only the second is compiled for each sink.
        dispatch!(self.level, simd => apart!(simd, buffers.project(simd, faces, &batch, stats)));
        dispatch!(self.level, simd => batch.draw(simd, buffers, sink, stats));
    }

    /// Rasterizes one triangle of a batch, by its corners as (X, Y, W).
    pub(crate) fn run_one(
        &mut self,
        corners: [DVec3; 3],
        faces: &Faces,
        passage: &Passage,
        sink: &mut impl Sink,
    ) {
        let batch = Batch::new(faces, passage);
        let corners = corners.map(Corner::at);
        let Buffers { planes, clipper, .. } = &mut self.buffers;
        let stats = &mut Stats::default();
        dispatch!(self.level, simd => batch.draw_one(simd, 0, corners, planes, clipper, sink, stats));
    }
}

impl Buffers {
    /// Transforms the vertices of a batch, and stores the triangles that may own a sample.
    #[inline(always)]
    fn project<S: Simd>(&mut self, simd: S, faces: &Faces, batch: &Batch, stats: &mut Stats) {
        if !faces.is_lone() {
            fetch(faces);
        }
        let first = faces.first_position as usize;
        let position = |place: usize| faces.positions[place];
        let matrix = faces.screen_from_local;
        let extent = if faces.is_lone() {
            let used = |place: usize| position(faces.corners[place] as usize - first);
            self.corners
                .fill(simd, faces.corners.len(), used, matrix, batch.near);
            None
        } else {
            let count = faces.positions.len();
            self.corners.fill(simd, count, position, matrix, batch.near)
        };
        self.tame = extent.is_some();
        let sieve = extent.map(|extent| Sieve::new(&extent, &batch.rect, batch.front));
        let mut triangles = Triangles::of(faces);
        let mut group = [(0, [0; 3]); sieve::LANES];
        self.triangles.clear();
        loop {
            let count = triangles.next_into(&mut group);
            if count == 0 {
                return;
            }
            let Some(sieve) = &sieve else {
                self.triangles.extend_from_slice(&group[..count]);
                continue;
            };
            let mut at = [[[0.0; sieve::LANES]; 2]; 3];
            for (lane, (_, used)) in group[..count].iter().enumerate() {
                for corner in 0..3 {
                    [at[corner][0][lane], at[corner][1][lane]] = self.corners.rounded(used[corner]);
                }
            }
            let sifted = sieve.sift(simd, &at);
            let mut left = (1_u32 << count) - 1;
            stats.triangles += u64::from((sifted.between & left).count_ones());
            left &= sifted.left;
            while left != 0 {
                self.triangles.push(group[left.trailing_zeros() as usize]);
                left &= left - 1;
            }
        }
    }
}

/// Prefetches all memory of a batch, so that the cache misses overlap.
///
/// In a large scene each batch is at an unrelated address, and a loop that also computes keeps only a few cache lines
/// in flight.
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

/// Relative rounding error of a transformed corner, as a part of the terms that it is the sum of.
const ROUNDING: f64 = 1.0 / (1_u64 << 50) as f64;

/// A determinant above this part of the product of two edges and the distance to a corner is certainly nonzero.
const THIN: f64 = 1e-6;

/// Parameters shared by all triangles of a batch.
struct Batch<'a> {
    /// Bounding rectangle of the aperture.
    rect: Rect,
    /// Near-plane distance.
    near: f64,
    /// Entry plane behind the last portal, n · (X, Y, W) ≥ d.
    entry: Option<(DVec3, f64)>,
    /// Sign of the determinant of front faces; 0 for double-sided faces.
    front: f64,
    /// Planes that clip the face.
    cuts: &'a [Cut],
    /// Bound on the rounding error of a corner, in the space of (X, Y, W).
    rounding: f64,
}

/// A triangle that may own samples of a rectangle, before its edges are computed.
struct Candidate {
    corners: [DVec3; 3],
    /// Contains all samples of the triangle.
    rect: Rect,
    normal: DVec3,
    determinant: f64,
    crosses_near: bool,
    /// Bounds of the reversed depth.
    least: f64,
    greatest: f64,
}

impl<'a> Batch<'a> {
    fn new(faces: &Faces<'a>, passage: &Passage) -> Batch<'a> {
        let is_opening = matches!(faces.source, FaceSource::Opening(_));
        Batch {
            rect: passage.aperture.rect(),
            // Openings are not clipped by the near plane: an opening that contains the eye must stay visible.
            near: if is_opening {
                passage.near_of_openings()
            } else {
                f64::from(passage.z_near)
            },
            entry: passage.entry,
            front: faces.front(passage),
            // Only a lone face ever has cuts.
            cuts: if faces.is_lone() { faces.cuts } else { &[] },
            // Edge-on openings are rejected before they get here, and the square that replaces an opening containing
            // the eye is as close to the eye as rounding errors.
            rounding: if is_opening {
                0.0
            } else {
                passage.corner_rounding() + ROUNDING * faces.screen_from_local.linear.translation.length()
            },
        }
    }

    /// Rasterizes the projected triangles into `sink`.
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, buffers: &mut Buffers, sink: &mut impl Sink, stats: &mut Stats) {
        let Buffers {
            corners,
            triangles,
            tame,
            planes,
            clipper,
        } = buffers;
        if *tame {
            let triangles = triangles.iter();
            sink.begin_batch(triangles.map(
                #[inline(always)]
                |(_, used)| [corners.get(used[0]), corners.get(used[1]), corners.get(used[2])],
            ));
        }
        for &(owner, used) in &*triangles {
            if sink.is_done() {
                return;
            }
            let corners = used.map(|used| corners.get(used));
            if *tame && !sink.wants(&corners) {
                continue;
            }
            self.draw_one(simd, owner, corners, planes, clipper, sink, stats);
        }
    }

    /// Rasterizes a projected triangle into `sink`.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the buffers are borrowed one by one")]
    fn draw_one<S: Simd>(
        &self,
        simd: S,
        owner: u32,
        corners: [Corner; 3],
        planes: &mut Vec<HalfPlane>,
        clipper: &mut Clipper,
        sink: &mut impl Sink,
        stats: &mut Stats,
    ) {
        let Some(candidate) = self.candidate(corners, clipper) else {
            return;
        };
        stats.triangles += 1;
        if sink.hides(&candidate.rect, rounded_up(candidate.greatest)) {
            stats.triangles_hidden += 1;
            return;
        }
        let triangle = self.set_up(owner, &candidate, planes);
        sink.begin(&triangle, &candidate.corners);
        walk_rows(simd, &candidate.rect, planes, &triangle, sink, stats);
    }

    /// Returns `true` if the eye is in the plane of a triangle, within rounding: if its determinant, which is then
    /// zero, is no larger than what moving the corners by `rounding` can cause.
    #[cold]
    fn is_edge_on(&self, &[a, b, c]: &[DVec3; 3]) -> bool {
        let [ab, ac] = [b - a, c - a];
        let normal = ab.cross(ac);
        let moved = self.rounding + ROUNDING * a.length().max(b.length()).max(c.length());
        normal.dot(a).abs() <= moved * (normal.length() + 2.0 * a.length() * (ab.length() + ac.length()))
    }

    /// Bounds a triangle, clipped by the cuts, on the screen and in depth; `None` if it owns no sample.
    fn candidate(&self, corners: [Corner; 3], clipper: &mut Clipper) -> Option<Candidate> {
        let [a, b, c] = corners.map(|corner| corner.at);
        let crosses_near = a.z <= self.near || b.z <= self.near || c.z <= self.near;
        let [p, q, r] = corners.map(|corner| corner.rev_depth);
        let [mut least, mut greatest] = [smaller(p, smaller(q, r)), greater(p, greater(q, r))];
        if crosses_near {
            let farthest = greater(a.z, greater(b.z, c.z));
            if farthest <= self.near {
                return None;
            }
            least = 1.0 / farthest;
            greatest = if self.near > 0.0 {
                1.0 / self.near
            } else {
                f64::from(f32::MAX)
            };
        }
        let rect = if crosses_near || !self.cuts.is_empty() {
            clipper.rect(&[a, b, c], self.near, self.cuts, &self.rect)
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
            Rect::around(low, high, &self.rect)
        };
        if rect.is_empty() {
            return None;
        }
        let normal = (b - a).cross(c - a);
        let determinant = normal.dot(a);
        // Edge-on triangles own no sample; back faces are culled unless double-sided.
        let sides = (b - a).length_squared() * (c - a).length_squared();
        let is_thin = determinant * determinant <= THIN * THIN * sides * a.length_squared();
        if (is_thin && self.is_edge_on(&[a, b, c])) || self.front * determinant < 0.0 {
            return None;
        }
        Some(Candidate {
            corners: [a, b, c],
            rect,
            normal,
            determinant,
            crosses_near,
            least,
            greatest,
        })
    }

    /// Computes the depth plane of a triangle, and writes the half-planes that bound its samples to `planes`.
    fn set_up(&self, owner: u32, candidate: &Candidate, planes: &mut Vec<HalfPlane>) -> Triangle {
        let [a, b, c] = candidate.corners;
        let rev_depth = candidate.normal / candidate.determinant;
        let side = if candidate.determinant < 0.0 { -1.0 } else { 1.0 };
        planes.clear();
        planes.extend([(a, b), (b, c), (c, a)].map(|(from, to)| HalfPlane::edge(from, to, side)));
        if candidate.crosses_near && self.near > 0.0 {
            planes.push(HalfPlane::new(DVec3::new(0.0, 0.0, 1.0 / self.near) - rev_depth));
        }
        if let Some((entry, distance)) = self.entry {
            planes.push(HalfPlane::new(entry - rev_depth * (distance * BEYOND)));
        }
        let cut = |cut: &Cut| HalfPlane::new(cut.normal - rev_depth * cut.distance);
        planes.extend(self.cuts.iter().map(cut));
        Triangle {
            owner,
            rev_depth,
            least: candidate.least,
            greatest: candidate.greatest,
        }
    }
}

/// Passes the samples of `rect` inside all half-planes to `sink`, one band of rows at a time.
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
    while y < rect.y1 && !sink.is_done() {
        if sink.wants_band(y)
            && let Some((band, samples)) = apart!(simd, Band::of(simd, y, rect, planes))
        {
            stats.samples += samples;
            apart!(simd, sink.band(&band, triangle));
        }
        y += BAND as u16;
    }
}

/// Rounds up to a reversed depth nearer than any stored sample of the triangle, as a bound for occlusion queries.
#[inline(always)]
fn rounded_up(rev_depth: f64) -> f32 {
    (rev_depth * (1.0 + 1.0 / (1_u64 << 20) as f64)) as f32
}
