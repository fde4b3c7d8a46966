//! Depth buffer in tiles of 8×8 samples that are expanded only when needed.
//!
//! A tile is empty, or fully owned by one triangle, or stored sample by sample. In pictures of walls most tiles are of
//! the second kind: 64 samples are decided by two depths. Expanding a tile later gives the same bits as storing its
//! samples from the start.

pub(super) use super::block::TILE_SHIFT;
use super::block::{Block, TILE};
use crate::cover::report::Report;
use crate::cover::samples::{COVERED, OPEN, lower_half, rev_depth};
use crate::cover::trace::Trace;
use crate::raster::{BAND, Band, Triangle};
use crate::simd::dispatch;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use fearless_simd::Level;
use std::cmp::Ordering;

const _: () = assert!(TILE == BAND);

/// The tiles of a passage's rectangle, in row-major order.
pub(super) struct Tiles {
    level: Level,
    /// Bounding rectangle of the aperture. Samples of a tile outside it are covered.
    pub(super) rect: Rect,
    pub(super) columns: usize,
    /// The first stored row of tiles; `rows` is the end row (exclusive).
    first_row: usize,
    pub(super) rows: usize,
    tiles: Vec<Tile>,
    /// Samples of the expanded tiles, by tile index.
    blocks: Vec<Block>,
    /// Triangles that own whole tiles.
    triangles: Vec<Triangle>,
    /// Open runs of the current row. `open` has, for each row of tiles, the columns that are open in all of its rows.
    runs: Vec<[u16; 2]>,
    open: Vec<[u16; 2]>,
    pub(super) trace: Option<Trace>,
}

impl Default for Tiles {
    fn default() -> Tiles {
        Tiles {
            level: crate::simd::level(),
            rect: Rect::default(),
            columns: 0,
            first_row: 0,
            rows: 0,
            tiles: Vec::new(),
            blocks: Vec::new(),
            triangles: Vec::new(),
            runs: Vec::new(),
            open: Vec::new(),
            trace: None,
        }
    }
}

/// State and farthest depth of a tile.
#[derive(Clone, Copy)]
struct Tile {
    state: State,
    /// Bits of the farthest reversed depth in the tile; never nearer than the truth.
    farthest: u32,
    /// Whether a sample may have become nearer since `farthest` was computed.
    stale: bool,
}

/// Representation of a tile.
#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// No face covers the tile.
    Empty,
    /// One triangle, by its index in [`Tiles::triangles`], owns the whole tile.
    Whole(u32),
    /// Samples are stored in [`Tiles::blocks`].
    Written,
}

impl Tiles {
    /// Clears all tiles and opens the samples of the passage's aperture. If `trace` is `true`, counts the work per
    /// sample.
    pub(super) fn clear(&mut self, passage: &Passage, trace: bool) {
        self.rect = passage.aperture.rect();
        self.trace = trace.then(|| Trace::new(&self.rect));
        let Rect { x0, x1, y0, y1 } = self.rect;
        [self.columns, self.rows] = [x1, y1].map(|side| usize::from(side).div_ceil(TILE));
        self.first_row = usize::from(y0) >> TILE_SHIFT;
        self.tiles.clear();
        self.tiles.resize(
            self.columns * (self.rows - self.first_row),
            Tile {
                state: State::Empty,
                farthest: 0,
                stale: false,
            },
        );
        if self.blocks.len() < self.tiles.len() {
            self.blocks.resize(self.tiles.len(), Block::OPEN);
        }
        self.triangles.clear();
        // Behind a portal some samples are covered from the start, and a trace counts every sample; both need expanded
        // tiles.
        if passage.is_unclipped() && !trace {
            return;
        }
        self.tiles.fill(Tile {
            state: State::Written,
            farthest: 0,
            stale: true,
        });
        self.blocks[..self.tiles.len()].fill(Block::COVERED);
        self.open.clear();
        self.open.resize(self.rows, [x0, x1]);
        for y in y0..y1 {
            passage.aperture.open_in_row(y, &mut self.runs);
            let row = usize::from(y) >> TILE_SHIFT;
            let band = &mut self.open[row];
            *band = match *self.runs {
                [[start, end]] => [band[0].max(start), band[1].min(end)],
                _ => [x1, x0],
            };
            for &[start, end] in &self.runs {
                for x in usize::from(start)..usize::from(end) {
                    let index = self.index(x >> TILE_SHIFT, row);
                    let block = &mut self.blocks[index];
                    block.0[usize::from(y) % TILE][x % TILE] = OPEN;
                }
            }
        }
        if trace {
            return;
        }
        for row in self.first_row..self.rows {
            let open = self.open[row];
            for column in usize::from(x0) >> TILE_SHIFT..self.columns {
                let tile = self.rect(column, row);
                if open[0] <= tile.x0 && tile.x1 <= open[1] {
                    let index = self.index(column, row);
                    self.tiles[index] = Tile {
                        state: State::Empty,
                        farthest: 0,
                        stale: false,
                    };
                }
            }
        }
    }

    /// Returns the index of a tile. Storage starts at the first row of the rectangle, so that a strip at the bottom of
    /// the screen takes no more memory than one at the top.
    #[inline(always)]
    fn index(&self, column: usize, row: usize) -> usize {
        (row - self.first_row) * self.columns + column
    }

    /// Returns the samples of a tile inside the aperture's rectangle.
    #[inline(always)]
    fn rect(&self, column: usize, row: usize) -> Rect {
        let [x0, y0] = [(column << TILE_SHIFT) as u16, (row << TILE_SHIFT) as u16];
        Rect {
            x0,
            y0,
            x1: x0 + TILE as u16,
            y1: y0 + TILE as u16,
        }
        .intersection(&self.rect)
    }

    /// Depth-tests a triangle over one band of rows and makes it the owner of the samples at which it is nearest. Calls
    /// `nearer` for each tile in which a sample may have become nearer.
    #[inline(always)]
    pub(super) fn keep_nearest(
        &mut self,
        band: &Band,
        triangle: &Triangle,
        mut nearer: impl FnMut(usize, usize),
    ) {
        let row = usize::from(band.y) >> TILE_SHIFT;
        let mut any = [u16::MAX, 0];
        for (_, [start, end]) in band.rows() {
            any = [any[0].min(start), any[1].max(end)];
        }
        let columns = usize::from(any[0]) >> TILE_SHIFT..=(usize::from(any[1]) - 1) >> TILE_SHIFT;
        if usize::from(any[1] - any[0]) < TILE {
            // Too narrow to own a whole tile, as most triangles of a detailed mesh are.
            for column in columns {
                if triangle.nearest() >= self.tiles[self.index(column, row)].farthest {
                    self.keep_nearest_in(column, row, band, triangle, &mut nearer);
                }
            }
            return;
        }
        // Columns that the triangle covers in all rows of the rectangle.
        let Rect { x0, y0, x1, y1 } = self.rect;
        let mut all = [x0, x1];
        for (y, &[start, end]) in (band.y..).zip(&band.runs) {
            if (y0..y1).contains(&y) {
                all = [all[0].max(start), all[1].min(end)];
            }
        }
        // Depth is linear on the screen, so its extremes are at corners.
        let [right, down] = [triangle.rev_depth.x > 0.0, triangle.rev_depth.y > 0.0];
        let [top, bottom] = [y0.max(band.y), y1.min(band.y + TILE as u16) - 1];
        let nearest_row = triangle.row(if down { bottom } else { top });
        let farthest_row = triangle.row(if down { top } else { bottom });
        let mut number = None;
        for column in columns {
            let rect = self.rect(column, row);
            let nearest = nearest_row.bits(i32::from(if right { rect.x1 - 1 } else { rect.x0 }));
            let index = self.index(column, row);
            let whole = all[0] <= rect.x0 && all[1] >= rect.x1;
            if whole && self.tiles[index].stale {
                // Recomputing the farthest depth costs less than a fruitless depth test of all samples.
                let farthest = self.blocks[index].farthest();
                self.tiles[index] = Tile {
                    farthest,
                    stale: false,
                    ..self.tiles[index]
                };
            }
            if nearest < self.tiles[index].farthest {
                continue;
            }
            let owns_it = match self.tiles[index].state {
                State::Empty => whole,
                State::Written => false,
                State::Whole(theirs) => match triangle.compare_depth(&self.triangles[theirs as usize], &rect)
                {
                    Some(Ordering::Less) => continue,
                    Some(Ordering::Greater) => whole,
                    _ => false,
                },
            };
            if !owns_it {
                self.keep_nearest_in(column, row, band, triangle, &mut nearer);
                continue;
            }
            let number = *number.get_or_insert_with(|| {
                self.triangles.push(*triangle);
                self.triangles.len() as u32 - 1
            });
            let farthest = farthest_row.bits(i32::from(if right { rect.x0 } else { rect.x1 - 1 }));
            self.tiles[index] = Tile {
                state: State::Whole(number),
                farthest,
                stale: false,
            };
            nearer(column, row);
        }
    }

    /// Depth-tests the triangle in one tile, sample by sample.
    #[inline(always)]
    fn keep_nearest_in(
        &mut self,
        column: usize,
        row: usize,
        band: &Band,
        triangle: &Triangle,
        nearer: &mut impl FnMut(usize, usize),
    ) {
        let index = self.index(column, row);
        if self.tiles[index].state != State::Written {
            self.expand(column, row);
        }
        let x = (column << TILE_SHIFT) as u16;
        let block = &mut self.blocks[index];
        for (place, y) in (band.y..).take(BAND).enumerate() {
            let run = band.runs[place];
            if run[0] < run[1] {
                block.keep_nearest(place, x, run, &triangle.row(y), triangle.owner);
            }
        }
        if self.trace.is_some() {
            self.count(column, row, band, triangle.owner);
        }
        if !self.tiles[index].stale {
            self.tiles[index].stale = true;
            nearer(column, row);
        }
    }

    /// Expands a tile to samples.
    #[inline(always)]
    fn expand(&mut self, column: usize, row: usize) {
        let index = self.index(column, row);
        let state = std::mem::replace(&mut self.tiles[index].state, State::Written);
        let block = &mut self.blocks[index];
        let [x, y] = [column, row].map(|place| (place << TILE_SHIFT) as u16);
        match state {
            State::Whole(number) => block.fill(x, y, &self.triangles[number as usize]),
            _ => *block = Block::OPEN,
        }
        let within = self.rect(column, row);
        if [within.x1 - within.x0, within.y1 - within.y0] != [TILE as u16; 2] {
            self.cover_outside(index, [x, y], &within);
        }
    }

    /// Covers the samples of a tile outside the aperture's rectangle. The tile's first column and row are `x` and `y`.
    #[cold]
    fn cover_outside(&mut self, index: usize, [x, y]: [u16; 2], within: &Rect) {
        for (y, samples) in (y..).zip(&mut self.blocks[index].0) {
            for (x, sample) in (x..).zip(samples) {
                if !((within.x0..within.x1).contains(&x) && (within.y0..within.y1).contains(&y)) {
                    *sample = COVERED;
                }
            }
        }
    }

    /// Counts a depth test for each sample of a band in one tile; samples that `owner` owns are attributed to the
    /// current batch.
    #[cold]
    fn count(&mut self, column: usize, row: usize, band: &Band, owner: u32) {
        let Rect { x0, x1, .. } = self.rect(column, row);
        let (block, Some(trace)) = (&self.blocks[self.index(column, row)], &mut self.trace) else {
            return;
        };
        for (y, [start, end]) in band.rows() {
            let [start, end] = [start.max(x0), end.min(x1).max(start.max(x0))];
            trace.test(y, start, end);
            for x in start..end {
                let sample = block.0[usize::from(y) % TILE][usize::from(x) % TILE];
                if sample as u32 == lower_half(owner) {
                    trace.own(y, x, x + 1, trace.batch);
                }
            }
        }
    }

    /// Begins a new batch of faces.
    pub(super) fn begin_batch(&mut self) {
        if let Some(trace) = &mut self.trace {
            trace.batch += 1;
        }
    }

    /// Returns the bits of the farthest reversed depth of a tile as last computed, without reading its samples; never
    /// nearer than the truth.
    #[inline(always)]
    pub(super) fn farthest_known(&self, column: usize, row: usize) -> u32 {
        self.tiles[self.index(column, row)].farthest
    }

    /// Returns the bits of the farthest reversed depth of a tile, recomputed if stale.
    pub(super) fn farthest(&mut self, column: usize, row: usize) -> u32 {
        if row < self.first_row {
            return u32::MAX;
        }
        let index = self.index(column, row);
        if self.tiles[index].stale {
            let farthest = self.farthest_in(&self.rect(column, row), column, row);
            self.tiles[index] = Tile {
                farthest,
                stale: false,
                ..self.tiles[index]
            };
        }
        self.tiles[index].farthest
    }

    /// Returns the bits of the farthest reversed depth among the samples of a tile inside `rect`.
    pub(super) fn farthest_in(&self, rect: &Rect, column: usize, row: usize) -> u32 {
        let within = self.rect(column, row).intersection(rect);
        if within.is_empty() {
            // Tiles outside the aperture's rectangle: nothing is visible there.
            return u32::MAX;
        }
        let Rect { x0, y0, x1, y1 } = within;
        match self.tiles[self.index(column, row)].state {
            State::Empty => 0,
            State::Whole(number) => {
                let triangle = &self.triangles[number as usize];
                let x = if triangle.rev_depth.x > 0.0 { x0 } else { x1 - 1 };
                triangle
                    .row(if triangle.rev_depth.y > 0.0 { y0 } else { y1 - 1 })
                    .bits(i32::from(x))
            }
            State::Written => {
                let block = &self.blocks[self.index(column, row)];
                if within == self.rect(column, row) {
                    return dispatch!(self.level, _simd => block.farthest());
                }
                let [columns, rows] = [[x0, x1 - 1], [y0, y1 - 1]]
                    .map(|[first, last]| [usize::from(first) % TILE, usize::from(last) % TILE + 1]);
                dispatch!(self.level, _simd => block.farthest_in(columns, rows))
            }
        }
    }

    /// Returns the bits of the reversed depth at a sample.
    pub(super) fn depth(&self, x: u16, y: u16) -> u32 {
        let index = self.index(usize::from(x) >> TILE_SHIFT, usize::from(y) >> TILE_SHIFT);
        match self.tiles[index].state {
            State::Empty => 0,
            State::Whole(number) => self.triangles[number as usize].row(y).bits(i32::from(x)),
            State::Written => rev_depth(self.blocks[index].0[usize::from(y) % TILE][usize::from(x) % TILE]),
        }
    }

    /// Returns the number of the face that owns a whole tile, if that is known without reading its samples.
    pub(super) fn owner(&self, column: usize, row: usize) -> Option<u32> {
        match self.tiles[self.index(column, row)].state {
            State::Whole(number) => Some(self.triangles[number as usize].owner),
            State::Empty | State::Written => None,
        }
    }

    /// Returns the memory in bytes for a screen of `size` (width, height) pixels.
    pub(super) fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = u64::from(size[0].div_ceil(TILE as u32)) * u64::from(size[1].div_ceil(TILE as u32));
        tiles * (size_of::<Tile>() + size_of::<Block>() + size_of::<Triangle>()) as u64
    }

    /// Reports all owners: tile by tile, or row by row if the report needs runs.
    pub(super) fn report(&self, report: &mut Report) {
        if report.wants_rows() {
            self.report_rows(report);
        } else {
            dispatch!(self.level, _simd => self.report_tiles(report));
        }
    }

    #[inline(always)]
    fn report_tiles(&self, report: &mut Report) {
        let Rect { x0, y0, x1, y1 } = self.rect;
        for row in usize::from(y0) >> TILE_SHIFT..usize::from(y1).div_ceil(TILE) {
            for column in usize::from(x0) >> TILE_SHIFT..usize::from(x1).div_ceil(TILE) {
                let index = self.index(column, row);
                match self.tiles[index].state {
                    State::Empty => {}
                    State::Whole(number) => {
                        let Rect { x0, y0, x1, y1 } = self.rect(column, row);
                        let samples = u64::from(x1 - x0) * u64::from(y1 - y0);
                        report.some(lower_half(self.triangles[number as usize].owner), samples);
                    }
                    State::Written => {
                        for samples in &self.blocks[index].0 {
                            report.eight(samples);
                        }
                    }
                }
            }
        }
    }

    fn report_rows(&self, report: &mut Report) {
        let Rect { x0, y0, x1, y1 } = self.rect;
        for y in y0..y1 {
            let row = usize::from(y) >> TILE_SHIFT;
            for column in usize::from(x0) >> TILE_SHIFT..usize::from(x1).div_ceil(TILE) {
                let Rect { x0, x1, .. } = self.rect(column, row);
                let index = self.index(column, row);
                match self.tiles[index].state {
                    State::Empty => report.run(x0, x1, OPEN as u32),
                    State::Whole(number) => {
                        report.run(x0, x1, lower_half(self.triangles[number as usize].owner));
                    }
                    State::Written => {
                        let samples = &self.blocks[index].0[usize::from(y) % TILE];
                        let first = usize::from(x0) % TILE;
                        report.samples(x0, &samples[first..first + usize::from(x1 - x0)]);
                    }
                }
            }
            report.end_row(y, &self.rect, self.trace.as_ref());
        }
    }
}
