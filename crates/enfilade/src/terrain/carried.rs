//! User-defined vertex attributes of a height field: normals, texture coordinates and colors.

use super::{HeightField, HeightFieldError};
use crate::mesh::{Attributes, Vertices};

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
    /// [`HeightFieldError::AttributeStride`], [`HeightFieldError::AttributeCount`] and
    /// [`HeightFieldError::AttributeNotFinite`].
    pub fn carrying(mut self, attributes: Attributes) -> Result<HeightField, HeightFieldError> {
        self.vertex_attributes = Some(FieldAttributes {
            normals: self.checked(attributes.normals, "normals")?,
            texture: self.checked(attributes.texture, "texture coordinates")?,
            colors: self.checked(attributes.colors, "colors")?,
        });
        Ok(self)
    }

    /// Copies a list that is empty or has one entry per sample.
    fn checked<const N: usize>(
        &self,
        list: Vertices<N>,
        what: &'static str,
    ) -> Result<Vec<[f32; N]>, HeightFieldError> {
        if let Some(stride) = list.short_stride() {
            let least = 4 * N;
            return Err(HeightFieldError::AttributeStride { what, stride, least });
        }
        let [needs, has] = [self.heights.len(), list.len()].map(|count| count as u64);
        if has != 0 && has != needs {
            return Err(HeightFieldError::AttributeCount { what, needs, has });
        }
        let copy: Vec<[f32; N]> = (0..list.len()).map(|sample| list.at(sample)).collect();
        if copy.as_flattened().iter().all(|value| value.is_finite()) {
            Ok(copy)
        } else {
            Err(HeightFieldError::AttributeNotFinite { what })
        }
    }
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
            normals: Vertices::Packed(&self.normals),
            texture: Vertices::Packed(&self.texture),
            colors: Vertices::Packed(&self.colors),
        }
    }
}

fn picked<T: Copy>(list: &[T], places: &[usize]) -> Vec<T> {
    if list.is_empty() {
        return Vec::new();
    }
    places.iter().map(|&place| list[place]).collect()
}
