//! Hierarchical z-buffer: skip whole octree nodes hidden behind a pyramid of depths.
//!
//! Each pyramid cell holds the farthest depth of the four below it, so one test can hide a large box.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, sections 3.1 to 3.3.
//! Cost: clear and finish O(samples of the aperture); a test O(1) cells where it is hidden or plainly seen; cells are
//!     brought up to date when a test needs them, not at each depth written.
//! Exact: an owner is kept beside each depth; a box is tested by its nearest corner, so nothing seen is dropped.

use super::depth_buffer::keep_nearest;
use super::raster::{Raster, Sink, Triangle};
use super::samples::{Sample, Samples, nearness};
use super::{Cover, Sight};
use crate::aperture::Rect;
use crate::canvas::Canvas;
use crate::content::Content;
use crate::faces::Faces;
use crate::order::Unsorted;
use crate::passage::Passage;
use crate::region::Region;
use crate::seen::Seen;
use crate::stats::Stats;

/// A depth buffer under a pyramid of farthest depths.
#[derive(Default)]
pub struct DepthPyramid {
    raster: Raster,
    depths: Depths,
}

#[derive(Default)]
struct Depths {
    samples: Samples,
    /// Tiles of 8×8 samples, then 2×2 cells of the level below each.
    levels: Vec<Level>,
}

#[derive(Default)]
struct Level {
    width: usize,
    height: usize,
    cells: Vec<Cell>,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    /// Bits of the farthest nearness below; never nearer than the truth.
    farthest: u32,
    /// May a sample below have come nearer since?
    stale: bool,
}

/// Samples along the side of the smallest cell: 8. Three levels of the textbook's pyramid in one: a tile is brought
/// up to date in about the time that the bookkeeping of its inner levels would take.
const TILE_SHIFT: usize = 3;
const TILE: usize = 1 << TILE_SHIFT;

impl Cover for DepthPyramid {
    type CullNeeds = Unsorted;
    type DrawNeeds = Unsorted;
    const PRIMES: bool = true;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        self.depths.samples.clear(passage, trace);
        self.depths.clear(passage.parent.is_some());
    }

    fn sees(&mut self, region: &Region) -> Sight {
        let bits = region.nearest.to_bits();
        if self.depths.sees(&region.rect, bits) {
            Sight::Partly
        } else {
            Sight::Hidden
        }
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.depths.samples.begin_batch();
        self.raster.run(faces, passage, &mut self.depths, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Seen) {
        self.depths
            .samples
            .look_through(&mut self.raster, faces, passage, stats, seen);
    }

    fn finish(
        &mut self,
        content: &Content,
        _passage: &Passage,
        seen: &mut Seen,
        canvas: Option<&mut dyn Canvas>,
    ) {
        self.depths.samples.finish(content, seen, canvas);
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let samples = u64::from(size[0]) * u64::from(size[1]);
        let tiles = u64::from(size[0].div_ceil(TILE as u32)) * u64::from(size[1].div_ceil(TILE as u32));
        samples * size_of::<Sample>() as u64 + 2 * tiles * size_of::<Cell>() as u64
    }
}

impl Depths {
    /// Shapes the pyramid over the aperture's rectangle. `partly`: some of its samples are covered from the start.
    fn clear(&mut self, partly: bool) {
        let Rect { x1, y1, .. } = self.samples.rect;
        let [mut width, mut height] = [x1, y1].map(|side| usize::from(side).div_ceil(TILE));
        for level in 0.. {
            if self.levels.len() == level {
                self.levels.push(Level::default());
            }
            let cells = &mut self.levels[level].cells;
            cells.clear();
            cells.resize(
                width * height,
                Cell {
                    farthest: 0,
                    stale: partly,
                },
            );
            self.levels[level].width = width;
            self.levels[level].height = height;
            if width <= 1 && height <= 1 {
                self.levels.truncate(level + 1);
                break;
            }
            [width, height] = [width.div_ceil(2), height.div_ceil(2)];
        }
    }

    /// Is any sample of `rect` no nearer than `bits`?
    fn sees(&mut self, rect: &Rect, bits: u32) -> bool {
        let mut level = 0;
        let cells = |level: usize| {
            let shift = TILE_SHIFT + level;
            let [x0, y0] = [rect.x0, rect.y0].map(|first| usize::from(first) >> shift);
            let [x1, y1] = [rect.x1, rect.y1].map(|end| (usize::from(end) - 1) >> shift);
            [x0, y0, x1, y1]
        };
        let [mut x0, mut y0, mut x1, mut y1] = cells(level);
        while (x1 - x0 > 1 || y1 - y0 > 1) && level + 1 < self.levels.len() {
            level += 1;
            [x0, y0, x1, y1] = cells(level);
        }
        (y0..=y1).any(|y| (x0..=x1).any(|x| self.cell_sees(level, x, y, rect, bits)))
    }

    fn cell_sees(&mut self, level: usize, x: usize, y: usize, rect: &Rect, bits: u32) -> bool {
        let index = y * self.levels[level].width + x;
        let Cell { farthest, stale } = self.levels[level].cells[index];
        if bits < farthest {
            return false;
        }
        let whole = self.is_whole(level, x, y, rect);
        if whole && !stale {
            return true;
        }
        if level == 0 {
            return self.tile_sees(x, y, whole, rect, bits);
        }
        let below = TILE_SHIFT + level - 1;
        let [first_x, first_y] = [rect.x0, rect.y0].map(|first| usize::from(first) >> below);
        let [last_x, last_y] = [rect.x1, rect.y1].map(|end| (usize::from(end) - 1) >> below);
        for child_y in (2 * y).max(first_y)..=(2 * y + 1).min(last_y) {
            for child_x in (2 * x).max(first_x)..=(2 * x + 1).min(last_x) {
                if self.cell_sees(level - 1, child_x, child_y, rect, bits) {
                    return true;
                }
            }
        }
        if whole {
            self.bring_up_to_date(level, x, y);
        }
        false
    }

    /// Does `rect` hold every sample of a cell that the aperture's rectangle holds?
    fn is_whole(&self, level: usize, x: usize, y: usize, rect: &Rect) -> bool {
        let shift = TILE_SHIFT + level;
        let all = &self.samples.rect;
        let [x0, y0] = [x << shift, y << shift];
        let [x1, y1] = [(x + 1) << shift, (y + 1) << shift];
        usize::from(rect.x0) <= x0.max(usize::from(all.x0))
            && usize::from(rect.y0) <= y0.max(usize::from(all.y0))
            && usize::from(rect.x1) >= x1.min(usize::from(all.x1))
            && usize::from(rect.y1) >= y1.min(usize::from(all.y1))
    }

    fn tile_sees(&mut self, x: usize, y: usize, whole: bool, rect: &Rect, bits: u32) -> bool {
        let index = y * self.levels[0].width + x;
        if self.levels[0].cells[index].stale {
            let farthest = self.farthest_in(x, y, &self.samples.rect);
            self.levels[0].cells[index] = Cell {
                farthest,
                stale: false,
            };
            if bits < farthest {
                return false;
            }
        }
        whole || self.farthest_in(x, y, rect) <= bits
    }

    /// Bits of the farthest nearness among the samples of a tile inside `rect`.
    fn farthest_in(&self, x: usize, y: usize, rect: &Rect) -> u32 {
        let x0 = (x * TILE).max(usize::from(rect.x0));
        let x1 = (x * TILE + TILE).min(usize::from(rect.x1));
        let y0 = (y * TILE).max(usize::from(rect.y0));
        let y1 = (y * TILE + TILE).min(usize::from(rect.y1));
        let mut farthest = Sample::MAX;
        for y in y0..y1 {
            let start = y * self.samples.width;
            for &sample in &self.samples.samples[start + x0..start + x1] {
                farthest = if sample < farthest { sample } else { farthest };
            }
        }
        nearness(farthest)
    }

    /// Takes over what the four cells below know.
    fn bring_up_to_date(&mut self, level: usize, x: usize, y: usize) {
        let [above, below] = [level, level - 1];
        let Level { width, height, .. } = self.levels[below];
        let mut cell = Cell {
            farthest: u32::MAX,
            stale: false,
        };
        for child_y in 2 * y..(2 * y + 2).min(height) {
            for child_x in 2 * x..(2 * x + 2).min(width) {
                let child = self.levels[below].cells[child_y * width + child_x];
                cell = Cell {
                    farthest: cell.farthest.min(child.farthest),
                    stale: cell.stale | child.stale,
                };
            }
        }
        let width = self.levels[above].width;
        self.levels[above].cells[y * width + x] = cell;
    }

    /// A sample of this tile came nearer: the cells above it no longer know.
    #[inline(always)]
    fn mark(&mut self, mut x: usize, mut y: usize) {
        for level in &mut self.levels {
            let cell = &mut level.cells[y * level.width + x];
            if cell.stale {
                return;
            }
            cell.stale = true;
            [x, y] = [x / 2, y / 2];
        }
    }
}

impl Sink for Depths {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        !self.sees(rect, nearest.to_bits())
    }

    #[inline(always)]
    fn run(&mut self, y: u16, x0: u16, x1: u16, triangle: &Triangle) {
        let tile_y = usize::from(y) >> TILE_SHIFT;
        let row = triangle.row(y);
        let mut start = x0;
        while start < x1 {
            let tile_x = usize::from(start) >> TILE_SHIFT;
            let end = (((tile_x + 1) << TILE_SHIFT) as u16).min(x1);
            let ends = [row.bits(i32::from(start)), row.bits(i32::from(end) - 1)];
            // Linear along the row, so nearest at an end; one bit more for what rounding does between.
            let nearest = ends[0].max(ends[1]) + 1;
            if nearest >= self.levels[0].cells[tile_y * self.levels[0].width + tile_x].farthest {
                keep_nearest(self.samples.row(y, start, end), start, y, triangle);
                self.samples.count(y, start, end, triangle.owner);
                self.mark(tile_x, tile_y);
            }
            start = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pyramid over 40×24 samples, with these rectangles at these nearnesses in it.
    fn pyramid(drawn: &[(Rect, f32)]) -> Depths {
        let mut depths = Depths::default();
        depths.samples.rect = Rect {
            x0: 0,
            y0: 0,
            x1: 40,
            y1: 24,
        };
        depths.samples.width = 40;
        depths.samples.samples = vec![0; 40 * 24];
        depths.clear(false);
        for (rect, near) in drawn {
            for y in rect.y0..rect.y1 {
                for x in rect.x0..rect.x1 {
                    let sample = &mut depths.samples.row(y, x, x + 1)[0];
                    *sample = (*sample).max(Sample::from(near.to_bits()) << 32);
                    depths.mark(usize::from(x) / TILE, usize::from(y) / TILE);
                }
            }
        }
        depths
    }

    fn rect(x0: u16, y0: u16, x1: u16, y1: u16) -> Rect {
        Rect { x0, y0, x1, y1 }
    }

    #[test]
    fn a_box_is_hidden_only_where_all_before_it_is_strictly_nearer() {
        let wall = rect(3, 2, 37, 22);
        let mut depths = pyramid(&[(wall, 0.5)]);
        let cases = [
            (wall, 0.4, false),
            (wall, 0.5, true),
            (wall, 0.6, true),
            (rect(2, 2, 37, 22), 0.4, true),
            (rect(3, 2, 37, 23), 0.4, true),
            (rect(20, 20, 21, 21), 0.4, false),
            (rect(0, 0, 40, 24), 0.4, true),
        ];
        for (rect, nearest, seen) in cases {
            assert_eq!(
                depths.sees(&rect, f32::to_bits(nearest)),
                seen,
                "{rect:?} at {nearest}"
            );
        }
    }

    #[test]
    fn a_pinhole_in_a_wall_is_found_at_every_place() {
        for y in 0..24 {
            for x in 0..40 {
                let all = rect(0, 0, 40, 24);
                let mut depths = pyramid(&[(all, 0.5)]);
                depths.samples.row(y, x, x + 1)[0] = 0;
                assert!(depths.sees(&all, f32::to_bits(0.4)), "hole at {x}, {y}");
                depths.samples.row(y, x, x + 1)[0] = Sample::MAX;
                depths.clear(true);
                assert!(!depths.sees(&all, f32::to_bits(0.4)), "no hole at {x}, {y}");
            }
        }
    }
}
