//! Directed portals, numbered by the cell they leave.

use crate::cells::Cells;
use crate::winding::{Plane, centre, newell, thickness};
use fearless_simd::Level;
use glam::DVec3;
use std::ops::Range;

/// A directed portal: leaves cell `from`, enters cell `to`.
#[derive(Clone, Debug)]
pub(crate) struct Way {
    /// Counter-clockwise about the direction of the way.
    pub(crate) corners: Vec<DVec3>,
    /// Its normal points along the way.
    pub(crate) plane: Plane,
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// Index of the same portal in the opposite direction.
    pub(crate) back: u32,
}

/// All directed portals; those out of one cell are consecutive.
#[derive(Debug)]
pub(crate) struct Ways {
    pub(crate) all: Vec<Way>,
    starts: Vec<u32>,
    /// Bounding spheres (centre, radius) of all ways, contiguous for loops over many ways.
    pub(crate) spheres: Vec<(DVec3, f64)>,
    /// Upper bound of the distance between two corners, and of a corner from the origin.
    pub(crate) size: f64,
    /// SIMD level of the machine; the result does not depend on it.
    pub(crate) level: Level,
}

/// Rounding error of a corner's height above a plane, relative to the size of the world, with a margin.
pub(crate) const ROUNDING: f64 = 1e-14;

impl Ways {
    pub(crate) fn of(cells: &Cells) -> Ways {
        let mut order: Vec<(u32, usize, usize)> = Vec::with_capacity(cells.portals().len() * 2);
        for (portal, of) in cells.portals().iter().enumerate() {
            order.push((of.cells[0], portal, 0));
            order.push((of.cells[1], portal, 1));
        }
        order.sort_unstable();
        let mut numbers = vec![[0u32; 2]; cells.portals().len()];
        let mut starts = vec![0u32; cells.count() as usize + 1];
        for (number, &(cell, portal, side)) in order.iter().enumerate() {
            numbers[portal][side] = number as u32;
            starts[cell as usize + 1] = number as u32 + 1;
        }
        for cell in 1..starts.len() {
            starts[cell] = starts[cell].max(starts[cell - 1]);
        }
        let size = size_of(cells);
        let all = order.iter().map(|&(from, portal, side)| {
            let of = &cells.portals()[portal];
            let mut corners: Vec<DVec3> = of.corners.iter().map(|&corner| corner.into()).collect();
            if side == 1 {
                corners.reverse();
            }
            let normal = newell(&corners).normalize();
            let centre = centre(&corners);
            let thick = thickness(&corners, normal);
            Way {
                // The slack includes the distance of snapped corners from the plane, to either side.
                plane: Plane {
                    normal,
                    offset: normal.dot(centre),
                    slack: thick + size * ROUNDING,
                },
                radius: corners
                    .iter()
                    .map(|&corner| (corner - centre).length())
                    .fold(0.0, f64::max),
                centre,
                corners,
                from,
                to: of.cells[1 - side],
                back: numbers[portal][1 - side],
            }
        });
        let all: Vec<Way> = all.collect();
        Ways {
            spheres: all.iter().map(|way| (way.centre, way.radius)).collect(),
            all,
            starts,
            size,
            level: Level::new(),
        }
    }

    pub(crate) fn count(&self) -> usize {
        self.all.len()
    }

    /// Returns the distance from portal edges, in units, at which a sampled ray certainly passes inside.
    pub(crate) fn clear(&self) -> f64 {
        self.size * 1e-12
    }

    pub(crate) fn cells(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the ways out of a cell.
    pub(crate) fn out_of(&self, cell: u32) -> Range<usize> {
        self.starts[cell as usize] as usize..self.starts[cell as usize + 1] as usize
    }
}

fn size_of(cells: &Cells) -> f64 {
    let corners = cells.portals().iter().flat_map(|portal| &portal.corners);
    let farthest = corners.flatten().fold(1.0, |most: f64, at| most.max(at.abs()));
    4.0 * farthest
}
