//! Height fields: ground of which one height is known at each place of a grid.
//!
//! A cell between four places is two triangles, and the diagonal between them goes from the corner north-east to the one
//! south-west. Cells are taken together in square blocks, each a mesh, so that any method can see a terrain.
//! Source: ours; the axes as in glTF, with north ahead: x goes east, y up, z south.
//! Cost: O(samples).

#[cfg(test)]
mod tests;

use crate::content::{Content, ContentBuilder, ContentError, ItemId, MaterialId, MeshId};
use crate::geom::Transform;
use crate::mesh::{Attributes, Mesh, Part};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;
use thiserror::Error;

/// Cells along a side of a block; those at the east and the south end may have fewer.
const BLOCK: u32 = 32;

/// The most samples along a side: 2¹⁶ cells.
const MOST_SAMPLES: u32 = (1 << 16) + 1;

/// Heights at the places of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    size: [u32; 2],
    cell: [f64; 2],
    heights: Vec<f32>,
}

/// Why heights make no field.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HeightFieldError {
    /// There is no cell, or there are more than are numbered.
    #[error("a height field has 2 to {MOST_SAMPLES} samples along each side, but this one has {} x {}", .0[0], .0[1])]
    Size([u32; 2]),
    /// A cell has no length, or it ends where 32-bit numbers do.
    #[error("cells are {} long from west to east and {} from north to south; that must be above 0, and all of them within 3e38", .0[0], .0[1])]
    Cell([f64; 2]),
    /// Not one height for each place.
    #[error("{needs} heights are needed, but {has} are there")]
    Count {
        /// How many there should be.
        needs: u64,
        /// How many there are.
        has: u64,
    },
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
        let heights = heights.into();
        if size.iter().any(|side| !(2..=MOST_SAMPLES).contains(side)) {
            return Err(HeightFieldError::Size(size));
        }
        let is_sound = |axis: usize| {
            let end = cell[axis] * f64::from(size[axis]);
            cell[axis] as f32 > 0.0 && end < f64::from(f32::MAX)
        };
        if !(is_sound(0) && is_sound(1)) {
            return Err(HeightFieldError::Cell(cell));
        }
        let needs = u64::from(size[0]) * u64::from(size[1]);
        if needs != heights.len() as u64 {
            let has = heights.len() as u64;
            return Err(HeightFieldError::Count { needs, has });
        }
        if let Some(at) = heights.iter().position(|height| !height.is_finite()) {
            let columns = size[0] as usize;
            return Err(HeightFieldError::Hole {
                column: (at % columns) as u32,
                row: (at / columns) as u32,
                height: heights[at],
            });
        }
        Ok(HeightField { size, cell, heights })
    }

    /// Samples from west to east and from north to south.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Where a sample stands. There must be one.
    pub fn position(&self, column: u32, row: u32) -> [f32; 3] {
        [
            (f64::from(column) * self.cell[0]) as f32,
            self.height(column, row),
            (f64::from(row) * self.cell[1]) as f32,
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
        self.heights[row as usize * self.size[0] as usize + column as usize]
    }

    /// A block as a mesh: cell by cell, first the triangle north-west of the diagonal, then the other; counter-clockwise seen
    /// from above.
    fn mesh_of(&self, block: [u32; 2], material: MaterialId) -> Mesh {
        let [columns, rows] = self.samples_of(block);
        let width = columns.len() as u32;
        let mut positions = Vec::with_capacity(columns.len() * rows.len());
        let mut normals = Vec::with_capacity(columns.len() * rows.len());
        let mut corners = Vec::with_capacity(6 * (columns.len() - 1) * (rows.len() - 1));
        for row in rows.clone() {
            for column in columns.clone() {
                positions.push(self.position(column, row));
                normals.push(self.normal(column, row));
            }
        }
        for row in 0..rows.len() as u32 - 1 {
            for column in 0..width - 1 {
                let north_west = row * width + column;
                let [north_east, south_west] = [north_west + 1, north_west + width];
                corners.extend([north_west, south_west, north_east]);
                corners.extend([north_east, south_west, south_west + 1]);
            }
        }
        let part = Part {
            positions: &positions,
            corners: &corners,
            sides: None,
            material,
            attributes: Attributes {
                normals: &normals,
                ..Attributes::default()
            },
        };
        Mesh::new(&[part]).expect("heights and places are finite, and triangles need no more")
    }

    /// Upright on the ground at a sample, by the neighbours around it.
    fn normal(&self, column: u32, row: u32) -> [f32; 3] {
        let along = |at: u32, axis: usize| [at.saturating_sub(1), (at + 1).min(self.size[axis] - 1)];
        let [west, east] = along(column, 0).map(|column| f64::from(self.height(column, row)));
        let [north, south] = along(row, 1).map(|row| f64::from(self.height(column, row)));
        let [across, down] = [(column, 0), (row, 1)].map(|(at, axis)| {
            let [before, after] = along(at, axis);
            f64::from(after - before) * self.cell[axis]
        });
        let normal = DVec3::new((west - east) / across, 1.0, (north - south) / down);
        normal.normalize_or_zero().as_vec3().to_array()
    }
}

/// A height field in a content.
#[derive(Clone, Debug)]
pub(crate) struct Terrain {
    pub(crate) field: Arc<HeightField>,
    /// The numbers of the items that are its blocks.
    pub(crate) blocks: Range<u32>,
    /// The mesh of the first block; the others' follow.
    first_mesh: MeshId,
    pub(crate) fragment_from_field: Transform,
}

impl Terrain {
    /// Are all blocks still there, and as they were?
    pub(crate) fn is_whole(&self, content: &Content) -> bool {
        let place = self.fragment_from_field.columns();
        self.blocks.clone().zip(self.first_mesh.0..).all(|(block, mesh)| {
            let item = content.items().get(block as usize);
            item.is_some_and(|item| item.mesh == MeshId(mesh) && item.fragment_from_item == place)
        })
    }
}

impl ContentBuilder {
    /// Adds the blocks of a height field as items, row after row, the northern first and each from west to east. They are called
    /// `NAME ROW COLUMN`, by numbers of blocks. Gives their numbers.
    ///
    /// # Errors
    /// As [`ContentBuilder::build`], where there would be more faces than are numbered.
    pub fn terrain(
        &mut self,
        name: &str,
        field: impl Into<Arc<HeightField>>,
        material: MaterialId,
        fragment_from_field: Transform,
    ) -> Result<Range<ItemId>, ContentError> {
        let field = field.into();
        let faces = 2 * field
            .size()
            .map(|side| u64::from(side - 1))
            .iter()
            .product::<u64>();
        if faces > u64::from(u32::MAX) {
            return Err(ContentError::TooManyFaces(faces));
        }
        let [columns, rows] = field.blocks();
        let mut first = None;
        for row in 0..rows {
            for column in 0..columns {
                let mesh = self.mesh(field.mesh_of([column, row], material));
                let item = self.item(&format!("{name} {row} {column}"), mesh, fragment_from_field);
                first.get_or_insert((item, mesh));
            }
        }
        let (first_item, first_mesh) = first.expect("a field has a block at least");
        let blocks = first_item.0..first_item.0 + columns * rows;
        self.terrains.push(Terrain {
            field,
            blocks: blocks.clone(),
            first_mesh,
            fragment_from_field,
        });
        Ok(ItemId(blocks.start)..ItemId(blocks.end))
    }
}
