//! Convex cells and the portals between them, checked.

use crate::winding::{newell, thickness};
use glam::DVec3;
use thiserror::Error;

/// A hole between two cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Portal {
    /// Its corners in order, in scene units; flat and convex. Seen from the first of the two cells they turn
    /// clockwise: their counter-clockwise normal points into the second.
    pub corners: Vec<[f64; 3]>,
    /// The two cells, numbered from 0.
    pub cells: [u32; 2],
}

/// Cells, each the convex space that its portals and walls bound, and the portals between them.
///
/// The walls are not needed: what is no portal lets nothing through. A cell that is not quite convex (corners snapped
/// to a grid) does no harm as long as a line of sight is what crosses each portal out of the cell it leaves, and enters
/// no cell twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    count: u32,
    portals: Vec<Portal>,
}

/// Why cells and portals do not fit together.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CellsError {
    /// Fewer than three corners.
    #[error("portal {portal} has {corners} corners; at least 3 are needed")]
    TooFewCorners {
        /// Which portal.
        portal: usize,
        /// How many it has.
        corners: usize,
    },
    /// A corner that is no place, or farther out than 10⁷ units.
    #[error("portal {portal} has a corner at {at}; only numbers up to ten million are places")]
    NoPlace {
        /// Which portal.
        portal: usize,
        /// The number.
        at: f64,
    },
    /// All corners in one line.
    #[error("portal {portal} has no area")]
    NoArea {
        /// Which portal.
        portal: usize,
    },
    /// Corners too far from its plane.
    #[error("portal {portal} is not flat: a corner is {off} units off its plane")]
    NotFlat {
        /// Which portal.
        portal: usize,
        /// How far a corner is off, in units.
        off: f64,
    },
    /// A corner that turns the wrong way.
    #[error("portal {portal} is not convex at its corner {corner}")]
    NotConvex {
        /// Which portal.
        portal: usize,
        /// Which corner, from 0.
        corner: usize,
    },
    /// A number that names no cell.
    #[error("portal {portal} leads to cell {cell}, but there are only {cells}")]
    NoSuchCell {
        /// Which portal.
        portal: usize,
        /// What it names.
        cell: u32,
        /// How many there are.
        cells: u32,
    },
    /// Both sides in one cell.
    #[error("portal {portal} leads from cell {cell} to itself")]
    SameCell {
        /// Which portal.
        portal: usize,
        /// Which cell.
        cell: u32,
    },
}

impl CellsError {
    /// The portal that breaks the rule, counted from 0.
    pub fn portal(&self) -> usize {
        match *self {
            CellsError::TooFewCorners { portal, .. }
            | CellsError::NoPlace { portal, .. }
            | CellsError::NoArea { portal }
            | CellsError::NotFlat { portal, .. }
            | CellsError::NotConvex { portal, .. }
            | CellsError::NoSuchCell { portal, .. }
            | CellsError::SameCell { portal, .. } => portal,
        }
    }
}

impl Cells {
    /// How far corners may be off a portal's plane, and inside the line through their neighbours: 0.1 unit, what
    /// compilers of maps that snap corners leave.
    pub const FLATNESS: f64 = 0.1;

    /// `count` cells and the portals between them.
    ///
    /// # Errors
    ///
    /// The first portal that is not flat, convex, of finite corners, and between two of the cells.
    pub fn new(count: u32, portals: Vec<Portal>) -> Result<Cells, CellsError> {
        for (number, portal) in portals.iter().enumerate() {
            check(number, portal, count)?;
        }
        Ok(Cells { count, portals })
    }

    /// How many cells there are.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// The portals, in the order in which they were given.
    pub fn portals(&self) -> &[Portal] {
        &self.portals
    }
}

/// How far out a corner may be, in units.
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
        return Err(CellsError::NoPlace { portal: number, at });
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
        // How far the corner stands inside the line through its neighbours.
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
