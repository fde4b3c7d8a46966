//! Tests faces against the tiles, and resolves items of which few samples pass by a depth buffer of these samples.
//!
//! A sub-tile stores two depths for 32 samples, so some samples of a hidden item pass. An item with many passing samples
//! is taken for visible. One with a few is doubtful: the sub-tiles with its samples are rasterized again, with a depth
//! for each sample, from the occluders found during the traversal. The item is hidden if it is behind them everywhere.
//! Source: original to this library.
//! Cost: a face O(tiles it overlaps); a doubtful item O(samples that pass), at most the limit; rasterizing again
//!     O(vertices of the occluders in front of a doubtful sub-tile) + O(sub-tiles).
//! Conservative: depths of tested faces are rounded towards the eye, those of occluders away from it, and equal depths
//!     count as visible, so no face hides itself.

use super::occluder::Slope;
use super::tiles::{
    ACROSS, BandTiles, COLUMNS, Grid, ROWS, SUB_COLUMNS, SUB_ROWS, SUB_TILES, SUB_TILES_OF_BAND,
    columns_within, rows_within, tiles,
};
use crate::faces::{FaceSource, Faces};
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::raster::{BAND, Band, Corner, Raster, Sink, Triangle, greater, smaller};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::options::Tightness;
use crate::view::passage::Passage;
use crate::view::region::{ROUND_UP, Region, Visibility};
use fearless_simd::Level;
use glam::DVec3;

/// Samples of a sub-tile.
const SAMPLES: usize = SUB_COLUMNS * SUB_ROWS;

/// Maximum number of passing samples of a doubtful item, as a part of the samples of the screen. More are seldom all
/// hidden.
const DOUBTFUL_PART: f64 = 14_400.0;

/// The same on a small screen.
const FEWEST_DOUBTFUL: f64 = 32.0;

/// Maximum part of the samples of a visible item that one triangle is estimated to have: only its centre is tested.
const LARGEST_PART: f64 = 0.25;

/// Columns and rows of a small triangle, which is tested by the rectangle around it.
const LARGEST_BOUNDED: u16 = 8;

/// Maximum number of doubtful sub-tiles, as a multiple of the number of tiles. Items in others are kept.
const BLOCKS_PER_TILE: usize = 4;

const THIRD: f64 = 1.0 / 3.0;

/// Factor that lowers reversed depth before it is stored: covers the rounding to f32.
const ROUND_DOWN: f64 = 1.0 - 1.0 / (1_u64 << 22) as f64;

/// Tests the faces of items, and resolves doubtful ones.
pub(super) struct Resolver {
    raster: Raster,
    /// The clusters rasterized as occluders, in order: mostly front to back.
    occluders: Vec<FoundOccluder>,
    /// Triangles with passing samples, and these.
    triangles: Vec<TestedTriangle>,
    passing: Vec<PassingSamples>,
    doubtful: Vec<DoubtfulItem>,
    /// The current item.
    item: ItemIndex,
    /// Number of passing samples of the current item, in part an estimate, and the maximum for a doubtful one.
    count: f64,
    limit: f64,
    depths: Depths,
}

/// Tests items by their faces against a finished cover: first all items, one after the other, then the doubtful ones.
pub struct ItemTest<'a> {
    grid: &'a Grid,
    resolver: &'a mut Resolver,
}

impl<'a> ItemTest<'a> {
    pub(super) fn new(grid: &'a Grid, resolver: &'a mut Resolver) -> ItemTest<'a> {
        ItemTest { grid, resolver }
    }

    /// Begins an item.
    pub(crate) fn begin_item(&mut self, passage: &Passage) {
        self.resolver.begin_item(passage);
    }

    /// Tests faces of the current item: `Hidden` if no sample of them passes, `Partial` if any does, `Full` if the item has
    /// more than a doubtful one, and is to be kept.
    pub(crate) fn test_faces(&mut self, faces: &Faces, passage: &Passage) -> Visibility {
        self.resolver.test_faces(self.grid, faces, passage)
    }

    /// Adds the current item to the doubtful ones, which are numbered from 0.
    pub(crate) fn end_doubtful(&mut self) {
        self.resolver.end_doubtful();
    }

    /// Finds out which of the doubtful items may be visible.
    pub(crate) fn resolve(&mut self, geometry: &Geometry, passage: &Passage) {
        self.resolver.resolve(self.grid, geometry, passage);
    }

    /// Returns `true` if a doubtful item may be visible. Call it after [`ItemTest::resolve`].
    pub(crate) fn is_visible(&mut self, number: usize, geometry: &Geometry, passage: &Passage) -> bool {
        self.resolver.is_visible(number, self.grid, geometry, passage)
    }
}

/// A cluster that was rasterized as an occluder, or of which the mesh node was too fine, and its bounds on the screen.
struct FoundOccluder {
    item: ItemIndex,
    cluster: u32,
    /// Whether the bounds are those of a mesh node with several clusters.
    is_fine: bool,
    rect: Rect,
    nearest: f32,
}

/// A doubtful item, and the ends of its samples and triangles.
#[derive(Clone, Copy)]
struct DoubtfulItem {
    item: ItemIndex,
    passing: usize,
    triangles: usize,
}

/// A triangle with passing samples.
#[derive(Clone, Copy)]
struct TestedTriangle {
    cluster: u32,
    shape: TestedShape,
}

/// What is known of a tested triangle.
#[derive(Clone, Copy)]
enum TestedShape {
    /// It owns all of its samples.
    Exact(Triangle),
    /// Its corners as (X, Y, W): it may own samples of the rectangle around it, and is nowhere nearer than this reversed
    /// depth.
    Bounded([DVec3; 3], f32),
}

/// Samples of a triangle in one sub-tile that the tiles do not hide.
#[derive(Clone, Copy)]
struct PassingSamples {
    /// Index of the tile, times [`SUB_TILES`], plus that of the sub-tile.
    sub_tile: u32,
    mask: u32,
    /// Index in [`Resolver::triangles`].
    triangle: u32,
}

/// A depth for each sample of the doubtful sub-tiles.
#[derive(Default)]
struct Depths {
    /// For each tile a lower bound of [`Block::worth`]; infinite if no sub-tile is doubtful.
    worth: Vec<f32>,
    /// For each tile a bit for each doubtful sub-tile.
    doubtful: Vec<u16>,
    /// For each band of rows whether any sub-tile in it is doubtful.
    bands: Vec<bool>,
    /// For each sub-tile the index of its block; meaningless unless it is doubtful.
    places: Vec<u32>,
    blocks: Vec<Block>,
}

/// The samples of a doubtful sub-tile, row by row.
#[derive(Clone, Copy)]
struct Block {
    /// Below this reversed depth an occluder hides no doubtful sample.
    worth: f32,
    /// The doubtful samples that are not hidden yet.
    open: u32,
    /// Reversed depths of the occluders, never above the true ones.
    depths: [f32; SAMPLES],
    /// Minimum and maximum reversed depth of the doubtful items at each sample.
    farthest: [f32; SAMPLES],
    nearest: [f32; SAMPLES],
}

impl Block {
    const EMPTY: Block = Block {
        worth: f32::INFINITY,
        open: 0,
        depths: [0.0; SAMPLES],
        farthest: [f32::INFINITY; SAMPLES],
        nearest: [0.0; SAMPLES],
    };

    /// Returns `true` if a triangle may hide a doubtful sample. `x` and `y` are the column and row of the first sample.
    #[inline(always)]
    fn gains(&self, triangle: &Triangle, [x, y]: [u16; 2]) -> bool {
        let slope = triangle.rev_depth;
        let last = [SUB_COLUMNS as f64 - 1.0, SUB_ROWS as f64 - 1.0];
        let nearest =
            triangle.row(y).beyond(x) + greater(slope.x * last[0], 0.0) + greater(slope.y * last[1], 0.0);
        nearest > f64::from(self.worth) && triangle.greatest > f64::from(self.worth)
    }

    /// Stores the reversed depths of a face, rounded down, at the samples at which it is nearer. `x` and `y` are the
    /// column and row of the first sample.
    #[inline(always)]
    fn store(&mut self, mask: u32, triangle: &Triangle, rounding: f64, [x, y]: [u16; 2]) {
        for (row, stored) in (0..).zip(self.depths.as_chunks_mut::<SUB_COLUMNS>().0) {
            let depths = triangle.row(y + row);
            let bits = mask >> (usize::from(row) * SUB_COLUMNS);
            for (column, stored) in (0..).zip(stored) {
                let rev_depth = ((depths.at(x + column) - rounding) * ROUND_DOWN) as f32;
                let covered = bits >> column & 1 != 0;
                // Subnormal numbers round more coarsely, so they are left out.
                *stored = if covered & (rev_depth > *stored) & (rev_depth >= f32::MIN_POSITIVE) {
                    rev_depth
                } else {
                    *stored
                };
            }
        }
        let mut worth = f32::INFINITY;
        let mut open = 0;
        for sample in 0..SAMPLES {
            let stored = self.depths[sample];
            let is_open = stored <= self.nearest[sample];
            open |= u32::from(is_open) << sample;
            let farthest = self.farthest[sample].max(stored);
            worth = if is_open & (farthest < worth) {
                farthest
            } else {
                worth
            };
        }
        self.open &= open;
        self.worth = if self.open == 0 { f32::INFINITY } else { worth };
    }
}

impl Resolver {
    pub(super) fn at(level: Level) -> Resolver {
        Resolver {
            raster: Raster::at(level),
            occluders: Vec::new(),
            triangles: Vec::new(),
            passing: Vec::new(),
            doubtful: Vec::new(),
            item: ItemIndex(0),
            count: 0.0,
            limit: 0.0,
            depths: Depths::default(),
        }
    }

    /// Bytes for each tile.
    pub(super) const BYTES_PER_TILE: usize = size_of::<Block>() * BLOCKS_PER_TILE
        + size_of::<u32>() * SUB_TILES
        + size_of::<f32>()
        + size_of::<u16>();

    /// Forgets all occluders and items.
    pub(super) fn clear(&mut self) {
        self.occluders.clear();
        self.triangles.clear();
        self.passing.clear();
        self.doubtful.clear();
    }

    /// Notes clusters of an item within `region` that may be occluders.
    pub(super) fn note_occluders(&mut self, item: ItemIndex, clusters: &[u32], region: &Region) {
        self.occluders
            .extend(clusters.iter().map(|&cluster| FoundOccluder {
                item,
                cluster,
                is_fine: clusters.len() > 1,
                rect: region.rect,
                nearest: region.nearest,
            }));
    }

    /// Begins an item. Unless doubtful items are resolved, one passing sample is enough to keep it.
    fn begin_item(&mut self, passage: &Passage) {
        let [width, height] = passage.size;
        self.count = 0.0;
        self.limit = if passage.options.tightness == Tightness::Resolved {
            (f64::from(width) * f64::from(height) / DOUBTFUL_PART).max(FEWEST_DOUBTFUL)
        } else {
            0.0
        };
        self.drop_undecided();
    }

    /// Removes the samples and faces after the last doubtful item.
    fn drop_undecided(&mut self) {
        let last = self.doubtful.last();
        self.passing.truncate(last.map_or(0, |last| last.passing));
        self.triangles.truncate(last.map_or(0, |last| last.triangles));
    }

    /// See [`ItemTest::test_faces`].
    fn test_faces(&mut self, grid: &Grid, faces: &Faces, passage: &Passage) -> Visibility {
        let FaceSource::Item(item, cluster) = faces.source else {
            return Visibility::Full;
        };
        self.item = item;
        let before = self.passing.len();
        let mut sink = PassingSink {
            grid,
            cluster,
            has_entry: passage.entry.is_some(),
            limit: self.limit,
            count: &mut self.count,
            triangles: &mut self.triangles,
            passing: &mut self.passing,
            slope: None,
        };
        self.raster.run(faces, passage, &mut sink, &mut Stats::default());
        if self.count > self.limit {
            Visibility::Full
        } else if self.passing.len() > before {
            Visibility::Partial
        } else {
            Visibility::Hidden
        }
    }

    /// See [`ItemTest::end_doubtful`].
    fn end_doubtful(&mut self) {
        self.doubtful.push(DoubtfulItem {
            item: self.item,
            passing: self.passing.len(),
            triangles: self.triangles.len(),
        });
    }

    /// Rasterizes the sub-tiles of doubtful items with a depth for each sample.
    fn resolve(&mut self, grid: &Grid, geometry: &Geometry, passage: &Passage) {
        self.drop_undecided();
        if self.doubtful.is_empty() {
            return;
        }
        self.depths.begin(grid, &self.passing, &self.triangles);
        for occluder in &self.occluders {
            if !self.depths.gains(grid, &occluder.rect, occluder.nearest) {
                continue;
            }
            let screen_from_item = passage.screen_from(&geometry.item(occluder.item).transform());
            let faces = Faces::of_cluster(geometry, occluder.item, occluder.cluster, &screen_from_item);
            if !faces.can_occlude {
                continue;
            }
            if occluder.is_fine {
                let bounds = &geometry.mesh_of(occluder.item).clusters()[occluder.cluster as usize].bounds;
                let own = Region::of(passage, &screen_from_item, bounds);
                if own.is_none_or(|own| !self.depths.gains(grid, &own.rect, own.nearest)) {
                    continue;
                }
            }
            let mut sink = DepthSink {
                grid,
                depths: &mut self.depths,
                rounding: 0.0,
            };
            self.raster.run(&faces, passage, &mut sink, &mut Stats::default());
        }
    }

    /// Returns `true` if any sample of a doubtful item may be visible, by its number.
    fn is_visible(&mut self, number: usize, grid: &Grid, geometry: &Geometry, passage: &Passage) -> bool {
        let first = number
            .checked_sub(1)
            .map_or(0, |before| self.doubtful[before].passing);
        let DoubtfulItem { item, passing, .. } = self.doubtful[number];
        let screen_from_item = passage.screen_from(&geometry.item(item).transform());
        for samples in &self.passing[first..passing] {
            let mask = self.depths.shown(grid, samples, &self.triangles);
            if mask == 0 {
                continue;
            }
            let TestedTriangle { cluster, shape } = &self.triangles[samples.triangle as usize];
            let (TestedShape::Bounded(corners, _), Some(block)) =
                (shape, self.depths.block(samples.sub_tile))
            else {
                return true;
            };
            let mut sink = ShownSink {
                limits: &grid.rect,
                depths: &block.depths,
                mask,
                origin: samples.origin(grid),
                seen: false,
            };
            let faces = Faces::of_cluster(geometry, item, *cluster, &screen_from_item);
            self.raster.run_one(*corners, &faces, passage, &mut sink);
            if sink.seen {
                return true;
            }
        }
        false
    }
}

impl PassingSamples {
    /// Returns the column and row of the sub-tile's first sample.
    fn origin(&self, grid: &Grid) -> [u16; 2] {
        let [tile, sub] = [
            self.sub_tile as usize / SUB_TILES,
            self.sub_tile as usize % SUB_TILES,
        ];
        let [column, row] = [tile % grid.columns, tile / grid.columns];
        [
            (column * COLUMNS + sub % ACROSS * SUB_COLUMNS) as u16,
            (row * ROWS + sub / ACROSS * SUB_ROWS) as u16,
        ]
    }

    /// Calls `each` with each sample's index in the sub-tile and the reversed depth there, rounded up.
    #[inline(always)]
    fn for_each(&self, grid: &Grid, triangles: &[TestedTriangle], mut each: impl FnMut(usize, f32)) {
        let shape = &triangles[self.triangle as usize].shape;
        let [x, y] = self.origin(grid);
        let rounding = match shape {
            TestedShape::Exact(triangle) => rounding(triangle, &grid.rect),
            TestedShape::Bounded(..) => 0.0,
        };
        let mut left = self.mask;
        while left != 0 {
            let sample = left.trailing_zeros() as usize;
            left &= left - 1;
            let rev_depth = match shape {
                TestedShape::Exact(triangle) => {
                    let row = triangle.row(y + (sample / SUB_COLUMNS) as u16);
                    ((row.at(x + (sample % SUB_COLUMNS) as u16) + rounding) * ROUND_UP) as f32
                }
                TestedShape::Bounded(_, nearest) => *nearest,
            };
            each(sample, rev_depth);
        }
    }
}

impl Depths {
    /// Begins with the sub-tiles of the passing samples, at infinite depth.
    fn begin(&mut self, grid: &Grid, passing: &[PassingSamples], triangles: &[TestedTriangle]) {
        let count = grid.tiles.len();
        self.worth.clear();
        self.worth.resize(count, f32::INFINITY);
        self.doubtful.clear();
        self.doubtful.resize(count, 0);
        self.bands.clear();
        self.bands.resize(grid.rows() * (ROWS / BAND), false);
        self.places.resize(count * SUB_TILES, 0);
        self.blocks.clear();
        for samples in passing {
            let [tile, sub] = [
                samples.sub_tile as usize / SUB_TILES,
                samples.sub_tile as usize % SUB_TILES,
            ];
            if self.doubtful[tile] >> sub & 1 == 0 {
                if self.blocks.len() == count * BLOCKS_PER_TILE {
                    continue;
                }
                self.doubtful[tile] |= 1 << sub;
                self.bands[tile / grid.columns * (ROWS / BAND) + sub / SUB_TILES_OF_BAND] = true;
                self.places[samples.sub_tile as usize] = self.blocks.len() as u32;
                self.blocks.push(Block::EMPTY);
            }
            let block = &mut self.blocks[self.places[samples.sub_tile as usize] as usize];
            block.open |= samples.mask;
            samples.for_each(grid, triangles, |sample, rev_depth| {
                block.farthest[sample] = block.farthest[sample].min(rev_depth);
                block.nearest[sample] = block.nearest[sample].max(rev_depth);
                block.worth = block.worth.min(rev_depth);
            });
            self.worth[tile] = self.worth[tile].min(block.worth);
        }
    }

    /// Returns `true` if occluders in `rect` with reversed depth up to `nearest` may hide a doubtful sample.
    #[inline(always)]
    fn gains(&self, grid: &Grid, rect: &Rect, nearest: f32) -> bool {
        let rect = rect.intersection(&grid.rect);
        if rect.is_empty() {
            return false;
        }
        for row in tiles(rect.y0, rect.y1, ROWS) {
            for column in tiles(rect.x0, rect.x1, COLUMNS) {
                let tile = row * grid.columns + column;
                if nearest > self.worth[tile] && self.gains_in(tile, [column, row], &rect, nearest) {
                    return true;
                }
            }
        }
        false
    }

    /// As [`Depths::gains`], in the tile at a column and row of tiles.
    fn gains_in(&self, tile: usize, [column, row]: [usize; 2], rect: &Rect, nearest: f32) -> bool {
        let columns = columns_within(rect.x0, rect.x1, column * COLUMNS);
        let bands = [0, 1].map(|band| rows_within(rect.y0, rect.y1, row * ROWS + band * BAND));
        let rows = bands.as_flattened();
        let mut left = self.doubtful[tile];
        while left != 0 {
            let sub = left.trailing_zeros() as usize;
            left &= left - 1;
            let across = columns >> (sub % ACROSS * SUB_COLUMNS) & 0xFF;
            let mask = (across * 0x0101_0101) & rows[sub / ACROSS];
            let block = &self.blocks[self.places[tile * SUB_TILES + sub] as usize];
            if nearest > block.worth && block.open & mask != 0 {
                return true;
            }
        }
        false
    }

    /// Returns the block of a sub-tile, by its index; `None` if there was no room for it.
    fn block(&self, sub_tile: u32) -> Option<&Block> {
        let [tile, sub] = [sub_tile as usize / SUB_TILES, sub_tile as usize % SUB_TILES];
        (self.doubtful[tile] >> sub & 1 != 0).then(|| &self.blocks[self.places[sub_tile as usize] as usize])
    }

    /// Returns the samples that are not behind the occluders.
    fn shown(&self, grid: &Grid, samples: &PassingSamples, triangles: &[TestedTriangle]) -> u32 {
        let Some(block) = self.block(samples.sub_tile) else {
            return samples.mask;
        };
        let mut shown = 0;
        samples.for_each(grid, triangles, |sample, rev_depth| {
            // NaN is visible.
            let is_behind = rev_depth < block.depths[sample];
            shown |= u32::from(!is_behind) << sample;
        });
        shown
    }
}

/// Returns a bound on the rounding error of a triangle's reversed depth at the samples of `limits`.
#[inline(always)]
fn rounding(triangle: &Triangle, limits: &Rect) -> f64 {
    /// Generous bound for sums of three products, relative to the largest.
    const ROUNDING: f64 = 1.0 / (1_u64 << 48) as f64;
    let most = DVec3::new(f64::from(limits.x1), f64::from(limits.y1), 1.0);
    triangle.rev_depth.abs().dot(most) * ROUNDING
}

/// Returns twice the signed area of a triangle on the screen.
#[inline(always)]
fn doubled_area([ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]) -> f64 {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

/// Returns `true` if a point of the screen is inside a triangle beyond the near plane, by more than rounding errors.
#[inline(always)]
fn is_inside(point: [f64; 2], corners: &[Corner; 3]) -> bool {
    /// In pixels, times the length of an edge.
    const SURELY: f64 = 1e-3;
    let [a, b, c] = corners.map(|corner| corner.pixel);
    let sides = [
        doubled_area(a, b, point),
        doubled_area(b, c, point),
        doubled_area(c, a, point),
    ];
    let edges = [[a, b], [b, c], [c, a]].map(|[from, to]| (to[0] - from[0]).abs() + (to[1] - from[1]).abs());
    let inside = |sign: f64| (0..3).all(|side| sign * sides[side] > SURELY * edges[side]);
    inside(1.0) || inside(-1.0)
}

/// Returns the samples of `limits` around a triangle beyond the near plane, and its reversed depth, rounded up.
#[inline(always)]
fn bounds([a, b, c]: &[Corner; 3], limits: &Rect) -> (Rect, f32) {
    let low = [0, 1].map(|axis| smaller(a.pixel[axis], smaller(b.pixel[axis], c.pixel[axis])));
    let high = [0, 1].map(|axis| greater(a.pixel[axis], greater(b.pixel[axis], c.pixel[axis])));
    let nearest = greater(a.rev_depth, greater(b.rev_depth, c.rev_depth));
    (Rect::around(low, high, limits), (nearest * ROUND_UP) as f32)
}

/// Rasterizer output that collects the samples that the tiles do not hide.
struct PassingSink<'a> {
    grid: &'a Grid,
    cluster: u32,
    has_entry: bool,
    limit: f64,
    count: &'a mut f64,
    triangles: &'a mut Vec<TestedTriangle>,
    passing: &'a mut Vec<PassingSamples>,
    slope: Option<Slope>,
}

impl Sink for PassingSink<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        self.grid.hides(rect, nearest)
    }

    #[inline(always)]
    fn is_done(&self) -> bool {
        *self.count > self.limit
    }

    /// Tests the sample at the middle of each triangle first. Keeps the item if one that its triangle owns passes; where
    /// doubtful items are resolved, if the triangles of those that pass have more samples than a doubtful item, by their
    /// areas.
    #[inline(always)]
    fn begin_batch(&mut self, triangles: impl Iterator<Item = [Corner; 3]>) {
        let most = LARGEST_PART * self.limit;
        let (mut small, mut large) = (*self.count, 0.0);
        let Rect { x0, y0, x1, y1 } = self.grid.rect;
        let [low, high] = [[x0, y0].map(f64::from), [x1, y1].map(f64::from)];
        for corners in triangles {
            let [a, b, c] = &corners;
            let [x, y] = [0, 1].map(|axis| (a.pixel[axis] + b.pixel[axis] + c.pixel[axis]) * THIRD);
            let rev_depth = (a.rev_depth + b.rev_depth + c.rev_depth) * THIRD;
            if x < low[0] || y < low[1] || x >= high[0] || y >= high[1] {
                continue;
            }
            if rev_depth < f64::from(self.grid.rev_depth_at(x as usize, y as usize)) {
                continue;
            }
            let area = doubled_area(a.pixel, b.pixel, c.pixel).abs();
            if self.limit == 0.0 {
                // Behind an entry plane a sample of a triangle may not be its own.
                if self.has_entry || area < 1.0 || !is_inside([x.floor() + 0.5, y.floor() + 0.5], &corners) {
                    continue;
                }
                large = 1.0;
            } else if 0.5 * area < most {
                small += 0.5 * area;
            } else {
                large += most;
            }
            if small + large > self.limit {
                *self.count = f64::INFINITY;
                return;
            }
        }
        *self.count = small;
    }

    /// Tests the rectangle around a small triangle; only large ones are rasterized.
    #[inline(always)]
    fn wants(&mut self, corners: &[Corner; 3]) -> bool {
        if self.limit == 0.0 {
            return true;
        }
        let (rect, nearest) = bounds(corners, &self.grid.rect);
        if rect.is_empty() {
            return false;
        }
        let Rect { x0, y0, x1, y1 } = rect;
        if x1 - x0 > LARGEST_BOUNDED || y1 - y0 > LARGEST_BOUNDED {
            return true;
        }
        let triangle = self.triangles.len() as u32;
        let mut any = false;
        for down in tiles(y0, y1, SUB_ROWS) {
            let rows = rows_within(y0, y1, down * SUB_ROWS)[0];
            for across in tiles(x0, x1, SUB_COLUMNS) {
                let tile = down * SUB_ROWS / ROWS * self.grid.columns + across / ACROSS;
                let sub = down % (ROWS / SUB_ROWS) * ACROSS + across % ACROSS;
                let columns = columns_within(x0, x1, across * SUB_COLUMNS) & 0xFF;
                let mask = self
                    .grid
                    .passing_in([tile, sub], (columns * 0x0101_0101) & rows, nearest);
                if mask != 0 {
                    any = true;
                    self.passing.push(PassingSamples {
                        sub_tile: (tile * SUB_TILES + sub) as u32,
                        mask,
                        triangle,
                    });
                }
            }
        }
        if any {
            self.triangles.push(TestedTriangle {
                cluster: self.cluster,
                shape: TestedShape::Bounded(corners.map(|corner| corner.at), nearest),
            });
        }
        false
    }

    #[inline(always)]
    fn begin(&mut self, triangle: &Triangle, _corners: &[DVec3; 3]) {
        self.slope = Some(Slope::of(triangle, &self.grid.rect));
        self.triangles.push(TestedTriangle {
            cluster: self.cluster,
            shape: TestedShape::Exact(*triangle),
        });
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        let Some(slope) = &self.slope else { return };
        let nearest = (triangle.greatest * ROUND_UP) as f32;
        let across = BandTiles::new(band);
        let y = usize::from(band.y);
        let first = y % ROWS / BAND * SUB_TILES_OF_BAND;
        for column in across.tiles() {
            if self.is_done() {
                return;
            }
            let index = y / ROWS * self.grid.columns + column;
            if nearest < self.grid.farthest[index] {
                continue;
            }
            let most = slope.most_over_band([column * COLUMNS, y]);
            for (sub, (samples, most)) in (first..).zip(across.samples(column).into_iter().zip(most)) {
                let mask = self.grid.passing_in([index, sub], samples, most);
                if mask != 0 {
                    *self.count += f64::from(mask.count_ones());
                    self.passing.push(PassingSamples {
                        sub_tile: (index * SUB_TILES + sub) as u32,
                        mask,
                        triangle: self.triangles.len() as u32 - 1,
                    });
                }
            }
        }
    }
}

/// Rasterizer output that finds whether a triangle owns a sample of a sub-tile in front of the occluders.
struct ShownSink<'a> {
    limits: &'a Rect,
    depths: &'a [f32; SAMPLES],
    mask: u32,
    /// Column and row of the first sample.
    origin: [u16; 2],
    seen: bool,
}

impl Sink for ShownSink<'_> {
    fn hides(&mut self, _rect: &Rect, _nearest: f32) -> bool {
        false
    }

    fn band(&mut self, band: &Band, triangle: &Triangle) {
        let [left, top] = self.origin;
        let rounding = rounding(triangle, self.limits);
        for (y, [x0, x1]) in band.rows() {
            if y < top || y >= top + SUB_ROWS as u16 {
                continue;
            }
            let row = triangle.row(y);
            for x in x0.max(left)..x1.min(left + SUB_COLUMNS as u16) {
                let sample = usize::from(y - top) * SUB_COLUMNS + usize::from(x - left);
                let rev_depth = ((row.at(x) + rounding) * ROUND_UP) as f32;
                // NaN is visible.
                let is_behind = rev_depth < self.depths[sample];
                self.seen |= self.mask >> sample & 1 != 0 && !is_behind;
            }
        }
    }
}

/// Rasterizer output that stores the nearest depths of occluders at doubtful samples.
struct DepthSink<'a> {
    grid: &'a Grid,
    depths: &'a mut Depths,
    /// Rounding error of the current triangle's reversed depth.
    rounding: f64,
}

impl Sink for DepthSink<'_> {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        !self.depths.gains(self.grid, rect, nearest)
    }

    #[inline(always)]
    fn wants(&mut self, corners: &[Corner; 3]) -> bool {
        let (rect, nearest) = bounds(corners, &self.grid.rect);
        self.depths.gains(self.grid, &rect, nearest)
    }

    #[inline(always)]
    fn wants_band(&self, y: u16) -> bool {
        self.depths.bands[usize::from(y) / BAND]
    }

    #[inline(always)]
    fn begin(&mut self, triangle: &Triangle, _corners: &[DVec3; 3]) {
        self.rounding = rounding(triangle, &self.grid.rect);
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        let across = BandTiles::new(band);
        let y = usize::from(band.y);
        let first = y % ROWS / BAND * SUB_TILES_OF_BAND;
        for column in across.tiles() {
            let index = y / ROWS * self.grid.columns + column;
            let doubtful = self.depths.doubtful[index] >> first & 0xFF;
            if doubtful == 0 {
                continue;
            }
            for (sub, mask) in across.samples(column).into_iter().enumerate() {
                if mask == 0 || doubtful >> sub & 1 == 0 {
                    continue;
                }
                let place = self.depths.places[index * SUB_TILES + first + sub];
                let block = &mut self.depths.blocks[place as usize];
                let [x, y] = [
                    column * COLUMNS + sub % ACROSS * SUB_COLUMNS,
                    y + sub / ACROSS * SUB_ROWS,
                ];
                if mask & block.open != 0 && block.gains(triangle, [x as u16, y as u16]) {
                    block.store(mask, triangle, self.rounding, [x as u16, y as u16]);
                }
            }
        }
    }
}
