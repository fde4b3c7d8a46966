//! Rasterizes selected occluders into the tiles.
//!
//! Edge functions decide which samples an occluder covers, as for the faces of the exact covers: each sample on a
//! shared edge belongs to exactly one face. The depth stored in a sub-tile is the farthest of the occluder's plane
//! there.
//! Source: Hasselgren, Andersson, Akenine-Möller, Masked Software Occlusion Culling, HPG 2016, sections 3.1 and 3.3.
//! Cost: an occluder O(bands of eight rows · corners) + O(tiles it overlaps).
//! Conservative: reversed depth is rounded down, and the parts in front of the near plane or the entry plane are
//!     clipped.

use super::runs::{RowDepth, RunQueue};
use super::tiles::{
    ACROSS, BandTiles, COLUMNS, Grid, ROWS, RevDepth, SUB_COLUMNS, SUB_ROWS, SUB_TILES_OF_BAND,
};
use crate::occluders::Occluder;
use crate::raster::{BAND, Band, Clipper, HalfPlane, Triangle, greater, smaller};
use crate::simd::dispatch;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use crate::view::region::ROUND_UP;
use fearless_simd::Level;
use fearless_simd::prelude::*;
use glam::DVec3;

/// Rasterizer for occluders.
pub(super) struct Fill {
    level: Level,
    planes: Vec<HalfPlane>,
    clipper: Clipper,
    run_queue: RunQueue,
}

/// Factor by which an occluder's plane must be behind the near plane. The surface itself, which the near plane clips,
/// may be nearer than its plane by any smaller factor.
const BEYOND_NEAR: f64 = 4.0;

/// Factor by which it must be behind the entry plane, in addition to the margin from its corners; see [`Fill::set_up`].
const BEYOND_ENTRY: f64 = 1.0 + 1.0 / (1_u64 << 8) as f64;

/// Generous bound on the rounding error of sums of three products, relative to the largest.
const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;

/// Factor that lowers reversed depth before it is stored: covers rounding to f32 and the multiplication.
const ROUND_DOWN: f64 = 1.0 - 1.0 / (1_u64 << 23) as f64;

/// Values below this, times the columns of any screen, fit f32.
const LARGE: f64 = 1e30;

/// Plane of reversed depth of an occluder on the screen, clamped to a range.
pub(super) struct Slope {
    /// Reversed depth at the point (x, y) is `at · (x, y, 1)`, accurate to `rounding`.
    at: DVec3,
    /// Range that the reversed depth is clamped to.
    least: f64,
    greatest: f64,
    rounding: f64,
}

impl Fill {
    pub(super) fn at(level: Level) -> Fill {
        Fill {
            level,
            planes: Vec::new(),
            clipper: Clipper::default(),
            run_queue: RunQueue::default(),
        }
    }

    /// Rasterizes an occluder and returns the number of samples it covers: 0 if it is degenerate, not finite or
    /// edge-on.
    pub(super) fn hide(&mut self, grid: &mut Grid, occluder: &Occluder, passage: &Passage) -> u64 {
        dispatch!(self.level, simd => self.hide_at(simd, grid, occluder, passage))
    }

    #[inline(always)]
    fn hide_at<S: Simd>(&mut self, simd: S, grid: &mut Grid, occluder: &Occluder, passage: &Passage) -> u64 {
        let Some((rect, slope)) = self.set_up(occluder, passage, &grid.rect) else {
            return 0;
        };
        let tiles = &mut grid.all();
        let mut covered = 0;
        let mut y = rect.y0 - rect.y0 % BAND as u16;
        while y < rect.y1 {
            if let Some((band, samples)) = Band::inside(simd, y, &rect, &self.planes) {
                covered += samples;
                self.run_queue.push_band(simd, tiles, &band, &slope);
            }
            y += BAND as u16;
        }
        self.run_queue.cover(simd, tiles);
        covered
    }

    /// Returns a bounding rectangle and the depth plane of an occluder, and fills `planes` with its edge functions and
    /// clip planes.
    #[inline(always)]
    fn set_up(&mut self, occluder: &Occluder, passage: &Passage, limits: &Rect) -> Option<(Rect, Slope)> {
        let Occluder { corners, plane } = *occluder;
        let near = f64::from(passage.z_near);
        let (&first, others) = corners.split_first()?;
        let at = plane.0 / plane.1;
        if !(plane.1 > 0.0 && at.is_finite()) {
            return None;
        }
        let [mut nearest, mut farthest] = [f64::INFINITY, f64::NEG_INFINITY];
        let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let mut least = f64::INFINITY;
        let mut surface = f64::INFINITY;
        let mut normal = DVec3::ZERO;
        for (i, &corner) in corners.iter().enumerate() {
            if !corner.is_finite() {
                return None;
            }
            nearest = smaller(corner.z, nearest);
            farthest = greater(corner.z, farthest);
            let per_w = 1.0 / corner.z;
            for (axis, value) in [corner.x * per_w, corner.y * per_w].into_iter().enumerate() {
                low[axis] = smaller(value, low[axis]);
                high[axis] = greater(value, high[axis]);
            }
            // Beyond the eye plane (W ≤ 0), the reversed depth only grows.
            let here = at.dot(corner);
            surface = smaller(here, surface);
            if corner.z > 0.0 || here < 0.0 {
                least = smaller(if corner.z > 0.0 { here * per_w } else { 0.0 }, least);
            }
            if i > 1 {
                normal += (corners[i - 1] - first).cross(corner - first);
            }
        }
        if others.len() < 2 || farthest <= near {
            return None;
        }
        let crosses_near = nearest <= near * BEYOND_NEAR;
        let rect = if crosses_near {
            self.clipper.rect(corners, near, &[], limits)
        } else {
            Rect::around(low, high, limits)
        };
        // Winding from the corners and from the plane; they disagree if the occluder is edge-on.
        let determinant = normal.dot(first);
        let agrees = determinant * normal.dot(at) > 0.0;
        if rect.is_empty() || !agrees {
            return None;
        }
        let side = if determinant < 0.0 { -1.0 } else { 1.0 };
        self.planes.clear();
        let mut from = corners[corners.len() - 1];
        for &to in corners {
            if from != to {
                self.planes.push(HalfPlane::edge(from, to, side));
            }
            from = to;
        }
        if crosses_near {
            let at_near = DVec3::new(0.0, 0.0, 1.0 / (near * BEYOND_NEAR));
            self.planes.push(HalfPlane::new(at_near - at));
        }
        if let Some((entry, distance)) = passage.entry {
            // Corners are in front of the plane by the distance that it was pushed back, the surface by at most twice
            // that: with corners at 1 - s of the distance to the plane, (1 - s)⁻³ is more than 1 / (1 - 2s) as long as
            // s is below 1/3.
            let pushed = if surface > 0.0 {
                1.0 / surface
            } else {
                f64::INFINITY
            };
            let beyond = BEYOND_ENTRY * greater(pushed * pushed * pushed, 1.0);
            self.planes.push(HalfPlane::new(entry - at * (distance * beyond)));
        }
        if !self.planes.iter().all(HalfPlane::is_finite) {
            return None;
        }
        let least = least * (1.0 - ROUNDING);
        Some((rect, Slope::new(at, [least, f64::INFINITY], limits)))
    }
}

impl Grid {
    /// Covers the samples of a band with a surface of the given depth plane.
    #[inline(always)]
    pub(super) fn cover(&mut self, band: &Band, slope: &Slope) {
        let across = BandTiles::new(band);
        for column in across.tiles() {
            self.cover_in_tile(&across, [column, usize::from(band.y)], slope);
        }
    }

    /// Covers the samples of a band, starting at row `y`, in one column of tiles.
    #[inline(always)]
    fn cover_in_tile(&mut self, across: &BandTiles, [column, y]: [usize; 2], slope: &Slope) {
        let rev_depth = slope.over_band([column * COLUMNS, y]);
        let index = y / ROWS * self.columns + column;
        let mut any_nearer = false;
        for rev_depth in rev_depth {
            any_nearer |= rev_depth > self.farthest[index];
        }
        if !any_nearer {
            return;
        }
        let first = y % ROWS / BAND * SUB_TILES_OF_BAND;
        let covered = across.samples(column);
        for (sub, (covered, rev_depth)) in (first..).zip(covered.into_iter().zip(rev_depth)) {
            let closed = self.closed_in(index, sub);
            self.tiles[index].cover(sub, [covered, closed], rev_depth.to_bits());
        }
        self.farthest[index] = self.tiles[index].farthest();
    }
}

impl Slope {
    /// Returns the depth plane of a triangle, for columns and rows up to the end of `limits`.
    #[inline(always)]
    pub(super) fn of(triangle: &Triangle, limits: &Rect) -> Slope {
        Slope::new(triangle.rev_depth, [triangle.least, triangle.greatest], limits)
    }

    /// Creates the depth plane `at`, clamped to `least..=greatest`, for columns and rows up to the end of `limits`.
    #[inline(always)]
    fn new(at: DVec3, [least, greatest]: [f64; 2], limits: &Rect) -> Slope {
        let most = DVec3::new(f64::from(limits.x1), f64::from(limits.y1), 1.0);
        Slope {
            at,
            least,
            greatest,
            rounding: at.abs().dot(most) * ROUNDING,
        }
    }

    /// Returns lower bounds in the row of `count` tiles that begins at column and row `at`. If f32 could overflow or the
    /// plane is NaN, only the minimum is known.
    #[inline(always)]
    pub(super) fn over_row<S: Simd>(&self, simd: S, at: [usize; 2], count: usize) -> RowDepth<S> {
        /// Bound on the rounding of f32, as a part of the terms that are added.
        const ROUNDING: f64 = 1.0 / (1_u64 << 21) as f64;
        let least = smaller(self.least, f64::from(f32::MAX)) * ROUND_DOWN;
        let least = if least < f64::from(f32::MIN_POSITIVE) {
            0.0
        } else {
            least as f32
        };
        let DVec3 { x, y, .. } = self.at;
        let [first, ..] = self.at_corners(at, [x < 0.0, y < 0.0]);
        let rounding = (x.abs() * (count * COLUMNS) as f64 + y.abs() * ROWS as f64) * ROUNDING;
        let first = first - self.rounding - rounding;
        // Written so that NaN fails too.
        let is_small = first.abs() < LARGE && rounding < LARGE;
        let (first, [x, y]) = if is_small {
            (first, [x, y])
        } else {
            (0.0, [0.0; 2])
        };
        RowDepth::new(simd, first as f32, [x as f32, y as f32], least)
    }

    /// Returns an upper bound anywhere.
    pub(super) fn nearest(&self) -> f32 {
        smaller(self.greatest, f64::from(f32::MAX)) as f32 * ROUND_UP as f32
    }

    /// Returns the minimum reversed depth over each sub-tile of a band in the tile at column and row `at`, rounded
    /// down. If the plane is NaN, returns the lower end of the range, as [`Slope::most_over_band`] returns the upper
    /// one.
    #[inline(always)]
    fn over_band(&self, at: [usize; 2]) -> RevDepth {
        let all = self.at_corners(at, [self.at.x < 0.0, self.at.y < 0.0]);
        let mut rounded = [0.0; SUB_TILES_OF_BAND];
        for (least, rounded) in all.iter().zip(&mut rounded) {
            let rev_depth = smaller(greater(*least - self.rounding, self.least), self.greatest) * ROUND_DOWN;
            // Subnormal numbers round more coarsely, so store them as infinitely far.
            let rev_depth = smaller(rev_depth, f64::from(f32::MAX)) as f32;
            *rounded = if rev_depth < f32::MIN_POSITIVE {
                0.0
            } else {
                rev_depth
            };
        }
        rounded
    }

    /// Returns the maximum reversed depth over each sub-tile of a band in the tile at column and row `at`, rounded up.
    #[inline(always)]
    pub(super) fn most_over_band(&self, at: [usize; 2]) -> RevDepth {
        let all = self.at_corners(at, [self.at.x > 0.0, self.at.y > 0.0]);
        let mut rounded = [0.0; SUB_TILES_OF_BAND];
        for (most, rounded) in all.iter().zip(&mut rounded) {
            let rev_depth = greater(smaller(*most + self.rounding, self.greatest), self.least);
            *rounded = (rev_depth * ROUND_UP) as f32;
        }
        rounded
    }

    /// Returns the reversed depth at one corner sample of each sub-tile: in its first or last column and row. Depth is
    /// linear, so its extremes are at corners.
    #[inline(always)]
    fn at_corners(&self, at: [usize; 2], [last_column, last_row]: [bool; 2]) -> [f64; SUB_TILES_OF_BAND] {
        let DVec3 { x, y, z } = self.at;
        let last = [SUB_COLUMNS as f64 - 0.5, SUB_ROWS as f64 - 0.5];
        let column = at[0] as f64 + if last_column { last[0] } else { 0.5 };
        let row = at[1] as f64 + if last_row { last[1] } else { 0.5 };
        let mut all = [0.0; SUB_TILES_OF_BAND];
        for (sub, rev_depth) in all.iter_mut().enumerate() {
            let [across, down] = [sub % ACROSS * SUB_COLUMNS, sub / ACROSS * SUB_ROWS];
            *rev_depth = (column + across as f64) * x + ((row + down as f64) * y + z);
        }
        all
    }
}
