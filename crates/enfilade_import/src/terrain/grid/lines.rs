//! The columns and rows of the vertices of a mesh.

use super::{GridError, GridPlace};

/// Maximum distance between vertices of one column or row, relative to the maximum |x| or |z| of all: two to four f32
/// steps there, the rounding error of a grid that was rotated before export. Columns closer than that are merged.
pub(super) const TOLERANCE: f64 = 1.0 / (1 << 22) as f64;

/// Positions of columns and rows, increasing; each is the minimum x or z of its vertices.
pub(super) struct Lines {
    pub(super) columns: Vec<f32>,
    pub(super) rows: Vec<f32>,
}

impl Lines {
    /// Finds the columns and rows of finite positions; `tolerance` is relative to the maximum |x| or |z|.
    pub(super) fn of(positions: &[[f32; 3]], tolerance: f64) -> Lines {
        let reach = positions.iter().flat_map(|[x, _, z]| [x.abs(), z.abs()]);
        let tolerance = tolerance * f64::from(reach.fold(0.0, f32::max));
        let along = |axis: usize| lines(positions.iter().map(|position| position[axis]), tolerance);
        Lines {
            columns: along(0),
            rows: along(2),
        }
    }

    /// Returns the index of a position's grid point, row by row.
    pub(super) fn place_of(&self, [x, _, z]: [f32; 3]) -> u64 {
        let last = |lines: &[f32], at: f32| lines.partition_point(|&line| line <= at) as u64 - 1;
        last(&self.rows, z) * self.columns.len() as u64 + last(&self.columns, x)
    }

    /// Returns the number of grid points.
    pub(super) fn places(&self) -> u64 {
        self.columns.len() as u64 * self.rows.len() as u64
    }

    /// Returns the column and row of a grid point.
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

/// Returns the minimum of each run of numbers that are within a tolerance of it.
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
