//! Tiles of 8×8 samples that cost nothing until they need their samples.
//!
//! A tile is empty, or one triangle owns all of it, or its samples are written out. Most tiles of a picture of walls
//! are of the second kind: 64 samples are decided by two depths. What is written out later is the same, bit for bit.

mod report;

pub(super) use super::block::TILE_SHIFT;
use super::block::{Block, TILE};
use super::raster::{BAND, Band};
use super::samples::{COVERED, OPEN, lower_half, rev_depth};
use super::trace::Trace;
use super::triangle::Triangle;
use crate::aperture::Rect;
use crate::passage::Passage;
use fearless_simd::{Level, dispatch};
use std::cmp::Ordering;

const _: () = assert!(TILE == BAND);

pub(super) struct Tiles {
    level: Level,
    /// The aperture's rectangle. What a tile holds beside it is covered.
    pub(super) rect: Rect,
    pub(super) columns: usize,
    /// The row of tiles that is kept first, and the one after the last.
    first_row: usize,
    pub(super) rows: usize,
    tiles: Vec<Tile>,
    /// The samples of tiles that are written out.
    blocks: Vec<Block>,
    /// Triangles that own whole tiles.
    triangles: Vec<Triangle>,
    /// The open runs of a row, and for each row of tiles the columns that are open in all its rows.
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

#[derive(Clone, Copy)]
struct Tile {
    state: State,
    /// Bits of the farthest reversed depth in it; never nearer than the truth.
    farthest: u32,
    /// May a sample have come nearer since `farthest` was known?
    stale: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// Nothing is in it.
    Empty,
    /// A triangle, by its place in [`Tiles::triangles`], owns all of it.
    Whole(u32),
    /// See the samples.
    Written,
}

impl Tiles {
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
        // Behind a portal some samples are covered from the start, and a trace wants each sample.
        if passage.parent.is_none() && !trace {
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

    /// Where a tile is kept: from the first row on, for a strip far down is as small as one on top.
    #[inline(always)]
    fn index(&self, column: usize, row: usize) -> usize {
        (row - self.first_row) * self.columns + column
    }

    /// The samples of a tile inside the aperture's rectangle.
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

    /// Lets a triangle own those samples of a band at which it is nearest. `nearer` is told of each tile in which a
    /// sample may have come nearer.
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
            // Too narrow to own a tile; most triangles of a detailed mesh are.
            for column in columns {
                if triangle.nearest() >= self.tiles[self.index(column, row)].farthest {
                    self.keep_nearest_in(column, row, band, triangle, &mut nearer);
                }
            }
            return;
        }
        // The columns that all rows of the rectangle hold.
        let Rect { x0, y0, x1, y1 } = self.rect;
        let mut all = [x0, x1];
        for (y, &[start, end]) in (band.y..).zip(&band.runs) {
            if (y0..y1).contains(&y) {
                all = [all[0].max(start), all[1].min(end)];
            }
        }
        // Linear, so nearest and farthest at corners.
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
                // To bring it up to date costs less than going through all its samples for nothing.
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
                State::Whole(theirs) => match triangle.beside(&self.triangles[theirs as usize], &rect) {
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

    /// The same in one tile, sample by sample.
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
            self.write_out(column, row);
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

    /// Writes the samples of a tile out.
    #[inline(always)]
    fn write_out(&mut self, column: usize, row: usize) {
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
            self.cover_beside(index, [x, y], &within);
        }
    }

    /// Covers what a tile, whose first column and row are given, holds beside the aperture's rectangle.
    #[cold]
    fn cover_beside(&mut self, index: usize, [x, y]: [u16; 2], within: &Rect) {
        for (y, samples) in (y..).zip(&mut self.blocks[index].0) {
            for (x, sample) in (x..).zip(samples) {
                if !((within.x0..within.x1).contains(&x) && (within.y0..within.y1).contains(&y)) {
                    *sample = COVERED;
                }
            }
        }
    }

    /// Counts a test of each sample of a band in one tile; those that `owner` owns came with the batch at hand.
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

    /// A new batch of faces begins.
    pub(super) fn begin_batch(&mut self) {
        if let Some(trace) = &mut self.trace {
            trace.batch += 1;
        }
    }

    /// Bits of the farthest reversed depth of a tile that is known without looking at samples; no nearer than the truth.
    #[inline(always)]
    pub(super) fn farthest_known(&self, column: usize, row: usize) -> u32 {
        self.tiles[self.index(column, row)].farthest
    }

    /// Bits of the farthest reversed depth of a tile.
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

    /// Bits of the farthest reversed depth among the samples of a tile inside `rect`.
    pub(super) fn farthest_in(&self, rect: &Rect, column: usize, row: usize) -> u32 {
        let within = self.rect(column, row).intersection(rect);
        if within.is_empty() {
            // Tiles beside the aperture's rectangle: nothing is seen there.
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

    /// Bits of the reversed depth at a sample.
    pub(super) fn depth(&self, x: u16, y: u16) -> u32 {
        let index = self.index(usize::from(x) >> TILE_SHIFT, usize::from(y) >> TILE_SHIFT);
        match self.tiles[index].state {
            State::Empty => 0,
            State::Whole(number) => self.triangles[number as usize].row(y).bits(i32::from(x)),
            State::Written => rev_depth(self.blocks[index].0[usize::from(y) % TILE][usize::from(x) % TILE]),
        }
    }

    /// The number of the face that owns a tile as a whole, where that is known without looking at its samples.
    pub(super) fn owner(&self, column: usize, row: usize) -> Option<u32> {
        match self.tiles[self.index(column, row)].state {
            State::Whole(number) => Some(self.triangles[number as usize].owner),
            State::Empty | State::Written => None,
        }
    }

    /// Memory in bytes for a screen of this size.
    pub(super) fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = u64::from(size[0].div_ceil(TILE as u32)) * u64::from(size[1].div_ceil(TILE as u32));
        tiles * (size_of::<Tile>() + size_of::<Block>() + size_of::<Triangle>()) as u64
    }
}
