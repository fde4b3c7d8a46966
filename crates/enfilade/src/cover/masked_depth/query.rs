//! Occlusion queries: tests rectangles and boxes against the tiles, boxes also by their outline and front faces.
//!
//! The outline is a tighter test than a rectangle and one depth. The silhouette of a box has at most six edges: those
//! between a face towards the eye and one that faces away. Only their directions are taken from there; each line is
//! moved out until all eight corners are inside. A ray enters the box at the farthest of the planes of its front faces,
//! because it has then crossed all of them.
//! Source: the directions as in Schmalstieg, Tobler, Real-time Bounding Box Area Computation, 1999.
//! Cost: O(tiles of the rectangle), less if the box is clearly visible; an outline costs as much as setting up four
//!     triangles.
//! Conservative: lines are moved outwards, and planes towards the eye, by more than the rounding error.

use super::occluder::Slope;
use super::tiles::{
    BandTiles, COLUMNS, Grid, ROWS, RevDepth, SUB_COLUMNS, SUB_ROWS, SUB_TILE_PLACES, SUB_TILES_OF_BAND,
    TilesView, columns_within, masks_of_rect, rows_within, tiles,
};
use crate::raster::{BAND, Band, HalfPlane, Triangle, greater, smaller};
use crate::view::aperture::Rect;
use crate::view::region::{ROUND_UP, Region, Volume, greatest_of, least_of};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8};
use glam::DVec3;

impl Grid {
    /// Returns `true` if geometry with reversed depth `nearest` may be visible at any sample of `rect`.
    #[inline(always)]
    pub(super) fn shows(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        !rect.is_empty()
            && (self.shows_middle_of(&rect, nearest) || self.view().first_seen(&rect, nearest).is_some())
    }

    /// Returns `true` if any sample may show the box, grown by `growth` pixels. Tests points inside it, then its
    /// rectangle, then its outline; only its rectangle if it crosses the near plane.
    #[inline(always)]
    pub(super) fn sees<S: Simd>(&self, simd: S, region: &Region, near: f64, growth: f64) -> bool {
        let rect = region.rect.intersection(&self.rect);
        if rect.is_empty() {
            return false;
        }
        let Some(corners) = region.volume.corners_on_screen(simd, near) else {
            return self.view().first_seen(&rect, region.nearest).is_some();
        };
        let [x, y, z] = region.volume.sides;
        let middle = region.volume.on_screen(region.volume.origin + 0.5 * (x + y + z));
        if self.shows_inside(simd, &rect, middle, &corners) {
            return true;
        }
        let Some(first) = self.view().first_seen(&rect, region.nearest) else {
            return false;
        };
        // No closures here and below: the code of a closure is not compiled for the SIMD level.
        match Outline::of(simd, &region.volume, &corners, growth, &rect) {
            Some(outline) if self.shows_middle(&rect, middle, &outline) => true,
            Some(outline) => self.sees_outline(simd, &rect, first, region.nearest, &outline),
            None => true,
        }
    }

    /// Returns `true` if any of nine points inside the box is in front of what is stored where it is on the screen: the
    /// middle, and one near each corner. A cheap early out: most visible boxes pass it.
    #[inline(always)]
    fn shows_inside<S: Simd>(&self, simd: S, rect: &Rect, middle: DVec3, corners: &[f64x8<S>; 3]) -> bool {
        /// In fewer columns or rows there may be no sample inside the box.
        const FEW: u16 = 4;
        let extent = (rect.x1 - rect.x0).min(rect.y1 - rect.y0);
        if extent < FEW {
            return false;
        }
        if self.shows_point(middle, rect) {
            return true;
        }
        // About two samples from each corner towards the middle. What is between them is inside the box, also on the
        // screen.
        let inwards = greater(2.0 / f64::from(extent), 1.0 / 16.0);
        let mut points = [[0.0; 8]; 3];
        for ((point, corner), middle) in points.iter_mut().zip(corners).zip(middle.to_array()) {
            (*corner + (f64x8::splat(simd, middle) - *corner) * inwards).store_slice(point);
        }
        let [x, y, rev_depth] = &points;
        for ((&x, &y), &rev_depth) in x.iter().zip(y).zip(rev_depth) {
            if self.shows_point(DVec3::new(x, y, rev_depth), rect) {
                return true;
            }
        }
        false
    }

    /// Returns `true` if a point (column, row, reversed depth) in `rect` is in front of what is stored there.
    #[inline(always)]
    fn shows_point(&self, at: DVec3, rect: &Rect) -> bool {
        match sample_in(rect, at) {
            Some([x, y]) => f64::from(self.rev_depth_at(x, y)) < at.z,
            None => false,
        }
    }

    /// Returns `true` if the sample at the projected centre of the box may show it, by outline and front faces. Most
    /// visible boxes that reach this test pass it.
    #[inline(always)]
    fn shows_middle(&self, rect: &Rect, middle: DVec3, outline: &Outline) -> bool {
        let Some([x, y]) = sample_in(rect, middle) else {
            return false;
        };
        outline.rev_depth_at([x as f64 + 0.5, y as f64 + 0.5]) >= f64::from(self.rev_depth_at(x, y))
    }

    /// Returns `true` if nothing with reversed depth up to `nearest` can be visible at any sample of `rect`.
    pub(super) fn hides(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        rect.is_empty() || self.view().first_seen(&rect, nearest).is_none()
    }

    /// Returns `true` if a face with the depth plane of `triangle` may be visible at any sample of a band.
    pub(super) fn sees_plane(&self, band: &Band, triangle: &Triangle) -> bool {
        let slope = Slope::of(triangle, &self.rect);
        let across = BandTiles::new(band);
        let y = usize::from(band.y);
        across.tiles().any(|column| {
            let most = slope.most_over_band([column * COLUMNS, y]);
            let index = y / ROWS * self.columns + column;
            self.view()
                .sees_in(index, y % ROWS / BAND, &across.samples(column), &most)
        })
    }

    /// Returns `true` if the centre sample of `rect` may show geometry with reversed depth `nearest`. An early out:
    /// most visible rectangles pass it.
    #[inline(always)]
    fn shows_middle_of(&self, rect: &Rect, nearest: f32) -> bool {
        let [x, y] = [
            usize::from(rect.x0.midpoint(rect.x1)),
            usize::from(rect.y0.midpoint(rect.y1)),
        ];
        let index = y / ROWS * self.columns + x / COLUMNS;
        nearest >= self.farthest[index] && nearest >= self.rev_depth_at(x, y)
    }

    /// Returns `true` if any sample of `rect`, from row `from` of tiles on, may show the box, by its outline and its
    /// front faces.
    #[inline(always)]
    fn sees_outline<S: Simd>(
        &self,
        simd: S,
        rect: &Rect,
        from: usize,
        nearest: f32,
        outline: &Outline,
    ) -> bool {
        for row in from..usize::from(rect.y1).div_ceil(ROWS) {
            if self.view().hides_row(row, rect, nearest) {
                continue;
            }
            for y in [row * ROWS, row * ROWS + BAND] {
                if y >= usize::from(rect.y1) {
                    break;
                }
                let Some((band, _)) = Band::inside(simd, y as u16, rect, outline.lines()) else {
                    continue;
                };
                let across = BandTiles::new(&band);
                for column in across.tiles() {
                    let index = row * self.columns + column;
                    if nearest < self.farthest[index] {
                        continue;
                    }
                    let rev_depth = outline.over_tile(simd, [column * COLUMNS, y], rect, nearest);
                    let samples = across.samples(column);
                    if self.view().sees_in(index, y % ROWS / BAND, &samples, &rev_depth) {
                        return true;
                    }
                }
            }
        }
        false
    }
}

impl TilesView<'_> {
    /// Returns the first row of tiles in which a sample of `rect` may show geometry with reversed depth `nearest`.
    #[inline(always)]
    pub(super) fn first_seen(&self, rect: &Rect, nearest: f32) -> Option<usize> {
        for row in tiles(rect.y0, rect.y1, ROWS) {
            if self.hides_row(row, rect, nearest) {
                continue;
            }
            if self.shows_in_row(row, rect, nearest) {
                return Some(row);
            }
        }
        None
    }

    /// Returns `true` if all tiles that `rect` overlaps in a row hide geometry with reversed depth `nearest`.
    #[inline(always)]
    fn hides_row(&self, row: usize, rect: &Rect, nearest: f32) -> bool {
        let columns = tiles(rect.x0, rect.x1, COLUMNS);
        let first = (row - self.first_row) * self.columns;
        let mut hidden = true;
        for &farthest in &self.farthest[first + columns.start..first + columns.end] {
            hidden &= nearest < farthest;
        }
        hidden
    }

    /// Returns `true` if a sample of `rect` in one row of tiles may show geometry with reversed depth `nearest`.
    #[inline(always)]
    fn shows_in_row(self, row: usize, rect: &Rect, nearest: f32) -> bool {
        let rev_depth = [nearest; SUB_TILES_OF_BAND];
        for column in tiles(rect.x0, rect.x1, COLUMNS) {
            let index = (row - self.first_row) * self.columns + column;
            if nearest < self.farthest[index] {
                continue;
            }
            let columns = columns_within(rect.x0, rect.x1, column * COLUMNS);
            for band in 0..ROWS / BAND {
                let rows = rows_within(rect.y0, rect.y1, row * ROWS + band * BAND);
                if self.sees_in(index, band, &masks_of_rect(columns, rows), &rev_depth) {
                    return true;
                }
            }
        }
        false
    }
}

/// Returns the sample at a point (column, row, reversed depth); `None` if it is outside `rect`.
#[inline(always)]
fn sample_in(rect: &Rect, at: DVec3) -> Option<[usize; 2]> {
    let [left, right] = [f64::from(rect.x0), f64::from(rect.x1)];
    let [top, bottom] = [f64::from(rect.y0), f64::from(rect.y1)];
    let is_in = left <= at.x && at.x < right && top <= at.y && at.y < bottom;
    if is_in {
        Some([at.x as usize, at.y as usize])
    } else {
        None
    }
}

/// Returns the normal of the faces of a box across an axis, not normalized, and a bound on its terms before their
/// subtraction.
#[inline(always)]
fn normal_of(sides: &[DVec3; 3], axis: usize) -> (DVec3, DVec3) {
    let [a, b] = [sides[(axis + 1) % 3], sides[(axis + 2) % 3]];
    let normal = a.cross(b);
    let [a, b] = [a.abs(), b.abs()];
    let size = DVec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    );
    (normal, size)
}

/// Silhouette and front faces of a box.
struct Outline {
    lines: [HalfPlane; 6],
    line_count: usize,
    /// Planes of the front faces: reversed depth is at most `front · (x, y, 1)` for each.
    fronts: [DVec3; 3],
    front_count: usize,
}

/// Distance by which lines are moved outwards, in pixels.
const SLACK: f64 = 1.0 / 1024.0;

/// Generous bound on the rounding error of sums of three products, relative to the largest.
const ROUNDING: f64 = 1.0 / (1_u64 << 46) as f64;

impl Outline {
    /// Returns the outline of a box with `corners` (column, row and reversed depth of each), up to `growth` pixels away
    /// along each axis; `None` if it may contain the eye.
    #[inline(always)]
    fn of<S: Simd>(
        simd: S,
        volume: &Volume,
        corners: &[f64x8<S>; 3],
        growth: f64,
        limits: &Rect,
    ) -> Option<Outline> {
        let [x, y, _] = *corners;
        let away = x.abs() + y.abs();
        // Written so that NaN fails too.
        if !away.simd_lt(f64x8::splat(simd, f64::INFINITY)).all_true() {
            return None;
        }
        let reach = greatest_of(away);
        let mut outline = Outline {
            lines: [HalfPlane::NONE; 6],
            line_count: 0,
            fronts: [DVec3::ZERO; 3],
            front_count: 0,
        };
        let facing = outline.add_fronts(volume, growth, limits);
        if outline.front_count == 0 {
            return None;
        }
        for axis in 0..3 {
            let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
            for ends in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                if (facing[i] == Some(ends[0])) != (facing[j] == Some(ends[1])) {
                    let from = ends[0] << i | ends[1] << j;
                    outline.add_line([x, y], [from, from | 1 << axis], growth, reach);
                }
            }
        }
        Some(outline)
    }

    /// Adds the planes of the faces towards the eye. Returns for each axis whether that is the face at the start (0) or
    /// at the end (1) of the box; `None` if neither.
    #[inline(always)]
    fn add_fronts(&mut self, volume: &Volume, growth: f64, limits: &Rect) -> [Option<usize>; 3] {
        if volume.is_parallel {
            return self.add_parallel_fronts(volume, growth, limits);
        }
        let Volume { origin, sides, .. } = *volume;
        let most = DVec3::new(f64::from(limits.x1), f64::from(limits.y1), 1.0);
        let mut facing = [None; 3];
        for axis in 0..3 {
            let (normal, size) = normal_of(&sides, axis);
            let [start, across] = [normal.dot(origin), normal.dot(sides[axis])];
            let error = size.dot(origin.abs() + sides[axis].abs()) * ROUNDING;
            let [low, high] = [start + smaller(across, 0.0), start + greater(across, 0.0)];
            let (normal, distance) = if low > 0.0 {
                (normal, low)
            } else {
                (-normal, -high)
            };
            // `false` if both are zero: such a face has no area.
            let faces_the_eye = distance > 2.0 * error;
            if !faces_the_eye {
                continue;
            }
            facing[axis] = Some(usize::from((low > 0.0) == (across < 0.0)));
            let grown = (normal.x.abs() + normal.y.abs()) * growth;
            let lifted = DVec3::new(normal.x, normal.y, normal.z + size.dot(most) * ROUNDING + grown);
            self.fronts[self.front_count] = lifted / (distance - error);
            self.front_count += 1;
        }
        facing
    }

    /// As [`Outline::add_fronts`] in a parallel view: a face n · (x, y, r) = d towards the viewer has n.z above 0, and
    /// reversed depth r = (d − n.x x − n.y y) / n.z.
    fn add_parallel_fronts(&mut self, volume: &Volume, growth: f64, limits: &Rect) -> [Option<usize>; 3] {
        let Volume { origin, sides, .. } = *volume;
        let reach = DVec3::new(f64::from(limits.x1), f64::from(limits.y1), 1.0);
        let mut facing = [None; 3];
        for axis in 0..3 {
            let (normal, size) = normal_of(&sides, axis);
            if normal.z.abs() <= size.z * (2.0 * ROUNDING) {
                continue;
            }
            let normal = normal * normal.z.signum();
            let across = normal.dot(sides[axis]);
            let distance = normal.dot(origin) + greater(across, 0.0);
            let most = origin.abs() + sides[axis].abs() + reach;
            let error = size.dot(most) * ROUNDING + (normal.x.abs() + normal.y.abs()) * growth;
            facing[axis] = Some(usize::from(across > 0.0));
            self.fronts[self.front_count] =
                DVec3::new(-normal.x, -normal.y, distance + error) / (normal.z - size.z * ROUNDING);
            self.front_count += 1;
        }
        facing
    }

    /// Adds a line in the direction between two of the corners `[x, y]`, with all corners on its inner side.
    #[inline(always)]
    fn add_line<S: Simd>(&mut self, [x, y]: [f64x8<S>; 2], [from, to]: [usize; 2], growth: f64, reach: f64) {
        let [a, b] = [y[from] - y[to], x[to] - x[from]];
        if self.line_count == self.lines.len() || (a == 0.0 && b == 0.0) {
            return;
        }
        let values = x * a + y * b;
        let [least, greatest] = [least_of(values), greatest_of(values)];
        let own = x[from] * a + y[from] * b;
        let slack = (a.abs() + b.abs()) * (SLACK + growth + reach * ROUNDING);
        let line = if greatest - own >= own - least {
            HalfPlane::new(DVec3::new(a, b, slack - least))
        } else {
            HalfPlane::new(DVec3::new(-a, -b, slack + greatest))
        };
        if line.is_finite() {
            self.lines[self.line_count] = line;
            self.line_count += 1;
        }
    }

    /// Returns the half-planes of the silhouette.
    #[inline(always)]
    fn lines(&self) -> &[HalfPlane] {
        &self.lines[..self.line_count]
    }

    /// Returns an upper bound of the box's reversed depth at a point of the screen; negative outside the silhouette.
    #[inline(always)]
    fn rev_depth_at(&self, [x, y]: [f64; 2]) -> f64 {
        let mut rev_depth = f64::INFINITY;
        for front in &self.fronts[..self.front_count] {
            rev_depth = smaller(x * front.x + (y * front.y + front.z), rev_depth);
        }
        for line in self.lines() {
            rev_depth = if line.holds(x, y) {
                rev_depth
            } else {
                f64::NEG_INFINITY
            };
        }
        rev_depth
    }

    /// Returns an upper bound, clamped to `nearest`, of the box's reversed depth at the samples of `rect` in each
    /// sub-tile of a band, in the tile that begins at column and row `at`.
    #[inline(always)]
    fn over_tile<S: Simd>(&self, simd: S, at: [usize; 2], rect: &Rect, nearest: f32) -> RevDepth {
        let [columns, rows] = &SUB_TILE_PLACES;
        // Those of the upper band; the lower one has the same, counted from its own first row.
        let (columns, _) = f32x16::from_slice(simd, columns).widen();
        let (rows, _) = f32x16::from_slice(simd, rows).widen();
        let [x0, y0] = [columns + at[0] as f64, rows + at[1] as f64];
        // Linear, so the maximum is at a corner.
        let [left, right] = [
            f64x8::splat(simd, f64::from(rect.x0)),
            f64x8::splat(simd, f64::from(rect.x1)),
        ];
        let [top, bottom] = [
            f64x8::splat(simd, f64::from(rect.y0)),
            f64x8::splat(simd, f64::from(rect.y1)),
        ];
        let columns = [x0.max(left) + 0.5, (x0 + SUB_COLUMNS as f64).min(right) - 0.5];
        let rows = [y0.max(top) + 0.5, (y0 + SUB_ROWS as f64).min(bottom) - 0.5];
        let mut rev_depth = f64x8::splat(simd, f64::INFINITY);
        for front in &self.fronts[..self.front_count] {
            let column = if front.x > 0.0 { columns[1] } else { columns[0] };
            let row = if front.y > 0.0 { rows[1] } else { rows[0] };
            let at_face = column * front.x + (row * front.y + front.z);
            rev_depth = at_face.simd_lt(rev_depth).select(at_face, rev_depth);
        }
        let zero = f64x8::splat(simd, 0.0);
        let rev_depth = rev_depth.simd_gt(zero).select(rev_depth, zero) * ROUND_UP;
        let mut all = [0.0; SUB_TILES_OF_BAND];
        for (sub, most) in all.iter_mut().enumerate() {
            let rev_depth = rev_depth[sub] as f32;
            *most = if rev_depth < nearest { rev_depth } else { nearest };
        }
        all
    }
}
