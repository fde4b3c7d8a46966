//! The clip region of a passage: the screen area still visible through the portals so far.

mod outline;

use glam::DVec3;
use outline::{Outline, within_grown};
use smallvec::smallvec;

/// A rectangle of samples: columns `x0..x1`, rows `y0..y1`.
#[doc(alias = "scissor")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Rect {
    /// First column.
    pub x0: u16,
    /// First row.
    pub y0: u16,
    /// Last column + 1.
    pub x1: u16,
    /// Last row + 1.
    pub y1: u16,
}

impl Rect {
    /// Returns `true` if the rectangle contains no sample.
    pub fn is_empty(&self) -> bool {
        self.x0 >= self.x1 || self.y0 >= self.y1
    }

    /// Returns the samples in both rectangles.
    #[must_use]
    pub fn intersection(&self, other: &Rect) -> Rect {
        Rect {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        }
    }

    /// Returns the samples whose pixel centres are at most `spread` pixels from these bounds along each axis, clipped to
    /// `within`; see [`Rect::around`].
    pub(crate) fn near(min: [f64; 2], max: [f64; 2], spread: f64, within: &Rect) -> Rect {
        Rect::around(min.map(|low| low - spread), max.map(|high| high + spread), within)
    }

    /// Margin in pixels. Screen positions are accurate to 10⁻⁹ pixel. An extra sample costs a test, a missing one a
    /// wrong picture.
    pub(crate) const SLACK: f64 = 1e-6;

    /// Returns the samples whose pixel centres are within these bounds, in pixels, clipped to `within`. Bounds are
    /// enlarged by [`Rect::SLACK`], so that rounding loses no sample.
    #[inline(always)]
    pub(crate) fn around(min: [f64; 2], max: [f64; 2], within: &Rect) -> Rect {
        let first = |low: f64, start: u16, end: u16| {
            let at = (low - (0.5 + Rect::SLACK)).clamp(f64::from(start) - 1.0, f64::from(end));
            (at + 1.0) as u16
        };
        let after = |high: f64, start: u16, end: u16| {
            ((high + (0.5 + Rect::SLACK)).clamp(f64::from(start), f64::from(end))) as u16
        };
        Rect {
            x0: first(min[0], within.x0, within.x1).max(within.x0),
            y0: first(min[1], within.y0, within.y1).max(within.y0),
            x1: after(max[0], within.x0, within.x1),
            y1: after(max[1], within.y0, within.y1),
        }
    }
}

/// A set of samples as runs of columns, row by row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    first_row: u16,
    /// Start of each row in `runs`, and the end of the last.
    starts: Vec<u32>,
    runs: Vec<[u16; 2]>,
}

impl Rows {
    pub(crate) fn clear(&mut self) {
        self.starts.clear();
        self.runs.clear();
    }

    /// Adds columns `x0..x1` of row `y`. Call with rows from top to bottom and, within a row, runs from left to right.
    pub fn push(&mut self, y: u16, x0: u16, x1: u16) {
        if self.starts.is_empty() {
            self.first_row = y;
            self.starts.push(0);
        }
        while self.first_row as usize + self.starts.len() - 1 <= usize::from(y) {
            self.starts.push(self.runs.len() as u32);
        }
        self.runs.push([x0, x1]);
        let last = self.starts.len() - 1;
        self.starts[last] = self.runs.len() as u32;
    }

    /// Returns the runs of row `y`, left to right, each as first column and last column + 1; empty for rows without
    /// samples.
    pub fn row(&self, y: u16) -> &[[u16; 2]] {
        match usize::from(y).checked_sub(usize::from(self.first_row)) {
            Some(row) if row + 1 < self.starts.len() => {
                &self.runs[self.starts[row] as usize..self.starts[row + 1] as usize]
            }
            _ => &[],
        }
    }

    /// Returns the range of rows, from the first with a run to the last with a run.
    pub fn range(&self) -> std::ops::Range<u16> {
        self.first_row..self.first_row + self.starts.len().saturating_sub(1) as u16
    }

    /// Returns the bounding rectangle of all runs.
    pub fn rect(&self) -> Rect {
        let range = self.range();
        let x0 = self.runs.iter().map(|run| run[0]).min().unwrap_or(0);
        let x1 = self.runs.iter().map(|run| run[1]).max().unwrap_or(0);
        Rect {
            x0,
            y0: range.start,
            x1,
            y1: range.end,
        }
    }
}

/// A clip region: the screen area still visible through the portals so far, as a convex polygon, plus the exact samples
/// if the method knows them.
#[doc(alias = "clip region")]
#[doc(alias = "scissor")]
#[doc(alias = "portal window")]
#[derive(Clone, Debug, PartialEq)]
pub struct Aperture {
    /// Corners on the screen, in pixels, y down.
    outline: Outline,
    rect: Rect,
    rows: Option<Rows>,
}

/// Returns the samples within the bounds of an outline and up to `spread` around it, clipped to `within`.
fn around(outline: &[[f64; 2]], spread: f64, within: &Rect) -> Rect {
    let low = |axis: usize| outline.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
    let high = |axis: usize| outline.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
    Rect::near([low(0), low(1)], [high(0), high(1)], spread, within)
}

/// Scratch buffers of [`Aperture::in_cells`].
#[derive(Default)]
pub(crate) struct CellRoom {
    rows: Rows,
    runs: Vec<[u16; 2]>,
    row: Vec<[u16; 2]>,
}

impl CellRoom {
    /// Takes the rows of an aperture back for reuse.
    pub(crate) fn take_back(&mut self, mut aperture: Aperture) {
        if let Some(rows) = aperture.take_rows() {
            self.rows = rows;
        }
    }
}

impl Aperture {
    /// Returns the clip region of the whole screen; `size` is width and height in pixels.
    pub fn screen(size: [u32; 2]) -> Aperture {
        let [width, height] = size.map(f64::from);
        Aperture {
            outline: smallvec![[0.0, 0.0], [0.0, height], [width, height], [width, 0.0]],
            rect: Rect {
                x0: 0,
                y0: 0,
                x1: size[0] as u16,
                y1: size[1] as u16,
            },
            rows: None,
        }
    }

    /// Whether this is the clip region of the whole screen, or of rows of it.
    pub(crate) fn is_unclipped(&self, size: [u32; 2]) -> bool {
        self.rows.is_none() && self.outline == Aperture::screen(size).outline
    }

    /// Returns a part of the screen, given by its convex outline, as [`Aperture::outline`] returns it, or by that and its
    /// samples; `None` if it contains no sample up to `spread` pixels from its outline.
    pub(crate) fn part(
        size: [u32; 2],
        outline: &[[f64; 2]],
        rows: Option<Rows>,
        spread: f64,
    ) -> Option<Aperture> {
        let screen = Aperture::screen(size);
        let rect = match &rows {
            Some(rows) => rows.rect(),
            None => around(outline, spread, &screen.rect),
        };
        let outline = outline.iter().copied().collect();
        (!rect.is_empty()).then_some(Aperture { outline, rect, rows })
    }

    /// Returns the intersection with an opening, given by its corners as (X, Y, W); `None` if it contains no sample.
    ///
    /// `rows` are the samples that the opening owns, if the method knows them. Otherwise the samples are those within
    /// the projected outline and up to `spread` around it. The outline grows by `margin` pixels.
    pub(crate) fn behind(
        &self,
        opening: impl Iterator<Item = DVec3>,
        rows: Option<Rows>,
        spread: f64,
        margin: f64,
    ) -> Option<Aperture> {
        let outline = within_grown(&self.outline, opening, margin);
        let rect = match &rows {
            Some(rows) => rows.rect(),
            None => around(&outline, spread, &self.rect),
        };
        (!rect.is_empty()).then_some(Aperture { outline, rect, rows })
    }

    /// Returns the aperture at a lower resolution, `scale` cells per pixel: a cell is open if any of its samples is.
    pub(crate) fn in_cells(&self, scale: [f64; 2], room: &mut CellRoom) -> Aperture {
        let cell = |at: u16, axis: usize| ((f64::from(at) + 0.5) * scale[axis]) as u16;
        let CellRoom { rows, runs, row } = room;
        rows.clear();
        row.clear();
        let Rect { y0, y1, .. } = self.rect;
        for y in y0..y1 {
            self.open_in_row(y, runs);
            row.extend(runs.iter().map(|&[x0, x1]| [cell(x0, 0), cell(x1 - 1, 0) + 1]));
            let at = cell(y, 1);
            if y + 1 == y1 || cell(y + 1, 1) != at {
                row.sort_unstable();
                let mut joined: Option<[u16; 2]> = None;
                for run in row.drain(..) {
                    match &mut joined {
                        Some(last) if run[0] <= last[1] => last[1] = last[1].max(run[1]),
                        last => {
                            if let Some([x0, x1]) = last.replace(run) {
                                rows.push(at, x0, x1);
                            }
                        }
                    }
                }
                if let Some([x0, x1]) = joined {
                    rows.push(at, x0, x1);
                }
            }
        }
        Aperture {
            outline: (self.outline.iter())
                .map(|at| [at[0] * scale[0], at[1] * scale[1]])
                .collect(),
            rect: rows.rect(),
            rows: Some(std::mem::take(rows)),
        }
    }

    /// Returns the part in rows `y0..y1`, which must be within the rectangle. If the aperture has exact samples, those
    /// of the part are stored in `spare`, which is taken; see [`Aperture::take_rows`].
    pub(crate) fn strip(&self, [y0, y1]: [u16; 2], spare: &mut Rows) -> Aperture {
        let rows = self.rows.as_ref().map(|rows| {
            spare.clear();
            for y in y0..y1 {
                rows.row(y).iter().for_each(|&[x0, x1]| spare.push(y, x0, x1));
            }
            std::mem::take(spare)
        });
        Aperture {
            outline: self.outline.clone(),
            rect: Rect { y0, y1, ..self.rect },
            rows,
        }
    }

    /// Returns the corners on the screen, in pixels, y down, counter-clockwise; fewer than three if the aperture is
    /// known by its samples only.
    pub fn outline(&self) -> &[[f64; 2]] {
        &self.outline
    }

    /// Returns the exact samples, if the method knows them.
    pub fn rows(&self) -> Option<&Rows> {
        self.rows.as_ref()
    }

    /// Takes the rows out for reuse.
    pub(crate) fn take_rows(&mut self) -> Option<Rows> {
        self.rows.take()
    }

    /// Returns the bounding rectangle of the samples.
    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Replaces `runs` by the open columns of row `y`, left to right.
    pub(crate) fn open_in_row(&self, y: u16, runs: &mut Vec<[u16; 2]>) {
        runs.clear();
        if let Some(rows) = &self.rows {
            runs.extend_from_slice(rows.row(y));
            return;
        }
        if !(self.rect.y0..self.rect.y1).contains(&y) {
            return;
        }
        let [mut left, mut right] = [f64::from(self.rect.x0), f64::from(self.rect.x1)];
        let center = f64::from(y) + 0.5;
        for (i, from) in self.outline.iter().enumerate() {
            let to = self.outline[(i + 1) % self.outline.len()];
            let down = to[1] - from[1];
            if down == 0.0 {
                continue;
            }
            let x = from[0] + (to[0] - from[0]) * ((center - from[1]) / down) - 0.5;
            if down > 0.0 {
                left = left.max(x - 1e-6);
            } else {
                right = right.min(x + 1.0 + 1e-6);
            }
        }
        let run = [left.max(0.0).ceil() as u16, right.max(0.0) as u16];
        if run[0] < run[1] {
            runs.push(run);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::ConvexPolygon;
    use crate::view::View;

    fn window(z: f32) -> ConvexPolygon {
        ConvexPolygon::rectangle([-1.0, -1.0, z], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]).expect("a square")
    }

    fn through(eye: [f32; 3], z: f32) -> Option<Aperture> {
        let view = View::new(eye, [eye[0], eye[1], eye[2] - 1.0], [100, 100]).expect("a valid view");
        let screen = view.screen_from_eye() * view.eye_from_sector().0;
        let window = window(z);
        let corners = window
            .corners()
            .iter()
            .map(|corner| screen.transform_point3(DVec3::from(corner.map(f64::from))));
        Aperture::screen(view.size()).behind(corners, None, 0.0, 0.0)
    }

    #[test]
    fn a_window_far_away_is_a_small_square() {
        let aperture = through([0.0; 3], -10.0).expect("window in view");
        let rect = aperture.rect();
        assert_eq!([rect.x1 - rect.x0, rect.y1 - rect.y0], [18, 18]);
        let mut runs = Vec::new();
        aperture.open_in_row(50, &mut runs);
        assert_eq!(runs, [[41, 59]]);
        aperture.open_in_row(20, &mut runs);
        assert!(runs.is_empty());
    }

    #[test]
    fn a_slanted_window_opens_the_samples_inside_it_and_no_other() {
        let mut tested = 0;
        for turn in [0.1, 0.7, 1.3, 2.9] {
            let corners: Vec<[f64; 2]> = (0..5)
                .map(|i| {
                    // Clockwise on the screen, where y is down.
                    let (sin, cos) = (turn + f64::from(i) * std::f64::consts::TAU / 5.0).sin_cos();
                    [50.3 + 31.0 * cos, 47.9 + 17.0 * sin]
                })
                .collect();
            let outline = corners.iter().map(|&[x, y]| DVec3::new(x, y, 1.0));
            let aperture = Aperture::screen([100, 100])
                .behind(outline, None, 0.0, 0.0)
                .expect("a window in view");
            let mut runs = Vec::new();
            for y in 0..100_u16 {
                aperture.open_in_row(y, &mut runs);
                for x in 0..100_u16 {
                    let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                    let sides = (0..5).map(|i| {
                        let [a, b] = [corners[i], corners[(i + 1) % 5]];
                        (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0])
                    });
                    let least = sides.fold(f64::INFINITY, f64::min);
                    if least.abs() < 1e-3 {
                        continue;
                    }
                    let is_open = runs.iter().any(|&[x0, x1]| (x0..x1).contains(&x));
                    assert_eq!(is_open, least > 0.0, "sample {x} {y}");
                    tested += u32::from(is_open);
                }
            }
        }
        assert!(tested > 4000);
    }

    #[test]
    fn a_window_that_the_eye_stands_in_is_the_whole_screen() {
        for distance in [1e-2, 1e-6, 1e-12] {
            let aperture = through([0.0; 3], -distance).expect("window right in front of the eye");
            assert_eq!(aperture.rect(), Aperture::screen([100, 100]).rect());
        }
    }

    #[test]
    fn a_window_behind_the_eye_shows_nothing() {
        assert_eq!(through([0.0; 3], 1.0), None);
    }

    #[test]
    fn rows_give_back_the_runs_they_were_given() {
        let mut rows = Rows::default();
        for (y, x0, x1) in [(3, 5, 9), (3, 11, 12), (6, 1, 2)] {
            rows.push(y, x0, x1);
        }
        assert_eq!(rows.row(3), [[5, 9], [11, 12]]);
        assert!(rows.row(2).is_empty() && rows.row(4).is_empty() && rows.row(7).is_empty());
        assert_eq!(rows.row(6), [[1, 2]]);
        assert_eq!(
            rows.rect(),
            Rect {
                x0: 1,
                y0: 3,
                x1: 12,
                y1: 7
            }
        );
    }
}
