//! Hierarchical z-buffer (Hi-Z): a depth pyramid lets one test hide a large box, such as an octree node with all its
//! contents.
//!
//! Each cell of the pyramid stores the farthest depth of the four cells below it.
//! Source: Greene, Kass, Miller, Hierarchical Z-Buffer Visibility, SIGGRAPH 1993, sections 3.1 to 3.3.
//! Cost: clear and finish O(tiles) + O(samples of tiles that edges cross); a test O(1) cells if the box is hidden or
//!     clearly visible. Cells are updated when a test needs them, not at each depth write.
//! Exact: an owner is stored beside each depth; a box is tested at its nearest corner, so nothing visible is culled.

mod block;
mod show;
mod tiles;

use crate::cover::report::Report;
use crate::cover::samples::look_through;
use crate::cover::{Coarse, Cover, Paints};
use crate::faces::Faces;
use crate::geometry::Owners;
use crate::order::Unsorted;
use crate::raster::{Band, Raster, Sink, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::canvas::{Canvas, CoverShape};
use crate::view::collector::Collector;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use tiles::{TILE_SHIFT, Tiles};

/// Hierarchical z-buffer: a depth buffer with a pyramid of farthest depths (Hi-Z) for occlusion queries. Faces may be
/// added in any order.
#[doc(alias = "Hi-Z")]
#[doc(alias = "HZB")]
#[doc(alias = "hierarchical depth")]
#[derive(Default)]
pub struct DepthPyramid {
    raster: Raster,
    depths: Depths,
}

/// Depth tiles and pyramid. The lowest cells of the pyramid are tiles of 8×8 samples, which replace the three lowest
/// levels of the paper's pyramid. Those levels cost more than they saved: most tiles in pictures of walls belong to one
/// triangle and are never expanded to samples.
#[derive(Default)]
struct Depths {
    tiles: Tiles,
    /// Level 0 has cells of 2×2 tiles; each further level has cells of 2×2 cells of the level below.
    levels: Vec<Level>,
    /// Number of levels in use for this passage; unused ones are kept to reuse their memory.
    height: usize,
}

#[derive(Default)]
struct Level {
    columns: usize,
    rows: usize,
    cells: Vec<Cell>,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    /// Bits of the farthest reversed depth below; never nearer than the truth.
    farthest: u32,
    /// Whether a cell below may have become nearer since.
    stale: bool,
}

impl Cover for DepthPyramid {
    type Needs = Unsorted;

    const NAME: &'static str = "DepthPyramid";

    fn test(&mut self, region: &Region) -> Visibility {
        let bits = region.nearest.to_bits();
        if self.depths.sees(&region.rect, bits) {
            Visibility::Partial
        } else {
            Visibility::Hidden
        }
    }

    fn needs_bytes(size: [u32; 2]) -> u64 {
        let tiles = size.map(|side| u64::from(side.div_ceil(1 << TILE_SHIFT)));
        Tiles::needs_bytes(size) + tiles[0] * tiles[1] * size_of::<Cell>() as u64
    }

    const SHAPE: Option<CoverShape> = Some(CoverShape::Pyramid);

    fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        self.depths.show(passage, canvas);
    }
}

impl Paints for DepthPyramid {
    const PRIMES: bool = true;

    fn clear(&mut self, passage: &Passage, trace: bool) {
        self.depths.tiles.clear(passage, trace);
        self.depths.shape(trace || !passage.is_unclipped());
    }

    fn add(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, _canvas: Option<&mut dyn Canvas>) {
        self.depths.tiles.begin_batch();
        self.raster.run(faces, passage, &mut self.depths, stats);
    }

    fn look_through(&mut self, faces: &Faces, passage: &Passage, stats: &mut Stats, seen: &mut Collector) {
        let tiles = &self.depths.tiles;
        look_through(
            |x, y| tiles.depth(x, y),
            &mut self.raster,
            faces,
            passage,
            stats,
            seen,
        );
    }

    fn finish(
        &mut self,
        owners: &dyn Owners,
        _passage: &Passage,
        seen: &mut Collector,
        canvas: Option<&mut dyn Canvas>,
    ) {
        let mut report = Report::new(owners, seen, canvas.map(|canvas| canvas as &mut dyn Canvas));
        self.depths.tiles.report(&mut report);
        report.finish();
    }
}

impl Coarse for DepthPyramid {
    fn clear_cells(&mut self, passage: &Passage) {
        self.clear(passage, false);
    }

    fn sees_cells(&mut self, rect: &Rect, nearest: f32) -> bool {
        self.depths.sees(rect, nearest.to_bits())
    }

    fn sees_plane(&mut self, cells: &Band, rev_depth: &Triangle) -> bool {
        let tiles = &self.depths.tiles;
        cells.rows().any(|(y, [x0, x1])| {
            let row = rev_depth.row(y);
            (x0..x1).any(|x| row.bits(i32::from(x)) >= tiles.depth(x, y))
        })
    }

    fn cover_cells(&mut self, cells: &Band, rev_depth: &Triangle) {
        self.depths.tiles.begin_batch();
        self.depths.band(cells, rev_depth);
    }
}

impl Depths {
    /// Resizes the levels to the tiles. `stale`: whether the tiles already contain covered samples.
    fn shape(&mut self, stale: bool) {
        let [mut columns, mut rows] = [self.tiles.columns, self.tiles.rows];
        let mut level = 0;
        while columns > 1 || rows > 1 {
            [columns, rows] = [columns.div_ceil(2), rows.div_ceil(2)];
            if self.levels.len() == level {
                self.levels.push(Level::default());
            }
            let Level {
                columns: width,
                rows: height,
                cells,
            } = &mut self.levels[level];
            [*width, *height] = [columns, rows];
            cells.clear();
            cells.resize(columns * rows, Cell { farthest: 0, stale });
            level += 1;
        }
        self.height = level;
    }

    /// Returns `true` if the depth of any sample in `rect` is at most `bits`, that is, if geometry this near may be
    /// visible.
    fn sees(&mut self, rect: &Rect, bits: u32) -> bool {
        let mut level = 0;
        let [mut first, mut last] = cells(rect, level);
        while (last[0] - first[0] > 1 || last[1] - first[1] > 1) && level < self.height {
            level += 1;
            [first, last] = cells(rect, level);
        }
        (first[1]..=last[1])
            .any(|row| (first[0]..=last[0]).any(|column| self.cell_sees(level, column, row, rect, bits)))
    }

    /// Tests the part of `rect` in one cell as [`Depths::sees`] does; level 0 is the tiles.
    fn cell_sees(&mut self, level: usize, column: usize, row: usize, rect: &Rect, bits: u32) -> bool {
        if level == 0 {
            return self.tile_sees(column, row, rect, bits);
        }
        let Level {
            columns,
            cells: known,
            ..
        } = &self.levels[level - 1];
        let Cell { farthest, stale } = known[row * columns + column];
        if bits < farthest {
            return false;
        }
        let whole = self.is_whole(level, column, row, rect);
        if whole && !stale {
            return true;
        }
        let [first, last] = cells(rect, level - 1);
        for below_row in (2 * row).max(first[1])..=(2 * row + 1).min(last[1]) {
            for below in (2 * column).max(first[0])..=(2 * column + 1).min(last[0]) {
                if self.cell_sees(level - 1, below, below_row, rect, bits) {
                    return true;
                }
            }
        }
        if whole {
            self.refresh_cell(level, column, row);
        }
        false
    }

    fn tile_sees(&mut self, column: usize, row: usize, rect: &Rect, bits: u32) -> bool {
        if bits < self.tiles.farthest_known(column, row) || bits < self.tiles.farthest(column, row) {
            return false;
        }
        self.is_whole(0, column, row, rect) || self.tiles.farthest_in(rect, column, row) <= bits
    }

    /// Returns `true` if `rect` contains all samples of a cell that are inside the aperture's rectangle.
    fn is_whole(&self, level: usize, column: usize, row: usize, rect: &Rect) -> bool {
        let shift = TILE_SHIFT + level;
        let all = &self.tiles.rect;
        let [x0, y0] = [column << shift, row << shift];
        let [x1, y1] = [(column + 1) << shift, (row + 1) << shift];
        usize::from(rect.x0) <= x0.max(usize::from(all.x0))
            && usize::from(rect.y0) <= y0.max(usize::from(all.y0))
            && usize::from(rect.x1) >= x1.min(usize::from(all.x1))
            && usize::from(rect.y1) >= y1.min(usize::from(all.y1))
    }

    /// Rebuilds a cell from its (up to four) children that contain samples of the aperture's rectangle.
    fn refresh_cell(&mut self, level: usize, column: usize, row: usize) {
        let [first, last] = cells(&self.tiles.rect, level - 1);
        let mut cell = Cell {
            farthest: u32::MAX,
            stale: false,
        };
        for below_row in (2 * row).max(first[1])..=(2 * row + 1).min(last[1]) {
            for below in (2 * column).max(first[0])..=(2 * column + 1).min(last[0]) {
                let known = match level {
                    1 => Cell {
                        farthest: self.tiles.farthest(below, below_row),
                        stale: false,
                    },
                    _ => {
                        let Level { columns, cells, .. } = &self.levels[level - 2];
                        cells[below_row * columns + below]
                    }
                };
                cell = Cell {
                    farthest: cell.farthest.min(known.farthest),
                    stale: cell.stale | known.stale,
                };
            }
        }
        let Level { columns, cells, .. } = &mut self.levels[level - 1];
        cells[row * *columns + column] = cell;
    }
}

/// Returns the first and last cells of a level that contain samples of `rect`, as column and row.
fn cells(rect: &Rect, level: usize) -> [[usize; 2]; 2] {
    let shift = TILE_SHIFT + level;
    [
        [usize::from(rect.x0) >> shift, usize::from(rect.y0) >> shift],
        [
            (usize::from(rect.x1) - 1) >> shift,
            (usize::from(rect.y1) - 1) >> shift,
        ],
    ]
}

/// Marks the cells above a tile as stale, after one of its samples became nearer.
#[inline(always)]
fn mark_stale(levels: &mut [Level], mut column: usize, mut row: usize) {
    for level in levels {
        [column, row] = [column / 2, row / 2];
        let cell = &mut level.cells[row * level.columns + column];
        if cell.stale {
            return;
        }
        cell.stale = true;
    }
}

impl Sink for Depths {
    #[inline(always)]
    fn hides(&mut self, rect: &Rect, nearest: f32) -> bool {
        let bits = nearest.to_bits();
        let [first, last] = cells(rect, 0);
        if last[0] - first[0] > 1 || last[1] - first[1] > 1 {
            return !self.sees(rect, bits);
        }
        // Updating a tile costs more than rasterizing a small triangle, so use only depths that are up to date.
        [first[1], last[1]].iter().all(|&row| {
            [first[0], last[0]]
                .iter()
                .all(|&column| bits < self.tiles.farthest_known(column, row))
        })
    }

    #[inline(always)]
    fn band(&mut self, band: &Band, triangle: &Triangle) {
        let levels = &mut self.levels[..self.height];
        self.tiles.keep_nearest(
            band,
            triangle,
            #[inline(always)]
            |column, row| mark_stale(levels, column, row),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Dice;
    use crate::geom::Transform;
    use crate::geometry::{GeometryBuilder, Material};
    use crate::ids::SectorId;
    use crate::ids::{ItemIndex, MaterialId};
    use crate::mesh::Mesh;
    use crate::view::View;

    /// A pyramid over 77×43 samples with random triangles in front of the eye, added by index.
    fn pyramid(seed: u32) -> DepthPyramid {
        let mut dice = Dice::new(u64::from(seed));
        let mut roll = || dice.roll() as f32;
        let corners = 3 * (2 + seed % 20);
        let positions: Vec<[f32; 3]> = (0..corners)
            .map(|_| [9.0 * roll() - 4.5, 6.0 * roll() - 3.0, -0.5 - 5.0 * roll()])
            .collect();
        let mut builder = GeometryBuilder::new([Material {
            double_sided: true,
            ..Material::opaque([1.0; 3])
        }]);
        for triangle in positions.chunks(3) {
            let mesh = Mesh::triangles(triangle, &[0, 1, 2], MaterialId(0)).expect("a triangle");
            let mesh = builder.mesh(mesh);
            builder.item("triangle", mesh, Transform::IDENTITY);
        }
        let geometry = builder.build().expect("sound triangles");
        let view = View::new([0.0; 3], [0.0, 0.0, -1.0], [77, 43]).expect("a valid view");
        let passage = Passage::at_the_eye(&view, SectorId(0), false);
        let mut cover = DepthPyramid::default();
        cover.clear(&passage, false);
        for item in 0..geometry.items().len() as u32 {
            let faces = Faces::of_cluster(&geometry, ItemIndex(item), 0, &passage.screen_from_sector);
            cover.add(&faces, &passage, &mut Stats::default(), None);
        }
        cover
    }

    #[test]
    fn a_box_is_hidden_only_where_every_sample_before_it_is_strictly_nearer() {
        let mut hidden = 0;
        for seed in 0..60 {
            let mut cover = pyramid(seed);
            let mut dice = Dice::new(u64::from(seed) + 1000);
            let mut roll = || dice.roll() as f32;
            let deepest = (0..43).flat_map(|y| (0..77).map(move |x| (x, y)));
            let depths: Vec<u32> = deepest.map(|(x, y)| cover.depths.tiles.depth(x, y)).collect();
            for _ in 0..300 {
                let [x0, y0] = [(76.0 * roll()) as u16, (42.0 * roll()) as u16];
                let x1 = x0 + 1 + ((77 - x0 - 1) as f32 * roll() * roll()) as u16;
                let y1 = y0 + 1 + ((43 - y0 - 1) as f32 * roll() * roll()) as u16;
                let rect = Rect { x0, y0, x1, y1 };
                // Half of the queries have exactly the depth of some sample: equal depths are visible.
                let at = depths[(roll() * (77.0 * 43.0)) as usize];
                let bits = if roll() < 0.5 { at } else { at.saturating_sub(1) };
                let seen =
                    (y0..y1).any(|y| (x0..x1).any(|x| depths[usize::from(y) * 77 + usize::from(x)] <= bits));
                hidden += u32::from(!seen);
                assert_eq!(cover.depths.sees(&rect, bits), seen, "{rect:?} of pyramid {seed}");
            }
        }
        assert!(hidden > 1000, "almost nothing was hidden: {hidden}");
    }
}
