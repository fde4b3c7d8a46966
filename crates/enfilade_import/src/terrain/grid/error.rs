//! Errors of recognising a grid of heights.

use crate::spoken::short;
use enfilade::HeightFieldError;
use std::fmt;
use thiserror::Error;

/// A grid point: the intersection of a column and a row, or the north-west corner of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlace {
    /// Column, from the west (−x), from 0.
    pub column: u32,
    /// Row, from the north (−z), from 0.
    pub row: u32,
    /// x in object space.
    pub x: f32,
    /// z in object space.
    pub z: f32,
}

impl fmt::Display for GridPlace {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let GridPlace { column, row, x, z } = *self;
        let [x, z] = [x, z].map(|value| short(value.into()));
        write!(f, "column {column}, row {row} (x {x}, z {z} in object space)")
    }
}

/// Why a mesh is not a grid of heights: y up, one height at each intersection of a column and a row, and two triangles
/// in each cell between them.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GridError {
    /// The mesh has no vertex at an intersection: it is not a grid, or has a hole.
    #[error(
        "its vertices are in {columns} columns and {rows} rows, but there is none at {place}; fill the hole, or split the \
         terrain around it, and check that the mesh itself has y up"
    )]
    NoCorner {
        /// Number of different x.
        columns: u32,
        /// Number of different z.
        rows: u32,
        /// The first such intersection, row by row.
        place: GridPlace,
    },
    /// Two vertices are above each other.
    #[error(
        "it has the heights {} and {} at {place}; remove one of them, and check that the mesh itself has y up",
        short(heights[0].into()), short(heights[1].into())
    )]
    TwoHeights {
        /// Two of the heights.
        heights: [f32; 2],
        /// The grid point.
        place: GridPlace,
    },
    /// The vertices at a grid point have different texture coordinates or colors.
    #[error("it has two {what} at {place}; weld the seam there, or split the terrain along it")]
    Seam {
        /// The attribute that differs.
        what: &'static str,
        /// The grid point.
        place: GridPlace,
    },
    /// A triangle is not half of a cell.
    #[error(
        "a triangle with a corner at {place} spans more than one cell; split every cell into two triangles, and use the same \
         columns and rows for all"
    )]
    Across {
        /// One of its corners.
        place: GridPlace,
    },
    /// A cell has only one triangle, or none.
    #[error("the cell south-east of {place} lacks a triangle; fill the hole, or split the terrain around it")]
    Hole {
        /// The north-west corner of the cell.
        place: GridPlace,
    },
    /// A cell has overlapping triangles.
    #[error(
        "the cell south-east of {place} has overlapping triangles; keep only the two that make up the cell"
    )]
    Overlap {
        /// The north-west corner of the cell.
        place: GridPlace,
    },
    /// A triangle faces down.
    #[error(
        "a triangle in the cell south-east of {place} faces down; flip it, because terrain is visible only from above"
    )]
    FacesDown {
        /// The north-west corner of the cell.
        place: GridPlace,
    },
    /// A cell is split along another diagonal than the first cell.
    #[error(
        "the cell south-east of {place} is split along another diagonal than the first; split all cells alike before \
         exporting"
    )]
    Diagonals {
        /// The north-west corner of the cell.
        place: GridPlace,
    },
    /// The [`HeightField`](enfilade::HeightField) rejects the grid.
    #[error("{0}; split it, or join it with the adjacent terrain")]
    Field(HeightFieldError),
}
