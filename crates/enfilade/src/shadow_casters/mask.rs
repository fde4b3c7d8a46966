//! The receiver mask of a light's view: for each cell of a grid, the distance of the farthest receiver.
//!
//! Source: Bittner, Mattausch, Silvennoinen, Wimmer, Shadow Caster Culling for Efficient Shadow Mapping, I3D 2011.

use crate::view::aperture::Rect;

/// Maximum number of columns and rows.
const CELLS: u32 = 128;

/// Distances of the farthest receivers; negative infinity in a cell without any.
#[derive(Default)]
pub(super) struct ReceiverMask {
    columns: usize,
    /// Pixels per cell, by axis.
    cell: [u32; 2],
    farthest: Vec<f64>,
}

impl ReceiverMask {
    /// Clears the mask for a viewport of `size` pixels.
    pub(super) fn clear(&mut self, size: [u32; 2]) {
        self.cell = size.map(|side| side.div_ceil(CELLS));
        let [columns, rows] = [0, 1].map(|axis| size[axis].div_ceil(self.cell[axis]) as usize);
        self.columns = columns;
        self.farthest.clear();
        self.farthest.resize(columns * rows, f64::NEG_INFINITY);
    }

    /// Adds a receiver within a rectangle of pixels, up to a distance.
    pub(super) fn add(&mut self, rect: &Rect, distance: f64) {
        for row in self.rows(rect) {
            for cell in &mut self.farthest[row] {
                *cell = cell.max(distance);
            }
        }
    }

    /// Whether something at a distance, within a rectangle of pixels, is before any receiver.
    pub(super) fn is_before_any(&self, rect: &Rect, distance: f64) -> bool {
        let mut rows = self.rows(rect);
        rows.any(|row| self.farthest[row].iter().any(|&cell| cell >= distance))
    }

    /// Iterates over the cells that a rectangle of pixels touches, row by row.
    fn rows(&self, rect: &Rect) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let first = [rect.x0, rect.y0];
        let end = [rect.x1, rect.y1];
        let first = [0, 1].map(|axis| u32::from(first[axis]) / self.cell[axis]);
        let end = [0, 1].map(|axis| u32::from(end[axis]).div_ceil(self.cell[axis]));
        let columns = self.columns;
        (first[1]..end[1]).map(move |row| {
            let start = row as usize * columns;
            start + first[0] as usize..start + end[0].max(first[0]) as usize
        })
    }
}
