//! Vertex attributes besides positions, for renderers. They do not affect visibility.

use super::build::{check_stride, first_used};
use super::list::List;
use super::{MeshError, Part, Vertices};
use bytemuck::Pod;

/// Vertex attributes of a part, for renderers. Each list is empty or has one element per position.
///
/// Attributes are interpolated linearly over a face; over a face of more than three corners as over its first three
/// corners that are not collinear.
#[doc(alias = "vertex attributes")]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attributes<'a> {
    /// Shading normals in object space, of any length. Zero, or an empty list, means the face normal.
    pub normals: Vertices<'a, 3>,
    /// Texture coordinates: (0, 0) is the upper left corner of the first texel, (1, 1) the lower right corner of the
    /// last.
    #[doc(alias = "uv")]
    pub texture: Vertices<'a, 2>,
    /// Vertex colors, multiplied by the material's color: red, green, blue and coverage, linear.
    pub colors: Vertices<'a, 4>,
}

/// The attributes of a whole mesh; each list is empty or as long as the positions.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshAttributes {
    pub(super) normals: List<[f32; 3]>,
    pub(super) texture: List<[f32; 2]>,
    pub(super) colors: List<[f32; 4]>,
}

impl Attributes<'_> {
    /// Checks that each list is empty or as long as the positions, and that all numbers of vertices in use are finite.
    pub(super) fn check(&self, number: usize, part: &Part) -> Result<(), MeshError> {
        check(number, part, &self.normals, "normals")?;
        check(number, part, &self.texture, "texture coordinates")?;
        check(number, part, &self.colors, "colors")
    }
}

fn check<const N: usize>(
    number: usize,
    part: &Part,
    list: &Vertices<N>,
    what: &'static str,
) -> Result<(), MeshError> {
    check_stride(number, list, what)?;
    let [count, positions] = [list.len(), part.positions.len()];
    if count != 0 && count != positions {
        return Err(MeshError::AttributeCount {
            part: number,
            what,
            count,
            positions,
        });
    }
    let is_bad = |position: usize| !list.at(position).iter().all(|value| value.is_finite());
    match first_used(part, (0..count).filter(|&position| is_bad(position))) {
        Some(position) => Err(MeshError::AttributeNotFinite {
            part: number,
            what,
            position,
        }),
        None => Ok(()),
    }
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
    list: impl Fn(&Attributes<'a>) -> Vertices<'a, N>,
    none: [f32; N],
) -> List<[f32; N]>
where
    [f32; N]: Pod,
{
    if parts.iter().all(|part| list(&part.attributes).is_empty()) {
        return List::default();
    }
    let value = |&(part, position): &(u32, u32)| {
        let list = list(&parts[part as usize].attributes);
        if list.is_empty() {
            none
        } else {
            list.at(position as usize)
        }
    };
    let values: Vec<[f32; N]> = sources.iter().map(value).collect();
    values.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::MaterialId;
    use crate::mesh::{Indices, Mesh};

    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    fn part(attributes: Attributes) -> Part {
        Part {
            positions: Vertices::Packed(&CORNERS),
            corners: Indices::U32(&[0, 1, 2, 0, 2, 3]),
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
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(&corners),
            attributes: Attributes {
                texture: Vertices::Packed(&texture),
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
            normals: Vertices::Packed(&[[0.0, 0.0, 1.0]]),
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
            texture: Vertices::Packed(&[[0.0; 2], [0.0; 2], [f32::NAN, 0.0], [0.0; 2]]),
            ..Attributes::default()
        });
        assert!(matches!(
            nan,
            MeshError::AttributeNotFinite {
                what: "texture coordinates",
                position: 2,
                ..
            }
        ));
    }
}
