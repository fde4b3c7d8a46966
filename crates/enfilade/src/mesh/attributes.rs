//! Vertex attributes besides positions, for renderers. They do not affect visibility.

use super::{MeshError, Part};

/// Vertex attributes of a part, for renderers. Each list is empty or has one element per position.
///
/// Attributes are interpolated linearly over a face; over a face of more than three corners as over its first three
/// corners that are not collinear.
#[doc(alias = "vertex attributes")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attributes<'a> {
    /// Shading normals in object space, of any length. Zero, or an empty list, means the face normal.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates: (0, 0) is the upper left corner of the first texel, (1, 1) the lower right corner of the
    /// last.
    #[doc(alias = "uv")]
    pub texture: &'a [[f32; 2]],
    /// Vertex colors, multiplied by the material's color: red, green, blue and coverage, linear.
    pub colors: &'a [[f32; 4]],
}

/// The attributes of a whole mesh; each list is empty or as long as the positions.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshAttributes {
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) texture: Vec<[f32; 2]>,
    pub(super) colors: Vec<[f32; 4]>,
}

impl Attributes<'_> {
    /// Checks that each list is empty or as long as the positions, and that all numbers are finite.
    pub(super) fn check(&self, part: usize, positions: usize) -> Result<(), MeshError> {
        let finite = [
            all_finite(self.normals),
            all_finite(self.texture),
            all_finite(self.colors),
        ];
        let counts = [self.normals.len(), self.texture.len(), self.colors.len()];
        let what = ["normals", "texture coordinates", "colors"];
        for ((count, finite), what) in counts.into_iter().zip(finite).zip(what) {
            if count != 0 && count != positions {
                return Err(MeshError::AttributeCount {
                    part,
                    what,
                    count,
                    positions,
                });
            }
            if !finite {
                return Err(MeshError::AttributeNotFinite { part, what });
            }
        }
        Ok(())
    }
}

fn all_finite<const N: usize>(list: &[[f32; N]]) -> bool {
    list.iter().flatten().all(|value| value.is_finite())
}

impl MeshAttributes {
    /// Collects the attributes of positions given as `(part, position)`. A list is empty only if it is empty in all
    /// parts.
    pub(super) fn gather(parts: &[Part], sources: &[(u32, u32)]) -> MeshAttributes {
        MeshAttributes {
            normals: gather(parts, sources, |a| a.normals, [0.0; 3]),
            texture: gather(parts, sources, |a| a.texture, [0.0; 2]),
            colors: gather(parts, sources, |a| a.colors, [1.0; 4]),
        }
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.normals) + size_of_val(&*self.texture) + size_of_val(&*self.colors)
    }
}

fn gather<'a, const N: usize>(
    parts: &[Part<'a>],
    sources: &[(u32, u32)],
    list: impl Fn(&Attributes<'a>) -> &'a [[f32; N]],
    none: [f32; N],
) -> Vec<[f32; N]> {
    if parts.iter().all(|part| list(&part.attributes).is_empty()) {
        return Vec::new();
    }
    let of = |&(part, position): &(u32, u32)| list(&parts[part as usize].attributes).get(position as usize);
    sources
        .iter()
        .map(|source| of(source).copied().unwrap_or(none))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::MaterialId;
    use crate::mesh::Mesh;

    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    fn part(attributes: Attributes) -> Part {
        Part {
            positions: &CORNERS,
            corners: &[0, 1, 2, 0, 2, 3],
            sides: None,
            material: MaterialId(0),
            attributes,
        }
    }

    #[test]
    fn what_corners_carry_stays_with_them_however_faces_are_sorted() {
        let side = 40;
        let place = |i: usize| [(i % side) as f32, (i / side) as f32, 0.0];
        let positions: Vec<[f32; 3]> = (0..side * side).map(place).collect();
        let texture: Vec<[f32; 2]> = positions.iter().map(|p| [p[0] * 0.5, p[1] * 0.25]).collect();
        let cell = |i: u32| [i, i + 1, i + 41, i, i + 41, i + 40];
        let corners: Vec<u32> = (0..39 * 40).filter(|i| i % 40 < 39).flat_map(cell).collect();
        let sheet = Part {
            positions: &positions,
            corners: &corners,
            attributes: Attributes {
                texture: &texture,
                ..Attributes::default()
            },
            ..part(Attributes::default())
        };
        // A second part without attributes, in the same mesh.
        let mesh = Mesh::new(&[sheet, part(Attributes::default())]).expect("two valid parts");
        assert!(mesh.normals().is_empty() && mesh.colors().is_empty());
        assert_eq!(mesh.texture().len(), mesh.positions().len());
        let pairs = mesh.positions().iter().zip(mesh.texture());
        let right = |(p, t): (&[f32; 3], &[f32; 2])| *t == [p[0] * 0.5, p[1] * 0.25] || *t == [0.0; 2];
        assert_eq!(pairs.filter(|&pair| right(pair)).count(), mesh.positions().len());
        let bare = mesh.texture().iter().filter(|&&t| t == [0.0; 2]).count();
        assert!(bare < 100, "{bare} corners without");
    }

    #[test]
    fn lists_of_another_length_or_with_nan_are_refused() {
        let of = |attributes| Mesh::new(&[part(attributes)]).expect_err("invalid attributes");
        let few = of(Attributes {
            normals: &[[0.0, 0.0, 1.0]],
            ..Attributes::default()
        });
        assert!(matches!(
            few,
            MeshError::AttributeCount {
                what: "normals",
                count: 1,
                positions: 4,
                ..
            }
        ));
        let nan = of(Attributes {
            texture: &[[f32::NAN, 0.0]; 4],
            ..Attributes::default()
        });
        assert!(matches!(
            nan,
            MeshError::AttributeNotFinite {
                what: "texture coordinates",
                ..
            }
        ));
    }
}
