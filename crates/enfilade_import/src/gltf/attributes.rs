//! Vertex attributes: normals, texture coordinates and colors, planned first and then read.
//!
//! Texture coordinates come from the set that the material's texture uses, transformed by its `KHR_texture_transform`:
//! the renderer gets one set and no transform.
//! Source: glTF 2.0 Specification, section 3.7.2.1; KHR_texture_transform.

use super::accessor::{AccessorUse, Row};
use super::buffers::Buffers;
use super::deform::Morph;
use super::document::{Document, Primitive, Semantic, TextureInfo, TextureTransform};
use crate::BrokenRule;
use crate::warning::{WarningKind, Warnings};
use enfilade::{Attributes, Vertices};

/// The texture coordinate set and transform of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    /// Index of the coordinate set.
    set: u32,
    /// The transform, as columns; the last one is the translation.
    place_from_coordinates: [[f64; 2]; 3],
}

impl Coordinates {
    pub(super) fn of(info: &TextureInfo) -> Coordinates {
        let transform = info.extensions.transform.unwrap_or_default();
        let TextureTransform {
            offset,
            rotation,
            scale,
            tex_coord,
        } = transform;
        let (sin, cos) = rotation.sin_cos();
        // The code listing in the specification rotates the other way; its example, the sample model and all other
        // implementations rotate this way (https://github.com/KhronosGroup/glTF/issues/1563).
        Coordinates {
            set: tex_coord.unwrap_or(info.tex_coord),
            place_from_coordinates: [
                [cos * scale[0], -sin * scale[0]],
                [sin * scale[1], cos * scale[1]],
                offset,
            ],
        }
    }

    fn place(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [u, v] = [u, v].map(f64::from);
        let [x, y, moved] = self.place_from_coordinates;
        [0, 1].map(|axis| (x[axis] * u + y[axis] * v + moved[axis]) as f32)
    }
}

/// The attributes of a primitive, checked as far as possible without their bytes.
#[derive(Clone, Debug, Default)]
pub(super) struct AttributePlan {
    normals: Option<Row>,
    texture: Option<(Row, Coordinates)>,
    colors: Option<Row>,
}

impl AttributePlan {
    /// Returns the texture coordinate set that is read.
    pub(super) fn texture_set(&self) -> Option<u32> {
        self.texture.as_ref().map(|(_, coordinates)| coordinates.set)
    }

    /// Checks the attributes of a primitive with `positions` vertices that its material uses.
    pub(super) fn new(
        document: &Document,
        primitive: &Primitive,
        positions: u64,
        coordinates: Option<Coordinates>,
        place: &dyn Fn() -> String,
        warnings: &mut Warnings,
    ) -> Result<AttributePlan, BrokenRule> {
        let attributes = &primitive.attributes;
        let row = |accessor: Option<u32>, wanted, what| -> Result<Option<Row>, BrokenRule> {
            let Some(accessor) = accessor else { return Ok(None) };
            let row = Row::new(document, accessor, wanted, place)?;
            if row.count != positions {
                return Err(BrokenRule::AttributeCount {
                    place: place(),
                    what,
                    count: row.count,
                    positions,
                });
            }
            Ok(Some(row))
        };
        let texture = match coordinates {
            Some(coordinates) => {
                let accessor = attributes.get(Semantic::TextureCoordinates(coordinates.set));
                let row = row(accessor, AccessorUse::TextureCoordinates, "texture coordinates")?;
                if row.is_none() {
                    warnings.name(WarningKind::NoTextureCoordinates, || {
                        format!("{} has no TEXCOORD_{}", place(), coordinates.set)
                    });
                }
                row.map(|row| (row, coordinates))
            }
            None => None,
        };
        Ok(AttributePlan {
            normals: row(attributes.get(Semantic::Normal), AccessorUse::Normals, "normals")?,
            texture,
            colors: row(attributes.get(Semantic::Color), AccessorUse::Colors, "colors")?,
        })
    }

    pub(super) fn rows(&self) -> impl Iterator<Item = &Row> {
        let texture = self.texture.as_ref().map(|(row, _)| row);
        [self.normals.as_ref(), texture, self.colors.as_ref()]
            .into_iter()
            .flatten()
    }

    /// Returns the attribute bytes per vertex of a mesh: all its parts store every attribute that any part has.
    pub(super) fn bytes_of_each<'a>(plans: impl Iterator<Item = &'a AttributePlan> + Clone) -> u64 {
        let any = |has: fn(&AttributePlan) -> bool| u64::from(plans.clone().any(has));
        12 * any(|plan| plan.normals.is_some())
            + 8 * any(|plan| plan.texture.is_some())
            + 16 * any(|plan| plan.colors.is_some())
    }

    /// Reads the attributes of some of the vertices, in the given order, moved by morph targets.
    pub(super) fn read(&self, positions: &[u32], buffers: &Buffers, morph: &Morph) -> VertexAttributes {
        let mut carried = VertexAttributes::default();
        if let Some(row) = &self.normals {
            let elements = row.elements(buffers);
            carried.normals = sound(
                positions
                    .iter()
                    .map(|&p| morph.normal(p, elements.floats(p as usize))),
                [0.0; 3],
                &mut carried.odd[0],
            );
        }
        if let Some((row, coordinates)) = &self.texture {
            let elements = row.elements(buffers);
            let places = positions
                .iter()
                .map(|&p| coordinates.place(morph.texture(p, elements.floats(p as usize))));
            carried.texture = sound(places, [0.0; 2], &mut carried.odd[1]);
        }
        if let Some(row) = &self.colors {
            let elements = row.elements(buffers);
            let has_coverage = row.parts() == 4;
            let color = |&p: &u32| {
                let [r, g, b, a] = morph.color(p, elements.floats(p as usize));
                [r, g, b, if has_coverage { a } else { 1.0 }]
            };
            let colors = sound(positions.iter().map(color), [1.0; 4], &mut carried.odd[2]);
            carried.colors = colors
                .into_iter()
                .map(|color| color.map(|part| part.clamp(0.0, 1.0)))
                .collect();
        }
        carried
    }
}

/// Collects a list with elements that are not finite replaced by `instead`; `replaced` becomes `true` if there are any.
fn sound<const N: usize>(
    list: impl Iterator<Item = [f32; N]>,
    instead: [f32; N],
    replaced: &mut bool,
) -> Vec<[f32; N]> {
    let checked = |element: [f32; N]| {
        if element.iter().all(|value| value.is_finite()) {
            element
        } else {
            *replaced = true;
            instead
        }
    };
    list.map(checked).collect()
}

/// Vertex attributes; each list is empty or has one element per vertex.
#[derive(Debug, Default)]
pub(super) struct VertexAttributes {
    normals: Vec<[f32; 3]>,
    texture: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
    /// Whether any normal, texture coordinate or color was not finite and was replaced.
    odd: [bool; 3],
}

impl VertexAttributes {
    pub(super) fn attributes(&self) -> Attributes<'_> {
        Attributes {
            normals: Vertices::Packed(&self.normals),
            texture: Vertices::Packed(&self.texture),
            colors: Vertices::Packed(&self.colors),
        }
    }

    /// Replaces the normal of each vertex that has one.
    pub(super) fn turn_normals(&mut self, turned: impl Fn(usize, [f32; 3]) -> [f32; 3]) {
        for (vertex, normal) in self.normals.iter_mut().enumerate() {
            *normal = turned(vertex, *normal);
        }
    }

    /// Returns the warnings for replaced elements.
    pub(super) fn oddities(&self) -> impl Iterator<Item = WarningKind> {
        let kinds = [
            WarningKind::BadNormals,
            WarningKind::BadTextureCoordinates,
            WarningKind::BadColors,
        ];
        self.odd
            .into_iter()
            .zip(kinds)
            .filter_map(|(odd, kind)| odd.then_some(kind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinates(json: &str) -> Coordinates {
        Coordinates::of(&serde_json::from_str(json).expect("a texture"))
    }

    #[test]
    fn a_lower_left_quadrant_turned_is_the_one_that_the_specification_means() {
        let turned = coordinates(
            r#"{"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform":
                {"offset": [0, 1], "rotation": 1.57079632679, "scale": [0.5, 0.5], "texCoord": 1}}}"#,
        );
        assert_eq!(turned.set, 1);
        // +v points down: the lower left quadrant is u from 0 to ½ and v from ½ to 1.
        for (at, expected) in [
            ([0.0, 0.0], [0.0, 1.0]),
            ([1.0, 0.0], [0.0, 0.5]),
            ([0.0, 1.0], [0.5, 1.0]),
        ] {
            let place = turned.place(at);
            let off = (0..2)
                .map(|axis| (place[axis] - expected[axis]).abs())
                .fold(0.0, f32::max);
            assert!(off < 1e-6, "{at:?}: {place:?}");
        }
    }

    #[test]
    fn coordinates_that_no_transform_moves_stay_as_they_are_to_the_bit() {
        let plain = coordinates(r#"{"index": 0}"#);
        for at in [[0.1, 0.7], [-3.3, 1e-20], [f32::MAX, f32::MIN_POSITIVE]] {
            assert_eq!(plain.place(at), at);
        }
    }
}
