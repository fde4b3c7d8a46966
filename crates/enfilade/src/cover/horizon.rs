//! Floating horizon for terrain: how far each group of columns is covered without a gap, from the bottom and from the
//! top.
//!
//! In terrain drawn front to back, far ground is hidden as long as it stays below the horizon drawn so far, and ground
//! above the eye as long as it stays above it. So for each group of eight columns of samples (or rows, if the up
//! direction is closer to horizontal on the screen) two horizons store how far the group is covered from either end,
//! and the farthest reversed depth within that part. A box is hidden if it is behind that part in all of its columns.
//! Each sample also stores reversed depth and owner, so that other geometry may come in any order, such as objects on
//! the ground that hide part of it.
//! Horizons follow from the covered samples, not from the terrain, so they are valid for any camera: a screen column is
//! a vertical section of the terrain only for a level one.
//! Source: Williamson, Hidden-Line Plotting Program, CACM 1972; Anderson, Hidden Line Elimination in Projected Grid
//!     Surfaces, ACM Transactions on Graphics 1982. Samples instead of lines, and depths beside them, are original to
//!     this library.
//! Cost: clear and finish O(samples of the aperture); a face O(samples it covers); a box O(columns / 8), plus
//!     O(samples) once in total for raising the horizons.
//! Exact: its visible set is the owners of the final samples, plus transparent faces depth-tested against them.

use super::samples::{COVERED, OPEN, Sample, Samples, look_through, rev_depth};
use super::{Cover, Paints};
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::order::Unsorted;
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::Canvas;
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use glam::DVec3;

/// Depth buffer with two floating horizons per group of eight columns, for terrain.
///
/// Takes faces in any order; culls best when terrain comes front to back. One sample per pixel of the screen.
#[derive(Default)]
#[doc(alias = "floating horizon")]
#[doc(alias = "terrain")]
pub struct Horizon {
    raster: Raster,
    buffer: HorizonBuffer,
}

/// A depth buffer and its horizons.
///
/// A *line* is a column of samples, or a row if `across` is `true`; a *step* is a position along a line.
#[derive(Default)]
struct HorizonBuffer {
    samples: Samples,
    /// Whether lines are rows instead of columns.
    across: bool,
    /// One entry for every eight lines of the aperture's rectangle.
    horizons: Vec<Horizons>,
}

/// Covered ranges of a group of eight lines, from either end.
#[derive(Clone, Copy)]
struct Horizons {
    /// The group is covered from its beginning up to the first step (exclusive), and from the second step to its end.
    ends: [u16; 2],
    /// Bits of the farthest reversed depth in each of the two covered parts.
    farthest: [u32; 2],
}

/// Lines per group: as many samples as fit in a cache line.
const LINES: u16 = 8;

impl Cover for Horizon {
    type Needs = Unsorted;

    const NAME: &'static str = "Horizon";

    fn test(&mut self, region: &Region) -> Visibility {
        if self.buffer.hides(&region.rect, region.nearest.to_bits()) {
            Visibility::Hidden
        } else {
            Visibility::Partial
        }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let lines = u64::from(size[0].max(size[1]).div_ceil(LINES.into()));
        Samples::needs_bytes(size) + lines * size_of::<Horizons>() as u64
    }
}

impl Paints for Horizon {
    const PRIMES: bool = false;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        let HorizonBuffer {
            samples,
            across,
            horizons,
        } = &mut self.buffer;
        samples.shape(passage, trace);
        samples.open(passage, |_, _| {});
        let rect = samples.rect;
        *across = is_up_horizontal(passage, &rect);
        let [lines, steps] = by_line(&rect, *across);
        horizons.clear();
        horizons.resize(
            usize::from((lines[1] - lines[0]).div_ceil(LINES)),
            Horizons {
                ends: steps,
                farthest: [u32::MAX; 2],
            },
        );
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.buffer.samples.begin_batch();
        self.raster.run(faces, passage, &mut self.buffer, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let depth = |x, y| self.buffer.samples.depth(x, y);
        look_through(depth, &mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.buffer.samples.report(owners, seen, canvas);
    }
}

/// Returns `true` if the sector's up axis, projected at the centre of `rect`, is closer to horizontal than to vertical.
fn is_up_horizontal(passage: &Passage, rect: &Rect) -> bool {
    let DVec3 { x, y, z } = passage.screen_from_sector.linear.transform_vector3(DVec3::Y);
    if passage.is_parallel() {
        return x.abs() > y.abs();
    }
    let middle = [
        0.5 * (f64::from(rect.x0) + f64::from(rect.x1)),
        0.5 * (f64::from(rect.y0) + f64::from(rect.y1)),
    ];
    (x - middle[0] * z).abs() > (y - middle[1] * z).abs()
}

/// Returns the range of lines of a rectangle, and the range of steps along them.
#[inline(always)]
fn by_line(rect: &Rect, across: bool) -> [[u16; 2]; 2] {
    let [columns, rows] = [[rect.x0, rect.x1], [rect.y0, rect.y1]];
    if across { [rows, columns] } else { [columns, rows] }
}

impl HorizonBuffer {
    /// Returns `true` if all samples in a rectangle are nearer than `bits`. Raises the horizons as far as needed to
    /// decide.
    fn hides(&mut self, rect: &Rect, bits: u32) -> bool {
        let rect = rect.intersection(&self.samples.rect);
        if rect.is_empty() {
            return true;
        }
        self.groups(&rect).all(|group| {
            let [start, end] = self.steps(&rect);
            self.raise(group, [start, end]);
            self.horizons[group].hide([start, end], bits)
        })
    }

    /// Returns the groups of lines that a rectangle touches.
    #[inline(always)]
    fn groups(&self, rect: &Rect) -> std::ops::RangeInclusive<usize> {
        let [first, _] = by_line(&self.samples.rect, self.across)[0];
        let [start, end] = by_line(rect, self.across)[0];
        usize::from((start - first) / LINES)..=usize::from((end - 1 - first) / LINES)
    }

    #[inline(always)]
    fn steps(&self, rect: &Rect) -> [u16; 2] {
        by_line(rect, self.across)[1]
    }

    /// Raises a horizon of a group over `start..end`, as far as samples are covered.
    fn raise(&mut self, group: usize, [start, end]: [u16; 2]) {
        let mut horizons = self.horizons[group];
        // Starts with the horizon at the end of the line, where the ground is.
        while horizons.ends[1] > start {
            let farthest = self.farthest_across(group, horizons.ends[1] - 1);
            if farthest == 0 {
                break;
            }
            horizons.ends[1] -= 1;
            horizons.farthest[1] = horizons.farthest[1].min(farthest);
        }
        while horizons.ends[1] > start && horizons.ends[0] < end {
            let farthest = self.farthest_across(group, horizons.ends[0]);
            if farthest == 0 {
                break;
            }
            horizons.ends[0] += 1;
            horizons.farthest[0] = horizons.farthest[0].min(farthest);
        }
        self.horizons[group] = horizons;
    }

    /// Returns the bits of the farthest reversed depth across a group of lines at one step; 0 if any sample is open.
    #[inline(always)]
    fn farthest_across(&self, group: usize, step: u16) -> u32 {
        let [first, last] = by_line(&self.samples.rect, self.across)[0];
        let start = first + group as u16 * LINES;
        let end = (start + LINES).min(last);
        let farthest = |samples: &[Sample]| {
            let least = samples.iter().fold(COVERED, |least, &sample| least.min(sample));
            if least == OPEN { 0 } else { rev_depth(least) }
        };
        if self.across {
            let all = (start..end).map(|y| farthest(self.samples.row(y, step, step + 1)));
            all.min().unwrap_or(0)
        } else {
            farthest(self.samples.row(step, start, end))
        }
    }
}

impl Horizons {
    /// Returns `true` if all steps from `start` to `end` are covered and nearer than `bits`.
    #[inline(always)]
    fn hide(&self, [start, end]: [u16; 2], bits: u32) -> bool {
        (self.ends[1] <= start && bits < self.farthest[1]) || (self.ends[0] >= end && bits < self.farthest[0])
    }
}

impl Sink for HorizonBuffer {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        let steps = self.steps(rect);
        let bits = nearest.to_bits();
        self.groups(rect)
            .all(|group| self.horizons[group].hide(steps, bits))
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        for (y, [x0, x1]) in band.rows() {
            self.samples.keep_nearest(y, x0, x1, triangle);
        }
    }
}
