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
    ACROSS, BandTiles, COLUMNS, Grid, ROWS, RevDepth, SUB_COLUMNS, SUB_ROWS, SUB_TILES_OF_BAND, TilesView,
    columns_within, masks_of_rect, rows_within, tiles,
};
use crate::raster::{BAND, Band, HalfPlane, Triangle, greater, smaller};
use crate::view::aperture::Rect;
use crate::view::region::{ROUND_UP, Region, Volume};
use fearless_simd::prelude::*;
use glam::DVec3;

impl Grid {
    /// Returns `true` if geometry with reversed depth `nearest` may be visible at any sample of `rect`.
    #[inline(always)]
    pub(super) fn shows(&self, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&self.rect);
        !rect.is_empty()
            && (self.shows_middle_of(&rect, nearest) || self.view().first_seen(&rect, nearest).is_some())
    }

    /// Returns `true` if any sample may show the box, grown by `growth` pixels. Tests its rectangle first, then, if it is entirely behind the
    /// near plane, its outline.
    #[inline(always)]
    pub(super) fn sees<S: Simd>(&self, simd: S, region: &Region, near: f64, growth: f64) -> bool {
        let rect = region.rect.intersection(&self.rect);
        if rect.is_empty() {
            return false;
        }
        if self.shows_inside(&rect, &region.volume, near) {
            return true;
        }
        let Some(first) = self.view().first_seen(&rect, region.nearest) else {
            return false;
        };
        // No closures here and below: the code of a closure is not compiled for the SIMD level.
        match Outline::of(&region.volume, near, growth, &rect) {
            Some(outline) if self.shows_middle(&rect, &outline, &region.volume) => true,
            Some(outline) => self.sees_outline(simd, &rect, first, region.nearest, &outline),
            None => true,
        }
    }

    /// Returns `true` if any of a few points inside the box is in front of what is stored where it is on the screen. A
    /// cheap early out: from a third to three quarters of the visible boxes pass it.
    #[inline(always)]
    fn shows_inside(&self, rect: &Rect, volume: &Volume, near: f64) -> bool {
        /// In fewer columns or rows there may be no sample inside the box.
        const FEW: u16 = 4;
        if rect.x1 - rect.x0 < FEW || rect.y1 - rect.y0 < FEW {
            return false;
        }
        let [x, y, z] = volume.sides;
        let middle = volume.origin + 0.5 * (x + y + z);
        if self.shows_point(middle, rect, volume, near) {
            return true;
        }
        // Halfway between the middle and four corners, of which no two are adjacent.
        let [x, y, z] = [0.25 * x, 0.25 * y, 0.25 * z];
        for offset in [x + y + z, x - y - z, y - x - z, z - x - y] {
            if self.shows_point(middle + offset, rect, volume, near) {
                return true;
            }
        }
        false
    }

    /// Returns `true` if a point, in the space of the volume, is in front of what is stored where it is on the screen.
    #[inline(always)]
    fn shows_point(&self, at: DVec3, rect: &Rect, volume: &Volume, near: f64) -> bool {
        let [left, right] = [rect.x0, rect.x1].map(f64::from);
        let [top, bottom] = [rect.y0, rect.y1].map(f64::from);
        let DVec3 { x, y, z: rev_depth } = volume.on_screen(at);
        // Both signs matter: behind the eye, 1 / W is negative.
        (rev_depth > 0.0 && rev_depth * near < 1.0)
            && (left <= x && x < right && top <= y && y < bottom)
            && f64::from(self.rev_depth_at(x as usize, y as usize)) < rev_depth
    }

    /// Returns `true` if the sample at the centre of the box may show it, by outline and front faces. Most visible
    /// boxes that reach this test pass it.
    #[inline(always)]
    fn shows_middle(&self, rect: &Rect, outline: &Outline, volume: &Volume) -> bool {
        let Some([x, y]) = sample_at_middle(rect, volume) else {
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
        let mut y = from * ROWS;
        while y < usize::from(rect.y1) {
            if let Some((band, _)) = Band::inside(simd, y as u16, rect, outline.lines()) {
                let across = BandTiles::new(&band);
                for column in across.tiles() {
                    let index = y / ROWS * self.columns + column;
                    if nearest < self.farthest[index] {
                        continue;
                    }
                    let rev_depth = outline.over_tile([column * COLUMNS, y], rect, nearest);
                    let samples = across.samples(column);
                    if self.view().sees_in(index, y % ROWS / BAND, &samples, &rev_depth) {
                        return true;
                    }
                }
            }
            y += BAND;
        }
        false
    }
}

impl TilesView<'_> {
    /// Returns the first row of tiles in which a sample of `rect` may show geometry with reversed depth `nearest`.
    #[inline(always)]
    pub(super) fn first_seen(&self, rect: &Rect, nearest: f32) -> Option<usize> {
        let columns = tiles(rect.x0, rect.x1, COLUMNS);
        for row in tiles(rect.y0, rect.y1, ROWS) {
            let first = (row - self.first_row) * self.columns;
            let mut hidden = true;
            for &farthest in &self.farthest[first + columns.start..first + columns.end] {
                hidden &= nearest < farthest;
            }
            if !hidden && self.shows_in_row(row, rect, nearest) {
                return Some(row);
            }
        }
        None
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

/// Returns the sample of `rect` at the projected centre of the box; `None` if the centre is outside `rect`.
#[inline(always)]
fn sample_at_middle(rect: &Rect, volume: &Volume) -> Option<[usize; 2]> {
    let [x, y, z] = volume.sides;
    let middle = volume.origin + 0.5 * (x + y + z);
    let DVec3 { x, y, .. } = volume.on_screen(middle);
    let within = |low: u16, value: f64, high: u16| f64::from(low) <= value && value < f64::from(high);
    (within(rect.x0, x, rect.x1) && within(rect.y0, y, rect.y1)).then_some([x as usize, y as usize])
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
    /// Returns the outline of a box, up to `growth` pixels away along each axis; `None` if the box crosses the near plane or may contain the eye.
    #[inline(always)]
    fn of(volume: &Volume, near: f64, growth: f64, limits: &Rect) -> Option<Outline> {
        let [mut xs, mut ys] = [[0.0; 8], [0.0; 8]];
        let mut nearest = f64::INFINITY;
        let mut reach = 0.0;
        for (corner, (x, y)) in volume.corners().into_iter().zip(xs.iter_mut().zip(&mut ys)) {
            let per_w = 1.0 / corner.z;
            [*x, *y] = [corner.x * per_w, corner.y * per_w];
            nearest = smaller(corner.z, nearest);
            reach = greater(x.abs() + y.abs(), reach);
        }
        // Written so that NaN fails too.
        if !(nearest > near && reach < f64::INFINITY) {
            return None;
        }
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
                    outline.add_line(&xs, &ys, [from, from | 1 << axis], growth, reach);
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

    /// Adds a line in the direction between two corners, with all corners on its inner side.
    #[inline(always)]
    fn add_line(&mut self, xs: &[f64; 8], ys: &[f64; 8], [from, to]: [usize; 2], growth: f64, reach: f64) {
        let [a, b] = [ys[from] - ys[to], xs[to] - xs[from]];
        if self.line_count == self.lines.len() || (a == 0.0 && b == 0.0) {
            return;
        }
        let [mut least, mut greatest] = [f64::INFINITY, f64::NEG_INFINITY];
        for (x, y) in xs.iter().zip(ys) {
            let value = a * x + b * y;
            least = smaller(value, least);
            greatest = greater(value, greatest);
        }
        let own = a * xs[from] + b * ys[from];
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
    /// sub-tile of a band, in the tile at column and row `at`.
    #[inline(always)]
    fn over_tile(&self, at: [usize; 2], rect: &Rect, nearest: f32) -> RevDepth {
        let mut all = [0.0; SUB_TILES_OF_BAND];
        for (sub, most) in all.iter_mut().enumerate() {
            let [x0, y0] = [
                at[0] + sub % ACROSS * SUB_COLUMNS,
                at[1] + sub / ACROSS * SUB_ROWS,
            ];
            // Linear, so the maximum is at a corner.
            let columns = [
                greater(x0 as f64, f64::from(rect.x0)) + 0.5,
                smaller((x0 + SUB_COLUMNS) as f64, f64::from(rect.x1)) - 0.5,
            ];
            let rows = [
                greater(y0 as f64, f64::from(rect.y0)) + 0.5,
                smaller((y0 + SUB_ROWS) as f64, f64::from(rect.y1)) - 0.5,
            ];
            let mut rev_depth = f64::INFINITY;
            for front in &self.fronts[..self.front_count] {
                let column = if front.x > 0.0 { columns[1] } else { columns[0] };
                let row = if front.y > 0.0 { rows[1] } else { rows[0] };
                rev_depth = smaller(column * front.x + (row * front.y + front.z), rev_depth);
            }
            let rev_depth = (greater(rev_depth, 0.0) * ROUND_UP) as f32;
            *most = if rev_depth < nearest { rev_depth } else { nearest };
        }
        all
    }
}
