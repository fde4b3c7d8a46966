//! Why a mesh is no grid of heights.

use crate::spoken::short;
use enfilade::HeightFieldError;
use std::fmt;
use thiserror::Error;

/// Where columns and rows of a grid cross, or the corner north-west of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlace {
    /// Counted from the west, which is −x.
    pub column: u32,
    /// Counted from the north, which is −z.
    pub row: u32,
    /// In the space of the mesh.
    pub x: f32,
    /// In the space of the mesh.
    pub z: f32,
}

impl fmt::Display for GridPlace {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let GridPlace { column, row, x, z } = *self;
        let [x, z] = [x, z].map(|value| short(value.into()));
        write!(f, "column {column}, row {row} (x {x}, z {z} in its own space)")
    }
}

/// Why a mesh is no grid of heights: y up, one height at each place where a column and a row cross, and between them cells
/// of two triangles each.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GridError {
    /// Columns and rows cross where the mesh has no corner: it is no grid, or has a hole.
    #[error(
        "its corners stand in {columns} columns and {rows} rows, but none at {place}; fill the hole, or cut the terrain in parts \
         around it, and check that the mesh itself has y up"
    )]
    NoCorner {
        /// Of different x.
        columns: u32,
        /// Of different z.
        rows: u32,
        /// The first such place, row after row.
        place: GridPlace,
    },
    /// One corner over another.
    #[error(
        "it has the heights {} and {} at {place}; leave one of them, and check that the mesh itself has y up",
        short(heights[0].into()), short(heights[1].into())
    )]
    TwoHeights {
        /// Two of them.
        heights: [f32; 2],
        /// Where.
        place: GridPlace,
    },
    /// Corners at one place that differ in what can only be the same all around it.
    #[error("it has two {what} at {place}; weld the seam there, or cut the terrain in two along it")]
    Seam {
        /// In what they differ.
        what: &'static str,
        /// Where.
        place: GridPlace,
    },
    /// A triangle that is no half of a cell.
    #[error(
        "a triangle with a corner at {place} reaches over more than one cell; cut every cell in two triangles, all of the \
         same columns and rows"
    )]
    Across {
        /// One of its corners.
        place: GridPlace,
    },
    /// A cell of one triangle, or of none.
    #[error(
        "the cell south-east of {place} lacks a triangle; fill the hole, or cut the terrain in parts around it"
    )]
    Hole {
        /// Its corner north-west.
        place: GridPlace,
    },
    /// Triangles over one another.
    #[error(
        "triangles lie over one another in the cell south-east of {place}; leave two that make up the cell"
    )]
    Overlap {
        /// Its corner north-west.
        place: GridPlace,
    },
    /// A triangle whose front is below.
    #[error(
        "a triangle in the cell south-east of {place} faces down; flip it, for terrain is seen from above"
    )]
    FacesDown {
        /// The cell's corner north-west.
        place: GridPlace,
    },
    /// A cell that is cut otherwise than the first.
    #[error(
        "the cell south-east of {place} is cut in triangles along another diagonal than the first; cut all alike before \
         exporting"
    )]
    Diagonals {
        /// Its corner north-west.
        place: GridPlace,
    },
    /// What is left to the field to check.
    #[error("{0}; cut it in parts, or join it with what is beside it")]
    Field(HeightFieldError),
}
