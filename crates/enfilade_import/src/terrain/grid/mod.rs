//! Converts a mesh that is a grid of heights into a height field with bit-identical triangles.
//!
//! Vertices with the same x, up to rounding, form a column, and those with the same z a row. Every intersection must
//! have a vertex, or several of the same height; every cell between them must be two upward-facing triangles, split
//! along the same diagonal everywhere. Steps between columns, and between rows, may vary. If all vertices of a column
//! have exactly the same x, and those of a row the same z, nothing moves; otherwise they move by less than
//! [`TOLERANCE`].
//! Source: ours.
//! Cost: O(corners log corners + triangles); memory O(corners), for any input.

mod cells;
mod error;
mod lines;

pub use error::{GridError, GridPlace};

use enfilade::{Attributes, HeightField, Mesh, Vertices};
use lines::{Lines, TOLERANCE};

/// Maximum memory per triangle for recognising a grid, if no vertex is shared: x and z of its three corners, sorted;
/// their point indices and sort order; the list of chosen corners, which doubles as it grows; cells; heights.
pub(crate) const BYTES_AT_WORK: u64 = 3 * (4 + 4 + 8 + 4 + 16 + 1 + 4);

/// Returns the height field of a mesh, in object space. The mesh must have at least one triangle and only one material.
///
/// Grid points whose vertices have different normals get none, so the faces there are flat shaded.
pub(crate) fn field_of(mesh: &Mesh) -> Result<HeightField, GridError> {
    let positions = mesh.positions();
    let laid_out = |lines: Lines| {
        let places = positions.iter().map(|&position| lines.place_of(position));
        let places: Vec<u64> = places.collect();
        let corners = one_for_each(mesh, &lines, &places)?;
        Ok((lines, places, corners))
    };
    let (lines, places, corners) = match laid_out(Lines::of(positions, 0.0)) {
        Err(GridError::NoCorner { .. }) => laid_out(Lines::of(positions, TOLERANCE))?,
        exact => exact?,
    };
    let diagonal = cells::diagonal(mesh, &lines, &places)?;
    let heights: Vec<f32> = corners
        .iter()
        .map(|corner| positions[corner.number as usize][1])
        .collect();
    let mut normals = picked(mesh.normals(), &corners);
    for (normal, corner) in normals.iter_mut().zip(&corners) {
        if !corner.is_smooth {
            *normal = [0.0; 3];
        }
    }
    let texture = picked(mesh.texture(), &corners);
    let colors = picked(mesh.colors(), &corners);
    let attributes = Attributes {
        normals: Vertices::Packed(&normals),
        texture: Vertices::Packed(&texture),
        colors: Vertices::Packed(&colors),
    };
    let Lines { columns, rows } = lines;
    HeightField::on_lines(columns, rows, heights)
        .and_then(|field| field.cut_along(diagonal).carrying(attributes))
        .map_err(GridError::Field)
}

/// One of the vertices at a grid point; all of them have the same height.
struct Corner {
    number: u32,
    /// Whether all vertices at the point have the same normal.
    is_smooth: bool,
}

/// Returns one vertex per grid point, row by row.
fn one_for_each(mesh: &Mesh, lines: &Lines, places: &[u64]) -> Result<Vec<Corner>, GridError> {
    let mut turns: Vec<u32> = (0..places.len() as u32).collect();
    turns.sort_unstable_by_key(|&corner| (places[corner as usize], corner));
    let at_one_place = turns.chunk_by(|&a, &b| places[a as usize] == places[b as usize]);
    let mut corners = Vec::new();
    for (wanted, together) in (0..).zip(at_one_place) {
        let number = together[0] as usize;
        if places[number] != wanted {
            return Err(lines.no_corner(wanted));
        }
        let mut is_smooth = true;
        for other in together[1..].iter().map(|&other| other as usize) {
            let place = || lines.place(wanted);
            let [height, too] = [number, other].map(|corner| mesh.positions()[corner][1]);
            if height != too {
                let heights = [height, too];
                return Err(GridError::TwoHeights {
                    heights,
                    place: place(),
                });
            }
            for (what, differs) in [
                ("texture coordinates", differ(mesh.texture(), number, other)),
                ("colors", differ(mesh.colors(), number, other)),
            ] {
                if differs {
                    return Err(GridError::Seam { what, place: place() });
                }
            }
            is_smooth &= !differ(mesh.normals(), number, other);
        }
        corners.push(Corner {
            number: together[0],
            is_smooth,
        });
    }
    if (corners.len() as u64) < lines.places() {
        return Err(lines.no_corner(corners.len() as u64));
    }
    Ok(corners)
}

fn differ<T: PartialEq>(list: &[T], one: usize, other: usize) -> bool {
    !list.is_empty() && list[one] != list[other]
}

/// Returns the attribute of each corner; empty if the mesh does not have the attribute.
fn picked<T: Copy>(list: &[T], corners: &[Corner]) -> Vec<T> {
    if list.is_empty() {
        return Vec::new();
    }
    corners
        .iter()
        .map(|corner| list[corner.number as usize])
        .collect()
}
