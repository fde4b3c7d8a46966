//! Convex cells and the portals between them, validated.

use crate::winding::{newell, thickness};
use glam::DVec3;
use thiserror::Error;

/// A convex opening between two cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// Corners in order, in scene units; flat and convex. The polygon is clockwise as seen from the first of the two
    /// cells: its counter-clockwise normal points into the second cell.
    pub corners: Vec<[f64; 3]>,
    /// Indices of the two cells.
    pub cells: [u32; 2],
}

/// Convex cells, each bounded by its walls and portals, and the portals between them.
///
/// Walls are not stored: everything that is not a portal is opaque. A slightly non-convex cell (corners snapped to a
/// grid) is harmless as long as each line of sight leaves a cell only through portals that face outwards and enters no
/// cell twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    count: u32,
    portals: Vec<Portal>,
}

/// The rule that a portal breaks.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CellsError {
    /// A portal with fewer than three corners.
    #[error("portal {portal} has {corners} corners; at least 3 are needed")]
    TooFewCorners {
        /// Index of the portal.
        portal: usize,
        /// Number of its corners.
        corners: usize,
    },
    /// A coordinate that is NaN, infinite, or beyond ±10⁷ units.
    #[error("portal {portal} has a corner coordinate of {at}; coordinates must be within ±10,000,000")]
    OutOfRange {
        /// Index of the portal.
        portal: usize,
        /// The coordinate.
        at: f64,
    },
    /// A portal whose corners are collinear.
    #[error("portal {portal} has no area")]
    NoArea {
        /// Index of the portal.
        portal: usize,
    },
    /// A portal with a corner more than [`Cells::FLATNESS`] off its plane.
    #[error("portal {portal} is not flat: a corner is {off:.3} units off its plane")]
    NotFlat {
        /// Index of the portal.
        portal: usize,
        /// Largest distance of a corner from the plane, in units.
        off: f64,
    },
    /// A portal with a reflex or repeated corner.
    #[error("portal {portal} is not convex at its corner {corner}")]
    NotConvex {
        /// Index of the portal.
        portal: usize,
        /// Index of the corner.
        corner: usize,
    },
    /// A cell index out of range.
    #[error("portal {portal} leads to cell {cell}, but there are only {cells}")]
    NoSuchCell {
        /// Index of the portal.
        portal: usize,
        /// The cell index.
        cell: u32,
        /// Number of cells.
        cells: u32,
    },
    /// A portal with the same cell on both sides.
    #[error("portal {portal} leads from cell {cell} to itself")]
    SameCell {
        /// Index of the portal.
        portal: usize,
        /// Index of the cell.
        cell: u32,
    },
}

impl CellsError {
    /// Returns the index of the portal that breaks the rule.
    pub fn portal(&self) -> usize {
        match *self {
            CellsError::TooFewCorners { portal, .. }
            | CellsError::OutOfRange { portal, .. }
            | CellsError::NoArea { portal }
            | CellsError::NotFlat { portal, .. }
            | CellsError::NotConvex { portal, .. }
            | CellsError::NoSuchCell { portal, .. }
            | CellsError::SameCell { portal, .. } => portal,
        }
    }
}

impl Cells {
    /// Tolerance of a portal's corners, in units: off its plane, and inside the line through the two neighbours. It
    /// accepts what map compilers that snap corners leave.
    pub const FLATNESS: f64 = 0.1;

    /// Creates `count` cells with the portals between them.
    ///
    /// # Errors
    /// The first portal that is not a flat, convex polygon with coordinates within ±10⁷ between two different cells.
    pub fn new(count: u32, portals: Vec<Portal>) -> Result<Cells, CellsError> {
        for (number, portal) in portals.iter().enumerate() {
            check(number, portal, count)?;
        }
        Ok(Cells { count, portals })
    }

    /// Returns the number of cells.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the portals in the order given to [`Cells::new`].
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }
}

/// Largest absolute coordinate of a corner, in units.
const FARTHEST: f64 = 1e7;

fn check(number: usize, portal: &Portal, cells: u32) -> Result<(), CellsError> {
    let [from, to] = portal.cells;
    if let Some(&cell) = portal.cells.iter().find(|&&cell| cell >= cells) {
        return Err(CellsError::NoSuchCell {
            portal: number,
            cell,
            cells,
        });
    }
    if from == to {
        return Err(CellsError::SameCell {
            portal: number,
            cell: from,
        });
    }
    if portal.corners.len() < 3 {
        return Err(CellsError::TooFewCorners {
            portal: number,
            corners: portal.corners.len(),
        });
    }
    if let Some(&at) = portal
        .corners
        .iter()
        .flatten()
        .find(|at| at.is_nan() || at.abs() > FARTHEST)
    {
        return Err(CellsError::OutOfRange { portal: number, at });
    }
    let corners: Vec<DVec3> = portal.corners.iter().map(|&corner| corner.into()).collect();
    let Some(normal) = newell(&corners).try_normalize() else {
        return Err(CellsError::NoArea { portal: number });
    };
    let off = thickness(&corners, normal);
    if off > Cells::FLATNESS {
        return Err(CellsError::NotFlat { portal: number, off });
    }
    for at in 0..corners.len() {
        let before = corners[(at + corners.len() - 1) % corners.len()];
        let [here, after] = [corners[at], corners[(at + 1) % corners.len()]];
        // Signed distance of the corner outside the line through its neighbours, times the distance of those two.
        let inside = normal.dot((here - before).cross(after - before));
        if inside < -Cells::FLATNESS * (after - before).length() || here == after {
            return Err(CellsError::NotConvex {
                portal: number,
                corner: at,
            });
        }
    }
    Ok(())
}
