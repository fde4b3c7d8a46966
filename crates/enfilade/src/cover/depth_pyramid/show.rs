//! Draws the pyramid by its largest cells that are nearly as precise as the tiles below them.

use super::Depths;
use super::tiles::TILE_SHIFT;
use crate::cover::show::{push, show_rows};
use crate::view::canvas::{Canvas, CoverSpan, HiddenBy};
use crate::view::passage::Passage;

/// Maximum ratio of the nearest tile's reversed depth to that of the cell, for the cell to be drawn as a whole.
const NEARLY: f32 = 1.15;

/// The number of cells drawn so far, and for each tile the number and the farthest reversed depth of its cell.
struct ShownCells {
    cells: u32,
    of_tiles: Vec<(u32, f32)>,
}

impl Depths {
    pub(super) fn show(&mut self, passage: &Passage, canvas: &mut dyn Canvas) {
        let mut shown = ShownCells {
            cells: 0,
            of_tiles: vec![(0, 0.0); self.tiles.columns * self.tiles.rows],
        };
        self.show_cell(self.height, 0, 0, &mut shown);
        let tiles = &self.tiles;
        show_rows(passage, canvas, |y, [x0, x1], spans| {
            let row = usize::from(y) >> TILE_SHIFT;
            for x in x0..x1 {
                let column = usize::from(x) >> TILE_SHIFT;
                let (cell, farthest) = shown.of_tiles[row * tiles.columns + column];
                let by = match tiles.owner(column, row) {
                    Some(face) => HiddenBy::One(face),
                    None if farthest > 0.0 => HiddenBy::Several,
                    None => HiddenBy::Nothing,
                };
                push(
                    spans,
                    CoverSpan {
                        x0: x,
                        x1: x + 1,
                        cell,
                        by,
                        rev_depth: [farthest; 2],
                    },
                );
            }
        });
    }

    /// Draws a cell, or the four below it.
    fn show_cell(&mut self, level: usize, column: usize, row: usize, shown: &mut ShownCells) {
        let [columns, rows] = [self.tiles.columns, self.tiles.rows];
        let side = 1 << level;
        let across = column * side..((column + 1) * side).min(columns);
        let down = row * side..((row + 1) * side).min(rows);
        let [mut farthest, mut nearest] = [f32::INFINITY, 0.0_f32];
        for row in down.clone() {
            for column in across.clone() {
                let known = f32::from_bits(self.tiles.farthest(column, row));
                // Tiles outside the aperture's rectangle are NaN, which `min` and `max` ignore.
                farthest = farthest.min(known);
                nearest = nearest.max(known);
            }
        }
        if level > 0 && nearest > NEARLY * farthest {
            for [right, below] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                self.show_cell(level - 1, 2 * column + right, 2 * row + below, shown);
            }
            return;
        }
        shown.cells += 1;
        for row in down {
            for column in across.clone() {
                shown.of_tiles[row * columns + column] = (shown.cells, farthest);
            }
        }
    }
}
