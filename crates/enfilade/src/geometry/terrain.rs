//! Height fields in a geometry: their blocks are items.

use super::{Geometry, GeometryBuilder, GeometryError};
use crate::geom::Transform;
use crate::ids::{ItemIndex, MaterialId, MeshId};
use crate::terrain::HeightField;
use std::ops::Range;
use std::sync::Arc;

/// A height field in a geometry, whose blocks are items: see [`GeometryBuilder::terrain`].
#[derive(Clone, Debug)]
pub struct Terrain {
    pub(crate) field: Arc<HeightField>,
    /// Item ids of its blocks.
    pub(crate) blocks: Range<u32>,
    /// Mesh of the first block; the other blocks' meshes follow.
    first_mesh: MeshId,
    pub(crate) sector_from_field: Transform,
}

impl Terrain {
    /// Returns the height field.
    pub fn field(&self) -> &Arc<HeightField> {
        &self.field
    }

    /// Returns the item of the first block; those of the other blocks follow.
    pub fn first_block(&self) -> ItemIndex {
        ItemIndex(self.blocks.start)
    }

    /// Returns the transform from the space of the field to that of the sector.
    pub fn sector_from_field(&self) -> &Transform {
        &self.sector_from_field
    }

    /// Returns `true` if all blocks are still in the geometry, unchanged.
    pub(crate) fn is_whole(&self, geometry: &Geometry) -> bool {
        let place = self.sector_from_field.columns();
        self.blocks.clone().zip(self.first_mesh.0..).all(|(block, mesh)| {
            let item = geometry.items().get(block as usize);
            item.is_some_and(|item| item.mesh == MeshId(mesh) && item.sector_from_item == place)
        })
    }
}

impl GeometryBuilder {
    /// Adds the blocks of a height field as items, row after row from the north, each row from west to east. They are
    /// named `NAME ROW COLUMN`, by block indices. Returns their ids.
    ///
    /// # Errors
    /// [`GeometryError::TooManyFaces`], as [`GeometryBuilder::build`].
    pub fn terrain(
        &mut self,
        name: &str,
        field: impl Into<Arc<HeightField>>,
        material: MaterialId,
        sector_from_field: Transform,
    ) -> Result<Range<ItemIndex>, GeometryError> {
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
        let (first_item, first_mesh) = first.expect("a height field has at least one block");
        let first = first_item.index.0;
        let blocks = first..first + columns * rows;
        self.terrains.push(Terrain {
            field,
            blocks: blocks.clone(),
            first_mesh,
            sector_from_field,
        });
        Ok(ItemIndex(blocks.start)..ItemIndex(blocks.end))
    }

    /// Declares items that were added already, from `first_block` on, as the blocks of a height field: those that
    /// [`GeometryBuilder::terrain`] added to another geometry, whose meshes were stored, for example.
    ///
    /// # Errors
    /// [`GeometryError::NotABlock`] for the first item that is missing or not as large as its block.
    pub fn terrain_of_items(
        &mut self,
        field: impl Into<Arc<HeightField>>,
        first_block: ItemIndex,
        sector_from_field: Transform,
    ) -> Result<(), GeometryError> {
        let field = field.into();
        let [columns, rows] = field.blocks();
        let first = self.mesh_of_item(first_block.0);
        let first_mesh = first.map_or(MeshId(0), |(mesh, _)| mesh);
        for block in 0..columns * rows {
            let item = first_block.0.saturating_add(block);
            let is_block = self.mesh_of_item(item).is_some_and(|(id, mesh)| {
                id.0 == first_mesh.0 + block
                    && mesh.bounds() == field.bounds_of([block % columns, block / columns])
            });
            if !is_block {
                return Err(GeometryError::NotABlock(ItemIndex(item)));
            }
        }
        self.terrains.push(Terrain {
            field,
            blocks: first_block.0..first_block.0 + columns * rows,
            first_mesh,
            sector_from_field,
        });
        Ok(())
    }
}
