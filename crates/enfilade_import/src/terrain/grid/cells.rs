//! Checks that each cell of a grid is two triangles, and along which diagonal it is split.

use super::GridError;
use super::lines::Lines;
use enfilade::{Diagonal, Mesh};

/// Bit k of a cell is set if one of its triangles leaves out corner k (north-west, north-east, south-west, south-east).
const NORTH_EAST_CUT: u8 = 0b1001;
const NORTH_WEST_CUT: u8 = 0b0110;
/// A triangle of the cell faces down.
const DOWN: u8 = 1 << 4;
/// Two triangles leave out the same corner.
const TWICE: u8 = 1 << 5;

/// Returns the common diagonal of all cells. Every grid point has a vertex; `places` holds the grid point of each
/// vertex.
pub(super) fn diagonal(mesh: &Mesh, lines: &Lines, places: &[u64]) -> Result<Diagonal, GridError> {
    let [columns, rows] = [&lines.columns, &lines.rows].map(|lines| lines.len());
    // One more column and row than there are cells, so that a cell has the index of its north-west grid point.
    let mut cells = vec![0_u8; columns * rows];
    for face in 0..mesh.face_count() {
        mark(mesh, lines, places, face, &mut cells)?;
    }
    let mut first = None;
    for (number, cell) in (0_u64..).zip(cells) {
        let [column, row] = lines.column_and_row(number);
        if column as usize == columns - 1 || row as usize == rows - 1 {
            continue;
        }
        let place = lines.place(number);
        let diagonal = match cell {
            NORTH_EAST_CUT => Diagonal::NorthEast,
            NORTH_WEST_CUT => Diagonal::NorthWest,
            _ if cell & TWICE != 0 => return Err(GridError::Overlap { place }),
            _ if cell & DOWN != 0 => return Err(GridError::FacesDown { place }),
            _ if cell.count_ones() < 2 => return Err(GridError::Hole { place }),
            _ => return Err(GridError::Overlap { place }),
        };
        if *first.get_or_insert(diagonal) != diagonal {
            return Err(GridError::Diagonals { place });
        }
    }
    // A grid without cells has no diagonal; the height field rejects it.
    Ok(first.unwrap_or_default())
}

/// Marks in the cell of a triangle which corner the triangle leaves out.
fn mark(mesh: &Mesh, lines: &Lines, places: &[u64], face: u32, cells: &mut [u8]) -> Result<(), GridError> {
    let corners = mesh.face(face);
    let at = |corner: usize| places[corners[corner] as usize];
    let [a, b, c] = [at(0), at(1), at(2)];
    // A triangle with two corners at the same grid point is degenerate and invisible.
    if a == b || b == c || c == a {
        return Ok(());
    }
    let [a, b, c] = [a, b, c].map(|place| lines.column_and_row(place));
    let least = [0, 1].map(|axis| a[axis].min(b[axis]).min(c[axis]));
    let [a, b, c] = [a, b, c].map(|corner| [0, 1].map(|axis| i64::from(corner[axis] - least[axis])));
    if [a, b, c].as_flattened().iter().any(|&step| step > 1) {
        return Err(GridError::Across {
            place: lines.place(at(0)),
        });
    }
    // The corners of a cell are numbered 0 to 3, so those of a triangle add up to 6 minus the one that it leaves out.
    let left_out = 6 - [a, b, c]
        .iter()
        .map(|[column, row]| column + 2 * row)
        .sum::<i64>();
    let cell = &mut cells[least[1] as usize * lines.columns.len() + least[0] as usize];
    let bit = 1 << left_out;
    if *cell & bit != 0 {
        *cell |= TWICE;
    }
    *cell |= bit;
    // The y component of the cross product of two edges: positive for triangles that are counter-clockwise when seen
    // from above.
    let [along, across] = [b, c].map(|corner| [corner[0] - a[0], corner[1] - a[1]]);
    if along[1] * across[0] - along[0] * across[1] < 0 {
        *cell |= DOWN;
    }
    Ok(())
}
