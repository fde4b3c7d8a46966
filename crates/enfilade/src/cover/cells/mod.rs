//! Coverage of cells larger than samples: finds the cells that a surface covers entirely, and the farthest depth there.
//! With a margin, a cell is the square around a sample in which the rounding of a renderer may move the picture.
//!
//! A surface covers a cell that it overlaps if the cell contains no boundary, silhouette or unpaired edge of it.
//! Shrinking each triangle instead would leave a crack along every shared edge. So each edge that touches a cell is
//! added to the cell's sum, with opposite signs from the two faces that share it. Where the sum is zero, the surface
//! has no end inside the cell and covers all of it or nothing.
//! Cells inside a single face need no sum.
//! An edge's hash comes from the positions of its ends and their space, so a surface is watertight across clusters,
//! materials and items of one space. Clusters arrive one after the other; the sum that a cluster leaves open in a cell
//! is kept for later ones that may close it.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3, for covers of lower resolution;
//!     the sums are original to this library.
//! Cost: a face O(cells that it touches), a cluster O(cells of its bounding rectangle).
//! Conservative: an edge or a face counts as touching a cell if rounding leaves that open; the reversed depth is the
//!     minimum of all faces that touch the cell, rounded down. Hashes have 64 bits: different edges that cancel at
//!     random are less likely than a hardware fault.

mod face;
#[cfg(test)]
mod tests;
mod waiting;

use super::Coarse;
use crate::faces::Faces;
use crate::raster::{BAND, Band, Triangle};
use crate::stats::Stats;
use crate::view::aperture::Rect;
use crate::view::passage::Passage;
use crate::view::region::Region;
use face::{Corner, Face, Row};
use waiting::OpenEdges;

/// Low-resolution occlusion coverage: finds the cells of a coarse grid that opaque surfaces cover entirely, so that a
/// cover can cull with fewer cells than samples.
///
/// Feeds another cover, which stores the depths of the cells and answers occlusion queries. Never reports a cell as
/// covered that a sample of any resolution could see through, nor nearer than the surface is anywhere in it.
#[doc(alias = "low resolution coverage")]
#[derive(Default)]
pub struct CoarseCoverage {
    rect: Rect,
    columns: usize,
    /// In row-major order from the top left cell of the screen.
    cells: Vec<Cell>,
    open_edges: Vec<OpenEdges>,
    /// Half the side of the square around the centre of each cell that is to be covered, in cells: ½ for the whole cell.
    half: f64,
    /// Number of the current cluster and of the first one of the passage, from 1.
    batch: u32,
    first_batch: u32,
    /// Column and row of the cells that outlines of the current cluster's faces touch.
    touched: Vec<[u16; 2]>,
    corners: Vec<Corner>,
}

/// Coverage of a cell by the current cluster.
#[derive(Clone, Copy, Default)]
struct Cell {
    /// Sum of the hashes of the edges that touch it, since the sum was last zero.
    edges: u64,
    /// Minimum reversed depth of the faces that touched it since then.
    least: f32,
    /// Reversed depth at which it is covered; 0 if it is not. Each time the sum returns to zero, the faces summed so
    /// far cover the cell, whatever is behind them in the same cluster.
    covered: f32,
    /// Number of the cluster; values of an earlier cluster are stale.
    batch: u32,
}

impl Cell {
    /// Call after all edges of a face were added.
    #[inline(always)]
    fn close(&mut self) {
        if self.edges == 0 {
            self.covered = self.covered.max(self.least);
            self.least = f32::INFINITY;
        }
    }
}

/// Minimum number of cells in a cluster's rectangle per face for its faces to be processed. With fewer, setting them up
/// costs more than they hide (section 3 of the source: small faces do not occlude). A kitchen of small things takes
/// half the time, at the cost of four more items in a hundred.
const WORTH: u64 = 1;

/// Maximum ratio of the reversed depths of neighbouring cells that are merged into one run.
const ALIKE: f32 = 1.0 + 1.0 / 32.0;

impl CoarseCoverage {
    /// Returns the memory in bytes for a grid of `cells` (columns, rows).
    pub(crate) fn needs_bytes(cells: [u32; 2]) -> u64 {
        u64::from(cells[0]) * u64::from(cells[1]) * (size_of::<Cell>() + size_of::<OpenEdges>()) as u64
    }

    /// Clears the coverage for a passage, whose screen is in cells.
    pub(crate) fn clear(&mut self, passage: &Passage) {
        self.rect = passage.aperture.rect();
        self.half = passage.spread;
        self.columns = usize::from(self.rect.x1);
        let count = self.columns * usize::from(self.rect.y1);
        if self.cells.len() < count {
            self.cells.resize(count, Cell::default());
            self.open_edges.resize(count, OpenEdges::default());
        }
        // Cluster numbers continue from passage to passage, so the cells need no clearing.
        if self.batch > u32::MAX / 2 {
            self.cells.fill(Cell::default());
            self.open_edges.fill(OpenEdges::default());
            self.batch = 0;
        }
        self.first_batch = self.batch + 1;
    }

    /// Adds the opaque faces of a cluster, and passes the cells that are now covered, with their depth, to `cover`.
    pub(crate) fn add(
        &mut self,
        faces: &Faces,
        passage: &Passage,
        stats: &mut Stats,
        cover: &mut impl Coarse,
    ) {
        stats.batches += 1;
        self.batch += 1;
        self.touched.clear();
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        let space = face::name_of_space(faces.screen_from_local);
        let corner = |&position: &[f32; 3]| Corner::new(position, faces.screen_from_local, space);
        corners.extend(faces.positions.iter().map(corner));
        let front = faces.front(passage);
        faces.for_each(|_, face| {
            for last in 2..face.len() {
                let used = [face[0], face[last - 1], face[last]]
                    .map(|index| &corners[(index - faces.first_position) as usize]);
                if let Some(face) = Face::of(used, front, passage, self.half, &self.rect) {
                    stats.triangles += 1;
                    if cover.sees_cells(&face.rect, face.nearest()) {
                        self.insert(&face, cover);
                    } else {
                        // Cells that it could close would be covered no nearer than by what hides it.
                        stats.triangles_hidden += 1;
                    }
                }
            }
        });
        self.corners = corners;
        self.finish_batch(cover);
    }

    /// Returns `true` if the faces of a cluster, with the bounds `region`, are large enough in cells to be processed
    /// one by one.
    pub(crate) fn is_worth(faces: &Faces, region: &Region) -> bool {
        let Rect { x0, y0, x1, y1 } = region.rect;
        u64::from(x1 - x0) * u64::from(y1 - y0) >= WORTH * faces.count() as u64
    }

    /// Returns `true` if any of these faces may be visible in `cover`; `true` when unsure.
    pub(crate) fn may_show(&mut self, faces: &Faces, passage: &Passage, cover: &mut impl Coarse) -> bool {
        self.corners.clear();
        let corner = |&position: &[f32; 3]| Corner::new(position, faces.screen_from_local, 0);
        self.corners.extend(faces.positions.iter().map(corner));
        let front = faces.front(passage);
        let mut shows = false;
        faces.for_each(|_, face| {
            for last in 2..face.len() {
                let used = [face[0], face[last - 1], face[last]]
                    .map(|index| &self.corners[(index - faces.first_position) as usize]);
                shows = shows
                    || Face::of(used, front, passage, self.half, &self.rect)
                        .is_some_and(|face| self.shows(&face, cover));
            }
        });
        shows
    }

    /// Returns `true` if a face may be visible. Tests its bounding rectangle at its nearest depth first, then each
    /// cell.
    fn shows(&self, face: &Face, cover: &mut impl Coarse) -> bool {
        let rect = face.rect;
        if !cover.sees_cells(&rect, face.nearest()) {
            return false;
        }
        if rect.x1 - rect.x0 <= 2 && rect.y1 - rect.y0 <= 2 {
            return true;
        }
        let upper = face.upper_plane(&self.rect);
        let first = rect.y0 - rect.y0 % BAND as u16;
        (first..rect.y1).step_by(BAND).any(|y| {
            let mut band = Band {
                y,
                runs: [[0; 2]; BAND],
            };
            for row in y.max(rect.y0)..(y + BAND as u16).min(rect.y1) {
                if let Some(Row { columns, .. }) = face.row(row, &self.rect) {
                    band.runs[usize::from(row - y)] = columns;
                }
            }
            cover.sees_plane(&band, &upper)
        })
    }

    /// Adds a face to the cells that its outline touches. The cells inside it are covered at once.
    #[inline]
    fn insert(&mut self, face: &Face, cover: &mut impl Coarse) {
        let rect = face.rect;
        let rows = rect.y0..rect.y1;
        if rect.x1 - rect.x0 == 1 && rows.len() == 1 && face.is_within(&rect) {
            // Fast path for most faces of a detailed mesh: one cell contains all edges.
            let least = face.least_in(rect.x0, rect.y0);
            let cell = self.open_cell([rect.x0, rect.y0], least);
            for edge in face.edges() {
                cell.edges = cell.edges.wrapping_add(edge.name);
            }
            cell.close();
            return;
        }
        let mut band = Band {
            y: rows.start - rows.start % BAND as u16,
            runs: [[0; 2]; BAND],
        };
        let mut any = false;
        for y in rows.clone() {
            if let Some(row) = face.row(y, &self.rect) {
                let [first, end] = row.columns;
                let [within, after] = row.within;
                band.runs[usize::from(y - band.y)] = row.within;
                any |= within < after;
                for x in (first..within).chain(after..end) {
                    self.open_cell([x, y], face.least_in(x, y));
                }
                let cells = &mut self.cells[usize::from(y) * self.columns..][..self.columns];
                for (edge, &[first, end]) in face.edges().iter().zip(&row.edges) {
                    for cell in &mut cells[usize::from(first)..usize::from(end)] {
                        cell.edges = cell.edges.wrapping_add(edge.name);
                    }
                }
                for x in (first..within).chain(after..end) {
                    cells[usize::from(x)].close();
                }
            }
            if any && (usize::from(y - band.y) == BAND - 1 || y + 1 == rows.end) {
                cover.cover_cells(&band, &face.lower_plane(&self.rect));
                any = false;
            }
            if usize::from(y - band.y) == BAND - 1 {
                band = Band {
                    y: y + 1,
                    runs: [[0; 2]; BAND],
                };
            }
        }
    }

    /// Begins adding a face to a cell; `least` is a lower bound of its reversed depth there.
    #[inline(always)]
    fn open_cell(&mut self, [x, y]: [u16; 2], least: f32) -> &mut Cell {
        let cell = &mut self.cells[usize::from(y) * self.columns + usize::from(x)];
        if cell.batch != self.batch {
            self.touched.push([x, y]);
            *cell = Cell {
                edges: 0,
                least: f32::INFINITY,
                covered: 0.0,
                batch: self.batch,
            };
        }
        cell.least = if least < cell.least { least } else { cell.least };
        cell
    }

    /// Passes the cells that the cluster covers, alone or together with earlier ones, to `cover`.
    fn finish_batch(&mut self, cover: &mut impl Coarse) {
        let mut run: Option<(u16, [u16; 2], f32)> = None;
        for place in 0..self.touched.len() {
            let [x, y] = self.touched[place];
            let Some(rev_depth) = self.covered(x, y) else {
                continue;
            };
            match &mut run {
                Some((row, [_, end], known))
                    if *row == y
                        && *end == x
                        && rev_depth <= *known * ALIKE
                        && *known <= rev_depth * ALIKE =>
                {
                    *end = x + 1;
                    *known = known.min(rev_depth);
                }
                run => {
                    let last = run.replace((y, [x, x + 1], rev_depth));
                    last.into_iter().for_each(|last| cover_run(last, cover));
                }
            }
        }
        run.into_iter().for_each(|last| cover_run(last, cover));
    }

    /// Returns the reversed depth at which the current cluster covers a cell whose edges it touches; `None` if it does
    /// not.
    #[inline]
    fn covered(&mut self, x: u16, y: u16) -> Option<f32> {
        let place = usize::from(y) * self.columns + usize::from(x);
        let Cell {
            edges,
            least,
            covered,
            ..
        } = self.cells[place];
        let closed = (edges != 0)
            .then(|| self.open_edges[place].add(edges, least, self.batch, self.first_batch))
            .flatten();
        let rev_depth = closed.map_or(covered, |closed| closed.max(covered));
        (rev_depth > 0.0).then_some(rev_depth)
    }
}

/// Passes one run of covered cells to `cover`.
#[inline]
fn cover_run((y, run, rev_depth): (u16, [u16; 2], f32), cover: &mut impl Coarse) {
    let mut band = Band {
        y: y - y % BAND as u16,
        runs: [[0; 2]; BAND],
    };
    band.runs[usize::from(y - band.y)] = run;
    cover.cover_cells(&band, &Triangle::flat(rev_depth));
}
