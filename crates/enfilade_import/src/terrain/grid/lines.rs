//! The columns and rows in which the corners of a mesh stand.

use super::{GridError, GridPlace};

/// How far apart corners of one column or row may stand, as a part of the greatest x or z of all: two to four steps of f32
/// there, which is what is left of a grid that was turned before it was exported. Columns nearer than that are one.
pub(super) const TOLERANCE: f64 = 1.0 / (1 << 22) as f64;

/// Where columns and rows stand, at the least x or z of their corners, growing.
pub(super) struct Lines {
    pub(super) columns: Vec<f32>,
    pub(super) rows: Vec<f32>,
}

impl Lines {
    /// Those of positions that are finite, within a part of the greatest x or z.
    pub(super) fn of(positions: &[[f32; 3]], tolerance: f64) -> Lines {
        let reach = positions.iter().flat_map(|[x, _, z]| [x.abs(), z.abs()]);
        let tolerance = tolerance * f64::from(reach.fold(0.0, f32::max));
        let along = |axis: usize| lines(positions.iter().map(|position| position[axis]), tolerance);
        Lines {
            columns: along(0),
            rows: along(2),
        }
    }

    /// The number of the place that one of those positions stands at, row after row.
    pub(super) fn place_of(&self, [x, _, z]: [f32; 3]) -> u64 {
        let last = |lines: &[f32], at: f32| lines.partition_point(|&line| line <= at) as u64 - 1;
        last(&self.rows, z) * self.columns.len() as u64 + last(&self.columns, x)
    }

    /// How many places there are.
    pub(super) fn places(&self) -> u64 {
        self.columns.len() as u64 * self.rows.len() as u64
    }

    /// The column and the row of a place.
    pub(super) fn column_and_row(&self, place: u64) -> [u32; 2] {
        let columns = self.columns.len() as u64;
        [(place % columns) as u32, (place / columns) as u32]
    }

    pub(super) fn place(&self, place: u64) -> GridPlace {
        let [column, row] = self.column_and_row(place);
        GridPlace {
            column,
            row,
            x: self.columns[column as usize],
            z: self.rows[row as usize],
        }
    }

    pub(super) fn no_corner(&self, place: u64) -> GridError {
        GridError::NoCorner {
            columns: self.columns.len() as u32,
            rows: self.rows.len() as u32,
            place: self.place(place),
        }
    }
}

/// The least of each run of numbers that are within a tolerance of it.
fn lines(numbers: impl Iterator<Item = f32>, tolerance: f64) -> Vec<f32> {
    let mut numbers: Vec<f32> = numbers.collect();
    numbers.sort_unstable_by(f32::total_cmp);
    let mut first = f64::NEG_INFINITY;
    numbers.retain(|&number| {
        let is_next = f64::from(number) - first > tolerance;
        if is_next {
            first = number.into();
        }
        is_next
    });
    numbers.shrink_to_fit();
    numbers
}
