//! Terrain too large for meshes: heights stay in their source, such as a memory-mapped file; only a min/max quadtree is
//! in memory.
//!
//! It is a sector of its own, not the terrain of a [`Geometry`], because all methods read the meshes of a geometry and
//! these triangles exist only while a look visits their block. The quadtree stores the minimum and maximum height of
//! each block of 32×32 cells and of each 2×2 group above. A look reads the heights of only those blocks that pass the
//! occlusion test, and triangulates them on the fly.
//! Source: original; the min/max quadtree as in Tevs, Ihrke, Seidel, Maximum Mipmaps for Fast, Accurate, and Scalable
//!     Dynamic Height Field Rendering, I3D 2008.
//! Cost: building reads every height once; 11 bytes of memory per block, independent of the height format.
//! Bit-identical triangles to a [`HeightField`](crate::HeightField) with the same heights.

mod heights;
mod levels;
mod owners;

pub use heights::{HeightBytes, HeightFormat, Heights};

use crate::geom::Aabb;
use crate::geometry::{Alpha, Geometry, GeometryBuilder, GeometryError, MAX_OPENINGS, Material, Opening};
use crate::ids::ItemIndex;
use crate::sector::Surface;
use crate::terrain::{BLOCK, Diagonal, HeightFieldError, check_cell, check_size};
use glam::DVec3;
use levels::Level;
use std::fmt;
use std::ops::Range;

/// Cells along a side of a cluster, which is a square part of a block.
const SQUARE: u32 = 8;
/// Clusters along a side of a full block.
const SQUARES: u32 = BLOCK / SQUARE;
/// Face ids reserved per cluster: two per cell.
const SQUARE_FACES: u32 = 2 * SQUARE * SQUARE;
/// Face ids reserved per block.
const BLOCK_FACES: u32 = SQUARES * SQUARES * SQUARE_FACES;

/// A custom sector of streamed terrain: heights are read on demand, and only a min/max quadtree is kept in memory.
///
/// Visibility is computed as by [`Method::FloatingHorizon`](crate::Method::FloatingHorizon). Add it with
/// [`SceneBuilder::add_custom`](crate::SceneBuilder::add_custom). Its items are blocks of 32×32 cells, row after row
/// from the north, each row from west to east. The first sample is at x = 0, z = 0; a portal's transform can move the
/// terrain. It is opaque and double-sided.
#[doc(alias = "heightmap streaming")]
pub struct LargeTerrain {
    heights: Box<dyn Heights>,
    size: [u32; 2],
    cell: [f64; 2],
    diagonal: Diagonal,
    color: [f32; 3],
    /// Level 0 holds the blocks, each further one 2×2 squares of the one before.
    levels: Vec<Level>,
    /// The openings; no items.
    holes: Geometry,
    /// Triangle indices of a cluster, by whether it is narrower than a full one: [west to east][north to south].
    corners: [[Vec<u32>; 2]; 2],
}

/// Buffers for the heights and vertices of a block, reused between looks.
pub(crate) struct Workplace {
    heights: Vec<f32>,
    positions: Vec<[f32; 3]>,
}

impl Default for Workplace {
    fn default() -> Workplace {
        Workplace {
            heights: vec![0.0; ((BLOCK + 1) * (BLOCK + 1)) as usize],
            positions: Vec::with_capacity(((SQUARE + 1) * (SQUARE + 1)) as usize),
        }
    }
}

/// A cluster of a block, as ranges of sample columns and rows.
#[derive(Clone, Debug)]
pub(crate) struct Square {
    pub(crate) number: u32,
    columns: Range<u32>,
    rows: Range<u32>,
}

impl Square {
    pub(crate) fn triangle_count(&self) -> u64 {
        2 * (self.columns.len() as u64 - 1) * (self.rows.len() as u64 - 1)
    }
}

impl LargeTerrain {
    /// Creates terrain of one color (linear RGB, 0 to 1) with samples `cell` units apart along x and z. Reads all
    /// heights once.
    ///
    /// # Errors
    /// [`HeightFieldError::Size`], [`HeightFieldError::Faces`], [`HeightFieldError::Cell`]; [`HeightFieldError::Hole`]
    /// or [`HeightFieldError::TooFar`] for the first invalid height.
    pub fn new(
        heights: impl Heights + 'static,
        cell: [f64; 2],
        color: [f32; 3],
    ) -> Result<LargeTerrain, HeightFieldError> {
        let size = heights.size();
        check_size(size)?;
        let blocks = size.map(|side| (side - 1).div_ceil(BLOCK));
        let faces = u64::from(blocks[0]) * u64::from(blocks[1]) * u64::from(BLOCK_FACES);
        if faces > u64::from(u32::MAX) - MAX_OPENINGS as u64 {
            return Err(HeightFieldError::Faces(faces));
        }
        check_cell(size, cell)?;
        let levels = Level::all(&heights)?;
        let mut terrain = LargeTerrain {
            heights: Box::new(heights),
            size,
            cell,
            diagonal: Diagonal::default(),
            color,
            levels,
            holes: only_openings(Vec::new()).expect("an empty list of openings is valid"),
            corners: Default::default(),
        };
        terrain.cut();
        Ok(terrain)
    }

    /// Returns the terrain with its cells split along the given diagonal.
    #[must_use]
    pub fn cut_along(mut self, diagonal: Diagonal) -> LargeTerrain {
        self.diagonal = diagonal;
        self.cut();
        self
    }

    /// Returns the terrain with the given openings, for example the doors of houses. Replaces the previous openings.
    ///
    /// # Errors
    /// [`GeometryError::TooManyOpenings`].
    pub fn with_openings(mut self, openings: Vec<Opening>) -> Result<LargeTerrain, GeometryError> {
        self.holes = only_openings(openings)?;
        Ok(self)
    }

    /// Returns the number of samples from west to east and from north to south.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the number of blocks from west to east and from north to south.
    pub fn blocks(&self) -> [u32; 2] {
        self.levels[0].size
    }

    pub(crate) fn holes(&self) -> &Geometry {
        &self.holes
    }

    /// Returns the number of quadtree levels; level 0 holds the blocks.
    pub(crate) fn level_count(&self) -> usize {
        self.levels.len()
    }

    /// Returns the number of squares of a level from west to east and from north to south.
    pub(crate) fn level_size(&self, level: usize) -> [u32; 2] {
        self.levels[level].size
    }

    /// Returns the start of a column (axis 0: x) or row (axis 1: z) of squares of a level.
    pub(crate) fn border(&self, level: usize, square: u32, axis: usize) -> f64 {
        f64::from(self.line((square << level) * BLOCK, axis))
    }

    /// Returns the AABB of a square of a level.
    pub(crate) fn bounds_of(&self, level: usize, square: [u32; 2]) -> Aabb {
        let [columns, rows] = [0, 1].map(|axis| {
            let first = (square[axis] << level) * BLOCK;
            first..(first + (BLOCK << level) + 1).min(self.size[axis])
        });
        self.around(&columns, &rows, self.levels[level].span(square))
    }

    /// Returns the AABB of a range of sample columns and rows between two heights.
    fn around(&self, columns: &Range<u32>, rows: &Range<u32>, [low, high]: [f32; 2]) -> Aabb {
        Aabb {
            min: [self.line(columns.start, 0), low, self.line(rows.start, 1)],
            max: [self.line(columns.end - 1, 0), high, self.line(rows.end - 1, 1)],
        }
    }

    /// Returns the position of a sample column (axis 0: x) or row (axis 1: z); the same bits as in a
    /// [`HeightField`](crate::HeightField).
    fn line(&self, line: u32, axis: usize) -> f32 {
        (f64::from(line) * self.cell[axis]) as f32
    }

    /// Returns the index of a block from its column and row.
    pub(crate) fn block_number(&self, [column, row]: [u32; 2]) -> u32 {
        row * self.blocks()[0] + column
    }

    /// Returns the column and row of a block from its item id.
    pub(crate) fn block_at(&self, item: ItemIndex) -> [u32; 2] {
        let columns = self.blocks()[0];
        [item.0 % columns, item.0 / columns]
    }

    /// Returns the id of a block's first face.
    pub(crate) fn first_face(&self, block: [u32; 2]) -> u32 {
        self.block_number(block) * BLOCK_FACES
    }

    /// Returns the number of clusters of a block from west to east and from north to south.
    pub(crate) fn squares(&self, block: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|axis| self.cells(block, axis).div_ceil(SQUARE))
    }

    /// Returns the number of cells of a block along an axis.
    fn cells(&self, block: [u32; 2], axis: usize) -> u32 {
        (self.size[axis] - 1 - block[axis] * BLOCK).min(BLOCK)
    }

    /// Returns a cluster of a block from its column and row in the block.
    pub(crate) fn square(&self, block: [u32; 2], [column, row]: [u32; 2]) -> Square {
        let [columns, rows] = [(column, 0), (row, 1)].map(|(at, axis)| {
            let first = block[axis] * BLOCK + at * SQUARE;
            first..(first + SQUARE + 1).min(self.size[axis])
        });
        Square {
            number: row * self.squares(block)[0] + column,
            columns,
            rows,
        }
    }

    /// Returns the start of a column (axis 0: x) or row (axis 1: z) of clusters of a block.
    pub(crate) fn square_border(&self, block: [u32; 2], square: u32, axis: usize) -> f64 {
        f64::from(self.line(block[axis] * BLOCK + square * SQUARE, axis))
    }

    /// Reads the heights of a block into `workplace`.
    pub(crate) fn read(&self, block: [u32; 2], workplace: &mut Workplace) {
        let [width, height] = [0, 1].map(|axis| self.cells(block, axis) as usize + 1);
        let rows = workplace.heights.chunks_exact_mut(width).take(height);
        for (row, heights) in (block[1] * BLOCK..).zip(rows) {
            self.heights.read(block[0] * BLOCK, row, heights);
        }
    }

    /// Returns the heights of a cluster of the block in `workplace`, row after row.
    fn rows_of<'a>(
        &self,
        square: &Square,
        block: [u32; 2],
        workplace: &'a Workplace,
    ) -> impl Iterator<Item = &'a [f32]> + use<'a> {
        let width = self.cells(block, 0) as usize + 1;
        let first = (square.columns.start - block[0] * BLOCK) as usize;
        let columns = first..first + square.columns.len();
        let top = (square.rows.start - block[1] * BLOCK) as usize;
        let rows = workplace.heights.chunks_exact(width).skip(top);
        rows.take(square.rows.len()).map(move |row| &row[columns.clone()])
    }

    /// Returns the AABB of a cluster of the block in `workplace`.
    pub(crate) fn bounds_in(&self, square: &Square, block: [u32; 2], workplace: &Workplace) -> Aabb {
        let rows = self.rows_of(square, block, workplace);
        let span = rows.fold(levels::NO_SPAN, levels::spanned);
        self.around(&square.columns, &square.rows, span)
    }

    /// Returns the vertex positions of a cluster of the block in `workplace`, row after row, and three indices into
    /// them per face.
    pub(crate) fn triangles<'a>(
        &'a self,
        square: &Square,
        block: [u32; 2],
        workplace: &'a mut Workplace,
    ) -> (&'a [[f32; 3]], &'a [u32]) {
        let mut positions = std::mem::take(&mut workplace.positions);
        positions.clear();
        for (row, heights) in square.rows.clone().zip(self.rows_of(square, block, workplace)) {
            let z = self.line(row, 1);
            let places = square.columns.clone().zip(heights);
            positions.extend(places.map(|(column, &height)| [self.line(column, 0), height, z]));
        }
        workplace.positions = positions;
        let [east, south] = self.is_narrow(square);
        (
            &workplace.positions,
            &self.corners[usize::from(east)][usize::from(south)],
        )
    }

    /// Returns whether a cluster has fewer cells than a full one from west to east and from north to south.
    fn is_narrow(&self, square: &Square) -> [bool; 2] {
        [&square.columns, &square.rows].map(|samples| samples.len() <= SQUARE as usize)
    }

    /// Computes the triangle indices of full clusters and of those at the eastern and southern border.
    fn cut(&mut self) {
        let widths = self.size.map(|side| match (side - 1) % SQUARE {
            0 => [SQUARE; 2],
            rest => [SQUARE, rest],
        });
        let corners = |[columns, rows]: [u32; 2]| {
            let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
            let cut = |[column, row]: [u32; 2]| {
                let north_west = row * (columns + 1) + column;
                let south_west = north_west + columns + 1;
                self.diagonal
                    .triangles([north_west, north_west + 1, south_west, south_west + 1])
            };
            cells.flat_map(cut).flatten().collect()
        };
        self.corners = widths[0].map(|columns| widths[1].map(|rows| corners([columns, rows])));
    }

    /// Returns the surface of a face. Panics if there is none.
    pub(crate) fn surface_of(&self, item: ItemIndex, face: u32) -> Surface {
        let block = self.block_at(item);
        let number = face / SQUARE_FACES;
        let columns = self.squares(block)[0];
        let square = self.square(block, [number % columns, number / columns]);
        let mut workplace = Workplace::default();
        self.read(block, &mut workplace);
        let (positions, corners) = self.triangles(&square, block, &mut workplace);
        let first = 3 * (face % SQUARE_FACES) as usize;
        let [a, b, c] =
            [0, 1, 2].map(|next| DVec3::from(positions[corners[first + next] as usize].map(f64::from)));
        let [red, green, blue] = self.color;
        Surface {
            normal: (b - a).cross(c - a).normalize_or_zero().as_vec3().into(),
            point: a.as_vec3().into(),
            color: [red, green, blue, 1.0],
            alpha: Alpha::Opaque,
        }
    }

    /// Returns the number of triangles of all blocks.
    pub(crate) fn triangle_count(&self) -> u64 {
        2 * u64::from(self.size[0] - 1) * u64::from(self.size[1] - 1)
    }

    pub(crate) fn triangles_of_block(&self, block: [u32; 2]) -> u64 {
        2 * u64::from(self.cells(block, 0)) * u64::from(self.cells(block, 1))
    }

    /// Returns the memory in bytes, without the heights, which the source holds.
    pub(crate) fn own_bytes(&self) -> u64 {
        let corners = self.corners.as_flattened().iter();
        self.levels.iter().map(Level::bytes).sum::<u64>()
            + corners.map(|corners| size_of_val(&**corners) as u64).sum::<u64>()
            + self.holes.bytes()
    }
}

/// Creates a geometry that has only openings.
fn only_openings(openings: Vec<Opening>) -> Result<Geometry, GeometryError> {
    let mut geometry = GeometryBuilder::new([] as [Material; 0]);
    for Opening { name, outline } in openings {
        geometry.opening(&name, outline);
    }
    geometry.build()
}

impl fmt::Debug for LargeTerrain {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_struct("LargeTerrain")
            .field("size", &self.size)
            .field("cell", &self.cell)
            .finish_non_exhaustive()
    }
}
