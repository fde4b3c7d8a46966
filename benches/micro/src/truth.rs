//! The reference of this benchmark: depth of the nearest face at each sample, in f64, by code that shares nothing with
//! the engine.
//!
//! Tests each face with five rays per sample, at its centre and at (±δ, ±δ) around it, in homogeneous coordinates, so
//! faces that cross the near plane or reach behind the eye need no clipping. A depth buffer may be as near as the
//! nearest hit of the five, not nearer.
//! Source: Olano, Greer, Triangle Scan Conversion Using 2D Homogeneous Coordinates, Graphics Hardware 1997.
//! Cost: a face O(rows it touches) + O(samples it covers), five times.

use super::lens::{Lens, cross, dot};
use enfilade::Rect;

/// Offset of the other four rays from the centre of a sample, in pixels.
const DELTA: f64 = 1.0 / 1024.0;
const RAYS: [[f64; 2]; 5] = [
    [0.0, 0.0],
    [-DELTA, -DELTA],
    [DELTA, -DELTA],
    [-DELTA, DELTA],
    [DELTA, DELTA],
];
/// Relative tolerance: how much nearer than the truth a buffer may be, and a face than the near plane.
const SLACK: f64 = 1.0 / (1 << 16) as f64;

/// The true depths of all samples of a screen.
pub(super) struct Truth {
    lens: Lens,
    /// Maximum reversed depth (1 / W) of the hits of a sample's rays; 0 without a hit.
    nearest: Vec<f32>,
    /// A bit for each ray of a sample that hits a face.
    hit: Vec<u8>,
}

/// Number of differences of a buffer, or of its test results, from the truth.
#[derive(Clone, Copy, Default)]
pub(super) struct ErrorCounts {
    /// Samples or boxes with which something visible may be culled.
    pub(super) wrong: u64,
    /// Samples or boxes that are certainly occluded but not found to be; costs time only.
    pub(super) loose: u64,
    /// Samples that the buffer covers.
    pub(super) covered: u64,
}

impl ErrorCounts {
    pub(super) fn add(&mut self, more: ErrorCounts) {
        self.wrong += more.wrong;
        self.loose += more.loose;
        self.covered += more.covered;
    }
}

impl Truth {
    /// Creates the truth of an empty screen.
    pub(super) fn new(lens: Lens) -> Truth {
        let samples = lens.size[0] as usize * lens.size[1] as usize;
        Truth {
            lens,
            nearest: vec![0.0; samples],
            hit: vec![0; samples],
        }
    }

    /// Adds a planar convex single-sided face, counter-clockwise from its front.
    pub(super) fn add(&mut self, corners: &[[f32; 3]]) {
        let mut at = corners.iter().map(|&corner| self.lens.corner(corner));
        let (Some(first), Some(mut before)) = (at.next(), at.next()) else {
            return;
        };
        let triangles: Vec<Triangle> = at
            .filter_map(|corner| {
                let second = std::mem::replace(&mut before, corner);
                Triangle::new([first, second, corner], &self.lens)
            })
            .collect();
        let Some(rows) = triangles
            .iter()
            .map(|t| t.rows)
            .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        else {
            return;
        };
        for y in rows[0]..rows[1] {
            for triangle in &triangles {
                self.add_row(triangle, y);
            }
        }
    }

    /// Adds one row of a triangle.
    fn add_row(&mut self, triangle: &Triangle, y: usize) {
        let width = self.lens.size[0] as usize;
        for (number, [dx, dy]) in RAYS.into_iter().enumerate().rev() {
            let [from, to] = triangle.columns(y as f64 + 0.5 + dy, dx, width);
            if from >= to {
                continue;
            }
            let [a, b, c] = triangle.rev_depth;
            let start = a * (0.5 + dx) + b * (y as f64 + 0.5 + dy) + c;
            let row = y * width;
            let samples = self.nearest[row + from..row + to].iter_mut();
            for (x, (nearest, hit)) in (from..).zip(samples.zip(&mut self.hit[row + from..row + to])) {
                let rev_depth = (a * x as f64 + start) as f32;
                *nearest = if rev_depth > *nearest { rev_depth } else { *nearest };
                *hit |= 1 << number;
            }
        }
    }

    /// Compares a buffer's reversed depth at each sample, row by row, with the truth.
    pub(super) fn check(&self, depth: &[f32]) -> ErrorCounts {
        let mut errors = ErrorCounts::default();
        for ((&nearest, &hit), &known) in self.nearest.iter().zip(&self.hit).zip(depth) {
            // The comparison is negated below so that NaN counts as wrong.
            let right = f64::from(known) <= f64::from(nearest) * (1.0 + SLACK);
            errors.wrong += u64::from(!right);
            errors.loose += u64::from(known <= 0.0 && hit == ALL_HIT);
            errors.covered += u64::from(known > 0.0);
        }
        errors
    }

    /// Compares a test result with the truth: whether a box with this rectangle and maximum reversed depth `nearest` is
    /// `hidden`.
    pub(super) fn check_rect(&self, rect: &Rect, nearest: f32, hidden: bool) -> ErrorCounts {
        let width = self.lens.size[0] as usize;
        let Rect { x0, y0, x1, y1 } = *rect;
        let nearest = f64::from(nearest);
        let (mut may_show, mut surely_hidden) = (false, true);
        for y in usize::from(y0)..usize::from(y1) {
            for index in y * width + usize::from(x0)..y * width + usize::from(x1) {
                let truth = f64::from(self.nearest[index]);
                may_show |= nearest >= truth * (1.0 + SLACK);
                surely_hidden &= self.hit[index] == ALL_HIT && nearest * (1.0 + SLACK) < truth;
            }
        }
        ErrorCounts {
            wrong: u64::from(hidden && may_show),
            loose: u64::from(!hidden && surely_hidden),
            covered: 0,
        }
    }
}

const ALL_HIT: u8 = (1 << RAYS.len()) - 1;

/// A front-facing triangle, as edge functions on the screen.
struct Triangle {
    /// Edge functions: (x, y) is inside if a·x + b·y + c ≥ 0 for all. The last is the near plane, or always positive.
    edges: [[f64; 3]; 4],
    /// Coefficients of 1 / W at (x, y), likewise.
    rev_depth: [f64; 3],
    /// Range of rows that may contain any of it.
    rows: [usize; 2],
}

impl Triangle {
    /// Returns `None` if it is back-facing, edge-on, not finite or in no row of the screen.
    fn new(corners: [[f64; 3]; 3], lens: &Lens) -> Option<Triangle> {
        let [p, q, r] = corners;
        let determinant = dot(p, cross(q, r));
        if !(determinant < 0.0 && determinant.is_finite()) {
            return None;
        }
        let [a, b, c] =
            [cross(q, r), cross(r, p), cross(p, q)].map(|line| line.map(|value| value / determinant));
        let rev_depth = [0, 1, 2].map(|i| a[i] + b[i] + c[i]);
        let near = lens.near * (1.0 - SLACK);
        let crosses = corners.iter().any(|corner| corner[2] < near);
        let beyond_near = match crosses {
            true => [-rev_depth[0], -rev_depth[1], 1.0 / near - rev_depth[2]],
            false => [0.0, 0.0, 1.0],
        };
        let [top, bottom] = heights(&corners, near)?;
        let row = |y: f64| y.clamp(0.0, f64::from(lens.size[1])) as usize;
        let rows = [row((top - 1.0).floor()), row((bottom + 1.0).ceil())];
        (rows[0] < rows[1]).then_some(Triangle {
            edges: [a, b, c, beyond_near],
            rev_depth,
            rows,
        })
    }

    /// Returns the range of columns in a row whose samples, shifted by `dx`, are inside.
    fn columns(&self, y: f64, dx: f64, width: usize) -> [usize; 2] {
        let [mut low, mut high] = [0.0, width as f64];
        for [a, b, c] in self.edges {
            let rest = b * y + c;
            if a > 0.0 {
                low = f64::max(low, (-rest / a - 0.5 - dx).ceil());
            } else if a < 0.0 {
                high = f64::min(high, (-rest / a - 0.5 - dx).floor() + 1.0);
            } else if rest < 0.0 {
                return [0, 0];
            }
        }
        if low < high {
            [low as usize, high as usize]
        } else {
            [0, 0]
        }
    }
}

/// Returns the minimum and maximum Y / W of the part beyond the near plane; `None` if there is none.
fn heights(corners: &[[f64; 3]; 3], near: f64) -> Option<[f64; 2]> {
    let mut between: Option<[f64; 2]> = None;
    let mut meet = |height: f64| {
        let [low, high] = between.unwrap_or([height; 2]);
        between = Some([low.min(height), high.max(height)]);
    };
    for (corner, next) in [(0, 1), (1, 2), (2, 0)] {
        let [[_, y, w], [_, next_y, next_w]] = [corners[corner], corners[next]];
        if w >= near {
            meet(y / w);
        }
        if (w >= near) != (next_w >= near) {
            let part = (near - w) / (next_w - w);
            meet((y + (next_y - y) * part) / near);
        }
    }
    between
}

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade::View;

    /// Compares a buffer with the truth, given its reversed depth at column x and row y.
    fn check(truth: &Truth, rev_depth_at: impl Fn(usize, usize) -> f32) -> ErrorCounts {
        let depth: Vec<f32> = (0..32 * 16)
            .map(|place| rev_depth_at(place % 32, place / 32))
            .collect();
        truth.check(&depth)
    }

    fn empty() -> Truth {
        Truth::new(Lens::new(
            &View::new([0.0; 3], [0.0, 0.0, -1.0], [32, 16]).expect("a valid view"),
        ))
    }

    /// Returns a face from its corners: pixel and distance of each.
    fn face(truth: &Truth, corners: &[([f64; 2], f64)]) -> Vec<[f32; 3]> {
        corners
            .iter()
            .map(|&(pixel, w)| truth.lens.point(pixel, w))
            .collect()
    }

    #[test]
    fn a_square_covers_its_samples_and_is_as_near_as_it_is() {
        let mut truth = empty();
        let square = face(
            &truth,
            &[
                ([4.1, 12.2], 2.0),
                ([12.1, 12.2], 2.0),
                ([12.1, 2.2], 2.0),
                ([4.1, 2.2], 2.0),
            ],
        );
        truth.add(&square);
        let inside = |x: usize, y: usize| (4..12).contains(&x) && (2..12).contains(&y);
        let exact = check(&truth, |x, y| if inside(x, y) { 0.5 } else { 0.0 });
        assert_eq!((exact.wrong, exact.loose, exact.covered), (0, 0, 80));
        let rect = |x0| Rect {
            x0,
            y0: 3,
            x1: 9,
            y1: 9,
        };
        let all_open = check(&truth, |_, _| 0.0);
        assert_eq!((all_open.wrong, all_open.loose), (0, 80));
        let too_near = check(&truth, |x, y| if inside(x, y) { 0.5001 } else { 0.0 });
        assert_eq!(too_near.wrong, 80);
        let too_large = check(&truth, |x, y| {
            if inside(x, y) || inside(x + 1, y) {
                0.5
            } else {
                0.0
            }
        });
        assert_eq!(too_large.wrong, 10);
        assert_eq!(check(&truth, |_, _| f32::NAN).wrong, 32 * 16);
        assert_eq!(truth.check_rect(&rect(5), 0.4, true).wrong, 0);
        assert_eq!(truth.check_rect(&rect(5), 0.4, false).loose, 1);
        assert_eq!(truth.check_rect(&rect(5), 0.6, true).wrong, 1);
        assert_eq!(truth.check_rect(&rect(3), 0.4, true).wrong, 1);
    }

    #[test]
    fn a_back_is_not_there() {
        let mut truth = empty();
        let mut back = face(
            &truth,
            &[([4.0, 12.0], 2.0), ([12.0, 12.0], 2.0), ([12.0, 2.0], 2.0)],
        );
        back.reverse();
        truth.add(&back);
        assert!(truth.hit.iter().all(|&hit| hit == 0));
    }

    #[test]
    fn what_goes_on_behind_the_eye_is_seen_up_to_the_near_plane() {
        let mut truth = empty();
        // A floor: two corners ahead, one far behind the eye.
        let floor = [[-9.0, -1.0, -9.0], [0.0, -1.0, 9.0], [9.0, -1.0, -9.0]];
        truth.add(&floor);
        let nearest = |x: usize, y: usize| truth.nearest[y * 32 + x];
        assert_eq!(nearest(16, 7), 0.0, "above the horizon");
        let focal = 8.0 / 30.0_f64.to_radians().tan();
        let below = f64::from(nearest(16, 15));
        // The last row is 7.5 pixels below the middle, and a ray another 1/1024; the floor is one unit below the eye.
        let lowest = 7.5 + DELTA + View::GENERIC_OFFSET[1];
        assert!((below * focal - lowest).abs() < 1e-5, "{below}");
    }
}
