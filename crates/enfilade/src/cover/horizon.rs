//! Floating horizon: how far up, and how far down, everything is covered without a gap.
//!
//! Of ground seen near to far the far is hidden as long as it stays below what was seen last, and of ground above the eye as
//! long as it stays over it. So for every eight columns of samples (or rows, where upright is nearer to across) it is known
//! how far they are covered from either end, and how far away the farthest of that is; a box is hidden where that is so in
//! all of its columns. Reversed depth and owner of each sample are kept, so that things may also come in another order: what
//! stands on the ground, and hides some of it.
//! Source: Williamson, Hidden-Line Plotting Program, CACM 1972; Anderson, Hidden Line Elimination in Projected Grid Surfaces,
//!     ACM Transactions on Graphics 1982. Samples instead of lines, and depths beside them, are ours.
//! Cost: clear and finish O(samples of the aperture); a face O(samples it covers); boxes O(columns / 8), and all together once
//!     O(samples) for raising horizons.
//! Exact: its set is the owners that are left, and glass held against the final depth.

use super::raster::{Band, Raster, Sink};
use super::samples::{COVERED, OPEN, Sample, Samples, look_through, rev_depth};
use super::triangle::Triangle;
use super::{Cover, Paints};
use crate::aperture::Rect;
use crate::canvas::Canvas;
use crate::collector::Collector;
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::order::Unsorted;
use crate::passage::Passage;
use crate::region::{Region, Visibility};
use crate::stats::Stats;
use glam::DVec3;

/// The nearest face so far at each sample, under two horizons.
#[derive(Default)]
pub struct Horizon {
    raster: Raster,
    known: Known,
}

#[derive(Default)]
struct Known {
    samples: Samples,
    /// Are lines rows, and not columns?
    across: bool,
    /// Of every eight lines of the aperture's rectangle.
    horizons: Vec<Horizons>,
}

/// How far eight lines are covered.
#[derive(Clone, Copy)]
struct Horizons {
    /// From their beginning up to here, and from here on to their end.
    ends: [u16; 2],
    /// Bits of the farthest reversed depth of each of the two.
    farthest: [u32; 2],
}

/// Lines that are taken together: as many samples as a line of the cache holds.
const LINES: u16 = 8;

impl Cover for Horizon {
    type CullNeeds = Unsorted;

    fn sees(&mut self, region: &Region) -> Visibility {
        if self.known.hides(&region.rect, region.nearest.to_bits()) {
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
    type DrawNeeds = Unsorted;
    const PRIMES: bool = false;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        let Known {
            samples,
            across,
            horizons,
        } = &mut self.known;
        samples.shape(passage, trace);
        samples.open(passage, |_, _| {});
        let rect = samples.rect;
        *across = up_goes_across(passage, &rect);
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
        self.known.samples.begin_batch();
        self.raster.run(faces, passage, &mut self.known, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let depth = |x, y| self.known.samples.depth(x, y);
        look_through(depth, &mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.known.samples.report(owners, seen, canvas);
    }
}

/// Does what goes up in the sector go more to the side on the screen than up?
fn up_goes_across(passage: &Passage, rect: &Rect) -> bool {
    let DVec3 { x, y, z } = passage.screen_from_sector.transform_vector3(DVec3::Y);
    let middle = [
        0.5 * (f64::from(rect.x0) + f64::from(rect.x1)),
        0.5 * (f64::from(rect.y0) + f64::from(rect.y1)),
    ];
    (x - middle[0] * z).abs() > (y - middle[1] * z).abs()
}

/// The lines of a rectangle, and the samples along them.
#[inline(always)]
fn by_line(rect: &Rect, across: bool) -> [[u16; 2]; 2] {
    let [columns, rows] = [[rect.x0, rect.x1], [rect.y0, rect.y1]];
    if across { [rows, columns] } else { [columns, rows] }
}

impl Known {
    /// Is everything in a rectangle nearer than `bits`? Raises horizons as far as needed to tell.
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

    /// The groups of lines in a rectangle.
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

    /// Brings one of the horizons of a group over `steps`, as far as samples are covered.
    fn raise(&mut self, group: usize, [start, end]: [u16; 2]) {
        let mut horizons = self.horizons[group];
        // The one from the end first: there is the ground.
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

    /// Bits of the farthest reversed depth across a group of lines; 0 where anything is open.
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
    /// Is all from `start` to `end` nearer than `bits`?
    #[inline(always)]
    fn hide(&self, [start, end]: [u16; 2], bits: u32) -> bool {
        (self.ends[1] <= start && bits < self.farthest[1]) || (self.ends[0] >= end && bits < self.farthest[0])
    }
}

impl Sink for Known {
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
