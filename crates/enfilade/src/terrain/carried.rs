//! User-defined vertex attributes of a height field: normals, texture coordinates and colors.

use super::{HeightField, HeightFieldError};
use crate::mesh::Attributes;

/// Each list is empty or has one entry per sample, row after row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FieldAttributes {
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) texture: Vec<[f32; 2]>,
    pub(super) colors: Vec<[f32; 4]>,
}

impl HeightField {
    /// Returns the field with vertex attributes: each list of `attributes` is empty or has one entry per sample, in the
    /// order of the heights. Replaces the computed normals: without normals in `attributes`, faces are flat-shaded.
    ///
    /// # Errors
    /// [`HeightFieldError::AttributeCount`] and [`HeightFieldError::AttributeNotFinite`].
    pub fn carrying(mut self, attributes: Attributes) -> Result<HeightField, HeightFieldError> {
        let needs = self.heights.len();
        let Attributes {
            normals,
            texture,
            colors,
        } = attributes;
        let lists = [
            ("normals", normals.len(), all_finite(normals)),
            ("texture coordinates", texture.len(), all_finite(texture)),
            ("colors", colors.len(), all_finite(colors)),
        ];
        for (what, has, is_finite) in lists {
            if has != 0 && has != needs {
                let [needs, has] = [needs, has].map(|count| count as u64);
                return Err(HeightFieldError::AttributeCount { what, needs, has });
            }
            if !is_finite {
                return Err(HeightFieldError::AttributeNotFinite { what });
            }
        }
        self.vertex_attributes = Some(FieldAttributes {
            normals: normals.to_vec(),
            texture: texture.to_vec(),
            colors: colors.to_vec(),
        });
        Ok(self)
    }
}

fn all_finite<const N: usize>(list: &[[f32; N]]) -> bool {
    list.iter().flatten().all(|value| value.is_finite())
}

impl FieldAttributes {
    /// Returns the attributes of the samples with the given indices.
    pub(super) fn at(&self, places: &[usize]) -> FieldAttributes {
        FieldAttributes {
            normals: picked(&self.normals, places),
            texture: picked(&self.texture, places),
            colors: picked(&self.colors, places),
        }
    }

    pub(super) fn attributes(&self) -> Attributes<'_> {
        Attributes {
            normals: &self.normals,
            texture: &self.texture,
            colors: &self.colors,
        }
    }
}

fn picked<T: Copy>(list: &[T], places: &[usize]) -> Vec<T> {
    if list.is_empty() {
        return Vec::new();
    }
    places.iter().map(|&place| list[place]).collect()
}
