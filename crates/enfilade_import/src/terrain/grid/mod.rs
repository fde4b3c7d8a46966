//! From a mesh to the height field that it is: the same triangles, to the bit.
//!
//! Corners whose x are the same but for rounding make a column, those of one z a row. Where both cross there must be a corner,
//! or several of one height; between them each cell must be two triangles that face up, parted by the same diagonal in all.
//! Steps between columns, and between rows, may differ. Nothing moves where corners of one column have the very same x, and
//! those of one row the same z; where not, they move by less than [`TOLERANCE`] says.
//! Source: ours.
//! Cost: O(corners log corners + triangles); memory O(corners), whatever the corners are.

mod cells;
mod error;
mod lines;

pub use error::{GridError, GridPlace};

use enfilade::{Attributes, HeightField, Mesh};
use lines::{Lines, TOLERANCE};

/// Bytes that recognising a grid takes for a triangle at most, where its three corners are its own: their x and z, sorted, the
/// numbers of their places and the turns in which these come, a list of corners that doubles as it grows, cells and heights.
pub(crate) const BYTES_AT_WORK: u64 = 3 * (4 + 4 + 8 + 4 + 16 + 1 + 4);

/// The field that a mesh of triangles is, in the space of the mesh. The mesh must have a triangle, and be of one material.
///
/// Places where corners have different normals get none, so that faces are flat there, as where all of their corners differ.
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
    let attributes = Attributes {
        normals: &normals,
        texture: &picked(mesh.texture(), &corners),
        colors: &picked(mesh.colors(), &corners),
    };
    let Lines { columns, rows } = lines;
    HeightField::on_lines(columns, rows, heights)
        .and_then(|field| field.cut_along(diagonal).carrying(attributes))
        .map_err(GridError::Field)
}

/// One of the corners at a place, all of which have its height.
struct Corner {
    number: u32,
    /// Have all of them its normal?
    is_smooth: bool,
}

/// A corner for each place, row after row.
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

/// One for each corner, or none where the mesh has none.
fn picked<T: Copy>(list: &[T], corners: &[Corner]) -> Vec<T> {
    if list.is_empty() {
        return Vec::new();
    }
    corners
        .iter()
        .map(|corner| list[corner.number as usize])
        .collect()
}
