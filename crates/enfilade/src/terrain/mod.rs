//! Height fields (heightmaps): terrain with one height per grid sample.
//!
//! A cell between four samples is two triangles, split along the same [`Diagonal`] in all cells. Cells are grouped into
//! square blocks, one mesh each, so that every method can render terrain.
//! Source: original; axes as in glTF, x east, y up, z south.
//! Cost: O(samples).

mod carried;
mod diagonal;
#[cfg(test)]
mod tests;

pub use diagonal::Diagonal;

use crate::geom::{Aabb, MAX_COORDINATE, is_in_range};
use crate::ids::MaterialId;
use crate::mesh::{Indices, Mesh, Part, Vertices};
use carried::FieldAttributes;
use glam::DVec3;
use std::ops::Range;
use thiserror::Error;

/// Cells along a side of a block; blocks at the eastern and southern border may have fewer.
pub(crate) const BLOCK: u32 = 32;

/// Maximum number of samples along a side: 2¹⁶ cells.
const MAX_SAMPLES: u32 = (1 << 16) + 1;

/// A heightmap: heights at the samples of a grid.
///
/// Add it to a geometry with [`GeometryBuilder::terrain`](crate::GeometryBuilder::terrain). For terrain too large for
/// memory see [`LargeTerrain`](crate::LargeTerrain).
#[doc(alias = "heightmap")]
#[doc(alias = "terrain")]
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    size: [u32; 2],
    /// x of the columns and z of the rows, increasing.
    lines: [Vec<f32>; 2],
    heights: Vec<f32>,
    diagonal: Diagonal,
    /// User-defined vertex attributes instead of computed normals.
    vertex_attributes: Option<FieldAttributes>,
}

/// Why heights do not form a height field.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// Too few samples for a cell, or more than the maximum.
    #[error("a height field has 2 to {MAX_SAMPLES} samples along each side, but this one has {} x {}", .0[0], .0[1])]
    Size([u32; 2]),
    /// A cell size is not positive, or the field is longer than [`MAX_COORDINATE`].
    #[error("cells are {} long from west to east and {} from north to south; both must be above 0, and the whole field within {MAX_COORDINATE:e}", .0[0], .0[1])]
    Cell([f64; 2]),
    /// Column or row positions that do not increase, are NaN, or exceed [`MAX_COORDINATE`].
    #[error(
        "{what} {number} of a height field is at {position}; positions must increase from one {what} to the next and be within ±{MAX_COORDINATE:e}"
    )]
    Line {
        /// `column` or `row`.
        what: &'static str,
        /// Index, counted from the west or from the north.
        number: u32,
        /// Its x or z.
        position: f32,
    },
    /// The number of heights differs from the number of samples.
    #[error("{needs} heights are needed, but there are {has}")]
    Count {
        /// Expected number.
        needs: u64,
        /// Actual number.
        has: u64,
    },
    /// The number of bytes does not match the size and format.
    #[error("the heights need {needs} bytes, but there are {has}")]
    Bytes {
        /// Expected number.
        needs: u64,
        /// Actual number.
        has: u64,
    },
    /// More faces than face ids.
    #[error("terrain of this size needs {0} face ids, but there are only 4294907295")]
    Faces(u64),
    /// A height is NaN, which usually marks a hole, or infinite.
    #[error(
        "the height at column {column}, row {row} is {height}: terrain cannot have holes; fill it, or split the field around it"
    )]
    Hole {
        /// Column, counted from the west.
        column: u32,
        /// Row, counted from the north.
        row: u32,
        /// The value.
        height: f32,
    },
    /// A height is beyond [`MAX_COORDINATE`].
    #[error("the height at column {column}, row {row} is {height}, which is not within {MAX_COORDINATE:e}")]
    TooFar {
        /// Column, counted from the west.
        column: u32,
        /// Row, counted from the north.
        row: u32,
        /// The value.
        height: f32,
    },
    /// The stride of an attribute is shorter than an entry.
    #[error("the {what} have a stride of {stride} bytes, but take {least}")]
    AttributeStride {
        /// Name of the attribute.
        what: &'static str,
        /// The stride, in bytes.
        stride: usize,
        /// Size of an entry, in bytes.
        least: usize,
    },
    /// An attribute list has not one entry per sample.
    #[error("{needs} {what} are needed, or none, but there are {has}")]
    AttributeCount {
        /// Name of the attribute.
        what: &'static str,
        /// Number of samples.
        needs: u64,
        /// Number of entries.
        has: u64,
    },
    /// An attribute is NaN or infinite.
    #[error("{what} of a height field are not all finite")]
    AttributeNotFinite {
        /// Name of the attribute.
        what: &'static str,
    },
}

impl HeightField {
    /// Creates a field of `size` samples (west to east, north to south), spaced `cell` units along x and z. The first
    /// sample is at x = 0, z = 0. `heights` are y, row after row from the north, each row from west to east.
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

    /// Creates a field with a non-uniform grid: `columns` are the x and `rows` the z of the samples, each at least 2
    /// increasing numbers. Heights as for [`HeightField::new`].
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
                let (number, position) = (at as u32, lines[at]);
                return Err(HeightFieldError::Line {
                    what,
                    number,
                    position,
                });
            }
        }
        HeightField::on(lines, size, heights.into())
    }

    /// Creates a field on checked grid lines.
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
            vertex_attributes: None,
        })
    }

    /// Returns the field with its cells split along the given diagonal.
    pub fn cut_along(self, diagonal: Diagonal) -> HeightField {
        HeightField { diagonal, ..self }
    }

    /// Returns the number of samples from west to east and from north to south.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the position of a sample. Panics if there is none.
    pub fn position(&self, column: u32, row: u32) -> [f32; 3] {
        let [columns, rows] = &self.lines;
        [
            columns[column as usize],
            self.height(column, row),
            rows[row as usize],
        ]
    }

    /// Returns the diagonal along which its cells are split.
    pub fn diagonal(&self) -> Diagonal {
        self.diagonal
    }

    /// Returns the AABB of the samples of a block.
    pub(crate) fn bounds_of(&self, block: [u32; 2]) -> Aabb {
        let [columns, rows] = self.samples_of(block);
        let row = |row| columns.clone().map(move |column| self.position(column, row));
        Aabb::of(rows.flat_map(row))
    }

    /// Returns the number of blocks from west to east and from north to south.
    pub fn blocks(&self) -> [u32; 2] {
        self.size.map(|side| (side - 1).div_ceil(BLOCK))
    }

    /// Returns the sample columns and rows of a block, given the block's column and row.
    pub fn samples_of(&self, block: [u32; 2]) -> [Range<u32>; 2] {
        [0, 1].map(|axis| {
            let first = block[axis] * BLOCK;
            first..(first + BLOCK + 1).min(self.size[axis])
        })
    }

    fn height(&self, column: u32, row: u32) -> f32 {
        self.heights[self.place(column, row)]
    }

    /// Returns the index of a sample.
    fn place(&self, column: u32, row: u32) -> usize {
        row as usize * self.size[0] as usize + column as usize
    }

    /// Builds the mesh of a block, cell by cell.
    pub(crate) fn mesh_of(&self, block: [u32; 2], material: MaterialId) -> Mesh {
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
        let vertex_attributes = match &self.vertex_attributes {
            Some(vertex_attributes) => vertex_attributes.at(&places),
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
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(&corners),
            sides: None,
            material,
            attributes: vertex_attributes.attributes(),
        };
        Mesh::new(&[part]).expect("finite positions and attributes form a valid mesh")
    }

    /// Computes vertex normals for a range of columns and rows.
    fn smooth(&self, [columns, rows]: [Range<u32>; 2]) -> FieldAttributes {
        let row = |row| columns.clone().map(move |column| self.normal(column, row));
        FieldAttributes {
            normals: rows.flat_map(row).collect(),
            ..FieldAttributes::default()
        }
    }

    /// Computes the unit normal at a sample by central differences.
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

pub(crate) fn check_size(size: [u32; 2]) -> Result<(), HeightFieldError> {
    if size.iter().any(|side| !(2..=MAX_SAMPLES).contains(side)) {
        return Err(HeightFieldError::Size(size));
    }
    Ok(())
}

/// Returns the error for a height that is not in range.
pub(crate) fn bad_height(column: u32, row: u32, height: f32) -> HeightFieldError {
    if height.is_finite() {
        HeightFieldError::TooFar { column, row, height }
    } else {
        HeightFieldError::Hole { column, row, height }
    }
}

pub(crate) fn check_cell(size: [u32; 2], cell: [f64; 2]) -> Result<(), HeightFieldError> {
    let is_sound = |axis: usize| {
        let end = cell[axis] * f64::from(size[axis]);
        cell[axis] as f32 > 0.0 && end <= f64::from(MAX_COORDINATE)
    };
    if !(is_sound(0) && is_sound(1)) {
        return Err(HeightFieldError::Cell(cell));
    }
    Ok(())
}
