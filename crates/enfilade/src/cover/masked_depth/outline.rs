//! Outline of a box on the screen and the depth of its front faces: a tighter occlusion test than a rectangle and one
//! depth.
//!
//! The silhouette of a box has at most six edges: those between a face towards the eye and one that faces away. Only
//! their directions are taken from there; each line is moved out until all eight corners are inside. A ray enters the
//! box at the farthest of the planes of its front faces, because it has then crossed all of them.
//! Source: the directions as in Schmalstieg, Tobler, Real-time Bounding Box Area Computation, 1999.
//! Cost: O(1), about as much as setting up four triangles.
//! Conservative: lines are moved outwards, and planes towards the eye, by more than the rounding error.

use super::tile::{ACROSS, RevDepth, SUB_COLUMNS, SUB_ROWS, SUB_TILES_OF_BAND};
use crate::aperture::Rect;
use crate::raster::{HalfPlane, greater, smaller};
use crate::region::Volume;
use glam::DVec3;

/// Silhouette and front faces of a box.
pub(super) struct Outline {
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

/// Same as `ROUND_UP` in `region`.
const ROUND_UP: f64 = 1.0 + 1.0 / (1_u64 << 20) as f64;

impl Outline {
    /// Returns the outline of a box; `None` if the box crosses the near plane or may contain the eye.
    #[inline(always)]
    pub(super) fn of(volume: &Volume, near: f64, limits: &Rect) -> Option<Outline> {
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
        let facing = outline.add_fronts(volume, limits);
        if outline.front_count == 0 {
            return None;
        }
        for axis in 0..3 {
            let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
            for ends in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                if (facing[i] == Some(ends[0])) != (facing[j] == Some(ends[1])) {
                    let from = ends[0] << i | ends[1] << j;
                    outline.add_line(&xs, &ys, [from, from | 1 << axis], reach);
                }
            }
        }
        Some(outline)
    }

    /// Adds the planes of the faces towards the eye. Returns for each axis whether that is the face at the start (0) or
    /// at the end (1) of the box; `None` if neither.
    #[inline(always)]
    fn add_fronts(&mut self, volume: &Volume, limits: &Rect) -> [Option<usize>; 3] {
        let Volume { origin, sides } = *volume;
        let most = DVec3::new(f64::from(limits.x1), f64::from(limits.y1), 1.0);
        let mut facing = [None; 3];
        for axis in 0..3 {
            let [a, b] = [sides[(axis + 1) % 3], sides[(axis + 2) % 3]];
            let normal = a.cross(b);
            // Bound on the terms of the normal before their subtraction.
            let [a, b] = [a.abs(), b.abs()];
            let size = DVec3::new(
                a.y * b.z + a.z * b.y,
                a.z * b.x + a.x * b.z,
                a.x * b.y + a.y * b.x,
            );
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
            let lifted = DVec3::new(normal.x, normal.y, normal.z + size.dot(most) * ROUNDING);
            self.fronts[self.front_count] = lifted / (distance - error);
            self.front_count += 1;
        }
        facing
    }

    /// Adds a line in the direction between two corners, with all corners on its inner side.
    #[inline(always)]
    fn add_line(&mut self, xs: &[f64; 8], ys: &[f64; 8], [from, to]: [usize; 2], reach: f64) {
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
        let slack = (a.abs() + b.abs()) * (SLACK + reach * ROUNDING);
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
    pub(super) fn lines(&self) -> &[HalfPlane] {
        &self.lines[..self.line_count]
    }

    /// Returns an upper bound of the box's reversed depth at a point of the screen; negative outside the silhouette.
    #[inline(always)]
    pub(super) fn rev_depth_at(&self, [x, y]: [f64; 2]) -> f64 {
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
    pub(super) fn over_tile(&self, at: [usize; 2], rect: &Rect, nearest: f32) -> RevDepth {
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
