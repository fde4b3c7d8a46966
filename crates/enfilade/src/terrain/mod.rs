//! Height fields: ground of which one height is known at each place of a grid.
//!
//! A cell between four places is two triangles, parted by the same [`Diagonal`] in all. Cells are taken together in square
//! blocks, each a mesh, so that any method can see a terrain.
//! Source: ours; the axes as in glTF, with north ahead: x goes east, y up, z south.
//! Cost: O(samples).

mod carried;
mod diagonal;
mod large;
#[cfg(test)]
mod tests;

pub use diagonal::Diagonal;
pub(crate) use large::Workplace;
pub use large::{HeightBytes, HeightFormat, Heights, LargeTerrain};

use crate::geom::{MAX_COORDINATE, Transform, is_in_range};
use crate::geometry::{Geometry, GeometryBuilder, GeometryError, ItemId, MaterialId, MeshId};
use crate::mesh::{Mesh, Part};
use carried::Carried;
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

/// Cells along a side of a block; those at the east and the south end may have fewer.
const BLOCK: u32 = 32;

/// The most samples along a side: 2¹⁶ cells.
const MAX_SAMPLES: u32 = (1 << 16) + 1;

/// Heights at the places of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    size: [u32; 2],
    /// x of the columns and z of the rows, which grow.
    lines: [Vec<f32>; 2],
    heights: Vec<f32>,
    diagonal: Diagonal,
    /// What is there instead of normals made of the heights.
    carried: Option<Carried>,
}

/// Why heights make no field.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// There is no cell, or there are more than are numbered.
    #[error("a height field has 2 to {MAX_SAMPLES} samples along each side, but this one has {} x {}", .0[0], .0[1])]
    Size([u32; 2]),
    /// A cell has no length, or all together are longer than [`MAX_COORDINATE`].
    #[error("cells are {} long from west to east and {} from north to south; that must be above 0, and all of them within {MAX_COORDINATE:e}", .0[0], .0[1])]
    Cell([f64; 2]),
    /// A column that is not east of the one before it, or a row that is not south of it; or NaN, or beyond
    /// [`MAX_COORDINATE`].
    #[error(
        "{what} {number} of a height field stands at {place}, which is not beyond the one before it, or is not within {MAX_COORDINATE:e}"
    )]
    Line {
        /// Columns or rows.
        what: &'static str,
        /// Which of them, counted from the west or from the north.
        number: u32,
        /// Its x, or z.
        place: f32,
    },
    /// Not one height for each place.
    #[error("{needs} heights are needed, but {has} are there")]
    Count {
        /// How many there should be.
        needs: u64,
        /// How many there are.
        has: u64,
    },
    /// Not as many bytes as the heights take.
    #[error("heights of {needs} bytes are needed, but {has} are there")]
    Bytes {
        /// How many there should be.
        needs: u64,
        /// How many there are.
        has: u64,
    },
    /// More faces than are numbered.
    #[error("blocks of so many samples take {0} numbers of faces, but there are no more than 4294907295")]
    Faces(u64),
    /// NaN, which stands for a hole as a rule, or infinite.
    #[error(
        "the height at column {column}, row {row} is {height}: terrain has no holes. Fill it, or cut the field in parts around it"
    )]
    Hole {
        /// Counted from the west.
        column: u32,
        /// Counted from the north.
        row: u32,
        /// What stands there.
        height: f32,
    },
    /// A height beyond [`MAX_COORDINATE`].
    #[error("the height at column {column}, row {row} is {height}, which is not within {MAX_COORDINATE:e}")]
    TooFar {
        /// Counted from the west.
        column: u32,
        /// Counted from the north.
        row: u32,
        /// What stands there.
        height: f32,
    },
    /// What places carry is not there for each of them.
    #[error("{needs} {what} are needed, or none, but {has} are there")]
    AttributeCount {
        /// Which of them.
        what: &'static str,
        /// How many places there are.
        needs: u64,
        /// How many of them there are.
        has: u64,
    },
    /// What a place carries is NaN or infinite.
    #[error("{what} of a height field are not all finite")]
    AttributeNotFinite {
        /// Which of them.
        what: &'static str,
    },
}

impl HeightField {
    /// `size` samples from west to east and from north to south, of which the first stands at x = 0, z = 0, and the next ones
    /// `cell` lengths on; their heights y, row after row, the northern first.
    ///
    /// # Errors
    /// A [`HeightFieldError`] for the first broken rule.
    pub fn new(
        size: [u32; 2],
        cell: [f64; 2],
        heights: impl Into<Vec<f32>>,
    ) -> Result<HeightField, HeightFieldError> {
        check_size(size)?;
        check_cell(size, cell)?;
        let lines = [0, 1].map(|axis| {
            let place = |line| (f64::from(line) * cell[axis]) as f32;
            (0..size[axis]).map(place).collect()
        });
        HeightField::on(lines, size, heights.into())
    }

    /// Samples where columns and rows cross: `columns` are the x of those that go from north to south, `rows` the z of those
    /// from west to east, each at least 2 numbers that grow, their steps as they like; heights as for [`HeightField::new`].
    ///
    /// # Errors
    /// A [`HeightFieldError`] for the first broken rule.
    pub fn on_lines(
        columns: impl Into<Vec<f32>>,
        rows: impl Into<Vec<f32>>,
        heights: impl Into<Vec<f32>>,
    ) -> Result<HeightField, HeightFieldError> {
        let lines = [columns.into(), rows.into()];
        let size = [0, 1].map(|axis: usize| u32::try_from(lines[axis].len()).unwrap_or(u32::MAX));
        check_size(size)?;
        for (what, lines) in ["column", "row"].into_iter().zip(&lines) {
            let is_sound = |at: usize| is_in_range(lines[at]) && (at == 0 || lines[at - 1] < lines[at]);
            if let Some(at) = (0..lines.len()).find(|&at| !is_sound(at)) {
                let (number, place) = (at as u32, lines[at]);
                return Err(HeightFieldError::Line { what, number, place });
            }
        }
        HeightField::on(lines, size, heights.into())
    }

    /// Heights on sound lines.
    fn on(lines: [Vec<f32>; 2], size: [u32; 2], heights: Vec<f32>) -> Result<HeightField, HeightFieldError> {
        let needs = u64::from(size[0]) * u64::from(size[1]);
        if needs != heights.len() as u64 {
            let has = heights.len() as u64;
            return Err(HeightFieldError::Count { needs, has });
        }
        if let Some(at) = heights.iter().position(|&height| !is_in_range(height)) {
            let columns = size[0] as usize;
            let [column, row] = [at % columns, at / columns].map(|number| number as u32);
            return Err(bad_height(column, row, heights[at]));
        }
        Ok(HeightField {
            size,
            lines,
            heights,
            diagonal: Diagonal::default(),
            carried: None,
        })
    }

    /// The same field, its cells cut along another diagonal.
    pub fn cut_along(self, diagonal: Diagonal) -> HeightField {
        HeightField { diagonal, ..self }
    }

    /// Samples from west to east and from north to south.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Where a sample stands. There must be one.
    pub fn position(&self, column: u32, row: u32) -> [f32; 3] {
        let [columns, rows] = &self.lines;
        [
            columns[column as usize],
            self.height(column, row),
            rows[row as usize],
        ]
    }

    /// Blocks from west to east and from north to south.
    pub fn blocks(&self) -> [u32; 2] {
        self.size.map(|side| (side - 1).div_ceil(BLOCK))
    }

    /// The columns and rows of the samples of a block, by its own column and row.
    pub fn samples_of(&self, block: [u32; 2]) -> [Range<u32>; 2] {
        [0, 1].map(|axis| {
            let first = block[axis] * BLOCK;
            first..(first + BLOCK + 1).min(self.size[axis])
        })
    }

    fn height(&self, column: u32, row: u32) -> f32 {
        self.heights[self.place(column, row)]
    }

    /// The number of a place among all.
    fn place(&self, column: u32, row: u32) -> usize {
        row as usize * self.size[0] as usize + column as usize
    }

    /// A block as a mesh, cell by cell.
    fn mesh_of(&self, block: [u32; 2], material: MaterialId) -> Mesh {
        let [columns, rows] = self.samples_of(block);
        let width = columns.len() as u32;
        let mut positions = Vec::with_capacity(columns.len() * rows.len());
        let mut places = Vec::with_capacity(columns.len() * rows.len());
        let mut corners = Vec::with_capacity(6 * (columns.len() - 1) * (rows.len() - 1));
        for row in rows.clone() {
            for column in columns.clone() {
                positions.push(self.position(column, row));
                places.push(self.place(column, row));
            }
        }
        let carried = match &self.carried {
            Some(carried) => carried.at(&places),
            None => self.smooth([columns.clone(), rows.clone()]),
        };
        for row in 0..rows.len() as u32 - 1 {
            for column in 0..width - 1 {
                let north_west = row * width + column;
                let [north_east, south_west] = [north_west + 1, north_west + width];
                let cell = [north_west, north_east, south_west, south_west + 1];
                corners.extend(self.diagonal.triangles(cell).as_flattened());
            }
        }
        let part = Part {
            positions: &positions,
            corners: &corners,
            sides: None,
            material,
            attributes: carried.attributes(),
        };
        Mesh::new(&[part]).expect("heights and places are finite, and triangles need no more")
    }

    /// Normals made of the heights, for some columns and rows.
    fn smooth(&self, [columns, rows]: [Range<u32>; 2]) -> Carried {
        let row = |row| columns.clone().map(move |column| self.normal(column, row));
        Carried {
            normals: rows.flat_map(row).collect(),
            ..Carried::default()
        }
    }

    /// Upright on the ground at a sample, by the neighbours around it.
    fn normal(&self, column: u32, row: u32) -> [f32; 3] {
        let along = |at: u32, axis: usize| [at.saturating_sub(1), (at + 1).min(self.size[axis] - 1)];
        let [west, east] = along(column, 0).map(|column| f64::from(self.height(column, row)));
        let [north, south] = along(row, 1).map(|row| f64::from(self.height(column, row)));
        let [across, down] = [(column, 0), (row, 1)].map(|(at, axis)| {
            let [before, after] = along(at, axis).map(|line| f64::from(self.lines[axis][line as usize]));
            after - before
        });
        let normal = DVec3::new((west - east) / across, 1.0, (north - south) / down);
        normal.normalize_or_zero().as_vec3().to_array()
    }
}

fn check_size(size: [u32; 2]) -> Result<(), HeightFieldError> {
    if size.iter().any(|side| !(2..=MAX_SAMPLES).contains(side)) {
        return Err(HeightFieldError::Size(size));
    }
    Ok(())
}

/// Why a height that is not in range is refused.
fn bad_height(column: u32, row: u32, height: f32) -> HeightFieldError {
    if height.is_finite() {
        HeightFieldError::TooFar { column, row, height }
    } else {
        HeightFieldError::Hole { column, row, height }
    }
}

fn check_cell(size: [u32; 2], cell: [f64; 2]) -> Result<(), HeightFieldError> {
    let is_sound = |axis: usize| {
        let end = cell[axis] * f64::from(size[axis]);
        cell[axis] as f32 > 0.0 && end <= f64::from(MAX_COORDINATE)
    };
    if !(is_sound(0) && is_sound(1)) {
        return Err(HeightFieldError::Cell(cell));
    }
    Ok(())
}

/// A height field in a geometry.
#[derive(Clone, Debug)]
pub(crate) struct Terrain {
    pub(crate) field: Arc<HeightField>,
    /// The numbers of the items that are its blocks.
    pub(crate) blocks: Range<u32>,
    /// The mesh of the first block; the others' follow.
    first_mesh: MeshId,
    pub(crate) sector_from_field: Transform,
}

impl Terrain {
    /// Are all blocks still there, and as they were?
    pub(crate) fn is_whole(&self, geometry: &Geometry) -> bool {
        let place = self.sector_from_field.columns();
        self.blocks.clone().zip(self.first_mesh.0..).all(|(block, mesh)| {
            let item = geometry.items().get(block as usize);
            item.is_some_and(|item| item.mesh == MeshId(mesh) && item.sector_from_item == place)
        })
    }
}

impl GeometryBuilder {
    /// Adds the blocks of a height field as items, row after row, the northern first and each from west to east. They are called
    /// `NAME ROW COLUMN`, by numbers of blocks. Gives their numbers.
    ///
    /// # Errors
    /// As [`GeometryBuilder::build`], where there would be more faces than are numbered.
    pub fn terrain(
        &mut self,
        name: &str,
        field: impl Into<Arc<HeightField>>,
        material: MaterialId,
        sector_from_field: Transform,
    ) -> Result<Range<ItemId>, GeometryError> {
        let field = field.into();
        let faces = 2 * field
            .size()
            .map(|side| u64::from(side - 1))
            .iter()
            .product::<u64>();
        if faces > u64::from(u32::MAX) {
            return Err(GeometryError::TooManyFaces(faces));
        }
        let [columns, rows] = field.blocks();
        let mut first = None;
        for row in 0..rows {
            for column in 0..columns {
                let mesh = self.mesh(field.mesh_of([column, row], material));
                let item = self.item(&format!("{name} {row} {column}"), mesh, sector_from_field);
                first.get_or_insert((item, mesh));
            }
        }
        let (first_item, first_mesh) = first.expect("a field has a block at least");
        let blocks = first_item.0..first_item.0 + columns * rows;
        self.terrains.push(Terrain {
            field,
            blocks: blocks.clone(),
            first_mesh,
            sector_from_field,
        });
        Ok(ItemId(blocks.start)..ItemId(blocks.end))
    }
}
