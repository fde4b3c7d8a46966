//! Surfaces in cells larger than samples: which cells are covered whole, and how near at least.
//!
//! A cell is covered by a surface that reaches into it and has no outline there: no boundary, no silhouette, no edge that
//! is known from one side only. Shrinking each triangle instead would leave a crack along every edge that two share. So
//! every edge that meets a cell is added up there, once from each side and with opposite signs: where the sum is nothing,
//! the surface goes through without an end, and covers all of the cell or none.
//! A cell that a face covers alone needs no sum.
//! An edge is named by the positions of its ends and the space they are in, so that faces hang together however they are
//! spread over clusters, materials and items of one space. Clusters come one after the other; what one leaves open in a
//! cell waits for those that may close it.
//! Source: Boreskov, Hierarchical s-buffer for scenes of high complexity, section 3, for covers of lower resolution; the
//!     sums are ours.
//! Cost: a face O(cells that it meets), a cluster O(cells between its outermost).
//! Conservative: an edge or face is taken to meet a cell where rounding leaves it open; reversed depth is the least of all faces
//! that meet the cell, rounded down. Names are of 64 bits: that those of unlike edges add up to nothing by chance is
//! less likely than a fault of the machine.

mod face;
#[cfg(test)]
mod tests;
mod waiting;

use super::Coarse;
use super::band::{BAND, Band};
use super::triangle::Triangle;
use crate::aperture::Rect;
use crate::faces::Faces;
use crate::passage::Passage;
use crate::region::Region;
use crate::stats::Stats;
use face::{Corner, Face, Row};
use waiting::OpenEdges;

/// What the faces that came so far cover.
#[derive(Default)]
pub struct CoarseCoverage {
    rect: Rect,
    columns: usize,
    /// By row and column of the screen in cells.
    cells: Vec<Cell>,
    open_edges: Vec<OpenEdges>,
    /// The cluster at hand, and the first of the passage; from 1.
    batch: u32,
    first_batch: u32,
    /// The cells that its outlines meet, as column and row.
    touched: Vec<[u16; 2]>,
    corners: Vec<Corner>,
}

/// What the cluster at hand does to a cell.
#[derive(Clone, Copy, Default)]
struct Cell {
    /// The edges that meet it, added up since they last came to nothing.
    edges: u64,
    /// The least reversed depth of the faces that met it since then.
    least: f32,
    /// How near it is covered; 0 where it is not. Each time that the sum comes to nothing something covers it, whatever
    /// lies behind that in the same cluster.
    covered: f32,
    /// That cluster; another's numbers mean nothing.
    batch: u32,
}

impl Cell {
    /// All edges of a face are in.
    #[inline(always)]
    fn close(&mut self) {
        if self.edges == 0 {
            self.covered = self.covered.max(self.least);
            self.least = f32::INFINITY;
        }
    }
}

/// Cells of its box, for each face of a cluster, from which on its faces are looked at one by one. Where they have fewer,
/// what they hide is not worth setting them up (section 3 of the source: small faces do not hide): a kitchen of small
/// things takes half as long for four items in a hundred more.
const WORTH: u64 = 1;

/// Neighbouring cells whose reversed depth differs by no more than this factor become one run.
const ALIKE: f32 = 1.0 + 1.0 / 32.0;

impl CoarseCoverage {
    /// Memory in bytes for so many cells.
    pub(crate) fn needs_bytes(cells: [u32; 2]) -> u64 {
        u64::from(cells[0]) * u64::from(cells[1]) * (size_of::<Cell>() + size_of::<OpenEdges>()) as u64
    }

    /// Starts over, for a passage in cells.
    pub(crate) fn clear(&mut self, passage: &Passage) {
        self.rect = passage.aperture.rect();
        self.columns = usize::from(self.rect.x1);
        let count = self.columns * usize::from(self.rect.y1);
        if self.cells.len() < count {
            self.cells.resize(count, Cell::default());
            self.open_edges.resize(count, OpenEdges::default());
        }
        // Clusters are numbered on from passage to passage, so that nothing need be cleared.
        if self.batch > u32::MAX / 2 {
            self.cells.fill(Cell::default());
            self.open_edges.fill(OpenEdges::default());
            self.batch = 0;
        }
        self.first_batch = self.batch + 1;
    }

    /// Takes opaque faces; `cover` is told of cells that are covered, and how near by at least.
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
                if let Some(face) = Face::of(used, front, passage, &self.rect) {
                    stats.triangles += 1;
                    if cover.sees_cells(&face.rect, face.nearest()) {
                        self.insert(&face, cover);
                    } else {
                        // What it could close, it would cover no nearer than what hides it.
                        stats.triangles_hidden += 1;
                    }
                }
            }
        });
        self.corners = corners;
        self.finish_batch(cover);
    }

    /// Are the faces of a cluster, whose box is `region`, large enough in cells to be looked at one by one?
    pub(crate) fn is_worth(faces: &Faces, region: &Region) -> bool {
        let Rect { x0, y0, x1, y1 } = region.rect;
        u64::from(x1 - x0) * u64::from(y1 - y0) >= WORTH * faces.count() as u64
    }

    /// May any of these faces be seen past what `cover` knows?
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
                    || Face::of(used, front, passage, &self.rect)
                        .is_some_and(|face| self.shows(&face, cover));
            }
        });
        shows
    }

    /// May a face be seen? By its nearest corner in the rectangle around it first, then cell by cell.
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

    /// Adds a face to the cells that its outline meets; those within it covers alone.
    #[inline]
    fn insert(&mut self, face: &Face, cover: &mut impl Coarse) {
        let rect = face.rect;
        let rows = rect.y0..rect.y1;
        if rect.x1 - rect.x0 == 1 && rows.len() == 1 && face.is_within(&rect) {
            // Most faces of a detailed mesh: all of their edges meet the one cell.
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

    /// A face comes into a cell, and is no farther there than this.
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

    /// Finds the cells that the cluster covers, alone or with those before it.
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

    /// How near a cell is covered now that the cluster is in, if its outlines left that open until now.
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

/// Tells of cells of one row.
#[inline]
fn cover_run((y, run, rev_depth): (u16, [u16; 2], f32), cover: &mut impl Coarse) {
    let mut band = Band {
        y: y - y % BAND as u16,
        runs: [[0; 2]; BAND],
    };
    band.runs[usize::from(y - band.y)] = run;
    cover.cover_cells(&band, &Triangle::flat(rev_depth));
}
