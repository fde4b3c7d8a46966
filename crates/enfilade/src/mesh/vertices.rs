//! Vertex and index buffers borrowed from the caller, as engines lay them out.

/// Vertex data of `N` floats per vertex, borrowed from the caller.
///
/// ```
/// # use enfilade::*;
/// // Position, normal and texture coordinates, interleaved: 32 bytes per vertex.
/// let vertices: [[f32; 8]; 3] = [
///     [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0],
///     [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
///     [0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
/// ];
/// let bytes: Vec<u8> = vertices.as_flattened().iter().flat_map(|value| value.to_ne_bytes()).collect();
/// let mesh = Mesh::new(&[Part {
///     positions: Vertices::Strided { bytes: &bytes, stride: 32 },
///     corners: Indices::U16(&[0, 1, 2]),
///     sides: None,
///     material: MaterialId(0),
///     attributes: Attributes {
///         texture: Vertices::Strided { bytes: &bytes[24..], stride: 32 },
///         ..Attributes::default()
///     },
/// }])?;
/// assert_eq!(mesh.texture()[1], [1.0, 1.0]);
/// # Ok::<(), MeshError>(())
/// ```
#[doc(alias = "vertex buffer")]
#[doc(alias = "interleaved")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Vertices<'a, const N: usize> {
    /// One array per vertex.
    Packed(&'a [[f32; N]]),
    /// `N` floats every `stride` bytes.
    Strided {
        /// The buffer from the first float of the first vertex on: pass `&buffer[offset..]` for an attribute that is
        /// `offset` bytes into the vertex. In the byte order of the machine, with any alignment. Bytes that make no
        /// whole vertex at the end are ignored.
        bytes: &'a [u8],
        /// Bytes from one vertex to the next, at least 4 `N`.
        stride: usize,
    },
}

/// Indices of vertices, borrowed from the caller.
#[doc(alias = "index buffer")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Indices<'a> {
    /// 16 bits per index.
    U16(&'a [u16]),
    /// 32 bits per index.
    U32(&'a [u32]),
}

impl<const N: usize> Default for Vertices<'_, N> {
    fn default() -> Self {
        Vertices::Packed(&[])
    }
}

impl<const N: usize> Vertices<'_, N> {
    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        match *self {
            Vertices::Packed(list) => list.len(),
            Vertices::Strided { bytes, stride } if bytes.len() >= 4 * N => {
                (bytes.len() - 4 * N) / stride.max(1) + 1
            }
            Vertices::Strided { .. } => 0,
        }
    }

    /// Returns `true` if there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the stride if it is too short for a vertex.
    pub(crate) fn short_stride(&self) -> Option<usize> {
        match *self {
            Vertices::Strided { stride, .. } if stride < 4 * N => Some(stride),
            _ => None,
        }
    }

    /// Returns a vertex.
    ///
    /// # Panics
    /// If `index` is out of range.
    #[inline]
    pub(crate) fn at(&self, index: usize) -> [f32; N] {
        match *self {
            Vertices::Packed(list) => list[index],
            Vertices::Strided { bytes, stride } => {
                let floats = bytes[index * stride..][..4 * N].as_chunks::<4>().0;
                std::array::from_fn(|i| f32::from_ne_bytes(floats[i]))
            }
        }
    }
}

impl Indices<'_> {
    /// Returns the number of indices.
    pub fn len(&self) -> usize {
        match self {
            Indices::U16(list) => list.len(),
            Indices::U32(list) => list.len(),
        }
    }

    /// Returns `true` if there are no indices.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns an index.
    ///
    /// # Panics
    /// If `corner` is out of range.
    #[inline]
    pub(super) fn at(&self, corner: usize) -> u32 {
        match self {
            Indices::U16(list) => u32::from(list[corner]),
            Indices::U32(list) => list[corner],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::MaterialId;
    use crate::mesh::{Attributes, Mesh, Part};

    #[test]
    fn an_interleaved_buffer_makes_the_same_mesh_as_separate_lists() {
        let side = 50_u16;
        let place = |i: u16| [i % side, i / side].map(f32::from);
        let positions: Vec<[f32; 3]> = (0..side * side).map(place).map(|[x, z]| [x, x * z, z]).collect();
        let colors: Vec<[f32; 4]> = positions.iter().map(|&[x, y, z]| [x, y, z, 0.5]).collect();
        let is_inside = |i: &u16| i % side + 1 < side && i / side + 1 < side;
        let cells = (0..side * side).filter(is_inside);
        let corners: Vec<u16> = cells.flat_map(|i| [i, i + side, i + 1]).collect();
        // Five bytes before the position, so that nothing is aligned, and three after the color.
        let mut bytes = Vec::new();
        for (position, color) in positions.iter().zip(&colors) {
            bytes.extend([0xFF; 5]);
            bytes.extend(position.iter().chain(color).flat_map(|value| value.to_ne_bytes()));
            bytes.extend([0xFF; 3]);
        }
        let stride = 36;
        let strided = Part {
            positions: Vertices::Strided {
                bytes: &bytes[5..],
                stride,
            },
            corners: Indices::U16(&corners),
            sides: None,
            material: MaterialId(0),
            attributes: Attributes {
                colors: Vertices::Strided {
                    bytes: &bytes[17..],
                    stride,
                },
                ..Attributes::default()
            },
        };
        let wide: Vec<u32> = corners.iter().map(|&corner| corner.into()).collect();
        let packed = Part {
            positions: Vertices::Packed(&positions),
            corners: Indices::U32(&wide),
            attributes: Attributes {
                colors: Vertices::Packed(&colors),
                ..Attributes::default()
            },
            ..strided
        };
        let [strided, packed] = [strided, packed].map(|part| Mesh::new(&[part]).expect("a valid part"));
        assert!(strided.clusters().len() > 10 && strided.colors().len() == strided.positions().len());
        assert_eq!(format!("{strided:?}"), format!("{packed:?}"));
    }

    #[test]
    fn a_buffer_has_as_many_vertices_as_are_whole() {
        let buffer = [0; 64];
        for (len, count) in [(0, 0), (11, 0), (12, 1), (31, 1), (32, 2), (52, 3), (64, 3)] {
            let vertices: Vertices<3> = Vertices::Strided {
                bytes: &buffer[..len],
                stride: 20,
            };
            assert_eq!(vertices.len(), count, "{len} bytes");
        }
    }
}
