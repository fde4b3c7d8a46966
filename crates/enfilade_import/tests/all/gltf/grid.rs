//! Meshes that are grids of heights.

use super::file::File;
use serde_json::json;

/// A grid of corners, and of triangles over them.
pub(crate) struct Grid {
    pub(crate) size: [u16; 2],
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) corners: Vec<u16>,
}

impl Grid {
    /// Columns and rows with irregular steps, and diagonals from north-east to south-west.
    pub(crate) fn at(size: [u16; 2], x: impl Fn(u16) -> f32, z: impl Fn(u16) -> f32) -> Grid {
        let places = (0..size[1]).flat_map(|row| (0..size[0]).map(move |column| (column, row)));
        let height = |column: u16, row: u16| f32::from((column * 7 + row * 5) % 11) * 0.3;
        Grid {
            size,
            positions: places
                .map(|(column, row)| [x(column), height(column, row), z(row)])
                .collect(),
            corners: cells(size, |[nw, ne, sw, se]| [nw, sw, ne, ne, sw, se]),
        }
    }

    /// With steps of one from 0.
    pub(crate) fn new(size: [u16; 2]) -> Grid {
        Grid::at(size, f32::from, f32::from)
    }

    /// The same, its diagonals from north-west to south-east.
    pub(crate) fn cut_otherwise(mut self) -> Grid {
        self.corners = cells(self.size, |[nw, ne, sw, se]| [nw, sw, se, nw, se, ne]);
        self
    }

    /// The same, without shared vertices.
    pub(crate) fn split(&self) -> Grid {
        let own = self
            .corners
            .iter()
            .map(|&corner| self.positions[usize::from(corner)]);
        Grid {
            size: self.size,
            positions: own.collect(),
            corners: (0..self.corners.len() as u16).collect(),
        }
    }

    /// A file of one node, `hill-terrain`, that shows it.
    pub(crate) fn file(&self) -> File {
        let mut file = File::empty();
        let primitive = file.primitive(&self.positions, &self.corners);
        let mesh = file.mesh(json!([primitive]));
        file.node(json!({ "name": "hill-terrain", "mesh": mesh }));
        file
    }
}

/// The corners of all cells, by those north-west, north-east, south-west and south-east of each.
fn cells(size: [u16; 2], cut: impl Fn([u16; 4]) -> [u16; 6]) -> Vec<u16> {
    let mut corners = Vec::new();
    for row in 0..size[1] - 1 {
        for column in 0..size[0] - 1 {
            let nw = row * size[0] + column;
            corners.extend(cut([nw, nw + 1, nw + size[0], nw + size[0] + 1]));
        }
    }
    corners
}
